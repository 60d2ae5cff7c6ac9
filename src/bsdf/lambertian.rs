//! Perfectly diffuse reflection and transmission (Pharr, Jakob and Humphreys 2016, §8.3).

use super::lobe::cosine_pdf;
use crate::math::Rgb;
use std::f32::consts::FRAC_1_PI;

/// Reflects the same radiance in all directions.
#[derive(Clone, Copy, Debug)]
pub struct LambertianReflection {
    /// Reflectance.
    pub reflectance: Rgb,
}

impl LambertianReflection {
    /// Value in 1/sr and density, for directions with these cosines to the shading normal.
    #[inline(always)]
    pub(super) fn f_and_pdf(&self, cos_o: f32, cos_i: f32) -> (Rgb, f32) {
        let pdf = cosine_pdf(cos_o * cos_i > 0.0, cos_i);
        (self.reflectance * FRAC_1_PI, pdf)
    }
}

/// Transmits the same radiance to all directions of the opposite side.
#[derive(Clone, Copy, Debug)]
pub struct LambertianTransmission {
    /// Transmittance.
    pub transmittance: Rgb,
}
