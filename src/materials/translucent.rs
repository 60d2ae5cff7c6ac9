//! The `translucent` material.

use super::roughness::find_roughness;
use super::{RoughnessMeaning, Scattering, may_scatter, reflectance};
use crate::bsdf::fresnel::Fresnel;
use crate::bsdf::lambertian::{LambertianReflection, LambertianTransmission};
use crate::bsdf::microfacet::{MicrofacetReflection, MicrofacetTransmission, MirroredReflection};
use crate::bsdf::trowbridge_reitz::TrowbridgeReitz;
use crate::bsdf::{Bsdf, Lobe};
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::params::ParamReader;
use crate::surface::TexturePoint;
use crate::textures::Textures;

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
    pub roughness: FloatInput,
    /// How roughness is interpreted.
    pub meaning: RoughnessMeaning,
    /// Whether the glossy transmission is mirrored, not refracted, as in pbrt-v2.
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
            roughness: find_roughness(reader, "roughness").unwrap_or(FloatInput::Constant(0.1)),
            meaning: RoughnessMeaning::from_params(reader),
            mirrored: reader.means_v2(""),
        }
    }

    fn glossy(&self, reflectance: Rgb, distribution: TrowbridgeReitz) -> MicrofacetReflection {
        let (eta_i, eta_t) = if self.mirrored {
            (ETA, 1.0)
        } else {
            (1.0, ETA)
        };
        MicrofacetReflection {
            reflectance,
            distribution,
            fresnel: Fresnel::Dielectric { eta_i, eta_t },
        }
    }
}

impl Scattering for Translucent {
    fn add_lobes(&self, at: &TexturePoint, textures: &Textures, bsdf: &mut Bsdf) {
        let [kd, ks, reflect, transmit] = [&self.kd, &self.ks, &self.reflect, &self.transmit]
            .map(|input| reflectance(input, at, textures));
        let (reflectance, transmittance) = (reflect * kd, transmit * kd);
        if !is_black(reflectance) {
            bsdf.add(Lobe::LambertianReflection(LambertianReflection {
                reflectance,
            }));
        }
        if !is_black(transmittance) {
            bsdf.add(Lobe::LambertianTransmission(LambertianTransmission {
                transmittance,
            }));
        }
        let (reflectance, transmittance) = (reflect * ks, transmit * ks);
        if is_black(reflectance) && is_black(transmittance) {
            return;
        }
        let roughness = textures.float(&self.roughness, at);
        let distribution = self.meaning.distribution(roughness, roughness);
        if !is_black(reflectance) {
            let lobe = self.glossy(reflectance, distribution);
            bsdf.add(Lobe::MicrofacetReflection(lobe));
        }
        if !is_black(transmittance) {
            bsdf.add(if self.mirrored {
                let lobe = self.glossy(transmittance, distribution);
                Lobe::MirroredReflection(MirroredReflection(lobe))
            } else {
                Lobe::MicrofacetTransmission(MicrofacetTransmission {
                    transmittance,
                    distribution,
                    eta_a: 1.0,
                    eta_b: ETA,
                })
            });
        }
    }

    fn max_lobes(&self) -> usize {
        let count =
            |inputs: [&SpectrumInput; 2]| inputs.into_iter().filter(|i| may_scatter(i)).count();
        (count([&self.kd, &self.ks]) * count([&self.reflect, &self.transmit])).max(1)
    }
}
