//! The `mirror` material.

use super::{Scattering, reflectance};
use crate::bsdf::fresnel::Fresnel;
use crate::bsdf::specular::SpecularReflection;
use crate::bsdf::{Bsdf, Lobe};
use crate::inputs::SpectrumInput;
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::params::ParamReader;
use crate::surface::TexturePoint;
use crate::textures::Textures;

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
    fn add_lobes(&self, at: &TexturePoint, textures: &Textures, bsdf: &mut Bsdf) {
        let reflectance = reflectance(&self.kr, at, textures);
        if !is_black(reflectance) {
            bsdf.add(Lobe::SpecularReflection(SpecularReflection {
                reflectance,
                fresnel: Fresnel::NoOp,
            }));
        }
    }

    fn is_smooth(&self) -> bool {
        super::may_scatter(&self.kr)
    }

    fn scatters_widely(&self) -> bool {
        false
    }
}
