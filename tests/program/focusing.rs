//! Focus on what the image shows, and films that are tilted: as a photographer sees them, in the image and in what is said of it.

use super::cli::Folder;
use crate::common::program::{Run, fstop};
use exr::prelude::{ReadChannels, ReadLayers};

const LENS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/lenses/dgauss.50mm.dat");

/// Cards at 2 m on the left and 1.2 m on the right half of what is seen, from the camera's origin, in units of `scale` a meter; above them there is nothing.
fn cards(scale: f64) -> String {
    let card = |x: [f64; 2], z: f64| {
        let [left, right, z, y] = [x[0], x[1], z, 0.1].map(|v| v * scale);
        format!(
            "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
             \"point P\" [{left} -{scale} {z} {right} -{scale} {z} {right} {y} {z} {left} {y} {z}]\n"
        )
    };
    format!(
        "WorldBegin\nLightSource \"distant\" \"point from\" [0 0 -1] \"point to\" [0 0 1]\n{}{}WorldEnd\n",
        card([-2.0, 0.0], 2.0),
        card([0.0, 2.0], 1.2)
    )
}

fn scene(folder: &Folder, camera: &str, world: &str) -> String {
    let text = format!(
        "Film \"image\" \"integer xresolution\" [60] \"integer yresolution\" [40] \"float diagonal\" 43.27\n\
         Sampler \"halton\" \"integer pixelsamples\" 1\nIntegrator \"directlighting\"\n{camera}\n{world}"
    );
    let path = folder.path("scene.pbrt");
    std::fs::write(&path, text).expect("room for a scene");
    path.display().to_string()
}

/// What the image's file says of itself.
fn attributes(folder: &Folder) -> exr::prelude::LayerAttributes {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(folder.path("f.exr"))
        .expect("an EXR file");
    image.layer_data.attributes
}

/// What it says of its focus, m.
fn focus(folder: &Folder) -> f64 {
    f64::from(attributes(folder).focus.expect("the focus"))
}

fn render(folder: &Folder, scene: &str, options: &[&str]) -> Run {
    folder.render(scene, "f.exr", options)
}

#[test]
fn a_lens_is_focused_on_what_the_image_shows_there() {
    let folder = Folder::new();
    let camera = |focus: &str| {
        format!(
            "Camera \"realistic\" \"string lensfile\" \"{LENS}\" \"float aperturediameter\" 12 {focus}"
        )
    };
    for (asked, options, expected) in [
        ("\"float focuspoint\" [.25 .6]", &[][..], 2.0),
        ("\"float focuspoint\" [.75 .6]", &[], 1.2),
        // The command line wins.
        (
            "\"float focuspoint\" [.25 .6]",
            &["--focus-point", "0.75,0.6"],
            1.2,
        ),
        ("", &["--focus-point", "0.25,0.6"], 2.0),
        // More of the left; then two zones, of which the nearer counts.
        ("\"float autofocuszones\" [.2 .6 .6 .9]", &[], 2.0),
        (
            "\"float autofocuszones\" [.1 .3 .6 .9  .6 .9 .6 .9]",
            &[],
            1.2,
        ),
        // Zones that see nothing do not count.
        (
            "\"float autofocuszones\" [.1 .9 0 .1  .1 .4 .6 .9]",
            &[],
            2.0,
        ),
    ] {
        let scene = scene(&folder, &camera(asked), &cards(1.0));
        render(&folder, &scene, &[options, &["--strict"]].concat());
        let found = focus(&folder);
        // Rays in single precision.
        assert!(
            (found - expected).abs() < 1e-5,
            "{asked} {options:?}: {found}"
        );
    }
    // By real rays, as a distance is.
    let best = |asked: &str| {
        let camera = camera(&format!("\"string focus\" \"best\" {asked}"));
        let scene = scene(&folder, &camera, &cards(1.0));
        render(&folder, &scene, &["--strict"]);
        focus(&folder)
    };
    let found = best("\"float focuspoint\" [.25 .6]");
    let expected = best("\"float focusdistance\" 2");
    assert!((found - expected).abs() < 1e-5, "{found} {expected}");
    assert!((expected - 2.0).abs() > 1e-2, "{expected}");
}

