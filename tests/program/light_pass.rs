//! Paths from the lights: their splats are the same for any division of the work, and are the light that is missing else.

use super::cli::Folder;
use crate::common::program::fstop;
use crate::common::rendering::Render;
use fstop::build::build;
use fstop::compare::{Options, compare};
use fstop::glam::DVec3;
use fstop::render::{Progress, TILE_SIZE, expose};
use fstop::scene::{ReadSettings, read_scene};
use fstop::syntax::SourceMap;
use std::path::Path;

/// A ball of glass with its caustic, and one of chalk.
const BOTH_ENDS: &str = "tests/scenes/reference/int_bdpt.pbrt";

/// Light paths that are traced once for the camera paths that are joined to them and for the lens.
const FOG: &str = "tests/scenes/census/point_medium_bdpt.pbrt";

/// A path tracer's image with the ghosts of a lens.
const GHOSTS: &str = "tests/scenes/valid/ghosts.pbrt";

fn bytes(folder: &Folder, scene: &str, options: &[&str]) -> Vec<u8> {
    let output = folder.path("a.exr");
    let name = output.display().to_string();
    let run = fstop([&["render", scene, "-o", &name, "--variance"], options].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    std::fs::read(output).expect("the image")
}

#[test]
fn threads_and_tiles_change_no_byte_of_them() {
    let folder = Folder::new();
    for (scene, goal) in [
        (BOTH_ENDS, ["--spp", "6"]),
        (BOTH_ENDS, ["--error", "25%"]),
        (FOG, ["--spp", "6"]),
        (FOG, ["--error", "40%"]),
        (GHOSTS, ["--spp", "40"]),
        (GHOSTS, ["--error", "40%"]),
    ] {
        let ways: [&[&str]; 3] = [
            &["--threads", "1"],
            &["--threads", "2", "--tile-size", "1000"],
            &["--threads", "5", "--tile-size", "7"],
        ];
        let all = ways.map(|way| bytes(&folder, scene, &[way, &goal[..]].concat()));
        assert!(all[0] == all[1] && all[0] == all[2], "{scene} {goal:?}");
    }
}

/// The scene with another integrator, filter and number of samples.
fn scene(integrator: &str, filter: &str, spp: u32) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(BOTH_ENDS);
    let text = std::fs::read_to_string(path).expect("the scene is part of the project");
    text.replace("\"bdpt\" \"integer", &format!("\"{integrator}\" \"integer"))
        .replace(
            "\"pixelsamples\" [16]",
            &format!("\"pixelsamples\" [{spp}]"),
        )
        .replace("PixelFilter \"box\"", &format!("PixelFilter {filter}"))
}

/// The mean of the image in each channel, and its variance if pixels are independent. Nothing is cut at 0.
fn mean(text: &str, seed: u64) -> (DVec3, DVec3) {
    let sources = SourceMap::new();
    let file = sources.add_text("scene", text);
    let (scene, said) = read_scene(&sources, file, &ReadSettings::default());
    assert!(!said.has_errors());
    let frame = scene.frames.into_iter().next().expect("a frame");
    let job = build(frame, seed).0.expect("a scene that can be built").job;
    let film = expose(&job, TILE_SIZE, &Progress::hidden());
    let count = film.pixels().len() as f64;
    let mean: DVec3 = film.pixels().iter().map(|pixel| pixel.mean()).sum();
    let variance = film.pixels().iter().map(|pixel| pixel.variance_of_mean());
    (mean / count, variance.sum::<DVec3>() / (count * count))
}

/// A filter spreads splats as it does samples, negative lobes included, and pixels at the edge lose none.
#[test]
fn both_parts_together_are_the_light_of_camera_paths() {
    for filter in [
        "\"gaussian\"",
        "\"mitchell\"",
        "\"box\" \"float xwidth\" 1.3 \"float ywidth\" 0.4",
    ] {
        let (camera, variance_of_camera) = mean(&scene("volpath", filter, 100), 1);
        let runs = [2, 3, 4, 5, 6, 7, 8, 9];
        let runs = runs.map(|seed| mean(&scene("bdpt", filter, 4), seed).0);
        // A filter makes neighbors alike: the scatter from run to run is the image's.
        let both = runs.iter().sum::<DVec3>() / 8.0;
        let scatter = runs.iter().map(|run| (*run - both) * (*run - both));
        let variance = scatter.sum::<DVec3>() / (7.0 * 8.0);
        let t = (both - camera) / (variance + variance_of_camera).map(f64::sqrt);
        // Student's distribution with at least seven degrees of freedom: one false alarm in a thousand channels.
        assert!(
            t.abs().max_element() < 5.41,
            "{filter}: {both} {camera:?}: {t}"
        );
    }
}

/// Samples in pixel centers alone meet no splat: all of the light is then found by the camera's paths.
#[test]
fn without_a_light_pass_camera_paths_find_its_light() {
    let centers = |name: &str| {
        let text = scene(name, "\"box\"", 16);
        let halton =
            "Sampler \"halton\" \"bool samplepixelcenter\" \"true\" \"integer pixelsamples\" 16";
        text.replace("Sampler \"random\" \"integer pixelsamples\" [16]", halton)
    };
    let [a, b] = ["bdpt", "volpath"].map(|name| Render::of_text(&centers(name), 7));
    let comparison = compare(&a.estimate(), &b.estimate(), &Options::default());
    let comparison = comparison.expect("images of one size");
    assert!(comparison.agrees(), "{}", comparison.sentence());
}
