//! The command line as design §7 has it: what each option does to the image, what goes where, and
//! with which code the program ends.

use crate::common::program::{Run, fstop, fstop_in};
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Text};
use fstop::film::{Image, LoadedImage, read};
use fstop::math::UVec2;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// 64×64 pixels under a wide filter, with mirrors, textures and depth.
pub(crate) const MITCHELL: &str = "tests/scenes/reference/filter_mitchell.pbrt";
/// A real lens, stratified samples.
pub(crate) const LENS: &str = "tests/scenes/valid/realistic_camera.pbrt";
/// Instances, Sobol' points, an area light.
pub(crate) const OBJECTS: &str = "tests/scenes/valid/instancing.pbrt";
/// Three frames of 16×12, 8×6 and 4×3 pixels, named in the file.
const FRAMES: &str = "tests/scenes/valid/several_frames.pbrt";

/// A folder for images, gone with the test.
pub(crate) struct Folder(pub tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Folder {
        Folder(tempfile::tempdir().expect("a temporary folder"))
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Everything in the folder, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(self.0.path())
            .expect("the folder")
            .map(|entry| {
                entry
                    .expect("an entry")
                    .file_name()
                    .to_string_lossy()
                    .into_owned()
            })
            .collect();
        names.sort();
        names
    }

    /// `fstop render SCENE -o NAME OPTIONS`, which must end well.
    pub(crate) fn render(&self, scene: &str, name: &str, options: &[&str]) -> Run {
        let run = fstop(command("render", scene, &self.path(name), options));
        assert_eq!(run.code, 0, "{scene} {options:?}\n{}", run.stderr);
        run
    }

    fn image(&self, scene: &str, options: &[&str]) -> Image {
        self.render(scene, "picture.exr", options);
        load(&self.path("picture.exr")).image
    }
}

pub(crate) fn command(word: &str, scene: &str, output: &Path, options: &[&str]) -> Vec<OsString> {
    let mut command: Vec<OsString> = [word, scene, "-o"].map(OsString::from).to_vec();
    command.push(output.into());
    command.extend(options.iter().map(OsString::from));
    command
}

pub(crate) fn load(path: &Path) -> LoadedImage {
    read(path).unwrap_or_else(|error| panic!("{error}"))
}

fn absolute(scene: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join(scene)
        .display()
        .to_string()
}

/// The same bytes, header included, for any number of threads and any tiles.
#[test]
fn threads_and_tiles_change_no_byte() {
    let folder = Folder::new();
    let ways: [&[&str]; 6] = [
        &["--threads", "1"],
        &["--threads", "2"],
        &["--threads", "5", "--tile-size", "7"],
        &["--threads", "2", "--tile-size", "1"],
        &["--threads", "1", "--tile-size", "33"],
        &["--tile-size", "100000"],
    ];
    for scene in [MITCHELL, LENS, OBJECTS] {
        let mut first = None;
        for options in ways {
            let options = [options, &["--spp", "4", "--variance"]].concat();
            folder.render(scene, "a.exr", &options);
            let bytes = std::fs::read(folder.path("a.exr")).expect("the image");
            assert!(
                first.get_or_insert_with(|| bytes.clone()) == &bytes,
                "{scene} {options:?}"
            );
        }
    }
}

#[test]
fn seeds_change_the_noise() {
    let folder = Folder::new();
    let one = folder.image(MITCHELL, &["--spp", "2"]);
    assert_eq!(one, folder.image(MITCHELL, &["--spp", "2", "--seed", "0"]));
    assert_ne!(one, folder.image(MITCHELL, &["--spp", "2", "--seed", "1"]));
}

