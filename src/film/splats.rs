//! Splats: what paths from the lights bring to pixels, wherever on the film they end.
//!
//! They come in any order, from any thread, process or machine, so their sums are integers: fixed point, wide enough for
//! every image, which adds up to the same bits however it is done. The point is placed for each image by its
//! [scale](Splats::new), about what one path brings.

use super::PixelBounds;
use super::path_set::PathSet;
use crate::handles::LightLayer;
use crate::math::color::luminance;
use crate::math::{Rgb, UVec2};
use glam::DVec3;
use std::ops::Range;

/// Bits of a sum behind the point: a contribution of 2⁻¹² of the scale keeps all digits of a float. There is more room
/// above, for fireflies, and because most of a large scene may be far from its lights.
const FRACTION: i32 = 36;

/// The largest contribution, as a power of two of a sum's unit (2⁵¹ of the scale): 2⁴⁰ of them fit into 128 bits with a
/// sign. What is larger counts as this.
const LARGEST: u32 = 87;

/// Bits of a sum of squares behind the point. Nothing is negative here, so that a sum that does not fit may stay at the
/// largest number, and still be that of any order.
const FRACTION_OF_SQUARE: i32 = 36;

/// The farthest that the point is moved either way: lights up to 2¹⁰⁰ times as strong as 1.
const MAX_SCALE: i32 = 100;

/// Bytes that a pixel's splats take.
pub(crate) const MEMORY_OF_SPLATS: u64 = size_of::<Sums>() as u64;

/// Bytes of the buffer in which a thread collects them.
pub(crate) const MEMORY_OF_SPLAT_BUFFER: u64 = (SplatBuffer::ROOM * size_of::<(u32, Rgb)>()) as u64;

/// Contributions to one pixel: their sum and that of their squares.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Sums {
    pub(super) values: [i128; 3],
    pub(super) squares: [u128; 3],
}

/// A splat that was dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DroppedSplat {
    /// Number of the light path, from 0.
    pub path: u64,
    /// Its pixel, in raster coordinates of the full image.
    pub pixel: UVec2,
}

impl DroppedSplat {
    /// That of the first path, in order of rows, regardless of the order in which they occurred.
    pub(super) fn first(a: Option<Self>, b: Option<Self>) -> Option<Self> {
        let both = a.into_iter().chain(b);
        both.min_by_key(|d| (d.path, d.pixel.y, d.pixel.x))
    }
}

/// Sums of splats, and which light paths they are of.
#[derive(Clone, Debug, PartialEq)]
pub struct Splats {
    bounds: PixelBounds,
    scale: i32,
    /// All of them, then those of each layer of light.
    pub(super) pixels: Vec<Sums>,
    pub(super) paths: PathSet,
    pub(super) dropped: u64,
    pub(super) first_dropped: Option<DroppedSplat>,
}

/// What a few paths bring, on its way to the sums.
#[derive(Debug)]
pub struct SplatBuffer {
    bounds: PixelBounds,
    has_layers: bool,
    max_luminance: f32,
    splats: Vec<(u32, Rgb)>,
    /// The last one may grow.
    paths: Vec<Range<u64>>,
    dropped: u64,
    first_dropped: Option<DroppedSplat>,
}

impl Splats {
    /// None yet, for these pixels. 2^`scale` is about what one path brings to a pixel if it brings anything; 2³⁰
    /// times more or 2¹⁰ times less does no harm. They are kept in so many layers of light besides.
    pub fn new(bounds: PixelBounds, scale: i32, lights: usize) -> Splats {
        Splats {
            bounds,
            scale: scale.clamp(-MAX_SCALE, MAX_SCALE),
            pixels: vec![Sums::default(); bounds.area() * (1 + lights)],
            paths: PathSet::default(),
            dropped: 0,
            first_dropped: None,
        }
    }

    /// The pixels.
    pub fn bounds(&self) -> PixelBounds {
        self.bounds
    }

    /// The paths whose splats are here.
    pub fn paths(&self) -> &PathSet {
        &self.paths
    }

    /// Number of splats that were not finite; each counts as nothing.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// The first of them.
    pub fn first_dropped(&self) -> Option<DroppedSplat> {
        self.first_dropped
    }

