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
//!
//! Where paths are traced from the lights, each half has its own, as many as camera samples.

use super::halves::{Counts, Halves, follows};
use super::paired_light::{Pairing, Pairs};
use super::work::{Worked, work};
use super::{
    Ended, Goal, Progress, RenderJob, light_pass, locate, photon_passes, render_in_two, sample_tile,
};
use crate::checkpoint::{Journal, Unit};
use crate::film::{Developed, DroppedSample, Film, PixelBounds, PixelStatistics, Splats, Tile};
use crate::integrators::Workspace;
use crate::integrators::witness::Place;
use crate::math::UVec2;
use crate::samplers::Sampler;
use rayon::prelude::*;
use std::ops::Range;
use std::time::{Duration, Instant};

/// An image rendered in passes.
#[derive(Clone, Debug)]
pub struct Progressive {
    /// The image.
    pub film: Developed,
    /// Its estimated relative error: the root of the mean, over pixels and channels, of variance / (mean² + ε²), where
    /// ε is 1 % of the image's mean, so that dark pixels do not dominate. The square is what `fstop compare` calls the
    /// relative mean squared error. It is an estimate: if n pixels have most of the error, it scatters by a relative
    /// 1/√(2n), and stopping at the first value that is small enough is biased toward stopping early. For 64 × 64
    /// pixels that is 1 %, for the edge of one light much more. `None` if it is unknown: the halves are equal, or one
    /// of them lacks pixels.
    pub error: Option<f64>,
    /// What the true error is below with the goal's confidence, if it has one.
    pub bound: Option<f64>,
    /// Average number of samples per pixel.
    pub spp: f64,
    /// Number of passes.
    pub passes: u32,
    /// Why rendering stopped.
    pub ended: Ended,
    /// The first sample that was dropped, and where on its path, if it was found again.
    pub first_dropped: Option<(DroppedSample, Option<Place>)>,
}

/// Renders the sampler's number of samples as two halves on the current rayon pool, whose difference tells the variance
/// of well-distributed samples; if it is stopped, as much of it as was done.
pub fn render_halves(job: &RenderJob, tile_size: u32, progress: &Progress) -> Progressive {
    let samplers = [0, 1].map(|half| job.sampler.half_of_samples(half));
    if !job.has_splats() {
        let (film, dropped) = render_in_two(job, &samplers, tile_size, progress);
        let first = dropped.into_iter().zip(samplers);
        let sampled = job.film.pixel_bounds().intersection(job.sampled);
        return Progressive {
            error: None,
            bound: None,
            spp: film.samples() as f64 / sampled.area().max(1) as f64,
            passes: 1,
            ended: match progress.is_stopped() {
                true => Ended::Stopped,
                false => Ended::Samples,
            },
            first_dropped: { first }
                .filter_map(|(dropped, sampler)| Some((dropped?, sampler)))
                .map(|(dropped, sampler)| (dropped, locate(job, (&sampler, None), dropped)))
                .next(),
            film,
        };
    }
    let mut passes = Passes::new(job, tile_size, progress);
    passes.samplers = samplers;
    let tiles = passes.halves.tiles().len();
    let counts = [0, 1].map(|half| vec![passes.samplers[half].spp(); tiles]);
    let ended = match passes.run(&counts, None, progress) {
        true => Ended::Samples,
        false => Ended::Stopped,
    };
    passes.finish(1, ended)
}

