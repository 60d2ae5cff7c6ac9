//! The records of a checkpoint: each with its length before and a checksum (CRC-32) behind it.
//!
//! Numbers are little-endian. What follows the last whole record, cut off by a full disk or a killed process, counts as
//! not written.

use crate::film::Tile;
use std::ops::Range;

/// A piece of a render's work: some samples of all pixels of a tile.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Unit {
    /// Which of two independent images (see [`crate::render`]); 0 if there is one.
    pub half: u8,
    /// Number of the tile.
    pub tile: u32,
    /// Indices of the samples.
    pub samples: Range<u32>,
}

/// What a record says.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Record {
    /// The samples before `done` of a unit are in the tiles that follow: subtrees from left to right.
    Work {
        /// Which.
        unit: Unit,
        /// Index after the last sample.
        done: u32,
    },
    /// The sample counts of both halves' tiles after a pass that was planned by the clock.
    Plan {
        /// Number of the pass.
        pass: u32,
        /// Counts of each half.
        counts: [Vec<u32>; 2],
    },
    /// Milliseconds of rendering so far.
    Spent(u64),
    /// A shard has all of these passes.
    Done {
        /// How many.
        passes: u32,
    },
    /// A part of all sums of splats so far follows; all of them, one after the other, take the place of earlier ones.
    Splats {
        /// As in [`Unit`].
        half: u8,
        /// Which, from 0.
        part: u32,
        /// How many there are.
        parts: u32,
    },
    /// A tile of photon mapping follows, after so many iterations; all of them, one after the other, take the place of earlier
    /// ones.
    Iterated {
        /// How many.
        done: u32,
        /// Which tile, from 0.
        part: u32,
        /// How many there are.
        parts: u32,
    },
}

/// Before and behind each record.
pub(super) const FRAME: usize = 8;

/// Frames a record.
pub(super) fn framed(body: &[u8]) -> Vec<u8> {
    let length = (body.len() as u32).to_le_bytes();
    let mut out = Vec::with_capacity(body.len() + FRAME);
    out.extend(length);
    out.extend(body);
    out.extend(crc32(&[&length, body]).to_le_bytes());
    out
}

/// CRC-32 of IEEE 802.3, as gzip has it.
pub(super) fn crc32(parts: &[&[u8]]) -> u32 {
    let mut crc = flate2::Crc::new();
    parts.iter().for_each(|part| crc.update(part));
    crc.sum()
}

impl Record {
    /// The record's bytes, followed by those of `tiles`.
    pub(super) fn store(&self, tiles: &[Tile]) -> Vec<u8> {
        let mut out = Vec::new();
        match self {
            Record::Work { unit, done } => {
                out.push(1);
                out.push(unit.half);
                for number in [unit.tile, unit.samples.start, unit.samples.end, *done] {
                    out.extend(number.to_le_bytes());
                }
                out.push(tiles.len() as u8);
                tiles.iter().for_each(|tile| tile.store(&mut out));
            }
            Record::Plan { pass, counts } => {
                out.push(2);
                out.extend(pass.to_le_bytes());
                out.extend((counts[0].len() as u32).to_le_bytes());
                for count in counts.iter().flatten() {
                    out.extend(count.to_le_bytes());
                }
            }
            Record::Spent(milliseconds) => {
                out.push(3);
                out.extend(milliseconds.to_le_bytes());
            }
            Record::Done { passes } => {
                out.push(4);
                out.extend(passes.to_le_bytes());
            }
            Record::Splats { half, part, parts } => {
                out.push(5);
                out.push(*half);
                out.extend(part.to_le_bytes());
                out.extend(parts.to_le_bytes());
            }
            Record::Iterated { done, part, parts } => {
                out.push(6);
                for number in [done, part, parts] {
                    out.extend(number.to_le_bytes());
                }
            }
        }
        out
    }

    /// Reads a record and leaves its tiles in `bytes`, after their number where there may be several, or its sums.
    pub(super) fn read(bytes: &mut &[u8]) -> Option<Record> {
        Some(match u8::from_le_bytes(take(bytes)?) {
            1 => {
                let half = u8::from_le_bytes(take(bytes)?);
                let mut number = || Some(u32::from_le_bytes(take(bytes)?));
                let (tile, samples) = (number()?, number()?..number()?);
                let unit = Unit {
                    half,
                    tile,
                    samples,
                };
                let done = number()?;
                Record::Work { unit, done }
            }
            2 => {
                let mut number = || Some(u32::from_le_bytes(take(bytes)?));
                let (pass, length) = (number()?, number()? as usize);
                let counts = bytes.chunks_exact(4).map(|mut four| take(&mut four));
                let counts: Vec<u32> = counts.map_while(|c| c.map(u32::from_le_bytes)).collect();
                let (a, b) = counts.split_at_checked(length)?;
                let counts = [a.to_vec(), b.to_vec()];
                (counts[1].len() == length).then_some(Record::Plan { pass, counts })?
            }
            3 => Record::Spent(u64::from_le_bytes(take(bytes)?)),
            4 => {
                let passes = u32::from_le_bytes(take(bytes)?);
                Record::Done { passes }
            }
            5 => {
                let half = u8::from_le_bytes(take(bytes)?);
                let mut number = || Some(u32::from_le_bytes(take(bytes)?));
                let (part, parts) = (number()?, number()?);
                Record::Splats { half, part, parts }
            }
            6 => {
                let mut number = || Some(u32::from_le_bytes(take(bytes)?));
                let (done, part, parts) = (number()?, number()?, number()?);
                Record::Iterated { done, part, parts }
            }
            _ => return None,
        })
    }
}

/// The tiles behind a record of work; `blank` makes an empty one.
pub(super) fn read_tiles(bytes: &mut &[u8], blank: impl Fn() -> Tile) -> Option<Vec<Tile>> {
    let count = u8::from_le_bytes(take(bytes)?);
    (0..count).map(|_| blank().restored(bytes)).collect()
}

/// The next `N` bytes.
pub(super) fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (first, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(*first)
}
