//! The `metal` material.

use super::lobes::glossy;
use super::roughness::{Roughness, find_roughness};
use super::{Place, Scattering};
use crate::bsdf::Bsdf;
use crate::bsdf::fresnel::Fresnel;
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::Rgb;
use crate::params::ParamReader;

/// Refractive index of copper: pbrt's 56 samples from 299 to 886 nm converted to RGB (docs/scene-language.md §6.2).
const COPPER_ETA: Rgb = Rgb::new(0.19999, 0.92209, 1.09988);

/// Its absorption coefficient, likewise.
const COPPER_K: Rgb = Rgb::new(3.90464, 2.44763, 2.13765);

/// A rough conductor. Parameters: spectrum `eta` and `k`, real and imaginary part of the refractive
/// index (copper's); float `roughness` (0.01), which `uroughness` and `vroughness` override;
/// constant bool `remaproughness` (true) (docs/scene-language.md §3.8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metal {
    /// Real part of the refractive index.
    pub eta: SpectrumInput,
    /// Imaginary part.
    pub k: SpectrumInput,
    /// Roughness.
    pub roughness: Roughness,
}

impl Metal {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Metal {
        let both = find_roughness(reader, "roughness").unwrap_or(FloatInput::Constant(0.01));
        Metal {
            eta: reader.spectrum_input("eta", COPPER_ETA),
            k: reader.spectrum_input("k", COPPER_K),
            roughness: Roughness::anisotropic(reader, both),
        }
    }
}

impl Scattering for Metal {
    fn is_isotropic(&self) -> bool {
        self.roughness.is_isotropic()
    }

    fn add_lobes(&self, at: &Place, bsdf: &mut Bsdf) {
        // Only the squares matter; beyond the bound everything is reflected anyway.
        let [eta, k] =
            [&self.eta, &self.k].map(|input| at.spectrum(input).map(|x| x.abs().min(1e4)));
        let distribution = self.roughness.distribution(at);
        bsdf.extend(glossy(
            Rgb::ONE,
            distribution,
            Fresnel::Conductor { eta, k },
        ));
    }
}
