//! Untrusted scenes: `--files-within`, and files that are no scenes.

use crate::common::program::{Run, fstop_in};
use std::path::Path;

/// What no message may repeat.
const SECRET: &str = "hunter2";

/// Everything that names a file, with this one.
fn scene_that_names(file: &str) -> String {
    format!(
        "Camera \"realistic\" \"string lensfile\" \"{file}\"\nWorldBegin\n\
         Include \"{file}\"\n\
         LightSource \"infinite\" \"string mapname\" \"{file}\"\n\
         LightSource \"goniometric\" \"string mapname\" \"{file}\"\n\
         LightSource \"projection\" \"string mapname\" \"{file}\"\n\
         LightSource \"point\" \"spectrum I\" \"{file}\"\n\
         Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"{file}\"\n\
         Texture \"p\" \"spectrum\" \"ptex\" \"string filename\" \"{file}\"\n\
         Material \"fourier\" \"string bsdffile\" \"{file}\"\n\
         Shape \"plymesh\" \"string filename\" \"{file}\"\n\
         Shape \"objmesh\" \"string filename\" \"{file}\"\nWorldEnd\n"
    )
}

/// How many of its lines name a file.
const NAMED: usize = 11;

struct Place(tempfile::TempDir);

impl Place {
    /// A folder `scene` beside a file with a secret, and a link in it that leads there.
    fn new() -> Place {
        let place = Place(tempfile::tempdir().expect("a temporary folder"));
        std::fs::create_dir(place.0.path().join("scene")).expect("a folder");
        place.write("secret", &format!("{SECRET} {SECRET}\n{SECRET} 2 3\n"));
        #[cfg(unix)]
        std::os::unix::fs::symlink("../secret", place.0.path().join("scene/link")).expect("a link");
        place
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.0.path().join(name), text).expect("a file");
    }

    fn run(&self, args: &[&str]) -> Run {
        let run = fstop_in(self.0.path(), args);
        assert!(!run.stderr.contains(SECRET), "{args:?}: {}", run.stderr);
        run
    }

    fn holds(&self, name: &str) -> bool {
        self.0.path().join(name).exists()
    }
}

#[test]
#[cfg(unix)]
fn no_directive_reads_outside_the_folder() {
    let place = Place::new();
    let absolute = place.0.path().join("secret").display().to_string();
    for file in [
        "../secret",
        "..\\\\secret",
        "../scene/../secret",
        "link",
        absolute.as_str(),
    ] {
        place.write("scene/scene.pbrt", &scene_that_names(file));
        for command in ["check", "render"] {
            let run = place.run(&[command, "--files-within", "scene", "scene/scene.pbrt"]);
            assert_eq!(run.code, 2, "{}", run.stderr);
            let refused = run.stderr.matches("files are read only within").count();
            assert_eq!(refused, NAMED, "{file}: {}", run.stderr);
            let run = place.run(&[command, "scene/scene.pbrt"]);
            assert_eq!((run.code, run.stderr.contains("only within")), (2, false));
        }
        let run = place.run(&["tradeoff", "--files-within", "scene", "scene/scene.pbrt"]);
        assert!(
            run.stderr.contains("files are read only within"),
            "{}",
            run.stderr
        );
    }
    // A main file of the folder that is a link out of it is not the file that was meant.
    let run = place.run(&["check", "--files-within", "scene", "scene/link"]);
    assert!(
        run.code == 2 && run.stderr.contains("only within"),
        "{}",
        run.stderr
    );
    // What an included file names is no different, and neither is what pbrt-v2 includes in a list.
    place.write(
        "scene/part",
        "Shape \"plymesh\" \"string filename\" \"../secret\"",
    );
    for line in [
        "Include \"part\"",
        "Shape \"sphere\" Include \"../secret\"",
        "Material \"measured\" \"string filename\" \"../secret\"",
    ] {
        place.write(
            "scene/scene.pbrt",
            &format!("WorldBegin\n{line}\nWorldEnd\n"),
        );
        let args = [
            "check",
            "--dialect",
            "v2",
            "--files-within",
            "scene",
            "scene/scene.pbrt",
        ];
        let run = place.run(&args);
        assert!(
            run.code == 2 && run.stderr.contains("files are read only within"),
            "{line}: {}",
            run.stderr
        );
    }
}

