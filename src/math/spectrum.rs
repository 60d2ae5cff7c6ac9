//! Sampled spectra to RGB as pbrt-v3's RGB mode does it (scene-language 4.7).

use super::Rgb;

/// A spectrum given as (wavelength in nm, value) pairs, ascending and linearly interpolated,
/// its ends held constant, converted to linear RGB.
pub fn rgb_from_samples(_samples: &[(f64, f64)]) -> Rgb {
    Rgb::ONE
}

/// Planck's curve at `kelvin` divided by its own peak, as linear RGB; zero at or below 0 K.
pub fn rgb_from_blackbody(_kelvin: f64) -> Rgb {
    Rgb::ONE
}