/// Exactly the pixels of the whole image, and no others.
#[test]
fn a_crop_is_cut_from_the_whole() {
    let folder = Folder::new();
    let whole = folder.image(MITCHELL, &["--spp", "4", "--variance"]);
    let crop = folder.image(
        MITCHELL,
        &[
            "--spp",
            "4",
            "--variance",
            "--crop",
            ".25,.5,.5,1",
            "--tile-size",
            "5",
        ],
    );
    assert_eq!(crop.resolution, whole.resolution);
    assert_eq!(
        (crop.bounds.min, crop.bounds.max),
        (UVec2::new(16, 32), UVec2::new(32, 64))
    );
    for pixel in crop.bounds.pixels() {
        assert_eq!(crop.pixel(pixel), whole.pixel(pixel), "{pixel}");
        assert_eq!(variance(&crop, pixel), variance(&whole, pixel), "{pixel}");
    }
}

fn variance(image: &Image, pixel: UVec2) -> fstop::math::Rgb {
    let index = image.bounds.index(pixel).expect("a pixel of the image");
    image.variance.as_ref().expect("variances")[index]
}

/// pbrt's own spelling: four arguments, and a crop window in the scene comes first.
#[test]
fn pbrts_cropwindow_yields_to_the_scenes() {
    let folder = Folder::new();
    let cropwindow = ["--cropwindow", "0", ".5", "0", ".25"];
    let options = [&cropwindow[..], &["--spp", "1"]].concat();
    let free = folder.image(MITCHELL, &options);
    assert_eq!(free.bounds.max, UVec2::new(32, 16));
    let scenes_own = folder.image("tests/scenes/valid/cropped.pbrt", &options);
    let bounds = scenes_own.bounds;
    // 32×24 pixels, cropwindow .75 .25 0 .5: ends in the wrong order are exchanged.
    assert_eq!(
        (bounds.min, bounds.max),
        (UVec2::new(8, 0), UVec2::new(24, 12))
    );
}

#[test]
fn a_bad_crop_is_refused() {
    let folder = Folder::new();
    for crop in ["0,1,0", "0,1,0,nan", ".5,.5,0,1", "a,b,c,d"] {
        let run = fstop(command(
            "render",
            MITCHELL,
            &folder.path("a.exr"),
            &["--crop", crop],
        ));
        assert_eq!(
            (run.code, folder.names().len()),
            (2, 0),
            "{crop}\n{}",
            run.stderr
        );
    }
}

#[test]
fn variance_adds_its_channels() {
    let folder = Folder::new();
    folder.render(MITCHELL, "without.exr", &["--spp", "4"]);
    folder.render(MITCHELL, "with.exr", &["--spp", "4", "--variance"]);
    let without = load(&folder.path("without.exr")).image;
    let with = load(&folder.path("with.exr")).image;
    assert_eq!(channels(&folder.path("without.exr")), ["B", "G", "R"]);
    assert_eq!(
        channels(&folder.path("with.exr")),
        ["B", "G", "R", "var.B", "var.G", "var.R"]
    );
    assert_eq!(without.pixels, with.pixels);
    let variances = with.variance.expect("variances");
    assert!(
        variances
            .iter()
            .all(|v| v.is_finite() && v.min_element() >= 0.0)
    );
    assert!(variances.iter().any(|v| v.max_element() > 0.0));
}

/// Well-distributed samples are taken in halves that share factors; few ones and independent ones are not.
#[test]
fn variances_say_how_well_they_are_known() {
    let folder = Folder::new();
    let scene = |sampler: &str, spp: u32| {
        let text = format!(
            "Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8\n\
             Sampler \"{sampler}\" \"integer pixelsamples\" {spp}\nWorldBegin\n\
             LightSource \"point\" \"point from\" [0 2 0]\nShape \"sphere\" \"float radius\" 3\nWorldEnd\n"
        );
        let path = folder.path("scene.pbrt");
        std::fs::write(&path, text).expect("a file");
        folder.render(&path.display().to_string(), "a.exr", &["--variance"]);
        let loaded = load(&folder.path("a.exr"));
        (loaded.spp, loaded.freedom, loaded.pool)
    };
    assert_eq!(scene("halton", 8), (Some(8), Some(6.0), Some(4)));
    assert_eq!(scene("halton", 7), (Some(7), Some(5.0), Some(4)));
    assert_eq!(scene("halton", 3), (Some(3), Some(2.0), None));
    assert_eq!(scene("random", 8), (Some(8), Some(7.0), None));
}

