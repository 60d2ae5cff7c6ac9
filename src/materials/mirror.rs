//! The `mirror` material.

use super::lobes::mirror;
use super::place::as_reflectance;
use super::{Material, Place, Scattering, may_scatter};
use crate::bsdf::fresnel::Fresnel;
use crate::bsdf::{Boundary, Bsdf};
use crate::inputs::SpectrumInput;
use crate::math::Rgb;
use crate::params::ParamReader;

/// Perfect specular reflection, the same at all angles. Parameter: spectrum `Kr` (0.9).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// Reflectance.
    pub kr: SpectrumInput,
}

impl Mirror {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Mirror {
        Mirror {
            kr: reader.spectrum_input("Kr", Rgb::splat(0.9)),
        }
    }
}

impl Scattering for Mirror {
    fn add_lobes(&self, at: &Place, bsdf: &mut Bsdf) {
        bsdf.extend(mirror(at.reflectance(&self.kr), Fresnel::NoOp));
    }

    fn even_boundary(&self) -> Option<Boundary> {
        let SpectrumInput::Constant(kr) = self.kr else {
            return None;
        };
        Boundary::of(&mirror(as_reflectance(kr), Fresnel::NoOp)?)
    }

    fn is_smooth(&self, _materials: &[Material]) -> bool {
        may_scatter(&self.kr)
    }

    fn scatters_widely(&self) -> bool {
        false
    }
}
