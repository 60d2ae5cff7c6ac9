//! The `glass` material.

use super::inputs::refractive_index;
use super::lobes::{UNBENT, glossy, into_index, rough_refraction};
use super::place::{as_reflectance, as_refractive_index};
use super::roughness::{Roughness, find_roughness};
use super::{Material, Place, Scattering, may_scatter};
use crate::bsdf::specular::FresnelSpecular;
use crate::bsdf::{Boundary, Bsdf, Lobe};
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::params::ParamReader;

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
    pub roughness: Roughness,
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
            roughness: Roughness::new(reader, roughness),
        }
    }
}

/// The lobe of a smooth surface, if it scatters anything.
fn smooth<'a>(reflectance: Rgb, transmittance: Rgb, eta_b: f32) -> Option<Lobe<'a>> {
    let boundary = FresnelSpecular {
        reflectance,
        transmittance,
        eta_a: 1.0,
        eta_b,
        evenness: 0.0,
    };
    let is_lit = !is_black(reflectance) || !is_black(transmittance);
    is_lit.then_some(Lobe::FresnelSpecular(boundary))
}

impl Scattering for Glass {
    fn is_isotropic(&self) -> bool {
        self.roughness.is_isotropic()
    }

    fn add_lobes(&self, at: &Place, bsdf: &mut Bsdf) {
        let (reflectance, transmittance) = (at.reflectance(&self.kr), at.reflectance(&self.kt));
        let eta_b = at.refractive_index(&self.eta);
        if let Some(distribution) = self.roughness.facets(at) {
            bsdf.extend(glossy(reflectance, distribution, into_index(eta_b)));
            bsdf.extend(rough_refraction(transmittance, distribution, eta_b));
        } else {
            bsdf.extend(smooth(reflectance, transmittance, eta_b));
        }
    }

    fn even_boundary(&self) -> Option<Boundary> {
        let (SpectrumInput::Constant(kr), SpectrumInput::Constant(kt), FloatInput::Constant(eta)) =
            (self.kr, self.kt, self.eta)
        else {
            return None;
        };
        if !self.roughness.is_smooth() {
            return None;
        }
        let (kr, kt) = (as_reflectance(kr), as_reflectance(kt));
        Boundary::of(&smooth(kr, kt, as_refractive_index(eta))?)
    }

    fn max_lobes(&self) -> usize {
        2
    }

    fn is_smooth(&self, _materials: &[Material]) -> bool {
        let colored = may_scatter(&self.kr) || may_scatter(&self.kt);
        let unbending = |eta: &FloatInput| matches!(eta, FloatInput::Constant(eta) if (eta - 1.0).abs() < UNBENT);
        let polished = self.roughness.is_smooth();
        (polished && colored) || (unbending(&self.eta) && may_scatter(&self.kt))
    }

    fn scatters_widely(&self) -> bool {
        !self.is_smooth(&[])
    }
}