#[test]
fn what_lies_in_the_folder_is_read() {
    let place = Place::new();
    std::fs::create_dir(place.0.path().join("scene/parts")).expect("a folder");
    place.write(
        "scene/parts/ball.pbrt",
        "Shape \"sphere\" \"float radius\" 0.1\n",
    );
    let text = "Film \"image\" \"integer xresolution\" 4 \"integer yresolution\" 4\n\
        WorldBegin\nLightSource \"infinite\"\nInclude \"parts/../parts/ball.pbrt\"\nWorldEnd\n";
    place.write("scene/scene.pbrt", text);
    let run = place.run(&[
        "render",
        "--files-within",
        "scene",
        "scene/scene.pbrt",
        "-o",
        "a.exr",
    ]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    // The user says where the scene lies and where the image goes.
    assert!(place.holds("a.exr"));
    place.write(
        "elsewhere.pbrt",
        "WorldBegin\nInclude \"secret\"\nWorldEnd\n",
    );
    let run = place.run(&["check", "--files-within", "scene", "elsewhere.pbrt"]);
    assert!(
        run.code == 2 && run.stderr.contains("files are read only within"),
        "{}",
        run.stderr
    );
    for (folder, problem) in [
        ("nowhere", "there is no such file"),
        ("secret", "this is no folder"),
    ] {
        let run = place.run(&["check", "--files-within", folder, "scene/scene.pbrt"]);
        assert_eq!(
            (run.code, run.stderr.trim_end()),
            (
                2,
                format!("error: --files-within {folder}: {problem}").as_str()
            )
        );
    }
}

#[test]
fn the_scene_names_no_image_outside_the_folder() {
    let place = Place::new();
    let name = |file: &str| {
        let film = format!("Film \"image\" \"string filename\" \"{file}\"");
        let text = format!(
            "{film} \"integer xresolution\" 4 \"integer yresolution\" 4\nWorldBegin\nWorldEnd\n"
        );
        place.write("scene/scene.pbrt", &text);
    };
    let render = |more: &[&str]| {
        let args = ["render", "--files-within", "scene", "scene/scene.pbrt"];
        place.run(&[&args, more].concat()).code
    };
    let absolute = place.0.path().join("b.exr").display().to_string();
    for file in ["a.exr", "scene/../a.exr", absolute.as_str()] {
        name(file);
        assert_eq!(render(&[]), 2, "{file}");
        let run = place.run(&["check", "--files-within", "scene", "scene/scene.pbrt"]);
        assert!(run.stderr.contains("the image cannot be"), "{}", run.stderr);
        assert_eq!(render(&["-o", "c.exr"]), 0, "{file}");
    }
    assert!(!place.holds("a.exr") && !place.holds("b.exr") && place.holds("c.exr"));
    name("scene/a.exr");
    assert_eq!(render(&[]), 0);
    assert!(Path::new(&place.0.path().join("scene/a.exr")).exists());
}

#[test]
fn files_that_are_no_scenes_are_not_repeated() {
    let place = Place::new();
    // Each directive says what is wrong with the file, and nothing of what is in it.
    for start in ["", "# a comment\n", "\"", "[", "1 2 "] {
        place.write("secret", &format!("{start}{SECRET}:x:0\n{SECRET} 1 1 1\n"));
        place.write("a.pbrt", &scene_that_names("secret"));
        let run = place.run(&["check", "a.pbrt"]);
        assert_eq!(run.code, 2);
        let said = [
            "`secret` is not a scene file",
            "expected a number",
            "is not a lens file",
        ];
        for text in said {
            assert!(run.stderr.contains(text), "{start}: {text}: {}", run.stderr);
        }
    }
    place.write("a.pbrt", "WorldBegin\nMaterial \"measured\" \"string filename\" \"b.brdf\"\nShape \"sphere\"\nWorldEnd\n");
    place.write("b.brdf", &format!("1\n{SECRET}\n"));
    let run = place.run(&["check", "--dialect", "v2", "a.pbrt"]);
    assert!(run.stderr.contains("expected a number"), "{}", run.stderr);
    let run = place.run(&["check", "secret"]);
    assert!(
        run.stderr.contains("`secret` is not a scene file"),
        "{}",
        run.stderr
    );
    // A scene with a misspelled word is told so.
    place.write("a.pbrt", "WorldBegin\nInclude \"part\"\nWorldEnd\n");
    place.write("part", "Shap \"sphere\"\n");
    assert!(place.run(&["check", "a.pbrt"]).stderr.contains("`Shap`"));
}
