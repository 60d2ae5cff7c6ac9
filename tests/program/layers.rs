//! `--aov`: what an image knows of its pixels besides their color. Laws of the layers, and that nothing else changes.

use super::cli::{Folder, LENS};
use crate::common::program::fstop;
use exr::meta::attribute::AttributeValue;
use exr::prelude::{ReadChannels, ReadLayers};
use fstop::film::read;
use std::collections::BTreeMap;
use std::path::Path;

const ALL: &str = "albedo,normal,depth,position,uv,material,instance,motion,coc,alpha";
/// A box with a mirror ball.
const BOX: &str = "tests/scenes/reference/int_cornell_path.pbrt";
/// A real lens before surfaces.
const GAUSS: &str = "tests/scenes/reference/realistic_dgauss50_full.pbrt";
/// Paths from the lights, too.
const BOTH_ENDS: &str = "tests/scenes/reference/int_bdpt.pbrt";

/// The channels of a file, as any program reads them.
pub(super) struct Channels {
    pub(super) width: usize,
    by_name: BTreeMap<String, Vec<f32>>,
    /// Attributes that are text.
    pub(super) texts: BTreeMap<String, String>,
}

impl Channels {
    pub(super) fn of(path: &Path) -> Channels {
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_file(path)
            .expect("an EXR file");
        let texts = image.layer_data.attributes.other.iter();
        let texts = texts.filter_map(|(name, value)| match value {
            AttributeValue::Text(text) => Some((name.to_string(), text.to_string())),
            _ => None,
        });
        let texts = texts.collect();
        let list = image.layer_data.channel_data.list;
        let named = list.into_iter().map(|channel| {
            let values = channel.sample_data.values_as_f32().collect();
            (channel.name.to_string(), values)
        });
        Channels {
            width: image.layer_data.size.0,
            by_name: named.collect(),
            texts,
        }
    }

    pub(super) fn get(&self, name: &str) -> &[f32] {
        &self.by_name[name]
    }

    /// Whether each value of a channel is within `tolerance` of what is expected at its pixel.
    pub(super) fn assert(&self, name: &str, tolerance: f32, expected: impl Fn([f32; 2]) -> f32) {
        for (index, value) in self.get(name).iter().enumerate() {
            let pixel = [index % self.width, index / self.width].map(|i| i as f32 + 0.5);
            let expected = expected(pixel);
            assert!(
                (value - expected).abs() <= tolerance,
                "{name} at {pixel:?} is {value}, not {expected}"
            );
        }
    }

    /// The standard deviation, in pixels along x, of a channel's distribution over the image.
    fn spread(&self, name: &str) -> f64 {
        let weighted = |of: &dyn Fn(f64) -> f64| -> f64 {
            let values = self.get(name).iter().enumerate();
            values
                .map(|(i, v)| f64::from(*v) * of((i % self.width) as f64))
                .sum()
        };
        let mean = weighted(&|x| x) / weighted(&|_| 1.0);
        (weighted(&|x| (x - mean).powi(2)) / weighted(&|_| 1.0)).sqrt()
    }
}

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).expect("a file")
}

/// Renders a scene's text, and returns its channels.
pub(super) fn layers_of(text: &str, more: &[&str]) -> Channels {
    let folder = Folder::new();
    let scene = folder.path("scene.pbrt");
    std::fs::write(&scene, text).expect("the scene");
    let scene = scene.display().to_string();
    folder.render(&scene, "a.exr", more);
    Channels::of(&folder.path("a.exr"))
}

#[test]
fn colors_have_the_same_bits_with_layers() {
    let folder = Folder::new();
    let whitted = "tests/scenes/reference/int_whitted.pbrt";
    for scene in [BOX, GAUSS, LENS, BOTH_ENDS, whitted] {
        for goal in [&["--spp", "5"][..], &["--spp", "8", "--variance"]] {
            folder.render(scene, "without.exr", goal);
            folder.render(scene, "with.exr", &[goal, &["--aov", ALL]].concat());
            let [without, with] =
                ["without.exr", "with.exr"].map(|name| read(&folder.path(name)).expect("an image"));
            // Bit for bit, variances as well.
            assert!(without == with, "{scene} {goal:?}");
            let with = Channels::of(&folder.path("with.exr"));
            assert!(with.get("A").iter().all(|a| (0.0..=1.0).contains(a)));
        }
    }
}

