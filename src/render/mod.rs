//! Rendering: the film in tiles, the tiles over threads, and for each pixel and sample a ray.
//!
//! A picture is a pure function of scene, settings and seed: every sample's numbers come from
//! (seed, pixel, sample index, dimension), pixels share nothing, and tiles are collected by
//! position. Threads and tile sizes change no bit of it.

mod progress;

pub use progress::Progress;

use crate::cameras::{Camera, CameraSample};
use crate::film::{Film, FilmSpec, PixelBounds, Tile};
use crate::filters::Filter;
use crate::integrators::Integrator;
use crate::math::{IVec2, UVec2, Vec2};
use crate::samplers::Sampler;
use crate::world::World;
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
            for pixel in bounds.pixels() {
                sample_pixel(shot, pixel, &mut tile);
            }
            progress.advance(bounds.area() as u64 * u64::from(shot.sampler.spp()));
            tile
        })
        .collect();
    for tile in &rendered {
        film.merge(tile);
    }
    film
}

/// Takes all samples of one pixel. The numbers are used in the order film, time, lens, path.
fn sample_pixel(shot: &Shot, pixel: UVec2, tile: &mut Tile) {
    let spp = shot.sampler.spp();
    // With more samples each stands for a smaller part of the pixel, and textures are filtered
    // over less (scene-language 3.1).
    let spacing = 1.0 / (spp as f32).sqrt();
    let want_differentials = shot.world.needs_footprint();
    let centre = pixel.as_vec2() + Vec2::splat(0.5);
    for index in 0..spp {
        let mut stream = shot
            .sampler
            .stream(IVec2::new(pixel.x as i32, pixel.y as i32), index);
        let on_film = shot.filter.sample(stream.next_2d());
        let time = stream.next_1d();
        let lens = stream.next_2d();
        let sample = CameraSample {
            raster: centre + on_film.offset,
            time,
            lens,
        };
        let Some(camera_ray) = shot.camera.ray(&sample, want_differentials) else {
            tile.add_sample(pixel, crate::math::Rgb::ZERO, 0.0);
            continue;
        };
        let differentials = camera_ray
            .differentials
            .map(|d| d.scaled(&camera_ray.ray, spacing));
        let radiance = shot.integrator.radiance(
            &shot.world,
            camera_ray.ray,
            differentials.as_ref(),
            &mut stream,
        );
        tile.add_sample(pixel, radiance, camera_ray.weight * on_film.weight);
    }
}
