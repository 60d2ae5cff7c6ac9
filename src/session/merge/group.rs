//! The files of a render's shards, held against each other.

use super::MergeError;
use crate::budget::{Budget, Bytes};
use crate::checkpoint::{Contents, Facts, Identity, Shard, Unit, restored};
use crate::film::{Splats, Tile};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Memory of the index of a piece of work: its name and place, and what a hash table takes besides.
const BYTES_OF_UNIT: u64 = 72;

/// So many files are open at once: fewer than any system allows.
const OPEN: usize = 64;

/// Shards of one render, by their numbers.
pub(super) struct Group {
    pub facts: Facts,
    /// Counts after each pass but the first, of the shard that knows of most.
    pub planned: Vec<[Vec<u32>; 2]>,
    shards: BTreeMap<u32, One>,
    open: BTreeMap<u32, File>,
}

struct One {
    path: PathBuf,
    contents: Contents,
}

impl Group {
    /// Reads all of them.
    ///
    /// # Errors
    /// A file that is not a shard's; shards of different renders; two of the same number.
    pub(super) fn read(paths: &[PathBuf], budget: &Budget) -> Result<Group, MergeError> {
        let mut shards = BTreeMap::new();
        for path in paths {
            let (facts, one) = read(path)?;
            let index = one.contents.units() as u64 * BYTES_OF_UNIT;
            budget.take(index).map_err(MergeError::Memory)?;
            let key = (facts.shard.of, facts.shard.number);
            if let Some((_, first)) = shards.get::<(u32, u32)>(&key) {
                let first: &One = first;
                return Err(MergeError::Doubled {
                    shard: facts.shard,
                    paths: [first.path.clone(), path.clone()],
                });
            }
            shards.insert(key, (facts, one));
        }
        let (facts, first) = shards.first_key_value().ok_or(MergeError::Nothing)?.1;
        for (other, one) in shards.values().skip(1) {
            let mut unlike = Vec::new();
            if other.shard.of != facts.shard.of {
                unlike.push(format!("the shards ({}, {})", facts.shard, other.shard));
            }
            let [a, b] = [first, one].map(|one| one.contents.identity.of_all_shards());
            unlike.extend(a.unlike(&b));
            let mut same = other.clone();
            same.shard = facts.shard;
            if unlike.is_empty() && same != *facts {
                unlike.push("what they say of the image".to_string());
            }
            if !unlike.is_empty() {
                let paths = [first.path.clone(), one.path.clone()];
                return Err(MergeError::Mixture { paths, unlike });
            }
        }
        let facts = facts.clone();
        let mut shards: BTreeMap<u32, One> = { shards.into_iter() }
            .map(|((_, number), (_, one))| (number, one))
            .collect();
        let planned = planned(&shards)?;
        // All the same: one copy is enough.
        shards
            .values_mut()
            .for_each(|one| one.contents.plans.clear());
        Ok(Group {
            planned,
            facts,
            shards,
            open: BTreeMap::new(),
        })
    }

    /// What is not there, in words.
    pub(super) fn missing(&self) -> Vec<String> {
        let passes = self.planned.len() as u32 + 1;
        let of_number = |number: u32| {
            let shard = format!("{number}/{}", self.facts.shard.of);
            let Some(one) = self.shards.get(&number) else {
                return Some(format!("shard {shard} is missing"));
            };
            let path = one.path.display();
            match one.contents.passes_done {
                Some(done) if done >= passes => None,
                Some(done) => Some(format!(
                    "{path}: shard {shard} has finished {done} of {passes} passes"
                )),
                None => Some(match one.contents.lost {
                    0 => format!("{path}: shard {shard} is not finished"),
                    lost => format!(
                        "{path}: shard {shard} is not finished: the last {} of the file were cut off or are damaged; render it again",
                        Bytes(lost)
                    ),
                }),
            }
        };
        (1..=self.facts.shard.of).filter_map(of_number).collect()
    }

