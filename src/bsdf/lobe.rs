//! One component of a BSDF.

use super::clearcoat::Clearcoat;
use super::disney_diffuse::DisneyDiffuse;
use super::fourier::FourierLobe;
use super::fresnel_blend::FresnelBlend;
use super::hair::Hair;
use super::lambertian::{LambertianReflection, LambertianTransmission};
use super::lobe_sample::LobeSample;
use super::measured::MeasuredLobe;
use super::microfacet::{MicrofacetReflection, MicrofacetTransmission, MirroredReflection};
use super::oren_nayar::OrenNayar;
use super::specular::{FresnelSpecular, SpecularReflection, SpecularTransmission};
use super::subsurface_exit::SubsurfaceExit;
use crate::math::sampling::{cosine_hemisphere, cosine_hemisphere_pdf};
use crate::math::{Rgb, Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// One component of a BSDF. Directions are local (z along the shading normal) and point away from the surface.
#[derive(Clone, Copy, Debug)]
pub enum Lobe<'a> {
    /// Diffuse reflection.
    LambertianReflection(LambertianReflection),
    /// Diffuse transmission.
    LambertianTransmission(LambertianTransmission),
    /// Rough diffuse reflection.
    OrenNayar(OrenNayar),
    /// Perfect mirror.
    SpecularReflection(SpecularReflection),
    /// Perfect refraction, or straight transmission.
    SpecularTransmission(SpecularTransmission),
    /// Smooth glass.
    FresnelSpecular(FresnelSpecular),
    /// Glossy reflection.
    MicrofacetReflection(MicrofacetReflection),
    /// Rough refraction.
    MicrofacetTransmission(MicrofacetTransmission),
    /// Glossy transmission without refraction.
    MirroredReflection(MirroredReflection),
    /// Glossy coat on a diffuse base.
    FresnelBlend(FresnelBlend),
    /// Disney's diffuse terms.
    DisneyDiffuse(DisneyDiffuse),
    /// Disney's clearcoat.
    Clearcoat(Clearcoat),
    /// A hair fiber, which scatters in all directions.
    Hair(Hair),
    /// The exit of a subsurface scattering path.
    SubsurfaceExit(SubsurfaceExit),
    /// A tabulated BSDF.
    Fourier(FourierLobe<'a>),
    /// A measured BRDF.
    Measured(MeasuredLobe<'a>),
}

/// A lobe that scatters according to a table.
#[derive(Debug)]
pub struct TableLobe<'a, Table> {
    /// The table.
    pub table: &'a Table,
    /// Scale of everything: the weight in a mix.
    pub(super) share: Rgb,
}

impl<Table> Copy for TableLobe<'_, Table> {}

impl<Table> Clone for TableLobe<'_, Table> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<'a, Table> TableLobe<'a, Table> {
    /// The whole table, unscaled.
    pub fn new(table: &'a Table) -> TableLobe<'a, Table> {
        let share = Rgb::ONE;
        TableLobe { table, share }
    }
}

/// The normal of the facet that reflects one direction to the other; `None` for directions on opposite sides.
pub(super) fn reflecting_facet(wo: Vec3, wi: Vec3) -> Option<Vec3> {
    if wo.z * wi.z <= 0.0 {
        return None;
    }
    (wo + wi).try_normalize()
}

impl Lobe<'_> {
    /// Returns `true` if the lobe is perfectly specular (a delta distribution).
    pub fn is_specular(&self) -> bool {
        matches!(
            self,
            Lobe::SpecularReflection(_) | Lobe::SpecularTransmission(_) | Lobe::FresnelSpecular(_)
        )
    }

    /// The share of light from everywhere that the lobe scatters to any direction, where that is the same for all.
    pub fn diffuse_reflectance(&self) -> Option<Rgb> {
        match self {
            Lobe::LambertianReflection(lobe) => Some(lobe.reflectance),
            Lobe::LambertianTransmission(lobe) => Some(lobe.transmittance),
            _ => None,
        }
    }

    /// Returns `true` if the lobe scatters into all directions, at least by a part of it.
    pub fn is_diffuse(&self) -> bool {
        matches!(
            self,
            Lobe::LambertianReflection(_)
                | Lobe::LambertianTransmission(_)
                | Lobe::OrenNayar(_)
                | Lobe::DisneyDiffuse(_)
                | Lobe::FresnelBlend(_)
                | Lobe::SubsurfaceExit(_)
                | Lobe::Measured(_)
        )
    }

    /// Returns `true` if the lobe reflects (`transmit` false) or transmits (true).
    pub fn scatters(&self, transmit: bool) -> bool {
        match self {
            Lobe::LambertianReflection(_)
            | Lobe::OrenNayar(_)
            | Lobe::SpecularReflection(_)
            | Lobe::MicrofacetReflection(_)
            | Lobe::FresnelBlend(_)
            | Lobe::DisneyDiffuse(_)
            | Lobe::Clearcoat(_)
            | Lobe::SubsurfaceExit(_)
            | Lobe::Measured(_) => !transmit,
            Lobe::LambertianTransmission(_)
            | Lobe::SpecularTransmission(_)
            | Lobe::MicrofacetTransmission(_)
            | Lobe::MirroredReflection(_) => transmit,
            Lobe::FresnelSpecular(_) | Lobe::Hair(_) | Lobe::Fourier(_) => true,
        }
    }

    /// Returns `false` if [`Lobe::pdf`] is known to be 0, as the lobe does not scatter to that side of the shading plane.
    #[inline]
    pub(super) fn may_sample(&self, wo: Vec3, wi: Vec3) -> bool {
        match self {
            Lobe::MicrofacetReflection(_) => wo.z * wi.z > 0.0,
            Lobe::MicrofacetTransmission(_) => wo.z * wi.z < 0.0,
            _ => true,
        }
    }

    /// Value, in 1/sr; black for a specular lobe.
    pub fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        match self {
            Lobe::LambertianReflection(l) => l.reflectance * FRAC_1_PI,
            Lobe::LambertianTransmission(l) => l.transmittance * FRAC_1_PI,
            Lobe::OrenNayar(l) => l.f(wo, wi),
            Lobe::MicrofacetReflection(l) => l.f(wo, wi),
            Lobe::MicrofacetTransmission(l) => l.f(wo, wi),
            Lobe::MirroredReflection(l) => l.f(wo, wi),
            Lobe::FresnelBlend(l) => l.f(wo, wi),
            Lobe::DisneyDiffuse(l) => l.f(wo, wi),
            Lobe::Clearcoat(l) => l.f(wo, wi),
            Lobe::Hair(l) => l.f(wo, wi),
            Lobe::SubsurfaceExit(l) => l.f(wo, wi),
            Lobe::Fourier(l) => l.f(wo, wi),
            Lobe::Measured(l) => l.f(wo, wi),
            Lobe::SpecularReflection(_)
            | Lobe::SpecularTransmission(_)
            | Lobe::FresnelSpecular(_) => Rgb::ZERO,
        }
    }

    /// Density of [`Lobe::sample`] per solid angle; 0 for a specular lobe.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        match self {
            Lobe::LambertianReflection(_) | Lobe::OrenNayar(_) | Lobe::DisneyDiffuse(_) => {
                cosine_pdf(wo.z * wi.z > 0.0, wi.z)
            }
            Lobe::SubsurfaceExit(_) => cosine_pdf(wo.z > 0.0 && wi.z > 0.0, wi.z),
            Lobe::LambertianTransmission(_) => cosine_pdf(wo.z * wi.z < 0.0, wi.z),
            Lobe::MicrofacetReflection(l) => l.pdf(wo, wi),
            Lobe::MicrofacetTransmission(l) => l.pdf(wo, wi),
            Lobe::MirroredReflection(l) => l.pdf(wo, wi),
            Lobe::FresnelBlend(l) => l.pdf(wo, wi),
            Lobe::Clearcoat(l) => l.pdf(wo, wi),
            Lobe::Hair(l) => l.pdf(wo, wi),
            Lobe::Fourier(l) => l.pdf(wo, wi),
            Lobe::Measured(l) => l.pdf(wo, wi),
            Lobe::SpecularReflection(_)
            | Lobe::SpecularTransmission(_)
            | Lobe::FresnelSpecular(_) => 0.0,
        }
    }

    /// [`Lobe::f`] and [`Lobe::pdf`] for one pair of directions together.
    #[inline]
    pub fn f_and_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        match self {
            Lobe::LambertianReflection(l) => l.f_and_pdf(wo.z, wi.z),
            Lobe::MicrofacetReflection(l) => l.f_and_pdf(wo, wi),
            Lobe::MicrofacetTransmission(l) => l.f_and_pdf(wo, wi),
            _ => (self.f(wo, wi), self.pdf(wo, wi)),
        }
    }

    /// Returns `true` if [`Lobe::sample`] uses its third number.
    pub fn needs_third(&self) -> bool {
        matches!(self, Lobe::Hair(_))
    }

    /// Samples a direction with `third` and `u` in [0, 1); `None` if there is none.
    pub fn sample(&self, wo: Vec3, third: f32, u: Vec2) -> Option<LobeSample> {
        match self {
            Lobe::LambertianReflection(_) | Lobe::OrenNayar(_) | Lobe::DisneyDiffuse(_) => {
                Some(self.cosine_sample(wo, cosine_hemisphere(u), false))
            }
            Lobe::SubsurfaceExit(_) => {
                (wo.z > 0.0).then(|| self.cosine_sample(wo, cosine_hemisphere(u), false))
            }
            Lobe::LambertianTransmission(_) => {
                Some(self.cosine_sample(wo, cosine_hemisphere(u), true))
            }
            Lobe::SpecularReflection(l) => Some(l.sample(wo)),
            Lobe::SpecularTransmission(l) => l.sample(wo),
            Lobe::FresnelSpecular(l) => l.sample(wo, u.x),
            Lobe::MicrofacetReflection(l) => l.sample(wo, u),
            Lobe::MicrofacetTransmission(l) => l.sample(wo, u),
            Lobe::MirroredReflection(l) => l.sample(wo, u),
            Lobe::FresnelBlend(l) => l.sample(wo, u),
            Lobe::Clearcoat(l) => l.sample(wo, u),
            Lobe::Hair(l) => l.sample(wo, third, u),
            Lobe::Fourier(l) => l.sample(wo, u),
            Lobe::Measured(l) => l.sample(wo, u),
        }
    }

    /// The sample toward `wi`, which is given above the surface and flipped to `wo`'s side or the other.
    #[inline]
    fn cosine_sample(&self, wo: Vec3, wi: Vec3, transmission: bool) -> LobeSample {
        let side = if transmission { -wo.z } else { wo.z };
        let wi = wi.with_z(wi.z.copysign(side));
        let (f, pdf) = self.f_and_pdf(wo, wi);
        LobeSample {
            transmission,
            ..LobeSample::reflected(wi, f, pdf)
        }
    }

    /// The lobe with everything it scatters scaled by `share`.
    pub fn scaled(mut self, share: Rgb) -> Self {
        match &mut self {
            Lobe::LambertianReflection(l) => l.reflectance *= share,
            Lobe::LambertianTransmission(l) => l.transmittance *= share,
            Lobe::OrenNayar(l) => l.reflectance *= share,
            Lobe::SpecularReflection(l) => l.reflectance *= share,
            Lobe::SpecularTransmission(l) => l.transmittance *= share,
            Lobe::FresnelSpecular(l) => {
                l.reflectance *= share;
                l.transmittance *= share;
            }
            Lobe::MicrofacetReflection(l) => l.reflectance *= share,
            Lobe::MicrofacetTransmission(l) => l.transmittance *= share,
            Lobe::MirroredReflection(l) => l.0.reflectance *= share,
            Lobe::FresnelBlend(l) => l.scale *= share,
            Lobe::DisneyDiffuse(l) => {
                l.reflectance *= share;
                l.sheen *= share;
            }
            Lobe::Clearcoat(l) => l.weight *= share,
            Lobe::Hair(l) => l.scale *= share,
            Lobe::SubsurfaceExit(l) => l.factor *= share,
            Lobe::Fourier(l) => l.share *= share,
            Lobe::Measured(l) => l.share *= share,
        }
        self
    }

    /// The single direction a specular lobe reflects or transmits to; `None` for other lobes.
    pub fn specular_direction(&self, wo: Vec3, transmit: bool) -> Option<LobeSample> {
        match (self, transmit) {
            (Lobe::SpecularReflection(l), false) => Some(l.sample(wo)),
            (Lobe::SpecularTransmission(l), true) => l.sample(wo),
            (Lobe::FresnelSpecular(l), false) => Some(l.reflect(wo)),
            (Lobe::FresnelSpecular(l), true) => l.refract(wo),
            _ => None,
        }
    }
}

/// Density of a cosine-distributed direction, 0 unless it `may` be scattered to.
#[inline(always)]
pub(super) fn cosine_pdf(may: bool, cosine: f32) -> f32 {
    if may {
        cosine_hemisphere_pdf(cosine.abs())
    } else {
        0.0
    }
}
