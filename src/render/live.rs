//! The image as it grows, for those who look at it before it is done: `--display-server` and `--write-partial`.
//!
//! Workers add the blocks of samples that they finish, under a lock that is held while one tile is added or read: nobody
//! who looks holds it for longer, so nobody delays the render. The image itself is made elsewhere and does not depend on
//! any of this.

use crate::film::{
    Film, FilmSpec, GrowingLayers, Image, ImageLayers, PixelBounds, PixelStatistics, Splats, Tile,
};
use crate::math::{Rgb, UVec2};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Side of the squares of pixels in which changes are noted: larger than a tile, so that an image takes few messages.
const SIDE: u32 = 64;

/// An image that is being rendered, for those who look at it meanwhile. Shared by threads; looking changes nothing.
pub struct Live {
    resolution: UVec2,
    bounds: PixelBounds,
    scale: f32,
    picture: Mutex<Picture>,
}

/// What is known of it: 16 bytes a pixel, 32 in halves, 12 more for each that has light of light paths.
struct Picture {
    /// Camera samples; all in the first where the image is not rendered in halves. Empty until there are any.
    halves: [Vec<Shown>; 2],
    /// What light paths have brought to each half's pixels, if any were traced.
    light: [Vec<Rgb>; 2],
    /// How many they were.
    light_paths: [u64; 2],
    /// Of all samples, if the image has layers.
    layers: Option<GrowingLayers>,
    /// Squares of [`SIDE`] pixels, row by row, that have changed since they were last asked for.
    changed: Vec<bool>,
}

/// A pixel's samples, to look at: single precision will do.
#[derive(Clone, Copy, Default)]
struct Shown {
    mean: Rgb,
    count: u32,
}

impl Shown {
    fn of(samples: &PixelStatistics) -> Shown {
        Shown {
            mean: samples.mean().as_vec3(),
            count: samples.count().try_into().unwrap_or(u32::MAX),
        }
    }

    fn join(&mut self, more: Shown) {
        let count = self.count.saturating_add(more.count);
        if more.count > 0 {
            let share = more.count as f32 / count as f32;
            self.mean += (more.mean - self.mean) * share;
            self.count = count;
        }
    }
}

impl Live {
    /// A black image.
    pub(crate) fn new(spec: &FilmSpec) -> Live {
        let bounds = spec.pixel_bounds();
        Live {
            resolution: spec.resolution,
            bounds,
            scale: spec.scale,
            picture: Mutex::new(Picture {
                halves: [Vec::new(), Vec::new()],
                light: [Vec::new(), Vec::new()],
                light_paths: [0; 2],
                layers: GrowingLayers::new(spec),
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
    pub(crate) fn add(&self, half: u8, tile: &Tile) {
        let mut tile = tile.clone();
        tile.close();
        let mut picture = self.lock();
        let pixels = &mut picture.halves[usize::from(half & 1)];
        pixels.resize(self.bounds.area(), Shown::default());
        for (pixel, samples) in tile.iter() {
            if let Some(index) = self.bounds.index(pixel) {
                pixels[index].join(Shown::of(samples));
            }
        }
        if let Some(layers) = &mut picture.layers {
            layers.add(&tile);
        }
        self.touch(&mut picture.changed, tile.bounds());
    }

    /// All samples so far, where they are kept otherwise.
    pub(crate) fn replace(&self, film: Film) {
        let shown = film.pixels().iter().map(Shown::of).collect();
        let mut picture = self.lock();
        picture.halves[0] = shown;
        if let Some(layers) = &mut picture.layers {
            layers.replace(&film);
        }
        picture.changed.fill(true);
    }

    /// All light of light paths so far of one half, when they are one for each pixel, and whenever they are twice as many as when they were last shown: it takes
    /// longer than a tile.
    pub(crate) fn light_now_and_then(&self, half: u8, splats: &Splats) {
        let last = self.lock().light_paths[usize::from(half & 1)];
        if splats.paths().count() >= (2 * last).max(self.bounds.area() as u64) {
            self.light(half, splats);
        }
    }

    /// All light of light paths so far of one half.
    pub(crate) fn light(&self, half: u8, splats: &Splats) {
        let light = self
            .bounds
            .pixels()
            .map(|pixel| splats.mean(pixel).as_vec3())
            .collect();
        let mut picture = self.lock();
        picture.light[usize::from(half & 1)] = light;
        picture.light_paths[usize::from(half & 1)] = splats.paths().count();
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
        let shown = |pixel| {
            let (light, samples) = self.bounds.index(pixel).map(|i| picture.pixel(i))?;
            Some(((light * self.scale).max(Rgb::ZERO), samples))
        };
        let shown = |pixel| shown(pixel).unwrap_or_default();
        bounds.pixels().map(shown).collect()
    }

    /// The layers of these pixels so far, but for Cryptomattes and what light paths have brought to light groups.
    pub fn layers(&self, bounds: PixelBounds) -> ImageLayers {
        let picture = self.lock();
        let layers = picture.layers.as_ref();
        layers.map_or_else(ImageLayers::default, |layers| layers.pixels(bounds))
    }

    /// The image so far, without layers and variances, and its samples per pixel on average.
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
    fn pixel(&self, index: usize) -> (Rgb, u64) {
        let (mut sum, mut halves, mut samples) = (Rgb::ZERO, 0u8, 0);
        for (pixels, light) in self.halves.iter().zip(&self.light) {
            if let Some(own) = pixels.get(index).filter(|own| own.count > 0) {
                sum += own.mean + light.get(index).copied().unwrap_or_default();
                halves += 1;
                samples += u64::from(own.count);
            }
        }
        (sum / f32::from(halves.max(1)), samples)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::SplatBuffer;
    use crate::handles::LightLayer;

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

    /// Of 100, 200, … paths for 100 pixels those of 100, 200, 400 and 800 are shown.
    #[test]
    fn light_is_shown_when_there_is_twice_as_much() {
        let size = UVec2::new(10, 10);
        let spec = FilmSpec {
            resolution: size,
            ..FilmSpec::default()
        };
        let (live, pixels) = (Live::new(&spec), spec.pixel_bounds());
        let mut splats = Splats::new(pixels, 0, 0);
        let mut buffer = SplatBuffer::new(pixels, f32::INFINITY, false);
        buffer.begin(0);
        let (mut shown, light) = (Vec::new(), Rgb::ONE);
        for paths in (50..=1000).step_by(50) {
            buffer.push(paths, UVec2::ZERO, light, (LightLayer::default(), light));
            buffer.reach(paths);
            splats.add(&mut buffer);
            live.light_now_and_then(1, &splats);
            shown.extend((!live.changes().is_empty()).then_some(paths));
        }
        assert_eq!(shown, [100, 200, 400, 800]);
    }
}
