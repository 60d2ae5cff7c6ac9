//! The README's table of features: every scene that it calls a proof exists, and no type that is
//! modelled, no reference, is missing from it.

use fstop::materials::Material;
use fstop::shapes::ShapeSpec;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The cells of the table's rows.
fn rows() -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(root().join("README.md")).expect("the README");
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
            "material" => "aterial",
            "shape" => "Shape",
            "light" => "Light",
            "texture" => "Texture",
            _ => continue,
        };
        let texts = quoted(&row[4]).map(|proof| {
            std::fs::read_to_string(scene(proof)).unwrap_or_else(|e| panic!("{proof}: {e}"))
        });
        let text: String = texts.collect();
        for name in quoted(&row[1]).filter(|n| n.chars().all(|c| c.is_lowercase())) {
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
    for kind in Material::KINDS.iter().chain(&ShapeSpec::KINDS) {
        assert!(named.contains(kind), "`{kind}` is not in the README");
    }
}
