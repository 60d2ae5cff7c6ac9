//! The `plastic` material.

use super::roughness::find_roughness;
use super::{RoughnessMeaning, Scattering, reflectance};
use crate::bsdf::fresnel::Fresnel;
use crate::bsdf::lambertian::LambertianReflection;
use crate::bsdf::microfacet::MicrofacetReflection;
use crate::bsdf::{Bsdf, Lobe};
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::params::ParamReader;
use crate::surface::TexturePoint;
use crate::textures::Textures;

/// A diffuse base with a glossy coat. Parameters: spectrum `Kd` (0.25), `Ks` (0.25); float
/// `roughness` (0.1); constant bool `remaproughness` (true).
///
/// As in pbrt, the coat's Fresnel reflectance is that of light going from index 1.5 into 1, which is total beyond
/// 41.8°: a bug of the reference that scenes have been tuned to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plastic {
    /// Diffuse reflectance.
    pub kd: SpectrumInput,
    /// Scale of the glossy reflection.
    pub ks: SpectrumInput,
    /// Roughness of the coat.
    pub roughness: FloatInput,
    /// How roughness is interpreted.
    pub meaning: RoughnessMeaning,
}

impl Plastic {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Plastic {
        Plastic {
            kd: reader.spectrum_input("Kd", Rgb::splat(0.25)),
            ks: reader.spectrum_input("Ks", Rgb::splat(0.25)),
            roughness: find_roughness(reader, "roughness").unwrap_or(FloatInput::Constant(0.1)),
            meaning: RoughnessMeaning::from_params(reader),
        }
    }
}

impl Scattering for Plastic {
    fn add_lobes(&self, at: &TexturePoint, textures: &Textures, bsdf: &mut Bsdf) {
        let kd = reflectance(&self.kd, at, textures);
        if !is_black(kd) {
            bsdf.add(Lobe::LambertianReflection(LambertianReflection {
                reflectance: kd,
            }));
        }
        let ks = reflectance(&self.ks, at, textures);
        if !is_black(ks) {
            let roughness = textures.float(&self.roughness, at);
            bsdf.add(Lobe::MicrofacetReflection(MicrofacetReflection {
                reflectance: ks,
                distribution: self.meaning.distribution(roughness, roughness),
                fresnel: Fresnel::Dielectric {
                    eta_i: 1.5,
                    eta_t: 1.0,
                },
            }));
        }
    }

    fn max_lobes(&self) -> usize {
        2
    }
}