/// As the course writes it: millimeters from the front vertex, only the film moves, and zones are in a file.
#[test]
fn the_courses_zones_move_the_film() {
    let folder = Folder::new();
    let zones = folder.path("zones.txt");
    std::fs::write(&zones, "# left right top bottom\n0.2 0.4 0.6 0.9\n").expect("room");
    let camera = format!(
        "Camera \"realistic\" \"string specfile\" \"{LENS}\" \"float filmdistance\" 36.77 \"float filmdiag\" 43.27 \
         \"float aperture_diameter\" 12 \"string af_zones\" \"{}\"",
        zones.display()
    );
    let scene = scene(&folder, &camera, &cards(1000.0));
    let run = render(&folder, &scene, &["--strict"]);
    // The card is 2 m from the front vertex, and the film some 70 mm behind that.
    let found = focus(&folder);
    let expected = "plane of focus 2.000 m in front of the lens";
    assert!(
        run.stderr.contains(expected) || run.stdout.contains(expected),
        "{}",
        run.stderr
    );
    assert!(found > 2.05 && found < 2.1, "{found}");
    for (text, problem) in [
        ("0.1 0.2 0.3", "is no zone"),
        ("0.2 0.1 0 1\n", "is no zone"),
        ("# none\n", "no zones"),
    ] {
        std::fs::write(&zones, text).expect("room");
        let run = fstop(["check", &scene]);
        assert!(
            run.code == 2 && run.stderr.contains(problem),
            "{}",
            run.stderr
        );
    }
}

#[test]
fn where_there_is_nothing_the_focus_stays_and_a_warning_says_so() {
    let folder = Folder::new();
    let camera = format!(
        "Camera \"realistic\" \"string lensfile\" \"{LENS}\" \"float focusdistance\" 3 \"float focuspoint\" [.5 .1]"
    );
    let scene = scene(&folder, &camera, &cards(1.0));
    let run = render(&folder, &scene, &[]);
    let message =
        "autofocus finds nothing in the point 0.5 0.1 of the image, and the focus is left as it is";
    assert!(
        run.stderr.contains(message) && run.stderr.contains("focuspoint"),
        "{}",
        run.stderr
    );
    assert!((focus(&folder) - 3.0).abs() < 1e-6);
    // What is too near says how near it may be.
    let near = cards(0.12);
    let camera = camera.replace("[.5 .1]", "[.75 .6]");
    let scene = self::scene(&folder, &camera, &near);
    let run = render(&folder, &scene, &[]);
    assert!(
        run.stderr.contains("autofocus on the point 0.75 0.6"),
        "{}",
        run.stderr
    );
    assert!(
        run.stderr.contains("the least distance from the film"),
        "{}",
        run.stderr
    );
    let run = fstop(["render", "x.pbrt", "--focus-point", "1.5,0"]);
    assert!(
        run.code == 2 && run.stderr.contains("0.5,0.4"),
        "{}",
        run.stderr
    );
}

/// Scheimpflug: stripes on the ground, 0.2 m below a lens wide open and focused at infinity, are sharp from near to far if the film leans back so
/// that the hinge, f/tan of the tilt below the axis, is on the ground; they are not otherwise.
#[test]
fn a_tilted_film_shows_the_ground_sharp() {
    let folder = Folder::new();
    let ground = "WorldBegin\nLightSource \"distant\" \"point from\" [0 1 0] \"point to\" [0 0 0]\n\
        Texture \"stripes\" \"color\" \"checkerboard\" \"float uscale\" 200 \"float vscale\" 0 \
        \"string aamode\" \"none\" \"color tex1\" [0 0 0] \"color tex2\" [1 1 1]\n\
        Material \"matte\" \"texture Kd\" \"stripes\"\n\
        Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [-1.5 -.2 .3  1.5 -.2 .3  1.5 -.2 30  -1.5 -.2 30] \
        \"float uv\" [0 0  1 0  1 1  0 1]\nWorldEnd\n";
    // f = 50.36 mm: the hinge is 200 mm off the axis.
    let degrees = (50.36f64 / 200.0).atan().to_degrees();
    let contrast = |tilt: f64| {
        let camera = format!(
            "Camera \"realistic\" \"string lensfile\" \"{LENS}\" \"float fnumber\" 2.4 \"float focusdistance\" 1e9 \"float tilt\" {tilt}"
        );
        let text = scene(&folder, &camera, ground);
        let scene_text = std::fs::read_to_string(&text).expect("the scene");
        let fine = scene_text.replace("[60]", "[180]").replace("[40]", "[120]");
        std::fs::write(&text, fine).expect("room");
        render(&folder, &text, &["--spp", "32", "--strict"]);
        let image = fstop::film::read(&folder.path("f.exr"))
            .expect("just written")
            .image;
        // Rows near the bottom, where the ground is 1 to 1.3 m away; their middle third.
        let rows = [95, 100, 105, 110];
        let of_row = |row: usize| {
            let line = &image.pixels[row * 180 + 60..row * 180 + 120];
            let values: Vec<f64> = line.iter().map(|p| f64::from(p.y)).collect();
            let mean = values.iter().sum::<f64>() / 60.0;
            let spread = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 60.0;
            spread.sqrt() / mean
        };
        rows.map(of_row).iter().sum::<f64>() / 4.0
    };
    let (sharp, flat, wrong) = (contrast(degrees), contrast(0.0), contrast(-degrees));
    println!("{sharp} {flat} {wrong}");
    // Black and white stripes of three pixels have a contrast near 1. On the flat film the blur is a disc three quarters of their period wide, of whose
    // contrast 0.4 is left (2 J1(πx)/(πx)), and less where pixels add to it; the film that leans forward has twice as wide a one.
    assert!(sharp > 0.7, "{sharp}");
    assert!(flat < 0.5 * sharp && wrong < 0.25 * sharp, "{flat} {wrong}");
}

