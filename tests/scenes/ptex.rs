//! `Texture "ptex"` through the whole program: meshes that say which face each triangle is of.

use crate::common::program::{Run, fstop_in};
use fstop::math::{Rgb, UVec2};
use std::path::Path;

/// Four squares of a color each, in an eight-bit file with alpha.
const SQUARES: &str = "tests/scenes/valid/textures/squares.ptx";

/// Six triangles of a gray each, in half floats.
const TRIANGLES: &str = "tests/scenes/valid/textures/triangles.ptx";

/// Pixels along a side of the image, which shows [-1, 1]².
const SIDE: u32 = 32;

/// What the image of a scene file's world says: what the program printed, and the image.
fn render(world: &str, more: &[&str]) -> (Run, Option<fstop::film::Image>) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for file in [SQUARES, TRIANGLES] {
        let from = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
        let name = from.file_name().expect("a name");
        std::fs::copy(&from, folder.path().join(name)).expect("a copy");
    }
    let text = format!(
        "LookAt 0 0 -1  0 0 0  0 1 0\nCamera \"orthographic\"\n\
         Film \"image\" \"integer xresolution\" {SIDE} \"integer yresolution\" {SIDE}\n\
         Sampler \"random\" \"integer pixelsamples\" [64]\n\
         Integrator \"path\" \"integer maxdepth\" 1\nWorldBegin\n\
         LightSource \"infinite\"\n{world}\nWorldEnd\n"
    );
    std::fs::write(folder.path().join("s.pbrt"), text).expect("room for a scene");
    let arguments = ["render", "s.pbrt", "-o", "a.exr", "--quiet"];
    let run = fstop_in(folder.path(), arguments.iter().chain(more));
    let image = fstop::film::read(&folder.path().join("a.exr")).ok();
    (run, image.map(|loaded| loaded.image))
}

/// The mean color of 6 × 6 pixels around a place in [-1, 1]².
///
/// A plane under a white sky shows its albedo. 36 · 64 samples of an estimate whose standard deviation is
/// no larger than the albedo leave 0.02 of it.
fn color(image: &fstop::film::Image, x: f32, y: f32) -> Rgb {
    let pixel = |x: f32| ((x + 1.0) / 2.0 * SIDE as f32) as u32;
    let middle = UVec2::new(pixel(x), SIDE - pixel(y));
    let around = (0..36).map(|i| middle + UVec2::new(i % 6, i / 6) - 3);
    let sum: Rgb = around
        .map(|p| image.pixels[(p.y * SIDE + p.x) as usize])
        .sum();
    sum / 36.0
}

/// Squares in the four quadrants, which are faces of these numbers.
fn squares(faces: &str, texture: &str) -> String {
    let mut points = String::new();
    let mut uv = String::new();
    let mut indices = String::new();
    for quadrant in 0..4 {
        let (x, y) = (quadrant % 2 - 1, quadrant / 2 - 1);
        for (dx, dy) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
            points += &format!("{} {} 0 ", x + dx, y + dy);
            uv += &format!("{dx} {dy} ");
        }
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| 4 * quadrant + i);
        indices += &format!("{a} {b} {c} {d} {a} {c} ");
    }
    format!(
        "Texture \"t\" \"spectrum\" \"ptex\" {texture}\n\
         Material \"matte\" \"texture Kd\" \"t\"\n\
         Shape \"trianglemesh\" \"integer indices\" [{indices}] \"point P\" [{points}] \
         \"float uv\" [{uv}] {faces}"
    )
}

const MIDDLES: [(f32, f32); 4] = [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)];

/// As the file has them, in steps of 1/255.
const COLORS: [[u8; 3]; 4] = [[204, 51, 26], [51, 179, 77], [77, 77, 230], [230, 204, 51]];

fn assert_shows(found: Rgb, expected: Rgb) {
    // Three standard deviations of the noise.
    let off = (found - expected).abs() - 0.06 * expected;
    assert!(off.max_element() < 1e-3, "{found}, not {expected}");
}

