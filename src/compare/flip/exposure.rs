//! The exposures of HDR-FLIP.

use crate::film::Image;
use crate::math::Rgb;
use crate::math::color::luminance;

/// Coefficients of the rational curve (a x² + b x + c) / (d x² + e x + f) that Narkowicz (2016) fitted to the ACES film
/// curve, including his exposure factor of 0.6.
const ACES: [f32; 6] = [
    0.6 * 0.6 * 2.51,
    0.6 * 0.03,
    0.0,
    0.6 * 0.6 * 2.43,
    0.6 * 0.59,
    0.14,
];

/// Tone-mapped values from here on count as bright (Andersson et al. 2021, §3).
const BRIGHT: f32 = 0.85;

/// A range of exposures, in stops (powers of two) as on a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExposureRange {
    /// The darkest: the brightest pixel is just bright.
    pub start: f32,
    /// The brightest: the median pixel is just bright.
    pub stop: f32,
    /// Number of exposures, evenly spaced from start to stop: at least 2, and at most one stop apart.
    pub count: usize,
}

impl ExposureRange {
    /// The papers' automatic choice of range for a reference: between the exposures at which its maximum and its median
    /// luminance are displayed as 0.85.
    pub fn of(reference: &Image) -> ExposureRange {
        let mut values: Vec<f32> = reference.pixels.iter().map(|&p| luminance(p)).collect();
        values.retain(|v| v.is_finite());
        values.sort_by(f32::total_cmp);
        // For black images: the papers' logarithm needs a positive value.
        let at = |index: usize| values.get(index).copied().unwrap_or(0.0).max(f32::EPSILON);
        let (median, most) = (at(values.len() / 2), at(values.len().saturating_sub(1)));
        let [start, stop] = [most, median].map(|v| (bright() / v).log2());
        ExposureRange {
            start,
            stop,
            count: ((stop - start).ceil() as usize).max(2),
        }
    }

    /// Each exposure in stops.
    pub fn stops(&self) -> impl Iterator<Item = f32> {
        let start = self.start;
        let step = (self.stop - start) / (self.count - 1).max(1) as f32;
        (0..self.count).map(move |i| start + i as f32 * step)
    }
}

/// The luminance that the tone curve maps to [`BRIGHT`]: the larger root of a quadratic equation.
fn bright() -> f32 {
    let [a, b, c, d, e, f] = ACES;
    let (p, q, r) = (a - BRIGHT * d, b - BRIGHT * e, c - BRIGHT * f);
    (-q + (q * q - 4.0 * p * r).sqrt()) / (2.0 * p)
}

/// Exposes by `stops` stops and applies the tone curve, 0…1.
pub(super) fn tone_map(rgb: Rgb, stops: f32) -> Rgb {
    let [a, b, c, d, e, f] = ACES;
    let curve = |x: f32| {
        // Beyond this the square would overflow; the curve is flat long before.
        let x = x.clamp(0.0, 1e6);
        ((a * x * x + b * x + c) / (d * x * x + e * x + f)).clamp(0.0, 1.0)
    };
    (rgb * stops.exp2()).map(curve)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::UVec2;

    #[test]
    fn the_brightest_and_the_median_are_just_bright() {
        let mut image = Image::black(UVec2::new(5, 1));
        image.pixels = [0.1, 0.2, 0.5, 3.0, 40.0].map(Rgb::splat).to_vec();
        let range = ExposureRange::of(&image);
        for (value, stops) in [(40.0, range.start), (0.5, range.stop)] {
            let shown = tone_map(Rgb::splat(value), stops);
            // The luminance weights sum to 1 in single precision.
            assert!(
                (shown - Rgb::splat(BRIGHT)).abs().max_element() < 1e-5,
                "{shown}"
            );
        }
        // 40 / 0.5 is 6.3 stops.
        assert_eq!(range.count, 7);
        let stops: Vec<f32> = range.stops().collect();
        assert_eq!((stops.len(), stops[0]), (7, range.start));
        assert!((stops[6] - range.stop).abs() < 1e-5);
    }

    #[test]
    fn black_images_have_a_range() {
        let range = ExposureRange::of(&Image::black(UVec2::new(3, 3)));
        assert!(range.start.is_finite() && range.stop.is_finite());
        assert_eq!(range.count, 2);
        assert_eq!(ExposureRange::of(&Image::black(UVec2::ZERO)).count, 2);
    }
}
