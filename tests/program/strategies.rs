//! `visualizestrategies` and `visualizeweights` of `bdpt`: an image of each strategy.

use super::cli::Folder;
use super::layers::{Channels, layers_of};
use crate::common::program::fstop;

const BOTH_ENDS: &str = "tests/scenes/reference/int_bdpt.pbrt";

/// The strategies for paths of so many scattering events: s, and the name of the image.
fn strategies(depth: u32) -> Vec<(u32, String)> {
    let all =
        (0..depth + 2).map(|s| (s, format!("bdpt_d{depth:02}_s{s:02}_t{:02}", depth + 2 - s)));
    // A point of a light is not joined to the lens.
    all.filter(|(s, _)| depth > 0 || *s == 0).collect()
}

fn channels(found: &Channels, name: &str) -> [Vec<f32>; 3] {
    ["R", "G", "B"].map(|channel| found.get(&format!("{name}.{channel}")).to_vec())
}

fn asking(text: &str, parameter: &str) -> String {
    text.replace(
        "Integrator \"bdpt\"",
        &format!("Integrator \"bdpt\" \"bool {parameter}\" true"),
    )
}

/// The picture is that which is rendered without them, and their sum but for single precision of a path's, some fifty terms.
#[test]
fn weighted_strategies_add_up_to_the_picture() {
    let text = std::fs::read_to_string(BOTH_ENDS).expect("a scene");
    assert!(text.contains("Integrator \"bdpt\""));
    for goal in [&["--spp", "9"][..], &["--spp", "16", "--variance"]] {
        let without = layers_of(&text, goal);
        let found = layers_of(&asking(&text, "visualizeweights"), goal);
        for channel in ["R", "G", "B"] {
            assert_eq!(without.get(channel), found.get(channel));
            let names = (0..=5).flat_map(strategies);
            let images: Vec<_> = names.map(|(_, name)| format!("{name}.{channel}")).collect();
            for (pixel, whole) in found.get(channel).iter().enumerate() {
                let sum: f32 = images.iter().map(|name| found.get(name)[pixel]).sum();
                let off = (sum - whole).abs();
                assert!(
                    off <= 2e-5 * whole.abs().max(1e-3),
                    "{channel} {pixel}: {sum} {whole}"
                );
            }
        }
    }
}

/// Between matte surfaces each strategy finds all light of its paths by itself, in expectation, and none is left out because
/// others are better.
#[test]
fn strategies_by_themselves_agree() {
    let text = r#"
        LookAt 0 1.5 -5  0 1.5 0  0 1 0
        Camera "perspective" "float fov" 70
        Film "image" "integer xresolution" 16 "integer yresolution" 16
        Sampler "random" "integer pixelsamples" 4096
        Integrator "bdpt" "integer maxdepth" 3
        WorldBegin
        AttributeBegin
          AreaLightSource "diffuse" "rgb L" [3 3 3]
          Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-2 2.7 -2  2 2.7 -2  2 2.7 2  -2 2.7 2]
        AttributeEnd
        Material "matte" "rgb Kd" [0.7 0.7 0.7]
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-4 0 -4  4 0 -4  4 0 4  -4 0 4]
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-4 3 -4  4 3 -4  4 3 4  -4 3 4]
        WorldEnd"#;
    let found = layers_of(&asking(text, "visualizestrategies"), &[]);
    for depth in 1..=3 {
        let mean = |(_, name): (u32, String)| {
            let [_, green, _] = channels(&found, &name);
            green.iter().map(|v| f64::from(*v)).sum::<f64>() / green.len() as f64
        };
        let means: Vec<f64> = strategies(depth).into_iter().map(mean).collect();
        let emitter_sampling = means[1];
        assert!(emitter_sampling > 0.01);
        for (s, mean) in means.iter().enumerate() {
            // A million samples of each: over eight seeds the noisiest scatters by 0.6 %.
            let off = mean / emitter_sampling - 1.0;
            assert!(off.abs() < 0.02, "d = {depth}, s = {s}: {means:?}");
        }
    }
}

#[test]
fn what_they_cannot_be_is_said() {
    let folder = Folder::new();
    let text = std::fs::read_to_string(BOTH_ENDS).expect("a scene");
    let scene = folder.path("a.pbrt").display().to_string();
    std::fs::write(&scene, asking(&text, "visualizeweights")).expect("the scene");
    let render = |name: &str, more: &[&str]| {
        let output = folder.path(name).display().to_string();
        fstop([&["render", &scene, "-o", &output, "--spp", "1"][..], more].concat())
    };
    let run = render("a.exr", &["--aov", "lights"]);
    assert_eq!(run.code, 2);
    assert!(
        run.stderr.contains("leave one of them out"),
        "{}",
        run.stderr
    );
    let run = render("a.png", &[]);
    assert!(
        run.stderr
            .contains("only .exr files keep the images of strategies"),
        "{}",
        run.stderr
    );
    let longer = asking(&text, "visualizeweights").replace(
        "\"integer maxdepth\"",
        "\"integer maxdepth\" 9 \"integer other\"",
    );
    std::fs::write(&scene, longer).expect("the scene");
    let run = fstop(["check", &scene]);
    assert!(run.stderr.contains("it is 5 at most"), "{}", run.stderr);
}
