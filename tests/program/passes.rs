//! Rendering until the image is good enough (`--error`) or the time is up (`--time`): the numbers
//! that are promised are true, and the image is the same one.

use crate::common::program::{Run, fstop};
use crate::common::rendering::Render;
use fstop::compare::{Estimate, Options, compare};
use fstop::film::{Image, read};
use std::path::{Path, PathBuf};

/// Random samples, caustics of a mirror ball: noise that differs much from tile to tile.
const BOX: &str = "tests/scenes/reference/int_cornell_path.pbrt";
/// Stratified samples and a real lens.
const LENS: &str = "tests/scenes/valid/realistic_camera.pbrt";
/// Sobol' points, instances, an area light.
const OBJECTS: &str = "tests/scenes/valid/instancing.pbrt";
/// Instances under a sky, 4096 pixels.
const GARDEN: &str = "tests/scenes/reference/shape_instancing.pbrt";

fn render(scene: &str, output: &Path, options: &[&str]) -> Run {
    let name = output.display().to_string();
    let run = fstop([&["render", scene, "-o", &name, "--variance"], options].concat());
    assert_eq!(run.code, 0, "{scene} {options:?}\n{}", run.stderr);
    run
}

fn scene_path(scene: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(scene)
}

fn number_before(text: &str, word: &str) -> f64 {
    let before = text.split(word).next().unwrap_or_default();
    let number = before.split_whitespace().last().unwrap_or_default();
    number
        .parse()
        .unwrap_or_else(|_| panic!("no number before `{word}`: {text}"))
}

#[test]
fn the_same_bytes_for_any_threads_and_tiles() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = folder.path().join("a.exr");
    let ways: [&[&str]; 4] = [
        &["--threads", "1"],
        &["--threads", "2"],
        &["--threads", "5", "--tile-size", "7"],
        &["--threads", "2", "--tile-size", "1000"],
    ];
    for scene in [BOX, LENS, OBJECTS] {
        let mut first = None;
        for options in ways {
            render(scene, &output, &[options, &["--error", "30%"]].concat());
            let bytes = std::fs::read(&output).expect("the image");
            assert!(
                first.get_or_insert_with(|| bytes.clone()) == &bytes,
                "{scene} {options:?}"
            );
        }
    }
}

/// Images with other seeds differ by as much as both promise: √2 times the error of one.
#[test]
fn the_error_is_what_it_claims() {
    // Not of 192 pixels, whose error is that of the few that show a light: there it is not known to 15 %.
    for scene in [BOX, LENS, GARDEN] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let output = folder.path().join("a.exr");
        let mut claimed = 0.0;
        let images: Vec<Image> = (0..6)
            .map(|seed| {
                let seed = seed.to_string();
                let run = render(scene, &output, &["--error", "20%", "--seed", &seed]);
                let percent = number_before(&run.stderr, " % after");
                assert!(percent <= 20.0, "{}", run.stderr);
                claimed += (0.01 * percent).powi(2) / 6.0;
                read(&output)
                    .unwrap_or_else(|error| panic!("{error}"))
                    .image
            })
            .collect();
        let mut found = 0.0;
        for pair in images.chunks(2) {
            found += relative_mse(&pair[0], &pair[1]) / 2.0 / 3.0;
        }
        // Three pairs of images of some hundred tiles with noise of heavy tails, which the
        // promise divides by the square of its own noisy mean: 15 % on the error.
        let ratio = (found / claimed).sqrt();
        assert!(
            (0.85..1.15).contains(&ratio),
            "{scene}: found/claimed {ratio}"
        );
    }
}

/// Mean of (a − b)² / (m² + ε²), m being the mean of both and ε 1 % of the mean image.
fn relative_mse(a: &Image, b: &Image) -> f64 {
    let pairs = || {
        a.pixels
            .iter()
            .zip(&b.pixels)
            .map(|(p, q)| (p.as_dvec3(), q.as_dvec3()))
    };
    let count = 3.0 * a.pixels.len() as f64;
    let mean = pairs()
        .map(|(p, q)| ((p + q) * 0.5).element_sum())
        .sum::<f64>()
        / count;
    let floor = (0.01 * mean).powi(2);
    let one = |(p, q): (glam::DVec3, glam::DVec3)| {
        let m = (p + q) * 0.5;
        ((p - q) * (p - q) / (m * m + floor)).element_sum()
    };
    pairs().map(one).sum::<f64>() / count
}

