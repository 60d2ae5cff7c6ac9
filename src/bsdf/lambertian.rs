//! Perfectly diffuse reflection and transmission (Pharr, Jakob and Humphreys 2016, §8.3).

use crate::math::Rgb;

/// Reflects the same radiance in all directions.
#[derive(Clone, Copy, Debug)]
pub struct LambertianReflection {
    /// Reflectance.
    pub reflectance: Rgb,
}

/// Transmits the same radiance to all directions of the opposite side.
#[derive(Clone, Copy, Debug)]
pub struct LambertianTransmission {
    /// Transmittance.
    pub transmittance: Rgb,
}
