//! What is in a checkpoint's file.

use super::record::{self, Record, Unit};
use super::{Facts, Header, Identity, LONGEST, MAGIC};
use crate::film::{Splats, Tile};
use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::time::Duration;

/// Which records a checkpoint has, and where.
#[derive(Debug, Default)]
pub struct Contents {
    /// What it is of.
    pub identity: Identity,
    /// Of a shard: what is known of the image.
    pub facts: Option<Facts>,
    /// The passes of which a shard has everything.
    pub passes_done: Option<u32>,
    /// Counts after a pass, by its number.
    pub plans: HashMap<u32, [Vec<u32>; 2]>,
    /// Time of rendering.
    pub spent: Duration,
    /// The latest record of each unit.
    units: HashMap<Unit, Place>,
    /// The sums of splats of each half.
    splats: HashMap<u8, Parts>,
    /// The tiles of photon mapping.
    iterated: Parts,
    /// Where the last whole record ends.
    pub(super) end: u64,
    /// Bytes after that, of a record that was cut off or is damaged, and of all that follow.
    pub lost: u64,
}

/// Where a record is in the file, and how far it got with its unit.
#[derive(Clone, Copy, Debug)]
struct Place {
    start: u64,
    length: usize,
    done: u32,
}

/// Records that belong together.
#[derive(Debug, Default)]
struct Parts {
    /// The latest of which there are all.
    whole: Vec<Place>,
    /// Those of which some are still to come.
    some: Vec<Place>,
}

impl Parts {
    fn add(&mut self, place: Place, part: u32, parts: u32) {
        if self.some.len() != part as usize {
            self.some.clear();
        }
        if self.some.len() == part as usize {
            self.some.push(place);
        }
        if self.some.len() == parts as usize {
            self.whole = std::mem::take(&mut self.some);
        }
    }
}

impl Place {
    fn bytes(&self, file: &mut File) -> io::Result<Vec<u8>> {
        let mut body = vec![0; self.length];
        file.seek(SeekFrom::Start(self.start))?;
        file.read_exact(&mut body)?;
        Ok(body)
    }
}

