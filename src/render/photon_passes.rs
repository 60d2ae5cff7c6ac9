//! Photon mapping: iterations, each of which sends photons from the lights and then takes a sample of every pixel, which
//! gathers them.
//!
//! Photons come first, so that a pixel's path can gather them where it ends: nothing is kept of it but the size of its disc.
//! Light paths are divided into fixed runs whose photons are joined in order, and each pixel sums its own. So the image
//! does not depend on threads, and needs neither locks nor atomic sums.
//!
//! A checkpoint has all tiles with their discs, and how many iterations each has: all as many, or, where the render was stopped
//! within one, some of them one more. The photons of an iteration are those of its number; they are sent again for the tiles that lack it.

use super::halves::floor;
use super::progressive::Progressive;
use super::{Ended, Goal, OfAll, Progress, RenderJob, SampleState, locate};
use crate::cameras::{BUNDLE, CameraRay, CameraSample};
use crate::film::{Film, Kept, PixelBounds, PixelStatistics, Tile};
use crate::integrators::{Disc, Gather, Photon, PhotonMap, PhotonMapper};
use crate::math::{DVec3, Rgb};
use arrayvec::ArrayVec;
use rayon::prelude::*;
use std::time::{Duration, Instant};

/// Light paths in a run.
const RUN: u64 = 1 << 12;

/// Iterations before an error is believed.
const PILOT: u32 = Goal::PILOT;

/// Side of the largest tile, pixels: a checkpoint's record holds one.
const LARGEST_TILE: u32 = 256;

/// Renders as many iterations as pixels have samples; if it is stopped, as many as were done.
pub(super) fn render(
    job: &RenderJob,
    mapper: &PhotonMapper,
    tile_size: u32,
    progress: &Progress,
) -> Film {
    let mut passes = Passes::restored(job, mapper, tile_size, job.sampler.spp(), progress);
    while passes.done < job.sampler.spp() && passes.iterate(progress) {}
    passes.film()
}

/// Renders until `goal` is reached. The error is that of noise: of the blur, samples do not tell.
pub(super) fn render_until(
    job: &RenderJob,
    mapper: &PhotonMapper,
    tile_size: u32,
    goal: &Goal,
    progress: &Progress,
) -> Progressive {
    let mut passes = Passes::restored(job, mapper, tile_size, goal.max_spp, progress);
    // As if the processes that a checkpoint knows of had been this one.
    let spent = progress.journal().map_or(Duration::ZERO, |j| j.spent());
    let left = goal.time.map(|time| time.saturating_sub(spent));
    let deadline = left.and_then(|left| Instant::now().checked_add(left));
    let ended = loop {
        if let Some(ended) = passes.ended(goal, deadline, progress) {
            break ended;
        }
        if !passes.iterate(progress) {
            break Ended::Stopped;
        }
    };
    let film = passes.film();
    let sampled = job.film.pixel_bounds().intersection(job.sampled);
    Progressive {
        error: error(&film),
        bound: None,
        first_dropped: { film.first_dropped() }
            .map(|first| (first, locate(job, (&job.sampler, None), first))),
        spp: passes.samples() as f64 / sampled.area().max(1) as f64,
        passes: passes.done,
        film: film.developed(Kept::Variance),
        ended,
    }
}

/// The estimated relative error (see [`Progressive::error`]) by the variances of pixels.
fn error(film: &Film) -> Option<f64> {
    let pixels = || film.pixels().iter().filter(|pixel| pixel.count() > 0);
    let count = 3.0 * pixels().count() as f64;
    let mean: DVec3 = pixels().map(PixelStatistics::mean).sum();
    let floor = floor(mean.element_sum() / count);
    let square = |pixel: &PixelStatistics| {
        let mean = pixel.mean();
        (pixel.variance_of_mean() / (mean * mean + floor)).element_sum()
    };
    let error = (pixels().map(square).sum::<f64>() / count).sqrt();
    (error.is_finite() && error > 0.0).then_some(error)
}

/// An image between two iterations.
struct Passes<'a> {
    job: &'a RenderJob,
    mapper: &'a PhotonMapper<'a>,
    /// Light paths in an iteration.
    paths: u64,
    runs: Vec<Vec<Photon>>,
    map: PhotonMap,
    tiles: Vec<Pixels>,
    /// Iterations that all tiles have.
    done: u32,
    /// Samples that the checkpoint has.
    kept: u64,
}

