//! Conversion of sampled spectra to RGB as in pbrt-v3's RGB mode (docs/scene-language.md §4.7).
//!
//! Wavelengths are in nm, temperatures in kelvin. There is no white balance: the flat spectrum 1 becomes the reddish
//! (1.20233, 0.94622, 0.90734), and existing scenes have been tuned to that.

use super::Rgb;
use super::cie::{COLOR_MATCHING, FIRST_WAVELENGTH};

/// ∑ȳ over the 471 rows, as in pbrt-v3.
const CIE_Y_SUM: f64 = 106.856_895;

/// pbrt-v3's factor on the sum over 1 nm steps. It is not 1/∑ȳ: 470 nm lie between the first and the last of the 471
/// wavelengths, so the flat spectrum 1 gets Y = 0.99788.
const SUM_TO_XYZ: f64 = 470.0 / (471.0 * CIE_Y_SUM);

/// Wien's displacement constant, m·K.
const WIEN: f64 = 2.897_772_1e-3;

/// The second radiation constant hc/k of Planck's law, m·K, from the h, c and k that pbrt uses.
const SECOND_RADIATION: f64 = 6.626_069_57e-34 * 299_792_458.0 / 1.380_648_8e-23;

/// Converts a spectrum given as (wavelength in nm, value) pairs, ascending, linearly interpolated and constant beyond
/// its ends, to linear RGB. Black if there are no pairs. Negative channels, which saturated colors have, are kept.
///
/// ```
/// let flat = fstop::math::spectrum::rgb_from_samples(&[(550.0, 1.0)]);
/// assert!((flat.x - 1.20233).abs() < 1e-4);
/// ```
pub fn rgb_from_samples(samples: &[(f64, f64)]) -> Rgb {
    // The requested wavelengths ascend too, so one pass over the pairs serves them all.
    let mut next = 0;
    rgb_from_function(|wavelength| {
        while next < samples.len() && samples[next].0 < wavelength {
            next += 1;
        }
        interpolate(samples, next, wavelength)
    })
}

/// The value at `wavelength`, where `next` is the first pair at or above it.
fn interpolate(samples: &[(f64, f64)], next: usize, wavelength: f64) -> f64 {
    let before = next.checked_sub(1).and_then(|i| samples.get(i));
    match (before, samples.get(next)) {
        (Some(&(w0, v0)), Some(&(w1, v1))) => v0 + (v1 - v0) * ((wavelength - w0) / (w1 - w0)),
        (Some(&(_, v)), None) | (None, Some(&(_, v))) => v,
        (None, None) => 0.0,
    }
}

/// Planck's blackbody curve at `kelvin` divided by its own peak, as linear RGB; zero at or below 0 K.
///
/// pbrt-v3's `blackbody`.
pub fn rgb_from_blackbody(kelvin: f64) -> Rgb {
    if kelvin > 0.0 {
        blackbody_relative_to(WIEN / kelvin, kelvin)
    } else {
        Rgb::ZERO
    }
}

/// Planck's blackbody curve at `kelvin` divided by its value at 555 nm, as linear RGB with Y = 1 for the flat spectrum;
/// zero at or below 0 K.
///
/// pbrt-v2's `blackbody` (docs/scene-language.md §A.3).
pub fn rgb_from_blackbody_v2(kelvin: f64) -> Rgb {
    if kelvin > 0.0 {
        // v2 divides by ∑ȳ alone.
        blackbody_relative_to(555e-9, kelvin) * (471.0f64 / 470.0) as f32
    } else {
        Rgb::ZERO
    }
}

/// Planck's curve at `kelvin` > 0 divided by its value at `reference` meters, as linear RGB.
fn blackbody_relative_to(reference: f64, kelvin: f64) -> Rgb {
    // Planck's law without the factor 2hc², which cancels, as a logarithm, since at a few kelvin both values underflow
    // although their ratio does not.
    let log_planck =
        |meters: f64| -5.0 * meters.ln() - log_exp_m1(SECOND_RADIATION / (meters * kelvin));
    let log_reference = log_planck(reference);
    rgb_from_function(|wavelength| (log_planck(wavelength * 1e-9) - log_reference).exp())
}

/// ln(eˣ − 1) for x > 0, without overflow.
fn log_exp_m1(x: f64) -> f64 {
    if x > 40.0 { x } else { x.exp_m1().ln() }
}

