//! `tests/scenes/invalid`: scenes with every kind of mistake. `fstop check` must refuse each with
//! exactly the text recorded beside it. What is recorded has been read and judged by a person: the
//! right line, column and caret, what was expected, what to try.

use crate::common::program::{differs_from_recorded, fstop, scenes};
use std::path::Path;

/// What is wrong with how one scene is refused, if anything.
fn check(scene: &Path) -> Option<String> {
    let run = fstop(["check".as_ref(), scene.as_os_str()]);
    if run.code != 2 {
        let (code, stderr) = (run.code, run.stderr);
        return Some(format!("{}: exit code {code}\n{stderr}", scene.display()));
    }
    // Trailing blanks of excerpts would not survive an editor.
    let text: String = (run.stderr + &run.stdout)
        .lines()
        .map(|line| format!("{}\n", line.trim_end()))
        .collect();
    differs_from_recorded(scene, &text)
}

#[test]
fn every_invalid_scene_is_refused_with_the_recorded_words() {
    let all = scenes("invalid");
    assert!(all.len() > 30, "only {} scenes", all.len());
    let wrong: Vec<String> = all.iter().filter_map(|s| check(s)).collect();
    assert!(
        wrong.is_empty(),
        "{} scenes:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

/// Rendering refuses what checking refuses, with the same words, and writes nothing.
#[test]
fn render_refuses_what_check_refuses() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = folder.path().join("picture.exr");
    for name in ["several_files", "missing_world_end", "lens_focus"] {
        let scene = Path::new("tests/scenes/invalid")
            .join(name)
            .with_extension("pbrt");
        let checked = fstop(["check".as_ref(), scene.as_os_str()]);
        for quiet in [None, Some("--quiet")] {
            let mut command = vec!["render".as_ref(), scene.as_os_str(), "-o".as_ref()];
            command.push(output.as_os_str());
            command.extend(quiet.map(std::ffi::OsStr::new));
            let rendered = fstop(command);
            assert_eq!(rendered.code, 2, "{name}");
            assert_eq!(rendered.stderr, checked.stderr, "{name}");
        }
    }
    let left = std::fs::read_dir(folder.path())
        .expect("the folder")
        .count();
    assert_eq!(left, 0, "files were written");
}

/// What is wrong inside a mesh file is found out when it is loaded, and shown at the file's name.
#[test]
fn a_corrupt_mesh_is_shown_at_its_name() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = folder.path().join("picture.exr");
    let scene = Path::new("tests/scenes/invalid/parts/corrupt_mesh.pbrt");
    let run = fstop([
        "render".as_ref(),
        "--quiet".as_ref(),
        scene.as_os_str(),
        "-o".as_ref(),
        output.as_os_str(),
    ]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(!output.exists());
    let text: String = (run.stderr.lines().map(str::trim_end))
        .map(|line| format!("{line}\n"))
        .collect();
    assert_eq!(differs_from_recorded(scene, &text), None);
}
