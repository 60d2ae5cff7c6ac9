//! One component of a BSDF.

use super::fourier::FourierLobe;
use super::lambertian::LambertianReflection;
use super::microfacet::{MicrofacetReflection, MicrofacetTransmission};
use super::oren_nayar::OrenNayar;
use super::specular::{FresnelSpecular, SpecularReflection, SpecularTransmission};
use super::subsurface_exit::SubsurfaceExit;
use crate::math::sampling::{cosine_hemisphere, cosine_hemisphere_pdf};
use crate::math::{Rgb, Vec2, Vec3};

/// One component of a BSDF. Directions are local (z along the shading normal) and point away.
#[derive(Clone, Copy, Debug)]
pub enum Lobe<'a> {
    /// Diffuse.
    LambertianReflection(LambertianReflection),
    /// Rough diffuse.
    OrenNayar(OrenNayar),
    /// Mirror.
    SpecularReflection(SpecularReflection),
    /// Refraction, or passage straight on.
    SpecularTransmission(SpecularTransmission),
    /// Smooth glass.
    FresnelSpecular(FresnelSpecular),
    /// Glossy.
    MicrofacetReflection(MicrofacetReflection),
    /// Rough refraction.
    MicrofacetTransmission(MicrofacetTransmission),
    /// The far end of a path under a surface.
    SubsurfaceExit(SubsurfaceExit),
    /// A table.
    Fourier(FourierLobe<'a>),
}

/// A direction drawn from a lobe.
#[derive(Clone, Copy, Debug)]
pub struct LobeSample {
    /// Value for the pair of directions; of a specular lobe the delta's factor over the cosine.
    pub f: Rgb,
    /// Sampled direction, local.
    pub wi: Vec3,
    /// Density per solid angle; of a specular lobe the probability.
    pub pdf: f32,
    /// Has the light passed through?
    pub transmission: bool,
    /// Refractive index on `wi`'s side over that on `wo`'s.
    pub eta: f32,
}

impl Lobe<'_> {
    /// Does it scatter into single directions only?
    pub fn is_specular(&self) -> bool {
        matches!(
            self,
            Lobe::SpecularReflection(_) | Lobe::SpecularTransmission(_) | Lobe::FresnelSpecular(_)
        )
    }

    /// Does it reflect (`transmit` false) or transmit (true)?
    pub fn scatters(&self, transmit: bool) -> bool {
        match self {
            Lobe::LambertianReflection(_)
            | Lobe::OrenNayar(_)
            | Lobe::SpecularReflection(_)
            | Lobe::MicrofacetReflection(_)
            | Lobe::SubsurfaceExit(_) => !transmit,
            Lobe::SpecularTransmission(_) | Lobe::MicrofacetTransmission(_) => transmit,
            Lobe::FresnelSpecular(_) | Lobe::Fourier(_) => true,
        }
    }

    /// Value, in 1/sr; black for a specular lobe.
    pub fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        match self {
            Lobe::LambertianReflection(l) => l.f(),
            Lobe::OrenNayar(l) => l.f(wo, wi),
            Lobe::MicrofacetReflection(l) => l.f(wo, wi),
            Lobe::MicrofacetTransmission(l) => l.f(wo, wi),
            Lobe::SubsurfaceExit(l) => l.f(wi),
            Lobe::Fourier(l) => l.f(wo, wi),
            Lobe::SpecularReflection(_)
            | Lobe::SpecularTransmission(_)
            | Lobe::FresnelSpecular(_) => Rgb::ZERO,
        }
    }

    /// Density of [`Lobe::sample`] per solid angle; 0 for a specular lobe.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        match self {
            Lobe::LambertianReflection(_) | Lobe::OrenNayar(_) | Lobe::SubsurfaceExit(_) => {
                if wo.z * wi.z > 0.0 {
                    cosine_hemisphere_pdf(wi.z.abs())
                } else {
                    0.0
                }
            }
            Lobe::MicrofacetReflection(l) => l.pdf(wo, wi),
            Lobe::MicrofacetTransmission(l) => l.pdf(wo, wi),
            Lobe::Fourier(l) => l.pdf(wo, wi),
            Lobe::SpecularReflection(_)
            | Lobe::SpecularTransmission(_)
            | Lobe::FresnelSpecular(_) => 0.0,
        }
    }

    /// Draws a direction with `uc` and `u` in [0, 1); `None` where the lobe gives none.
    pub fn sample(&self, wo: Vec3, uc: f32, u: Vec2) -> Option<LobeSample> {
        match self {
            Lobe::LambertianReflection(_) | Lobe::OrenNayar(_) | Lobe::SubsurfaceExit(_) => {
                let mut wi = cosine_hemisphere(u);
                wi.z = wi.z.copysign(wo.z);
                Some(LobeSample {
                    f: self.f(wo, wi),
                    wi,
                    pdf: self.pdf(wo, wi),
                    transmission: false,
                    eta: 1.0,
                })
            }
            Lobe::SpecularReflection(l) => Some(l.sample(wo)),
            Lobe::SpecularTransmission(l) => l.sample(wo),
            Lobe::FresnelSpecular(l) => l.sample(wo, uc),
            Lobe::MicrofacetReflection(l) => l.sample(wo, u),
            Lobe::MicrofacetTransmission(l) => l.sample(wo, u),
            Lobe::Fourier(l) => l.sample(wo, u),
        }
    }

    /// The one direction a specular lobe reflects or transmits to; `None` for others.
    pub fn specular_direction(&self, wo: Vec3, transmit: bool) -> Option<LobeSample> {
        match (self, transmit) {
            (Lobe::SpecularReflection(l), false) => Some(l.sample(wo)),
            (Lobe::SpecularTransmission(l), true) => l.sample(wo),
            (Lobe::FresnelSpecular(l), false) => Some(l.reflection().sample(wo)),
            (Lobe::FresnelSpecular(l), true) => l.transmission().sample(wo),
            _ => None,
        }
    }
}
