//! Rough diffuse reflection (Oren and Nayar 1994, the qualitative model;
//! Pharr, Jakob and Humphreys 2016, §8.4.1).

use crate::math::{Rgb, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Diffuse facets whose slopes have a Gaussian distribution.
#[derive(Clone, Copy, Debug)]
pub struct OrenNayar {
    pub(super) reflectance: Rgb,
    a: f32,
    b: f32,
}

impl OrenNayar {
    /// A lobe from the facets' reflectance and the standard deviation of their inclination in degrees.
    pub fn new(reflectance: Rgb, sigma_degrees: f32) -> OrenNayar {
        let sigma2 = sigma_degrees.to_radians().powi(2);
        OrenNayar {
            reflectance,
            a: 1.0 - sigma2 / (2.0 * (sigma2 + 0.33)),
            b: 0.45 * sigma2 / (sigma2 + 0.09),
        }
    }

    /// The BRDF, in 1/sr: R/π (A + B max(0, cos(φi − φo)) sin α tan β), α the larger and β the
    /// smaller of the two angles to the normal.
    pub fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        // sin θi sin θo cos(φi − φo) is the dot product of the tangential components.
        let along = (wo.x * wi.x + wo.y * wi.y).max(0.0);
        // sin α tan β = sin θi sin θo / cos β, and β has the larger cosine.
        let cos_beta = wo.z.abs().max(wi.z.abs());
        let shape = if cos_beta > 0.0 {
            self.a + self.b * along / cos_beta
        } else {
            self.a
        };
        self.reflectance * (FRAC_1_PI * shape)
    }
}
