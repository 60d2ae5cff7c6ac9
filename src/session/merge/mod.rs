//! Merging shards: from the sums in their files to the image that one process would have made, bit for bit.
//!
//! One piece is in memory at a time, besides the film: however many shards there are.

mod group;

use super::DroppedSamples;
use super::rendered::{Finished, Rendered};
use super::shards::counts;
use crate::budget::{Budget, Bytes, OverBudget};
use crate::checkpoint::{Plan, Shard};
use crate::film::{
    Film, FilmSpec, Kept, LightShare, MEMORY_OF_SPLATS, Pairwise, PixelBounds, PixelStatistics,
    Splats, Tile,
};
use crate::render::{self, Division, Ended, Goal, Halves, Pass, TILE_SIZE};
use group::Group;
use std::io;
use std::path::PathBuf;

/// Of each pixel: values and variances, pooled and not.
const BYTES_OF_IMAGE: u64 = 9 * 4;

/// Why shards cannot be merged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// No files.
    #[error("there are no shards to merge")]
    Nothing,
    /// It is something else.
    #[error("{}: this is {why}", .path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What it is.
        why: &'static str,
    },
    /// It cannot be read.
    #[error("{}: cannot read: {source}", .path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The operating system's error.
        source: io::Error,
    },
    /// A record's checksum is right, but its contents are not.
    #[error("{}: this file is damaged: remove it, and render the shard again", .0.display())]
    Damaged(PathBuf),
    /// Two files of the same shard.
    #[error("{} and {}: both are shard {shard}", .paths[0].display(), .paths[1].display())]
    Doubled {
        /// Which.
        shard: Shard,
        /// The files.
        paths: [PathBuf; 2],
    },
    /// Files of different renders.
    #[error("{} and {}: these are shards of different renders, which differ in {}", .paths[0].display(), .paths[1].display(), .unlike.join(", "))]
    Mixture {
        /// The files.
        paths: [PathBuf; 2],
        /// What is different.
        unlike: Vec<String>,
    },
    /// Shards that are not there or not finished.
    #[error("{}", some(.0))]
    Missing(Vec<String>),
    /// The image is too large for this machine.
    #[error("the image takes {} of memory more, and this machine has {}: merge on a larger one", Bytes(.0.needed), Bytes(.0.left))]
    Memory(OverBudget),
    /// The plan that the shards have followed is none for their image.
    #[error(
        "the passes that the shards have followed are none of their image: remove their files, and begin anew"
    )]
    Passes,
}

impl MergeError {
    /// Returns `true` if they might be read on another machine or later.
    pub fn is_failure(&self) -> bool {
        match self {
            MergeError::Unreadable { source, .. } => source.kind() != io::ErrorKind::NotFound,
            MergeError::Memory(_) => true,
            _ => false,
        }
    }
}

/// Lines, but not thousands of them.
fn some(all: &[String]) -> String {
    const MOST: usize = 20;
    let mut lines: Vec<String> = all.iter().take(MOST).cloned().collect();
    if all.len() > MOST {
        lines.push(format!("and {} more", all.len() - MOST));
    }
    lines.join("\n")
}

/// What comes of shards.
pub enum Merged {
    /// The image.
    Image {
        /// It.
        image: Box<Rendered>,
        /// With an error for a goal: what the shards have done, which they find finished.
        plan: Option<Plan>,
    },
    /// Its error is larger than the goal: what all shards do next.
    Plan {
        /// For `--plan`.
        plan: Plan,
        /// Estimated relative error so far, if it is known.
        error: Option<f64>,
        /// The goal.
        goal: f64,
    },
}

