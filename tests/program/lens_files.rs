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
    let all = fstop(["lens", &zoom, "-o", &file("zoom.zmx")]);
    assert_eq!(all.code, 0, "{}", all.stderr);
    let read = Prescription::read(Path::new(&file("zoom.zmx"))).expect("a lens");
    assert_eq!(read.positions.expect("a zoom").zooms(), [50.0, 80.0]);
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
    // Formats that have positions write the requested one alone, and all of them where none is requested.
    for name in ["still.dat", "still.json"] {
        let at = ["--zoom", "80", "--focus", "2"];
        run(&[&["lens", &zoom], &at[..], &["-o", &file(name)]].concat());
        let back = Prescription::read(Path::new(&file(name))).expect("a lens");
        assert!(
            back.positions.is_none() && back.surfaces[1].thickness == 9.0,
            "{name}"
        );
        let described = |path: &str, more: &[&str]| run(&[&["lens", path], more].concat());
        assert_eq!(described(&file(name), &[]), described(&zoom, &at), "{name}");
        run(&["lens", &zoom, "-o", &file(name)]);
        let back = Prescription::read(Path::new(&file(name))).expect("a lens");
        assert_eq!(
            back.positions.expect("a zoom").zooms(),
            [50.0, 80.0],
            "{name}"
        );
    }
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

/// 24 million pixels, of 36 × 24 mm.
const FULL: [f64; 2] = [6000.0, 4000.0];

/// Side of the windows of them that are rendered.
const WINDOW: u32 = 64;

/// `side` pixels each way from `corner` on of a checkered wall 10 km away, in checks of some 8 pixels, as `camera` sees it.
fn window(camera: &str, folder: &Path, corner: [f64; 2], side: u32) -> Image {
    let output = folder.join("window.exr");
    // Half a pixel less is rounded up to a whole one.
    let ends =
        [0, 1].map(|i| [corner[i], corner[i] + f64::from(side)].map(|x| (x - 0.5) / FULL[i]));
    let [[left, right], [top, bottom]] = ends;
    let scene = format!(
        "{camera}\nSampler \"halton\" \"integer pixelsamples\" 64\nIntegrator \"path\" \"integer maxdepth\" 1\nPixelFilter \"box\"\n\
         Film \"image\" \"integer xresolution\" 6000 \"integer yresolution\" 4000 \"float diagonal\" 43.26661530556787 \
         \"float cropwindow\" [{left} {right} {top} {bottom}] \"string filename\" \"{}\"\n\
         WorldBegin\nLightSource \"infinite\" \"rgb L\" [1 1 1]\n\
         Texture \"checks\" \"spectrum\" \"checkerboard\" \"float uscale\" 1000 \"float vscale\" 1000 \"string aamode\" \"none\" \
         \"rgb tex1\" [.9 .9 .9] \"rgb tex2\" [.2 .2 .2]\n\
         Material \"matte\" \"texture Kd\" \"checks\"\nRotate 10 0 0 1\n\
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [-5000 -5000 10000 5000 -5000 10000 5000 5000 10000 -5000 5000 10000] \"float uv\" [0 0 1 0 1 1 0 1]\n\
         WorldEnd\n",
        output.display()
    );
    let file = folder.join("window.pbrt");
    std::fs::write(&file, scene).expect("a scene");
    run(&["render", &file.to_string_lossy(), "--quiet"]);
    let image = film::read(&output).expect("an image").image;
    assert_eq!(image.pixels.len(), (side * side) as usize);
    image
}

/// Between four of a grid's values linearly; `at(i, j)` is the value at the middle of cell (i, j).
fn bilinear([x, y]: [f64; 2], at: impl Fn(usize, usize) -> f64) -> f64 {
    let (i, j) = (x.floor(), y.floor());
    let (s, t) = (x - i, y - j);
    let (i, j) = (i as usize, j as usize);
    let row = |j: usize| at(i, j) * (1.0 - s) + at(i + 1, j) * s;
    row(j) * (1.0 - t) + row(j + 1) * t
}

/// Times that pictures are blurred by 1 2 1 in x and y: sampling of sharp edges, which is not the same in both, counts less then.
const BLURS: usize = 4;

/// A square of `side` pixels, blurred; a pixel is lost at each side each time.
fn blurred(mut image: Vec<f64>, mut side: usize) -> Vec<f64> {
    for _ in 0..BLURS {
        let inner = side - 2;
        let at = |i: usize, j: usize| image[j * side + i];
        let row = |i: usize, j: usize| at(i, j) + 2.0 * at(i + 1, j) + at(i + 2, j);
        let all = (0..inner * inner).map(|k| (k % inner, k / inner));
        let next = all.map(|(i, j)| (row(i, j) + 2.0 * row(i, j + 1) + row(i, j + 2)) / 16.0);
        image = next.collect();
        side = inner;
    }
    image
}

