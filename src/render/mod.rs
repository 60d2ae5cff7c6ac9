//! Rendering: the film in tiles, the tiles over threads, and for each pixel and sample a ray.
//!
//! A picture is a pure function of scene, settings and seed: every sample's numbers come from
//! (seed, pixel, sample index, dimension), pixels share nothing, and tiles are collected by
//! position. Threads and tile sizes change no bit of it.

mod progress;

pub use progress::Progress;

use crate::cameras::{BUNDLE, Camera, CameraRay, CameraSample};
use crate::film::{Film, FilmSpec, PixelBounds, Tile};
use crate::filters::Filter;
use crate::integrators::Integrator;
use crate::math::{IVec2, Rgb, UVec2, Vec2};
use crate::samplers::{SampleStream, Sampler};
use crate::world::World;
use arrayvec::ArrayVec;
use rayon::prelude::*;

/// Side of a tile in pixels: small enough to keep two cores busy to the end of a small picture,
/// large enough that handing out tiles costs nothing.
pub const TILE_SIZE: u32 = 16;

/// All that one picture needs.
pub struct Shot {
    /// What rays meet.
    pub world: World,
    /// Makes the rays.
    pub camera: Camera,
    /// Follows them.
    pub integrator: Integrator,
    /// Numbers for every sample.
    pub sampler: Sampler,
    /// Where in and around a pixel its samples fall.
    pub filter: Filter,
    /// The film.
    pub film: FilmSpec,
    /// Pixels to sample; those outside stay black.
    pub sampled: PixelBounds,
}

/// Renders the picture on the current rayon pool.
pub fn render(shot: &Shot, tile_size: u32, progress: &Progress) -> Film {
    let mut film = Film::new(&shot.film);
    let tiles: Vec<PixelBounds> = film
        .bounds()
        .intersection(shot.sampled)
        .tiles(tile_size)
        .collect();
    let blank = &film;
    let rendered: Vec<Tile> = tiles
        .into_par_iter()
        .map(|bounds| {
            let mut tile = blank.tile(bounds);
            sample_tile(shot, &mut tile, bounds);
            progress.advance(bounds.area() as u64 * u64::from(shot.sampler.spp()));
            tile
        })
        .collect();
    for tile in &rendered {
        film.merge(tile);
    }
    film
}

/// Takes all samples of a tile, a bundle of camera rays at a time.
fn sample_tile(shot: &Shot, tile: &mut Tile, bounds: PixelBounds) {
    let spp = shot.sampler.spp();
    // With more samples each stands for a smaller part of the pixel, and textures are filtered
    // over less (scene-language 3.1).
    let spacing = 1.0 / (spp as f32).sqrt();
    let want_differentials = shot.world.needs_footprint();
    let mut waiting = ArrayVec::<Waiting, BUNDLE>::new();
    let mut samples = ArrayVec::<CameraSample, BUNDLE>::new();
    let mut rays = ArrayVec::new();
    let mut indices = bounds
        .pixels()
        .flat_map(|pixel| (0..spp).map(move |index| (pixel, index)));
    loop {
        for (pixel, index) in indices.by_ref().take(BUNDLE) {
            let (sample, rest) = Waiting::new(shot, pixel, index);
            samples.push(sample);
            waiting.push(rest);
        }
        if samples.is_empty() {
            return;
        }
        shot.camera.rays(&samples, want_differentials, &mut rays);
        for (waiting, ray) in waiting.drain(..).zip(&rays) {
            waiting.finish(shot, ray.as_ref(), spacing, tile);
        }
        samples.clear();
    }
}

/// A sample whose ray is being made.
struct Waiting {
    pixel: UVec2,
    stream: SampleStream,
    filter_weight: f32,
}

impl Waiting {
    /// The numbers are used in the order film, time, lens, wavelength (of a camera that disperses), path.
    fn new(shot: &Shot, pixel: UVec2, index: u32) -> (CameraSample, Waiting) {
        let at = IVec2::new(pixel.x as i32, pixel.y as i32);
        let mut stream = shot.sampler.stream(at, index);
        let on_film = shot.filter.sample(stream.next_2d());
        let time = stream.next_1d();
        let sample = CameraSample {
            raster: pixel.as_vec2() + Vec2::splat(0.5) + on_film.offset,
            time,
            lens: stream.next_2d(),
            wavelength: if shot.camera.disperses() {
                stream.next_1d()
            } else {
                0.5
            },
        };
        let waiting = Waiting {
            pixel,
            stream,
            filter_weight: on_film.weight,
        };
        (sample, waiting)
    }

    fn finish(mut self, shot: &Shot, ray: Option<&CameraRay>, spacing: f32, tile: &mut Tile) {
        let Some(camera_ray) = ray else {
            tile.add_sample(self.pixel, Rgb::ZERO, 0.0);
            return;
        };
        let differentials = camera_ray
            .differentials
            .map(|d| d.scaled(&camera_ray.ray, spacing));
        let radiance = shot.integrator.radiance(
            &shot.world,
            camera_ray.ray,
            differentials.as_ref(),
            &mut self.stream,
        );
        let weight = camera_ray.tint * (camera_ray.weight * self.filter_weight);
        tile.add_coloured_sample(self.pixel, radiance, weight);
    }
}