/// Merges the files of all shards of a render, in any order; with `allow_missing` those that there are. With
/// `variance`, the image has the variance of each pixel's mean.
///
/// # Errors
/// See [`MergeError`].
pub fn merge(paths: &[PathBuf], allow_missing: bool, variance: bool) -> Result<Merged, MergeError> {
    let budget = Budget::new(None);
    let mut group = Group::read(paths, &budget)?;
    let missing = group.missing();
    if !missing.is_empty() && !allow_missing {
        return Err(MergeError::Missing(missing));
    }
    let is_whole = missing.is_empty();
    let [min, max] = group.facts.sampled;
    let spec = group.facts.film.spec();
    let sampled = spec.pixel_bounds().intersection(PixelBounds::new(min, max));
    let in_halves = group.facts.goal.is_some() || group.facts.halved;
    let films = if in_halves { 3 } else { 1 };
    let splats = group
        .facts
        .splats
        .map_or(0, |_| MEMORY_OF_SPLATS * films.min(2))
        * (1 + spec.layers.lights() as u64);
    let layers = spec.layers.memory_of_sums() * films + spec.layers.memory_of_image();
    let bytes = films * size_of::<PixelStatistics>() as u64 + splats + layers + BYTES_OF_IMAGE;
    let room = budget.take(spec.pixel_bounds().area() as u64 * bytes);
    room.map_err(MergeError::Memory)?;
    let finished = match group.facts.goal {
        None => of_samples(&mut group, &spec, sampled)?,
        Some(facts) => {
            let goal = Goal {
                error: Some(facts.error),
                confidence: facts.confidence,
                time: None,
                max_spp: facts.max_spp,
            };
            match of_passes(&mut group, &spec, sampled, &goal, is_whole)? {
                Ok(finished) => finished,
                Err((plan, error)) => {
                    let goal = facts.error;
                    return Ok(Merged::Plan { plan, error, goal });
                }
            }
        }
    };
    let first_dropped = finished.film.first_dropped();
    let first_dropped = first_dropped.map(|first| (first, "somewhere on its path".to_string()));
    let dropped = DroppedSamples::of(&finished.film, first_dropped);
    let metadata = group.facts.metadata.clone();
    let image = Box::new(finished.develop(metadata, variance, dropped, 0));
    let plan = { group.facts.goal.filter(|_| is_whole) }.map(|_| Plan {
        of: group.identity(),
        passes: group.planned,
    });
    Ok(Merged::Image { image, plan })
}

/// An image with the same number of samples everywhere.
fn of_samples(
    group: &mut Group,
    spec: &FilmSpec,
    sampled: PixelBounds,
) -> Result<Finished, MergeError> {
    let spp = group.facts.spp;
    let division = Division::new(sampled, Some(spp), group.facts.shard.of);
    let mut film = Film::new(spec);
    if group.facts.halved {
        return of_halves(group, spec, sampled, &division);
    }
    let pass = division.whole(&[spp]);
    add(group, &division, (1, &pass), spec, |_, tile| {
        film.merge(tile)
    })?;
    let (samples, all) = (film.samples(), sampled.area() as u64 * u64::from(spp));
    let mut has_paths = true;
    if let Some((scale, share)) = group.facts.splats {
        let mut splats = Splats::new(sampled, scale, spec.layers.lights());
        let how = (share, group.facts.are_paired);
        let of_shard = |shard| vec![division.light(shard, (0, &pass), how)];
        group.add_splats(0, of_shard, &mut splats)?;
        has_paths = splats.paths().count() >= share.paths(all);
        film.add_light(&[splats]);
    }
    Ok(Finished {
        spp: samples as f64 / sampled.area().max(1) as f64,
        error: None,
        bound: None,
        passes: None,
        stopped: samples < all || !has_paths,
        film: film.developed(Kept::Variance),
    })
}

/// The same in two halves.
fn of_halves(
    group: &mut Group,
    spec: &FilmSpec,
    sampled: PixelBounds,
    division: &Division,
) -> Result<Finished, MergeError> {
    let pass = division.whole(&counts(group.facts.spp, true));
    let halves = halves_of(group, spec, sampled, division, std::slice::from_ref(&pass))?;
    let film = halves.developed(|_| ());
    let of_half = |spp| sampled.area() as u64 * u64::from(spp);
    let of_halves = counts(group.facts.spp, true).into_iter().map(of_half);
    let (samples, all) = (film.samples(), of_halves.clone().sum::<u64>());
    let lacks_paths = group.facts.splats.is_some_and(|(_, share)| {
        film.paths() < of_halves.map(|samples| share.paths(samples)).sum()
    });
    Ok(Finished {
        spp: samples as f64 / sampled.area().max(1) as f64,
        error: None,
        bound: None,
        passes: None,
        stopped: samples < all || lacks_paths,
        film,
    })
}

