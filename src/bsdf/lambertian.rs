//! Perfectly diffuse reflection and transmission (Pharr, Jakob and Humphreys 2016, §8.3).

use crate::math::Rgb;
use std::f32::consts::FRAC_1_PI;

/// Reflects the same radiance in all directions.
#[derive(Clone, Copy, Debug)]
pub struct LambertianReflection {
    /// Reflectance.
    pub reflectance: Rgb,
}

impl LambertianReflection {
    /// The BRDF, in 1/sr.
    pub fn f(&self) -> Rgb {
        self.reflectance * FRAC_1_PI
    }
}

/// Transmits the same radiance to all directions of the opposite side.
#[derive(Clone, Copy, Debug)]
pub struct LambertianTransmission {
    /// Transmittance.
    pub transmittance: Rgb,
}

impl LambertianTransmission {
    /// The BTDF, in 1/sr.
    pub fn f(&self) -> Rgb {
        self.transmittance * FRAC_1_PI
    }
}
