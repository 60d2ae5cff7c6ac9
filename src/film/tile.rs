//! A tile: the part of the film that one worker owns.

use super::layers::{
    CameraSample, LayerPixels, LayerSample, LayerSet, MatteId, RenderSpace, SurfaceSample,
    TileLayers,
};
use super::pairwise::{Join, PixelSum};
use super::{PixelBounds, PixelStatistics};
use crate::math::color::luminance;
use crate::math::{Rgb, UVec2};

/// Radiance with a luminance below this is an error rather than rounding (docs/scene-language.md §4.1).
const MAX_NEGATIVE_LUMINANCE: f32 = -1e-5;

/// A sample that was dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DroppedSample {
    /// Its pixel, in raster coordinates of the full image.
    pub pixel: UVec2,
    /// Index of the sample within the pixel, from 0.
    pub sample: u64,
}

impl DroppedSample {
    /// The one that comes first in the image, row by row, regardless of the order in which they occurred.
    pub fn first(a: Option<Self>, b: Option<Self>) -> Option<Self> {
        a.into_iter()
            .chain(b)
            .min_by_key(|d| (d.pixel.y, d.pixel.x, d.sample))
    }
}

/// The pixels of a rectangle while one thread renders them: samples are added without a lock, those of a pixel one after
/// the other (a pixel that is returned to has its parts pooled).
#[derive(Clone, Debug)]
pub struct Tile {
    bounds: PixelBounds,
    max_sample_luminance: f32,
    first_sample: u64,
    pub(super) pixels: Vec<PixelStatistics>,
    /// The pixel whose samples are being added, and those.
    open: usize,
    sum: PixelSum,
    /// Where any are wanted; not part of the tile, which is moved.
    pub(super) layers: Option<Box<TileLayers>>,
    pub(super) dropped: u64,
    pub(super) first_dropped: Option<DroppedSample>,
}

impl Tile {
    /// An empty tile. Samples brighter than `max_sample_luminance` are scaled down to it; infinite for no limit.
    pub fn new(bounds: PixelBounds, max_sample_luminance: f32) -> Tile {
        let pixels = vec![PixelStatistics::default(); bounds.area()];
        Tile {
            bounds,
            max_sample_luminance,
            first_sample: 0,
            pixels,
            open: 0,
            sum: PixelSum::default(),
            layers: None,
            dropped: 0,
            first_dropped: None,
        }
    }

    /// The same tile for pixels that already have this many samples elsewhere: its own are counted from there.
    pub fn after(self, first_sample: u64) -> Tile {
        Tile {
            first_sample,
            ..self
        }
    }

    /// The same tile, empty, with these layers.
    pub fn with_layers(self, set: LayerSet) -> Tile {
        Tile {
            layers: TileLayers::new(set, self.bounds.area()),
            ..self
        }
    }

    /// Returns `true` if layers are wanted of every sample.
    #[inline(always)]
    pub fn has_layers(&self) -> bool {
        self.layers.is_some()
    }

    /// How many layers of light are wanted.
    pub fn lights(&self) -> usize {
        { self.layers.as_ref() }.map_or(0, |layers| layers.pixels.set.lights())
    }

    /// Adds what layers tell of a sample to `pixel`: `None` for one whose ray does not leave the
    /// lens, `Some(None)` for one that meets nothing. `weight` is the filter's.
    /// `lights` is what it brings to the pixel, by layers of light.
    #[inline(always)]
    pub fn add_layers(
        &mut self,
        pixel: UVec2,
        weight: f32,
        sample: Option<Option<&LayerSample>>,
        lights: &[Rgb],
    ) {
        if let Some(layers) = &mut self.layers {
            layers.open(pixel, || self.bounds.index(pixel));
            layers.add(weight, sample, lights);
        }
    }

