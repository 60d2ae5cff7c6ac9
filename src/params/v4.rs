//! Types that pbrt-v4 has and pbrt-v3 has not: who gives a v4 scene to a reader of v3 shall learn what
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

/// What is to be said where `kind` is a type that the directive `word` has in pbrt-v4 only.
pub(super) fn note(word: &str, kind: &str) -> Option<String> {
    let word = word.strip_prefix("MakeNamed").unwrap_or(word);
    let (_, _, v3) = TYPES
        .iter()
        .find(|(directive, v4, _)| *directive == word && *v4 == kind)?;
    let fact = format!("`{kind}` belongs to pbrt-v4; pbrt-v3 scenes are read here");
    Some(if v3.is_empty() {
        fact
    } else {
        format!("{fact}, where `{v3}` comes nearest")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_of_v4_are_told_from_others() {
        let named = note("MakeNamedMaterial", "diffuse");
        assert_eq!(named, note("Material", "diffuse"));
        assert!(named.is_some_and(|note| note.contains("`matte`")));
        assert!(note("Medium", "nanovdb").is_some());
        // A light may be called so.
        assert_eq!(note("AreaLightSource", "diffuse"), None);
        assert_eq!(note("Material", "diffus"), None);
    }
}
