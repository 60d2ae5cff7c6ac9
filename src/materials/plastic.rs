//! The `plastic` material.

use super::lobes::{diffuse, glossy};
use super::place::as_reflectance;
use super::roughness::Roughness;
use super::{Place, Scattering};
use crate::bsdf::fresnel::Fresnel;
use crate::bsdf::{Bsdf, CoatedLobes};
use crate::inputs::SpectrumInput;
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::params::ParamReader;

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
    pub roughness: Roughness,
}

const COAT: Fresnel = Fresnel::Dielectric {
    eta_i: 1.5,
    eta_t: 1.0,
};

impl Plastic {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Plastic {
        Plastic {
            kd: reader.spectrum_input("Kd", Rgb::splat(0.25)),
            ks: reader.spectrum_input("Ks", Rgb::splat(0.25)),
            roughness: Roughness::isotropic(reader),
        }
    }
}

impl Scattering for Plastic {
    fn add_lobes(&self, at: &Place, bsdf: &mut Bsdf) {
        bsdf.extend(diffuse(at.reflectance(&self.kd)));
        let ks = at.reflectance(&self.ks);
        if !is_black(ks) {
            bsdf.extend(glossy(ks, self.roughness.distribution(at), COAT));
        }
    }

    fn even_coat(&self) -> Option<CoatedLobes> {
        let (SpectrumInput::Constant(kd), SpectrumInput::Constant(ks)) = (self.kd, self.ks) else {
            return None;
        };
        let lobes = [
            diffuse(as_reflectance(kd))?,
            glossy(
                as_reflectance(ks),
                self.roughness.even_distribution()?,
                COAT,
            )?,
        ];
        CoatedLobes::of(&lobes)
    }

    fn max_lobes(&self) -> usize {
        2
    }
}
