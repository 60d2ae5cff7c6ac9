//! Rendering: the film is divided into tiles, tiles are distributed over threads, and each pixel sample traces a camera
//! ray.
//!
//! An image is a pure function of scene, settings and seed: every sample's dimensions are determined by (seed, pixel,
//! sample index, dimension), pixels are independent, and tiles are collected by position. Thread count and tile size do
//! not change a bit of it.

mod allocation;
mod goal;
mod halves;
mod light_pass;
mod photon_passes;
mod pilot;
mod progress;
mod progressive;
mod shard;
mod work;

pub use goal::{Ended, Goal};
pub use halves::Halves;
pub use progress::{Progress, Step};
pub use progressive::render_until;
pub use shard::{Division, LightOfShard, Pass, passes, render_shard};

use crate::cameras::{BUNDLE, Camera, CameraRay, CameraSample};
use crate::checkpoint::Unit;
use crate::film::{DroppedSample, Film, FilmSpec, LightShare, PixelBounds, Tile};
use crate::filters::Filter;
use crate::integrators::witness::{Place, Watch};
use crate::integrators::{CameraEnd, Integrator, Workspace};
use crate::math::{IVec2, Rgb, UVec2, Vec2};
use crate::samplers::{SampleStream, Sampler};
use crate::world::World;
use arrayvec::ArrayVec;
use rayon::prelude::*;
use std::ops::Range;
use work::{Worked, work};

/// Side of a tile in pixels: small enough to keep two cores busy to the end of a small image, large enough that
/// distributing tiles costs nothing.
pub const TILE_SIZE: u32 = 16;

/// Everything that is needed to render one image.
pub struct RenderJob {
    /// The geometry, materials and lights.
    pub world: World,
    /// Generates the camera rays.
    pub camera: Camera,
    /// Computes the radiance along them.
    pub integrator: Integrator,
    /// Generates the samples.
    pub sampler: Sampler,
    /// Samples per pixel that textures are filtered for: the scene's own, regardless of how many are taken. With more
    /// samples each covers a smaller part of the pixel (docs/scene-language.md §3.1), so the converged image depends on
    /// it.
    pub footprint_spp: u32,
    /// The reconstruction filter, which distributes samples in and around a pixel.
    pub filter: Filter,
    /// The film.
    pub film: FilmSpec,
    /// Pixels to sample; those outside stay black.
    pub sampled: PixelBounds,
    /// Light paths for each camera sample, where any are traced: see [`RenderJob::learn`].
    pub light_share: LightShare,
}

/// Renders the image on the current rayon pool; if it is stopped, as much of it as was done.
pub fn render(job: &RenderJob, tile_size: u32, progress: &Progress) -> Film {
    if let Some(mapper) = job.integrator.photons(&job.world) {
        return photon_passes::render(job, &mapper, tile_size, progress);
    }
    let mut film = Film::new(&job.film);
    let tiles: Vec<PixelBounds> = film
        .bounds()
        .intersection(job.sampled)
        .tiles(tile_size)
        .collect();
    let rendered: Vec<Tile> = tiles
        .into_par_iter()
        .enumerate()
        .map(|(tile, bounds)| {
            let unit = Unit {
                half: 0,
                tile: tile as u32,
                samples: 0..job.sampler.spp(),
            };
            match work(job, &job.sampler, bounds, &unit, progress) {
                Worked::Finished(tile) | Worked::Stopped(tile) => tile,
            }
        })
        .collect();
    for tile in rendered {
        film.merge(tile);
    }
    if let Some(mut splats) = light_pass::restored(job, 0, progress) {
        let paths = 0..job.light_paths(job.sampler.spp());
        let sampler = (0, &job.sampler);
        light_pass::trace(job, sampler, &mut splats, paths, || true, progress);
        film.add_light(&[splats]);
    }
    film
}

/// Renders a range of the sampler's samples in every pixel of a tile, a bundle of camera rays at a time.
fn sample_tile(
    job: &RenderJob,
    sampler: &Sampler,
    samples_of_pixel: Range<u32>,
    tile: &mut Tile,
    bounds: PixelBounds,
) {
    let all = OfAll::new(job);
    let want_differentials = job.world.needs_footprint();
    let mut waiting = ArrayVec::<PendingSample, BUNDLE>::new();
    let mut samples = ArrayVec::<CameraSample, BUNDLE>::new();
    let mut rays = ArrayVec::new();
    let mut workspace = Workspace::default();
    let mut indices = bounds
        .pixels()
        .flat_map(|pixel| samples_of_pixel.clone().map(move |index| (pixel, index)));
    loop {
        for (pixel, index) in indices.by_ref().take(BUNDLE) {
            let (sample, rest) = PendingSample::new(job, sampler, pixel, index);
            samples.push(sample);
            waiting.push(rest);
        }
        if samples.is_empty() {
            tile.close();
            return;
        }
        job.camera.rays(&samples, want_differentials, &mut rays);
        for ((waiting, sample), ray) in waiting.drain(..).zip(&samples).zip(&rays) {
            waiting.finish(job, sample, ray.as_ref(), &all, tile, &mut workspace);
        }
        samples.clear();
    }
}