#[test]
fn layers_have_the_same_bits_however_the_work_is_divided() {
    let folder = Folder::new();
    let names = |of: u32| -> Vec<String> {
        let name = |number| folder.path(&format!("a.shard-{number}-of-{of}.fsc"));
        { 1..=of }.map(|n| name(n).display().to_string()).collect()
    };
    let [halves, whole] = [&["--variance"][..], &[]];
    for (scene, spp, more) in [
        (GAUSS, "70", whole),
        (BOX, "9", whole),
        (BOX, "150", halves),
        (BOTH_ENDS, "4", whole),
    ] {
        let goal = ["--spp", spp, "--aov", ALL, "--crop", "0.1,0.6,0.2,0.9"];
        let goal = [&goal[..], more].concat();
        folder.render(
            scene,
            "whole.exr",
            &[&goal[..], &["--threads", "1"]].concat(),
        );
        let whole = bytes(&folder.path("whole.exr"));
        let other = ["--threads", "5", "--tile-size", "7"];
        folder.render(scene, "other.exr", &[&goal[..], &other].concat());
        assert!(whole == bytes(&folder.path("other.exr")), "{scene}: tiles");
        for range in ["1/3", "2/3", "3/3"] {
            folder.render(scene, "a.exr", &[&goal[..], &["--shard", range]].concat());
        }
        let merged = folder.path("merged.exr").display().to_string();
        let shards = names(3);
        let mut arguments = vec!["merge", "-o", &merged];
        arguments.extend(more);
        arguments.extend(shards.iter().map(String::as_str));
        let run = fstop(arguments);
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert!(
            whole == bytes(&folder.path("merged.exr")),
            "{scene}: shards"
        );
        shards.iter().for_each(|shard| {
            std::fs::remove_file(shard).expect("a shard's file");
        });
    }
}

/// With an error for a goal, tiles have different numbers of samples, and layers are the means of all of both halves.
#[test]
fn passes_keep_layers_too() {
    let folder = Folder::new();
    let goal = [
        "--error",
        "20%",
        "--spp",
        "64",
        "--aov",
        "albedo,alpha,depth",
    ];
    folder.render(BOX, "passes.exr", &goal);
    folder.render(BOX, "again.exr", &[&goal[..], &["--threads", "5"]].concat());
    assert!(bytes(&folder.path("passes.exr")) == bytes(&folder.path("again.exr")));
    folder.render(
        BOX,
        "plain.exr",
        &["--spp", "64", "--aov", "albedo,alpha,depth"],
    );
    let [passes, plain] = ["passes.exr", "plain.exr"].map(|name| Channels::of(&folder.path(name)));
    // Of 4,096 pixels, of which the 256 at the edges of the box are known to a tenth from some twenty samples.
    for name in ["A", "albedo.R", "albedo.G", "depth.Z"] {
        let mean =
            |found: &Channels| found.get(name).iter().sum::<f32>() / found.get(name).len() as f32;
        let off = mean(&passes) / mean(&plain) - 1.0;
        assert!(off.abs() < 0.01, "{name}: {off}");
    }
}

/// A wall of known place in front of a camera that does not stand at the world's origin. The filter reaches half a pixel, so that
/// means over a pixel are those at its middle, but for the noise of 64 points in as many cells: each deviates by 1/8 pixel over
/// √12, their mean by 0.0045 pixels, and 2,000 values by less than five times that.
#[test]
fn a_wall_is_where_it_is() {
    let scene = r#"
        LookAt 1 2 3  1 2 4  0 1 0
        Camera "perspective" "float fov" 53.13010235415598
        Film "image" "integer xresolution" 16 "integer yresolution" 16
        Sampler "stratified" "integer xsamples" 8 "integer ysamples" 8
        PixelFilter "box" "float xwidth" 0.5 "float ywidth" 0.5
        Integrator "path" "integer maxdepth" 1
        WorldBegin
        LightSource "point" "point from" [1 2 3]
        Material "matte" "rgb Kd" [0.5 0.25 0.125]
        # From x = -5 to 7 and y = -4 to 8, 8 from the camera: (u, v) run over it.
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "float uv" [0 0 1 0 1 1 0 1]
          "point P" [-5 -4 11  7 -4 11  7 8 11  -5 8 11]
        WorldEnd"#;
    let found = layers_of(scene, &["--aov", ALL]);
    // At a distance of 8 and with the tangent 1/2 for half the picture, a pixel is 1/2 wide. pbrt's x axis is turned round by
    // LookAt along +z with y up: x grows to the right.
    let (near, wide) = (1e-5, 0.5 * 5.0 * 0.0045);
    let x = |[x, _]: [f32; 2]| 1.0 + 0.5 * (x - 8.0);
    let y = |[_, y]: [f32; 2]| 2.0 - 0.5 * (y - 8.0);
    found.assert("A", 0.0, |_| 1.0);
    found.assert("depth.Z", near, |_| 8.0);
    for (channel, value) in [("albedo.R", 0.5), ("albedo.G", 0.25), ("albedo.B", 0.125)] {
        found.assert(channel, 0.0, |_| value);
    }
    for (channel, value) in [("normal.X", 0.0), ("normal.Y", 0.0), ("normal.Z", -1.0)] {
        found.assert(channel, 0.0, |_| value);
    }
    found.assert("position.X", wide, x);
    found.assert("position.Y", wide, y);
    found.assert("position.Z", near, |_| 11.0);
    found.assert("uv.U", wide / 12.0, |at| (x(at) + 5.0) / 12.0);
    found.assert("uv.V", wide / 12.0, |at| (y(at) + 4.0) / 12.0);
    found.assert("coc.Y", 0.0, |_| 0.0);
    found.assert("motion.X", 0.0, |_| 0.0);
}

