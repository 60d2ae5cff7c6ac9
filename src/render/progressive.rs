//! Progressive rendering in passes, until an error goal or time limit is reached.
//!
//! The image is the mean of two **halves**: separate films with independent samples, each well distributed within
//! itself. Half their difference estimates the error of the mean without assuming that the samples of a pixel are
//! independent, which stratified and quasi-random ones are not: their sample variance would overestimate it.
//!
//! After each pass tiles get samples according to their noise ([`super::allocation`]). The allocation of one half is
//! determined by the *other* half's previous passes, and the halves have equal weight regardless of their sample
//! counts: a tile that happened to look smooth gets no more weight for it. (One decision uses both: when to stop, and
//! so by how much all counts are scaled; it depends on the whole image.)
//!
//! The error is known once the halves differ somewhere. Until then, because no light or only one value has been found,
//! it is not taken as 0: all sample counts are doubled.
//!
//! Without a time limit the image is a pure function of scene, settings and seed. A time limit starts with the first
//! sample: the first pass then grows from one sample per pixel in one half, no tile is started after the time is up,
//! and a tile that has no sample by then is filled with that of its central pixel.

use super::allocation::{Share, doubled, for_error, for_samples};
use super::work::{Worked, work};
use super::{Ended, Goal, Progress, RenderJob, sample_tile};
use crate::checkpoint::{Journal, Unit};
use crate::film::{DroppedSample, Film, PixelBounds, PixelStatistics, Tile};
use crate::math::UVec2;
use crate::samplers::Sampler;
use glam::DVec3;
use rayon::prelude::*;
use std::time::{Duration, Instant};

/// An image rendered in passes.
#[derive(Clone, Debug)]
pub struct Progressive {
    /// The image.
    pub film: Film,
    /// Its estimated relative error: the root of the mean, over pixels and channels, of variance / (mean² + ε²), where
    /// ε is 1 % of the image's mean, so that dark pixels do not dominate. The square is what `fstop compare` calls the
    /// relative mean squared error. It is an estimate: if n pixels have most of the error, it scatters by a relative
    /// 1/√(2n), and stopping at the first value that is small enough is biased toward stopping early. For 64 × 64
    /// pixels that is 1 %, for the edge of one light much more. `None` if it is unknown: the halves are equal, or one
    /// of them lacks pixels.
    pub error: Option<f64>,
    /// Average number of samples per pixel.
    pub spp: f64,
    /// Number of passes.
    pub passes: u32,
    /// Why rendering stopped.
    pub ended: Ended,
    /// The first sample that was dropped, and its sampler.
    pub first_dropped: Option<(DroppedSample, Sampler)>,
}

/// Renders the image on the current rayon pool until `goal` is reached.
pub fn render_until(
    job: &RenderJob,
    tile_size: u32,
    goal: &Goal,
    progress: &Progress,
) -> Progressive {
    // As if the processes that a checkpoint knows of had been this one.
    let spent = progress.journal().map_or(Duration::ZERO, |j| j.spent());
    let now = Instant::now();
    let started = now.checked_sub(spent).unwrap_or(now);
    let mut passes = Passes::new(job, tile_size);
    let deadline = goal.time.and_then(|time| started.checked_add(time));
    let most = (goal.max_spp.max(Goal::PILOT) / 2).max(1);
    let mut number = 0;
    if deadline.is_some() {
        passes.preview();
    }
    for counts in first_pass(deadline.is_some()) {
        let next = counts.map(|count| vec![count; passes.tiles.len()]);
        if !passes.run(&next, deadline, progress) {
            return passes.finish(1, ended_early(progress));
        }
    }
    loop {
        number += 1;
        let error = passes.error();
        progress.pass_done(number, passes.spp(), error);
        let time_left = deadline.map(|end| end.saturating_duration_since(Instant::now()));
        let good = |wanted: f64| error.is_some_and(|error| error <= wanted);
        if goal.error.is_some_and(good) {
            return passes.finish(number, Ended::Error);
        }
        if passes.all_have(most) {
            return passes.finish(number, Ended::Samples);
        }
        let plan = || passes.plan(goal, error, time_left, started.elapsed(), most);
        let next = match progress.journal().filter(|_| deadline.is_some()) {
            Some(journal) => planned_once(journal, number, &passes.counts(), most, plan),
            None => plan(),
        };
        // No further pass fits into the time.
        if next == passes.counts() || !passes.run(&next, deadline, progress) {
            return passes.finish(number, ended_early(progress));
        }
    }
}

/// Why a pass was not finished.
fn ended_early(progress: &Progress) -> Ended {
    match progress.is_stopped() {
        true => Ended::Stopped,
        false => Ended::Time,
    }
}

