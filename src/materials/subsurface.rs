//! The `subsurface` material.

use super::Place;
use super::interior::{Extinction, Inside, Interior};
use crate::inputs::SpectrumInput;
use crate::math::Rgb;
use crate::media::presets::{self, Coefficients};
use crate::params::ParamReader;
use crate::syntax::suggest::nearest;

/// A medium of given coefficients below a dielectric boundary (docs/scene-language.md §3.8). Parameters:
/// spectrum `sigma_a` ((0.0011, 0.0024, 0.014)) and `sigma_s` ((2.55, 3.21, 3.77)), absorption and
/// scattering, per scene unit once they are multiplied with `scale`; constant string `name` (none)
/// gives measured ones per mm instead, for which `g` is 0; and those of `Interior`.
/// In pbrt-v2's language `sigma_prime_s` means `sigma_s`.
#[derive(Clone, Debug, PartialEq)]
pub struct Subsurface {
    /// Absorption before scaling.
    pub sigma_a: SpectrumInput,
    /// Scattering before scaling.
    pub sigma_s: SpectrumInput,
    /// Boundary and other properties.
    pub interior: Interior,
}

impl Subsurface {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Subsurface {
        let measured = measured(reader);
        let mut interior = Interior::from_params(reader);
        if measured.is_some() {
            // Reduced coefficients include the mean cosine.
            interior.g = 0.0;
        }
        let usual = measured.unwrap_or(presets::WHOLE_MILK);
        let sigma_s = reader.spelling("sigma_s");
        Subsurface {
            sigma_a: reader.spectrum_input("sigma_a", usual.sigma_a),
            sigma_s: reader.spectrum_input(sigma_s, usual.sigma_s),
            interior,
        }
    }
}

impl Inside for Subsurface {
    fn interior(&self) -> &Interior {
        &self.interior
    }

    fn interior_mut(&mut self) -> &mut Interior {
        &mut self.interior
    }

    /// Coefficients below 0 count as 0.
    fn medium(&self, at: &Place) -> Option<Extinction> {
        let [absorption, scattering] =
            [&self.sigma_a, &self.sigma_s].map(|sigma| self.interior.scale * at.reflectance(sigma));
        let extinction = absorption + scattering;
        Some(Extinction {
            albedo: scattering / extinction.max(Rgb::splat(f32::MIN_POSITIVE)),
            mean_free_path: extinction.recip(),
        })
    }
}

/// The measured coefficients called `name`.
fn measured(reader: &ParamReader) -> Option<Coefficients> {
    let name = reader.find_string("name").filter(|name| !name.is_empty())?;
    let found = presets::find(name);
    if found.is_none() {
        let hint = nearest(name, presets::names()).map_or(String::new(), |similar| {
            format!("; did you mean `{similar}`?")
        });
        reader.warn(
            "name",
            format!("no coefficients are known of `{name}`: the usual ones are used{hint}"),
        );
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::Dialect;
    use crate::params::testing::{Surroundings, read, read_in};
    use crate::surface::TexturePoint;
    use crate::textures::Textures;

    fn coefficients(subsurface: &Subsurface) -> [SpectrumInput; 2] {
        [subsurface.sigma_a, subsurface.sigma_s]
    }

    const fn rgb(r: f32, g: f32, b: f32) -> SpectrumInput {
        SpectrumInput::Constant(Rgb::new(r, g, b))
    }

    #[test]
    fn names_give_coefficients_that_parameters_override() {
        let params = "\"string name\" \"Skin1\" \"rgb sigma_a\" [1 2 3] \"float g\" .5";
        let skin = read("subsurface", params, Subsurface::from_params);
        assert_eq!(skin.warnings, 0, "{}", skin.text);
        assert_eq!(
            coefficients(&skin.value),
            [rgb(1.0, 2.0, 3.0), rgb(0.74, 0.88, 1.01)]
        );
        assert_eq!(skin.value.interior.g, 0.0);
        let usual = read("subsurface", "", Subsurface::from_params).value;
        let misspelt = read(
            "subsurface",
            "\"string name\" \"skin1\"",
            Subsurface::from_params,
        );
        assert_eq!(
            (coefficients(&misspelt.value), misspelt.warnings),
            (coefficients(&usual), 1)
        );
        assert!(misspelt.text.contains("`Skin1`"), "{}", misspelt.text);
    }

    #[test]
    fn wild_coefficients_make_media_of_numbers() {
        let at = Place {
            point: TexturePoint {
                p: Rgb::ZERO,
                uv: crate::math::Vec2::ZERO,
                footprint: Default::default(),
                face: 0,
            },
            textures: &Textures::default(),
            materials: &[],
        };
        let wild = [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e-30, 1e30];
        for a in wild {
            for s in wild {
                let mut material = read("subsurface", "", Subsurface::from_params).value;
                material.sigma_a = rgb(a, 1.0, 1.0);
                material.sigma_s = rgb(s, 1.0, 1.0);
                let medium = material.medium(&at).unwrap();
                assert!(medium.mean_free_path.x >= 0.0, "{a} {s}: {medium:?}");
                // NaN counts as black (`ProfileTable::row`).
                assert!(
                    !(medium.albedo.x < 0.0 || medium.albedo.x > 1.0),
                    "{a} {s}: {medium:?}"
                );
                assert_eq!((medium.albedo.y, medium.mean_free_path.y), (0.5, 0.5));
            }
        }
    }

    #[test]
    fn v2_has_names_of_its_own() {
        let v2 = Surroundings {
            dialect: Dialect::V2,
            word: "Material",
            ..Surroundings::default()
        };
        let params = "\"rgb sigma_prime_s\" [1 2 3] \"float index\" 1.4 \"float scale\" 2";
        let read = read_in(&v2, "subsurface", params, Subsurface::from_params);
        assert_eq!(read.warnings, 0, "{}", read.text);
        let Subsurface {
            sigma_s, interior, ..
        } = read.value;
        assert_eq!(
            (sigma_s, interior.eta, interior.scale),
            (rgb(1.0, 2.0, 3.0), 1.4, 2.0)
        );
    }

    #[test]
    fn numbers_out_of_range_are_replaced_with_a_warning() {
        for (params, warnings) in [
            ("\"float eta\" 0", 1),
            ("\"float eta\" -1", 1),
            ("\"float g\" 1.5", 1),
            ("\"float scale\" -1", 1),
            ("\"float uroughness\" -1", 1),
            ("\"float eta\" 1 \"float g\" -1 \"float scale\" 0", 0),
        ] {
            let outcome = read("subsurface", params, Subsurface::from_params);
            assert_eq!(outcome.warnings, warnings, "{}", outcome.text);
        }
        let outcome = read(
            "subsurface",
            "\"float eta\" 0 \"float g\" 7",
            Subsurface::from_params,
        );
        assert_eq!(
            (outcome.value.interior.eta, outcome.value.interior.g),
            (1.33, 0.0)
        );
    }
}