    /// Adds samples of a pixel that have met the same with this weight, and bring no light to layers of their own: its mattes, and where its points are.
    /// Each with what the camera tells of it, where it tells anything.
    #[inline(always)]
    pub fn add_run_of_layers<'a>(
        &mut self,
        pixel: UVec2,
        weight: f32,
        (mattes, space): ([MatteId; 2], &RenderSpace),
        samples: impl Iterator<Item = (&'a SurfaceSample, Option<CameraSample>)>,
    ) {
        if let Some(layers) = &mut self.layers {
            layers.open(pixel, || self.bounds.index(pixel));
            layers.begin_run(weight, mattes, space);
            layers.add_run(samples);
        }
    }

    /// The sums of its layers, if there are any, as [`Tile::statistics`].
    pub(super) fn layers(&self) -> Option<&LayerPixels> {
        self.layers.as_ref().map(|layers| &layers.pixels)
    }

    /// Samples of this pixel follow.
    #[inline(always)]
    fn open(&mut self, index: usize) {
        if index != self.open {
            self.close_pixel();
            self.open = index;
        }
    }

    /// The pixels of this tile.
    pub fn bounds(&self) -> PixelBounds {
        self.bounds
    }

    /// Adds a sample to `pixel` (full-image raster coordinates; ignored outside the tile).
    ///
    /// `radiance` is the integrator's estimate; `weight` is everything that multiplies it on the way to the pixel: the
    /// camera's weight times the filter's (±1 for filters with negative lobes). A vignetted sample is black: radiance
    /// or weight 0.
    ///
    /// `maxsampleluminance` limits the radiance, before the weight, as in pbrt-v3. A sample that is not finite, or
    /// whose luminance is below −1e-5, is counted as black and as dropped; the return value is then `false`.
    pub fn add_sample(&mut self, pixel: UVec2, radiance: Rgb, weight: f32) -> bool {
        self.add_colored_sample(pixel, radiance, Rgb::splat(weight))
    }

    /// Like [`add_sample`](Self::add_sample), with a weight per channel.
    #[inline(always)]
    pub fn add_colored_sample(&mut self, pixel: UVec2, radiance: Rgb, weight: Rgb) -> bool {
        let Some(index) = self.bounds.index(pixel) else {
            return true;
        };
        self.open(index);
        let value = self.counted(radiance, weight);
        if value.is_none() {
            self.drop_next(pixel);
        }
        self.sum.add(value.unwrap_or(Rgb::ZERO));
        value.is_some()
    }

    /// What a sample counts for; `None` if it is dropped.
    #[inline(always)]
    fn counted(&self, radiance: Rgb, weight: Rgb) -> Option<Rgb> {
        let y = luminance(radiance);
        let limited = if y > self.max_sample_luminance {
            radiance * (self.max_sample_luminance / y)
        } else {
            radiance
        };
        let value = limited * weight;
        let good = radiance.is_finite() && value.is_finite() && y >= MAX_NEGATIVE_LUMINANCE;
        good.then_some(value)
    }

    /// What a part of this radiance counts for, as a factor.
    pub fn factor_of_parts(&self, radiance: Rgb, weight: Rgb) -> Rgb {
        let y = luminance(radiance);
        match self.counted(radiance, weight) {
            None => Rgb::ZERO,
            Some(_) if y > self.max_sample_luminance => weight * (self.max_sample_luminance / y),
            Some(_) => weight,
        }
    }

    /// Number of samples counted as black because they were not finite or clearly negative.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// The first of them.
    pub fn first_dropped(&self) -> Option<DroppedSample> {
        self.first_dropped
    }

    #[cold]
    fn drop_next(&mut self, pixel: UVec2) {
        let pooled = self.pixels.get(self.open).map_or(0, |p| p.count());
        let sample = self.first_sample + pooled + self.sum.count();
        let dropped = Some(DroppedSample { pixel, sample });
        self.first_dropped = DroppedSample::first(self.first_dropped, dropped);
        self.dropped += 1;
    }

    /// Pools what has been added to the last pixel.
    pub fn close(&mut self) {
        self.close_pixel();
        if let Some(layers) = &mut self.layers {
            layers.close();
        }
    }