/// Iterations that all of these have.
fn iterations(tiles: &[Pixels]) -> u32 {
    tiles.iter().map(|tile| tile.done).min().unwrap_or(0)
}

/// The pixels of a tile.
struct Pixels {
    tile: Tile,
    discs: Vec<Disc>,
    /// Iterations so far.
    done: u32,
}

impl Pixels {
    fn store(&self, out: &mut Vec<u8>) {
        self.tile.store(out);
        self.discs.iter().for_each(|disc| disc.store(out));
    }

    /// What these, before the first iteration, became in `done`, by `bytes`; `None` if they cannot have become that.
    fn restored(self, done: u32, mut bytes: &[u8]) -> Option<Pixels> {
        let tile = self.tile.restored(&mut bytes)?;
        let discs = self.discs.iter().map(|disc| disc.restored(&mut bytes));
        let discs = discs.collect::<Option<_>>()?;
        let has_all = |(_, pixel): (_, &PixelStatistics)| pixel.count() == u64::from(done);
        let is_whole = bytes.is_empty() && tile.iter().all(has_all);
        is_whole.then_some(Pixels { tile, discs, done })
    }
}

impl<'a> Passes<'a> {
    /// What the checkpoint has, if that is at most so many iterations.
    fn restored(
        job: &'a RenderJob,
        mapper: &'a PhotonMapper<'a>,
        tile_size: u32,
        most: u32,
        progress: &Progress,
    ) -> Passes<'a> {
        let film = job.film.pixel_bounds();
        let paths = mapper.paths(film.area() as u64);
        let pixels = |bounds: PixelBounds| Pixels {
            tile: job.film.tile(bounds),
            discs: vec![mapper.disc(); bounds.area()],
            done: 0,
        };
        let sampled = film.intersection(job.sampled);
        let bounds: Vec<PixelBounds> = sampled.tiles(tile_size.min(LARGEST_TILE)).collect();
        let kept = progress.journal().and_then(|journal| {
            let read =
                |tile: usize, done, bytes: &[u8]| pixels(*bounds.get(tile)?).restored(done, bytes);
            journal.restore_iterated(bounds.len(), read)
        });
        let is_possible = |tiles: &Vec<Pixels>| {
            let most = most.min(iterations(tiles) + 1);
            tiles.iter().all(|tile| tile.done <= most)
        };
        let tiles = { kept.filter(is_possible) }
            .unwrap_or_else(|| bounds.iter().copied().map(pixels).collect());
        let passes = Passes {
            job,
            mapper,
            paths,
            runs: vec![Vec::new(); paths.div_ceil(RUN) as usize],
            map: PhotonMap::default(),
            done: iterations(&tiles),
            tiles,
            kept: 0,
        };
        let kept = passes.samples();
        progress.advance(kept);
        Passes { kept, ..passes }
    }

    /// Why no iteration follows; `None` if one does: also where it has begun already.
    fn ended(&self, goal: &Goal, deadline: Option<Instant>, progress: &Progress) -> Option<Ended> {
        if self.done == 0 || self.tiles.iter().any(|tile| tile.done > self.done) {
            return None;
        }
        let is_known = self.done >= PILOT;
        let error = is_known.then(|| error(&self.film())).flatten();
        progress.pass_done(self.done, self.done.into(), error);
        if goal.error.zip(error).is_some_and(|(goal, e)| e <= goal) {
            return Some(Ended::Error);
        }
        if self.done >= goal.max_spp {
            return Some(Ended::Samples);
        }
        let is_over = deadline.is_some_and(|end| Instant::now() >= end);
        is_over.then_some(Ended::Time)
    }

    /// One more iteration, and the checkpoint if it is time. Returns `false` if it was stopped; then some tiles may have it.
    fn iterate(&mut self, progress: &Progress) -> bool {
        self.advance(progress);
        if let Some(journal) = progress.journal()
            && self.samples() > self.kept
            && (progress.is_stopped() || journal.is_time_for(self.bytes()))
        {
            self.kept = self.samples();
            journal.keep_iterated(&self.tiles, |tile| tile.done, Pixels::store);
        }
        !progress.is_stopped()
    }

    /// Takes the tiles that lack it through the next iteration, or, if it is stopped, some of them.
    fn advance(&mut self, progress: &Progress) {
        let goes_on = || !progress.is_stopped();
        let Passes { job, mapper, .. } = *self;
        let paths = self.paths;
        let before = u64::from(self.done) * paths;
        let shutter = job.camera.shutter();
        let runs = self.runs.par_iter_mut().enumerate();
        runs.filter(|_| goes_on()).for_each(|(run, photons)| {
            photons.clear();
            let start = run as u64 * RUN;
            for path in start..(start + RUN).min(paths) {
                let mut stream = job.sampler.light_stream(before + path);
                mapper.trace(|fraction| shutter.time(fraction), &mut stream, photons);
            }
            if before == 0 {
                // Later iterations have about as many; with this they find their memory there.
                photons.reserve(photons.len() / 2);
            }
        });
        if !goes_on() {
            return;
        }
        self.map.fill(self.runs.iter().map(Vec::as_slice));
        let pass = Pass {
            job,
            mapper,
            map: &self.map,
            paths: paths as f64,
            number: self.done,
            spacing: OfAll::new(job, &job.sampler, None).spacing,
        };
        let tiles = self.tiles.par_iter_mut();
        let lacking = tiles.filter(|tile| tile.done == pass.number && goes_on());
        lacking.for_each(|pixels| {
            pass.sample(pixels);
            progress.advance(pixels.discs.len() as u64);
        });
        self.done = iterations(&self.tiles);
        if let Some(live) = progress.live() {
            live.replace(self.film());
        }
    }

    /// Of all pixels.
    fn samples(&self) -> u64 {
        let of_tile = |tile: &Pixels| u64::from(tile.done) * tile.discs.len() as u64;
        self.tiles.iter().map(of_tile).sum()
    }

    /// That a checkpoint takes, but for a few.
    fn bytes(&self) -> u64 {
        let pixels: usize = self.tiles.iter().map(|tile| tile.discs.len()).sum();
        (pixels * (size_of::<PixelStatistics>() + size_of::<Disc>())) as u64
    }

    fn film(&self) -> Film {
        let mut film = Film::new(&self.job.film);
        for pixels in &self.tiles {
            film.merge(pixels.tile.clone());
        }
        film
    }
}

