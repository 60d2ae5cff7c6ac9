//! `fstop compare`: what it says, in which form, with which exit code; and that its page is whole.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

mod common;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use common::program::{Run, fstop};
use fstop::film::{FilmMetadata, Image, PixelBounds, write};
use fstop::math::hash::mix2;
use fstop::math::{Rgb, UVec2};
use serde_json::Value;
use std::path::PathBuf;

/// A scene of 64 × 64 pixels and 16 samples each.
const CORNELL: &str = "tests/scenes/reference/int_cornell_path.pbrt";

/// Samples that the made-up renders say they have.
const SPP: u32 = 64;

/// Images in a folder that is gone with the test.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Folder {
        Folder(tempfile::tempdir().expect("a temporary folder"))
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).display().to_string()
    }

    fn write(&self, name: &str, image: &Image) -> String {
        let metadata = FilmMetadata {
            spp: SPP,
            ..FilmMetadata::default()
        };
        write(&PathBuf::from(self.path(name)), image, &metadata).expect("a writable folder");
        self.path(name)
    }

    /// Two renders of one expectation in EXR files.
    fn pair(&self, size: UVec2) -> [String; 2] {
        [(1, "a.exr"), (2, "b.exr")].map(|(seed, name)| self.write(name, &render(seed, size)))
    }
}

/// A gradient with noise of 5 % a pixel whose variance is known exactly.
fn render(seed: u64, size: UVec2) -> Image {
    let mut image = Image::black(size);
    let uniform = |i: u64| (mix2(seed, i) >> 11) as f32 / (1u64 << 53) as f32;
    let mut variance = Vec::new();
    for (i, (pixel, value)) in (0..).zip(image.bounds.pixels().zip(&mut image.pixels)) {
        let mean = 0.2 + 0.6 * pixel.x as f32 / size.x as f32;
        // Twelve uniform numbers less six are nearly normal, with variance 1.
        let normal = |c: u64| (0..12).map(|k| uniform(36 * i + 12 * c + k)).sum::<f32>() - 6.0;
        *value = Rgb::from([0, 1, 2].map(|c| mean * (1.0 + 0.05 * normal(c))));
        variance.push(Rgb::splat((0.05 * mean).powi(2)));
    }
    image.variance = Some(variance);
    image
}

const SMALL: UVec2 = UVec2::new(40, 30);

fn compare(arguments: &[&str]) -> Run {
    fstop(["compare"].iter().chain(arguments))
}

fn json(arguments: &[&str]) -> (i32, Value) {
    let run = compare(&[&["--json"], arguments].concat());
    let value = serde_json::from_str(&run.stdout);
    (
        run.code,
        value.unwrap_or_else(|e| panic!("{e}\n{}\n{}", run.stdout, run.stderr)),
    )
}

