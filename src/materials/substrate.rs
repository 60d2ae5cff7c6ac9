//! The `substrate` material.

use super::roughness::Roughness;
use super::{Place, Scattering};
use crate::bsdf::fresnel_blend::FresnelBlend;
use crate::bsdf::{Bsdf, Lobe};
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::params::ParamReader;

/// A diffuse base under a glossy coat (Ashikhmin and Shirley 2000). Parameters: spectrum `Kd` (0.5), `Ks` (0.5); float
/// `uroughness`, `vroughness` (0.1) (like pbrt, there is no `roughness` here); constant bool `remaproughness` (true).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Substrate {
    /// Reflectance of the base.
    pub kd: SpectrumInput,
    /// Reflectance of the coat at normal incidence.
    pub ks: SpectrumInput,
    /// Roughness of the coat along u and v.
    pub roughness: Roughness,
}

impl Substrate {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Substrate {
        Substrate {
            kd: reader.spectrum_input("Kd", Rgb::splat(0.5)),
            ks: reader.spectrum_input("Ks", Rgb::splat(0.5)),
            roughness: Roughness::anisotropic(reader, FloatInput::Constant(0.1)),
        }
    }
}

impl Scattering for Substrate {
    fn is_isotropic(&self) -> bool {
        self.roughness.is_isotropic()
    }

    fn add_lobes(&self, at: &Place, bsdf: &mut Bsdf) {
        let [diffuse, specular] = [&self.kd, &self.ks].map(|k| at.reflectance(k));
        if is_black(diffuse) && is_black(specular) {
            return;
        }
        bsdf.add(Lobe::FresnelBlend(FresnelBlend {
            diffuse,
            specular,
            distribution: self.roughness.distribution(at),
            scale: Rgb::ONE,
        }));
    }
}
