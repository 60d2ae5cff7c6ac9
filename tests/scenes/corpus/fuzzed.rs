//! `tests/scenes/fuzzed`: files that are no scenes, or scenes nobody would write. Whatever the bytes
//! are, the program says what it thinks of them, and neither panics nor runs for ever. Besides the
//! stored ones, valid scenes are spoilt in thousands of ways, and large ones are made on the spot.

use super::mutation::{Dice, spoil};
use super::watch::{trouble, under_watch};
use crate::common::program::{fstop, scenes};
use crate::fuzzing::survive;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Spoilt versions of each valid scene.
const VERSIONS: u64 = 30;

/// Tries one text as if it stood in the file `name`; what it is where it made trouble.
fn spoilt_trouble(name: &Path, what: &str, text: &[u8]) -> Option<String> {
    let found = trouble(|| {
        survive(name, text);
    });
    found.map(|message| {
        let text = String::from_utf8_lossy(text);
        format!("{} {what}: {message}\n{text}\n", name.display())
    })
}

fn bytes(scene: &Path) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join(scene)).expect("a readable scene")
}

#[test]
fn spoilt_scenes_are_survived() {
    under_watch(|report| {
        let names = scenes("valid");
        let texts: Vec<Vec<u8>> = names.iter().map(|name| bytes(name)).collect();
        let mut troubles = Vec::new();
        for (i, name) in names.iter().enumerate() {
            for version in 0..VERSIONS {
                let mut dice = Dice::new(1000 * i as u64 + version);
                let other = &texts[dice.below(texts.len())];
                let spoilt = spoil(&texts[i], other, &mut dice);
                let what = format!("version {version}");
                report(&format!(
                    "{} {what}\n{}",
                    name.display(),
                    String::from_utf8_lossy(&spoilt)
                ));
                troubles.extend(spoilt_trouble(name, &what, &spoilt));
            }
        }
        troubles
    });
}

/// Every beginning of a scene is a file that somebody's disk was too small for.
#[test]
fn truncated_scenes_are_survived() {
    under_watch(|report| {
        let name = Path::new("tests/scenes/valid/names_with_blanks.pbrt");
        let text = bytes(name);
        let mut troubles = Vec::new();
        for end in 0..text.len() {
            report(&format!("{end} bytes"));
            troubles.extend(spoilt_trouble(name, &format!("{end} bytes"), &text[..end]));
        }
        troubles
    });
}

/// The stored ones, and all that is made to fail elsewhere, through the library.
#[test]
fn stored_scenes_are_survived() {
    under_watch(|report| {
        let mut troubles = Vec::new();
        for name in [scenes("fuzzed"), scenes("invalid")].concat() {
            report(&name.display().to_string());
            troubles.extend(spoilt_trouble(&name, "as stored", &bytes(&name)));
        }
        troubles
    });
}

/// The stored ones through the program: a verdict, and no message of Rust's own.
#[test]
fn the_program_survives_stored_scenes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = folder.path().join("a.exr");
    let stored = scenes("fuzzed");
    assert!(stored.len() > 15, "only {} scenes", stored.len());
    for scene in stored {
        let checked = fstop(["check".as_ref(), scene.as_os_str()]);
        let mut command = vec!["render".as_ref(), "--quick".as_ref(), "-o".as_ref()];
        command.extend([output.as_os_str(), scene.as_os_str()]);
        let rendered = fstop(command);
        for run in [&checked, &rendered] {
            assert!(
                matches!(run.code, 0 | 2),
                "{}: {}",
                scene.display(),
                run.code
            );
            assert!(
                !run.stderr.contains("panicked"),
                "{}\n{}",
                scene.display(),
                run.stderr
            );
        }
        assert!(
            checked.code == 0 || rendered.code == 2,
            "{}",
            scene.display()
        );
    }
}

/// Spoilt scenes through the program, since a thread's stack and the way out differ there.
#[test]
fn the_program_survives_spoilt_scenes() {
    let names = scenes("valid");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = folder.path().join("spoilt.pbrt");
    for (i, name) in names.iter().enumerate() {
        let mut dice = Dice::new(77 + i as u64);
        let text = bytes(name);
        std::fs::write(&scene, spoil(&text, &text, &mut dice)).expect("a file");
        let run = fstop(["check".as_ref(), scene.as_os_str()]);
        assert!(
            matches!(run.code, 0 | 2),
            "{}: {}\n{}",
            name.display(),
            run.code,
            run.stderr
        );
        assert!(
            !run.stderr.contains("panicked"),
            "{}\n{}",
            name.display(),
            run.stderr
        );
    }
}

