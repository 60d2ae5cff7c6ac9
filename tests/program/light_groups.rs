//! `--aov lights`: the picture by groups of its lights.

use super::cli::Folder;
use super::layers::{Channels, layers_of};
use crate::common::program::fstop;

/// A ground, a ball of glass and a mirror under lights of two groups and of none; `more` is in the world, too.
fn scene(integrator: &str, more: &str) -> String {
    format!(
        r#"
        LookAt 0 2 -6  0 0.5 0  0 1 0
        Camera "perspective" "float fov" 40
        Film "image" "integer xresolution" 24 "integer yresolution" 24 "float maxsampleluminance" 20
        Sampler "halton" "integer pixelsamples" 16
        Integrator "{integrator}"
        WorldBegin
        {LIGHTS}
        {more}
        Material "matte" "rgb Kd" [0.5 0.4 0.3]
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-9 0 -9  9 0 -9  9 0 9  -9 0 9]
        Material "glass"
        AttributeBegin Translate 0 1 0 Shape "sphere" "float radius" 0.8 AttributeEnd
        Material "mirror"
        AttributeBegin Translate 2 1 1 Shape "sphere" "float radius" 0.8 AttributeEnd
        WorldEnd"#
    )
}

const LIGHTS: &str = r#"LightSource "point" "point from" [-2 4 -2] "rgb I" [9 6 3] "string group" "key"
        LightSource "infinite" "rgb L" [0.1 0.2 0.4] "string group" "sky"
        LightSource "distant" "point from" [3 4 -2] "rgb L" [0.5 0.5 0.5]
        AttributeBegin
          AreaLightSource "diffuse" "rgb L" [4 4 4] "string group" "key"
          Translate -1 3 1 Shape "sphere" "float radius" 0.3
        AttributeEnd"#;

const AOV: [&str; 2] = ["--aov", "lights"];

/// Whether the layers of light add up to the picture, each channel and pixel, but for single precision of a path's sum: some twenty terms.
fn add_up(found: &Channels, context: &str) {
    for channel in ["R", "G", "B"] {
        let layer = |name: &str| found.get(&format!("light_{name}.{channel}"));
        let parts = [layer("rest"), layer("key"), layer("sky")];
        for (pixel, whole) in found.get(channel).iter().enumerate() {
            let sum: f32 = parts.iter().map(|part| part[pixel]).sum();
            assert!(
                (sum - whole).abs() <= 1e-5 * whole.abs().max(1e-3),
                "{context}: {channel} of pixel {pixel} is {whole}, not {sum}"
            );
        }
    }
}

fn mean(found: &Channels, channel: &str) -> f64 {
    let values = found.get(channel);
    values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64
}

#[test]
fn layers_add_up_to_the_picture() {
    let fog = r#"MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [0.05 0.05 0.05] "rgb sigma_s" [0.1 0.1 0.1]
        AttributeBegin MediumInterface "fog" "" Material "" Translate -1 1 -2 Shape "sphere" AttributeEnd"#;
    let below = r#"AttributeBegin Material "kdsubsurface" Translate -2 0.6 0 Shape "sphere" "float radius" 0.6 AttributeEnd"#;
    for (integrator, more) in [
        ("path", ""),
        ("path", below),
        ("volpath", fog),
        ("bdpt", ""),
        ("bdpt", fog),
        ("directlighting", ""),
        ("whitted", ""),
        ("ambientocclusion", ""),
    ] {
        let text = scene(integrator, more);
        // Of 15 samples one half has one more.
        for goal in [
            &["--spp", "5"][..],
            &["--spp", "8", "--variance"],
            &["--spp", "15", "--variance"],
        ] {
            let found = layers_of(&text, &[&AOV, goal].concat());
            add_up(&found, &format!("{integrator} {more} {goal:?}"));
            let lit = |name: &str| mean(&found, &format!("light_{name}.G")) > 1e-3;
            let expected = integrator != "ambientocclusion";
            assert_eq!(
                [lit("key"), lit("sky"), lit("rest")],
                [expected, expected, true]
            );
        }
    }
}

/// A filter with negative lobes may make light negative, but not where colors are.
#[test]
fn layers_add_up_through_negative_lobes() {
    let dark = scene("path", "").replace("[0.1 0.2 0.4]", "[1 1 1]");
    let text = dark.replace("Film", "PixelFilter \"sinc\" Film");
    add_up(
        &layers_of(&text, &[&AOV[..], &["--spp", "64"]].concat()),
        "sinc",
    );
}

