//! A scene whose light the integrator cannot find is told so, before and while it is rendered.

use crate::common::program::fstop;

const LASER: &str = "tests/scenes/valid/laser.pbrt";

/// The scene with another integrator.
fn of_integrator(folder: &tempfile::TempDir, integrator: &str) -> String {
    let scene = folder.path().join("laser.pbrt");
    let laser = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(LASER);
    let text = std::fs::read_to_string(laser).expect("the scene is part of the project");
    let text = text.replace("Integrator \"bdpt\"", integrator);
    std::fs::write(&scene, text).expect("room for a scene");
    scene.display().to_string()
}

/// What is in the light of a laser that only `bdpt` finds.
#[test]
fn bdpt_finds_the_laser() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let brightest = |integrator: &str| {
        let scene = of_integrator(&folder, integrator);
        let output = folder.path().join("laser.exr");
        let file = output.display().to_string();
        let run = fstop(["render", &scene, "-o", &file, "--spp", "16", "--strict"]);
        assert_eq!(run.code, 0, "{}", run.stderr);
        let image = fstop::film::read(&output).expect("just written").image;
        image
            .pixels
            .iter()
            .fold(0.0, |most: f32, pixel| most.max(pixel.y))
    };
    // The ball's shadow on the floor, where all of the laser's light comes through the ball.
    assert_eq!(brightest("Integrator \"path\""), 0.0);
    assert!(brightest("Integrator \"bdpt\"") > 0.1);
}

#[test]
fn a_laser_through_glass_warns_and_is_refused_when_strict() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = folder.path().join("laser.exr").display().to_string();
    let scene = of_integrator(&folder, "SurfaceIntegrator \"photonmap\"");
    let place = "laser.pbrt:6:19";
    let words = "`photonmap` is rendered by `bdpt`, which cannot find the light of `spot` lights off or through `glass` where";
    for (arguments, code) in [
        (vec!["check", &scene], 0),
        (vec!["check", &scene, "--strict"], 2),
        (vec!["render", &scene, "-o", &output], 0),
        (vec!["render", &scene, "-o", &output, "--strict"], 2),
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
    let scene = of_integrator(&folder, "Integrator \"path\"");
    let output = folder.path().join("path.exr").display().to_string();
    let words = "the image lacks the light of `spot` lights off or through `glass`";
    let checked = fstop(["check", &scene, "--strict"]);
    assert_eq!(checked.code, 0, "{}", checked.stderr);
    assert!(checked.stderr.contains(words), "{}", checked.stderr);
    let rendered = fstop(["render", &scene, "-o", &output, "--strict"]);
    assert_eq!(rendered.code, 0, "{}", rendered.stderr);
    assert!(!rendered.stderr.contains(words), "{}", rendered.stderr);
}
