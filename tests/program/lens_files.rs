//! `fstop lens`: lenses written for other programs, and maps for compositing.

use crate::common::program::fstop;
use fstop::film::{self, Image};
use fstop::optics::analysis::Film;
use fstop::optics::{Lens, Prescription};
use std::path::Path;

const LENS: &str = "tests/golden/triplet_50.dat";

fn run(arguments: &[&str]) -> String {
    let run = fstop(arguments);
    assert_eq!(run.code, 0, "{arguments:?}: {}", run.stderr);
    run.stdout
}

#[test]
fn lenses_are_written_in_the_format_of_their_ending() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let described = run(&["lens", LENS]);
    for name in ["a.dat", "a.zmx", "a.json"] {
        run(&["lens", LENS, "-o", &file(name)]);
        assert_eq!(run(&["lens", &file(name)]), described, "{name}");
    }
    let wrong = fstop(["lens", LENS, "-o", &file("a.len")]);
    assert!(
        wrong.code == 2 && wrong.stderr.contains("written as .dat, .zmx or .json"),
        "{}",
        wrong.stderr
    );
    // A zoom at one of its positions, with the glass catalogue that its file needs.
    let zoom = file("zoom.dat");
    let glass = "sellmeier=1.03961212,0.231792344,1.01046945,0.00600069867,0.0200179144,103.560653";
    let text = format!(
        "zoom 50 80\ngap D 2 9\n60 4 1.5168000345005883 64.17 20 {glass}\n-60 D 1 0 20\n0 40 0 0 8\n"
    );
    std::fs::write(&zoom, text).expect("a file");
    let refused = fstop(["lens", &zoom, "-o", &file("zoom.zmx")]);
    assert!(
        refused.code == 2 && refused.stderr.contains("cannot say how groups move"),
        "{}",
        refused.stderr
    );
    let written = fstop(["lens", &zoom, "--zoom", "80", "-o", &file("zoom.zmx")]);
    assert!(
        written.code == 0 && written.stderr.contains("zoom.agf"),
        "{}",
        written.stderr
    );
    let back = Prescription::read(Path::new(&file("zoom.zmx"))).expect("a lens");
    assert_eq!(
        (back.surfaces[1].thickness, back.film_distance),
        (9.0, 40.0)
    );
    assert!(back.surfaces[0].dispersion.is_some());
}

#[test]
fn tables_have_the_rows_that_they_promise() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let [chief, rays, psf] = ["chief.csv", "rays.csv", "psf.exr"].map(file);
    run(&[
        "lens",
        LENS,
        "--chief-rays",
        &chief,
        "--rays",
        &rays,
        "--psf",
        &psf,
        "--depths",
        "1,inf",
    ]);
    let table = |name: &str| std::fs::read_to_string(name).expect("a table");
    let columns = |text: &str| {
        let mut lines = text.lines();
        let count = lines.next().expect("a head").split(',').count();
        let numbers = |line: &str| {
            let cells: Vec<f64> = line
                .split(',')
                .map(|c| c.parse().expect("a number"))
                .collect();
            assert_eq!(cells.len(), count, "{line}");
            cells
        };
        lines.map(numbers).collect::<Vec<_>>()
    };
    let chief = columns(&table(&chief));
    assert_eq!(chief.len(), 101);
    assert!(
        chief
            .windows(2)
            .all(|w| w[1][0] > w[0][0] && w[1][1] > w[0][1])
    );
    let rays = columns(&table(&rays));
    // Two depths, five fields, three colors, most of 32² rays each.
    assert!(rays.len() > 30 * 500, "{}", rays.len());
    let image = film::read(Path::new(&psf)).expect("an image").image;
    assert_eq!((image.resolution.x, image.resolution.y), (5 * 64, 2 * 64));
    let sum: f32 = image.pixels.iter().map(|p| p.x).sum();
    assert!((sum - 10.0).abs() < 1e-2, "{sum}");
    for (arguments, expected) in [
        (["--map-size", "0x5"], "WIDTHxHEIGHT"),
        (["--map-size", "99999x5"], "WIDTHxHEIGHT"),
        (["--depths", "-1"], "distance in meters"),
    ] {
        let wrong = fstop(["lens", LENS, arguments[0], arguments[1]]);
        assert!(
            wrong.code == 2 && wrong.stderr.contains(expected),
            "{}",
            wrong.stderr
        );
    }
}

/// Pixels of the pictures below.
const SIZE: [usize; 2] = [480, 320];
/// mm.
const DIAGONAL: f64 = 14.0;

/// A checkered wall so far away that the place of the pupil is no matter, through `camera`.
fn wall(camera: &str, folder: &Path, name: &str) -> Image {
    let output = folder.join(name);
    let [width, height] = SIZE;
    let scene = format!(
        "{camera}\nSampler \"halton\" \"integer pixelsamples\" 16\nIntegrator \"path\" \"integer maxdepth\" 1\nPixelFilter \"box\"\n\
         Film \"image\" \"integer xresolution\" {width} \"integer yresolution\" {height} \"float diagonal\" {DIAGONAL} \"string filename\" \"{}\"\n\
         WorldBegin\nLightSource \"infinite\" \"rgb L\" [1 1 1]\n\
         Texture \"checks\" \"spectrum\" \"checkerboard\" \"float uscale\" 30 \"float vscale\" 30 \"rgb tex1\" [.9 .9 .9] \"rgb tex2\" [.2 .2 .2]\n\
         Material \"matte\" \"texture Kd\" \"checks\"\n\
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [-30000 -30000 10000 30000 -30000 10000 30000 30000 10000 -30000 30000 10000] \"float uv\" [0 0 1 0 1 1 0 1]\n\
         WorldEnd\n",
        output.display()
    );
    let file = folder.join("scene.pbrt");
    std::fs::write(&file, scene).expect("a scene");
    run(&["render", &file.to_string_lossy(), "--quiet"]);
    film::read(&output).expect("an image").image
}

