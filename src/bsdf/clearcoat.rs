//! Clearcoat of the Disney BRDF (Burley, "Physically Based Shading at Disney", 2012, §5.4 and appendix B.2). Directions
//! are local.

use super::lobe::reflecting_facet;
use super::lobe_sample::LobeSample;
use crate::math::{Rgb, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Width of the distribution used for Smith masking, regardless of the coat's gloss.
const MASKING_ALPHA: f32 = 0.25;

/// Reflectance at normal incidence: a refractive index of 1.5.
const R0: f32 = 0.04;

/// A thin glossy coat with the long tails of Berry's distribution.
#[derive(Clone, Copy, Debug)]
pub struct Clearcoat {
    /// Scale of the reflected light; the model's strength 1 is a quarter of a full reflection.
    pub weight: Rgb,
    /// Width of the distribution, above 0 and below 1.
    pub alpha: f32,
}

impl Clearcoat {
    /// Generalized Trowbridge–Reitz (GTR1) with exponent 1 (equation 4 of the appendix). Using the sine keeps the
    /// precision near the pole that 1 − cos² would lose.
    fn d(&self, h: Vec3) -> f32 {
        let a2 = self.alpha * self.alpha;
        let spread = h.x * h.x + h.y * h.y + a2 * h.z * h.z;
        (a2 - 1.0) / (PI * a2.ln() * spread)
    }

    /// Reflectance of a smooth coat of weight 1.
    pub(super) fn reflectance_at(&self, cos: f32) -> f32 {
        0.25 * (R0 + (1.0 - R0) * super::fresnel::schlick_weight(cos))
    }

    /// The BRDF, in 1/sr.
    pub fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        let Some(h) = (wo + wi).try_normalize() else {
            return Rgb::ZERO;
        };
        let fresnel = R0 + (1.0 - R0) * super::fresnel::schlick_weight(wo.dot(h));
        let masking = half_g1(wo.z.abs()) * half_g1(wi.z.abs());
        // The cosines of 4 cos cos are part of the masking term.
        self.weight * (0.25 * masking * fresnel * self.d(h))
    }

    /// Density of [`Clearcoat::sample`].
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        reflecting_facet(wo, wi).map_or(0.0, |h| self.d(h) * h.z.abs() / (4.0 * wo.dot(h).abs()))
    }

    /// Reflects about a facet sampled by area; `None` if the light would leave below the surface.
    pub fn sample(&self, wo: Vec3, u: Vec2) -> Option<LobeSample> {
        let a2 = self.alpha * self.alpha;
        let sin2 = (a2.powf(1.0 - u.x) - a2) / (1.0 - a2);
        let sin = sin2.clamp(0.0, 1.0).sqrt();
        let cos = (1.0 - sin * sin).sqrt().copysign(wo.z);
        let (sin_phi, cos_phi) = (TAU * u.y).sin_cos();
        let h = Vec3::new(sin * cos_phi, sin * sin_phi, cos);
        let wi = 2.0 * wo.dot(h) * h - wo;
        LobeSample::evaluated(wi, self.pdf(wo, wi), || self.f(wo, wi))
    }
}

/// Smith masking over twice the cosine, as Burley writes it: 1/(cos + √(α² + cos² − α² cos²)), so that the product of
/// two is four times G/(4 cos cos).
fn half_g1(cos: f32) -> f32 {
    let a2 = MASKING_ALPHA * MASKING_ALPHA;
    1.0 / (cos + (a2 + (1.0 - a2) * cos * cos).sqrt())
}