/// A plan that depends on the clock, or what it was when an earlier process made it.
fn planned_once(
    journal: &Journal,
    pass: u32,
    have: &[Vec<u32>; 2],
    most: u32,
    plan: impl FnOnce() -> [Vec<u32>; 2],
) -> [Vec<u32>; 2] {
    let fits = |counts: &&[Vec<u32>; 2]| {
        let halves = || counts.iter().zip(have);
        halves().all(|(next, have)| next.len() == have.len()) && { halves() }
            .flat_map(|(next, have)| next.iter().zip(have))
            .all(|(next, have)| (*have..=most.max(*have)).contains(next))
    };
    if let Some(counts) = journal.plan(pass).filter(fits) {
        return counts.clone();
    }
    let counts = plan();
    journal.planned(pass, &counts);
    counts
}

/// Sample counts per pixel of the two halves, in sequence, up to the first pass's. With a time limit in small steps, so
/// that every pixel has a sample as early as possible.
fn first_pass(against_the_clock: bool) -> Vec<[u32; 2]> {
    let all = Goal::PILOT / 2;
    let steps = [[1, 0], [1, 1], [2, 2]];
    let steps = steps.into_iter().filter(|_| against_the_clock);
    steps.chain([[all; 2]]).collect()
}

/// Fraction of the remaining time that a pass is planned for: tiles differ, and being late is worse than being early.
const PART_OF_TIME: f64 = 0.9;

/// A pass is planned for slightly less than the requested error: its estimate is noisy, and a miss costs another pass.
const PART_OF_ERROR: f64 = 0.97;

/// One of two independent images.
struct Half {
    sampler: Sampler,
    film: Film,
    /// Samples per pixel of each tile.
    counts: Vec<u32>,
}

struct Passes<'a> {
    job: &'a RenderJob,
    tiles: Vec<PixelBounds>,
    halves: [Half; 2],
    /// The first sample of each tile's central pixel, which may have to fill the tile.
    preview: Vec<PixelStatistics>,
}

