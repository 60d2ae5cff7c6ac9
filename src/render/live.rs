//! The picture as it grows, for those who look at it before it is done: `--display-server` and `--write-partial`.
//!
//! Workers add the blocks of samples that they finish, under a lock that is held while one tile is added or read: nobody
//! who looks holds it for longer, so nobody delays the render. The image itself is made elsewhere and does not depend on
//! any of this.

use crate::film::{Film, FilmSpec, Image, LayerSet, PixelBounds, PixelStatistics, Splats, Tile};
use crate::math::{DVec3, Rgb, UVec2};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Side of the squares of pixels in which changes are noted: larger than a tile, so that a picture takes few messages.
const SIDE: u32 = 64;

/// A picture that is being rendered. Shared by threads.
pub struct Live {
    resolution: UVec2,
    bounds: PixelBounds,
    scale: f64,
    picture: Mutex<Picture>,
}

/// What is known of it.
struct Picture {
    /// Camera samples; all in the first film where the image is not rendered in halves.
    halves: [Film; 2],
    /// What light paths have brought to each half's pixels, if any were traced.
    light: [Vec<DVec3>; 2],
    /// Squares of [`SIDE`] pixels, row by row, that have changed since they were last asked for.
    changed: Vec<bool>,
}

impl Live {
    /// A black picture, without layers.
    pub fn new(spec: &FilmSpec) -> Live {
        let film = Film::new(&FilmSpec {
            layers: LayerSet::NONE,
            ..spec.clone()
        });
        let bounds = film.bounds();
        Live {
            resolution: film.resolution(),
            bounds,
            scale: spec.scale.into(),
            picture: Mutex::new(Picture {
                halves: [film.clone(), film],
                light: [Vec::new(), Vec::new()],
                changed: vec![false; bounds.tiles(SIDE).count()],
            }),
        }
    }

    /// Width and height of the full image in pixels.
    pub fn resolution(&self) -> UVec2 {
        self.resolution
    }

    /// The pixels to be rendered.
    pub fn bounds(&self) -> PixelBounds {
        self.bounds
    }

    /// More samples of one half.
    pub fn add(&self, half: u8, tile: &Tile) {
        let mut picture = self.lock();
        picture.halves[usize::from(half & 1)].merge(tile.clone());
        self.touch(&mut picture.changed, tile.bounds());
    }

    /// All samples so far, where they are kept otherwise.
    pub fn replace(&self, film: Film) {
        let mut picture = self.lock();
        picture.halves[0] = film;
        picture.changed.fill(true);
    }

    /// All light of light paths so far of one half.
    pub fn light(&self, half: u8, splats: &Splats) {
        let light = self
            .bounds
            .pixels()
            .map(|pixel| splats.mean(pixel))
            .collect();
        let mut picture = self.lock();
        picture.light[usize::from(half & 1)] = light;
        picture.changed.fill(true);
    }

    /// Everything is to be shown again.
    pub fn touch_all(&self) {
        self.lock().changed.fill(true);
    }

    /// The squares of pixels that have changed since the last call.
    pub fn changes(&self) -> Vec<PixelBounds> {
        let mut picture = self.lock();
        let pairs = self.bounds.tiles(SIDE).zip(&mut picture.changed);
        pairs
            .filter_map(|(square, changed)| std::mem::take(changed).then_some(square))
            .collect()
    }

    /// The light of these pixels so far, as in the image, and how many samples they have.
    pub fn pixels(&self, bounds: PixelBounds) -> Vec<(Rgb, u64)> {
        let picture = self.lock();
        let one = |pixel| picture.pixel(self.bounds.index(pixel), pixel);
        let shown = |(light, samples): (DVec3, u64)| {
            let light = (light * self.scale).max(DVec3::ZERO).as_vec3();
            (light, samples)
        };
        bounds.pixels().map(|pixel| shown(one(pixel))).collect()
    }

    /// The picture so far, without variances, and its samples per pixel on average.
    pub fn image(&self) -> (Image, f64) {
        let mut image = Image::black(UVec2::ZERO);
        (image.resolution, image.bounds) = (self.resolution, self.bounds);
        image.pixels = vec![Rgb::ZERO; self.bounds.area()];
        let mut samples = 0;
        for square in self.bounds.tiles(SIDE) {
            for (pixel, (light, count)) in square.pixels().zip(self.pixels(square)) {
                samples += count;
                if let Some(index) = self.bounds.index(pixel) {
                    image.pixels[index] = light;
                }
            }
        }
        (image, samples as f64 / self.bounds.area().max(1) as f64)
    }

    fn touch(&self, changed: &mut [bool], tile: PixelBounds) {
        let columns = self.bounds.size().x.div_ceil(SIDE);
        let tile = tile.intersection(self.bounds);
        if tile.is_empty() {
            return;
        }
        let first = (tile.min - self.bounds.min) / SIDE;
        let last = (tile.max - UVec2::ONE - self.bounds.min) / SIDE;
        for row in first.y..=last.y {
            for column in first.x..=last.x {
                if let Some(square) = changed.get_mut((row * columns + column) as usize) {
                    *square = true;
                }
            }
        }
    }

    fn lock(&self) -> MutexGuard<'_, Picture> {
        // What a panic elsewhere leaves half added is shown so, and nothing more.
        self.picture.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Picture {
    /// The mean of the halves that have samples, and the number of these.
    fn pixel(&self, index: Option<usize>, pixel: UVec2) -> (DVec3, u64) {
        let has_samples = |own: &&PixelStatistics| own.count() > 0;
        let (mut sum, mut halves, mut samples) = (DVec3::ZERO, 0, 0);
        for (film, light) in self.halves.iter().zip(&self.light) {
            if let Some(own) = film.statistics(pixel).filter(has_samples) {
                let light = index.and_then(|index| light.get(index));
                sum += own.mean() + light.copied().unwrap_or_default();
                halves += 1;
                samples += own.count();
            }
        }
        (sum / f64::from(halves.max(1)), samples)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec() -> FilmSpec {
        FilmSpec {
            resolution: UVec2::new(150, 70),
            ..FilmSpec::default()
        }
    }

    #[test]
    fn what_is_added_is_told_once_and_shown_as_in_the_image() {
        let live = Live::new(&spec());
        assert!(live.changes().is_empty());
        let bounds = PixelBounds::new(UVec2::new(60, 0), UVec2::new(70, 10));
        let mut tile = spec().tile(bounds);
        for pixel in bounds.pixels() {
            tile.add_sample(pixel, Rgb::splat(0.5), 1.0);
        }
        tile.close();
        live.add(0, &tile);
        live.add(1, &tile);
        // It lies across the border of two squares, of three in a row.
        let squares = live.changes();
        assert_eq!(squares.iter().map(|s| s.min.x).collect::<Vec<_>>(), [0, 64]);
        assert!(live.changes().is_empty());
        let (light, samples) = live.pixels(bounds)[0];
        assert_eq!((light, samples), (Rgb::splat(0.5), 2));
        let (image, spp) = live.image();
        assert_eq!(image.pixel(UVec2::new(69, 9)), Rgb::splat(0.5));
        assert_eq!(image.pixel(UVec2::new(70, 9)), Rgb::ZERO);
        assert_eq!(spp, 200.0 / (150.0 * 70.0));
        live.touch_all();
        assert_eq!(live.changes().len(), 6);
    }
}
