//! The `matte` material.

use super::lobes::diffuse;
use super::place::as_reflectance;
use super::{Place, Scattering};
use crate::bsdf::oren_nayar::OrenNayar;
use crate::bsdf::{Bsdf, Lobe};
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::params::ParamReader;

/// Diffuse reflection. Parameters: spectrum `Kd` (0.5); float `sigma` (0): standard deviation of the facets'
/// inclination in degrees, clamped to 0…90; 0 is Lambertian, anything else Oren–Nayar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matte {
    /// Reflectance.
    pub kd: SpectrumInput,
    /// Roughness in degrees.
    pub sigma: FloatInput,
}

impl Matte {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Matte {
        let kd = reader.spectrum_input("Kd", Rgb::splat(0.5));
        let sigma = reader.float_input("sigma", 0.0);
        if let FloatInput::Constant(given) = sigma
            && !(0.0..=90.0).contains(&given)
        {
            // Negative and NaN: Lambertian, as 0.
            let used = if given > 90.0 { 90 } else { 0 };
            let message = format!("`sigma` is {given} degrees, outside 0 to 90: {used} is used");
            reader.warn("sigma", message);
        }
        Matte { kd, sigma }
    }
}

impl Scattering for Matte {
    fn even_reflectance(&self) -> Option<Rgb> {
        let (SpectrumInput::Constant(kd), FloatInput::Constant(sigma)) = (self.kd, self.sigma)
        else {
            return None;
        };
        let reflectance = as_reflectance(kd);
        // NaN: Lambertian.
        let is_rough = sigma > 0.0;
        (!is_rough && !is_black(reflectance)).then_some(reflectance)
    }

    fn add_lobes(&self, at: &Place, bsdf: &mut Bsdf) {
        let reflectance = at.reflectance(&self.kd);
        if is_black(reflectance) {
            return;
        }
        let sigma = at.within(&self.sigma, 0.0, 90.0);
        if sigma > 0.0 {
            bsdf.add(Lobe::OrenNayar(OrenNayar::new(reflectance, sigma)));
        } else {
            bsdf.extend(diffuse(reflectance));
        }
    }
}
