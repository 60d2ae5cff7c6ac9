//! The `substrate` material.

use super::roughness::find_roughness;
use super::{RoughnessMeaning, Scattering, reflectance};
use crate::bsdf::fresnel_blend::FresnelBlend;
use crate::bsdf::{Bsdf, Lobe};
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::params::ParamReader;
use crate::surface::TexturePoint;
use crate::textures::Textures;

/// A diffuse base under a glossy coat (Ashikhmin and Shirley 2000). Parameters: spectrum `Kd` (0.5), `Ks` (0.5); float
/// `uroughness`, `vroughness` (0.1) (like pbrt, there is no `roughness` here); constant bool `remaproughness` (true).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Substrate {
    /// Reflectance of the base.
    pub kd: SpectrumInput,
    /// Reflectance of the coat at normal incidence.
    pub ks: SpectrumInput,
    /// Roughness of the coat along u and v.
    pub roughness: [FloatInput; 2],
    /// How roughnesses are interpreted.
    pub meaning: RoughnessMeaning,
}

impl Substrate {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Substrate {
        let roughness = |name| find_roughness(reader, name).unwrap_or(FloatInput::Constant(0.1));
        Substrate {
            kd: reader.spectrum_input("Kd", Rgb::splat(0.5)),
            ks: reader.spectrum_input("Ks", Rgb::splat(0.5)),
            roughness: [roughness("uroughness"), roughness("vroughness")],
            meaning: RoughnessMeaning::from_params(reader),
        }
    }
}

impl Scattering for Substrate {
    fn add_lobes(&self, at: &TexturePoint, textures: &Textures, bsdf: &mut Bsdf) {
        let [diffuse, specular] = [&self.kd, &self.ks].map(|k| reflectance(k, at, textures));
        if is_black(diffuse) && is_black(specular) {
            return;
        }
        let [u, v] = self.roughness.map(|r| textures.float(&r, at));
        bsdf.add(Lobe::FresnelBlend(FresnelBlend {
            diffuse,
            specular,
            distribution: self.meaning.distribution(u, v),
            scale: Rgb::ONE,
        }));
    }
}
