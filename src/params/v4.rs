//! Types and parameters that pbrt-v4 has and pbrt-v3 has not: who gives a v4 scene to a reader of v3 shall learn what
//! is the matter.

/// Directive (without a `MakeNamed`), pbrt-v4's type, and what comes nearest to it in pbrt-v3; empty
/// where nothing does. From pbrt-v4's description of its file format,
/// <https://pbrt.org/fileformat-v4>.
const TYPES: [(&str, &str, &str); 25] = [
    ("Camera", "spherical", "environment"),
    ("Film", "gbuffer", "image"),
    ("Film", "rgb", "image"),
    ("Film", "spectral", "image"),
    ("Integrator", "lightpath", ""),
    ("Integrator", "randomwalk", "path"),
    ("Integrator", "simplepath", "path"),
    ("Integrator", "simplevolpath", "volpath"),
    ("Material", "coatedconductor", ""),
    ("Material", "coateddiffuse", "plastic"),
    ("Material", "conductor", "metal"),
    ("Material", "dielectric", "glass"),
    ("Material", "diffuse", "matte"),
    ("Material", "diffusetransmission", "translucent"),
    ("Material", "interface", "none"),
    ("Material", "thindielectric", ""),
    ("Medium", "cloud", ""),
    ("Medium", "nanovdb", ""),
    ("Medium", "rgbgrid", ""),
    ("Medium", "uniformgrid", "heterogeneous"),
    ("Sampler", "independent", "random"),
    ("Sampler", "paddedsobol", "sobol"),
    ("Sampler", "pmj02bn", "02sequence"),
    ("Sampler", "zsobol", "sobol"),
    ("Shape", "bilinearmesh", ""),
];

/// Directive, pbrt-v4's parameter, and what pbrt-v3 calls it, the first that the type has; empty where nothing
/// does the same.
const PARAMETERS: [(&str, &str, &[&str]); 6] = [
    ("LightSource", "filename", &["mapname"]),
    ("LightSource", "illuminance", &[]),
    ("LightSource", "power", &[]),
    ("Material", "reflectance", &["Kd", "Kr"]),
    ("PixelFilter", "xradius", &["xwidth"]),
    ("PixelFilter", "yradius", &["ywidth"]),
];

/// What is to be said where nobody asks for the parameter `name` of the directive `word`, but for those that are `asked`.
pub(super) fn parameter(word: &str, name: &str, asked: &[String]) -> Option<String> {
    let word = word.strip_prefix("MakeNamed").unwrap_or(word);
    let of = |(directive, v4, _): &&(&str, &str, &[&str])| *directive == word && *v4 == name;
    let (_, _, v3) = PARAMETERS.iter().find(of)?;
    let has = |name: &&&str| asked.iter().any(|asked| asked == *name);
    let how = match v3.iter().find(has) {
        Some(v3) => format!("pbrt-v3 calls it `{v3}`"),
        None if v3.is_empty() => "give the strength itself, by `L` or `I`, and `scale`".to_string(),
        None => return None,
    };
    Some(format!("`{name}` is a parameter of pbrt-v4; {how}"))
}

/// What is to be said where `kind` is a type that the directive `word` has in pbrt-v4 only.
pub(super) fn note(word: &str, kind: &str) -> Option<String> {
    let word = word.strip_prefix("MakeNamed").unwrap_or(word);
    let (_, _, v3) = TYPES
        .iter()
        .find(|(directive, v4, _)| *directive == word && *v4 == kind)?;
    let fact = format!("`{kind}` belongs to pbrt-v4; pbrt-v3 scenes are read here");
    let instead = match kind {
        "diffuse" | "coateddiffuse" => ", with `Kd` for `reflectance`",
        _ => "",
    };
    Some(if v3.is_empty() {
        fact
    } else {
        format!("{fact}, where `{v3}` comes nearest{instead}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::testing::{Surroundings, read_in};

    #[test]
    fn types_of_v4_are_told_from_others() {
        let named = note("MakeNamedMaterial", "diffuse");
        assert_eq!(named, note("Material", "diffuse"));
        assert!(named.is_some_and(|note| note.contains("`matte`")));
        assert!(note("Medium", "nanovdb").is_some());
        // A light may be called so.
        assert_eq!(note("AreaLightSource", "diffuse"), None);
        assert_eq!(note("Material", "diffus"), None);
        // Of all its parameters the matte that is used does not know this one.
        let coated = note("Material", "coateddiffuse");
        assert!(coated.is_some_and(|note| note.ends_with("with `Kd` for `reflectance`")));
    }

    #[test]
    fn parameters_of_v4_are_named_in_v3s_words() {
        let told = |word, params: &str, asked: &'static str| {
            let surroundings = Surroundings {
                word,
                ..Surroundings::default()
            };
            let outcome = read_in(&surroundings, "t", params, |p| p.accept(asked));
            assert_eq!(outcome.warnings, 1);
            outcome.text
        };
        for (word, params, asked, expected) in [
            (
                "PixelFilter",
                "\"float xradius\" 2",
                "xwidth",
                "pbrt-v3 calls it `xwidth`",
            ),
            (
                "LightSource",
                "\"string filename\" \"a\"",
                "mapname",
                "calls it `mapname`",
            ),
            (
                "LightSource",
                "\"float illuminance\" 2",
                "L",
                "by `L` or `I`, and `scale`",
            ),
            (
                "Material",
                "\"rgb reflectance\" [1 1 1]",
                "Kd",
                "calls it `Kd`",
            ),
            (
                "Material",
                "\"rgb reflectance\" [1 1 1]",
                "Kr",
                "calls it `Kr`",
            ),
        ] {
            let text = told(word, params, asked);
            assert!(text.contains(expected), "{text}");
        }
        // A point light has no image.
        let text = told("LightSource", "\"string filename\" \"a\"", "I");
        assert!(!text.contains("pbrt-v4"), "{text}");
    }
}