/// Tiles choose their samples by what they have seen, and still show what pbrt-v3 shows.
#[test]
fn the_expectation_is_the_references() {
    if crate::common::is_left_out("refimages") {
        return;
    }
    let image = Render::new(&scene_path(BOX), 1, 30, &["--error", "45%"]);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("refimages/int_cornell_path.exr");
    let reference = read(&path).unwrap_or_else(|error| panic!("{error}"));
    // As in tests/scenes/references.rs: a false alarm in ten thousand changes of the random numbers.
    let options = Options {
        alpha: 1e-4,
        ..Options::default()
    };
    let reference_runs = f64::from(reference.runs.expect("references count their runs"));
    let reference = Estimate {
        image: &reference.image,
        freedom: reference_runs - 1.0,
        pool: None,
        samples: None,
        light_paths: None,
    };
    let ours = Estimate {
        samples: None,
        light_paths: None,
        ..image.estimate()
    };
    let comparison = compare(&ours, &reference, &options);
    let comparison = comparison.unwrap_or_else(|error| panic!("{error}"));
    assert!(comparison.verdict.agrees(), "{:?}", comparison.metrics);
}

#[test]
fn the_time_ends_a_render() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = folder.path().join("a.exr");
    let run = render(BOX, &output, &["--time", "0.3"]);
    assert!(run.stderr.contains("time is up"), "{}", run.stderr);
    let both = render(BOX, &output, &["--time", "3600", "--error", "60%"]);
    assert!(both.stderr.contains("good enough"), "{}", both.stderr);
}

/// A scene of `width` pixels in a row of tiles, or in a square of them, with this world.
fn written(folder: &Path, width: u32, world: &str) -> String {
    let scene = folder.join("scene.pbrt");
    let text = format!(
        "LookAt 0 0 -5  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" [40]\n\
         Film \"image\" \"integer xresolution\" [{width}] \"integer yresolution\" [{width}]\n\
         Sampler \"random\" Integrator \"path\"\nWorldBegin\n{world}\nWorldEnd\n"
    );
    std::fs::write(&scene, text).expect("room for a scene");
    scene.display().to_string()
}

const FLOOR: &str = "Material \"matte\" Shape \"disk\" \"float height\" [2] \"float radius\" [9]";
/// All of its light goes through glass, which no path from the camera finds.
const LAMP_IN_GLASS: &str =
    "LightSource \"point\" Material \"glass\" Shape \"sphere\" \"float radius\" [.5]";
const SKY: &str = "LightSource \"infinite\" \"rgb L\" [.5 .5 .5]";

/// Samples are doubled until there is an error to speak of, or no more are allowed.
#[test]
fn no_noise_is_not_no_error() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = folder.path().join("a.exr");
    for (world, words) in [
        (format!("{LAMP_IN_GLASS} {FLOOR}"), "no light was found"),
        (SKY.to_string(), "unknown error (no noise was found)"),
    ] {
        let scene = written(folder.path(), 16, &world);
        let run = render(&scene, &output, &["--error", "1%", "--spp", "100"]);
        assert!(run.stderr.contains(words), "{}", run.stderr);
        // 8, 16, 32, 64, 100.
        let passes = "100.0 samples a pixel on average in 5 passes (no more samples allowed)";
        assert!(run.stderr.contains(passes), "{}", run.stderr);
        // Nothing is claimed in the file either: it is the one of 100 samples.
        let claimed = read(&output).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(claimed.spp, Some(100));
    }
}

