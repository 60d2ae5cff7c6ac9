//! The table of docs/features.md: every scene that it calls a proof exists and uses what it proves,
//! and no supported type is missing from it. That those scenes are rendered, and how well they
//! meet pbrt-v3's images, is for `tests/scenes/references.rs` and the corpus.

use fstop::cameras::CAMERA_NAMES;
use fstop::filters::FILTER_NAMES;
use fstop::lights::LightSpec;
use fstop::materials::Material;
use fstop::samplers::sampler_names;
use fstop::shapes::ShapeSpec;
use fstop::textures::FloatTextureSpec;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The cells of the table's rows.
fn rows() -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(root().join("docs/features.md")).expect("the features");
    let lines = text
        .lines()
        .skip_while(|l| !l.starts_with("| kind | feature |"));
    let rows = lines.skip(2).take_while(|l| l.starts_with('|'));
    let cells = |row: &str| {
        let cells = row.trim_matches('|').split(" | ");
        cells.map(|cell| cell.trim().to_string()).collect()
    };
    rows.map(cells).collect()
}

/// What stands between backticks.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

fn scene(proof: &str) -> PathBuf {
    let scenes = root().join("tests/scenes");
    let folder = match proof.contains('/') {
        true => scenes,
        false => scenes.join("reference"),
    };
    folder.join(proof).with_extension("pbrt")
}

#[test]
fn every_feature_has_a_scene_that_proves_it() {
    let rows = rows();
    assert!(rows.len() > 50, "{} rows", rows.len());
    for row in &rows {
        assert_eq!(row.len(), 5, "{row:?}");
        assert!(quoted(&row[4]).next().is_some(), "{row:?}");
        for proof in quoted(&row[4]) {
            assert!(scene(proof).exists(), "{row:?}: no scene {proof}");
        }
    }
}

/// The scene that is said to prove a type uses it.
#[test]
fn the_scenes_use_what_they_prove() {
    for row in rows() {
        let directive = match row[0].as_str() {
            "camera" => "Camera",
            "filter" => "PixelFilter",
            "integrator" => "Integrator",
            "material" => "aterial",
            "medium" => "MakeNamedMedium",
            "sampler" => "Sampler",
            "shape" => "Shape",
            "light" => "Light",
            "texture" => "Texture",
            _ => continue,
        };
        let texts = quoted(&row[4]).map(|proof| {
            std::fs::read_to_string(scene(proof)).unwrap_or_else(|e| panic!("{proof}: {e}"))
        });
        let text: String = texts.collect();
        let is_type = |n: &&str| n.chars().all(|c| c.is_lowercase() || c.is_ascii_digit());
        for name in quoted(&row[1]).filter(is_type) {
            let used = text
                .lines()
                .any(|line| line.contains(directive) && line.contains(&format!("\"{name}\"")));
            assert!(used || name == "none", "{row:?}: `{name}` is not there");
        }
    }
}

#[test]
fn every_type_and_every_reference_is_in_the_table() {
    let rows = rows();
    let named: BTreeSet<&str> = rows.iter().flat_map(|row| quoted(&row[1])).collect();
    let scattering = Material::KINDS.iter().chain(&fstop::media::KINDS);
    let samplers = sampler_names();
    let sampling = samplers.iter().chain(FILTER_NAMES);
    let seeing = CAMERA_NAMES.iter().chain(fstop::integrators::NAMES);
    let scenery = ShapeSpec::KINDS.iter().chain(LightSpec::KINDS);
    let scenery = scenery.chain(FloatTextureSpec::KINDS);
    // pbrt-v2's `metropolis` is a renderer, known as a misspelling only.
    let kinds = scattering.chain(sampling).chain(seeing).chain(scenery);
    for kind in kinds.filter(|kind| **kind != "metropolis") {
        assert!(named.contains(kind), "`{kind}` is not in docs/features.md");
    }
}
