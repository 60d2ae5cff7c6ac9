//! What pbrt-v2 reads otherwise than pbrt-v3: the whole table of (directive, type, parameter), docs/scene-language.md
//! §A.2 and §A.3. Those that read a parameter ask for it in pbrt-v3's words; the reader looks up here what holds.

use super::{Dialect, ParamReader};
use crate::math::Rgb;
use crate::math::spectrum::{rgb_from_blackbody, rgb_from_blackbody_v2};

/// What pbrt-v2 has in the place of a parameter of pbrt-v3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum V2 {
    /// The same with another default.
    Default(f64),
    /// The same under another name.
    Named(&'static str),
    /// No such parameter: pbrt-v3's default applies, and the parameter is reported as unused.
    Absent,
    /// A parameter that pbrt-v3 does not have.
    Only,
    /// The same name with another meaning, which the comment above the row explains.
    Means,
}

/// Types, parameter, and what pbrt-v2 has in its place. An empty list means all types, an empty parameter the directive
/// itself.
pub(super) type Row = (&'static [&'static str], &'static str, V2);

const ALL: &[&str] = &[];
const PROJECTIONS: &[&str] = &["perspective", "orthographic", "environment"];
const SUBSURFACE: &[&str] = &["subsurface", "kdsubsurface"];

/// The directives with such parameters.
#[cfg(any(test, feature = "internals"))]
pub const DIRECTIVES: [&str; 10] = [
    "AreaLightSource",
    "Camera",
    "Film",
    "Integrator",
    "LightSource",
    "Material",
    "PixelFilter",
    "Sampler",
    "Shape",
    "Texture",
];

/// The rows of a directive. The parameters of a material are its own wherever they stand.
pub fn rows(directive: &str) -> &'static [Row] {
    use V2::{Absent, Default, Means, Named, Only};
    match directive {
        "Film" => &[
            (ALL, "xresolution", Default(640.0)),
            (ALL, "yresolution", Default(480.0)),
            // A preview window, which pbrt-v2 also reads and ignores.
            (ALL, "display", Only),
        ],
        "Camera" => &[
            (ALL, "focaldistance", Default(1e30)),
            (PROJECTIONS, "hither", Only),
            (PROJECTIONS, "yon", Only),
        ],
        "PixelFilter" => &[
            // The zeros of the sinc within the half width, not the width of the window.
            (&["sinc"], "tau", Means),
        ],
        "Sampler" => &[
            (ALL, "pixelsamples", Default(4.0)),
            (&["stratified"], "xsamples", Default(2.0)),
            (&["stratified"], "ysamples", Default(2.0)),
        ],
        "Integrator" | "SurfaceIntegrator" => &[
            // Of paths: bounces, where pbrt-v3 counts surfaces that scatter.
            (ALL, "maxdepth", Means),
            (&["ambientocclusion"], "nsamples", Default(2048.0)),
            (&["ambientocclusion"], "cossample", Absent),
            (&["ambientocclusion"], "maxdist", Only),
        ],
        "LightSource" => &[(ALL, "samples", Absent)],
        "AreaLightSource" => &[
            (ALL, "samples", Absent),
            // All pieces of a shape are one light.
            (ALL, "", Means),
        ],
        "Shape" => &[(ALL, "discarddegenerateUVs", Only)],
        "Material" | "MakeNamedMaterial" => &[
            // Without it, a roughness is one over Blinn's exponent.
            (ALL, "remaproughness", Absent),
            (
                &["uber", "glass", "subsurface", "kdsubsurface"],
                "uroughness",
                Absent,
            ),
            (
                &["uber", "glass", "subsurface", "kdsubsurface"],
                "vroughness",
                Absent,
            ),
            (&["uber", "glass"], "eta", Absent),
            // The indices of the two sides are swapped in Fresnel's equations.
            (&["uber", "translucent"], "", Means),
            (SUBSURFACE, "eta", Named("index")),
            (SUBSURFACE, "index", Default(1.3)),
            (SUBSURFACE, "g", Absent),
            (SUBSURFACE, "Kt", Absent),
            (&["subsurface"], "sigma_s", Named("sigma_prime_s")),
            (&["kdsubsurface"], "mfp", Absent),
            (&["kdsubsurface"], "meanfreepath", Only),
        ],
        "Texture" => &[
            // The exponent of stored values, not whether they are sRGB.
            (&["imagemap"], "gamma", Means),
            // The first row of an EXR file is t = 0.
            (&["imagemap"], "filename", Means),
        ],
        _ => &[],
    }
}

/// What is to be said where `kind` is a type that the directive `word` has in pbrt-v2 only, in a scene that is read as pbrt-v3's.
pub(super) fn note(word: &str, kind: &str) -> Option<String> {
    let of_v2 = match word {
        "Material" | "MakeNamedMaterial" => matches!(kind, "shinymetal" | "measured"),
        _ => false,
    };
    of_v2.then(|| format!("`{kind}` is pbrt-v2's; with `--dialect v2` the scene is read so"))
}