    /// Adds what is in `buffer`, unless its paths are here already, and empties it.
    pub fn add(&mut self, buffer: &mut SplatBuffer) {
        let is_new = self.paths.insert_all(&buffer.paths);
        let next = buffer.paths.last().map_or(0, |last| last.end);
        buffer.begin(next);
        for (index, splat) in buffer.splats.drain(..).filter(|_| is_new) {
            if let Some(sums) = self.pixels.get_mut(index as usize) {
                sums.add(splat, self.scale);
            }
        }
        let dropped = std::mem::take(&mut buffer.dropped);
        let first = buffer.first_dropped.take();
        if is_new {
            self.dropped = self.dropped.saturating_add(dropped);
            self.first_dropped = DroppedSplat::first(self.first_dropped, first);
        }
    }

    /// The mean of what a path brings to a pixel; 0 without paths.
    pub fn mean(&self, pixel: UVec2) -> DVec3 {
        self.mean_of(self.sums(pixel))
    }

    /// The same of the light in a layer.
    pub fn mean_of_layer(&self, pixel: UVec2, layer: usize) -> DVec3 {
        self.mean_of(self.sums_of_part(pixel, 1 + layer))
    }

    fn mean_of(&self, sums: Sums) -> DVec3 {
        let count = self.paths.count().max(1) as f64;
        let unit = power_of_two(self.scale - FRACTION);
        DVec3::from(sums.values.map(|sum| sum as f64)) * unit / count
    }

    /// The variance of [`mean`](Self::mean): Σx²/N less the mean's square, over N − 1, as of independent paths that each
    /// come to the pixel once. Well-distributed paths do better; those that come several times, which are rare, do
    /// worse. Infinite for one path, which says nothing about variance.
    pub fn variance_of_mean(&self, pixel: UVec2) -> DVec3 {
        let count = self.paths.count() as f64;
        if count <= 1.0 {
            return DVec3::INFINITY;
        }
        let unit = power_of_two(2 * self.scale - FRACTION_OF_SQUARE);
        let squares = self.sums(pixel).squares.map(|sum| sum as f64);
        let (mean, squares) = (self.mean(pixel), DVec3::from(squares) * unit / count);
        (squares - mean * mean).max(DVec3::ZERO) / (count - 1.0)
    }

    /// Nothing, outside.
    fn sums(&self, pixel: UVec2) -> Sums {
        self.sums_of_part(pixel, 0)
    }

    /// Of all light, or of that in a layer.
    fn sums_of_part(&self, pixel: UVec2, part: usize) -> Sums {
        let index = self.bounds.index(pixel);
        let place = |index: usize| index + part * self.bounds.area();
        let sums = index.and_then(|index| self.pixels.get(place(index)));
        sums.copied().unwrap_or_default()
    }
}

impl Sums {
    /// Adds a contribution; `scale` is that of the image.
    fn add(&mut self, value: Rgb, scale: i32) {
        for channel in 0..3 {
            let (digits, exponent) = digits(value[channel]);
            let units = shifted(digits.into(), exponent + FRACTION - scale, LARGEST);
            let signed = if value[channel] < 0.0 {
                -(units as i128)
            } else {
                units as i128
            };
            let square = u64::from(digits) * u64::from(digits);
            let exponent = 2 * (exponent - scale) + FRACTION_OF_SQUARE;
            let square = shifted(square, exponent, 128);
            self.values[channel] = self.values[channel].saturating_add(signed);
            self.squares[channel] = self.squares[channel].saturating_add(square);
        }
    }

    /// Adds other contributions.
    pub(super) fn join(&mut self, other: &Sums) {
        for channel in 0..3 {
            self.values[channel] = self.values[channel].saturating_add(other.values[channel]);
            self.squares[channel] = self.squares[channel].saturating_add(other.squares[channel]);
        }
    }
}

impl SplatBuffer {
    /// Splats in a full buffer: 1 MiB of them.
    const FULL: usize = 1 << 16;

    /// Room for what comes between two looks at it, so that no path makes it grow, unless it brings very much.
    const ROOM: usize = 2 * SplatBuffer::FULL;

    /// Ranges of path numbers in a full buffer.
    const FULL_OF_RANGES: usize = 1 << 8;

    /// For the pixels of some [`Splats`]. Contributions brighter than `max_luminance` are scaled down to it.
    pub fn new(bounds: PixelBounds, max_luminance: f32, has_layers: bool) -> SplatBuffer {
        SplatBuffer {
            bounds,
            has_layers,
            max_luminance,
            splats: Vec::with_capacity(SplatBuffer::ROOM),
            paths: Vec::with_capacity(2 * SplatBuffer::FULL_OF_RANGES),
            dropped: 0,
            first_dropped: None,
        }
    }

