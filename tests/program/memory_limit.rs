//! What is larger than the memory is an error at its line, and not the end of the process.

use super::cli::Folder;
use crate::common::program::fstop_in;
use flate2::{Compression, write::GzEncoder};
use std::io::Write;

/// A scene of 4 × 4 pixels with `world` on its line 4.
fn scene(world: &str) -> String {
    let film = "\"integer xresolution\" 4 \"integer yresolution\" 4 \"string filename\" \"a.exr\"";
    format!("Film \"image\" {film}\nCamera \"perspective\"\nWorldBegin\n{world}\nWorldEnd\n")
}

/// A triangle in a PLY file, with `bytes` bytes of another element behind it.
fn ply(bytes: usize) -> Vec<u8> {
    let mut file = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
         property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
         element other {bytes}\nproperty uchar b\nend_header\n"
    )
    .into_bytes();
    for number in [0.0f32, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 1.0, 1.0] {
        file.extend(number.to_le_bytes());
    }
    file.push(3);
    for index in [0i32, 1, 2] {
        file.extend(index.to_le_bytes());
    }
    file.resize(file.len() + bytes, 0);
    file
}

fn numbers(count: usize) -> String {
    vec!["0"; count].join(" ")
}

/// One of each that can be large: refused with little memory, accepted with enough.
#[test]
fn what_is_too_large_is_an_error_at_its_line() {
    let folder = Folder::new();
    let write = |name: &str, bytes: &[u8]| {
        std::fs::write(folder.path(name), bytes).expect("a writable folder");
    };
    image::RgbImage::new(600, 400)
        .save(folder.path("image.png"))
        .expect("a writable folder");
    write("mesh.ply", &ply(300_000));
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(&ply(300_000)).expect("memory");
    let packed = packed.finish().expect("memory");
    assert!(packed.len() < 2000);
    write("mesh.ply.gz", &packed);
    let faces = "f 1 2 3\n".repeat(20_000);
    write(
        "mesh.obj",
        format!("v 0 0 1\nv 1 0 1\nv 0 1 1\n{faces}").as_bytes(),
    );
    let square = "\"point P\" [0 0 1 1 0 1 0 1 1 1 1 1]";
    for world in [
        "LightSource \"infinite\" \"string mapname\" \"image.png\"".to_owned(),
        "Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"image.png\" \
         Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\""
            .to_owned(),
        "Shape \"plymesh\" \"string filename\" \"mesh.ply\"".to_owned(),
        "Shape \"plymesh\" \"string filename\" \"mesh.ply.gz\"".to_owned(),
        "Shape \"objmesh\" \"string filename\" \"mesh.obj\"".to_owned(),
        format!("Shape \"loopsubdiv\" \"integer nlevels\" 7 \"integer indices\" [0 1 2] {square}"),
        format!(
            "Shape \"heightfield\" \"integer nu\" 50 \"integer nv\" 50 \"float Pz\" [{}]",
            numbers(2500)
        ),
        format!(
            "Shape \"trianglemesh\" \"integer indices\" [{}] {square}",
            "0 1 2 ".repeat(5000)
        ),
        format!(
            "Shape \"nurbs\" \"integer nu\" 2 \"integer nv\" 2 \"integer uorder\" 2 \"integer vorder\" 2 \
             \"float uknots\" [0 0 1 1] \"float vknots\" [0 0 1 1] {square}"
        ),
    ] {
        write("scene.pbrt", scene(&world).as_bytes());
        let short = world.chars().take(60).collect::<String>();
        for command in ["check", "render"] {
            let run = fstop_in(
                folder.0.path(),
                [command, "--max-memory", "200K", "scene.pbrt"],
            );
            assert_eq!(run.code, 2, "{short}\n{}", run.stderr);
            assert!(
                run.stderr.contains("--max-memory"),
                "{short}\n{}",
                run.stderr
            );
            assert!(
                run.stderr.contains("scene.pbrt:4:"),
                "{short}\n{}",
                run.stderr
            );
        }
        let run = fstop_in(
            folder.0.path(),
            ["check", "--max-memory", "64M", "scene.pbrt"],
        );
        assert_eq!(run.code, 0, "{short}\n{}", run.stderr);
        let run = fstop_in(folder.0.path(), ["check", "scene.pbrt"]);
        assert_eq!(run.code, 0, "{short}\n{}", run.stderr);
    }
}

/// Two that fit one by one do not fit together.
#[test]
fn the_limit_is_of_all_together() {
    let folder = Folder::new();
    let square = "\"point P\" [0 0 1 1 0 1 0 1 1 1 1 1]";
    let mesh = format!(
        "Shape \"loopsubdiv\" \"integer nlevels\" 5 \"integer indices\" [0 1 2] {square}\n"
    );
    for (count, code) in [(1, 0), (2, 2)] {
        std::fs::write(folder.path("scene.pbrt"), scene(&mesh.repeat(count))).expect("a scene");
        let run = fstop_in(
            folder.0.path(),
            ["check", "--max-memory", "250K", "scene.pbrt"],
        );
        assert_eq!(run.code, code, "{}", run.stderr);
    }
}

