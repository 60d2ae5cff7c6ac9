//! Files that are none: pipes that nobody writes to, devices without end. Each is refused at once.

use crate::common::program::{fstop, fstop_in};
use std::path::Path;
use std::process::Command;

/// A pipe in `folder` that nobody writes to.
fn pipe(folder: &Path) -> String {
    let path = folder.join("pipe");
    let made = Command::new("mkfifo").arg(&path).status();
    assert!(made.expect("mkfifo").success());
    path.display().to_string()
}

#[test]
fn pipes_and_devices_are_no_scenes_and_no_lenses() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for path in ["/dev/zero".to_string(), pipe(folder.path())] {
        for command in ["check", "render", "lens", "tradeoff"] {
            let run = fstop([command, path.as_str()]);
            assert_eq!(run.code, 2, "{command} {path}: {}", run.stderr);
            assert!(
                run.stderr.contains("this is not a regular file"),
                "{command} {path}: {}",
                run.stderr
            );
        }
    }
}

#[test]
fn pipes_and_devices_are_no_assets() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = pipe(folder.path());
    for path in ["/dev/zero", path.as_str()] {
        let scene = format!(
            "Camera \"realistic\" \"string lensfile\" \"{path}\"\nWorldBegin\n\
             Include \"{path}\"\n\
             LightSource \"infinite\" \"string mapname\" \"{path}\"\n\
             LightSource \"point\" \"spectrum I\" \"{path}\"\n\
             Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"{path}\"\n\
             Material \"fourier\" \"string bsdffile\" \"{path}\"\n\
             Shape \"plymesh\" \"string filename\" \"{path}\"\n\
             Shape \"objmesh\" \"string filename\" \"{path}\"\nWorldEnd\n"
        );
        std::fs::write(folder.path().join("scene.pbrt"), scene).expect("a file");
        let run = fstop_in(folder.path(), ["check", "scene.pbrt"]);
        assert_eq!(run.code, 2, "{}", run.stderr);
        let refused = run.stderr.matches("this is not a regular file").count();
        assert_eq!(refused, 8, "{path}: {}", run.stderr);
    }
}

/// What a shell makes of `<(command)` is a pipe, and is read; so is standard input.
#[test]
fn pipes_that_come_with_the_program_are_scenes() {
    let program = env!("CARGO_BIN_EXE_fstop");
    let scene = "tests/scenes/valid/scopes_end_crosswise.pbrt";
    for line in [
        format!("'{program}' check <(cat {scene})"),
        format!("cat {scene} | '{program}' check -"),
        format!("cat {scene} | '{program}' check /dev/stdin"),
        format!("'{program}' check /dev/stdin < {scene}"),
    ] {
        let run = Command::new("bash")
            .args(["-c", &line])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .expect("bash");
        let said = String::from_utf8_lossy(&run.stderr);
        assert!(run.status.success() && said.is_empty(), "{line}: {said}");
    }
}

/// A scene given for a lens is answered with one line, not with what is wrong with each row of it.
#[test]
fn a_scene_is_no_lens() {
    let run = fstop(["lens", "tests/scenes/valid/scopes_end_crosswise.pbrt"]);
    assert_eq!(
        (run.code, run.stderr.lines().count()),
        (2, 1),
        "{}",
        run.stderr
    );
    assert!(run.stderr.contains("this is a scene"), "{}", run.stderr);
    // Whatever else it is, one line says enough.
    let run = fstop(["lens", "Cargo.lock"]);
    assert_eq!(run.code, 2);
    assert!(
        run.stderr.len() < 300 && run.stderr.contains("is not a lens file"),
        "{}",
        run.stderr
    );
}

/// The note on which sampler replaces the scene's is printed on demand only.
#[test]
fn the_sampler_is_noted_on_demand() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene =
        "Sampler \"halton\"\nWorldBegin\nLightSource \"point\"\nShape \"sphere\"\nWorldEnd\n";
    std::fs::write(folder.path().join("scene.pbrt"), scene).expect("a file");
    let quiet = fstop_in(folder.path(), ["check", "scene.pbrt"]);
    assert_eq!((quiet.code, quiet.stderr.as_str()), (0, ""));
    let verbose = fstop_in(folder.path(), ["check", "-v", "scene.pbrt"]);
    assert!(verbose.stderr.contains("note: "), "{}", verbose.stderr);
    assert!(
        verbose.stderr.contains("Sampler \"halton\""),
        "{}",
        verbose.stderr
    );
}
