//! `Material "fourier"` through the whole program: files made from formulas, against the materials
//! that have these formulas.

#[path = "../../src/assets/bsdf_file/generator.rs"]
mod generator;

use crate::common::rendering::{Render, explain};
use fstop::compare::{Options, compare};
use generator::{Analytic, encode};
use std::path::Path;

/// Chance that equal images fail; seeds are fixed, so that a pass is for good.
const ALPHA: f64 = 1e-4;

/// The file of `tests/scenes/valid/fourier.pbrt`: three channels, reflecting and transmitting.
const SMALL: &str = "tests/scenes/valid/parts/small.bsdf";

fn lambert(mu_i: f64, mu_o: f64, _: f64) -> [f64; 3] {
    if mu_i * mu_o < 0.0 {
        [0.7, 0.4, 0.2]
    } else {
        [0.0; 3]
    }
}

/// A ball of the material on a floor, below a sky and a light.
fn render(folder: &Path, name: &str, material: &str, seed: u32) -> Render {
    let scene = folder.join(name).with_extension("pbrt");
    let text = format!(
        "LookAt 0 3 -4  0 .8 0  0 1 0\nCamera \"perspective\" \"float fov\" [35]\n\
         Film \"image\" \"integer xresolution\" [32] \"integer yresolution\" [32]\n\
         Sampler \"random\" \"integer pixelsamples\" [64]\nIntegrator \"path\"\nWorldBegin\n\
         LightSource \"infinite\" \"rgb L\" [.5 .6 .7]\n\
         AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [9 8 7]\n\
         Translate 2 4 -1 Shape \"sphere\" \"float radius\" [.7] AttributeEnd\n\
         AttributeBegin Rotate -90 1 0 0 Shape \"disk\" \"float radius\" [9] AttributeEnd\n\
         {material}\nTranslate 0 1 0 Shape \"sphere\"\nWorldEnd\n"
    );
    std::fs::write(&scene, text).expect("room for a scene");
    Render::new(&scene, seed, 4, &[])
}

/// Lambert's law from a file of one channel and of three is `matte`.
#[test]
fn a_file_of_lamberts_law_renders_as_matte() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let matte = render(
        folder.path(),
        "matte",
        "Material \"matte\" \"rgb Kd\" [.7 .4 .2]",
        1,
    );
    // The luminance that the generator makes of (0.7, 0.4, 0.2): (0.4 + 0.0201826 + 0.2081625)/1.39829.
    let gray = "Material \"matte\" \"rgb Kd\" [.449367 .449367 .449367]";
    let gray = render(folder.path(), "gray", gray, 1);
    for (channels, seed, expected) in [(3, 11, &matte), (1, 21, &gray)] {
        let bytes = encode(&Analytic {
            eta: 1.0,
            channels,
            cosines: 64,
            terms: 1,
            value: &lambert,
        });
        std::fs::write(folder.path().join("lambert.bsdf"), bytes).expect("room for a file");
        let material = "Material \"fourier\" \"string bsdffile\" \"lambert.bsdf\"";
        let shown = render(folder.path(), "fourier", material, seed);
        let options = Options {
            alpha: ALPHA,
            ..Options::default()
        };
        let (a, b) = (shown.estimate(), expected.estimate());
        let comparison = compare(&a, &b, &options).expect("images of equal size");
        let agrees = comparison.verdict.agrees();
        assert!(
            agrees,
            "{}",
            explain("fourier", &a, &b, &options, &comparison)
        );
    }
}

/// The file in the project is what the generator writes, but for the last digits of cosines.
#[test]
fn the_small_file_is_the_generators() {
    let words = |bytes: &[u8]| -> Vec<f32> {
        let (words, _) = bytes[8..].as_chunks::<4>();
        words.iter().map(|word| f32::from_le_bytes(*word)).collect()
    };
    let kept = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join(SMALL)).expect("the file");
    let (kept, made) = (words(&kept), words(&small()));
    assert_eq!(kept.len(), made.len());
    for (a, b) in kept.iter().zip(&made) {
        // Integers read as floats are equal or tiny.
        assert!((a - b).abs() <= 1e-5 * b.abs().max(0.01), "{a} and {b}");
    }
}

/// Writes the file anew.
#[test]
#[ignore = "makes the file of a scene, once"]
fn write_the_small_file() {
    std::fs::write(Path::new(env!("CARGO_MANIFEST_DIR")).join(SMALL), small()).expect("room");
}

fn small() -> Vec<u8> {
    // Glossy on the side it comes from, diffuse on the other.
    let value = |mu_i: f64, mu_o: f64, phi: f64| {
        if mu_i * mu_o > 0.0 {
            return [0.3, 0.2, 0.1];
        }
        let across = ((1.0 - mu_i * mu_i) * (1.0 - mu_o * mu_o)).max(0.0).sqrt();
        let cos = (mu_i * mu_o).abs() + across * phi.cos();
        let gloss = 0.25 * 0.36 / (1.64 - 1.6 * cos).powf(1.5);
        [0.1 + gloss, 0.2 + gloss, 0.4 + gloss]
    };
    encode(&Analytic {
        eta: 1.0,
        channels: 3,
        cosines: 20,
        terms: 16,
        value: &value,
    })
}