/// What the picture does not cover has no coverage, and what a pixel is half covered by is not taken for something nearer.
#[test]
fn edges_are_covered_in_part() {
    let scene = r#"
        Camera "orthographic" "float screenwindow" [0 4 0 4]
        Film "image" "integer xresolution" 4 "integer yresolution" 4
        Sampler "stratified" "integer xsamples" 8 "integer ysamples" 8
        PixelFilter "box" "float xwidth" 0.5 "float ywidth" 0.5
        WorldBegin
        LightSource "infinite" "rgb L" [1 1 1]
        Material "matte" "rgb Kd" [0.5 0.5 0.5]
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-9 -9 5  1.5 -9 5  1.5 9 5  -9 9 5]
        WorldEnd"#;
    let found = layers_of(scene, &["--aov", ALL]);
    // Eight columns of points, of which four are covered, whatever their place in their cells.
    let covered = |[x, _]: [f32; 2]| (1.5 - (x - 0.5)).clamp(0.0, 1.0);
    found.assert("A", 0.0, covered);
    found.assert("albedo.G", 1e-6, |at| 0.5 * covered(at));
    found.assert("normal.Z", 1e-6, |at| -covered(at));
    found.assert(
        "depth.Z",
        1e-6,
        |at| if covered(at) > 0.0 { 5.0 } else { 0.0 },
    );
}

/// In a matte ball all ways end at the same albedo: through a pane, off it, and off a mirror, but what that swallows. Depth, place
/// and coverage are of what is met first.
#[test]
fn glass_and_mirrors_are_followed() {
    let inside = |material: &str| {
        format!(
            r#"
        Camera "perspective" "float fov" 30
        Film "image" "integer xresolution" 8 "integer yresolution" 8
        Sampler "halton" "integer pixelsamples" 64
        WorldBegin
        LightSource "point"
        Material "matte" "rgb Kd" [0.5 0.25 0.75]
        Shape "sphere" "float radius" 10
        {material}
        Translate 0 0 4
        Shape "disk" "float radius" 9
        Translate 0 0 1
        Shape "disk" "float radius" 9
        WorldEnd"#
        )
    };
    let glass = layers_of(&inside("Material \"glass\""), &["--aov", ALL]);
    let mirror = layers_of(
        &inside("Material \"mirror\" \"rgb Kr\" [0.5 1 1]"),
        &["--aov", ALL],
    );
    // The weights of some bounces in single precision.
    for (found, red) in [(glass, 0.5), (mirror, 0.25)] {
        found.assert("albedo.R", 1e-5, |_| red);
        found.assert("albedo.G", 1e-5, |_| 0.25);
        found.assert("albedo.B", 1e-5, |_| 0.75);
        found.assert("depth.Z", 1e-5, |_| 4.0);
        found.assert("A", 0.0, |_| 1.0);
    }
}