/// A light so small that the first pass misses it: its light makes the error known, and that is reached then.
#[test]
fn light_that_is_found_late_still_counts() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = folder.path().join("a.exr");
    let lamp = "AttributeBegin AreaLightSource \"diffuse\" Shape \"sphere\" \"float radius\" [.003] \
                AttributeEnd Material \"matte\" \"rgb Kd\" [0 0 0] Shape \"disk\" \"float height\" [2]";
    let scene = written(folder.path(), 8, lamp);
    let run = render(&scene, &output, &["--error", "1000%", "--spp", "65536"]);
    assert!(run.stderr.contains("good enough"), "{}", run.stderr);
    assert!(
        number_before(&run.stderr, " samples a pixel") > 8.0,
        "{}",
        run.stderr
    );
}

/// Time is spent although no noise shows where to spend it.
#[test]
fn time_without_noise_is_used() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = folder.path().join("a.exr");
    let scene = written(folder.path(), 16, &format!("{LAMP_IN_GLASS} {FLOOR}"));
    let run = render(&scene, &output, &["--time", "1"]);
    assert!(run.stderr.contains("no light was found"), "{}", run.stderr);
    assert!(run.stderr.contains("time is up"), "{}", run.stderr);
    assert!(number_before(&run.stderr, " s (") > 0.5, "{}", run.stderr);
}

/// The time limit holds from the first sample on, and still there is an image everywhere.
#[test]
fn the_first_pass_ends_with_the_time() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = folder.path().join("a.exr");
    let scene = written(folder.path(), 1024, SKY);
    let run = render(&scene, &output, &["--time", "0.001"]);
    assert!(run.stderr.contains("time is up"), "{}", run.stderr);
    // One tile a thread, of 4096, and what a slow machine does in between.
    assert!(
        number_before(&run.stderr, " samples a pixel") < 0.5,
        "{}",
        run.stderr
    );
    let image = read(&output).unwrap_or_else(|error| panic!("{error}"));
    let sky = fstop::math::Rgb::splat(0.5);
    assert!(image.image.pixels.iter().all(|&pixel| pixel == sky));
}

#[test]
fn samples_end_a_render() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = folder.path().join("a.exr");
    let run = render(BOX, &output, &["--error", "1e-9", "--spp", "16"]);
    assert!(
        run.stderr.contains("no more samples allowed"),
        "{}",
        run.stderr
    );
    let loaded = read(&output).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(loaded.spp, Some(16));
}

#[test]
fn nonsense_is_refused() {
    for option in [
        ["--error", "0"],
        ["--error", "-1%"],
        ["--time", "0"],
        ["--time", "x"],
    ] {
        let run = fstop([&["render", BOX], &option[..]].concat());
        assert_eq!(run.code, 2, "{option:?}");
        assert!(run.stderr.contains("expected a positive"), "{}", run.stderr);
    }
}

/// A bound is above the estimate, and rendering goes on until it is small enough.
#[test]
fn a_confidence_is_kept_and_told() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = folder.path().join("a.exr");
    let plain = render(OBJECTS, &output, &["--error", "20%"]);
    assert!(!plain.stderr.contains("confidence"), "{}", plain.stderr);
    let goal = ["--error", "20%", "--confidence", "95%"];
    let sure = render(OBJECTS, &output, &goal).stderr;
    let error = number_before(&sure, " %, below");
    let bound = number_before(&sure, " % with 95 % confidence");
    assert!(error < bound && bound <= 20.0, "{sure}");
    // Without enough samples there is a bound, which is above the goal, or none.
    let few = render(OBJECTS, &output, &[&goal[..], &["--spp", "8"]].concat()).stderr;
    assert!(few.contains("no more samples allowed"), "{few}");
    for (options, said) in [
        (&["--error", "20%", "--confidence", "100%"][..], "below one"),
        (&["--error", "20%", "--confidence", "0.4"], "below one"),
        (&["--confidence", "95%"], "--error"),
    ] {
        let run = fstop([&["render", BOX], options].concat());
        assert_eq!(run.code, 2, "{options:?}");
        assert!(run.stderr.contains(said), "{}", run.stderr);
    }
}
