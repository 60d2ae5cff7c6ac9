//! Exit of a subsurface scattering path (Pharr, Jakob and Humphreys 2016, §11.4.1 and §15.4.3).

use super::fresnel::dielectric;
use super::fresnel_moments::FresnelMoments;
use crate::math::{Rgb, Vec3};
use std::f32::consts::PI;

/// Light that enters a medium diffusely through a smooth boundary: the Fresnel transmittance, normalized over the
/// hemisphere (equation 11.7), for radiance (times η², which cancels the 1/η² at the other end).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SubsurfaceExit {
    /// Refractive index relative to the outside.
    eta: f32,
    /// η² over the cosine-weighted integral of the transmittance.
    pub(super) factor: Rgb,
    /// See [`SubsurfaceExit::emerging`].
    emerges: bool,
}

impl SubsurfaceExit {
    /// The lobe for a medium of relative index `eta`, positive.
    pub fn new(eta: f32) -> SubsurfaceExit {
        let through = 1.0 - 2.0 * FresnelMoments::outside(f64::from(eta)).first as f32;
        SubsurfaceExit {
            eta,
            factor: Rgb::splat(eta * eta / (PI * through)),
            emerges: false,
        }
    }

    /// The same for importance: light that comes from below leaves in the direction `wo` of [`SubsurfaceExit::f`], whose directions
    /// are exchanged, and no refraction scales it.
    pub fn emerging(self) -> SubsurfaceExit {
        SubsurfaceExit {
            factor: self.factor / (self.eta * self.eta),
            emerges: true,
            ..self
        }
    }

    /// Value in 1/sr; directions are local. Light arrives from outside only.
    pub fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Rgb::ZERO;
        }
        let outside = if self.emerges { wo } else { wi };
        (1.0 - dielectric(outside.z, 1.0, self.eta)) * self.factor
    }
}
