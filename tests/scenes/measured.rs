//! pbrt-v2's `Material "measured"` through the whole program: files made from formulas, against `matte`.

#[path = "../../src/assets/merl_file/generator.rs"]
mod merl;

#[path = "../../src/assets/brdf_file/generator.rs"]
mod list;

use crate::common::rendering::{Render, explain};
use fstop::compare::{Options, compare};
use fstop::math::spectrum::rgb_from_samples;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// Chance that equal images fail; seeds are fixed, so that a pass is for good.
const ALPHA: f64 = 1e-4;

/// A ball of the material on a floor, below a sky and a light.
fn render(folder: &Path, name: &str, material: &str, seed: u32) -> Render {
    let scene = folder.join(name).with_extension("pbrt");
    let text = format!(
        "LookAt 0 3 -4  0 .8 0  0 1 0\nCamera \"perspective\" \"float fov\" [35]\n\
         Film \"image\" \"integer xresolution\" [32] \"integer yresolution\" [32]\n\
         Sampler \"random\" \"integer pixelsamples\" [64]\nSurfaceIntegrator \"path\"\nWorldBegin\n\
         LightSource \"infinite\" \"rgb L\" [.5 .6 .7]\n\
         AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [9 8 7]\n\
         Translate 2 4 -1 Shape \"sphere\" \"float radius\" [.7] AttributeEnd\n\
         AttributeBegin Rotate -90 1 0 0 Shape \"disk\" \"float radius\" [9] AttributeEnd\n\
         {material}\nTranslate 0 1 0 Shape \"sphere\"\nWorldEnd\n"
    );
    std::fs::write(&scene, text).expect("room for a scene");
    Render::new(&scene, seed, 4, &[])
}

/// Lambert's law in a file of either format is `matte`.
#[test]
fn files_of_lamberts_law_render_as_matte() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let table = merl::encode([9, 9, 18], &|_, _, _| [0.7, 0.4, 0.2].map(|kd| kd / PI));
    let spectrum = [(450.0, 0.2), (550.0, 0.4), (650.0, 0.7)];
    let samples = list::encode(&spectrum.map(|(nm, _)| nm), &list::pairs(6, 6), &|_| {
        spectrum.map(|(_, kd)| kd / PI).to_vec()
    });
    let files = [
        ("lambert.binary", table, [0.7, 0.4, 0.2]),
        (
            "lambert.brdf",
            samples.into_bytes(),
            rgb_from_samples(&spectrum).to_array(),
        ),
    ];
    for ((name, bytes, [r, g, b]), seed) in files.into_iter().zip([1, 11]) {
        std::fs::write(folder.path().join(name), bytes).expect("room for a file");
        let measured = format!("Material \"measured\" \"string filename\" \"{name}\"");
        let shown = render(folder.path(), "measured", &measured, seed);
        let matte = format!("Material \"matte\" \"rgb Kd\" [{r} {g} {b}]");
        let expected = render(folder.path(), "matte", &matte, seed + 20);
        let options = Options {
            alpha: ALPHA,
            ..Options::default()
        };
        let (a, b) = (shown.estimate(), expected.estimate());
        let comparison = compare(&a, &b, &options).expect("images of equal size");
        let agrees = comparison.verdict.agrees();
        assert!(agrees, "{}", explain(name, &a, &b, &options, &comparison));
    }
}

/// A highlight on a diffuse base, in small files of both formats for the scenes of the tests.
fn small() -> [(PathBuf, Vec<u8>); 2] {
    let shine = |theta_h: f64| 0.3 * theta_h.cos().powi(30);
    let table = merl::encode([10, 4, 6], &|h, _, _| {
        [0.3, 0.1, 0.05].map(|kd| kd / PI + shine(h))
    });
    let samples = list::encode(&[450.0, 650.0], &list::pairs(6, 5), &|[ti, pi, to, po]| {
        let (sines, turn) = (ti.sin() * to.sin(), (pi - po).cos());
        let cos_2d = sines * turn + ti.cos() * to.cos();
        let cos_h = (ti.cos() + to.cos()) / (2.0 + 2.0 * cos_2d).sqrt();
        // Three digits are enough, and keep the file small.
        let value =
            |kd: f64| (1e3 * (kd / PI + shine(cos_h.clamp(-1.0, 1.0).acos()))).round() / 1e3;
        vec![value(0.1), value(0.3)]
    });
    let parts = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/valid/parts");
    [
        (parts.join("paint.binary"), table),
        (parts.join("paint.brdf"), samples.into_bytes()),
    ]
}

/// The files in the project are as long as the generators', which write them with digits of this machine's sines.
#[test]
fn the_small_files_are_the_generators() {
    for (path, bytes) in small() {
        let kept = std::fs::read(&path).expect("the file").len() as f64;
        // Last digits may be more or fewer.
        assert!(
            (kept / bytes.len() as f64 - 1.0).abs() < 0.01,
            "{}",
            path.display()
        );
    }
}

/// Writes the files anew.
#[test]
#[ignore = "makes the files of a scene, once"]
fn write_the_small_files() {
    for (path, bytes) in small() {
        std::fs::write(path, bytes).expect("room");
    }
}