fn channels(path: &Path) -> Vec<String> {
    let meta = MetaData::read_from_file(path, true).expect("an EXR file");
    let list = &meta.headers[0].channels.list;
    list.iter()
        .map(|channel| channel.name.to_string())
        .collect()
}

/// What the header says about how the image was made.
#[test]
fn the_exr_tells_its_story() {
    let folder = Folder::new();
    folder.render(
        LENS,
        "a.exr",
        &["--spp", "3", "--seed", "18446744073709551615"],
    );
    let meta = MetaData::read_from_file(folder.path("a.exr"), true).expect("an EXR file");
    let own = &meta.headers[0].own_attributes;
    let text = |name: &str| match own.other.get(&Text::from(name)) {
        Some(AttributeValue::Text(text)) => text.to_string(),
        other => panic!("{name}: {other:?}"),
    };
    // Stratified samples would round the count; these are Sobol' points.
    assert_eq!(
        own.other.get(&Text::from("spp")),
        Some(&AttributeValue::I32(3))
    );
    assert_eq!(text("seed"), "18446744073709551615");
    assert_eq!(text("scene"), "realistic_camera.pbrt");
    assert_eq!(text("lens"), "wild.dat");
    let software = own.software_name.as_ref().expect("software").to_string();
    assert_eq!(software, concat!("fstop ", env!("CARGO_PKG_VERSION")));
    // The camera stands at the origin of the world.
    let identity = glam::Mat4::IDENTITY.to_cols_array();
    assert_eq!(own.world_to_camera, Some(identity));
    let ndc = own.world_to_normalized_device.expect("worldToNDC");
    let ndc = glam::Mat4::from_cols_array(&ndc);
    // Straight ahead is the middle of the image.
    let middle = ndc.project_point3(glam::Vec3::new(0.0, 0.0, 10.0));
    // Rounding of 16 single-precision numbers of size 1.
    assert!(
        (middle.truncate() - 0.5).abs().max_element() < 1e-5,
        "{middle}"
    );
    // The data window of a crop is smaller than the display window.
    folder.render(MITCHELL, "b.exr", &["--spp", "1", "--crop", "0.5,1,0,1"]);
    let meta = MetaData::read_from_file(folder.path("b.exr"), true).expect("an EXR file");
    let display = meta.headers[0].shared_attributes.display_window;
    assert_eq!((display.size.x(), display.size.y()), (64, 64));
    assert_eq!(meta.headers[0].layer_size.x(), 32);
    assert_eq!(meta.headers[0].own_attributes.layer_position.x(), 32);
    assert!(
        !meta.headers[0]
            .own_attributes
            .other
            .contains_key(&Text::from("lens"))
    );
}

#[test]
fn png_output_is_the_image_in_srgb() {
    let folder = Folder::new();
    let png = folder.path("beside.png");
    let png = png.to_str().expect("a name in UTF-8");
    folder.render(MITCHELL, "a.exr", &["--spp", "2", "--png", png]);
    folder.render(MITCHELL, "b.png", &["--spp", "2"]);
    folder.render(MITCHELL, "c.PNG", &["--spp", "2", "--threads", "1"]);
    let exr = load(&folder.path("a.exr")).image;
    let first = image::open(png).expect("a PNG file").to_rgb8();
    for name in ["b.png", "c.PNG"] {
        let other = image::open(folder.path(name))
            .expect("a PNG file")
            .to_rgb8();
        assert_eq!(first, other, "{name}");
    }
    assert_eq!(first.dimensions(), (64, 64));
    for pixel in exr.bounds.pixels() {
        for channel in 0..3 {
            let linear = exr.pixel(pixel)[channel].clamp(0.0, 1.0);
            // IEC 61966-2-1.
            let encoded = if linear <= 0.003_130_8 {
                12.92 * linear
            } else {
                1.055 * linear.powf(1.0 / 2.4) - 0.055
            };
            let found = f32::from(first.get_pixel(pixel.x, pixel.y)[channel]);
            // Half a step of rounding, and a hundredth for the two ways to compute a power.
            assert!((found - 255.0 * encoded).abs() < 0.51, "{pixel} {channel}");
        }
    }
}