#[test]
fn a_film_larger_than_the_memory_is_refused() {
    let folder = Folder::new();
    let text = |width: u32| scene("").replace("4 \"integer y", &format!("{width} \"integer y"));
    // Colors alone, and those of halves with their sums.
    for (width, more, needed) in [
        (65_536, &[][..], "3.0 MiB"),
        (9000, &["--error", "50%"], "MiB"),
    ] {
        std::fs::write(folder.path("scene.pbrt"), text(width)).expect("a scene");
        let arguments = ["render", "--max-memory", "1M", "scene.pbrt"];
        let run = fstop_in(folder.0.path(), [&arguments[..], more].concat());
        assert_eq!(run.code, 2, "{}", run.stderr);
        let said = run.stderr.contains("the film needs ") && run.stderr.contains(needed);
        assert!(
            said && run.stderr.contains("scene.pbrt:1:1"),
            "{}",
            run.stderr
        );
    }
    let run = fstop_in(
        folder.0.path(),
        ["check", "--max-memory", "1M", "scene.pbrt"],
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
}

/// Levels beyond the limit are not made fewer in silence.
#[test]
fn too_many_levels_are_an_error() {
    let folder = Folder::new();
    let shape = "Shape \"loopsubdiv\" \"integer nlevels\" 20 \"integer indices\" [0 1 2] \
                 \"point P\" [0 0 1 1 0 1 0 1 1]";
    std::fs::write(folder.path("scene.pbrt"), scene(shape)).expect("a scene");
    let run = fstop_in(folder.0.path(), ["render", "scene.pbrt"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(
        run.stderr.contains("12 is the most for this mesh"),
        "{}",
        run.stderr
    );
}

/// An EXR header's windows, with every byte turned: an answer or a message, never an abort.
#[test]
fn compare_survives_any_byte_of_the_windows() {
    let folder = Folder::new();
    folder.render(super::cli::OBJECTS, "a.exr", &["--spp", "1"]);
    let good = std::fs::read(folder.path("a.exr")).expect("the image");
    for name in ["dataWindow\0box2i\0", "displayWindow\0box2i\0"] {
        let at = good.windows(name.len()).position(|w| w == name.as_bytes());
        let start = at.expect("an attribute") + name.len() + 4;
        for byte in start..start + 16 {
            let mut bad = good.clone();
            bad[byte] ^= 0xff;
            std::fs::write(folder.path("b.exr"), &bad).expect("a writable folder");
            let run = fstop_in(folder.0.path(), ["compare", "--no-flip", "b.exr", "a.exr"]);
            // A wider display window moves no pixel: such images may well agree.
            let least = i32::from(name.starts_with("data"));
            assert!(
                (least..=2).contains(&run.code),
                "{name} {byte}: {}",
                run.code
            );
        }
    }
}

/// Files of a terabyte, which take no place on the disk, are refused before they are read.
#[test]
fn a_file_larger_than_the_memory_is_not_read() {
    let folder = Folder::new();
    for (name, world) in [
        (
            "big.ply",
            "Shape \"plymesh\" \"string filename\" \"big.ply\"",
        ),
        (
            "big.obj",
            "Shape \"objmesh\" \"string filename\" \"big.obj\"",
        ),
        (
            "big.png",
            "LightSource \"infinite\" \"string mapname\" \"big.png\"",
        ),
        (
            "big.ptx",
            "Texture \"t\" \"color\" \"ptex\" \"string filename\" \"big.ptx\" Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\"",
        ),
        (
            "big.bsdf",
            "Material \"fourier\" \"string bsdffile\" \"big.bsdf\" Shape \"sphere\"",
        ),
        (
            "big.binary",
            "Material \"measured\" \"string filename\" \"big.binary\" Shape \"sphere\"",
        ),
        (
            "big.spd",
            "LightSource \"point\" \"spectrum I\" \"big.spd\"",
        ),
        ("big.pbrt", "Include \"big.pbrt\""),
    ] {
        let file = std::fs::File::create(folder.path(name)).expect("a file");
        // Some file systems have no room for the size alone.
        if file.set_len(1 << 40).is_err() {
            return;
        }
        std::fs::write(folder.path("scene.pbrt"), scene(world)).expect("a scene");
        let run = fstop_in(
            folder.0.path(),
            [
                "check",
                "--dialect",
                "v2",
                "--max-memory",
                "1G",
                "scene.pbrt",
            ],
        );
        let said = run.stderr.contains("of memory") || run.stderr.contains("it is larger than");
        assert!(run.code == 2 && said, "{name}: {}", run.stderr);
        assert!(
            run.stderr.contains("scene.pbrt:4:"),
            "{name}: {}",
            run.stderr
        );
        std::fs::remove_file(folder.path(name)).expect("the file");
    }
}