/// A scene too large to be stored, in a file of its own, judged by the program.
fn judge(text: &str) -> (i32, String) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = folder.path().join("large.pbrt");
    std::fs::write(&scene, text).expect("a file");
    let output = folder.path().join("a.exr");
    let command: [&std::ffi::OsStr; 6] = [
        "render".as_ref(),
        "--spp".as_ref(),
        "1".as_ref(),
        "-o".as_ref(),
        output.as_os_str(),
        scene.as_os_str(),
    ];
    let run = fstop(command);
    assert!(!run.stderr.contains("panicked"), "{}", run.stderr);
    (run.code, run.stderr)
}

/// Film and world around `inside`.
fn world(inside: &str) -> String {
    let film = "\"integer xresolution\" 4 \"integer yresolution\" 3";
    format!("Film \"image\" {film}\nWorldBegin\nLightSource \"infinite\"\n{inside}\nWorldEnd\n")
}

#[test]
fn ten_thousand_nested_includes_render() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |i: usize| -> PathBuf { folder.path().join(format!("{i}.pbrt")) };
    for i in 1..10_000 {
        let text = format!("Translate 0 0 .001\nInclude \"{}.pbrt\"\n", i + 1);
        std::fs::write(path(i), text).expect("a file");
    }
    std::fs::write(path(10_000), "Shape \"sphere\"\n").expect("a file");
    std::fs::write(path(0), world("Include \"1.pbrt\"")).expect("a file");
    let run = fstop(["check".as_ref(), path(0).as_os_str()]);
    assert_eq!((run.code, run.stderr.as_str()), (0, ""));
    // And in a circle of that length.
    std::fs::write(path(10_000), "Include \"5.pbrt\"\n").expect("a file");
    let run = fstop(["check".as_ref(), path(0).as_os_str()]);
    assert_eq!(run.code, 2);
    assert!(
        run.stderr.contains("files include each other in a circle"),
        "{}",
        run.stderr
    );
    assert!(run.stderr.len() < 3000, "{}", run.stderr);
}

#[test]
fn a_million_shapes_render() {
    let mut shapes = String::new();
    for i in 0..1_000_000_u64 {
        let (x, y, z) = (i * 7919 % 1000, i * 104_729 % 997, i * 31 % 991);
        writeln!(
            shapes,
            "TransformBegin Translate {x} {y} {z} Shape \"sphere\" \"float radius\" .{i}1 TransformEnd"
        )
        .expect("memory");
    }
    let (code, stderr) = judge(&world(&shapes));
    assert_eq!(code, 0, "{stderr}");
}

#[test]
fn deep_nesting_renders() {
    const DEPTH: usize = 100_000;
    for word in ["Attribute", "Transform"] {
        let begin = format!("{word}Begin Translate 0 0 .0001\n").repeat(DEPTH);
        let end = format!("{word}End\n").repeat(DEPTH);
        let (code, stderr) = judge(&world(&format!("{begin}Shape \"sphere\"\n{end}")));
        assert_eq!(code, 0, "{stderr}");
        assert!(!stderr.contains("warning"), "{stderr}");
        // Never closed: the pattern is shown, not every one of them.
        let (code, stderr) = judge(&world(&format!("{begin}Shape \"sphere\"\n")));
        assert_eq!(code, 0, "{stderr}");
        assert!(
            stderr.contains("is never closed") && stderr.len() < 5000,
            "{stderr}"
        );
    }
}

/// Textures in textures in textures: refused at a depth that no scene has, not by a full stack.
#[test]
fn deep_textures_are_refused() {
    let mut textures = String::from("Texture \"t0\" \"spectrum\" \"constant\"\n");
    for i in 1..20_000 {
        let before = i - 1;
        writeln!(
            textures,
            "Texture \"t{i}\" \"spectrum\" \"scale\" \"texture tex1\" \"t{before}\""
        )
        .expect("memory");
    }
    textures += "Material \"matte\" \"texture Kd\" \"t19999\"\nShape \"sphere\"\n";
    let (code, stderr) = judge(&world(&textures));
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.len() < 50_000, "{} bytes of messages", stderr.len());
}

/// Thousands of lights, textures, materials, objects and instances: nothing takes time squared.
#[test]
fn many_of_everything_renders() {
    let mut inside = String::new();
    for i in 0..3_000 {
        writeln!(
            inside,
            "Texture \"t{i}\" \"float\" \"constant\" MakeNamedMaterial \"m{i}\" \"string type\" \"matte\"\n\
             CoordinateSystem \"c{i}\" LightSource \"point\"\n\
             ObjectBegin \"o{i}\" Shape \"sphere\" ObjectEnd ObjectInstance \"o{i}\"\n\
             AttributeBegin AreaLightSource \"diffuse\" Shape \"disk\" AttributeEnd"
        )
        .expect("memory");
    }
    let (code, stderr) = judge(&world(&inside));
    assert_eq!(code, 0, "{stderr}");
}
