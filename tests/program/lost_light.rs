//! A scene whose light the integrator cannot find is told so, before and while it is rendered.

use crate::common::program::fstop;

const LASER: &str = "tests/scenes/valid/laser.pbrt";

#[test]
fn a_laser_through_glass_warns_and_is_refused_when_strict() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = folder.path().join("laser.exr").display().to_string();
    let words = "`bdpt` is rendered by `volpath`, which cannot find the light of `spot` lights";
    let place = "laser.pbrt:6:12";
    for (arguments, code) in [
        (vec!["check", LASER], 0),
        (vec!["check", LASER, "--strict"], 2),
        (vec!["render", LASER, "-o", &output], 0),
        (vec!["render", LASER, "-o", &output, "--strict"], 2),
    ] {
        let run = fstop(&arguments);
        assert_eq!(run.code, code, "{arguments:?}\n{}", run.stderr);
        let said = run.stderr.contains(words) && run.stderr.contains(place);
        assert!(said, "{arguments:?}\n{}", run.stderr);
        assert!(!run.stderr.contains("the same image"), "{}", run.stderr);
    }
}

/// pbrt-v3's `path` leaves the light out as well: who asks is told, who renders is not bothered.
#[test]
fn path_is_noted_by_check_alone() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = folder.path().join("path.pbrt");
    let laser = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(LASER);
    let text = std::fs::read_to_string(laser).expect("the scene is part of the project");
    std::fs::write(&scene, text.replace("\"bdpt\"", "\"path\"")).expect("room for a scene");
    let scene = scene.display().to_string();
    let output = folder.path().join("path.exr").display().to_string();
    let words = "the image lacks the light of `spot` lights off or through `glass`";
    let checked = fstop(["check", &scene, "--strict"]);
    assert_eq!(checked.code, 0, "{}", checked.stderr);
    assert!(checked.stderr.contains(words), "{}", checked.stderr);
    let rendered = fstop(["render", &scene, "-o", &output, "--strict"]);
    assert_eq!(rendered.code, 0, "{}", rendered.stderr);
    assert!(!rendered.stderr.contains(words), "{}", rendered.stderr);
}