/// Several frames: each to the file its Film names, or to numbered files beside the one `-o` names.
#[test]
fn every_frame_gets_its_file() {
    let folder = Folder::new();
    let scene = absolute(FRAMES);
    let run = fstop_in(folder.0.path(), ["render", "--spp", "1", scene.as_str()]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(folder.names(), ["one.exr", "three.exr", "two.exr"]);
    let sizes = ["one.exr", "two.exr", "three.exr"].map(|n| load(&folder.path(n)).image.resolution);
    assert_eq!(
        sizes,
        [UVec2::new(16, 12), UVec2::new(8, 6), UVec2::new(4, 3)]
    );
    let folder = Folder::new();
    let png = folder.path("p.png");
    let png = png.to_str().expect("a name in UTF-8");
    folder.render(FRAMES, "a.exr", &["--spp", "1", "--png", png]);
    assert_eq!(
        folder.names(),
        ["a.2.exr", "a.3.exr", "a.exr", "p.2.png", "p.3.png", "p.png"]
    );
}

/// What cannot be written is said before anything is rendered, and nothing is left lying about.
#[test]
fn a_bad_output_is_refused_before_rendering() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("folder.exr")).expect("a folder");
    std::fs::write(folder.path("file"), "").expect("a file");
    for (output, word, code) in [
        ("nowhere/a.exr", "there is no folder `", 74),
        ("file/a.exr", "there is no folder `", 74),
        ("folder.exr", "is a folder", 2),
        ("a.gif", "must end in", 2),
        ("a", "must end in", 2),
    ] {
        // At a million samples a pixel, rendering first would not end within the test's patience.
        let options = ["--spp", "1000000"];
        let run = fstop(command("render", MITCHELL, &folder.path(output), &options));
        assert_eq!(run.code, code, "{output}\n{}", run.stderr);
        assert!(run.stderr.contains(word), "{output}\n{}", run.stderr);
        assert!(!run.stderr.contains(".fstop-"), "a hidden file is no news");
        assert!(
            !run.stderr.contains("field of view"),
            "rendering began\n{}",
            run.stderr
        );
        assert_eq!(folder.names(), ["file", "folder.exr"], "{output}");
    }
    // A later frame's file counts too: nothing is rendered before it is known to be good.
    let scene = folder.path("frames.pbrt");
    let frame = |name: &str| {
        let film = format!(
            "\"integer xresolution\" 4 \"integer yresolution\" 4 \"string filename\" \"{name}\""
        );
        format!("Film \"image\" {film}\nWorldBegin\nLightSource \"infinite\"\nWorldEnd\n")
    };
    std::fs::write(&scene, frame("good.exr") + &frame("nowhere/bad.exr")).expect("a scene");
    let run = fstop_in(folder.0.path(), ["render", "frames.pbrt"]);
    assert_eq!(run.code, 74, "{}", run.stderr);
    assert_eq!(folder.names(), ["file", "folder.exr", "frames.pbrt"]);
}

#[cfg(unix)]
#[test]
fn a_folder_without_permission_is_refused_before_rendering() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let locked = folder.path("locked");
    std::fs::create_dir(&locked).expect("a folder");
    std::fs::set_permissions(&locked, PermissionsExt::from_mode(0o555)).expect("permissions");
    if std::fs::write(locked.join("probe"), "").is_ok() {
        println!("skipped: this user may write everywhere");
        return;
    }
    let run = fstop(command(
        "render",
        MITCHELL,
        &locked.join("a.exr"),
        &["--spp", "1000000"],
    ));
    assert_eq!(run.code, 74, "{}", run.stderr);
    assert!(run.stderr.contains("cannot write"), "{}", run.stderr);
}