impl Contents {
    /// Reads every whole record; `None` if the file is not a checkpoint.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn read(mut file: BufReader<File>) -> io::Result<Option<Contents>> {
        let mut magic = [0; MAGIC.len()];
        if let Err(error) = file.read_exact(&mut magic) {
            return end_or(error).map(|_| None);
        }
        if magic != MAGIC {
            return Ok(None);
        }
        let Some(body) = next(&mut file)? else {
            return Ok(None);
        };
        let Ok(Header { identity, image }) = serde_json::from_slice(&body) else {
            return Ok(None);
        };
        let mut contents = Contents {
            identity,
            facts: image,
            end: (MAGIC.len() + body.len() + record::FRAME) as u64,
            ..Contents::default()
        };
        while let Some(body) = next(&mut file)? {
            if !contents.add(&body) {
                break;
            }
            contents.end += (body.len() + record::FRAME) as u64;
        }
        contents.lost = { file.get_ref().metadata()?.len() }.saturating_sub(contents.end);
        Ok(Some(contents))
    }

    /// Adds the record after the last; `false` if it is none.
    fn add(&mut self, body: &[u8]) -> bool {
        let place = Place {
            start: self.end + 4,
            length: body.len(),
            done: 0,
        };
        match Record::read(&mut &body[..]) {
            Some(Record::Work { unit, done }) => {
                let place = Place { done, ..place };
                if done > unit.samples.start {
                    self.units.insert(unit, place);
                }
            }
            Some(Record::Plan { pass, counts }) => drop(self.plans.insert(pass, counts)),
            Some(Record::Spent(milliseconds)) => self.spent = Duration::from_millis(milliseconds),
            Some(Record::Done { passes }) => self.passes_done = Some(passes),
            Some(Record::Splats { half, part, parts }) => {
                self.splats.entry(half).or_default().add(place, part, parts);
            }
            Some(Record::Iterated { part, parts, .. }) => self.iterated.add(place, part, parts),
            None => return false,
        }
        true
    }

    /// Returns `true` if there is any work in it.
    pub fn holds_work(&self) -> bool {
        let mut splats = self.splats.values();
        !self.units.is_empty()
            || splats.any(|parts| !parts.whole.is_empty())
            || !self.iterated.whole.is_empty()
    }

    /// Returns `true` if it has samples of the unit.
    pub fn has(&self, unit: &Unit) -> bool {
        self.units.contains_key(unit)
    }

    /// Returns `true` if it has all samples of the unit.
    pub fn has_whole(&self, unit: &Unit) -> bool {
        let place = self.units.get(unit);
        place.is_some_and(|place| place.done == unit.samples.end)
    }

    /// The bytes of a unit's record in `file`, if there is one.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn bytes(&self, unit: &Unit, file: &mut File) -> io::Result<Option<Vec<u8>>> {
        let place = self.units.get(unit);
        place.map(|place| place.bytes(file)).transpose()
    }

    /// Adds the sums of splats of a half to `splats`, if there are any. `None` if they cannot be added to them; then
    /// `splats` are useless.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn add_splats(
        &self,
        half: u8,
        file: &mut File,
        splats: &mut Splats,
    ) -> io::Result<Option<()>> {
        let places = { self.splats.get(&half) }.map_or(&[][..], |parts| &parts.whole);
        if !places.is_empty() && places.len() != splats.parts() as usize {
            return Ok(None);
        }
        for (part, place) in (0..).zip(places) {
            let body = place.bytes(file)?;
            let mut bytes = &body[..];
            let is_it = matches!(Record::read(&mut bytes), Some(Record::Splats { .. }));
            if !is_it || !splats.add_stored(part, bytes) {
                return Ok(None);
            }
        }
        Ok(Some(()))
    }

    /// Number of tiles of photon mapping.
    pub fn iterated_tiles(&self) -> usize {
        self.iterated.whole.len()
    }

    /// The iterations that a tile of photon mapping has, and the bytes of what it holds; `None` if there is no such tile.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn iterated(&self, tile: usize, file: &mut File) -> io::Result<Option<(u32, Vec<u8>)>> {
        let Some(place) = self.iterated.whole.get(tile) else {
            return Ok(None);
        };
        let mut body = place.bytes(file)?;
        let mut rest = &body[..];
        let Some(Record::Iterated { done, .. }) = Record::read(&mut rest) else {
            return Ok(None);
        };
        let start = body.len() - rest.len();
        Ok(Some((done, body.split_off(start))))
    }

    /// Number of units.
    pub fn units(&self) -> usize {
        self.units.len()
    }
}

/// What the record of a unit holds: the index after the last sample, and the subtrees before it. `None` if the numbers
/// of samples are not those of the unit: then the file is damaged, or was made to deceive.
pub fn restored(unit: &Unit, body: &[u8], blank: impl Fn() -> Tile) -> Option<(u32, Vec<Tile>)> {
    let mut bytes = body;
    let Some(Record::Work { done, .. }) = Record::read(&mut bytes) else {
        return None;
    };
    let samples = &unit.samples;
    (samples.start..=samples.end)
        .contains(&done)
        .then_some(())?;
    let tiles = record::read_tiles(&mut bytes, &blank)?;
    let pixels = blank().bounds();
    let count_of = |pixel| -> u64 {
        let counts = tiles.iter().filter_map(|tile| tile.statistics(pixel));
        counts
            .map(|found| found.count())
            .fold(0, u64::saturating_add)
    };
    let expected = u64::from(done - samples.start);
    let is_whole = bytes.is_empty() && pixels.pixels().all(|pixel| count_of(pixel) == expected);
    is_whole.then_some((done, tiles))
}

/// The next record's bytes; `None` at the end, or where one is cut off or damaged.
fn next(file: &mut BufReader<File>) -> io::Result<Option<Vec<u8>>> {
    let mut length = [0; 4];
    if let Err(error) = file.read_exact(&mut length) {
        return end_or(error);
    }
    let count = u32::from_le_bytes(length);
    if count > LONGEST {
        return Ok(None);
    }
    let mut body = Vec::new();
    file.by_ref().take(count.into()).read_to_end(&mut body)?;
    let mut crc = [0; 4];
    if let Err(error) = file.read_exact(&mut crc) {
        return end_or(error);
    }
    let good = u32::from_le_bytes(crc) == record::crc32(&[&length, &body]);
    Ok(good.then_some(body))
}

fn end_or(error: io::Error) -> io::Result<Option<Vec<u8>>> {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => Ok(None),
        _ => Err(error),
    }
}
