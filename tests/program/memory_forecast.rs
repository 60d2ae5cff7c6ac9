//! `check --memory`: the forecast is near what a render takes, without one.

use super::cli::Folder;
use crate::common::program::{fstop, fstop_in};
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;

/// Part by which forecast and peak may differ. What allocators keep, and how far threads get before others, is not
/// forecast.
const TOLERANCE: f64 = 0.2;

/// The line `all` of the table, in bytes.
fn forecast(folder: &Path, scene: &str) -> f64 {
    let run = fstop_in(folder, ["check", "--memory", scene]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let line = { run.stdout.lines() }.find(|line| line.starts_with("  all "));
    let words: Vec<&str> = line.expect("a sum").split_whitespace().collect();
    let unit = match words[2] {
        "MiB" => 1048576.0,
        "GiB" => 1073741824.0,
        other => panic!("{other}: {}", run.stdout),
    };
    words[1].parse::<f64>().expect("a number") * unit
}

/// The most memory that a render of the scene had, as it tells itself.
fn peak(folder: &Path, scene: &str) -> Option<f64> {
    let line = [
        "render",
        scene,
        "--spp",
        "1",
        "-o",
        "a.exr",
        "--progress",
        "json",
    ];
    let run = fstop_in(folder, line);
    assert_eq!(run.code, 0, "{}", run.stderr);
    // Progress is told now and then, and perhaps not while the file is written: the last line alone knows of all.
    let end: Value = serde_json::from_str(run.stderr.lines().last()?).expect("JSON");
    assert_eq!(end["event"], "end");
    end["peak_memory_bytes"].as_f64()
}

/// Writes the scene of a small image, and checks its forecast; returns both.
fn check(
    folder: &Folder,
    (name, options): (&str, &str),
    [width, height]: [u32; 2],
    world: &str,
) -> String {
    let scene = format!(
        "{options} LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\"\n\
         Film \"image\" \"integer xresolution\" {width} \"integer yresolution\" {height}\n\
         WorldBegin LightSource \"infinite\"\n{world}\nWorldEnd\n"
    );
    std::fs::write(folder.path("s.pbrt"), scene).expect("a file");
    let (forecast, Some(peak)) = (
        forecast(folder.0.path(), "s.pbrt"),
        peak(folder.0.path(), "s.pbrt"),
    ) else {
        return format!("{name}: skipped: the system does not tell of a process's memory");
    };
    let said = format!(
        "{name}: forecast {:.1} MiB, measured {:.1} MiB",
        forecast / 1048576.0,
        peak / 1048576.0
    );
    assert!(
        (forecast / peak - 1.0).abs() < TOLERANCE,
        "{name}: {forecast} for {peak}"
    );
    said
}

/// A wavy square of 2·n² triangles as a binary PLY file.
fn ply(n: u32) -> Vec<u8> {
    let side = n + 1;
    let mut file = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        side * side,
        2 * n * n
    )
    .into_bytes();
    for i in 0..side * side {
        let (x, y) = ((i % side) as f32 / n as f32, (i / side) as f32 / n as f32);
        for v in [x, y, (9.0 * x).sin() * (7.0 * y).cos()] {
            file.extend(v.to_le_bytes());
        }
    }
    for i in 0..n * n {
        let a = i / n * side + i % n;
        for face in [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]] {
            file.push(3);
            face.into_iter().for_each(|v| file.extend(v.to_le_bytes()));
        }
    }
    file
}

/// Each kind of scene takes 30 MiB or more, of which the program is 8.
#[test]
fn large_things_are_forecast() {
    let folder = Folder::new();
    let check = |name: &str, size: [u32; 2], world: &str| {
        println!("{}", check(&folder, (name, ""), size, world));
    };
    std::fs::write(folder.path("m.ply"), ply(300)).expect("a file");
    check(
        "mesh",
        [64, 64],
        "Shape \"plymesh\" \"string filename\" \"m.ply\"",
    );
    // Of many values: the file of one would be small.
    check(
        "film",
        [2400, 1000],
        "Texture \"t\" \"spectrum\" \"wrinkled\"\n\
         Texture \"c\" \"spectrum\" \"scale\" \"texture tex1\" \"t\" \"rgb tex2\" [.3 .5 .7]\n\
         Material \"matte\" \"texture Kd\" \"c\"\n\
         Shape \"disk\" \"float radius\" 50",
    );
    let both_ends = ("splats", "Integrator \"bdpt\"");
    println!(
        "{}",
        // In a world of matte surfaces alone the pilot pass may leave paths from the lights out.
        self::check(
            &folder,
            both_ends,
            [800, 600],
            "Material \"glass\" Shape \"sphere\""
        )
    );
    let mut pfm = b"PF\n1500 1000\n-1\n".to_vec();
    pfm.extend([0u8, 0, 0, 63].repeat(3 * 1500 * 1000));
    std::fs::write(folder.path("t.pfm"), pfm).expect("a file");
    let texture = "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"t.pfm\"\n\
                   Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\"";
    check("image", [64, 64], texture);
    let (mut spheres, mut instances, mut curves) = (String::new(), String::new(), String::new());
    instances += "ObjectBegin \"o\" Shape \"sphere\" \"float radius\" .01 ObjectEnd\n";
    for i in 0..40_000 {
        let (x, y, z) = (i % 37, i % 41, i % 43);
        let place = format!("AttributeBegin Translate {x} {y} {z}");
        let _ = writeln!(
            spheres,
            "{place} Shape \"sphere\" \"float radius\" .1 AttributeEnd"
        );
        let _ = writeln!(instances, "{place} ObjectInstance \"o\" AttributeEnd");
        if i % 2 == 0 {
            let points =
                format!("{x} {y} {z} {x}.1 {y}.3 {z}.2 {x}.4 {y}.1 {z}.3 {x}.5 {y}.5 {z}.5");
            let _ = writeln!(
                curves,
                "Shape \"curve\" \"float width\" .01 \"point P\" [{points}]"
            );
        }
    }
    check("quadrics", [64, 64], &spheres);
    check("instances", [64, 64], &instances);
    check("curves", [64, 64], &curves);
}

/// A small scene is little more than the program, and a broken file is told of.
#[test]
fn small_scenes_are_the_program() {
    let folder = Folder::new();
    let scene = "tests/scenes/valid/realistic_camera.pbrt";
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let bytes = forecast(root, scene);
    // A build for tests has its code in other pages than one for use.
    assert!((7e6..14e6).contains(&bytes), "{bytes}");
    std::fs::write(folder.path("m.ply"), "no mesh").expect("a file");
    let scene = "WorldBegin Shape \"plymesh\" \"string filename\" \"m.ply\" WorldEnd";
    std::fs::write(folder.path("s.pbrt"), scene).expect("a file");
    let run = fstop_in(folder.0.path(), ["check", "--memory", "s.pbrt"]);
    assert!(
        run.code == 2 && run.stderr.contains("m.ply"),
        "{}",
        run.stderr
    );
    assert_eq!(fstop(["check", "--memory", "nowhere.pbrt"]).code, 2);
}