/// What they note on their own ways is what a ray for the layers alone would have met, as `ambientocclusion` sends one: matte, of which the albedo is
/// known and of which it is estimated, behind a surface without a material; glass, of which `bdpt` chooses the ways otherwise, and mirrors.
#[test]
fn integrators_see_the_same_layers() {
    let by = |integrator: &str, parameters: &str| {
        let text = format!(
            r#"
        Integrator "{integrator}" {parameters}
        Camera "perspective" "float fov" 60
        Film "image" "integer xresolution" 24 "integer yresolution" 16
        Sampler "halton" "integer pixelsamples" 4
        WorldBegin
        LightSource "point"
        AttributeBegin Material "matte" "rgb Kd" [0.5 0.25 0.75] Translate -2 0 5 Shape "sphere" AttributeEnd
        AttributeBegin Material "metal" "float roughness" 0.2 Translate 0 0 5 Shape "sphere" AttributeEnd
        AttributeBegin Material "uber" "rgb Kr" [0.5 0.5 0.5] Translate 2 0 5 Shape "sphere" AttributeEnd
        AttributeBegin Material "glass" Translate -1 1.5 5 Shape "sphere" AttributeEnd
        AttributeBegin Material "mirror" Translate 1 1.5 5 Shape "sphere" AttributeEnd
        AttributeBegin Material "none" Translate 0 0 3 Shape "disk" "float radius" 0.2 AttributeEnd
        WorldEnd"#
        );
        layers_of(&text, &["--aov", ALL])
    };
    let expected = by("ambientocclusion", "");
    // Deeper paths of bdpt are joined now and then to light paths, which take the numbers before theirs.
    let others = [
        ("directlighting", ""),
        ("whitted", ""),
        ("bdpt", r#""integer maxdepth" 1"#),
    ];
    for (integrator, parameters) in others {
        let found = by(integrator, parameters);
        let layers = expected
            .by_name
            .iter()
            .filter(|(name, _)| !"RGB".contains(&***name));
        for (name, values) in layers {
            assert!(found.get(name) == values, "{integrator} {name}");
        }
    }
}

/// A path that goes both ways at glass, or through fog, is seen along one of them, which shows as much as a ray for the layers alone: in the mean over the
/// image, wherever the path ends.
#[test]
fn paths_that_take_both_ways_show_the_same_layers() {
    let by = |integrator: &str, (fog, factors): (&str, &str), seed: &str| {
        let text = format!(
            r#"
        Integrator {integrator}
        Camera "perspective" "float fov" 60
        Film "image" "integer xresolution" 32 "integer yresolution" 32
        Sampler "random" "integer pixelsamples" 64
        WorldBegin
        LightSource "point" "point from" [0 3 0]
        Material "matte" "rgb Kd" [0.9 0 0.1]
        Shape "sphere" "float radius" 30
        AttributeBegin Material "matte" "rgb Kd" [0 0.8 0.1] Translate 0 0 9 Shape "disk" "float radius" 4 AttributeEnd
        {fog}
        Material "glass" {factors}
        AttributeBegin Translate 0.5 0 5 Rotate 50 1 0 0 Shape "disk" "float radius" 3 AttributeEnd
        AttributeBegin Translate 0 0 3 Rotate 70 0 1 0 Shape "disk" "float radius" 3 AttributeEnd
        Translate -1 0 4 Shape "sphere" "float radius" 0.8
        WorldEnd"#
        );
        let found = layers_of(&text, &["--aov", "albedo,normal", "--seed", seed]);
        let mean = |name: &str| {
            let values = found.get(name);
            values.iter().map(|&x| f64::from(x)).sum::<f64>() / values.len() as f64
        };
        ["albedo.R", "albedo.G", "normal.Y", "normal.Z"].map(mean)
    };
    let fog = r#"MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_s" [0.1 0.2 0.1] "rgb sigma_a" [0 0 0.1]
        AttributeBegin MediumInterface "fog" "" Material "none" Translate 0 0 3 Shape "sphere" "float radius" 2.5 AttributeEnd"#;
    let cases = [
        (r#""path" "integer maxdepth" 8"#, ""),
        (r#""path" "integer maxdepth" 2"#, ""),
        (r#""path" "integer maxdepth" 8 "float rrthreshold" 100"#, ""),
        (r#""volpath" "integer maxdepth" 8"#, fog),
        (r#""volpath" "integer maxdepth" 1"#, fog),
    ];
    // The last two have a way that carries nothing.
    let all_factors = [
        r#""rgb Kr" [1 0.8 0.5]"#,
        r#""rgb Kr" [0 0 0]"#,
        r#""rgb Kt" [0 0 0]"#,
    ];
    for factors in all_factors {
        let expected = by("\"ambientocclusion\"", ("", factors), "1");
        for (integrator, fog) in cases {
            let found = by(integrator, (fog, factors), "2");
            for (found, expected) in found.into_iter().zip(expected) {
                // Values of −1 to 1, mostly not: 65,536 samples of both, whose standard deviations are below 0.6; four standard errors.
                let tolerance = 4.0 * 0.6 * (2.0_f64 / 65536.0).sqrt();
                let error = (found - expected).abs();
                assert!(
                    error < tolerance,
                    "{integrator} {factors}: {found}, not {expected}"
                );
            }
        }
    }
}

/// The circle of confusion, against the picture of a small ball out of focus: light evenly spread over a circle of diameter D
/// deviates by D/4 along x. The real lens is stopped down, for its aberrations fall with the cube of the aperture.
#[test]
fn circles_of_confusion_are_as_large_as_they_are_seen() {
    let scene = |camera: &str, pixels: u32, distance: f64, radius: f64| {
        format!(
            r#"
        {camera}
        Film "image" "integer xresolution" {pixels} "integer yresolution" {pixels} "float diagonal" 6
        Sampler "halton" "integer pixelsamples" 4096
        PixelFilter "box" "float xwidth" 0.5 "float ywidth" 0.5
        WorldBegin
        LightSource "infinite" "rgb L" [1 1 1]
        Translate 0 0 {distance}
        Shape "sphere" "float radius" {radius}
        WorldEnd"#
        )
    };
    let thin =
        r#"Camera "perspective" "float fov" 20 "float lensradius" 0.1 "float focaldistance" 4"#;
    let real = format!(
        r#"Camera "realistic" "string lensfile" "{}/lenses/dgauss.50mm.dat" "float focusdistance" 1.0
           "float aperturediameter" 4"#,
        env!("CARGO_MANIFEST_DIR")
    );
    let [wide, narrow] = ["0.3,0.7,0.3,0.7", "0.47,0.53,0.47,0.53"];
    // The ball is a tenth of its blur, and pixels a fifteenth or an eighth: each adds the half of its square. Some 1,500 rays meet
    // it, whose deviation is known to 1.3 %.
    for (camera, crop, pixels, distance, radius) in [
        (thin, wide, 96, 2.0, 0.005),
        (&real, narrow, 400, 1.3, 0.0001),
        (&real, narrow, 400, 0.8, 0.0001),
    ] {
        let scene = scene(camera, pixels, distance, radius);
        let found = layers_of(&scene, &["--aov", ALL, "--crop", crop]);
        let told = found.get("coc.Y").iter().copied().fold(0.0, f32::max);
        let seen = 4.0 * found.spread("A");
        assert!(told > 6.0, "{told}");
        let off = f64::from(told) / seen - 1.0;
        assert!(off.abs() < 0.05, "{camera}: {told} {seen}");
    }
}

#[test]
fn the_scene_asks_for_layers_too() {
    let film = |aov: &str| {
        format!(
            r#"Film "image" "integer xresolution" 2 "integer yresolution" 2 {aov}
            Camera "perspective"
            WorldBegin LightSource "infinite" WorldEnd"#
        )
    };
    let names = |found: Channels| -> Vec<String> { found.by_name.into_keys().collect() };
    let color = ["B", "G", "R"];
    let of = |aov: &str, more: &[&str]| names(layers_of(&film(aov), more));
    assert_eq!(of("", &[]), color);
    let both = ["B", "G", "R", "depth.Z", "uv.U", "uv.V"];
    assert_eq!(of(r#""string aov" ["uv" "depth"]"#, &[]), both);
    assert_eq!(of(r#""string aov" "depth,uv""#, &[]), both);
    // What the command line says, wins.
    assert_eq!(
        of(r#""string aov" "depth""#, &["--aov", "alpha"]),
        ["A", "B", "G", "R"]
    );
}

#[test]
fn what_cannot_be_is_said() {
    let folder = Folder::new();
    let scene = folder.path("scene.pbrt");
    let film = r#"Film "image" "string aov" ["depht"]
        Camera "perspective" WorldBegin LightSource "infinite" WorldEnd"#;
    std::fs::write(&scene, film).expect("the scene");
    let scene = scene.display().to_string();
    let output = folder.path("a.exr").display().to_string();
    let run = fstop(["render", &scene, "-o", &output]);
    assert_eq!(run.code, 2);
    let message = "no layer is called \"depht\"; there are albedo, normal, depth";
    assert!(
        run.stderr.contains(message) && run.stderr.contains('^'),
        "{}",
        run.stderr
    );
    let run = fstop(["render", BOX, "-o", &output, "--aov", "albedo,depht"]);
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains(message), "{}", run.stderr);
    let photons = "tests/scenes/reference/int_sppm.pbrt";
    let run = fstop(["render", photons, "-o", &output, "--aov", "depth"]);
    assert_eq!(run.code, 2);
    assert!(
        run.stderr.contains("`sppm` makes no layers"),
        "{}",
        run.stderr
    );
    let png = folder.path("a.png").display().to_string();
    let run = fstop(["render", BOX, "-o", &png, "--aov", "depth", "--quick"]);
    assert_eq!(run.code, 0);
    assert!(run.stderr.contains("--aov has no effect"), "{}", run.stderr);
}