/// A lens of two groups, whose first moves to focus: what is engraved on it is not what it has near by, and the image says both.
#[test]
fn the_image_and_its_file_say_what_the_camera_is_set_to() {
    let folder = Folder::new();
    let lens = folder.path("inner.dat");
    std::fs::write(
        &lens,
        "focus inf 0.5\ngap D 2 6\n60 4 1.5168 20\n-60 D 1 20\n0 2 0 8\n80 3 1.5168 20\n-80 40 1 20\n",
    )
    .expect("room for a lens");
    let camera = format!(
        "Camera \"realistic\" \"string lensfile\" \"{}\" \"float aperturediameter\" 6 \"float focusdistance\" .5",
        lens.display()
    );
    let run = render(&folder, &scene(&folder, &camera, &cards(1.0)), &[]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    for said in [
        "focal length ",
        ", effective f/",
        "T",
        "field of view ",
        "plane of focus ",
        "depth of field ",
        "hyperfocal distance ",
    ] {
        assert!(run.stderr.contains(said), "{said}: {}", run.stderr);
    }
    let attributes = attributes(&folder);
    use exr::meta::attribute::AttributeValue::{F32, FloatVec2};
    let number = |name: &str| match attributes.other.get(&exr::prelude::Text::from(name)) {
        Some(F32(x)) => f64::from(*x),
        other => panic!("{name} is {other:?}"),
    };
    let said = |before: &str| {
        let rest = run.stderr.split(before).nth(1).expect("it is said");
        let end = rest.find(|c: char| c != '.' && !c.is_ascii_digit());
        let said = &rest[..end.unwrap_or(rest.len())];
        said.parse::<f64>().expect("a number")
    };
    // Half the last digit that is said, and for the light half a percent of sampling (`effective_f_number`).
    assert!((number("effectiveFocalLength") - said("focal length ")).abs() < 6e-4);
    assert!((number("workingFNumber") / said("effective f/") - 1.0).abs() < 6e-3);
    assert!(number("nominalFocalLength") < number("effectiveFocalLength") - 0.5);
    let view = attributes
        .other
        .get(&exr::prelude::Text::from("fieldOfView"));
    let Some(FloatVec2(exr::prelude::Vec2(x, y))) = view else {
        panic!("{view:?}")
    };
    assert!((f64::from(*x) - said("field of view ")).abs() < 0.051);
    // Of 36 × 24 mm.
    let ratio = f64::from(*x).to_radians().tan() / f64::from(*y).to_radians().tan();
    assert!((1.4..1.8).contains(&ratio), "{ratio}");
}

/// The wall is 2 m away on the left, a card 1.2 m on the right, and a lamp behind the wall.
const NAMED: &str = "WorldBegin\nLightSource \"distant\" \"point from\" [0 0 -1] \"point to\" [0 0 1]\n\
    MakeNamedMaterial \"plaster\" \"string type\" \"matte\"\n\
    ObjectBegin \"card\"\nShape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [0 -1 0 2 -1 0 2 .1 0 0 .1 0]\nObjectEnd\n\
    ObjectBegin \"lamp\"\nShape \"sphere\" \"float radius\" .1\nObjectEnd\n\
    AttributeBegin\nTranslate 0 0 1.2\nObjectInstance \"card\"\nAttributeEnd\n\
    AttributeBegin\nTranslate -.3 -.3 3\nObjectInstance \"lamp\"\nAttributeEnd\n\
    NamedMaterial \"plaster\"\n\
    Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [-2 -1 2 0 -1 2 0 .1 2 -2 .1 2]\nWorldEnd\n";

#[test]
fn a_lens_is_focused_on_what_is_called_so() {
    let folder = Folder::new();
    let camera = |focus: &str| {
        format!(
            "Camera \"realistic\" \"string lensfile\" \"{LENS}\" \"float focusdistance\" 3 {focus}"
        )
    };
    // By the name of a material, an object, an instance and a shape.
    for (name, expected) in [
        ("plaster", 2.0),
        ("card", 1.2),
        ("card#1", 1.2),
        ("trianglemesh@23", 2.0),
    ] {
        let asked = camera(&format!("\"string focusobject\" \"{name}\""));
        let run = render(&folder, &scene(&folder, &asked, NAMED), &["--strict"]);
        assert_eq!(run.code, 0, "{}", run.stderr);
        let said = format!("focused on `{name}`");
        assert!(run.stderr.contains(&said), "{}", run.stderr);
        // As for a point: to what the view changes with the focus.
        let found = focus(&folder);
        assert!((found - expected).abs() < 1e-4, "{name}: {found}");
    }
    // The command line wins; the object over a point.
    let both = camera("\"string focusobject\" \"plaster\" \"float focuspoint\" [.75 .6]");
    let run = render(&folder, &scene(&folder, &both, NAMED), &[]);
    let warned = "focusobject is given too, and wins";
    assert!(run.stderr.contains(warned), "{}", run.stderr);
    assert!((focus(&folder) - 2.0).abs() < 1e-4);
    render(
        &folder,
        &scene(&folder, &both, NAMED),
        &["--focus-point", "0.75,0.6"],
    );
    assert!((focus(&folder) - 1.2).abs() < 1e-4);
}

#[test]
fn what_is_not_there_or_not_seen_is_said() {
    let folder = Folder::new();
    let camera = |name: &str| {
        format!(
            "Camera \"realistic\" \"string lensfile\" \"{LENS}\" \"float focusdistance\" 3 \"string focusobject\" \"{name}\""
        )
    };
    let run = render(&folder, &scene(&folder, &camera("lamp"), NAMED), &[]);
    let message = "autofocus does not find `lamp` in the image, and the focus is left as it is";
    assert!(
        run.code == 0 && run.stderr.contains(message) && run.stderr.contains("focusobject"),
        "{}",
        run.stderr
    );
    assert!((focus(&folder) - 3.0).abs() < 1e-6);
    let run = fstop(["render", &scene(&folder, &camera("crad"), NAMED)]);
    for said in [
        "no object, shape or material is called `crad`; there are card#1, lamp#1, trianglemesh@23, ",
        "did you mean `card`?",
    ] {
        assert!(run.code == 2 && run.stderr.contains(said), "{}", run.stderr);
    }
    let checked = fstop(["check", &folder.path("scene.pbrt").display().to_string()]);
    assert!(checked.code != 0 && checked.stderr.contains("`crad`"));
}

#[test]
fn the_camera_may_name_its_sensor_and_the_film_what_white_is() {
    let folder = Folder::new();
    let rendered = |film: &str, sensor: &str| {
        let text = format!(
            "Film \"image\" {film}\nSampler \"halton\" \"integer pixelsamples\" 1\nIntegrator \"directlighting\"\n\
             Camera \"realistic\" \"string lensfile\" \"{LENS}\" {sensor}\n{}",
            cards(1.0)
        );
        let path = folder.path("sensor.pbrt");
        std::fs::write(&path, text).expect("room for a scene");
        let out = folder.path("f.exr").display().to_string();
        let crop = "0.5,0.501,0.5,0.501";
        fstop([
            "render",
            &path.display().to_string(),
            "-o",
            &out,
            "--crop",
            crop,
        ])
    };
    let sensor = "\"string sensor\" \"aps-c-24\"";
    let run = rendered("\"float whiteluminance\" 4000", sensor);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("pixels of 3.9 um"), "{}", run.stderr);
    assert_eq!(attributes(&folder).white_luminance, Some(4000.0));
    // The film's own pixels, and its own sensor, if it is the same.
    let run = rendered(
        "\"integer xresolution\" 600 \"integer yresolution\" 400",
        sensor,
    );
    assert!(run.stderr.contains("pixels of 39.2 um"), "{}", run.stderr);
    assert_eq!(attributes(&folder).white_luminance, None);
    assert_eq!(rendered(sensor, sensor).code, 0);
    let run = rendered("\"string sensor\" \"phone-12\"", sensor);
    let message = "the film has the sensor \"phone-12\" and the camera \"aps-c-24\": leave one out";
    assert!(
        run.code == 2 && run.stderr.contains(message),
        "{}",
        run.stderr
    );
    let run = rendered("\"float whiteluminance\" -1", sensor);
    assert!(
        run.code == 2 && run.stderr.contains("whiteluminance"),
        "{}",
        run.stderr
    );
}