    #[inline(never)]
    fn close_pixel(&mut self) {
        if let Some(pixel) = self.pixels.get_mut(self.open) {
            pixel.join(&self.sum.take());
        }
    }

    /// The statistics of one pixel, `None` outside. The last pixel's samples are missing until [`Tile::close`].
    pub fn statistics(&self, pixel: UVec2) -> Option<&PixelStatistics> {
        self.pixels.get(self.bounds.index(pixel)?)
    }

    /// Every pixel with its statistics, row by row, as [`Tile::statistics`].
    pub fn iter(&self) -> impl Iterator<Item = (UVec2, &PixelStatistics)> {
        self.bounds.pixels().zip(&self.pixels)
    }
}

impl Join for Tile {
    /// Pools the samples of each pixel; both tiles are closed.
    fn join(&mut self, right: &Tile) {
        for (pixel, statistics) in self.pixels.iter_mut().zip(&right.pixels) {
            pixel.join(statistics);
        }
        if let (Some(own), Some(right)) = (&mut self.layers, &right.layers) {
            own.pixels.join(&right.pixels);
        }
        self.dropped = self.dropped.saturating_add(right.dropped);
        self.first_dropped = DroppedSample::first(self.first_dropped, right.first_dropped);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tile(limit: f32) -> Tile {
        Tile::new(PixelBounds::new(UVec2::new(2, 3), UVec2::new(4, 5)), limit)
    }

    #[test]
    fn luminance_is_limited_before_the_weight() {
        let p = UVec2::new(2, 3);
        let mut t = tile(1.0);
        assert!(t.add_sample(p, Rgb::splat(10.0), 3.0));
        t.close();
        // Luminance 10 becomes 1, then times 3; the luminance weights sum to 1 within 1e-6.
        assert!((t.statistics(p).unwrap().mean().x - 3.0).abs() < 1e-5);
        let mut t = tile(1.0);
        t.add_sample(p, Rgb::splat(0.5), 30.0);
        t.close();
        assert_eq!(t.statistics(p).unwrap().mean().x, 15.0);
    }

    #[test]
    fn bad_samples_are_black_and_counted() {
        let p = UVec2::new(3, 4);
        let mut t = tile(f32::INFINITY);
        for bad in [
            Rgb::NAN,
            Rgb::INFINITY,
            Rgb::new(0.0, f32::NEG_INFINITY, 0.0),
            Rgb::splat(-1e-3),
        ] {
            assert!(!t.add_sample(p, bad, 1.0));
        }
        assert!(!t.add_sample(p, Rgb::ONE, f32::NAN));
        assert!(!t.add_sample(p, Rgb::splat(f32::MAX), 2.0));
        assert!(t.add_sample(p, Rgb::splat(-1e-6), 1.0));
        assert!(t.add_sample(p, Rgb::splat(7.0), -1.0));
        assert_eq!(t.dropped(), 6);
        let first = |pixel, sample| Some(DroppedSample { pixel, sample });
        assert_eq!(t.first_dropped(), first(p, 0));
        let earlier = UVec2::new(2, 4);
        t.add_sample(earlier, Rgb::ONE, 1.0);
        t.add_sample(earlier, Rgb::NAN, 1.0);
        assert_eq!(t.first_dropped(), first(earlier, 1));
        t.close();
        let s = t.statistics(p).unwrap();
        assert_eq!(s.count(), 8);
        // (−1e-6 − 7) / 8, to single precision of the two samples.
        assert!((s.mean().x + 7.000_001 / 8.0).abs() < 1e-7);
    }

    #[test]
    fn samples_outside_are_ignored() {
        let mut t = tile(f32::INFINITY);
        t.add_sample(UVec2::new(1, 3), Rgb::ONE, 1.0);
        t.add_sample(UVec2::new(2, 5), Rgb::ONE, 1.0);
        t.close();
        assert!(t.iter().all(|(_, s)| s.count() == 0));
    }
}
