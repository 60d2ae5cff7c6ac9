//! The `uber` material.

use super::inputs::{refractive_index, refractive_index_at};
use super::roughness::find_roughness;
use super::{RoughnessMeaning, Scattering, may_scatter, reflectance};
use crate::bsdf::fresnel::Fresnel;
use crate::bsdf::lambertian::LambertianReflection;
use crate::bsdf::microfacet::MicrofacetReflection;
use crate::bsdf::specular::{SpecularReflection, SpecularTransmission};
use crate::bsdf::{Bsdf, Lobe};
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::params::ParamReader;
use crate::surface::TexturePoint;
use crate::textures::Textures;

/// Diffuse and glossy reflection, mirror reflection, refraction and opacity combined. Parameters: spectrum `Kd` (0.25),
/// `Ks` (0.25), `Kr` (0), `Kt` (0), all scaled by spectrum `opacity` (1), while 1 − opacity of the light is transmitted
/// straight; float `roughness` (0.1), `uroughness` (roughness), `vroughness` (that along u); float `eta`, else `index`
/// (1.5); constant bool `remaproughness` (true).
///
/// In pbrt-v2's language the two sides' indices are swapped in all its lobes, a bug like [`Plastic`](super::Plastic)'s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uber {
    /// Diffuse reflectance.
    pub kd: SpectrumInput,
    /// Scale of the glossy reflection.
    pub ks: SpectrumInput,
    /// Scale of the mirror reflection.
    pub kr: SpectrumInput,
    /// Scale of the refraction.
    pub kt: SpectrumInput,
    /// Fraction of light that interacts with the surface at all.
    pub opacity: SpectrumInput,
    /// Roughness along u and v.
    pub roughness: [FloatInput; 2],
    /// How roughnesses are interpreted.
    pub meaning: RoughnessMeaning,
    /// Refractive index of the inside.
    pub eta: FloatInput,
    /// Whether the two sides' indices are swapped.
    pub swapped: bool,
}

impl Uber {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Uber {
        let roughness = find_roughness(reader, "roughness").unwrap_or(FloatInput::Constant(0.1));
        let [u, v] = ["uroughness", "vroughness"].map(|name| find_roughness(reader, name));
        let u = u.unwrap_or(roughness);
        Uber {
            kd: reader.spectrum_input("Kd", Rgb::splat(0.25)),
            ks: reader.spectrum_input("Ks", Rgb::splat(0.25)),
            kr: reader.spectrum_input("Kr", Rgb::ZERO),
            kt: reader.spectrum_input("Kt", Rgb::ZERO),
            opacity: reader.spectrum_input("opacity", Rgb::ONE),
            roughness: [u, v.unwrap_or(u)],
            meaning: RoughnessMeaning::from_params(reader),
            eta: refractive_index(reader),
            swapped: reader.means_v2(""),
        }
    }
}

impl Scattering for Uber {
    fn add_lobes(&self, at: &TexturePoint, textures: &Textures, bsdf: &mut Bsdf) {
        let factor = |input| reflectance(input, at, textures);
        let opacity = factor(&self.opacity);
        let holes = (Rgb::ONE - opacity).max(Rgb::ZERO);
        let [kd, ks, kr, kt] =
            [&self.kd, &self.ks, &self.kr, &self.kt].map(|input| opacity * factor(input));
        let eta = refractive_index_at(&self.eta, at, textures);
        let (eta_a, eta_b) = if self.swapped { (eta, 1.0) } else { (1.0, eta) };
        let fresnel = Fresnel::Dielectric {
            eta_i: eta_a,
            eta_t: eta_b,
        };
        if !is_black(holes) {
            let lobe = SpecularTransmission {
                transmittance: holes,
                eta_a: 1.0,
                eta_b: 1.0,
            };
            bsdf.add(Lobe::SpecularTransmission(lobe));
        }
        if !is_black(kd) {
            bsdf.add(Lobe::LambertianReflection(LambertianReflection {
                reflectance: kd,
            }));
        }
        if !is_black(ks) {
            let [u, v] = self.roughness.map(|r| textures.float(&r, at));
            let distribution = self.meaning.distribution(u, v);
            bsdf.add(Lobe::MicrofacetReflection(MicrofacetReflection {
                reflectance: ks,
                distribution,
                fresnel,
            }));
        }
        if !is_black(kr) {
            bsdf.add(Lobe::SpecularReflection(SpecularReflection {
                reflectance: kr,
                fresnel,
            }));
        }
        if !is_black(kt) {
            bsdf.add(Lobe::SpecularTransmission(SpecularTransmission {
                transmittance: kt,
                eta_a,
                eta_b,
            }));
        }
    }

    fn max_lobes(&self) -> usize {
        let holes = self.opacity != SpectrumInput::Constant(Rgb::ONE);
        let lobes = [&self.kd, &self.ks, &self.kr, &self.kt].map(may_scatter);
        let lobes = lobes.iter().filter(|&&may| may).count() + usize::from(holes);
        lobes.max(1)
    }

    fn is_smooth(&self) -> bool {
        let holes = self.opacity != SpectrumInput::Constant(Rgb::ONE);
        let polished = super::may_scatter(&self.kr) || super::may_scatter(&self.kt);
        holes || (super::may_scatter(&self.opacity) && polished)
    }
}