#[test]
fn a_name_may_be_in_any_script() {
    let folder = Folder::new();
    let path = folder.path("scene.pbrt");
    for name in ["ключ", "主光", "schlüssel"] {
        let text = scene("path", "").replace("\"sky\"", &format!("\"{name}\""));
        std::fs::write(&path, text).expect("the scene");
        let scene = path.display().to_string();
        folder.render(&scene, "a.exr", &[&AOV[..], &["--spp", "1"]].concat());
        let bytes = std::fs::read(folder.path("a.exr")).expect("a file");
        let channel = format!("light_{name}.R\0");
        assert!(
            bytes
                .windows(channel.len())
                .any(|at| at == channel.as_bytes()),
            "{name}"
        );
    }
}

/// The layer of a group is the picture by its lights alone.
#[test]
fn a_layer_is_the_picture_without_the_other_lights() {
    for integrator in ["path", "bdpt", "directlighting"] {
        let text = scene(integrator, "");
        let spp = ["--spp", "256"];
        let found = layers_of(&text, &[&AOV[..], &spp].concat());
        let others = |line: &str| line.contains("\"sky\"") || line.contains("\"distant\"");
        let alone: Vec<&str> = text.lines().filter(|line| !others(line)).collect();
        let alone = layers_of(&alone.join("\n"), &spp);
        let mean = |found: &Channels, name: &str| mean(found, name);
        let off = mean(&found, "light_key.G") / mean(&alone, "G") - 1.0;
        // 576 pixels of 256 samples each, whose scatter is their mean; other light is chosen half the time. Caustics of `path` are not there.
        assert!(off.abs() < 0.02, "{integrator}: {off}");
    }
}

#[test]
fn a_path_that_is_helped_from_the_lights_keeps_them_apart() {
    let folder = Folder::new();
    // A lamp so small that camera paths hardly meet it through the glass.
    let text = scene("path", "")
        .replace("\"float radius\" 0.3", "\"float radius\" 0.02")
        .replace("[4 4 4]", "[900 900 900]")
        .replace("\"float maxsampleluminance\" 20", "");
    let path = folder.path("scene.pbrt");
    std::fs::write(&path, &text).expect("the scene");
    let scene = path.display().to_string();
    folder.render(&scene, "with.exr", &AOV);
    folder.render(&scene, "without.exr", &[]);
    let [with, without] = ["with.exr", "without.exr"].map(|name| Channels::of(&folder.path(name)));
    for channel in ["R", "G", "B"] {
        assert_eq!(with.get(channel), without.get(channel));
    }
    add_up(&with, "a small lamp");
}

/// Bits of layers do not depend on how the work is divided.
#[test]
fn shards_have_them_too() {
    let folder = Folder::new();
    let path = folder.path("scene.pbrt");
    std::fs::write(&path, scene("bdpt", "")).expect("the scene");
    let scene = path.display().to_string();
    folder.render(
        &scene,
        "whole.exr",
        &[&AOV[..], &["--threads", "1"]].concat(),
    );
    for shard in ["1/2", "2/2"] {
        folder.render(
            &scene,
            "a.exr",
            &[&AOV[..], &["--shard", shard, "--tile-size", "16"]].concat(),
        );
    }
    let [merged, first, second] = ["m.exr", "a.shard-1-of-2.fsc", "a.shard-2-of-2.fsc"]
        .map(|name| folder.path(name).display().to_string());
    let run = fstop(["merge", "-o", &merged, &first, &second]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let bytes = |name: &str| std::fs::read(folder.path(name)).expect("a file");
    assert!(bytes("whole.exr") == bytes("m.exr"));
}

#[test]
fn what_cannot_be_is_said() {
    let folder = Folder::new();
    let path = folder.path("scene.pbrt");
    let render = |text: &str| {
        std::fs::write(&path, text).expect("the scene");
        let [scene, output] = [&path, &folder.path("a.exr")].map(|path| path.display().to_string());
        fstop([
            "render", &scene, "-o", &output, "--spp", "1", "--aov", "lights",
        ])
    };
    let text = scene("path", "");
    let run = render(&text.replace("\"string group\"", "#"));
    assert_eq!(run.code, 2);
    assert!(
        run.stderr.contains("no light of the scene is in a group"),
        "{}",
        run.stderr
    );
    for (name, message) in [
        ("rest", "`rest` is what light without a group is called"),
        ("a b", "letters, digits"),
        ("", "letters, digits"),
        ("abcdefghijklmnopqrstuvwxyz", "letters, digits"),
    ] {
        let run = render(&text.replace("\"sky\"", &format!("\"{name}\"")));
        assert_eq!(run.code, 2);
        assert!(
            run.stderr.contains(message) && run.stderr.contains('^'),
            "{}",
            run.stderr
        );
    }
    let light = |i: usize| format!("LightSource \"point\" \"string group\" \"g{i}\"\n");
    let many: String = (0..23).map(light).collect();
    assert_eq!(render(&scene("path", &many)).code, 0);
    let run = render(&scene("path", &(many + &light(23))));
    assert_eq!(run.code, 2);
    assert!(
        run.stderr.contains("one group of lights too many"),
        "{}",
        run.stderr
    );
}