/// An image that was there is replaced whole.
#[test]
fn an_image_is_replaced() {
    let folder = Folder::new();
    std::fs::write(folder.path("a.exr"), "old").expect("a file");
    folder.render(OBJECTS, "a.exr", &["--spp", "1"]);
    assert_eq!(
        load(&folder.path("a.exr")).image.resolution,
        UVec2::new(16, 12)
    );
    assert_eq!(folder.names(), ["a.exr"]);
}

#[test]
fn a_scene_alone_is_rendered() {
    let folder = Folder::new();
    let scene = absolute(FRAMES);
    let run = fstop_in(folder.0.path(), [scene.as_str(), "--spp", "1"]);
    assert_eq!((run.code, folder.names().len()), (0, 3), "{}", run.stderr);
    let folder = Folder::new();
    let run = fstop_in(folder.0.path(), ["--quiet", "--spp", "1", scene.as_str()]);
    assert_eq!((run.code, folder.names().len()), (0, 3), "{}", run.stderr);
    assert_eq!((run.stderr, run.stdout), (String::new(), String::new()));
}

/// pbrt's own options, in pbrt's spelling and order.
#[test]
fn pbrts_options_are_understood() {
    let folder = Folder::new();
    let output = folder.path("a.exr");
    let output = output.to_str().expect("a name in UTF-8");
    let run = fstop([
        "--quick",
        "--quiet",
        "--nthreads",
        "1",
        "--outfile",
        output,
        MITCHELL,
    ]);
    assert_eq!((run.code, run.stderr.as_str()), (0, ""));
    let quick = load(&folder.path("a.exr"));
    assert_eq!(quick.image.resolution, UVec2::new(16, 16));
    // `random` keeps its count under --quick, as in pbrt-v3; the others take one sample.
    assert_eq!(quick.spp, Some(128));
    folder.render(OBJECTS, "b.exr", &["--quick"]);
    assert_eq!(load(&folder.path("b.exr")).spp, Some(1));
    // Values may follow an equals sign.
    let outfile = format!("--outfile={output}");
    let run = fstop(["--quick", outfile.as_str(), "--nthreads=2", OBJECTS]);
    assert_eq!(run.code, 0, "{}", run.stderr);
}

/// Warnings are no hindrance unless asked to be; checking and rendering agree on it.
#[test]
fn strict_refuses_warnings() {
    let folder = Folder::new();
    let scene = "tests/scenes/valid/unknown_types.pbrt";
    assert_eq!(fstop(["check", scene]).code, 0);
    let strict = fstop(["check", "--strict", scene]);
    assert_eq!(strict.code, 2);
    assert!(
        strict
            .stdout
            .contains("not fit to render with --strict (7 warnings)"),
        "{}",
        strict.stdout
    );
    let run = fstop(command(
        "render",
        scene,
        &folder.path("a.exr"),
        &["--strict", "--spp", "1"],
    ));
    assert_eq!((run.code, folder.names().len()), (2, 0), "{}", run.stderr);
    let why = "refused because of --strict";
    assert!(run.stderr.contains(why), "{}", run.stderr);
    // Notes are not warnings.
    folder.render(
        "tests/scenes/valid/integrators.pbrt",
        "a.exr",
        &["--strict", "--spp", "1"],
    );
}

#[test]
fn check_takes_several_files() {
    let good = "tests/scenes/valid/crlf.pbrt";
    let bad = "tests/scenes/invalid/several_files.pbrt";
    let run = fstop(["check", good, LENS]);
    let expected = format!("{good}: ok\n{LENS}: ok\n");
    assert_eq!(
        (run.code, run.stdout, run.stderr),
        (0, expected, String::new())
    );
    let run = fstop(["check", good, bad, "tests/scenes/nowhere.pbrt", LENS]);
    assert_eq!(run.code, 2);
    let verdicts: Vec<&str> = run.stdout.lines().collect();
    assert_eq!(verdicts.len(), 4, "{}", run.stdout);
    assert_eq!(verdicts[0], format!("{good}: ok"));
    assert!(verdicts[1].starts_with(&format!("{bad}: not fit to render (6 errors")));
    assert_eq!(
        verdicts[2],
        "tests/scenes/nowhere.pbrt: not fit to render (1 error)"
    );
    assert_eq!(verdicts[3], format!("{LENS}: ok"));
    assert!(
        run.stderr
            .contains("cannot read `tests/scenes/nowhere.pbrt`"),
        "{}",
        run.stderr
    );
}

