//! Cameras of ISET3d's pbrt (<https://github.com/ISET/pbrt-v3-spectral>), which public scenes of
//! image-system simulations ask for.

/// The camera's type, and what of it `realistic` has not.
const CAMERAS: [(&str, &str); 4] = [
    ("omni", "with the lens as a table (.dat) and no microlenses"),
    ("realisticDiffraction", "without diffraction"),
    (
        "realisticEye",
        "with the eye as a lens table (.dat) and a flat film",
    ),
    (
        "rtf",
        "with the lens's surfaces as a table (.dat), not its ray transfer function",
    ),
];

/// What is to be said where `kind` is a camera of ISET3d.
pub(super) fn note(word: &str, kind: &str) -> Option<String> {
    let (_, how) = CAMERAS
        .iter()
        .find(|(name, _)| word == "Camera" && *name == kind)?;
    Some(format!(
        "`{kind}` belongs to ISET3d; `realistic` comes nearest, {how}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_of_iset3d_have_a_neighbor_here() {
        for (kind, _) in CAMERAS {
            let note = note("Camera", kind).expect(kind);
            assert!(note.contains("`realistic` comes nearest"), "{note}");
        }
        assert_eq!(note("Camera", "realistic"), None);
        assert_eq!(note("Shape", "omni"), None);
    }
}
