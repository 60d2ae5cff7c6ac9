//! Photon mapping: iterations, each of which sends photons from the lights and then takes a sample of every pixel, which
//! gathers them.
//!
//! Photons come first, so that a pixel's path can gather them where it ends: nothing is kept of it but the size of its disc.
//! Light paths are divided into fixed runs whose photons are joined in order, and each pixel sums its own. So the image
//! does not depend on threads, and needs neither locks nor atomic sums.

use super::halves::floor;
use super::progressive::Progressive;
use super::{Ended, Goal, OfAll, PendingSample, Progress, RenderJob};
use crate::cameras::{BUNDLE, CameraRay, CameraSample};
use crate::film::{Film, Kept, PixelBounds, PixelStatistics, Tile};
use crate::integrators::{Disc, Gather, Photon, PhotonMap, PhotonMapper};
use crate::math::{DVec3, Rgb};
use arrayvec::ArrayVec;
use rayon::prelude::*;
use std::time::Instant;

/// Light paths in a run.
const RUN: u64 = 1 << 12;

/// Iterations before an error is believed.
const PILOT: u32 = Goal::PILOT;

/// Renders as many iterations as pixels have samples; if it is stopped, as many as were done.
pub(super) fn render(
    job: &RenderJob,
    mapper: &PhotonMapper,
    tile_size: u32,
    progress: &Progress,
) -> Film {
    let mut passes = Passes::new(job, mapper, tile_size);
    for _ in 0..job.sampler.spp() {
        if !passes.iterate(progress) {
            break;
        }
    }
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
    let deadline = { goal.time }.and_then(|time| Instant::now().checked_add(time));
    let mut passes = Passes::new(job, mapper, tile_size);
    let ended = loop {
        if !passes.iterate(progress) {
            break Ended::Stopped;
        }
        let is_known = passes.done >= PILOT;
        let error = is_known.then(|| error(&passes.film())).flatten();
        progress.pass_done(passes.done, passes.done.into(), error);
        if goal.error.zip(error).is_some_and(|(goal, e)| e <= goal) {
            break Ended::Error;
        }
        if passes.done >= goal.max_spp {
            break Ended::Samples;
        }
        if deadline.is_some_and(|end| Instant::now() >= end) {
            break Ended::Time;
        }
    };
    let film = passes.film();
    Progressive {
        error: error(&film),
        bound: None,
        first_dropped: film
            .first_dropped()
            .map(|first| (first, job.sampler.clone())),
        spp: passes.done.into(),
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
    /// Iterations so far.
    done: u32,
}

/// The pixels of a tile.
struct Pixels {
    tile: Tile,
    discs: Vec<Disc>,
}

impl<'a> Passes<'a> {
    fn new(job: &'a RenderJob, mapper: &'a PhotonMapper<'a>, tile_size: u32) -> Passes<'a> {
        let film = job.film.pixel_bounds();
        let paths = mapper.paths(film.area() as u64);
        let pixels = |bounds: PixelBounds| Pixels {
            tile: job.film.tile(bounds),
            discs: vec![mapper.disc(); bounds.area()],
        };
        let sampled = film.intersection(job.sampled);
        Passes {
            job,
            mapper,
            paths,
            runs: vec![Vec::new(); paths.div_ceil(RUN) as usize],
            map: PhotonMap::default(),
            tiles: sampled.tiles(tile_size).map(pixels).collect(),
            done: 0,
        }
    }

    /// One more iteration. Returns `false` if it was stopped; then some tiles may have it.
    fn iterate(&mut self, progress: &Progress) -> bool {
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
            return false;
        }
        self.map.fill(self.runs.iter().map(Vec::as_slice));
        let pass = Pass {
            job,
            mapper,
            map: &self.map,
            paths: paths as f64,
            number: self.done,
            spacing: OfAll::new(job).spacing,
        };
        let tiles = self.tiles.par_iter_mut().filter(|_| goes_on());
        tiles.for_each(|pixels| {
            pass.sample(pixels);
            progress.advance(pixels.discs.len() as u64);
        });
        self.done += 1;
        if let Some(live) = progress.live() {
            live.replace(self.film());
        }
        goes_on()
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
        let mut waiting = ArrayVec::<PendingSample, BUNDLE>::new();
        let mut samples = ArrayVec::<CameraSample, BUNDLE>::new();
        let mut rays = ArrayVec::new();
        let mut discs = pixels.discs.iter_mut();
        let mut at = pixels.tile.bounds().pixels();
        loop {
            for pixel in at.by_ref().take(BUNDLE) {
                let (sample, rest) = PendingSample::new(job, &job.sampler, pixel, number);
                samples.push(sample);
                waiting.push(rest);
            }
            if samples.is_empty() {
                pixels.tile.close();
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
        mut waiting: PendingSample,
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