/// The spectrum `value`(wavelength in nm), evaluated at ascending wavelengths, as linear RGB.
fn rgb_from_function(mut value: impl FnMut(f64) -> f64) -> Rgb {
    let mut xyz = [0.0f64; 3];
    for (i, row) in COLOR_MATCHING.iter().enumerate() {
        let v = value(f64::from(FIRST_WAVELENGTH) + i as f64);
        for (sum, matching) in xyz.iter_mut().zip(row) {
            *sum += v * matching;
        }
    }
    // The matrix of `color::rgb_from_xyz`, in double precision: red is a difference of terms
    // three times its size.
    let [x, y, z] = xyz.map(|sum| sum * SUM_TO_XYZ);
    Rgb::new(
        (3.240_479 * x - 1.537_150 * y - 0.498_535 * z) as f32,
        (-0.969_256 * x + 1.875_991 * y + 0.041_556 * z) as f32,
        (0.055_648 * x - 0.204_043 * y + 1.057_311 * z) as f32,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::color::{luminance, rgb_from_xyz};

    fn assert_near(actual: Rgb, expected: [f32; 3], tolerance: f32) {
        let expected = Rgb::from_array(expected);
        assert!(
            (actual - expected).abs().max_element() < tolerance,
            "{actual} but expected {expected}"
        );
    }

    /// Half a unit of the fifth decimal of the reference values as printed, and as much again because the reference
    /// sums in single precision.
    const PRINTED: f32 = 1e-5;

    #[test]
    fn flat_spectrum_is_reddish() {
        let flat = rgb_from_samples(&[(400.0, 1.0), (700.0, 1.0)]);
        assert_near(flat, [1.20233, 0.94622, 0.90734], PRINTED);
        assert!((luminance(flat) - 0.99788).abs() < PRINTED);
    }

    #[test]
    fn blackbodies_match_the_reference_table() {
        // docs/scene-language.md §6.3, printed by pbrt-v3.
        for (kelvin, rgb) in [
            (2000.0, [0.12191, 0.03130, 0.00099]),
            (2700.0, [0.53349, 0.22157, 0.05290]),
            (3000.0, [0.73506, 0.35049, 0.11298]),
            (4000.0, [1.16520, 0.76155, 0.43977]),
            (5000.0, [1.19001, 0.94206, 0.74794]),
            (6500.0, [0.92222, 0.86950, 0.91522]),
            (8000.0, [0.64145, 0.67169, 0.83829]),
            (10000.0, [0.38594, 0.44029, 0.63353]),
            (20000.0, [0.04883, 0.06457, 0.12042]),
        ] {
            assert_near(rgb_from_blackbody(kelvin), rgb, PRINTED);
        }
    }

    #[test]
    fn ends_are_held_and_the_inside_is_linear() {
        let ramp = rgb_from_samples(&[(360.0, 0.0), (830.0, 470.0)]);
        let by_hand = rgb_from_function(|w| w - 360.0);
        assert_near(ramp, by_hand.to_array(), 1e-3);
        // A single pair is constant everywhere; pairs far outside matter only through interpolation.
        assert_eq!(
            rgb_from_samples(&[(100.0, 2.0)]),
            rgb_from_samples(&[(900.0, 2.0)])
        );
        assert_eq!(rgb_from_samples(&[]), Rgb::ZERO);
    }

    #[test]
    fn version_2_is_one_at_555_nm() {
        // Where the curve is nearly flat around its peak both normalizations agree: at T = b/555 nm they are equal
        // except for the 471/470 of the sum.
        let kelvin = WIEN / 555e-9;
        let ratio = rgb_from_blackbody_v2(kelvin) / rgb_from_blackbody(kelvin);
        assert_near(ratio, [471.0 / 470.0; 3], 1e-6);
        assert!(rgb_from_blackbody_v2(2000.0).x > rgb_from_blackbody(2000.0).x);
    }

    #[test]
    fn odd_temperatures_stay_finite() {
        for kelvin in [-1.0, 0.0, f64::NAN, 1e-300, 1e-3, 1.0, 1e9, f64::MAX] {
            let rgb = rgb_from_blackbody(kelvin);
            assert!(rgb.is_finite(), "{kelvin} K gives {rgb}");
        }
        assert_eq!(rgb_from_blackbody(-5.0), Rgb::ZERO);
    }

    #[test]
    fn double_precision_matrix_is_the_shared_one() {
        let rgb = rgb_from_function(|_| 1.0);
        let mut xyz = Rgb::ZERO;
        for row in COLOR_MATCHING.iter() {
            xyz += Rgb::new(row[0] as f32, row[1] as f32, row[2] as f32);
        }
        // 471 single-precision additions.
        assert_near(rgb_from_xyz(xyz * SUM_TO_XYZ as f32), rgb.to_array(), 1e-4);
    }
}
