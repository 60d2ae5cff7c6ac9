//! The `uber` material.

use super::inputs::refractive_index;
use super::lobes::{diffuse, glossy, mirror, refraction, straight};
use super::roughness::{Roughness, find_roughness};
use super::{Material, Place, Scattering, may_scatter};
use crate::bsdf::Bsdf;
use crate::bsdf::fresnel::Fresnel;
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::params::ParamReader;

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
    pub roughness: Roughness,
    /// Refractive index of the inside.
    pub eta: FloatInput,
    /// `true` if the two sides' indices are swapped.
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
            roughness: Roughness::new(reader, [u, v.unwrap_or(u)]),
            eta: refractive_index(reader),
            swapped: reader.means_v2(""),
        }
    }
}

impl Scattering for Uber {
    fn is_isotropic(&self) -> bool {
        self.roughness.is_isotropic()
    }

    fn add_lobes(&self, at: &Place, bsdf: &mut Bsdf) {
        let opacity = at.reflectance(&self.opacity);
        let holes = (Rgb::ONE - opacity).max(Rgb::ZERO);
        let [kd, ks, kr, kt] =
            [&self.kd, &self.ks, &self.kr, &self.kt].map(|input| opacity * at.reflectance(input));
        let eta = at.refractive_index(&self.eta);
        let (eta_i, eta_t) = if self.swapped { (eta, 1.0) } else { (1.0, eta) };
        let fresnel = Fresnel::Dielectric { eta_i, eta_t };
        bsdf.extend(straight(holes));
        bsdf.extend(diffuse(kd));
        if !is_black(ks) {
            bsdf.extend(glossy(ks, self.roughness.distribution(at), fresnel));
        }
        bsdf.extend(mirror(kr, fresnel));
        bsdf.extend(refraction(kt, eta_i, eta_t));
    }

    fn max_lobes(&self) -> usize {
        let holes = self.opacity != SpectrumInput::Constant(Rgb::ONE);
        let lobes = [&self.kd, &self.ks, &self.kr, &self.kt].map(may_scatter);
        let lobes = lobes.iter().filter(|&&may| may).count() + usize::from(holes);
        lobes.max(1)
    }

    fn is_smooth(&self, _materials: &[Material]) -> bool {
        let holes = self.opacity != SpectrumInput::Constant(Rgb::ONE);
        let polished = may_scatter(&self.kr) || may_scatter(&self.kt);
        holes || (may_scatter(&self.opacity) && polished)
    }
}
