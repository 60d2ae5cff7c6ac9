//! The lobes that several materials have; none of a black color.

use crate::bsdf::Lobe;
use crate::bsdf::fresnel::Fresnel;
use crate::bsdf::lambertian::{LambertianReflection, LambertianTransmission};
use crate::bsdf::microfacet::{MicrofacetReflection, MicrofacetTransmission};
use crate::bsdf::specular::{SpecularReflection, SpecularTransmission};
use crate::bsdf::trowbridge_reitz::TrowbridgeReitz;
use crate::math::Rgb;
use crate::math::color::is_black;

/// Refractive indices this close to 1 deflect light by less than the half vector can resolve: it is transmitted
/// straight.
pub(super) const UNBENT: f32 = 1e-4;

/// The Fresnel reflectance of a boundary into the refractive index `eta`.
pub(super) fn into_index(eta: f32) -> Fresnel {
    let eta_i = 1.0;
    Fresnel::Dielectric { eta_i, eta_t: eta }
}

/// Diffuse reflection.
pub(super) fn diffuse<'a>(reflectance: Rgb) -> Option<Lobe<'a>> {
    let lobe = LambertianReflection { reflectance };
    (!is_black(reflectance)).then_some(Lobe::LambertianReflection(lobe))
}

/// Diffuse transmission.
pub(super) fn diffuse_transmission<'a>(transmittance: Rgb) -> Option<Lobe<'a>> {
    let lobe = LambertianTransmission { transmittance };
    (!is_black(transmittance)).then_some(Lobe::LambertianTransmission(lobe))
}

/// Glossy reflection.
pub(super) fn glossy<'a>(
    reflectance: Rgb,
    distribution: TrowbridgeReitz,
    fresnel: Fresnel,
) -> Option<Lobe<'a>> {
    let lobe = MicrofacetReflection {
        reflectance,
        distribution,
        fresnel,
    };
    (!is_black(reflectance)).then_some(Lobe::MicrofacetReflection(lobe))
}

/// A mirror.
pub(super) fn mirror<'a>(reflectance: Rgb, fresnel: Fresnel) -> Option<Lobe<'a>> {
    let lobe = SpecularReflection {
        reflectance,
        fresnel,
    };
    (!is_black(reflectance)).then_some(Lobe::SpecularReflection(lobe))
}

/// Refraction through a smooth boundary, from the index on the normal's side to that on the other.
pub(super) fn refraction<'a>(transmittance: Rgb, eta_a: f32, eta_b: f32) -> Option<Lobe<'a>> {
    let lobe = SpecularTransmission {
        transmittance,
        eta_a,
        eta_b,
    };
    (!is_black(transmittance)).then_some(Lobe::SpecularTransmission(lobe))
}

/// Light that goes straight on.
pub(super) fn straight<'a>(transmittance: Rgb) -> Option<Lobe<'a>> {
    refraction(transmittance, 1.0, 1.0)
}

/// Refraction through a rough boundary into the refractive index `eta`.
pub(super) fn rough_refraction<'a>(
    transmittance: Rgb,
    distribution: TrowbridgeReitz,
    eta: f32,
) -> Option<Lobe<'a>> {
    if (eta - 1.0).abs() < UNBENT {
        return straight(transmittance);
    }
    let lobe = MicrofacetTransmission {
        transmittance,
        distribution,
        eta_a: 1.0,
        eta_b: eta,
    };
    (!is_black(transmittance)).then_some(Lobe::MicrofacetTransmission(lobe))
}