/// Values that begin with a hyphen are values: what is said is what is wrong with them.
#[test]
fn negative_values_are_understood_and_refused() {
    const LENS_FILE: &str = "lenses/dgauss.50mm.dat";
    for (arguments, words) in [
        (
            &["lens", LENS_FILE, "--aperture", "-1"][..],
            "--aperture -1: expected",
        ),
        (
            &["lens", LENS_FILE, "--film-distance", "-5"],
            "--film-distance -5: expected a positive number",
        ),
        (
            &["lens", LENS_FILE, "--focus", "-1"],
            "invalid value '-1' for '--focus <M>': expected a distance in meters",
        ),
        (
            &["lens", LENS_FILE, "--scale", "-2"],
            "--scale -2: expected a positive number",
        ),
        (
            &["render", MITCHELL, "--threads", "-2"],
            "invalid value '-2' for '--threads",
        ),
        (
            &["render", MITCHELL, "--seed", "-2"],
            "expected a whole number from 0",
        ),
        (&["render", MITCHELL, "-o", "-x.exr"], "written `./-x.exr`"),
        (&["render", MITCHELL, "--time", "1e30"], "too long"),
        (
            &["render", MITCHELL, "--spp", "-3"],
            "expected a whole number from 1",
        ),
        (
            &["render", MITCHELL, "--crop", "-1,-.5,0,1"],
            "--crop: the crop window",
        ),
    ] {
        let run = fstop(arguments);
        assert_eq!(run.code, 2, "{arguments:?}\n{}", run.stderr);
        assert!(run.stderr.contains(words), "{arguments:?}\n{}", run.stderr);
    }
    // Cut to the image, as in a scene file.
    let folder = Folder::new();
    let cut = folder.image(MITCHELL, &["--crop", "-1,2,0,.25", "--spp", "1"]);
    assert_eq!(cut.bounds.max, UVec2::new(64, 16));
}

/// Far more threads than any processor needs are not started; the image is the same.
#[test]
fn threads_are_limited() {
    let folder = Folder::new();
    let started = std::time::Instant::now();
    let run = folder.render(MITCHELL, "a.exr", &["--spp", "1", "--threads", "100000"]);
    // Starting as many as asked for took minutes; the limit takes a fraction of a second.
    assert!(started.elapsed().as_secs() < 20, "{:?}", started.elapsed());
    let told = run.stderr.matches("warning: --threads 100000: ").count();
    assert_eq!(told, 1, "{}", run.stderr);
    let run = folder.render(MITCHELL, "b.exr", &["--spp", "1", "--threads", "2"]);
    assert!(!run.stderr.contains("--threads"), "{}", run.stderr);
    let [a, b] = ["a.exr", "b.exr"].map(|n| std::fs::read(folder.path(n)).expect("an image"));
    assert!(a == b);
}

#[test]
fn outputs_must_not_collide() {
    let folder = Folder::new();
    for (image, png, words) in [
        ("x.exr", "x.exr", "expected a name ending in .png"),
        ("x.png", "x.png", "written there already"),
        ("x.png", "./x.png", "written there already"),
        ("x.exr", "x.tga", "expected a name ending in .png"),
    ] {
        let scene = absolute(MITCHELL);
        let arguments = ["render", &scene, "--spp", "1", "-o", image, "--png", png];
        let run = fstop_in(folder.0.path(), arguments);
        assert_eq!(run.code, 2, "{image} {png}\n{}", run.stderr);
        assert!(run.stderr.contains(words), "{image} {png}\n{}", run.stderr);
        assert!(folder.names().is_empty());
    }
    let run = fstop(["merge", "x.fsc", "-o", "x.exr", "--png", "y.exr"]);
    let words = "expected a name ending in .png";
    assert!(
        run.code == 2 && run.stderr.contains(words),
        "{}",
        run.stderr
    );
}