    /// Returns `true` if it is to be emptied.
    pub fn is_full(&self) -> bool {
        self.splats.len() >= SplatBuffer::FULL || self.paths.len() >= SplatBuffer::FULL_OF_RANGES
    }

    /// Paths from number `first` follow; the buffer is empty.
    pub fn begin(&mut self, first: u64) {
        self.paths.clear();
        self.paths.push(first..first);
    }

    /// Adds what a path brings to a pixel: its filter's weight and all else in it, but for the number of paths. Nothing
    /// outside the film. A value that is not finite counts as dropped. `part` is what it counts for in a layer of light, where there are any.
    #[inline]
    pub fn push(&mut self, path: u64, pixel: UVec2, value: Rgb, part: (LightLayer, Rgb)) {
        let Some(index) = self.bounds.index(pixel) else {
            return;
        };
        if !value.is_finite() {
            self.dropped += 1;
            let this = Some(DroppedSplat { path, pixel });
            self.first_dropped = DroppedSplat::first(self.first_dropped, this);
            return;
        }
        let y = luminance(value);
        let factor = match y > self.max_luminance {
            true => self.max_luminance / y,
            false => 1.0,
        };
        self.splats.push((index as u32, value * factor));
        let (layer, part) = part;
        if self.has_layers && part.is_finite() {
            let place = index + (1 + layer.index()) * self.bounds.area();
            self.splats.push((place as u32, part * factor));
        }
    }

    /// All paths before number `end` have been traced.
    pub fn reach(&mut self, end: u64) {
        if let Some(last) = self.paths.last_mut() {
            last.end = end;
        }
    }

    /// This path has been traced. They may come in any order, each once.
    pub fn add_path(&mut self, path: u64) {
        match self.paths.last_mut() {
            Some(last) if last.end == path => last.end += 1,
            _ => self.paths.push(path..path + 1),
        }
    }
}

/// The digits of a finite number's magnitude as an integer, and the power of two that they count.
fn digits(x: f32) -> (u32, i32) {
    let bits = x.to_bits();
    let exponent = bits >> 23 & 0xff;
    let leading = u32::from(exponent > 0) << 23;
    (bits & 0x7f_ffff | leading, exponent.max(1) as i32 - 150)
}

/// `digits` × 2^`exponent`, rounded to a whole number and at most 2^`most` − 1. All in integers, which is as fast as it is the
/// same everywhere.
fn shifted(digits: u64, exponent: i32, most: u32) -> u128 {
    let length = u64::BITS - digits.leading_zeros();
    if exponent < 0 {
        // A right shift by 63 leaves nothing of 48 digits, even rounded.
        let down = exponent.unsigned_abs().min(63);
        return (((digits >> (down - 1)) + 1) >> 1).into();
    }
    match length == 0 || exponent as u32 <= most - length {
        true => u128::from(digits) << exponent.min(127),
        false => u128::MAX >> (128 - most),
    }
}

