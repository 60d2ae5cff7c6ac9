//! The `glass` material.

use super::inputs::{refractive_index, refractive_index_at};
use super::roughness::{UNBENT, add_rough_refraction, find_roughness};
use super::{RoughnessMeaning, Scattering, may_scatter, reflectance};
use crate::bsdf::fresnel::Fresnel;
use crate::bsdf::microfacet::MicrofacetReflection;
use crate::bsdf::specular::FresnelSpecular;
use crate::bsdf::{Bsdf, Lobe};
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::params::ParamReader;
use crate::surface::TexturePoint;
use crate::textures::Textures;

/// A dielectric boundary; the geometric normal points to the outside, whose index is 1. Parameters: spectrum `Kr` (1),
/// `Kt` (1); float `eta`, else `index` (1.5); float `uroughness`, `vroughness` (0): smooth if both are 0 (like pbrt,
/// there is no `roughness` here); constant bool `remaproughness` (true). In pbrt-v2's language only `Kr`, `Kt` and
/// `index`, always smooth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glass {
    /// Scale of the reflected light.
    pub kr: SpectrumInput,
    /// Scale of the refracted light.
    pub kt: SpectrumInput,
    /// Refractive index of the inside.
    pub eta: FloatInput,
    /// Roughness along u and v.
    pub roughness: [FloatInput; 2],
    /// How roughnesses are interpreted.
    pub meaning: RoughnessMeaning,
}

impl Glass {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Glass {
        let smooth = FloatInput::Constant(0.0);
        let roughness =
            ["uroughness", "vroughness"].map(|name| find_roughness(reader, name).unwrap_or(smooth));
        Glass {
            kr: reader.spectrum_input("Kr", Rgb::ONE),
            kt: reader.spectrum_input("Kt", Rgb::ONE),
            eta: refractive_index(reader),
            roughness,
            meaning: RoughnessMeaning::from_params(reader),
        }
    }
}

impl Scattering for Glass {
    fn add_lobes(&self, at: &TexturePoint, textures: &Textures, bsdf: &mut Bsdf) {
        let reflectance_of = |input| reflectance(input, at, textures);
        let (reflectance, transmittance) = (reflectance_of(&self.kr), reflectance_of(&self.kt));
        let eta_b = refractive_index_at(&self.eta, at, textures);
        let [u, v] = self.roughness.map(|r| textures.float(&r, at));
        if u == 0.0 && v == 0.0 {
            if !is_black(reflectance) || !is_black(transmittance) {
                let lobe = FresnelSpecular {
                    reflectance,
                    transmittance,
                    eta_a: 1.0,
                    eta_b,
                };
                bsdf.add(Lobe::FresnelSpecular(lobe));
            }
            return;
        }
        let distribution = self.meaning.distribution(u, v);
        if !is_black(reflectance) {
            let fresnel = Fresnel::Dielectric {
                eta_i: 1.0,
                eta_t: eta_b,
            };
            bsdf.add(Lobe::MicrofacetReflection(MicrofacetReflection {
                reflectance,
                distribution,
                fresnel,
            }));
        }
        if !is_black(transmittance) {
            add_rough_refraction(bsdf, transmittance, distribution, eta_b);
        }
    }

    fn max_lobes(&self) -> usize {
        2
    }

    fn is_smooth(&self) -> bool {
        let colored = may_scatter(&self.kr) || may_scatter(&self.kt);
        let unbending = |eta: &FloatInput| matches!(eta, FloatInput::Constant(eta) if (eta - 1.0).abs() < UNBENT);
        let polished = self.roughness == [FloatInput::Constant(0.0); 2];
        (polished && colored) || (unbending(&self.eta) && may_scatter(&self.kt))
    }

    fn scatters_widely(&self) -> bool {
        !self.is_smooth()
    }
}
