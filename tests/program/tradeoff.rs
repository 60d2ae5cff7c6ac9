//! `fstop tradeoff`: what it measures is true where the truth is known, and it says what it should.

use crate::common::program::fstop;
use serde_json::Value;

/// A real lens, stratified samples.
const LENS: &str = "tests/scenes/valid/realistic_camera.pbrt";
/// Random samples, light that bounces.
const BOX: &str = "tests/scenes/reference/int_cornell_path.pbrt";

fn study(scene: &str, options: &[&str]) -> Value {
    let run = fstop([&["tradeoff", scene, "--json", "--quiet"], options].concat());
    assert_eq!(run.code, 0, "{scene}\n{}", run.stderr);
    serde_json::from_str(&run.stdout).unwrap_or_else(|e| panic!("{e}: {}", run.stdout))
}

fn settings<'a>(study: &'a Value, setting: &str) -> Vec<&'a Value> {
    let all = study["settings"].as_array().expect("settings");
    all.iter().filter(|s| s["setting"] == setting).collect()
}

fn number(value: &Value, path: &str) -> f64 {
    let found = value.pointer(path).and_then(Value::as_f64);
    found.unwrap_or_else(|| panic!("no {path} in {value}"))
}

#[test]
fn every_knob_of_a_lens_is_turned() {
    let study = study(LENS, &["--time", "2"]);
    for (setting, least) in [
        ("scene", 1),
        ("samples", 3),
        ("sampler", 2),
        ("lens model", 2),
        ("precision", 1),
        ("pupil sampling", 2),
        ("integrator", 2),
        ("maxdepth", 1),
        ("light choice", 2),
        ("filter", 4),
    ] {
        let failed = study["failed"].as_array().expect("a list");
        let failed = failed.iter().filter(|s| s["setting"] == setting).count();
        let found = settings(&study, setting).len() + failed;
        assert!(found >= least, "{setting}: {found}");
    }
    let sentence = study["recommendation"]["sentence"]
        .as_str()
        .expect("a sentence");
    assert!(sentence.starts_with("For 1 % error take "), "{sentence}");
}

/// What the confidence intervals of the variances at each count make of the fitted power of the counts.
fn slope_within(samples: &[&Value]) -> f64 {
    let x = |s: &Value| number(s, "/spp").ln();
    let mean = samples.iter().map(|s| x(s)).sum::<f64>() / samples.len() as f64;
    let spread: f64 = samples.iter().map(|s| (x(s) - mean).powi(2)).sum();
    let squares = samples.iter().map(|s| {
        let relative = number(s, "/variance/within") / number(s, "/variance/value");
        ((x(s) - mean) * relative).powi(2)
    });
    squares.sum::<f64>().sqrt() / spread
}

#[test]
fn depth_that_is_missing_is_bias_and_samples_are_noise() {
    let study = study(BOX, &["--time", "5", "--error", "20%"]);
    // Independent samples: the variance falls as their number. With counts of one to hundreds the fitted power is
    // known to about a tenth; on a busy machine there are fewer, and it is known as the variances are.
    let slope = number(&study, "/slope");
    let within = slope_within(&settings(&study, "samples"));
    assert!((slope - 1.0).abs() < within.max(0.25), "{slope} ± {within}");
    // Of a box lit from inside one bounce is by far not all: the scene's depth is 8.
    let depths = settings(&study, "maxdepth");
    let shallow = depths.iter().find(|s| s["value"] == "1").expect("depth 1");
    let bias = number(shallow, "/relativeBias/value");
    assert!(bias > 0.2, "{bias}");
    // More depth than 8 shows nothing to speak of.
    let deep = depths
        .iter()
        .find(|s| s["value"] == "16")
        .expect("depth 16");
    let (value, within) = (
        number(deep, "/relativeBias/value"),
        number(deep, "/relativeBias/within"),
    );
    assert!(value < 0.1 || value < 3.0 * within, "{value} ± {within}");
    assert_eq!(study["recommendation"]["relativeError"], 0.2);
}

/// The caustic of a spot light below a glass ball: path tracers lack it, so neither may be recommended in the place of
/// `bdpt`, however little noise is left.
#[test]
fn an_integrator_that_loses_light_is_told_and_not_taken() {
    let scene = "tests/scenes/census/spot_glassball_bdpt.pbrt";
    let study = study(scene, &["--time", "4", "--error", "10%"]);
    let integrators = settings(&study, "integrator");
    let names: Vec<_> = integrators.iter().map(|s| &s["value"]).collect();
    assert_eq!(names, ["path", "volpath", "sppm"]);
    for tracer in &integrators[..2] {
        // Where the caustic is, all light is lost: a pixel there is 100 % off, and it covers a tenth of the image or so.
        let bias = number(tracer, "/relativeBias/value");
        assert!(bias > 0.1, "{bias}");
    }
    let advice = &study["recommendation"];
    let turned = advice["settings"].as_array().expect("a list");
    let tracers = turned
        .iter()
        .filter(|s| s["setting"] == "integrator" && s["value"] != "sppm");
    assert_eq!(tracers.count(), 0, "{advice}");
    let sentence = advice["sentence"].as_str().expect("a sentence");
    assert!(sentence.contains("Of the integrators"), "{sentence}");
    assert!(sentence.contains("`path` differs by"), "{sentence}");
}

/// A board of checks, filtered for the scene's own 128 samples however many a setting takes. Filtered for
/// each setting's own number, one sample a pixel was 28 % off, and no advice could be given.
#[test]
fn fewer_samples_blur_no_texture() {
    let study = study(
        "tests/scenes/reference/realistic_dgauss50_full.pbrt",
        &["--time", "3"],
    );
    for setting in settings(&study, "samples") {
        let (value, within) = (
            number(setting, "/relativeBias/value"),
            number(setting, "/relativeBias/within"),
        );
        assert!(value < 0.05 || value < 3.0 * within, "{value} ± {within}");
    }
}

#[test]
fn text_and_page() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let page = folder.path().join("t.html");
    let name = page.display().to_string();
    let run = fstop(["tradeoff", BOX, "--time", "1", "--quiet", "--html", &name]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    for word in [
        "efficiency",
        "±",
        "samples",
        "maxdepth",
        "For 1 % error take",
    ] {
        assert!(run.stdout.contains(word), "{word}: {}", run.stdout);
    }
    let html = std::fs::read_to_string(&page).expect("the page");
    for word in [
        "<svg",
        "relative error (%)",
        "seconds for an image",
        "<table>",
        "For 1 % error",
    ] {
        assert!(html.contains(word), "{word}");
    }
    // Nothing is fetched: the only addresses are names of XML vocabularies.
    let addresses = html.matches("http").count();
    assert_eq!(addresses, html.matches("http://www.w3.org/").count());
}

#[test]
fn nonsense_is_refused() {
    for option in [["--error", "0"], ["--time", "-1"]] {
        let run = fstop([&["tradeoff", BOX], &option[..]].concat());
        assert_eq!(run.code, 2, "{option:?}");
    }
    assert_eq!(fstop(["tradeoff", "no such scene.pbrt"]).code, 2);
}