impl ParamReader<'_> {
    fn row(&self, name: &str) -> Option<V2> {
        let holds =
            |row: &&Row| row.1 == name && (row.0.is_empty() || row.0.contains(&self.kind()));
        self.rows.iter().find(holds).map(|row| row.2)
    }

    /// Returns `true` if the parameter exists in the file's dialect.
    pub fn offers(&self, name: &str) -> bool {
        match self.row(name) {
            Some(V2::Absent | V2::Named(_)) => self.dialect() == Dialect::V3,
            Some(V2::Only) => self.dialect() == Dialect::V2,
            _ => true,
        }
    }

    /// Returns `true` if the parameter, or the directive if `name` is empty, has its pbrt-v2 meaning.
    pub fn means_v2(&self, name: &str) -> bool {
        self.dialect() == Dialect::V2 && self.row(name) == Some(V2::Means)
    }

    /// The parameter's name in the file's dialect.
    pub fn spelling(&self, name: &'static str) -> &'static str {
        match self.row(name) {
            Some(V2::Named(other)) if self.dialect() == Dialect::V2 => other,
            _ => name,
        }
    }

    /// The parameter's default in the file's dialect, from that in pbrt-v3.
    pub fn default_of(&self, name: &str, v3: f64) -> f64 {
        match self.row(name) {
            Some(V2::Default(v2)) if self.dialect() == Dialect::V2 => v2,
            _ => v3,
        }
    }
}

/// What pbrt-v2 makes of a sampled spectrum, over what pbrt-v3 makes of it: v2 divides the sum over
/// 471 wavelengths by that of the luminosity function, v3 multiplies besides with the 470 nm
/// between the first and the last of them and divides by their number (docs/scene-language.md §A.3).
const V2_OVER_V3: f32 = 471.0 / 470.0;

impl Dialect {
    /// The integrator of a file that names none.
    pub fn default_integrator(self) -> &'static str {
        match self {
            Dialect::V2 => "directlighting",
            Dialect::V3 => "path",
        }
    }

    /// A sampled spectrum's color, from that in pbrt-v3.
    pub(super) fn of_samples(self, v3: Rgb) -> Rgb {
        match self {
            Dialect::V2 => v3 * V2_OVER_V3,
            Dialect::V3 => v3,
        }
    }

    /// The color of a black body: of a spectrum that is 1 at 555 nm in pbrt-v2, at its peak in pbrt-v3.
    pub(super) fn of_blackbody(self, kelvin: f64) -> Rgb {
        match self {
            Dialect::V2 => rgb_from_blackbody_v2(kelvin),
            Dialect::V3 => rgb_from_blackbody(kelvin),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::testing::{Surroundings, read_in};

    #[test]
    fn materials_of_v2_are_known_in_v3() {
        for (dialect, told) in [(Dialect::V2, false), (Dialect::V3, true)] {
            let surroundings = Surroundings {
                dialect,
                word: "MakeNamedMaterial",
                ..Surroundings::default()
            };
            let outcome = read_in(&surroundings, "shinymetal", "", |p| {
                p.unknown_kind_replaced(&["matte"], "a matte is used");
            });
            assert_eq!(outcome.text.contains("`--dialect v2`"), told);
        }
        assert_eq!(note("Shape", "measured"), None);
    }

    #[test]
    fn each_kind_of_row_is_followed() {
        for (dialect, radius, older, newer, focus) in [
            (Dialect::V2, 7.0, true, false, 1e30),
            (Dialect::V3, f64::INFINITY, false, true, 1e6),
        ] {
            let read = |word, kind, params, look: fn(&ParamReader) -> f64| {
                let surroundings = Surroundings {
                    dialect,
                    word,
                    ..Surroundings::default()
                };
                read_in(&surroundings, kind, params, look)
            };
            let yon = read("Camera", "perspective", "\"float yon\" 7", |p| {
                p.float("yon", f64::INFINITY)
            });
            assert_eq!((yon.value, yon.warnings), (radius, usize::from(!older)));
            let focus_read = read("Camera", "perspective", "", |p| {
                p.float("focaldistance", 1e6)
            });
            assert_eq!(focus_read.value, focus);
            let index = "\"float index\" 2 \"float eta\" 3";
            let eta = read("Material", "subsurface", index, |p| {
                p.float(p.spelling("eta"), 1.33)
            });
            assert_eq!(
                (eta.value, eta.warnings),
                (if older { 2.0 } else { 3.0 }, 1)
            );
            let usual = read("Material", "subsurface", "", |p| {
                p.float(p.spelling("eta"), 1.33)
            });
            assert_eq!(usual.value, if older { 1.3 } else { 1.33 });
            let rough = read("Material", "glass", "\"float uroughness\" .5", |p| {
                p.float("uroughness", 0.0)
            });
            assert_eq!(
                (rough.value, rough.warnings),
                (if newer { 0.5 } else { 0.0 }, usize::from(!newer))
            );
            let metal = read("Material", "metal", "\"float uroughness\" .5", |p| {
                p.float("uroughness", 0.0)
            });
            assert_eq!((metal.value, metal.warnings), (0.5, 0));
            let meaning = read("PixelFilter", "sinc", "", |p| {
                f64::from(u8::from(p.means_v2("tau")))
            });
            assert_eq!(meaning.value == 1.0, older);
        }
    }
}