/// What README shows: two renders of one scene with other seeds, and one of another scene.
#[test]
fn renders_know_their_noise() {
    let folder = Folder::new();
    let render = |name: &str, arguments: &[&str]| {
        let file = folder.path(name);
        let run = fstop([&["render", CORNELL, "--variance", "-o", &file], arguments].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        file
    };
    let (a, b) = (
        render("a.exr", &["--seed", "1"]),
        render("b.exr", &["--seed", "2"]),
    );
    let (code, value) = json(&[&a, &b]);
    assert_eq!(
        (code, &value["noise"]),
        (0, &Value::from("stored")),
        "{value:#}"
    );
    // 16 samples a pixel, of which one degree of freedom goes into the mean.
    assert_eq!(value["a"]["spp"], 16);
    assert_eq!(value["a"]["degrees_of_freedom"], 15.0);
    // The same random numbers give the same image: nothing may differ.
    let again = render("again.exr", &["--seed", "1"]);
    assert_eq!(
        compare(&[&a, &again, "--noise", "none", "--tolerance", "0"]).code,
        0
    );
    assert_eq!(compare(&[&a, &b, "--noise", "none", "--no-flip"]).code, 1);
}

#[test]
fn the_sentence_comes_first_and_the_code_says_the_same() {
    let folder = Folder::new();
    let [a, b] = folder.pair(SMALL);
    let same = compare(&[&a, &b]);
    assert_eq!(same.code, 0, "{}", same.stdout);
    assert!(same.stdout.starts_with("The images agree: "));
    for part in [
        "single pixels",
        "blocks of 8 × 8",
        "the whole image",
        "A / B",
        "PSNR",
        "FLIP as shown",
    ] {
        assert!(same.stdout.contains(part), "{part}\n{}", same.stdout);
    }
    let mut brighter = render(2, SMALL);
    for (i, p) in brighter.pixels.iter_mut().enumerate() {
        *p *= if i % 40 < 20 && i < 600 { 1.04 } else { 1.0 };
    }
    let c = folder.write("c.exr", &brighter);
    let other = compare(&[&a, &c]);
    assert_eq!(other.code, 1);
    assert!(
        other.stdout.starts_with("The images differ: "),
        "{}",
        other.stdout
    );
    // 4 % on a quarter of 300 pixels with 5 % noise are ten standard errors; a tolerance of 5 % makes
    // them nothing.
    assert_eq!(
        compare(&[&a, &c, "--tolerance", "0.05", "--correction", "sidak"]).code,
        0
    );
    assert_eq!(compare(&[&a, &c, "--plain-welch", "--tile", "16"]).code, 1);
}

#[test]
fn json_has_every_number() {
    let folder = Folder::new();
    let [a, b] = folder.pair(SMALL);
    let (code, value) = json(&[&a, &b, "--alpha", "0.01", "--correction", "sidak"]);
    assert_eq!((code, &value["agree"]), (0, &Value::from(true)));
    assert_eq!(value["alpha"], 0.01);
    assert_eq!(value["correction"], "sidak");
    assert_eq!(value["a"]["window"], serde_json::json!([0, 0, 40, 30]));
    let levels = value["levels"].as_array().expect("a list");
    let sides: Vec<&Value> = levels.iter().map(|level| &level["side"]).collect();
    assert_eq!(
        sides,
        [
            &Value::from(1),
            &Value::from(8),
            &Value::from(32),
            &Value::Null
        ]
    );
    assert_eq!(levels[0]["tests"], 3600);
    let ratio = value["metrics"]["means"]["green"]["ratio"]
        .as_f64()
        .expect("a number");
    let error = value["metrics"]["means"]["green"]["ratio_error_95"]
        .as_f64()
        .expect("a number");
    // 5 % √2 over √1200 pixels at 1.96 standard errors is 0.4 %, a little more as they are not equal.
    assert!(
        (ratio - 1.0).abs() < 3.0 * error && (0.003..0.006).contains(&error),
        "{ratio} {error}"
    );
    for path in [
        "/p",
        "/metrics/mse",
        "/metrics/relative_mse",
        "/metrics/psnr",
        "/metrics/expected_mse",
        "/metrics/largest_tile/luminance_a",
        "/flip/ldr/mean",
        "/flip/hdr/p95",
        "/flip/hdr/exposures",
        "/uniformity/0/p",
        "/neighbor_correlation/value",
        "/levels/3/worst/degrees_of_freedom",
    ] {
        assert!(
            value.pointer(path).is_some_and(Value::is_number),
            "{path}\n{value:#}"
        );
    }
    let histogram = value["uniformity"][0]["histogram"]
        .as_array()
        .expect("a list");
    assert_eq!(
        histogram.iter().filter_map(Value::as_u64).sum::<u64>(),
        3600
    );
}

/// Every format this reads, against the same image in EXR.
#[test]
fn files_of_all_kinds() {
    let folder = Folder::new();
    let image = render(1, SMALL);
    let a = folder.write("a.exr", &image);
    let pfm = folder.write("a.pfm", &image);
    assert_eq!(compare(&[&a, &pfm, "--noise", "none"]).code, 0);
    for name in ["a.png", "a.tga"] {
        let file = folder.write(name, &image);
        let (code, value) = json(&[&a, &file]);
        assert_eq!(
            (code, &value["b"]["decoded_from_srgb"]),
            (0, &Value::from(true)),
            "{value:#}"
        );
        assert_eq!(value["noise"], "spatial");
        let said = compare(&[&file, &file]);
        assert!(said.stdout.contains("decoded from sRGB"), "{}", said.stdout);
        // A byte is up to 1/255 of an encoded value off, at most 0.5 % of the linear one here.
        assert_eq!(
            compare(&[&a, &file, "--noise", "none", "--tolerance", "0.01"]).code,
            0
        );
    }
    let hdr = folder.path("a.hdr");
    let texels = image.pixels.iter().flat_map(|p| p.to_array()).collect();
    image::Rgb32FImage::from_raw(40, 30, texels)
        .expect("as many values as pixels")
        .save(&hdr)
        .expect("a writable folder");
    // Eight bits of mantissa for the brightest channel.
    assert_eq!(
        compare(&[&a, &hdr, "--noise", "none", "--tolerance", "0.01"]).code,
        0
    );
}

/// Where few light paths come, or few samples meet an edge, single pixels and blocks seemed to have no noise: of these scenes nearly every pair was said to differ.
#[test]
fn images_of_rare_light_agree() {
    let folder = Folder::new();
    for name in [
        "spot_mirrorpanel_bdpt",
        "distant_mirrorring_bdpt",
        "distant_glassball_bdpt",
        "distant_direct_bdpt",
    ] {
        let text = std::fs::read_to_string(format!("tests/scenes/census/{name}.pbrt"));
        let text = text.expect("a scene").replace("\"random\"", "\"halton\"");
        let scene = folder.path("scene.pbrt");
        std::fs::write(&scene, text).expect("a writable folder");
        let [a, b] = ["100", "101"].map(|seed| {
            let file = folder.path(&format!("{seed}.exr"));
            let options = ["--spp", "64", "--variance", "--seed", seed, "-o", &file];
            let run = fstop([&["render", &scene], &options[..]].concat());
            assert_eq!(run.code, 0, "{}", run.stderr);
            file
        });
        let run = compare(&[&a, &b, "--no-flip"]);
        assert_eq!(run.code, 0, "{name}: {}", run.stdout);
    }
}

/// Light paths help `path` where there are enough samples, and what they know well the fewer samples of the other image may have missed in
/// whole blocks. Until files said so these were said to differ. In one square of the last scene two halves were alike by chance, and what its neighbors have is a part of its
/// variance.
#[test]
fn images_of_other_light_paths_and_samples_agree() {
    let folder = Folder::new();
    for (name, seeds, is_helped) in [
        ("areasphere_sdsmirror_path", ["100", "101"], true),
        ("areasphere_rr_path", ["102", "103"], true),
        ("spot_mirrorpanel_bdpt", ["103", "102"], false),
    ] {
        let text = std::fs::read_to_string(format!("tests/scenes/census/{name}.pbrt"));
        let text = text.expect("a scene").replace("\"random\"", "\"halton\"");
        let scene = folder.path("scene.pbrt");
        std::fs::write(&scene, text).expect("a writable folder");
        let [a, b] = [("16", seeds[0]), ("256", seeds[1])].map(|(spp, seed)| {
            let file = folder.path(&format!("{seed}.exr"));
            let options = ["--spp", spp, "--variance", "--seed", seed, "-o", &file];
            let run = fstop([&["render", &scene], &options[..]].concat());
            assert_eq!(run.code, 0, "{}", run.stderr);
            file
        });
        let (code, value) = json(&[&a, &b, "--no-flip"]);
        assert_ne!(code, 1, "{name}: {value:#}");
        let paths = |image: &str| value[image]["light_paths"].as_f64().expect("a number");
        assert_eq!(paths("a") != paths("b"), is_helped, "{name}: {value:#}");
        let notes = value["notes"].to_string();
        assert_eq!(notes.contains("no light paths"), is_helped, "{notes}");
        // That the whole image is black would have been found all the same.
        let sizes = value["findable"].as_array().expect("sizes");
        let whole = sizes.iter().find(|size| size["side"].is_null());
        let least = whole.expect("the whole")["relative_difference"].as_f64();
        assert!(least.expect("a number") < 1.0, "{name}: {value:#}");
    }
}

/// Files with the CIE's colors are converted, and it is said.
#[test]
fn colors_of_the_cie_are_converted() {
    use exr::prelude::{Image as File, SpecificChannels, Vec2, WritableImage};
    let folder = Folder::new();
    let image = render(1, SMALL);
    let a = folder.write("a.exr", &image);
    // Of Rec. 709 primaries with D65 (ITU-R BT.709-6 and CIE 15).
    let row = |[x, y, z]: [f32; 3], p: Rgb| p.dot(Rgb::new(x, y, z));
    let channels = SpecificChannels::build()
        .with_channel("X")
        .with_channel("Y")
        .with_channel("Z")
        .with_pixel_fn(|Vec2(x, y)| {
            let p = image.pixels[y * SMALL.x as usize + x];
            (
                row([0.412_391, 0.357_584, 0.180_481], p),
                row([0.212_639, 0.715_169, 0.072_192], p),
                row([0.019_331, 0.119_195, 0.950_532], p),
            )
        });
    let xyz = folder.path("xyz.exr");
    let file = File::from_channels((SMALL.x as usize, SMALL.y as usize), channels);
    { file.write().to_file(&xyz) }.expect("a writable folder");
    // pbrt's matrix differs in its fourth digit.
    let run = compare(&[&a, &xyz, "--noise", "none", "--tolerance", "1e-3"]);
    assert_eq!(run.code, 0, "{}", run.stdout);
    let said = run.stdout.matches("converted from X, Y and Z").count();
    assert_eq!(said, 1, "{}", run.stdout);
}

#[test]
fn windows_must_be_the_same_where_files_know_them() {
    let folder = Folder::new();
    let mut crop = render(1, SMALL);
    crop.resolution = UVec2::new(100, 100);
    crop.bounds = PixelBounds::new(UVec2::new(10, 20), UVec2::new(50, 50));
    let a = folder.write("crop.exr", &crop);
    // PFM does not know.
    assert_eq!(
        compare(&[&a, &folder.write("crop.pfm", &crop), "--noise", "none"]).code,
        0
    );
    let [whole, _] = folder.pair(SMALL);
    let other = compare(&[&a, &whole]);
    assert_eq!(other.code, 2);
    assert!(
        other
            .stderr
            .contains("crop window: A holds x 10..50 y 20..50"),
        "{}",
        other.stderr
    );
    let smaller = folder.write("smaller.exr", &render(1, UVec2::new(30, 40)));
    let other = compare(&[&whole, &smaller]);
    assert_eq!(other.code, 2);
    assert!(
        other.stderr.contains("A is 40 × 30 pixels, B 30 × 40"),
        "{}",
        other.stderr
    );
}

/// Pixels beyond the display window, on either side of it, are pixels as others are; files of other display windows are told apart.
#[test]
fn overscan_is_compared_and_said() {
    use exr::meta::attribute::{Chromaticities, IntegerBounds};
    use exr::meta::header::{ImageAttributes, LayerAttributes};
    use exr::prelude::{Encoding, Image as File, Layer, SpecificChannels, Vec2, WritableImage};
    let folder = Folder::new();
    // Pixels from (−4, −2) on, of a display window of this size at (0, 0).
    let file = |name: &str, seed: u64, display: (usize, usize), red: f32| {
        let image = render(seed, SMALL);
        let of = |Vec2(x, y): Vec2<usize>| image.pixels[y * SMALL.x as usize + x].into();
        let channels = SpecificChannels::rgb(of);
        let attributes = LayerAttributes {
            layer_position: Vec2(-4, -2),
            ..LayerAttributes::default()
        };
        let size = (SMALL.x as usize, SMALL.y as usize);
        let layer = Layer::new(size, attributes, Encoding::UNCOMPRESSED, channels);
        let mut whole = ImageAttributes::new(IntegerBounds::from_dimensions(display));
        whole.chromaticities = Some(Chromaticities {
            red: Vec2(red, 0.33),
            green: Vec2(0.3, 0.6),
            blue: Vec2(0.15, 0.06),
            white: Vec2(0.3127, 0.329),
        });
        let path = folder.path(name);
        { File::new(whole, layer).write().to_file(&path) }.expect("a writable folder");
        path
    };
    let a = file("a.exr", 1, (32, 26), 0.64);
    let b = file("b.exr", 2, (32, 26), 0.64);
    let run = compare(&[&a, &b]);
    assert_eq!(run.code, 0, "{}\n{}", run.stdout, run.stderr);
    let window =
        "of a data window (x -4..36 y -2..28) beyond the display window of 32 × 26 (overscan";
    assert_eq!(run.stdout.matches(window).count(), 2, "{}", run.stdout);
    assert!(!run.stdout.contains("crop"), "{}", run.stdout);
    for word in ["display windows differ", "primaries"] {
        assert!(!run.stdout.contains(word), "{}", run.stdout);
    }
    let other = compare(&[&a, &file("c.exr", 3, (36, 28), 0.708)]).stdout;
    for word in [
        "display windows differ",
        "B has primaries other than Rec. 709's",
    ] {
        assert!(other.contains(word), "{other}");
    }
}

#[test]
fn trouble_has_a_code_of_its_own() {
    let folder = Folder::new();
    let [a, b] = folder.pair(SMALL);
    let png = folder.write("a.png", &render(1, SMALL));
    let broken = folder.path("broken.exr");
    let bytes = std::fs::read(&a).expect("written before");
    std::fs::write(&broken, &bytes[..bytes.len() / 2]).expect("a writable folder");
    let nowhere = folder.path("no/page.html");
    let cases: [(&[&str], &str); 9] = [
        (&[&a, "missing.exr"], "missing.exr"),
        (&[&a, &broken], "broken.exr"),
        (&[&a, "README.md"], "README.md"),
        (
            &[&a, &png, "--noise", "stored"],
            "B has no usable variances",
        ),
        (&[&a, &b, "--alpha", "0"], "probability"),
        (&[&a, &b, "--tolerance", "-1"], "fraction"),
        (&[&a, &b, "--tile", "1"], "--tile"),
        (&[&a, &b, "--html", &nowhere], "page.html"),
        (&[&a], "<B>"),
    ];
    for (arguments, said) in cases {
        let run = compare(arguments);
        // A folder that is missing may be a disk that is not mounted here.
        let code = if said == "page.html" { 74 } else { 2 };
        assert_eq!(run.code, code, "{arguments:?}: {}", run.stdout);
        assert!(run.stderr.contains(said), "{arguments:?}: {}", run.stderr);
    }
}

#[test]
fn values_that_are_no_numbers_are_located() {
    let folder = Folder::new();
    let [a, _] = folder.pair(SMALL);
    let mut broken = render(2, SMALL);
    broken.pixels[47].z = f32::NAN;
    let b = folder.write("nan.exr", &broken);
    let (code, value) = json(&[&a, &b, "--html", &folder.path("nan.html")]);
    assert_eq!(
        (code, &value["b"]["non_finite"]["count"]),
        (1, &Value::from(1))
    );
    assert_eq!(value["b"]["non_finite"]["first"], serde_json::json!([7, 1]));
    assert_eq!(value["a"]["non_finite"], Value::Null);
    assert!(value["metrics"]["mse"].is_number() && value["flip"]["hdr"]["mean"].is_number());
}

#[test]
fn images_without_variances_are_said_to_be() {
    let folder = Folder::new();
    let [a, _] = folder.pair(SMALL);
    let mut bare = render(2, SMALL);
    bare.variance = None;
    let b = folder.write("bare.exr", &bare);
    let run = compare(&[&a, &b]);
    assert_eq!(run.code, 0, "{}", run.stdout);
    assert!(
        run.stdout.contains("note: B has no usable variances: "),
        "{}",
        run.stdout
    );
    assert!(run.stdout.contains("neighbors in blocks of 8 × 8"));
}

#[test]
fn the_page_is_whole_and_needs_no_network() {
    let folder = Folder::new();
    let [a, _] = folder.pair(SMALL);
    let b = folder.write("<b> & \"c\".exr", &render(2, SMALL));
    let file = folder.path("page.html");
    assert_eq!(compare(&[&a, &b, "--html", &file]).code, 0);
    let page = std::fs::read_to_string(&file).expect("the page");
    well_formed(&page);
    for part in [
        "The images agree: ",
        "id=\"canvas\"",
        "value=\"wipe\"",
        "value=\"difference\"",
        "value=\"p\"",
        "value=\"flip\"",
        "id=\"exposure\"",
        "id=\"divide\"",
        "id=\"tests\"",
        "id=\"means\"",
        "id=\"metrics\"",
        "id=\"histograms\"",
        "Histogram of p-values of single pixels",
        "PSNR",
        "prefers-color-scheme: dark",
        "keydown",
        "&lt;b&gt; &amp; &quot;c&quot;.exr",
        "<noscript>",
    ] {
        assert!(page.contains(part), "{part}");
    }
    for outside in [
        "http:", "https:", "src=", "@import", "url(", "fetch(", "NaN", "<b> &",
    ] {
        assert!(!page.contains(outside), "{outside}");
    }
    let data = data(&page);
    assert_eq!(
        (&data["width"], &data["height"], &data["factor"]),
        (&40.into(), &30.into(), &1.into())
    );
    // Halves, three to a pixel; bytes, one to a pixel.
    for (key, bytes) in [("a", 7200), ("b", 7200), ("p", 1200), ("flip", 1200)] {
        assert_eq!(decoded(&data, key).len(), bytes, "{key}");
    }
    let first = half::f16::from_le_bytes([decoded(&data, "a")[0], decoded(&data, "a")[1]]);
    assert_eq!(first, half::f16::from_f32(render(1, SMALL).pixels[0].x));
}

#[test]
fn large_images_are_carried_smaller_and_flip_can_be_left_out() {
    let folder = Folder::new();
    let [a, b] = folder.pair(UVec2::new(1400, 900));
    let file = folder.path("page.html");
    assert_eq!(compare(&[&a, &b, "--no-flip", "--html", &file]).code, 0);
    let page = std::fs::read_to_string(&file).expect("the page");
    well_formed(&page);
    assert!(page.contains("Shown at 700 × 450 pixels, each the mean of 2 × 2"));
    assert!(!page.contains("value=\"flip\""));
    let data = data(&page);
    assert_eq!(decoded(&data, "a").len(), 700 * 450 * 6);
    assert_eq!(data["flip"], Value::Null);
}

/// The images and maps in a page.
fn data(page: &str) -> Value {
    let (_, rest) = page.split_once("id=\"data\">").expect("the data");
    let (data, _) = rest.split_once("</script>").expect("its end");
    serde_json::from_str(data).expect("JSON")
}

fn decoded(data: &Value, key: &str) -> Vec<u8> {
    STANDARD
        .decode(data[key].as_str().expect("text"))
        .expect("base64")
}

/// Every element is closed in the order that they were opened, attributes are quoted, and no two have
/// the same id.
fn well_formed(page: &str) {
    const VOID: [&str; 4] = ["meta", "input", "br", "hr"];
    let mut rest = page
        .strip_prefix("<!DOCTYPE html>")
        .expect("the document's type");
    let (mut open, mut ids) = (Vec::new(), std::collections::BTreeSet::new());
    while let Some(at) = rest.find('<') {
        let (tag, after) = rest[at + 1..].split_once('>').expect("the tag's end");
        rest = after;
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name.to_owned()), "</{name}>");
            continue;
        }
        assert_eq!(tag.matches('"').count() % 2, 0, "<{tag}>");
        let name = tag.split([' ', '/']).next().expect("a name").to_owned();
        if let Some((_, id)) = tag.split_once(" id=\"") {
            let id = id.split('"').next().expect("quoted").to_owned();
            assert!(ids.insert(id.clone()), "two elements are called {id}");
        }
        if ["script", "style"].contains(&name.as_str()) {
            let end = rest.find(&format!("</{name}>")).expect("its end");
            rest = &rest[end + name.len() + 3..];
        } else if !VOID.contains(&name.as_str()) && !tag.ends_with('/') {
            open.push(name);
        }
    }
    assert_eq!(open, Vec::<String>::new());
}

