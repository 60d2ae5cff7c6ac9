//! What ISET3d's pbrt (<https://github.com/ISET/pbrt-v3-spectral>, and the pbrt-v2 before it) has besides: public scenes of
//! image-system simulations ask for it.

/// Directive, type, and what comes nearest here.
const TYPES: [(&str, &str, &str); 10] = [
    ("Camera", "omni", OMNI),
    ("Camera", "omnispectral", OMNI),
    (
        "Camera",
        "realisticDiffraction",
        "`realistic` comes nearest, without diffraction",
    ),
    (
        "Camera",
        "realisticEye",
        "`realistic` comes nearest, with the eye as a lens table (.dat) and a flat film",
    ),
    (
        "Camera",
        "rtf",
        "`realistic` comes nearest, with the file of the lens's surfaces (.json or .dat), not its ray transfer function",
    ),
    (
        "Camera",
        "pinhole",
        "`perspective` comes nearest, with the `fov` that filmdiag and filmdistance make",
    ),
    ("Camera", "idealDiffraction", PERSPECTIVE),
    ("Camera", "perspectiveDiffraction", PERSPECTIVE),
    (
        "Integrator",
        "metadata",
        "`path` with --aov depth,position,material,instance writes what it does",
    ),
    (
        "Integrator",
        "spectralpath",
        "`path` comes nearest, in red, green and blue",
    ),
];

/// `omni` takes millimeters but for these (its `src/cameras/omni.cpp`).
const OMNI: &str = "`realistic` comes nearest: it reads the lens's .json as it is, without microlenses; its filmdistance is in mm, where that of \
                    ISET3d is in meters";
const PERSPECTIVE: &str =
    "`perspective` comes nearest, with lensradius and focaldistance, without diffraction";

/// Parameters of its cameras, and what comes nearest here.
const PARAMETERS: [(&str, &str); 2] = [
    (
        "chromaticAberrationEnabled",
        "this is ISET3d's; \"bool dispersion\" \"true\" comes nearest",
    ),
    (
        "diffractionEnabled",
        "this is ISET3d's; diffraction is not modeled here",
    ),
];

/// What is to be said where `kind` is a type that the directive `word` has in ISET3d only.
pub(super) fn note(word: &str, kind: &str) -> Option<String> {
    let word = word.strip_prefix("Surface").unwrap_or(word);
    let of = |(directive, name, _): &&(&str, &str, &str)| *directive == word && *name == kind;
    let (_, _, how) = TYPES.iter().find(of)?;
    Some(format!("`{kind}` belongs to ISET3d; {how}"))
}

/// What is to be said where `name` is a parameter that the directive `word` has in ISET3d only.
pub(super) fn parameter(word: &str, name: &str) -> Option<&'static str> {
    let (_, how) = PARAMETERS.iter().find(|(other, _)| *other == name)?;
    (word == "Camera").then_some(how)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_of_iset3d_have_a_neighbor_here() {
        for (word, kind, _) in TYPES {
            let note = note(word, kind).expect(kind);
            assert!(note.contains("belongs to ISET3d; `"), "{note}");
        }
        // The lens needs no conversion, and a length another unit.
        let omni = note("Camera", "omni").expect("a note");
        assert!(
            omni.contains(".json as it is") && omni.contains("in meters"),
            "{omni}"
        );
        assert!(note("SurfaceIntegrator", "metadata").is_some());
        assert_eq!(note("Camera", "realistic"), None);
        assert_eq!(note("Shape", "omni"), None);
    }

    #[test]
    fn colors_of_a_lens_have_another_name_here() {
        let name = "chromaticAberrationEnabled";
        assert!(parameter("Camera", name).is_some_and(|how| how.contains("dispersion")));
        assert_eq!(parameter("Film", name), None);
    }
}
