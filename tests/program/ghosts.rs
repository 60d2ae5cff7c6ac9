//! `"bool ghosts"` as a user meets it: what is said, and what the image's file says of the lens.

use super::cli::Folder;
use super::layers::Channels;
use crate::common::program::{Run, fstop};
use exr::prelude::{ReadChannels, ReadLayers};

const LENS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/lenses/dgauss.50mm.dat");

/// A white wall of light before a double Gauss.
fn scene(folder: &Folder, camera: &str, rest: &str) -> String {
    let text = format!(
        "Film \"image\" \"integer xresolution\" [6] \"integer yresolution\" [4] \"float diagonal\" 43.27\n\
         Camera \"realistic\" \"string lensfile\" \"{LENS}\" \"float focusdistance\" inf {camera}\n{rest}\n\
         WorldBegin\nLightSource \"infinite\" \"rgb L\" [1 1 1]\nWorldEnd\n"
    );
    let path = folder.path("scene.pbrt");
    std::fs::write(&path, text).expect("room for a scene");
    path.display().to_string()
}

fn render(camera: &str, rest: &str) -> (Run, Folder) {
    let folder = Folder::new();
    let scene = scene(&folder, camera, rest);
    let run = folder.render(&scene, "f.exr", &["--spp", "256"]);
    (run, folder)
}

/// The T-number in the image's file, and the brightness of its middle.
fn t_stop(folder: &Folder) -> (f64, f64) {
    let path = folder.path("f.exr");
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(&path)
        .expect("an EXR file");
    let t_stop = image
        .layer_data
        .attributes
        .other
        .get(&exr::meta::attribute::Text::from("tStop"))
        .cloned();
    let Some(exr::meta::attribute::AttributeValue::F32(t_stop)) = t_stop else {
        panic!("{t_stop:?}");
    };
    let green = Channels::of(&path).get("G").to_vec();
    (
        f64::from(t_stop),
        f64::from(green[8] + green[9] + green[14] + green[15]) / 4.0,
    )
}

/// The file, `fstop lens --ghosts` and the picture say the same of what surfaces reflect.
#[test]
fn the_t_number_is_that_of_the_lens_with_its_reflections() {
    for coating in ["", "1.38@550"] {
        let open = "\"float aperturediameter\" 14 \"bool simpleweighting\" \"false\"";
        let reflecting =
            format!("{open} \"bool ghosts\" \"true\" \"string coating\" \"{coating}\"");
        let (_, bright) = t_stop(&render(open, "").1);
        let (run, folder) = render(&reflecting, "");
        assert_eq!(run.stderr.matches("warning").count(), 0, "{}", run.stderr);
        let (found, dark) = t_stop(&folder);
        let coated: &[&str] = if coating.is_empty() {
            &[]
        } else {
            &["--coating", coating]
        };
        let table = fstop(
            [
                &["lens", LENS, "--aperture", "14", "--ghosts", "5", "--json"],
                coated,
            ]
            .concat(),
        );
        let table: serde_json::Value = serde_json::from_str(&table.stdout).expect("JSON");
        let expected = table["t_number"].as_f64().expect("a number");
        // Single precision.
        assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
        let transmitted = table["transmitted"].as_f64().expect("a number");
        // The picture lacks that, but for what ghosts of the sky bring back: some percent of what is reflected. At 549 nm instead of 588 a coating
        // reflects less by a tenth.
        let left = dark / bright;
        assert!(
            (transmitted - 0.01..transmitted + 0.1).contains(&left),
            "{left} {transmitted}"
        );
        // A T-number that is asked for is that of the file.
        let asked = format!(
            "\"float tnumber\" 5 \"bool ghosts\" \"true\" \"string coating\" \"{coating}\""
        );
        let (found, _) = t_stop(&render(&asked, "").1);
        // What is transmitted is a mean over some thousand rays, of which a few come and go with the stop.
        assert!((found / 5.0 - 1.0).abs() < 1e-3, "{found}");
    }
}

#[test]
fn it_is_said_where_there_are_no_ghosts() {
    let ghosts = "\"bool ghosts\" \"true\"";
    for (camera, rest, words) in [
        (
            "\"string model\" \"thick\"",
            "",
            "there are no ghosts: they need the lens model",
        ),
        (
            "",
            "Integrator \"sppm\" \"integer iterations\" 2",
            "the image has no ghosts",
        ),
        (
            "",
            "Integrator \"ambientocclusion\"",
            "the image has no ghosts",
        ),
        (
            "",
            "Sampler \"halton\" \"bool samplepixelcenter\" \"true\"",
            "the image has no ghosts",
        ),
    ] {
        let (run, _) = render(&format!("{ghosts} {camera}"), rest);
        assert!(
            run.stderr.contains(words),
            "{camera} {rest}: {}",
            run.stderr
        );
    }
    let (run, _) = render("\"string coating\" \"1.38@550\"", "");
    assert!(
        run.stderr.contains("without \"bool ghosts\""),
        "{}",
        run.stderr
    );
    let folder = Folder::new();
    let scene = scene(
        &folder,
        &format!("{ghosts} \"string coating\" \"thick\""),
        "",
    );
    let run = fstop(["render", &scene]);
    assert!(
        run.code != 0 && run.stderr.contains("expected INDEX@NM"),
        "{}",
        run.stderr
    );
}

/// Ghosts are in the layers of their lights.
#[test]
fn layers_of_light_add_up_to_the_picture_with_its_ghosts() {
    let folder = Folder::new();
    let scene = "tests/scenes/valid/ghosts.pbrt";
    folder.render(scene, "f.exr", &["--spp", "64", "--aov", "lights"]);
    let found = Channels::of(&folder.path("f.exr"));
    for channel in ["R", "G", "B"] {
        let layer = |name: &str| found.get(&format!("light_{name}.{channel}"));
        let parts = [layer("rest"), layer("lamps"), layer("sky")];
        for (pixel, whole) in found.get(channel).iter().enumerate() {
            let sum: f32 = parts.iter().map(|part| part[pixel]).sum();
            // Single precision of sums of some twenty terms.
            assert!(
                (sum - whole).abs() <= 1e-5 * whole.abs().max(1e-3),
                "{channel} of {pixel}: {whole}, not {sum}"
            );
        }
        // No camera path meets a light without area, and there is nothing above the ground that it shines on but the lens.
        let distant: f32 = layer("rest")[..24].iter().sum();
        assert!(distant > 0.0);
    }
}