/// Of two sentences that deny each other a page has one.
#[test]
fn no_note_denies_another() {
    let folder = Folder::new();
    let size = UVec2::splat(96);
    let clean = [render(1, size), render(2, size)];
    let scaled = |factor: f32| {
        clean.each_ref().map(|image| {
            let mut image = image.clone();
            image
                .variance
                .iter_mut()
                .flatten()
                .for_each(|variance| *variance *= factor);
            image
        })
    };
    // Each pixel the mean of sixteen: as a splatting filter makes them, whose variances are those of sharp pixels.
    let blurred = |images: &[Image; 2], has_variances: bool| {
        images.each_ref().map(|sharp| {
            let mut image = sharp.clone();
            for pixel in sharp.bounds.pixels() {
                let around = (0..16).map(|k| sharp.pixel(pixel + UVec2::new(k % 4, k / 4)));
                let index = image.bounds.index(pixel).expect("a pixel");
                image.pixels[index] = around.sum::<Rgb>() / 16.0;
            }
            image.variance = image.variance.filter(|_| has_variances);
            image
        })
    };
    let brighter = |[a, mut b]: [Image; 2]| {
        b.pixels.iter_mut().for_each(|value| *value *= 1.1);
        [a, b]
    };
    let denials = [
        ("are too sure", "less easily than they could be"),
        (
            "variances are overestimated",
            "noise that is larger or more skewed",
        ),
        ("The images differ", "either something moved"),
        ("render both with --variance", "or without variances"),
    ];
    let pairs = [
        clean.clone(),
        brighter(clean.clone()),
        scaled(4.0),
        scaled(0.5),
        brighter(scaled(4.0)),
        blurred(&clean, true),
        blurred(&clean, false),
        blurred(&scaled(4.0), true),
        brighter(blurred(&clean, true)),
    ];
    let mut said = String::new();
    for (i, pair) in pairs.iter().enumerate() {
        let [a, b] = [("a.exr", &pair[0]), ("b.exr", &pair[1])]
            .map(|(name, image)| folder.write(name, image));
        let file = folder.path("page.html");
        compare(&[&a, &b, "--html", &file, "--no-flip"]);
        let page = std::fs::read_to_string(&file).expect("the page");
        let head = page.split("</header>").next().expect("a head");
        for (one, other) in denials {
            assert!(
                !(head.contains(one) && head.contains(other)),
                "{i}: {one}, but {other}: {head}"
            );
        }
        said += head;
    }
    // The notes that might have met were all there.
    for (one, other) in denials.into_iter().take(2) {
        assert!(said.contains(one) && said.contains(other), "{one} {other}");
    }
}
