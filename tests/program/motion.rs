//! `--aov motion`: how far the picture of a point moves.

use super::cli::Folder;
use super::layers::{Channels, layers_of};
use crate::common::program::fstop;

/// A picture of 16 × 16 pixels of a wall in the plane z = 8 that moves as `of_wall` says, seen by `camera` after `before` it.
fn wall(camera: &str, before: &str, of_wall: &str) -> String {
    format!(
        r#"
        {before}
        Camera {camera}
        Film "image" "integer xresolution" 16 "integer yresolution" 16
        Sampler "halton" "integer pixelsamples" 16
        WorldBegin
        LightSource "infinite"
        ObjectBegin "wall"
          Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-99 -99 8  99 -99 8  99 99 8  -99 99 8]
        ObjectEnd
        AttributeBegin
          ActiveTransform EndTime {of_wall} ActiveTransform All
          ObjectInstance "wall"
        AttributeEnd
        WorldEnd"#
    )
}

const AOV: [&str; 2] = ["--aov", "motion"];

/// Half as wide as it is far: eight pixels to each side are 4 wide at a distance of 8.
const CAMERA: &str = r#""perspective" "float fov" 53.13010235415598 "#;

/// Rounded to single precision at the point, its image at a hundred pixels' distance, and their difference.
const ROUNDING: f32 = 1e-4;

#[test]
fn a_wall_moves_as_far_as_it_is_moved() {
    // 1 to the right and 1/2 up is two pixels and one.
    let scene = |shutter: &str| wall(&format!("{CAMERA}{shutter}"), "", "Translate 1 0.5 0");
    let half = r#""float shutterclose" 0.5"#;
    // Without motion blur: what it moves by while anything moves.
    let at_once = r#""float shutteropen" 0.25 "float shutterclose" 0.25"#;
    for (shutter, [x, y]) in [("", [2.0, 1.0]), (half, [1.0, 0.5]), (at_once, [2.0, 1.0])] {
        let found = layers_of(&scene(shutter), &AOV);
        found.assert("motion.X", ROUNDING, |_| x);
        found.assert("motion.Y", ROUNDING, |_| y);
    }
}

#[test]
fn a_shape_and_the_camera_move_as_instances_do() {
    // A wall within an object that moves within it, and that is in an instance that moves: twice as far.
    let twice = wall(CAMERA, "", "Translate 1 0.5 0").replace(
        "Shape \"trianglemesh\"",
        "ActiveTransform EndTime Translate 1 0.5 0 ActiveTransform All Shape \"trianglemesh\"",
    );
    let found = layers_of(&twice, &AOV);
    found.assert("motion.X", ROUNDING, |_| 4.0);
    found.assert("motion.Y", ROUNDING, |_| 2.0);
    // The world moves to the left and down before a camera that moves to the right and up; the wall goes with the camera.
    let camera = "ActiveTransform EndTime Translate -1 -0.5 0 ActiveTransform All";
    let found = layers_of(&wall(CAMERA, camera, ""), &AOV);
    found.assert("motion.X", ROUNDING, |_| -2.0);
    found.assert("motion.Y", ROUNDING, |_| -1.0);
    let found = layers_of(&wall(CAMERA, camera, "Translate 1 0.5 0"), &AOV);
    found.assert("motion.X", ROUNDING, |_| 0.0);
    found.assert("motion.Y", ROUNDING, |_| 0.0);
}

/// Turned about the camera's axis by a right angle, every pixel goes a quarter around the middle.
#[test]
fn a_wall_turns() {
    let scene = wall(
        r#""orthographic" "float screenwindow" [-8 8 -8 8]"#,
        "",
        "Rotate 90 0 0 1",
    );
    let found = layers_of(&scene, &[&AOV[..], &["--spp", "256"]].concat());
    // Between its ends the wall is where the point of a pixel is at another time: points that are at p at some time of the turn begin at p turned
    // back by a quarter at most, and their mean is that of all angles φ from 0 to 90°: from R(−φ)p to R(90° − φ)p, whose difference is
    // (R(90°) − 1) ∫R(−φ)dφ p = (2/π) (R(90°) − 1) (p + R(−90°)p).
    let expected = |x: f64, y: f64| {
        let (sx, sy) = (x + y, y - x);
        let scale = std::f64::consts::FRAC_2_PI;
        [scale * (-sy - sx), scale * (sx - sy)]
    };
    let (right, up) = (found.get("motion.X"), found.get("motion.Y"));
    for i in 0..256 {
        let x = (i % found.width) as f64 - 7.5;
        let y = 7.5 - (i / found.width) as f64;
        let [dx, dy] = expected(x, y);
        // The pixel's default filter is a box: of noise there is a tenth of a pixel, from 256 times and places.
        let off = (f64::from(right[i]) - dx).hypot(f64::from(up[i]) - dy);
        assert!(
            off < 0.2,
            "({x}, {y}): ({}, {}), not ({dx}, {dy})",
            right[i],
            up[i]
        );
    }
}