/// Renders the image on the current rayon pool until `goal` is reached.
pub fn render_until(
    job: &RenderJob,
    tile_size: u32,
    goal: &Goal,
    progress: &Progress,
) -> Progressive {
    if let Some(mapper) = job.integrator.photons(&job.world) {
        return photon_passes::render_until(job, &mapper, tile_size, goal, progress);
    }
    // As if the processes that a checkpoint knows of had been this one.
    let spent = progress.journal().map_or(Duration::ZERO, |j| j.spent());
    let now = Instant::now();
    let started = now.checked_sub(spent).unwrap_or(now);
    let mut passes = Passes::new(job, tile_size, progress);
    let deadline = goal.time.and_then(|time| started.checked_add(time));
    passes.goal = Some(*goal);
    let mut number = 0;
    if deadline.is_some() {
        passes.preview();
    }
    for counts in first_pass(deadline.is_some()) {
        let next = counts.map(|count| vec![count; passes.halves.tiles().len()]);
        if !passes.run(&next, deadline, progress) {
            return passes.finish(1, ended_early(progress));
        }
    }
    loop {
        number += 1;
        let known = progress.journal().and_then(|j| j.plan(number));
        if known.is_none() && !passes.forget_later_light(progress) {
            return passes.finish(number, ended_early(progress));
        }
        let halves = &passes.halves;
        // There may be light of later passes in it already.
        let error = halves
            .judged(goal, number)
            .filter(|_| known.is_none() || !job.has_splats());
        progress.pass_done(number, halves.spp(), error);
        if let Some(ended) = halves.reached(goal, error) {
            return passes.finish(number, ended);
        }
        let affordable = deadline.map(|end| {
            let left = end.saturating_duration_since(Instant::now());
            let rate = halves.samples() / started.elapsed().as_secs_f64().max(1e-9);
            rate * left.as_secs_f64() * PART_OF_TIME
        });
        let plan = || halves.plan(goal, error, affordable);
        let is_kept = deadline.is_some() || job.has_splats();
        let next = match progress.journal().filter(|_| is_kept) {
            Some(journal) => planned_once(journal, number, halves, goal, plan),
            None => plan(),
        };
        // No further pass fits into the time.
        if next == *halves.counts() || !passes.run(&next, deadline, progress) {
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

/// A plan that depends on the clock, or on splats that are kept without those of earlier passes, or what it was when an
/// earlier process made it.
fn planned_once(
    journal: &Journal,
    pass: u32,
    halves: &Halves,
    goal: &Goal,
    plan: impl FnOnce() -> Counts,
) -> Counts {
    let fits = |next: &&Counts| follows(halves.counts(), next, goal);
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
    let steps = [[1, 0], [1, 1], [2, 2]];
    let steps = steps.into_iter().filter(|_| against_the_clock);
    steps.chain([[Goal::PILOT_OF_HALF; 2]]).collect()
}

/// Fraction of the remaining time that a pass is planned for: tiles differ, and being late is worse than being early.
const PART_OF_TIME: f64 = 0.9;

struct Passes<'a> {
    job: &'a RenderJob,
    halves: Halves,
    samplers: [Sampler; 2],
    /// None if all samples are taken in one pass.
    goal: Option<Goal>,
    /// The sample counts before and after each pass so far.
    passes: Vec<[Counts; 2]>,
    /// The first sample of each tile's central pixel, which may have to fill the tile.
    preview: Vec<PixelStatistics>,
}

impl<'a> Passes<'a> {
    fn new(job: &'a RenderJob, tile_size: u32, progress: &Progress) -> Passes<'a> {
        let splats = |half| light_pass::restored(job, half, progress);
        let splats = splats(0).zip(splats(1)).map(<[Splats; 2]>::from);
        Passes {
            job,
            halves: Halves::new(
                &job.film,
                job.sampled,
                tile_size,
                splats,
                job.sampler.is_dependent(),
            ),
            samplers: [0, 1].map(|half| job.sampler.half(half)),
            goal: None,
            passes: Vec::new(),
            preview: Vec::new(),
        }
    }

    /// Renders one sample in each tile, the same that the first pass renders there, and traces as many light paths.
    fn preview(&mut self) {
        let paths = self.halves.tiles().len() as u64;
        self.trace_light(0, (0..paths, 0), || true, &Progress::hidden());
        let hidden = Progress::hidden();
        let pairs = Pairs::new(self.job, Pairing::whole(self.job, 1), (0, None), &hidden);
        let sample = |workspace: &mut Workspace, bounds: &PixelBounds| {
            let center = (bounds.min + bounds.max) / 2;
            let pixel = PixelBounds::new(center, center + UVec2::ONE);
            let mut tile = self.job.film.tile(pixel);
            let own = (workspace, None, pairs.as_ref());
            sample_tile(self.job, &self.samplers[0], 0..1, (&mut tile, pixel), own);
            tile.statistics(center).copied().unwrap_or_default()
        };
        let tiles = self.halves.tiles().par_iter();
        let sampled = tiles.map_init(|| self.job.workspace(), sample);
        self.preview = sampled.collect();
    }

    /// Traces light paths of a half, as long as it is in time; some were counted already.
    fn trace_light(
        &mut self,
        half: usize,
        (paths, counted): (Range<u64>, u64),
        in_time: impl Fn() -> bool + Sync,
        progress: &Progress,
    ) -> bool {
        let paths = (std::slice::from_ref(&paths), counted);
        let sampler = (half as u8, &self.samplers[half]);
        let splats = self.halves.splats(half);
        splats.is_none_or(|splats| {
            light_pass::trace(self.job, sampler, splats, paths, in_time, progress)
        })
    }

    /// The light paths that belong to the samples of one half so far, or in a plan.
    fn paths(&self, half: usize, counts: &Counts) -> u64 {
        { self.job.splat_share() }.paths(self.halves.samples_of(half, counts))
    }

    /// Traces the light paths so far again if a checkpoint has those of later passes in the same sums, but not the plans of
    /// these passes. Returns `false` if it was stopped.
    fn forget_later_light(&mut self, progress: &Progress) -> bool {
        let mut is_whole = true;
        for half in [0, 1] {
            let paths = self.paths(half, self.halves.counts());
            if let (Some(splats), Some(blank)) = (self.halves.splats(half), self.job.splats())
                && splats.paths().count() > paths
            {
                *splats = blank;
                is_whole &= self.trace_light(half, (0..paths, 0), || true, progress);
            }
        }
        is_whole
    }

    /// Renders every tile of both halves up to these sample counts, and traces as many light paths. Starts no tile after the deadline: returns `false`
    /// if some were not rendered because of it, or because the render was stopped.
    fn run(&mut self, counts: &Counts, deadline: Option<Instant>, progress: &Progress) -> bool {
        let in_time = || deadline.is_none_or(|end| Instant::now() < end);
        let kept = |unit: &Unit| progress.journal().is_some_and(|journal| journal.has(unit));
        let before = [0, 1].map(|half| self.paths(half, self.halves.counts()));
        let pass = [self.halves.counts().clone(), counts.clone()];
        let job = self.job;
        let workspace = || job.workspace();
        let (mut complete, mut traced) = (true, [0; 2]);
        for (half, counts) in counts.iter().enumerate() {
            let (tiles, have) = (self.halves.tiles().to_vec(), &pass[0][half]);
            let pairing = self.pairing(half, &pass);
            let splats = (half as u8, self.halves.splats(half));
            let pairs = Pairs::new(job, pairing, splats, progress);
            let jobs = tiles.par_iter().zip(have).zip(counts);
            let rendered: Vec<Option<(Tile, u32)>> = jobs
                .enumerate()
                .map_init(workspace, |workspace, (tile, ((bounds, &have), &want))| {
                    let unit = Unit {
                        half: half as u8,
                        tile: tile as u32,
                        samples: have..want,
                    };
                    if want <= have || !(in_time() || kept(&unit)) {
                        return None;
                    }
                    let unit_of_tile = (&unit, *bounds);
                    let own = (workspace, pairs.as_ref());
                    match work(job, &self.samplers[half], unit_of_tile, own, progress) {
                        Worked::Finished(tile) => Some((tile, want)),
                        // A part of a pass would be counted by no later one.
                        Worked::Stopped(tile) => self.goal.is_none().then_some((tile, have)),
                    }
                })
                .collect();
            traced[half] = pairs.map_or(0, Pairs::traced);
            for (number, (tile, &want)) in rendered.into_iter().zip(counts).enumerate() {
                if let Some((tile, reached)) = tile {
                    self.halves.merge(half, tile);
                    self.halves.reach(half, number, reached);
                }
                complete &= self.halves.counts()[half][number] >= want;
            }
        }
        for (half, done) in before.into_iter().enumerate() {
            let paths = (done..self.paths(half, counts), traced[half]);
            complete &= self.trace_light(half, paths, in_time, progress);
        }
        self.passes.push(pass);
        complete
    }

    /// Which light paths the samples of a half are joined to in a pass with these counts before and after it.
    fn pairing(&self, half: usize, [before, after]: &[Counts; 2]) -> Option<Pairing> {
        let samples = before[half].iter().zip(&after[half]).map(|(&a, &b)| a..b);
        match self.goal {
            Some(_) => Pairing::of_pass(self.job, samples),
            None => Pairing::whole(self.job, self.samplers[half].spp()),
        }
    }

    /// Where on its path a sample of a half was dropped, if it is found again: joined to the light path that it had in its pass.
    fn locate(&self, half: usize, dropped: DroppedSample) -> Option<Place> {
        let mut tiles = self.halves.tiles().iter();
        let tile = tiles.position(|tile| tile.contains(dropped.pixel))?;
        let has_it = |[before, after]: &&[Counts; 2]| {
            let samples = u64::from(before[half][tile])..u64::from(after[half][tile]);
            samples.contains(&dropped.sample)
        };
        let pass = self.passes.iter().find(has_it)?;
        let pairing = self.pairing(half, pass);
        locate(self.job, (&self.samplers[half], pairing.as_ref()), dropped)
    }

    /// Fills tiles that have no samples of their own.
    fn fill(&self, film: &mut Film) {
        let [a, b] = self.halves.counts();
        let tiles = self.halves.tiles().iter().zip(&self.preview);
        for ((&bounds, preview), counts) in tiles.zip(a.iter().zip(b)) {
            if counts == (&0, &0) {
                film.fill(bounds, preview);
            }
        }
    }

    fn finish(self, passes: u32, ended: Ended) -> Progressive {
        let halves = &self.halves;
        let error = halves.error();
        let goal = self.goal.filter(|goal| goal.confidence.is_some());
        let bound = goal.and_then(|goal| halves.judged(&goal, passes));
        let first_dropped = halves.first_dropped();
        let film = halves.developed(|film| self.fill(film));
        let spp = match self.goal {
            Some(_) => halves.spp(),
            // Of a tile that was stopped, too.
            None => film.samples() as f64 / halves.pixels().max(1.0),
        };
        Progressive {
            first_dropped: first_dropped.map(|(first, half)| (first, self.locate(half, first))),
            film,
            error,
            bound,
            spp,
            passes,
            ended,
        }
    }
}
