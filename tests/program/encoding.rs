//! `--half` and `--exposure`: how images are stored.

use super::cli::Folder;
use crate::common::program::fstop;
use exr::meta::MetaData;
use exr::meta::attribute::SampleType;
use fstop::film::read;
use std::path::Path;

/// A box with a mirror ball.
const BOX: &str = "tests/scenes/reference/int_cornell_path.pbrt";

/// The names of a file's channels that are half floats, and of the others.
fn channels(path: &Path) -> [Vec<String>; 2] {
    let meta = MetaData::read_from_file(path, false).expect("an EXR file");
    let list = &meta.headers[0].channels.list;
    [SampleType::F16, SampleType::F32].map(|kind| {
        let own = list.iter().filter(|channel| channel.sample_type == kind);
        own.map(|channel| channel.name.to_string()).collect()
    })
}

#[test]
fn half_floats_are_the_same_numbers_rounded() {
    let folder = Folder::new();
    let how = ["--spp", "4", "--variance", "--aov", "albedo,depth,alpha"];
    folder.render(BOX, "whole.exr", &how);
    folder.render(BOX, "half.exr", &[&how[..], &["--half"]].concat());
    let [halves, others] = channels(&folder.path("half.exr"));
    assert_eq!(halves.join(" "), "A B G R albedo.B albedo.G albedo.R");
    let variances = |name: &&String| name.contains("var.") || name.contains("independent.");
    assert_eq!(others.iter().filter(variances).count() + 1, others.len());
    assert!(others.contains(&"depth.Z".to_string()));
    let [whole, half] =
        ["whole.exr", "half.exr"].map(|name| read(&folder.path(name)).expect("an image").image);
    assert_eq!(whole.variance, half.variance);
    for (whole, half) in whole.pixels.iter().zip(&half.pixels) {
        // Half a unit in the last of 11 places; below 2^-14 they are 2^-24 apart.
        let error = (*whole - *half).abs();
        assert!(
            error.cmple(whole.abs() / 2048.0 + 2f32.powi(-25)).all(),
            "{whole} {half}"
        );
    }
    // Shards know nothing of it: their merge does.
    folder.render(BOX, "s.exr", &[&how[..], &["--shard", "1/1"]].concat());
    let shard = folder.path("s.shard-1-of-1.fsc").display().to_string();
    let merged = folder.path("merged.exr").display().to_string();
    let run = fstop(["merge", &shard, "-o", &merged, "--half", "--variance"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let bytes = |name: &str| std::fs::read(folder.path(name)).expect("a file");
    assert!(bytes("merged.exr") == bytes("half.exr"));
}

#[test]
fn colors_beyond_half_floats_are_clamped_and_said() {
    let folder = Folder::new();
    let scene = folder.path("scene.pbrt");
    let text = r#"Film "image" "integer xresolution" 3 "integer yresolution" 2
        Camera "perspective" WorldBegin LightSource "infinite" "rgb L" [1e6 1 1] WorldEnd"#;
    std::fs::write(&scene, text).expect("the scene");
    let run = folder.render(&scene.display().to_string(), "a.exr", &["--half"]);
    assert!(
        run.stderr.contains("6 pixels are brighter than 65504"),
        "{}",
        run.stderr
    );
    let image = read(&folder.path("a.exr")).expect("an image").image;
    assert!(
        image
            .pixels
            .iter()
            .all(|pixel| *pixel == [65504.0, 1.0, 1.0].into())
    );
}

#[test]
fn pictures_are_exposed_and_the_rest_is_not() {
    let folder = Folder::new();
    let scene = folder.path("scene.pbrt");
    let text = |light: f32| {
        format!(
            r#"Film "image" "integer xresolution" 3 "integer yresolution" 2
            Camera "perspective" WorldBegin LightSource "infinite" "rgb L" [{light} {light} {light}] WorldEnd"#
        )
    };
    let name = scene.display().to_string();
    let bytes = |name: &str| std::fs::read(folder.path(name)).expect("a file");
    let png = folder.path("a.png").display().to_string();
    let darker = folder.path("b.png").display().to_string();
    std::fs::write(&scene, text(0.5)).expect("the scene");
    folder.render(&name, "a.exr", &["--png", &png]);
    std::fs::write(&scene, text(2.0)).expect("the scene");
    folder.render(&name, "b.exr", &["--png", &darker, "--exposure", "-2"]);
    // Two stops less of four times the light.
    assert!(bytes("a.png") == bytes("b.png"));
    let image = read(&folder.path("b.exr")).expect("an image").image;
    assert!(image.pixels.iter().all(|pixel| *pixel == [2.0; 3].into()));
    let run = folder.render(&name, "c.exr", &["--exposure", "1"]);
    assert!(
        run.stderr.contains("--exposure has no effect"),
        "{}",
        run.stderr
    );
    let output = folder.path("c.exr").display().to_string();
    let run = fstop(["render", &name, "-o", &output, "--exposure", "bright"]);
    assert_eq!(run.code, 2);
}
