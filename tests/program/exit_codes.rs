//! Exit codes, by which farms decide what to do next. 0, 1, 75 and 130 are tested where they belong, too.

use super::cli::{Folder, OBJECTS};
use crate::common::program::{Run, fstop, fstop_in};
use std::path::Path;
use std::process::Command;

/// A bug, on the main thread or on another, asks for a report with version and place.
#[test]
fn a_bug_asks_for_a_report() {
    for (thread, arguments) in [
        ("main", ["check", OBJECTS]),
        ("worker", ["check", OBJECTS]),
        ("main", ["lens", "lenses/dgauss.50mm.dat"]),
    ] {
        let run = Command::new(env!("CARGO_BIN_EXE_fstop"))
            .args(arguments)
            .env("FSTOP_PANIC", thread)
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .expect("the program");
        let said = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(70), "{said}");
        let request = said.lines().last().expect("a line");
        let version = env!("CARGO_PKG_VERSION");
        let start = format!("error: this is a bug in fstop {version}, at src/");
        assert!(request.starts_with(&start), "{request}");
        assert!(
            request.contains("bugs.rs:") && request.contains("report"),
            "{request}"
        );
        assert!(said.contains("a rehearsal"), "{said}");
    }
}

/// A file that is there and cannot be read; none where every file can.
fn unreadable(folder: &Folder) -> Option<String> {
    let locked = folder.path("locked");
    std::fs::write(&locked, "WorldBegin WorldEnd").expect("a file");
    #[cfg(unix)]
    {
        let none = std::os::unix::fs::PermissionsExt::from_mode(0o000);
        std::fs::set_permissions(&locked, none).expect("permissions");
    }
    // Who may read everything is still refused by the driver of the loopback device, which has no speed.
    let candidates = [locked.as_path(), Path::new("/sys/class/net/lo/speed")];
    let fails = |path: &&Path| path.is_file() && std::fs::read(path).is_err();
    let found = candidates.into_iter().find(fails);
    found.map(|path| path.display().to_string())
}

/// Files that cannot be read here are another machine's chance, unless something else is wrong as well.
#[test]
fn a_file_that_cannot_be_read_is_no_bad_scene() {
    let folder = Folder::new();
    let Some(path) = unreadable(&folder) else {
        println!("skipped: every file can be read");
        return;
    };
    for command in ["render", "check", "tradeoff", "lens"] {
        let run = fstop([command, path.as_str()]);
        assert_eq!(run.code, 74, "{command}: {}", run.stderr);
    }
    assert_eq!(fstop(["compare", path.as_str(), path.as_str()]).code, 74);
    let image = "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\"";
    let used = "Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\"";
    for (name, directive) in [
        ("include", format!("WorldBegin Include \"{path}\"")),
        (
            "lens",
            format!("Camera \"realistic\" \"string lensfile\" \"{path}\" WorldBegin"),
        ),
        (
            "light",
            format!("WorldBegin LightSource \"infinite\" \"string mapname\" \"{path}\""),
        ),
        (
            "spectrum",
            format!("WorldBegin LightSource \"point\" \"spectrum I\" \"{path}\""),
        ),
        ("image", format!("WorldBegin {image} \"{path}\" {used}")),
        (
            "fourier",
            format!("WorldBegin Material \"fourier\" \"string bsdffile\" \"{path}\""),
        ),
        (
            "ply",
            format!("WorldBegin Shape \"plymesh\" \"string filename\" \"{path}\""),
        ),
        (
            "obj",
            format!("WorldBegin Shape \"objmesh\" \"string filename\" \"{path}\""),
        ),
    ] {
        let checked = |more: &str| -> Run {
            std::fs::write(
                folder.path("s.pbrt"),
                format!("{directive}\n{more}\nWorldEnd\n"),
            )
            .expect("a file");
            fstop_in(folder.0.path(), ["check", "s.pbrt"])
        };
        let run = checked("");
        assert_eq!(run.code, 74, "{name}: {}", run.stderr);
        let run = checked("Shape \"plymesh\" \"string filename\" \"nowhere.ply\"");
        assert_eq!(run.code, 2, "{name}: {}", run.stderr);
    }
    // Of several scenes, one that is wrong everywhere decides.
    let both = ["check", path.as_str(), "nowhere.pbrt"];
    assert_eq!(fstop(both).code, 2);
    let one = ["check", OBJECTS, path.as_str()];
    assert_eq!(fstop(one).code, 74);
}

/// A name that no file can have is wrong everywhere; a folder that is missing may be a disk that is not mounted.
#[test]
fn an_image_that_cannot_be_written_is_told_from_a_bad_name() {
    let folder = Folder::new();
    for (name, code) in [("none/a.exr", 74), ("a.exr/", 2), ("", 2), ("a.gif", 2)] {
        let output = folder.path(name).display().to_string();
        let run = fstop(["render", OBJECTS, "--spp", "1", "-o", &output]);
        assert_eq!(run.code, code, "{name}: {}", run.stderr);
    }
    #[cfg(target_os = "linux")]
    {
        std::os::unix::fs::symlink("/dev/full", folder.path("full.exr")).expect("a link");
        let output = folder.path("full.exr").display().to_string();
        let run = Command::new(env!("CARGO_BIN_EXE_fstop"))
            .args(["render", "--spp", "1", "-o", &output])
            .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join(OBJECTS))
            .current_dir(folder.0.path())
            .output()
            .expect("the program");
        let said = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(74), "{said}");
    }
    let checkpoint = folder.path("none/a.fsc").display().to_string();
    let output = folder.path("a.exr").display().to_string();
    let run = fstop([
        "render",
        OBJECTS,
        "-o",
        &output,
        "--checkpoint",
        &checkpoint,
    ]);
    assert_eq!(run.code, 74, "{}", run.stderr);
    let foreign = folder.path("foreign.fsc");
    std::fs::write(&foreign, "a letter").expect("a file");
    let foreign = foreign.display().to_string();
    let run = fstop(["render", OBJECTS, "-o", &output, "--checkpoint", &foreign]);
    assert_eq!(run.code, 2, "{}", run.stderr);
}

/// Whoever asks for the codes finds them all.
#[test]
fn help_lists_every_code() {
    for arguments in [vec!["--help"], vec!["render", "--help"]] {
        let help = fstop(&arguments).stdout;
        for code in ["0 ", "1 ", "2 ", "70 ", "74 ", "75 ", "130 "] {
            let is_told = help
                .lines()
                .any(|line| line.starts_with(&format!("  {code}")));
            assert!(is_told, "{arguments:?}: no {code}\n{help}");
        }
    }
}