impl<'a> Passes<'a> {
    fn new(job: &'a RenderJob, tile_size: u32) -> Passes<'a> {
        let film = Film::new(&job.film);
        let bounds = film.bounds().intersection(job.sampled);
        let tiles: Vec<PixelBounds> = bounds.tiles(tile_size).collect();
        let half = |which| Half {
            sampler: job.sampler.half(which),
            film: film.clone(),
            counts: vec![0; tiles.len()],
        };
        Passes {
            job,
            halves: [half(0), half(1)],
            tiles,
            preview: Vec::new(),
        }
    }

    /// Renders one sample in each tile, the same that the first pass renders there.
    fn preview(&mut self) {
        let half = &self.halves[0];
        let sample = |bounds: &PixelBounds| {
            let center = (bounds.min + bounds.max) / 2;
            let pixel = PixelBounds::new(center, center + UVec2::ONE);
            let mut tile = half.film.tile(pixel);
            sample_tile(self.job, &half.sampler, 0..1, &mut tile, pixel);
            tile.statistics(center).copied().unwrap_or_default()
        };
        self.preview = self.tiles.par_iter().map(sample).collect();
    }

    fn counts(&self) -> [Vec<u32>; 2] {
        [0, 1].map(|i| self.halves[i].counts.clone())
    }

    fn all_have(&self, most: u32) -> bool {
        self.halves
            .iter()
            .flat_map(|h| &h.counts)
            .all(|&n| n >= most)
    }

    /// Renders every tile of both halves up to these sample counts. Starts no tile after the deadline: returns `false`
    /// if some were not rendered because of it, or because the render was stopped.
    fn run(
        &mut self,
        counts: &[Vec<u32>; 2],
        deadline: Option<Instant>,
        progress: &Progress,
    ) -> bool {
        let in_time = || deadline.is_none_or(|end| Instant::now() < end);
        let kept = |unit: &Unit| progress.journal().is_some_and(|journal| journal.has(unit));
        let mut complete = true;
        for ((half, counts), which) in self.halves.iter_mut().zip(counts).zip(0..) {
            let jobs = self.tiles.par_iter().zip(&half.counts).zip(counts);
            let rendered: Vec<Option<Tile>> = jobs
                .enumerate()
                .map(|(tile, ((bounds, &have), &want))| {
                    let unit = Unit {
                        half: which,
                        tile: tile as u32,
                        samples: have..want,
                    };
                    if want <= have || !(in_time() || kept(&unit)) {
                        return None;
                    }
                    let film = &half.film;
                    match work(self.job, &half.sampler, film, *bounds, &unit, progress) {
                        Worked::Finished(tile) => Some(tile),
                        Worked::Stopped(_) => None,
                    }
                })
                .collect();
            for (tile, (have, &want)) in
                rendered.into_iter().zip(half.counts.iter_mut().zip(counts))
            {
                if let Some(tile) = tile {
                    half.film.merge(tile);
                    *have = want;
                }
                complete &= *have >= want;
            }
        }
        complete
    }

    /// Number of camera samples so far.
    fn samples(&self) -> f64 {
        let of = |half: &Half| -> f64 {
            let pairs = self.tiles.iter().zip(&half.counts);
            pairs.map(|(t, &n)| t.area() as f64 * f64::from(n)).sum()
        };
        self.halves.iter().map(of).sum()
    }

    fn pixels(&self) -> f64 {
        self.tiles.iter().map(|t| t.area() as f64).sum()
    }

    /// Average number of samples per pixel.
    fn spp(&self) -> f64 {
        self.samples() / self.pixels().max(1.0)
    }

    /// See [`Progressive::error`].
    fn error(&self) -> Option<f64> {
        if self.halves.iter().flat_map(|h| &h.counts).any(|&n| n == 0) {
            return None;
        }
        let [a, b] = [0, 1].map(|i| self.halves[i].film.pixels());
        let pairs = || a.iter().zip(b).filter(|(p, _)| p.count() > 0);
        let count = pairs().count() as f64;
        let mean: DVec3 = pairs().map(|(p, q)| (p.mean() + q.mean()) * 0.5).sum();
        let floor = floor(mean.element_sum() / (3.0 * count));
        let squares = pairs().map(|(p, q)| {
            let (mean, error) = ((p.mean() + q.mean()) * 0.5, (p.mean() - q.mean()) * 0.5);
            (error * error / (mean * mean + floor)).element_sum()
        });
        let error = (squares.sum::<f64>() / (3.0 * count)).sqrt();
        // No pixels, or no noise: what has not been sampled yet may be anything.
        (error.is_finite() && error > 0.0).then_some(error)
    }

    /// The tiles of `of`, with the noise measured by the other half.
    fn shares(&self, of: usize) -> Vec<Share> {
        let film = &self.halves[1 - of].film;
        let seen = film.pixels().iter().filter(|p| p.count() > 0);
        let sum: DVec3 = seen.map(PixelStatistics::mean).sum();
        let floor = floor(sum.element_sum() / (3.0 * self.pixels()));
        let noise = |pixel: &PixelStatistics| {
            let variance = pixel.variance_of_mean() * pixel.count() as f64;
            (variance / (pixel.mean() * pixel.mean() + floor)).element_sum() / 3.0
        };
        let share = |(tile, &count): (&PixelBounds, &u32)| Share {
            noise: tile
                .pixels()
                .filter_map(|p| film.statistics(p))
                .map(noise)
                .sum(),
            area: tile.area() as f64,
            count,
        };
        self.tiles
            .iter()
            .zip(&self.halves[of].counts)
            .map(share)
            .collect()
    }

    /// The counts after the next pass; the current ones if no time is left.
    fn plan(
        &self,
        goal: &Goal,
        error: Option<f64>,
        time_left: Option<Duration>,
        spent: Duration,
        most: u32,
    ) -> [Vec<u32>; 2] {
        let shares = [0, 1].map(|half| self.shares(half));
        let mut plan = [0, 1].map(|half| doubled(&shares[half], most));
        if let Some((wanted, error)) = goal.error.zip(error) {
            // The error that the allocation predicts for the mean of the halves, compared with their actual difference:
            // well-distributed samples do better than independent ones.
            let promised: f64 = shares
                .iter()
                .flatten()
                .map(|s| s.noise / f64::from(s.count))
                .sum();
            let measured = (error / (PART_OF_ERROR * wanted)).powi(2);
            let target = 0.5 * promised / measured;
            plan = [0, 1].map(|i| for_error(&shares[i], target, most));
        }
        let Some(left) = time_left else { return plan };
        let rate = self.samples() / spent.as_secs_f64().max(1e-9);
        let affordable = rate * left.as_secs_f64() * PART_OF_TIME;
        let cost = |plan: &[Vec<u32>; 2]| -> f64 {
            let of = |half: usize| -> f64 {
                let tiles = plan[half].iter().zip(&shares[half]);
                tiles.map(|(&n, s)| f64::from(n - s.count) * s.area).sum()
            };
            of(0) + of(1)
        };
        if goal.error.is_some() && cost(&plan) <= affordable {
            return plan;
        }
        [0, 1].map(|i| for_samples(&shares[i], 0.5 * affordable, most))
    }

    /// Fills tiles that have no samples of their own.
    fn fill(&self, film: &mut Film) {
        let [a, b] = &self.halves;
        let counts = a.counts.iter().zip(&b.counts);
        let tiles = self.tiles.iter().zip(&self.preview).zip(counts);
        for ((&bounds, preview), counts) in tiles {
            if counts == (&0, &0) {
                film.fill(bounds, preview);
            }
        }
    }

    fn finish(self, passes: u32, ended: Ended) -> Progressive {
        let (spp, error) = (self.spp(), self.error());
        let [a, b] = &self.halves;
        let of = |half: &Half| {
            let dropped = half.film.first_dropped()?;
            Some((dropped, half.sampler.clone()))
        };
        let mut film = Film::mean_of(&a.film, &b.film);
        self.fill(&mut film);
        Progressive {
            first_dropped: of(a).or_else(|| of(b)),
            film,
            error,
            spp,
            passes,
            ended,
        }
    }
}

/// ε² for an image of this mean.
fn floor(mean: f64) -> DVec3 {
    DVec3::splat((0.01 * mean).powi(2).max(f64::MIN_POSITIVE))
}