/// Both halves with what the shards have of the passes.
fn halves_of(
    group: &mut Group,
    spec: &FilmSpec,
    sampled: PixelBounds,
    division: &Division,
    passes: &[Pass],
) -> Result<Halves, MergeError> {
    let (scale, share) = group.facts.splats.unzip();
    let splats = scale.map(|scale| Splats::new(sampled, scale, spec.layers.lights()));
    let splats = splats.map(|splats| [splats.clone(), splats]);
    let are_dependent = group.facts.are_dependent;
    let mut halves = Halves::new(spec, sampled, TILE_SIZE, splats, are_dependent);
    for (number, pass) in (1..).zip(passes) {
        add(group, division, (number, pass), spec, |half, tile| {
            halves.merge(half, tile)
        })?;
        for (half, tiles) in pass.iter().enumerate() {
            for (tile, samples) in tiles.iter().enumerate() {
                halves.reach(half, tile, samples.end);
            }
        }
    }
    let how = (share.unwrap_or(LightShare(1.0)), group.facts.are_paired);
    for half in [0, 1] {
        let of_pass = |shard, pass| division.light(shard, (half, pass), how);
        let of_shard = |shard| passes.iter().map(|pass| of_pass(shard, pass)).collect();
        if let Some(splats) = halves.splats(half) {
            group.add_splats(half as u8, of_shard, splats)?;
        }
    }
    Ok(halves)
}

/// An adaptive image as far as its passes go, or what comes next.
fn of_passes(
    group: &mut Group,
    spec: &FilmSpec,
    sampled: PixelBounds,
    goal: &Goal,
    is_whole: bool,
) -> Result<Result<Finished, (Plan, Option<f64>)>, MergeError> {
    let division = Division::new(sampled, None, group.facts.shard.of);
    let passes = render::passes(sampled, goal, &group.planned).ok_or(MergeError::Passes)?;
    let halves = halves_of(group, spec, sampled, &division, &passes)?;
    let error = { halves.judged(goal, passes.len() as u32) }.filter(|_| is_whole);
    let ended = halves.reached(goal, error);
    if ended.is_none() && is_whole {
        let mut passes = group.planned.clone();
        passes.push(halves.plan(goal, error, None));
        let of = group.identity();
        return Ok(Err((Plan { of, passes }, error)));
    }
    let film = halves.developed(|_| ());
    let spp = match is_whole {
        true => halves.spp(),
        false => film.samples() as f64 / sampled.area().max(1) as f64,
    };
    Ok(Ok(Finished {
        film,
        spp,
        error: halves.error().filter(|_| is_whole),
        bound: error.filter(|_| goal.confidence.is_some()),
        passes: Some((passes.len() as u32, ended.unwrap_or(Ended::Stopped))),
        stopped: !is_whole,
    }))
}

/// Hands the cells of a pass, each with all its samples, to `take` with their half.
fn add(
    group: &mut Group,
    division: &Division,
    (number, pass): (u32, &Pass),
    spec: &FilmSpec,
    mut take: impl FnMut(usize, Tile),
) -> Result<(), MergeError> {
    for half in 0..pass.len() {
        let owner = |cell| {
            let first = division.pieces_of(half, cell, pass).next();
            first.map(|piece| division.owner(&piece, pass))
        };
        // Those of one shard one after the other, so that few files are opened again.
        let mut cells: Vec<u32> = (0..division.cells()).collect();
        cells.sort_by_cached_key(|cell| owner(*cell));
        for cell in cells {
            let mut blocks = Pairwise::default();
            for piece in division.pieces_of(half, cell, pass) {
                let shard = division.owner(&piece, pass);
                let blank = || spec.tile(piece.bounds);
                let tiles = group.tiles((shard, number), &piece.unit, blank)?;
                tiles.into_iter().for_each(|tile| blocks.push(tile));
            }
            if let Some(tile) = blocks.take(None) {
                take(half, tile);
            }
        }
    }
    Ok(())
}