    /// The samples of a unit of a pass, from 1, that a shard has: subtrees from left to right. Nothing if it has none.
    ///
    /// # Errors
    /// A record that is damaged.
    pub(super) fn tiles(
        &mut self,
        (shard, pass): (u32, u32),
        unit: &Unit,
        blank: impl Fn() -> Tile,
    ) -> Result<Vec<Tile>, MergeError> {
        let Some(one) = self.shards.get(&shard) else {
            return Ok(Vec::new());
        };
        let damaged = || MergeError::Damaged(one.path.clone());
        let is_finished = one.contents.passes_done.is_some_and(|done| done >= pass);
        if is_finished && !one.contents.has_whole(unit) {
            return Err(damaged());
        }
        if !one.contents.has(unit) {
            return Ok(Vec::new());
        }
        if !self.open.contains_key(&shard) {
            if self.open.len() >= OPEN {
                self.open.clear();
            }
            self.open.insert(shard, open(&one.path)?);
        }
        let file = self.open.get_mut(&shard).ok_or_else(damaged)?;
        let body = one.contents.bytes(unit, file);
        let body = body
            .map_err(|source| unreadable(&one.path, source))?
            .ok_or_else(damaged)?;
        let (_, tiles) = restored(unit, &body, blank).ok_or_else(damaged)?;
        Ok(tiles)
    }

    /// Adds what the shards' light paths have brought in one half to `splats`. A shard that has finished some passes has at
    /// least the paths in `wanted` of its number.
    ///
    /// # Errors
    /// Sums that are damaged, or not there.
    pub(super) fn add_splats(
        &self,
        half: u8,
        wanted: impl Fn(Shard) -> Vec<Vec<Range<u64>>>,
        splats: &mut Splats,
    ) -> Result<(), MergeError> {
        for (number, one) in &self.shards {
            let damaged = || MergeError::Damaged(one.path.clone());
            let mut file = open(&one.path)?;
            let added = one.contents.add_splats(half, &mut file, splats);
            added
                .map_err(|source| unreadable(&one.path, source))?
                .ok_or_else(damaged)?;
            let shard = Shard {
                number: *number,
                ..self.facts.shard
            };
            let passes = one.contents.passes_done.unwrap_or_default() as usize;
            let mut finished = wanted(shard).into_iter().take(passes).flatten();
            let paths = splats.paths();
            if !finished.all(|range| paths.missing(range).is_empty()) {
                return Err(damaged());
            }
        }
        Ok(())
    }

    /// What the render is, regardless of shards.
    pub(super) fn identity(&self) -> Identity {
        let first = self.shards.first_key_value();
        first.map_or_else(Default::default, |(_, one)| {
            one.contents.identity.of_all_shards()
        })
    }
}

/// The longest plan that a shard has followed; the others' must be its beginning.
fn planned(shards: &BTreeMap<u32, One>) -> Result<Vec<[Vec<u32>; 2]>, MergeError> {
    let of = |one: &One| -> Vec<[Vec<u32>; 2]> {
        let plans = (1..).map_while(|pass| one.contents.plans.get(&pass).cloned());
        plans.collect()
    };
    let mut longest: (Vec<[Vec<u32>; 2]>, Option<&One>) = (Vec::new(), None);
    for one in shards.values() {
        let plans = of(one);
        let common = plans.len().min(longest.0.len());
        if plans[..common] != longest.0[..common] {
            let first = longest.1.map_or_else(PathBuf::new, |one| one.path.clone());
            return Err(MergeError::Mixture {
                paths: [first, one.path.clone()],
                unlike: vec![
                    "their plans: remove the files of one, and render it again".to_string(),
                ],
            });
        }
        if plans.len() > longest.0.len() || longest.1.is_none() {
            longest = (plans, Some(one));
        }
    }
    Ok(longest.0)
}

fn open(path: &Path) -> Result<File, MergeError> {
    if path.exists() && !path.is_file() {
        return Err(foreign(path, "no regular file"));
    }
    File::open(path).map_err(|source| unreadable(path, source))
}

fn foreign(path: &Path, why: &'static str) -> MergeError {
    let path = path.to_owned();
    MergeError::Foreign { path, why }
}

fn unreadable(path: &Path, source: io::Error) -> MergeError {
    let path = path.to_owned();
    MergeError::Unreadable { path, source }
}

fn read(path: &Path) -> Result<(Facts, One), MergeError> {
    let contents = Contents::read(BufReader::new(open(path)?));
    let contents = contents.map_err(|source| unreadable(path, source))?;
    let contents =
        contents.ok_or_else(|| foreign(path, "no checkpoint of this version of fstop"))?;
    let whole = "the checkpoint of a whole render: the command that made it continues it";
    let facts = contents.facts.clone().ok_or_else(|| foreign(path, whole))?;
    if facts.film.spec().check().is_err() || !facts.shard.is_valid() {
        return Err(foreign(
            path,
            "a shard that says impossible things of its image",
        ));
    }
    let path = path.to_owned();
    Ok((facts, One { path, contents }))
}