/// 2ⁿ; n within what doubles have without losing digits.
fn power_of_two(n: i32) -> f64 {
    f64::from_bits(((1023 + n.clamp(-1022, 1023)) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::splat_variances::SplatVariances;
    use crate::film::{Film, FilmSpec};

    fn bounds() -> PixelBounds {
        PixelBounds::new(UVec2::new(3, 5), UVec2::new(10, 9))
    }

    /// What path `i` brings, and where: magnitudes from 2⁻³⁰ to 2²⁰ of both signs.
    fn splat(i: u64) -> (UVec2, Rgb) {
        let phase = (i as f32 * 0.618_034).fract();
        let pixel = UVec2::new(3 + (i * 5 % 7) as u32, 5 + (i * 3 % 4) as u32);
        let strength = (50.0 * phase - 30.0).exp2();
        let sign = if i.is_multiple_of(7) { -0.1 } else { 1.0 };
        (pixel, Rgb::new(1.0, 0.3, phase) * (sign * strength))
    }

    fn trace(paths: Range<u64>, splats: &mut Splats) {
        let mut buffer = SplatBuffer::new(splats.bounds(), f32::INFINITY, false);
        buffer.begin(paths.start);
        for i in paths.clone() {
            let (pixel, value) = splat(i);
            buffer.push(i, pixel, value, (LightLayer::default(), value));
        }
        buffer.reach(paths.end);
        splats.add(&mut buffer);
    }

    fn traced(paths: Range<u64>, scale: i32) -> Splats {
        let mut splats = Splats::new(bounds(), scale, 0);
        trace(paths, &mut splats);
        splats
    }

    #[test]
    fn any_order_makes_the_same_bits() {
        let whole = traced(0..5000, 2);
        for parts in [1, 7, 100] {
            let mut sum = Splats::new(bounds(), 2, 0);
            let ranges = (0..parts).map(|i| 5000 * i / parts..5000 * (i + 1) / parts);
            let mut ranges: Vec<Range<u64>> = ranges.collect();
            ranges.sort_by_key(|range| range.start * 617 % 5003);
            for range in ranges {
                trace(range, &mut sum);
            }
            assert_eq!(sum, whole);
        }
    }

    /// As doubles add it up, to the digits of the sum's unit.
    #[test]
    fn layers_of_light_add_up_to_all() {
        let mut splats = Splats::new(bounds(), 2, 3);
        let mut buffer = SplatBuffer::new(bounds(), f32::INFINITY, true);
        buffer.begin(0);
        for i in 0..1000 {
            let (pixel, value) = splat(i);
            buffer.push(i, pixel, value, (LightLayer((i / 28 % 2) as u8), value));
        }
        buffer.reach(1000);
        splats.add(&mut buffer);
        for pixel in bounds().pixels() {
            let of = |layer| splats.mean_of_layer(pixel, layer);
            // Sums of integers, of which doubles keep 53 bits.
            let off = of(0) + of(1) - splats.mean(pixel);
            assert!(off.abs().max_element() <= 1e-15 * splats.mean(pixel).abs().max_element());
            assert_eq!(of(2), DVec3::ZERO);
            assert_ne!(of(1), DVec3::ZERO);
        }
    }

    #[test]
    fn means_and_variances_are_those_of_what_paths_bring() {
        let n = 5000;
        for scale in [-18, 2, 18] {
            let splats = traced(0..n, scale);
            for pixel in bounds().pixels() {
                let here = |i: u64| Some(splat(i)).filter(|s| s.0 == pixel);
                let all = || (0..n).filter_map(here).map(|s| s.1.as_dvec3());
                let mean = all().sum::<DVec3>() / n as f64;
                let squares = all().map(|x| x * x).sum::<DVec3>() / n as f64;
                let variance = (squares - mean * mean) / (n as f64 - 1.0);
                let found = splats.mean(pixel);
                let found_variance = splats.variance_of_mean(pixel);
                // Half a unit, 2⁻³⁷ of the scale, of each of at most 5000 / 28 splats; doubles round them, too.
                let unit = 2f64.powi(scale - FRACTION);
                let error = (found - mean).abs();
                assert!(error.max_element() < unit + 1e-13 * squares.max_element().sqrt());
                // Squares are exact to 2⁻³⁶ of the scale's.
                let error = (found_variance - variance).abs();
                let unit = 2f64.powi(2 * scale - FRACTION_OF_SQUARE);
                assert!(error.max_element() < unit + 1e-12 * variance.max_element());
            }
        }
    }

    #[test]
    fn too_much_light_stays_the_most_there_is() {
        let mut splats = Splats::new(bounds(), 0, 0);
        let pixel = UVec2::new(3, 5);
        for i in 0..100 {
            let mut buffer = SplatBuffer::new(splats.bounds(), f32::INFINITY, false);
            buffer.begin(i);
            buffer.push(
                i,
                pixel,
                Rgb::new(f32::MAX, -f32::MAX, 1.0),
                (LightLayer::default(), Rgb::ONE),
            );
            buffer.reach(i + 1);
            splats.add(&mut buffer);
        }
        let (mean, variance) = (splats.mean(pixel), splats.variance_of_mean(pixel));
        // The next smaller number has no double of its own.
        let most = 2f64.powi(LARGEST as i32 - FRACTION);
        assert_eq!(mean, DVec3::new(most, -most, 1.0));
        assert!(variance.is_finite() && variance.z == 0.0);
        // As many as there will ever be.
        let mut sums = Sums::default();
        let large = Sums {
            values: [i128::MAX - 5, i128::MIN + 5, 0],
            squares: [u128::MAX - 5, 0, 0],
        };
        (0..3).for_each(|_| sums.join(&large));
        assert_eq!(sums.values, [i128::MAX, i128::MIN, 0]);
        assert_eq!(sums.squares, [u128::MAX, 0, 0]);
    }

    #[test]
    fn fixed_point_is_the_number_rounded() {
        let mantissas = [0, 1, 0x40_0000, 0x7f_ffff, 0x2a_aaaa];
        for bits in mantissas
            .map(|m| (0..255u32).map(move |e| e << 23 | m))
            .into_iter()
            .flatten()
        {
            let x = f32::from_bits(bits);
            let (digits, exponent) = digits(x);
            assert_eq!(f64::from(digits) * 2f64.powi(exponent), f64::from(x));
            for scale in [-100, -3, 0, 100] {
                let exact = f64::from(x) * 2f64.powi(FRACTION - scale);
                let rounded = (exact + 0.5).floor().min(2f64.powi(LARGEST as i32) - 1.0);
                let found = shifted(digits.into(), exponent + FRACTION - scale, LARGEST);
                assert_eq!(found as f64, rounded, "{x:e} {scale}");
                let exact = f64::from(x) * f64::from(x) * 2f64.powi(36 - 2 * scale);
                let square = u64::from(digits) * u64::from(digits);
                let found = shifted(square, 2 * (exponent - scale) + 36, 128);
                assert_eq!(
                    found as f64,
                    (exact + 0.5).floor().min(u128::MAX as f64),
                    "{x:e}"
                );
            }
        }
    }

    #[test]
    fn paths_count_once_and_only_for_their_pixels() {
        let mut splats = traced(0..100, 2);
        let before = splats.clone();
        let mut buffer = SplatBuffer::new(splats.bounds(), f32::INFINITY, false);
        buffer.begin(50);
        buffer.push(
            50,
            UVec2::new(3, 5),
            Rgb::ONE,
            (LightLayer::default(), Rgb::ONE),
        );
        buffer.reach(51);
        splats.add(&mut buffer);
        buffer.begin(100);
        buffer.push(
            100,
            UVec2::new(2, 5),
            Rgb::ONE,
            (LightLayer::default(), Rgb::ONE),
        );
        splats.add(&mut buffer);
        assert_eq!(splats, before);
    }

    #[test]
    fn broken_splats_are_counted_and_located_and_bright_ones_limited() {
        let mut splats = Splats::new(bounds(), 0, 0);
        let mut buffer = SplatBuffer::new(splats.bounds(), 4.0, false);
        let (a, b) = (UVec2::new(4, 6), UVec2::new(5, 5));
        buffer.begin(0);
        buffer.push(0, a, Rgb::splat(8.0), (LightLayer::default(), Rgb::ONE));
        buffer.push(1, a, Rgb::NAN, (LightLayer::default(), Rgb::ONE));
        buffer.push(
            1,
            b,
            Rgb::new(0.0, f32::NEG_INFINITY, 0.0),
            (LightLayer::default(), Rgb::ONE),
        );
        buffer.push(
            2,
            b,
            Rgb::new(-1.0, 0.0, 0.0),
            (LightLayer::default(), Rgb::ONE),
        );
        buffer.reach(4);
        splats.add(&mut buffer);
        assert_eq!(splats.dropped(), 2);
        let first = DroppedSplat { path: 1, pixel: b };
        assert_eq!(splats.first_dropped(), Some(first));
        // 4 of four paths, to the rounding of luminance's three factors.
        assert!((splats.mean(a) - 1.0).abs().max_element() < 1e-6);
        assert_eq!(splats.mean(b).x, -0.25);
    }

    /// A film has the light of both, and the variances of both.
    #[test]
    fn light_is_added_to_pixels_that_are_sampled() {
        let spec = FilmSpec {
            resolution: UVec2::new(20, 20),
            scale: 2.0,
            ..FilmSpec::default()
        };
        let mut film = Film::new(&spec);
        let mut tile = spec.tile(PixelBounds::new(UVec2::new(4, 6), UVec2::new(5, 7)));
        let pixel = UVec2::new(4, 6);
        for x in [1.0, 3.0] {
            tile.add_sample(pixel, Rgb::splat(x), 1.0);
        }
        film.merge(tile);
        let splats = traced(0..1000, 0);
        film.add_light(std::slice::from_ref(&splats));
        let (mean, variance) = (splats.mean(pixel), SplatVariances::new(&splats).at(pixel));
        let image = film.develop();
        let at = 6 * 20 + 4;
        // Two of single precision's roundings.
        let close = |a: Rgb, b: DVec3| (a.as_dvec3() / b - 1.0).abs().max_element() < 2e-7;
        assert!(close(image.pixels[at], (mean + 2.0) * 2.0));
        assert!(close(image.variance.unwrap()[at], (variance + 1.0) * 4.0));
        assert_eq!(image.pixels[at + 1], Rgb::ZERO);
        assert_eq!(film.paths, 1000);
    }
}
