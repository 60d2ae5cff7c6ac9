//! The parts of the spectrum that a camera with `"bool dispersion" "true"` traces rays of.
//!
//! A sample is traced at one wavelength, that of the band its number falls into, and counts for each channel of the
//! linear RGB image as much as the band does: the integral of the CIE color matching functions over it, brought
//! to RGB. Spectral light lies outside the RGB triangle; channels below 0 are taken for 0, wavelength by wavelength, so that no
//! image has any. Then the mean over all bands is made (1, 1, 1): what is seen without a fringe keeps its color.
//!
//! Bands are equally likely and bounded so that each holds the same share of what is seen: the root of ½R² + G² + ¼B², as
//! noise is seen by its luminance first. The weight of a ray then has a luminance of variance 0.21 and channels of 1.7 in
//! the mean; bands of equal width between 400 and 700 nm have 0.84 and 2.2, and wavelengths drawn evenly from 360 to
//! 830 nm 1.9 and 4.2. (With the channels below 0 it would be 0.36 and 3.0.) A stratified sampler meets all bands in
//! every pixel alike, where nothing of it is left but fringes.

use crate::math::Rgb;
use crate::math::cie::{COLOR_MATCHING, FIRST_WAVELENGTH};
use crate::optics::dispersion::AbbeModel;
use crate::optics::lens::LensError;
use crate::optics::{Lens, Prescription};

/// Bands: the lateral color of a lens without any correction, some 100 µm over the spectrum at the corner of full
/// frame, becomes steps of about a pixel.
pub(super) const BANDS: usize = 12;

/// A part of the spectrum.
#[derive(Clone, Debug)]
pub struct Band {
    /// The lens at the wavelength in the middle of what the band shows, its film where the d line has it.
    pub lens: Lens,
    /// That wavelength, µm.
    pub wavelength: f64,
    /// What a ray counts for in each channel; (1, 1, 1) in the mean over all bands.
    pub tint: Rgb,
}

impl Band {
    /// The bands of a lens whose file tells of dispersion, by wavelength.
    pub fn all(prescription: &Prescription, film_distance: f64) -> Result<Vec<Band>, LensError> {
        let bands = spectrum(BANDS).into_iter().map(|(wavelength, tint)| {
            let lens = prescription.at_wavelength(wavelength, AbbeModel::NormalLine);
            Ok(Band {
                lens: Lens::new(&lens, film_distance)?,
                wavelength,
                tint,
            })
        });
        bands.collect()
    }
}

/// Wavelength (µm) and tint of `count` bands.
fn spectrum(count: usize) -> Vec<(f64, Rgb)> {
    let sensitivity = sensitivity();
    let importance = |[r, g, b]: &[f64; 3]| (0.5 * r * r + g * g + 0.25 * b * b).sqrt();
    let total: f64 = sensitivity.iter().map(importance).sum();
    let mut bands = vec![([0.0; 3], 0.0, 0.0); count];
    let mut before = 0.0;
    for (i, s) in sensitivity.iter().enumerate() {
        let here = importance(s);
        // A row of the table is a nanometer, and may reach over the end of a band: each gets its part.
        let (low, high) = (before / total, (before + here) / total);
        before += here;
        for (k, (sum, weighted, weight)) in bands.iter_mut().enumerate() {
            let ends = [k, k + 1].map(|end| end as f64 / count as f64);
            let part = high.min(ends[1]) - low.max(ends[0]);
            if part > 0.0 {
                let share = part / (high - low);
                (0..3).for_each(|c| sum[c] += share * s[c]);
                *weighted += share * here * (f64::from(FIRST_WAVELENGTH) + i as f64);
                *weight += share * here;
            }
        }
    }
    let finished = |(sum, weighted, weight): ([f64; 3], f64, f64)| {
        let [r, g, b] = sum.map(|x| (x * count as f64) as f32);
        (1e-3 * weighted / weight, Rgb::new(r, g, b))
    };
    bands.into_iter().map(finished).collect()
}