/// How far `moved` is to be moved, in pixels, to lie on `fixed`: least squares of brightness, gain, offset and the gradient
/// (B. Lucas and T. Kanade, "An iterative image registration technique", IJCAI 1981). Squares of `side` pixels.
fn shift(fixed: &[f64], moved: &[f64], side: usize) -> [f64; 2] {
    let mut system = [[0.0; 5]; 4];
    for j in 1..side - 1 {
        for i in 1..side - 1 {
            let at = |i: usize, j: usize| moved[j * side + i];
            let across = 0.5 * (at(i + 1, j) - at(i - 1, j));
            let along = 0.5 * (at(i, j + 1) - at(i, j - 1));
            // A picture that is moved to the right has what was to the left.
            let row = [-across, -along, at(i, j), 1.0, fixed[j * side + i]];
            for k in 0..4 {
                for (sum, x) in system[k].iter_mut().zip(row) {
                    *sum += row[k] * x;
                }
            }
        }
    }
    // Gauss and Jordan; a matrix of squares needs no other pivots.
    for k in 0..4 {
        let pivot = system[k].map(|x| x / system[k][k]);
        for (j, row) in system.iter_mut().enumerate() {
            let factor = if j == k { 0.0 } else { row[k] };
            for (x, p) in row.iter_mut().zip(pivot) {
                *x -= factor * p;
            }
        }
        system[k] = pivot;
    }
    // Gradients are of what has not been brightened yet.
    [0, 1].map(|k| system[k][4] / system[2][4])
}

/// What docs/lens-files.md promises: a pinhole's picture, warped by the map, lies on the lens' picture to 0.02 of 24 million pixels.
#[test]
fn a_warped_picture_lies_on_the_lens_to_a_fiftieth_of_a_pixel() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let path = format!("{}/tests/golden/dgauss_50.dat", env!("CARGO_MANIFEST_DIR"));
    let mut prescription = Prescription::read(path.as_ref()).expect("a lens");
    prescription.set_stops(0.2);
    let distance = Lens::focused(&prescription, 1e7).expect("a focus");
    let lens = Lens::new(&prescription, distance).expect("a lens");
    let f = lens.pinhole_focal_length().expect("a pinhole");
    // Of 10 km the way from film to entrance pupil is as much as 0.02 pixels of the picture's corner.
    let pupil = lens.paraxial().entrance_pupil.expect("a pupil").z;
    let of_pinhole = format!(
        "Translate 0 0 {}\nCamera \"perspective\" \"float fov\" {}",
        -1e-3 * (lens.film_z() - pupil),
        2.0 * (12.0 / f).atan().to_degrees()
    );
    let of_lens = format!(
        "Camera \"realistic\" \"string lensfile\" \"{path}\" \"float aperturediameter\" 0.2 \"float focusdistance\" 10000 \"string precision\" \"double\""
    );
    // A tenth of the pixels each way: of distortion that grows by the square to 1.7 %, straight lines between them are within
    // 0.017 × 6 / 3606 × 10² / 8 = 4e-4 of a pixel.
    const MAP: [usize; 2] = [600, 400];
    let stmap = folder.join("st.exr").to_string_lossy().into_owned();
    run(&[
        "lens",
        &path,
        "--aperture",
        "0.2",
        "--focus",
        "10000",
        "--film-diagonal",
        "43.26661530556787",
        "--map-size",
        "600x400",
        "--stmap",
        &stmap,
    ]);
    let map = film::read(Path::new(&stmap)).expect("a map").image.pixels;
    // Pixels from the upper left corner of the pinhole's picture, for those of the lens'.
    let source = |p: [f64; 2]| {
        let place = [0, 1].map(|i| (p[i] + 0.5) * MAP[i] as f64 / FULL[i] - 0.5);
        let of = |pick: fn(&fstop::glam::Vec3) -> f32| {
            bilinear(place, |i, j| f64::from(pick(&map[j * MAP[0] + i])))
        };
        [
            of(|st| st.x) * FULL[0] - 0.5,
            (1.0 - of(|st| st.y)) * FULL[1] - 0.5,
        ]
    };
    let side = WINDOW as usize;
    for field in [0.0, 0.5, 0.9] {
        // Along the diagonal, away from the axes of the checks.
        let corner = [0, 1].map(|i| (0.5 * FULL[i] * (1.0 + field)).floor() - 0.5 * side as f64);
        let fixed = window(&of_lens, folder, corner, WINDOW);
        let fixed = fixed.pixels.iter().map(|p| f64::from(p.x)).collect();
        let fixed = blurred(fixed, side);
        // With a margin for what is magnified.
        let margin = 8.0;
        let from = source(corner).map(|x| (x - margin).floor());
        let wide = WINDOW + 2 * margin as u32;
        let pinhole = window(&of_pinhole, folder, from, wide);
        let warped = |by: f64| -> Vec<f64> {
            let all = (0..side * side).map(|k| {
                let [x, y] = source([0, 1].map(|i| corner[i] + [k % side, k / side][i] as f64));
                let at = |i: usize, j: usize| f64::from(pinhole.pixels[j * wide as usize + i].x);
                bilinear([x + by - from[0], y - from[1]], at)
            });
            blurred(all.collect(), side)
        };
        let inner = side - 2 * BLURS;
        let [x, y] = shift(&fixed, &warped(0.0), inner);
        println!("field {field}: {x:.4} {y:.4} pixels");
        assert!(x.hypot(y) <= 0.02, "{field}: {x} {y}");
        // And a tenth of a pixel is found: what is sampled farther right lies farther left.
        let [moved, _] = shift(&fixed, &warped(0.1), inner);
        assert!((moved - x - 0.1).abs() < 0.02, "{field}: {moved}");
    }
}
