//! Paths from the lights: their splats are the same for any division of the work, and are the light that is missing else.

use super::cli::Folder;
use crate::common::program::fstop;
use crate::common::rendering::Render;
use fstop::compare::{Options, compare};
use std::path::Path;

/// A ball of glass with its caustic, and one of chalk.
const BOTH_ENDS: &str = "tests/scenes/reference/int_bdpt.pbrt";

fn bytes(folder: &Folder, options: &[&str]) -> Vec<u8> {
    let output = folder.path("a.exr");
    let name = output.display().to_string();
    let run = fstop([&["render", BOTH_ENDS, "-o", &name, "--variance"], options].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    std::fs::read(output).expect("the image")
}

#[test]
fn threads_and_tiles_change_no_byte_of_them() {
    let folder = Folder::new();
    for goal in [["--spp", "6"], ["--error", "25%"]] {
        let ways: [&[&str]; 3] = [
            &["--threads", "1"],
            &["--threads", "2", "--tile-size", "1000"],
            &["--threads", "5", "--tile-size", "7"],
        ];
        let all = ways.map(|way| bytes(&folder, &[way, &goal[..]].concat()));
        assert!(all[0] == all[1] && all[0] == all[2], "{goal:?}");
    }
}

/// The scene with another integrator and another filter.
fn scene(integrator: &str, filter: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(BOTH_ENDS);
    let text = std::fs::read_to_string(path).expect("the scene is part of the project");
    let text = text.replace("\"bdpt\" \"integer", &format!("\"{integrator}\" \"integer"));
    text.replace("PixelFilter \"box\"", &format!("PixelFilter {filter}"))
}

/// A filter spreads splats as it does samples, negative lobes included, and pixels at the edge lose none.
#[test]
fn both_parts_together_are_the_light_of_camera_paths() {
    let one = Render::of_text(&scene("volpath", "\"box\""), 1);
    assert!(one.image.pixels.len() == 64 * 64);
    for filter in [
        "\"box\"",
        "\"gaussian\"",
        "\"mitchell\"",
        "\"box\" \"float xwidth\" 1.3 \"float ywidth\" 0.4",
    ] {
        let [a, b] = ["bdpt", "volpath"].map(|name| Render::of_text(&scene(name, filter), 7));
        let comparison = compare(&a.estimate(), &b.estimate(), &Options::default());
        let comparison = comparison.expect("images of one size");
        // Default false-alarm rate: one in a thousand comparisons.
        assert!(comparison.agrees(), "{filter}: {}", comparison.sentence());
    }
}

/// Samples in pixel centers alone meet no splat: all of the light is then found by the camera's paths.
#[test]
fn without_a_light_pass_camera_paths_find_its_light() {
    let centers = |name: &str| {
        let text = scene(name, "\"box\"");
        let halton =
            "Sampler \"halton\" \"bool samplepixelcenter\" \"true\" \"integer pixelsamples\" 16";
        text.replace("Sampler \"random\" \"integer pixelsamples\" [16]", halton)
    };
    let [a, b] = ["bdpt", "volpath"].map(|name| Render::of_text(&centers(name), 7));
    let comparison = compare(&a.estimate(), &b.estimate(), &Options::default());
    let comparison = comparison.expect("images of one size");
    assert!(comparison.agrees(), "{}", comparison.sentence());
}
