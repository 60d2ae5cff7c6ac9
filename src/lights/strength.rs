//! How strong a light is: a spectrum parameter and `scale`, which all lights have.

use crate::math::Rgb;
use crate::math::color::luminance;
use crate::params::ParamReader;

/// The product of the spectrum parameters `name` (1) and `scale` (1). One that takes light away is kept and
/// warned of: samples that come to less than nothing are black (scene-language 4.1).
pub(super) fn strength(reader: &ParamReader, name: &str) -> Rgb {
    let given = reader.spectrum(name, Rgb::ONE);
    let strength = given * reader.spectrum("scale", Rgb::ONE);
    if luminance(strength) < 0.0 {
        let negative = if luminance(given) < 0.0 {
            name
        } else {
            "scale"
        };
        let message = "this light is negative: samples that it makes negative count as black";
        reader.warn(negative, message);
    }
    strength
}

#[cfg(test)]
mod tests {
    use crate::lights::{DiffuseAreaSpec, LightSpec};
    use crate::math::transform::Transform;
    use crate::params::testing::read;

    #[test]
    fn a_negative_light_is_told_at_its_parameter() {
        // A saturated color of positive luminance is one that screens cannot show, and no mistake.
        let cases = [
            ("[-1 -1 -1]", "[1 1 1]", 1),
            ("[1 1 1]", "[-1 -1 -1]", 1),
            ("[-1 -1 -1]", "[-1 -1 -1]", 0),
            ("[-.1 1 .5]", "[1 1 1]", 0),
            ("[0 0 0]", "[1 1 1]", 0),
        ];
        let lights = [
            ("point", "I"),
            ("spot", "I"),
            ("distant", "L"),
            ("infinite", "L"),
            ("goniometric", "I"),
            ("projection", "I"),
        ];
        for (value, scale, expected) in cases {
            for (kind, name) in lights {
                let text = format!("\"rgb {name}\" {value} \"rgb scale\" {scale}");
                let found = read(kind, &text, |reader| {
                    LightSpec::from_params(reader, &Transform::IDENTITY)
                });
                assert_eq!(found.warnings, expected, "{kind} {text}: {}", found.text);
            }
            let text = format!("\"rgb L\" {value} \"rgb scale\" {scale}");
            let found = read("diffuse", &text, DiffuseAreaSpec::from_params);
            assert_eq!(found.warnings, expected, "{text}: {}", found.text);
        }
    }
}
