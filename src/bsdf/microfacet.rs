//! Microfacet BRDF and BTDF: rough boundaries made of small smooth facets (Torrance and Sparrow 1967; Walter et al.
//! 2007; Pharr, Jakob and Humphreys 2016, §8.4.4 and §14.1.1–14.1.3). Directions are local.

use super::fresnel::{Fresnel, dielectric};
use super::lobe::reflecting_facet;
use super::lobe_sample::LobeSample;
use super::specular::refract;
use super::trowbridge_reitz::TrowbridgeReitz;
use crate::math::{Rgb, Vec2, Vec3};

/// Glossy reflection (Torrance–Sparrow).
#[derive(Clone, Copy, Debug)]
pub struct MicrofacetReflection {
    /// Scale of the reflected light.
    pub reflectance: Rgb,
    /// Distribution of facet normals.
    pub distribution: TrowbridgeReitz,
    /// Fresnel reflectance of a facet.
    pub fresnel: Fresnel,
}

impl MicrofacetReflection {
    /// Fresnel reflectance of the facet with normal ±`h`, taken on the side of the surface normal.
    fn fresnel_at(&self, h: Vec3, wi: Vec3) -> Rgb {
        self.fresnel
            .evaluate(wi.dot(if h.z < 0.0 { -h } else { h }))
    }

    /// The BRDF, in 1/sr (equation 8.19).
    pub fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        let cosines = (wo.z * wi.z).abs();
        let Some(h) = (wo + wi).try_normalize().filter(|_| cosines > 0.0) else {
            return Rgb::ZERO;
        };
        self.reflectance
            * self.fresnel_at(h, wi)
            * (self.distribution.d(h) * self.distribution.g(wo, wi) / (4.0 * cosines))
    }

    /// Density of [`MicrofacetReflection::sample`].
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        reflecting_facet(wo, wi).map_or(0.0, |h| {
            self.distribution.pdf(wo, h) / (4.0 * wo.dot(h).abs())
        })
    }

    /// Value and density together, which share the half vector, its density and the masking of `wo`.
    pub fn f_and_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let facets = self.distribution.reflection(wo, wi);
        let fresnel = self.fresnel.evaluate(facets.cosine);
        (self.reflectance * fresnel * facets.f, facets.pdf)
    }

    /// Reflects about a facet sampled from the visible ones; `None` if the light would leave below the surface.
    pub fn sample(&self, wo: Vec3, u: Vec2) -> Option<LobeSample> {
        let (wi, is_above) = self.distribution.sample_reflection(wo, u);
        if !is_above {
            return None;
        }
        let (f, pdf) = self.f_and_pdf(wo, wi);
        Some(LobeSample::reflected(wi, f, pdf))
    }
}

/// Glossy reflection mirrored through the surface: light leaves as a glossy reflection would, but on the opposite side,
/// without refraction. This is pbrt-v2's glossy transmission (its `BRDFToBTDF`), the same from both sides.
#[derive(Clone, Copy, Debug)]
pub struct MirroredReflection(pub MicrofacetReflection);

impl MirroredReflection {
    /// The BTDF, in 1/sr; radiance is not scaled, as nothing is refracted.
    pub fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        self.0.f(raised(wo), raised(wi))
    }

    /// Density of [`MirroredReflection::sample`].
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z * wi.z >= 0.0 {
            return 0.0;
        }
        self.0.pdf(raised(wo), raised(wi))
    }

    /// The reflection's sample, flipped to the opposite side.
    pub fn sample(&self, wo: Vec3, u: Vec2) -> Option<LobeSample> {
        let reflected = self.0.sample(raised(wo), u)?;
        Some(LobeSample {
            wi: reflected.wi.with_z(reflected.wi.z.copysign(-wo.z)),
            transmission: true,
            ..reflected
        })
    }
}

/// The direction mirrored to above the surface.
fn raised(w: Vec3) -> Vec3 {
    w.with_z(w.z.abs())
}

/// Refraction through a rough boundary.
#[derive(Clone, Copy, Debug)]
pub struct MicrofacetTransmission {
    /// Scale of the refracted light.
    pub transmittance: Rgb,
    /// Distribution of facet normals.
    pub distribution: TrowbridgeReitz,
    /// Refractive index on the normal's side.
    pub eta_a: f32,
    /// Refractive index on the other side.
    pub eta_b: f32,
}

impl MicrofacetTransmission {
    /// Relative refractive index: `wi`'s side over `wo`'s.
    fn eta(&self, wo: Vec3) -> f32 {
        if wo.z > 0.0 {
            self.eta_b / self.eta_a
        } else {
            self.eta_a / self.eta_b
        }
    }

    /// The facet normal (z > 0) that refracts one direction to the other; `None` if there is none, or only one that is
    /// back-facing. (pbrt-v3 includes those in values but never samples them, so that its images of rough glass are up
    /// to 1 % brighter at grazing angles.)
    fn facet(&self, wo: Vec3, wi: Vec3) -> Option<Vec3> {
        if wo.z * wi.z >= 0.0 {
            return None;
        }
        let h = (wo + self.eta(wo) * wi).try_normalize()?;
        let h = if h.z < 0.0 { -h } else { h };
        (wo.dot(h) * wo.z > 0.0 && wi.dot(h) * wi.z > 0.0).then_some(h)
    }

    /// The BTDF for radiance, in 1/sr (equation 8.20).
    pub fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        self.f_and_pdf(wo, wi).0
    }

    /// Density of [`MicrofacetTransmission::sample`].
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.f_and_pdf(wo, wi).1
    }

    /// Value and density together, which share the facet and its density. Where one is not used it is not computed.
    #[inline(always)]
    pub fn f_and_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let Some(h) = self.facet(wo, wi) else {
            return (Rgb::ZERO, 0.0);
        };
        let eta = self.eta(wo);
        let (o, i) = (wo.dot(h), wi.dot(h));
        let share = 1.0 - dielectric(o, self.eta_a, self.eta_b);
        let denominator = o + eta * i;
        // η² of the half-vector's Jacobian and 1/η² of the radiance scaling cancel.
        let shape = self.distribution.d(h) * self.distribution.g(wo, wi) * o * i
            / (wo.z * wi.z * denominator * denominator);
        let pdf =
            self.distribution.pdf(wo, h) * (eta * eta * i / (denominator * denominator)).abs();
        (self.transmittance * (share * shape.abs()), pdf)
    }

    /// Refracts through a facet sampled from the visible ones; `None` for total internal reflection.
    pub fn sample(&self, wo: Vec3, u: Vec2) -> Option<LobeSample> {
        let h = self.distribution.sample(wo, u);
        if wo.dot(h) <= 0.0 {
            return None;
        }
        let eta = self.eta(wo);
        let wi = refract(wo, h, eta)?;
        let (f, pdf) = self.f_and_pdf(wo, wi);
        (pdf > 0.0).then(|| LobeSample::reflected(wi, f, pdf).transmitted(eta))
    }
}