/// Stored variances, of several samples or of one, which tells none.
#[test]
fn it_is_said_what_is_known_of_the_noise() {
    let folder = Folder::new();
    let compare = |spp: &str, more: &[&str]| {
        folder.render(MITCHELL, "a.exr", &["--variance", "--spp", spp]);
        let image = folder.path("a.exr").display().to_string();
        let arguments = ["compare", &image, &image, "--no-flip"];
        fstop(arguments.iter().chain(more))
    };
    let run = compare("4", &["--cell", "4"]);
    let words = "--cell has no effect";
    assert!(run.stderr.contains(words), "{}", run.stderr);
    let run = compare("1", &["--cell", "4"]);
    assert!(!run.stderr.contains(words), "{}", run.stderr);
    assert!(run.stdout.contains("tells no variances"), "{}", run.stdout);
}

#[test]
fn options_of_lenses_need_one() {
    let folder = Folder::new();
    let run = folder.render(MITCHELL, "a.exr", &["--spp", "1", "--f-number", "4"]);
    let words = "--f-number has no effect";
    assert!(run.stderr.contains(words), "{}", run.stderr);
}

#[test]
fn variance_without_a_place_for_it_is_warned_about() {
    let folder = Folder::new();
    let told = |run: &Run| run.stderr.contains("--variance has no effect");
    let options = ["--spp", "2", "--variance"];
    assert!(told(&folder.render(MITCHELL, "a.png", &options)));
    assert!(!told(&folder.render(MITCHELL, "a.exr", &options)));
}

#[test]
fn misuse_ends_with_code_2_and_help_with_0() {
    for arguments in [
        &[][..],
        &["render"],
        &["check"],
        &["lens"],
        &["tests/scenes/nowhere.pbrt"],
        &["render", MITCHELL, "--spp", "0"],
        &["render", MITCHELL, "--spp", "many"],
        &["render", MITCHELL, "--nonsense"],
        &["render", MITCHELL, MITCHELL],
        &["check", "--dialect", "v4", MITCHELL],
        &["lens", "nowhere.dat"],
        &["lens", MITCHELL],
        &["lens", "lenses/dgauss.50mm.dat", "--focus", ".05"],
        &["lens", "lenses/dgauss.50mm.dat", "--aperture", "-1"],
        &["lens", "lenses/dgauss.50mm.dat", "--scale", "0"],
        &["lens", "lenses/dgauss.50mm.dat", "--map-size", "9x9"],
        &["lens", "lenses/dgauss.50mm.dat", "--depths", "1"],
        &["lens", "lenses/dgauss.50mm.dat", "--stmap", "x.png"],
    ] {
        let run = fstop(arguments);
        assert_eq!(run.code, 2, "{arguments:?}\n{}{}", run.stdout, run.stderr);
        assert!(
            !run.stderr.is_empty() && run.stdout.is_empty(),
            "{arguments:?}"
        );
    }
    for arguments in [
        &["--help"][..],
        &["--version"],
        &["help"],
        &["render", "--help"],
    ] {
        let run = fstop(arguments);
        assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{arguments:?}");
        assert!(run.stdout.contains("fstop"), "{}", run.stdout);
    }
}