/// The wavelength in the middle of what each channel shows of a spectrum of equal energy, nm.
pub(super) fn of_channels() -> [f64; 3] {
    let sensitivity = sensitivity();
    std::array::from_fn(|c| {
        let weights = sensitivity.iter().map(|s| s[c]);
        let nanometers = (0..).map(|i| f64::from(FIRST_WAVELENGTH) + f64::from(i));
        let weighted = weights.clone().zip(nanometers).map(|(w, nm)| w * nm);
        weighted.sum::<f64>() / weights.sum::<f64>()
    })
}

/// How much of each channel of a spectrum of equal energy a nanometer contributes.
fn sensitivity() -> Vec<[f64; 3]> {
    let rgb = |[x, y, z]: &[f64; 3]| {
        // The matrix of `math::color::rgb_from_xyz`.
        [
            3.240_479 * x - 1.537_150 * y - 0.498_535 * z,
            -0.969_256 * x + 1.875_991 * y + 0.041_556 * z,
            0.055_648 * x - 0.204_043 * y + 1.057_311 * z,
        ]
        .map(|channel: f64| channel.max(0.0))
    };
    let rows: Vec<[f64; 3]> = COLOR_MATCHING.iter().map(rgb).collect();
    let mut sums = [0.0; 3];
    for row in &rows {
        (0..3).for_each(|c| sums[c] += row[c]);
    }
    let relative = |row: [f64; 3]| [0, 1, 2].map(|c| row[c] / sums[c]);
    rows.into_iter().map(relative).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_are_white_together_and_run_from_blue_to_red() {
        for count in [1, 3, BANDS, 40] {
            let bands = spectrum(count);
            let mean = bands.iter().map(|b| b.1).sum::<Rgb>() / count as f32;
            // `count` roundings of numbers below 6.
            assert!((mean - Rgb::ONE).abs().max_element() < 2e-6, "{mean}");
            for pair in bands.windows(2) {
                assert!(pair[0].0 < pair[1].0);
            }
        }
        let bands = spectrum(BANDS);
        let (blue, red) = (bands[0], bands[BANDS - 1]);
        assert!(blue.0 > 0.4 && blue.0 < 0.45 && red.0 > 0.6 && red.0 < 0.66);
        assert!(blue.1.z > 3.0 * blue.1.y.abs() && red.1.x > 3.0 * red.1.y.abs());
    }

    /// The module's figures.
    #[test]
    fn bands_of_equal_weight_are_the_least_noisy() {
        // Of the luminance and of a channel, over the choice of the band with these probabilities.
        let variance = |tints: &[(f64, [f64; 3])]| {
            let second = |w: [f64; 3]| -> f64 {
                let value = |t: &[f64; 3]| w[0] * t[0] + w[1] * t[1] + w[2] * t[2];
                tints.iter().map(|(p, t)| value(t).powi(2) / p).sum()
            };
            let channels = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(second);
            [
                second([0.2127, 0.7152, 0.0722]) - 1.0,
                channels.iter().sum::<f64>() / 3.0 - 1.0,
            ]
        };
        let even: Vec<(f64, [f64; 3])> = spectrum(BANDS)
            .iter()
            .map(|b| 1.0 / BANDS as f64 * b.1.as_dvec3())
            .map(|t| (1.0 / BANDS as f64, t.to_array()))
            .collect();
        let nanometers = sensitivity();
        let of_equal_width = |from: usize, to: usize, count: usize| -> Vec<(f64, [f64; 3])> {
            let width = (to - from) / count;
            let band = |k: usize| {
                let mut sum = [0.0; 3];
                for row in &nanometers[from + k * width..from + (k + 1) * width] {
                    (0..3).for_each(|c| sum[c] += row[c]);
                }
                (1.0 / count as f64, sum)
            };
            (0..count).map(band).collect()
        };
        let [ours, equal, whole] = [
            variance(&even),
            // 400 to 700 nm.
            variance(&of_equal_width(40, 340, BANDS)),
            variance(&of_equal_width(0, 470, 470)),
        ];
        for (found, expected) in [
            (ours, [0.21, 1.67]),
            (equal, [0.84, 2.16]),
            (whole, [1.94, 4.16]),
        ] {
            for (found, expected) in found.iter().zip(expected) {
                // Two digits.
                assert!((found / expected - 1.0).abs() < 0.03, "{found} {expected}");
            }
        }
    }
}
