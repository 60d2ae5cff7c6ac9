//! Parameters common to all media.

use super::phase::HenyeyGreenstein;
use super::presets::{self, Coefficients};
use crate::math::Rgb;
use crate::math::float::clamp_nan_low;
use crate::params::ParamReader;
use crate::syntax::suggest::nearest;

/// Maximum coefficient per scene unit: light gets nowhere either way, and sums and products stay finite in single
/// precision.
const LARGEST_COEFFICIENT: f32 = 1e20;

/// `sigma_a` and `sigma_s`, else those of the `preset`, times `scale`.
pub(super) fn coefficients(reader: &ParamReader) -> Coefficients {
    let preset = reader.find_string("preset").filter(|name| !name.is_empty());
    let found = preset.and_then(presets::find);
    if let (Some(name), None) = (preset, found) {
        let meant = nearest(name, presets::names());
        let meant = meant.map_or(String::new(), |name| format!(" (did you mean `{name}`?)"));
        let message = format!("there is no medium preset `{name}`{meant}: whole milk is used");
        reader.warn("preset", message);
    }
    let Coefficients { sigma_a, sigma_s } = found.unwrap_or(presets::WHOLE_MILK);
    let scale = reader.float("scale", 1.0) as f32;
    let scaled = |name, usual| usable(reader, name, reader.spectrum(name, usual) * scale);
    Coefficients {
        sigma_a: scaled("sigma_a", sigma_a),
        sigma_s: scaled("sigma_s", sigma_s),
    }
}

/// A coefficient with every channel clamped to 0…[`LARGEST_COEFFICIENT`].
fn usable(reader: &ParamReader, name: &str, given: Rgb) -> Rgb {
    let used = given.map(|v| clamp_nan_low(v, 0.0, LARGEST_COEFFICIENT));
    if used != given {
        let [r, g, b] = used.to_array();
        let message =
            format!("`{name}` times `scale` is outside 0 to 1e20: ({r:?}, {g:?}, {b:?}) is used");
        reader.warn(name, message);
    }
    used
}

/// The phase function with mean cosine `g`.
pub(super) fn phase(reader: &ParamReader) -> HenyeyGreenstein {
    let g = reader.float("g", 0.0);
    // NaN is rejected too.
    if !(-1.0..=1.0).contains(&g) {
        reader.warn("g", format!("`g` is {g}, not from -1 to 1: the nearest of these is used, or 0 if it is no number"));
    }
    HenyeyGreenstein::new(g as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::testing::read;

    #[test]
    fn own_coefficients_come_before_the_presets() {
        let outcome = read(
            "homogeneous",
            r#""string preset" "Skin1" "float scale" 2"#,
            coefficients,
        );
        assert_eq!(outcome.warnings, 0);
        assert_eq!(outcome.value.sigma_s, 2.0 * Rgb::new(0.74, 0.88, 1.01));
        let text = r#""string preset" "Skin1" "rgb sigma_s" [1 2 3]"#;
        let outcome = read("homogeneous", text, coefficients);
        assert_eq!(outcome.value.sigma_s, Rgb::new(1.0, 2.0, 3.0));
        assert_eq!(outcome.value.sigma_a, Rgb::new(0.032, 0.17, 0.48));
        let outcome = read("homogeneous", r#""string preset" "Skin3""#, coefficients);
        assert_eq!((outcome.warnings, outcome.value), (1, presets::WHOLE_MILK));
        assert!(outcome.text.contains("Skin1"), "{}", outcome.text);
        assert_eq!(
            read("homogeneous", "", coefficients).value,
            presets::WHOLE_MILK
        );
    }

    #[test]
    fn odd_numbers_are_warned_of() {
        for (text, sigma_s) in [
            (r#""rgb sigma_s" [-1 0 2]"#, [0.0, 0.0, 2.0]),
            (r#""rgb sigma_s" [1 1 1] "float scale" -1"#, [0.0; 3]),
            (
                r#""rgb sigma_s" [1 1 0] "float scale" 1e30"#,
                [1e20, 1e20, 0.0],
            ),
        ] {
            let text = format!(r#""rgb sigma_a" [0 0 0] {text}"#);
            let outcome = read("homogeneous", &text, coefficients);
            assert_eq!(
                (outcome.value.sigma_s.to_array(), outcome.warnings),
                (sigma_s, 1)
            );
        }
        for (g, warnings) in [("-1", 0), ("1", 0), ("1.5", 1), ("-9", 1)] {
            let outcome = read("homogeneous", &format!(r#""float g" {g}"#), phase);
            assert_eq!(outcome.warnings, warnings);
        }
    }
}