/// Standard input is a scene like any other; names in it start at the working directory.
#[test]
fn a_scene_comes_from_standard_input() {
    use std::io::Write;
    use std::process::{Command, Stdio};
    let folder = Folder::new();
    let mut child = Command::new(env!("CARGO_BIN_EXE_fstop"))
        .args(["render", "-", "--spp", "1", "--quiet"])
        .current_dir(folder.0.path())
        .stdin(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let scene = std::fs::read(absolute(FRAMES)).expect("the scene");
    let mut input = child.stdin.take().expect("its standard input");
    input.write_all(&scene).expect("a willing listener");
    drop(input);
    assert!(child.wait().expect("an end").success());
    assert_eq!(folder.names(), ["one.exr", "three.exr", "two.exr"]);
}

/// The keys of issue 2, in mm; the values are the 50 mm double Gauss's.
#[test]
fn a_lens_in_json() {
    for lens in [
        "dgauss.50mm",
        "dgauss.100mm",
        "fisheye.10mm",
        "telephoto.250mm",
        "wide.22mm",
    ] {
        let run = fstop(["lens", "--json", &format!("lenses/{lens}.dat")]);
        assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{lens}");
        let json: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
        let number = |key: &str| {
            json[key]
                .as_f64()
                .unwrap_or_else(|| panic!("{lens}: {key}"))
        };
        let focal_length = number("effective_focal_length");
        // `dgauss.50mm` promises 50 mm; lens makers round by a few percent.
        let promised: f64 = lens
            .split(['.', 'm'])
            .rev()
            .find_map(|s| s.parse().ok())
            .expect("mm");
        assert!(
            (focal_length / promised - 1.0).abs() < 0.05,
            "{lens}: {focal_length}"
        );
        assert!(number("back_focal_distance") > 0.0 && number("f_number") > 1.0);
        assert!(number("front_focal_distance").is_finite());
        for pupil in ["entrance_pupil", "exit_pupil"] {
            let of = |key: &str| json[pupil][key].as_f64();
            assert!(
                of("z").is_some() && of("diameter") > Some(0.0),
                "{lens}: {pupil}"
            );
        }
        // The definition of the f-number.
        let diameter = json["entrance_pupil"]["diameter"]
            .as_f64()
            .expect("a number");
        // Rounding of a division and of printing to 17 digits.
        assert!((number("f_number") / (focal_length / diameter) - 1.0).abs() < 1e-12);
        let text = fstop(["lens", &format!("lenses/{lens}.dat")]);
        assert!(
            text.code == 0 && text.stdout.contains("focal length"),
            "{}",
            text.stdout
        );
    }
}

/// One line says that a file was read as pbrt-v2 and why; `--dialect` decides otherwise.
#[test]
fn the_dialect_is_told_and_can_be_overruled() {
    let course = "tests/scenes/valid/course_camera.pbrt";
    let told = |run: &Run| run.stderr.matches("read as a pbrt-v2 scene").count();
    let folder = Folder::new();
    let auto = folder.render(course, "a.exr", &[]);
    assert_eq!(told(&auto), 1, "{}", auto.stderr);
    let v3 = folder.render(course, "b.exr", &["--dialect", "v3"]);
    assert_eq!(told(&v3), 0, "{}", v3.stderr);
    let v2 = folder.render(course, "c.exr", &["--dialect", "v2"]);
    assert_eq!(told(&v2), 0, "{}", v2.stderr);
    let [a, c] = ["a.exr", "c.exr"].map(|name| std::fs::read(folder.path(name)).expect("an image"));
    assert!(a == c, "asked for or found out, v2 is v2");
    // pbrt-v2's defaults differ: 640×480 and 4 samples against 1280×720 and 16.
    let plain = "tests/scenes/valid/defaults.pbrt";
    let small = folder.image(plain, &["--dialect", "v2", "--spp", "1"]);
    assert_eq!(small.resolution, UVec2::new(640, 480));
    let large = folder.image(plain, &["--spp", "1"]);
    assert_eq!(large.resolution, UVec2::new(1280, 720));
    // A v2 directive under --dialect v3 is warned about, and not rendered as v2.
    let run = fstop([
        "check",
        "--dialect",
        "v3",
        "tests/scenes/valid/v2_directives.pbrt",
    ]);
    assert!(
        run.stderr.contains("read as pbrt-v3 as asked"),
        "{}",
        run.stderr
    );
    assert_eq!(told(&run), 0);
}