/// Between the middles of pixels linearly; `None` outside of them.
fn sample(image: &Image, [u, v]: [f32; 2]) -> Option<f32> {
    let [x, y] = [u * SIZE[0] as f32 - 0.5, (1.0 - v) * SIZE[1] as f32 - 0.5];
    let (i, j) = (x.floor(), y.floor());
    if i < 0.0 || j < 0.0 || i as usize + 1 >= SIZE[0] || j as usize + 1 >= SIZE[1] {
        return None;
    }
    let at = |i: usize, j: usize| image.pixels[j * SIZE[0] + i].x;
    let (i, j, s, t) = (i as usize, j as usize, x - i, y - j);
    let row = |j: usize| at(i, j) * (1.0 - s) + at(i + 1, j) * s;
    Some(row(j) * (1.0 - t) + row(j + 1) * t)
}

/// Mean difference of two pictures where the second one is known, relative to the mean of the first.
fn difference(a: &[f32], b: &[Option<f32>]) -> f64 {
    let known: Vec<(f64, f64)> = a
        .iter()
        .zip(b)
        .filter_map(|(a, b)| Some((f64::from(*a), f64::from((*b)?))))
        .collect();
    assert!(known.len() > a.len() / 2);
    let mean =
        |part: fn(&(f64, f64)) -> f64| known.iter().map(part).sum::<f64>() / known.len() as f64;
    let (of_a, of_b) = (mean(|p| p.0), mean(|p| p.1));
    known
        .iter()
        .map(|(a, b)| (a / of_a - b / of_b).abs())
        .sum::<f64>()
        / known.len() as f64
}

/// A fisheye's picture, and a pinhole's warped and darkened to it.
#[test]
fn maps_turn_a_pinholes_picture_into_the_lens() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let path = format!("{}/tests/golden/fisheye_10.dat", env!("CARGO_MANIFEST_DIR"));
    let mut prescription = Prescription::read(path.as_ref()).expect("a lens");
    prescription.set_stops(0.2);
    let distance = Lens::focused(&prescription, 1e7).expect("a focus");
    let lens = Lens::new(&prescription, distance).expect("a lens");
    let short = Film::of_diagonal(DIAGONAL).height;
    let fov = 2.0
        * (0.5 * short / lens.pinhole_focal_length().expect("a pinhole"))
            .atan()
            .to_degrees();
    let of_lens = wall(
        &format!(
            "Camera \"realistic\" \"string lensfile\" \"{path}\" \"float aperturediameter\" 0.2 \"float focusdistance\" 10000"
        ),
        folder,
        "lens.exr",
    );
    let of_pinhole = wall(
        &format!("Camera \"perspective\" \"float fov\" {fov}"),
        folder,
        "pinhole.exr",
    );
    let file = |name: &str| folder.join(name).to_string_lossy().into_owned();
    let [stmap, undistort, shading] = ["st.exr", "un.exr", "shade.exr"].map(file);
    let diagonal = DIAGONAL.to_string();
    run(&[
        "lens",
        &path,
        "--aperture",
        "0.2",
        "--focus",
        "10000",
        "--film-diagonal",
        &diagonal,
        "--map-size",
        "480x320",
        "--stmap",
        &stmap,
        "--undistort",
        &undistort,
        "--shading",
        &shading,
    ]);
    let map = |name: &str| film::read(Path::new(name)).expect("a map").image.pixels;
    let (forth, back, dark) = (map(&stmap), map(&undistort), map(&shading));
    let bright: Vec<f32> = of_lens
        .pixels
        .iter()
        .zip(&dark)
        .map(|(p, d)| p.x / d.x)
        .collect();
    let plain: Vec<Option<f32>> = of_pinhole.pixels.iter().map(|p| Some(p.x)).collect();
    let warped: Vec<Option<f32>> = forth
        .iter()
        .map(|st| sample(&of_pinhole, [st.x, st.y]))
        .collect();
    let (before, after) = (difference(&bright, &plain), difference(&bright, &warped));
    // What is left is at the edges of the checks: a twentieth of their pixels, half of their height.
    assert!(after < 0.1 * before && after < 0.03, "{before} {after}");
    // And the lens' picture back.
    let flat = Image {
        pixels: bright
            .iter()
            .map(|x| fstop::glam::Vec3::splat(*x))
            .collect(),
        ..of_lens.clone()
    };
    let unwarped: Vec<Option<f32>> = back.iter().map(|st| sample(&flat, [st.x, st.y])).collect();
    let pinhole: Vec<f32> = of_pinhole.pixels.iter().map(|p| p.x).collect();
    let after = difference(&pinhole, &unwarped);
    assert!(after < 0.1 * before && after < 0.03, "{before} {after}");
}