/// Repeats a dropped sample of `sampler` and returns where on its path it failed; `None` if there was no path. Samples
/// are pure functions of their dimensions, so nothing needs to be recorded for this.
pub fn locate(job: &RenderJob, sampler: &Sampler, dropped: DroppedSample) -> Option<Place> {
    let (sample, mut waiting) =
        PendingSample::new(job, sampler, dropped.pixel, dropped.sample as u32);
    let mut rays = ArrayVec::new();
    let want_differentials = job.world.needs_footprint();
    let samples: ArrayVec<CameraSample, BUNDLE> = [sample].into_iter().collect();
    job.camera.rays(&samples, want_differentials, &mut rays);
    let camera_ray: &CameraRay = rays.first()?.as_ref()?;
    let mut watch = Watch::default();
    let all = OfAll::new(job);
    job.integrator.radiance(
        &job.world,
        &waiting.camera_end(job, &sample, camera_ray, &all),
        camera_ray.scaled_differentials(all.spacing).as_ref(),
        &mut waiting.stream,
        &mut Workspace::default(),
        Some(&mut watch),
    );
    watch.offender()
}

/// What all samples of an image have in common.
struct OfAll {
    /// Spacing of a pixel's samples, in pixels: see [`RenderJob::footprint_spp`].
    spacing: f32,
    /// See [`RenderJob::paths_per_sample`].
    light_paths: f32,
}

impl OfAll {
    fn new(job: &RenderJob) -> OfAll {
        OfAll {
            spacing: 1.0 / (job.footprint_spp.max(1) as f32).sqrt(),
            light_paths: job.paths_per_sample(),
        }
    }
}

/// A sample whose camera ray has not been generated yet.
struct PendingSample {
    pixel: UVec2,
    stream: SampleStream,
    filter_weight: f32,
    film_density: f32,
}

impl PendingSample {
    /// Dimensions are used in the order film, time, lens (if the camera has one), wavelength (if it disperses), path.
    fn new(
        job: &RenderJob,
        sampler: &Sampler,
        pixel: UVec2,
        index: u32,
    ) -> (CameraSample, PendingSample) {
        let at = IVec2::new(pixel.x as i32, pixel.y as i32);
        let mut stream = sampler.stream(at, index);
        let on_film = job.filter.sample(stream.next_2d());
        let time = stream.next_1d();
        let sample = CameraSample {
            raster: pixel.as_vec2() + Vec2::splat(0.5) + on_film.offset,
            time,
            lens: if job.camera.has_lens() {
                stream.next_2d()
            } else {
                Vec2::splat(0.5)
            },
            wavelength: if job.camera.disperses() {
                stream.next_1d()
            } else {
                0.5
            },
        };
        let waiting = PendingSample {
            pixel,
            stream,
            filter_weight: on_film.weight,
            film_density: if job.integrator.traces_light() {
                job.filter.at(on_film.offset).0
            } else {
                1.0
            },
        };
        (sample, waiting)
    }

    fn camera_end<'a>(
        &self,
        job: &'a RenderJob,
        sample: &'a CameraSample,
        ray: &'a CameraRay,
        all: &OfAll,
    ) -> CameraEnd<'a> {
        CameraEnd {
            camera: &job.camera,
            sample,
            ray,
            film_density: self.film_density,
            light_paths: all.light_paths,
        }
    }

    fn finish(
        mut self,
        job: &RenderJob,
        sample: &CameraSample,
        ray: Option<&CameraRay>,
        all: &OfAll,
        tile: &mut Tile,
        workspace: &mut Workspace,
    ) {
        let Some(camera_ray) = ray else {
            tile.add_sample(self.pixel, Rgb::ZERO, 0.0);
            return;
        };
        let differentials = camera_ray.scaled_differentials(all.spacing);
        let end = self.camera_end(job, sample, camera_ray, all);
        let radiance = job.integrator.radiance(
            &job.world,
            &end,
            differentials.as_ref(),
            &mut self.stream,
            workspace,
            None,
        );
        let weight = camera_ray.tint * (camera_ray.weight * self.filter_weight);
        tile.add_colored_sample(self.pixel, radiance, weight);
    }
}
