//! The `translucent` material.

use super::lobes::{diffuse, diffuse_transmission, glossy, into_index, rough_refraction};
use super::roughness::Roughness;
use super::{Place, Scattering, may_scatter};
use crate::bsdf::fresnel::Fresnel;
use crate::bsdf::microfacet::{MicrofacetReflection, MirroredReflection};
use crate::bsdf::{Bsdf, Lobe};
use crate::inputs::SpectrumInput;
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::params::ParamReader;

/// Refractive index inside; pbrt has no parameter for it.
const ETA: f32 = 1.5;

/// Diffuse and glossy reflection and transmission. Parameters: spectrum `Kd` (0.25), `Ks` (0.25), `reflect` (0.5),
/// `transmit` (0.5): the fractions of both that are reflected and transmitted; float `roughness` (0.1); constant bool
/// `remaproughness` (true).
///
/// In pbrt-v2's language the glossy transmission is the reflection mirrored through the surface instead of refracted,
/// and the two sides' indices are swapped, a bug like [`Plastic`](super::Plastic)'s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Translucent {
    /// Color of the diffuse part.
    pub kd: SpectrumInput,
    /// Color of the glossy part.
    pub ks: SpectrumInput,
    /// Fraction reflected.
    pub reflect: SpectrumInput,
    /// Fraction transmitted.
    pub transmit: SpectrumInput,
    /// Roughness of the glossy part.
    pub roughness: Roughness,
    /// `true` if the glossy transmission is mirrored, not refracted, as in pbrt-v2.
    pub mirrored: bool,
}

impl Translucent {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Translucent {
        Translucent {
            kd: reader.spectrum_input("Kd", Rgb::splat(0.25)),
            ks: reader.spectrum_input("Ks", Rgb::splat(0.25)),
            reflect: reader.spectrum_input("reflect", Rgb::splat(0.5)),
            transmit: reader.spectrum_input("transmit", Rgb::splat(0.5)),
            roughness: Roughness::isotropic(reader),
            mirrored: reader.means_v2(""),
        }
    }

    /// Fresnel reflectance of the boundary.
    fn fresnel(&self) -> Fresnel {
        match self.mirrored {
            true => Fresnel::Dielectric {
                eta_i: ETA,
                eta_t: 1.0,
            },
            false => into_index(ETA),
        }
    }
}

impl Scattering for Translucent {
    fn add_lobes(&self, at: &Place, bsdf: &mut Bsdf) {
        let [kd, ks, reflect, transmit] =
            [&self.kd, &self.ks, &self.reflect, &self.transmit].map(|input| at.reflectance(input));
        bsdf.extend(diffuse(reflect * kd));
        bsdf.extend(diffuse_transmission(transmit * kd));
        let (reflectance, transmittance) = (reflect * ks, transmit * ks);
        if is_black(reflectance) && is_black(transmittance) {
            return;
        }
        let distribution = self.roughness.distribution(at);
        bsdf.extend(glossy(reflectance, distribution, self.fresnel()));
        if !self.mirrored {
            bsdf.extend(rough_refraction(transmittance, distribution, ETA));
        } else if !is_black(transmittance) {
            bsdf.add(Lobe::MirroredReflection(MirroredReflection(
                MicrofacetReflection {
                    reflectance: transmittance,
                    distribution,
                    fresnel: self.fresnel(),
                },
            )));
        }
    }

    fn max_lobes(&self) -> usize {
        let count =
            |inputs: [&SpectrumInput; 2]| inputs.into_iter().filter(|i| may_scatter(i)).count();
        (count([&self.kd, &self.ks]) * count([&self.reflect, &self.transmit])).max(1)
    }
}