/// Through a real lens a point moves by what lies between it and where it comes to, as the layer `position` shows.
#[test]
fn it_is_that_of_a_lens_too() {
    let lens = concat!(env!("CARGO_MANIFEST_DIR"), "/lenses/dgauss.50mm.dat");
    let camera = format!(r#""realistic" "string lensfile" "{lens}" "float focusdistance" 8"#);
    let scene = wall(&camera, "", "Translate 0.03 0.06 0");
    let found = layers_of(&scene, &["--aov", "motion,position,alpha", "--spp", "1024"]);
    let at = |name: &str, x: usize, y: usize| found.get(name)[y * found.width + x];
    for (x, y) in [(8, 8), (4, 11), (2, 2), (13, 5)] {
        let across = (at("position.X", x + 1, y) - at("position.X", x - 1, y)) / 2.0;
        let up = (at("position.Y", x, y - 1) - at("position.Y", x, y + 1)) / 2.0;
        let told = [at("motion.X", x, y), at("motion.Y", x, y)];
        // The noise of `position`, a fiftieth of a pixel; and that the picture is distorted by 1 %.
        for (told, seen) in told.into_iter().zip([0.03 / across, 0.06 / up]) {
            assert!(
                (told / seen - 1.0).abs() < 0.03,
                "({x}, {y}): {told} {seen}"
            );
        }
    }
}

/// Points leave the image, and what is rendered of it.
#[test]
fn a_crop_has_the_motion_of_the_whole() {
    let lens = concat!(env!("CARGO_MANIFEST_DIR"), "/lenses/dgauss.50mm.dat");
    let camera = format!(r#""realistic" "string lensfile" "{lens}" "float focusdistance" 8"#);
    // Two pixels to the right.
    let scene = wall(&camera, "", "Translate 0.7 0 0");
    let whole = layers_of(&scene, &AOV);
    let part = layers_of(
        &scene,
        &[&AOV[..], &["--crop", "0.25,0.75,0.25,0.75"]].concat(),
    );
    assert_eq!((whole.width, part.width), (16, 8));
    for channel in ["motion.X", "motion.Y"] {
        let (whole, part) = (whole.get(channel), part.get(channel));
        for (i, value) in part.iter().enumerate() {
            assert_eq!(*value, whole[(4 + i / 8) * 16 + 4 + i % 8], "{channel} {i}");
        }
    }
    // Also where they leave it: as far as beside.
    let across = whole.get("motion.X");
    assert!(
        across.iter().all(|x| (x / across[0] - 1.0).abs() < 0.1),
        "{across:?}"
    );
}

#[test]
fn a_camera_that_does_not_know_says_so() {
    let folder = Folder::new();
    let lens = concat!(env!("CARGO_MANIFEST_DIR"), "/lenses/dgauss.50mm.dat");
    let camera = format!(r#""realistic" "string lensfile" "{lens}" "string model" "thin""#);
    let scene = folder.path("scene.pbrt");
    std::fs::write(&scene, wall(&camera, "", "")).expect("the scene");
    let [scene, output] = [scene, folder.path("a.exr")].map(|path| path.display().to_string());
    let run = fstop(["render", &scene, "-o", &output, "--aov", "motion"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(run.stderr.contains("--aov motion"), "{}", run.stderr);
    let run = fstop(["render", &scene, "-o", &output, "--aov", "depth"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(Channels::of(&folder.path("a.exr")).get("depth.Z")[0] > 0.0);
}
