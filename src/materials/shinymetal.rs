//! The `shinymetal` material.

use super::lobes::{glossy, mirror};
use super::roughness::Roughness;
use super::{Material, Place, Scattering};
use crate::bsdf::Bsdf;
use crate::bsdf::fresnel::Fresnel;
use crate::inputs::SpectrumInput;
use crate::math::Rgb;
use crate::params::ParamReader;

/// pbrt-v2's glossy metal with a mirror reflection; pbrt-v3 has none. Parameters: spectrum `Ks`, `Kr` (1): reflectance
/// of the two at normal incidence; float `roughness` (0.1). Their Fresnel reflectance is that of a conductor without
/// absorption that reflects as much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShinyMetal {
    /// Reflectance of the glossy part.
    pub ks: SpectrumInput,
    /// Reflectance of the mirror.
    pub kr: SpectrumInput,
    /// Roughness of the glossy part.
    pub roughness: Roughness,
}

impl ShinyMetal {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> ShinyMetal {
        ShinyMetal {
            ks: reader.spectrum_input("Ks", Rgb::ONE),
            kr: reader.spectrum_input("Kr", Rgb::ONE),
            roughness: Roughness::isotropic(reader),
        }
    }
}

impl Scattering for ShinyMetal {
    fn add_lobes(&self, at: &Place, bsdf: &mut Bsdf) {
        let [of_glossy, of_mirror] = [&self.ks, &self.kr].map(|k| Fresnel::Conductor {
            eta: index_of(at.reflectance(k)),
            k: Rgb::ZERO,
        });
        let distribution = self.roughness.distribution(at);
        bsdf.extend(glossy(Rgb::ONE, distribution, of_glossy));
        bsdf.extend(mirror(Rgb::ONE, of_mirror));
    }

    fn max_lobes(&self) -> usize {
        2
    }

    fn is_smooth(&self, _materials: &[Material]) -> bool {
        true
    }
}

/// The index whose Fresnel reflectance at normal incidence, ((η − 1)/(η + 1))², is this; reflectances are limited to
/// 0.999, since nothing reflects everything.
fn index_of(reflectance: Rgb) -> Rgb {
    let amplitude = reflectance.min(Rgb::splat(0.999)).map(f32::sqrt);
    (1.0 + amplitude) / (1.0 - amplitude)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_index_reflects_what_was_asked_for() {
        let asked = Rgb::new(0.0, 0.25, 0.9);
        let fresnel = Fresnel::Conductor {
            eta: index_of(asked),
            k: Rgb::ZERO,
        };
        // Rounding, magnified by an index of 38.
        assert!((fresnel.evaluate(1.0) - asked).abs().max_element() < 1e-5);
    }
}