/// An iteration, when its photons are there.
struct Pass<'a> {
    job: &'a RenderJob,
    mapper: &'a PhotonMapper<'a>,
    map: &'a PhotonMap,
    paths: f64,
    number: u32,
    /// See [`OfAll`].
    spacing: f32,
}

impl Pass<'_> {
    /// Takes a sample of every pixel of a tile, a bundle of camera rays at a time.
    fn sample(&self, pixels: &mut Pixels) {
        let Pass { job, number, .. } = *self;
        let want_differentials = job.world.needs_footprint();
        let mut waiting = ArrayVec::<SampleState, BUNDLE>::new();
        let mut samples = ArrayVec::<CameraSample, BUNDLE>::new();
        let mut rays = [const { None }; BUNDLE];
        let mut discs = pixels.discs.iter_mut();
        let mut at = pixels.tile.bounds().pixels();
        loop {
            for pixel in at.by_ref().take(BUNDLE) {
                let (sample, rest) = SampleState::new(job, &job.sampler, pixel, number);
                samples.push(sample);
                waiting.push(rest);
            }
            if samples.is_empty() {
                pixels.tile.close();
                pixels.done += 1;
                return;
            }
            job.camera.rays(&samples, want_differentials, &mut rays);
            for ((waiting, ray), disc) in waiting.drain(..).zip(&rays).zip(&mut discs) {
                self.finish(waiting, ray.as_ref(), disc, &mut pixels.tile);
            }
            samples.clear();
        }
    }

    fn finish(
        &self,
        mut waiting: SampleState,
        ray: Option<&CameraRay>,
        disc: &mut Disc,
        tile: &mut Tile,
    ) {
        let Some(camera_ray) = ray else {
            tile.add_sample(waiting.pixel, Rgb::ZERO, 0.0);
            return;
        };
        let differentials = camera_ray.scaled_differentials(self.spacing);
        let mut gather = Gather {
            map: self.map,
            paths: self.paths,
            disc,
        };
        let stream = &mut waiting.stream;
        let differentials = differentials.as_ref();
        let radiance = { self.mapper }.radiance(camera_ray.ray, differentials, stream, &mut gather);
        let weight = camera_ray.tint * (camera_ray.weight * waiting.filter_weight);
        tile.add_colored_sample(waiting.pixel, radiance, weight);
    }
}