#[test]
fn triangles_show_the_faces_that_the_mesh_names() {
    let faces = [2, 0, 3, 1];
    let ids = "\"integer faceIndices\" [2 2 0 0 3 3 1 1]";
    for (gamma, text) in [(2.2f32, ""), (1.0, "\"float gamma\" 1")] {
        let texture = format!("\"string filename\" \"squares.ptx\" {text}");
        let (run, image) = render(&squares(ids, &texture), &[]);
        assert_eq!((run.code, run.stderr.as_str()), (0, ""));
        let image = image.expect("an image");
        for ((x, y), face) in MIDDLES.into_iter().zip(faces) {
            let expected = COLORS[face].map(|v| (f32::from(v) / 255.0).powf(gamma));
            assert_shows(color(&image, x, y), expected.into());
        }
    }
}

#[test]
fn without_numbers_all_is_of_the_first_face_and_beyond_the_last_one_black() {
    let texture = "\"string filename\" \"squares.ptx\" \"float gamma\" 1";
    let (_, image) = render(&squares("", texture), &[]);
    let first = Rgb::from(COLORS[0].map(|v| f32::from(v) / 255.0));
    let image = image.expect("an image");
    for (x, y) in MIDDLES {
        assert_shows(color(&image, x, y), first);
    }
    let ids = "\"integer faceIndices\" [0 0 4 4 -1 -1 2000000000 2000000000]";
    let (run, image) = render(&squares(ids, texture), &[]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let image = image.expect("an image");
    assert_shows(color(&image, -0.5, -0.5), first);
    for (x, y) in &MIDDLES[1..] {
        assert_eq!(color(&image, *x, *y), Rgb::ZERO);
    }
}

#[test]
fn instances_and_cut_outs_know_their_faces() {
    // The object's mesh is not its first, and it stands elsewhere. Face 2 of the triangles is 0: a hole, in
    // which the white sky is seen.
    let ids = "\"integer faceIndices\" [2 2 0 0 3 3 1 1] \"texture alpha\" \"hole\"";
    let texture = "\"string filename\" \"squares.ptx\" \"float gamma\" 1";
    let hole = "Texture \"hole\" \"float\" \"ptex\" \"string filename\" \"triangles.ptx\"\n";
    let mesh = squares(ids, texture);
    // Turned upside down, so that the quadrants change places.
    let world = format!(
        "{hole}ObjectBegin \"o\"\nMaterial \"matte\" \"rgb Kd\" [1 0 0]\nTranslate 0 0 5\n\
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 1 2] \"point P\" [8 8 0 9 8 0 9 9 0]\n\
         Translate 0 0 -5\n{mesh}\nObjectEnd\nRotate 180 0 0 1\nObjectInstance \"o\""
    );
    let (run, image) = render(&world, &[]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let image = image.expect("an image");
    for ((x, y), face) in MIDDLES.into_iter().zip([1, 3, 0, 2]) {
        let expected = match face {
            2 => Rgb::ONE,
            _ => Rgb::from(COLORS[face].map(|v| f32::from(v) / 255.0)),
        };
        assert_shows(color(&image, x, y), expected);
    }
}

#[test]
fn a_file_that_cannot_be_used_is_black() {
    let ids = "\"integer faceIndices\" [2 2 0 0 3 3 1 1]";
    for (name, words) in [
        ("nowhere.ptx", "there is no such file"),
        ("s.pbrt", "cannot decode 's.pbrt': it is not a Ptex file"),
    ] {
        let world = squares(ids, &format!("\"string filename\" \"{name}\""));
        let (run, _) = render(&world, &[]);
        assert_eq!(run.code, 2);
        assert!(run.stderr.contains(words), "{}", run.stderr);
        let place = "Texture \"t\" \"spectrum\" \"ptex\" \"string filename\"";
        assert!(run.stderr.contains(place), "{}", run.stderr);
        let (run, image) = render(&world, &["--keep-going"]);
        assert_eq!(run.code, 1, "{}", run.stderr);
        let image = image.expect("an image");
        assert!(image.pixels.iter().all(|p| *p == Rgb::ZERO));
    }
}
