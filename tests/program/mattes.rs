//! `--aov material,instance`: Cryptomattes, read as other programs do.

use super::cli::Folder;
use super::layers::{Channels, layers_of};
use crate::common::program::fstop;
use std::collections::BTreeMap;

const MATTES: [&str; 4] = ["--aov", "material,instance,alpha", "--spp", "64"];

/// What each thing of a matte covers, by its name: sums over pixels that `select` chooses.
fn covered(found: &Channels, matte: &str, select: impl Fn(usize) -> bool) -> BTreeMap<String, f32> {
    // The key of a matte is that of the attribute with its name.
    let named = |(name, value): (&String, &String)| {
        let key = name.strip_suffix("/name")?;
        (key.starts_with("cryptomatte/") && value == matte).then(|| key.to_string())
    };
    let key = found.texts.iter().find_map(named).expect("a matte");
    assert_eq!(found.texts[&format!("{key}/hash")], "MurmurHash3_32");
    assert_eq!(
        found.texts[&format!("{key}/conversion")],
        "uint32_to_float32"
    );
    let manifest = &found.texts[&format!("{key}/manifest")];
    let manifest: BTreeMap<String, String> = serde_json::from_str(manifest).expect("JSON");
    let covers = |number: u32| -> f32 {
        let mut sum = 0.0;
        for level in 0..3 {
            for pair in ["RG", "BA"] {
                let channel = |i: usize| found.get(&format!("{matte}{level:02}.{}", &pair[i..=i]));
                let both = channel(0).iter().zip(channel(1)).enumerate();
                let same = both.filter(|(at, (id, _))| id.to_bits() == number && select(*at));
                sum += same.map(|(_, (_, part))| part).sum::<f32>();
            }
        }
        sum
    };
    let number = |hex: &str| u32::from_str_radix(hex, 16).expect("a number");
    { manifest.into_iter() }
        .map(|(name, hex)| (name, covers(number(&hex))))
        .collect()
}

/// A wall of a named material over the left three eighths, one of an anonymous one over the last quarter, and an object twice, before and between.
const WALLS: &str = r#"
    Camera "orthographic" "float screenwindow" [0 8 0 8]
    Film "image" "integer xresolution" 8 "integer yresolution" 8
    Sampler "stratified" "integer xsamples" 8 "integer ysamples" 8
    PixelFilter "box" "float xwidth" 0.5 "float ywidth" 0.5
    WorldBegin
    LightSource "infinite"
    MakeNamedMaterial "gold" "string type" "metal"
    ObjectBegin "tile"
      Material "glass"
      Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [0 0 0  1 0 0  1 8 0  0 8 0]
    ObjectEnd
    NamedMaterial "gold"
    Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [0 0 5  3 0 5  3 8 5  0 8 5]
    Material "matte"
    Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [6 0 5  8 0 5  8 8 5  6 8 5]
    AttributeBegin Translate 0.5 0 2 ObjectInstance "tile" AttributeEnd
    AttributeBegin Translate 4 0 2 ObjectInstance "tile" AttributeEnd
    WorldEnd"#;

#[test]
fn parts_are_those_that_things_cover() {
    let found = layers_of(WALLS, &MATTES);
    let all = |matte: &str| covered(&found, matte, |_| true);
    let materials: Vec<_> = all("CryptoMaterial").into_iter().collect();
    let named = |list: &[(&str, f32)]| -> Vec<(String, f32)> {
        list.iter()
            .map(|(name, part)| (name.to_string(), *part))
            .collect()
    };
    // In pixels; eight columns of samples in each, so that all parts are exact.
    assert_eq!(
        materials,
        named(&[("glass@10", 16.0), ("gold", 16.0), ("matte@15", 16.0)])
    );
    let objects: Vec<_> = all("CryptoObject").into_iter().collect();
    let expected = [
        ("tile#1", 8.0),
        ("tile#2", 8.0),
        ("trianglemesh@14", 16.0),
        ("trianglemesh@16", 16.0),
    ];
    assert_eq!(objects, named(&expected));
    // In the pixel that both share.
    let shared = covered(&found, "CryptoObject", |at| at == 1);
    assert_eq!((shared["tile#1"], shared["trianglemesh@14"]), (0.5, 0.5));
    let alpha: f32 = found.get("A").iter().sum();
    assert_eq!(alpha, 48.0);
}

/// Through a filter with negative lobes the parts are those that alpha is made of.
#[test]
fn parts_are_filtered_as_alpha_is() {
    let scene = WALLS.replace(
        r#"PixelFilter "box" "float xwidth" 0.5 "float ywidth" 0.5"#,
        r#"PixelFilter "mitchell""#,
    );
    let found = layers_of(&scene, &MATTES);
    for matte in ["CryptoMaterial", "CryptoObject"] {
        for pixel in 0..64 {
            let parts: f32 = covered(&found, matte, |at| at == pixel).values().sum();
            let alpha = found.get("A")[pixel];
            // A thing of negative weight is not written: the filter's lobes are 1/13 of its middle.
            assert!(
                (parts - alpha).abs() < 0.08,
                "{matte} {pixel}: {parts} {alpha}"
            );
        }
    }
}

#[test]
fn what_moves_covers_as_much_as_what_rests() {
    let moving =
        "AttributeBegin ActiveTransform EndTime Translate 1 0 0 ActiveTransform All Translate 4";
    let scene = WALLS.replace("AttributeBegin Translate 4", moving);
    let found = layers_of(&scene, &MATTES);
    let column = |x: usize| covered(&found, "CryptoObject", |at| at % 8 == x)["tile#2"] / 8.0;
    // It is over the fourth column's place at first and then over the next one's. From 64 times in as many cells each.
    for (x, part) in [(3, 0.0), (4, 0.5), (5, 0.5), (6, 0.0)] {
        assert!((column(x) - part).abs() < 0.02, "{x}: {}", column(x));
    }
}

#[test]
fn a_shape_is_called_by_its_file() {
    let folder = Folder::new();
    let text = r#"Film "image" "integer xresolution" 2 "integer yresolution" 2 Camera "perspective"
        WorldBegin LightSource "infinite" Include "more.pbrt" Shape "plymesh" "string filename" "leaf.ply" WorldEnd"#;
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
               property list uchar int vertex_indices\nend_header\n-9 -9 5\n9 -9 5\n0 9 5\n3 0 1 2\n";
    for (name, text) in [
        ("scene.pbrt", text),
        ("leaf.ply", ply),
        ("more.pbrt", "\nShape \"sphere\""),
    ] {
        std::fs::write(folder.path(name), text).expect("a file");
    }
    let scene = folder.path("scene.pbrt").display().to_string();
    let output = folder.path("a.exr");
    let run = fstop([
        "render",
        &scene,
        "-o",
        &output.display().to_string(),
        "--aov",
        "instance",
    ]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let parts = covered(&Channels::of(&output), "CryptoObject", |_| true);
    let names: Vec<&str> = parts.keys().map(String::as_str).collect();
    // The camera stands in the ball.
    assert_eq!(names, ["leaf", "sphere@more.pbrt:2"]);
    assert_eq!(parts["sphere@more.pbrt:2"], 4.0);
}
