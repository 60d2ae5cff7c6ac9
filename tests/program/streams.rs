//! Standard output and standard error that are full or that nobody reads: no image is lost for
//! it, and no answer is taken for a yes that was never read.

use super::cli::{Folder, LENS, OBJECTS, command, load};
use std::ffi::OsString;
use std::fs::OpenOptions;
use std::path::Path;
use std::process::{Command, Stdio};

/// What becomes of a stream.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fate {
    Read,
    /// Every write fails: no space left on the device.
    Full,
    /// Every write fails: the reader of the pipe has gone.
    Closed,
}

impl Fate {
    fn stream(self) -> Stdio {
        match self {
            Fate::Read => Stdio::null(),
            Fate::Full => {
                let full = OpenOptions::new().write(true).open("/dev/full");
                full.expect("the device").into()
            }
            Fate::Closed => {
                let (reader, writer) = std::io::pipe().expect("a pipe");
                drop(reader);
                writer.into()
            }
        }
    }
}

/// The exit code of `fstop ARGUMENTS` with its streams so treated.
fn code(arguments: &[OsString], out: Fate, err: Fate) -> Option<i32> {
    let status = Command::new(env!("CARGO_BIN_EXE_fstop"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .stdout(out.stream())
        .stderr(err.stream())
        .status();
    status.expect("the program starts").code()
}

fn words(line: &str) -> Vec<OsString> {
    line.split(' ').map(OsString::from).collect()
}

/// Commands that print to standard error what they have to say, with the codes they end with.
#[test]
fn a_lost_standard_error_changes_nothing() {
    let folder = Folder::new();
    for err in [Fate::Full, Fate::Closed] {
        for (scene, options) in [
            (OBJECTS, vec!["--spp", "1"]),
            (
                OBJECTS,
                vec!["--spp", "1", "--threads", "100000", "--variance"],
            ),
            (OBJECTS, vec!["--error", "50%"]),
            (LENS, vec!["--spp", "1"]),
        ] {
            let picture = folder.path("a.exr");
            let arguments = command("render", scene, &picture, &options);
            assert_eq!(code(&arguments, err, err), Some(0), "{arguments:?}");
            let size = std::fs::metadata(&picture).map(|m| m.len()).unwrap_or(0);
            assert!(size > 500, "{arguments:?} left no image");
            std::fs::remove_file(&picture).expect("the image");
        }
        let unfit = "tests/scenes/invalid/missing_files.pbrt";
        assert!(Path::new(env!("CARGO_MANIFEST_DIR")).join(unfit).exists());
        for (line, expected) in [
            (format!("render {unfit}"), 2),
            (format!("check {unfit} {OBJECTS}"), 2),
            (format!("check {OBJECTS}"), 0),
            ("lens lenses/dgauss.50mm.dat --aperture 1e9".to_owned(), 0),
            ("lens nowhere.dat".to_owned(), 2),
            ("compare nowhere.exr nowhere.exr".to_owned(), 2),
            ("tradeoff nowhere.pbrt".to_owned(), 2),
            ("render --nonsense".to_owned(), 2),
        ] {
            assert_eq!(
                code(&words(&line), Fate::Read, err),
                Some(expected),
                "{line}"
            );
        }
    }
}

/// Results on standard output: a reader who has left has had enough; a full disk is an error.
#[test]
fn a_lost_standard_output_is_no_answer() {
    let folder = Folder::new();
    folder.render(OBJECTS, "a.exr", &["--spp", "1"]);
    folder.render(LENS, "b.exr", &["--spp", "1"]);
    let compared = |a: &str, b: &str, option: &str| -> Vec<OsString> {
        let mut arguments = vec!["compare".into()];
        arguments.extend([folder.path(a).into(), folder.path(b).into(), option.into()]);
        arguments
    };
    let mut brightened = load(&folder.path("a.exr")).image;
    for pixel in &mut brightened.pixels {
        *pixel = *pixel * 2.0 + 1.0;
    }
    fstop::film::write(
        &folder.path("bright.exr"),
        &brightened,
        &fstop::film::FilmMetadata::default(),
    )
    .expect("an image");
    for (arguments, read) in [
        (compared("a.exr", "a.exr", "--json"), 0),
        (compared("a.exr", "a.exr", "--no-flip"), 0),
        (compared("a.exr", "bright.exr", "--json"), 1),
        (words(&format!("check {OBJECTS} {OBJECTS}")), 0),
        (words("lens lenses/dgauss.50mm.dat lenses/wide.22mm.dat"), 0),
        (words("lens lenses/dgauss.50mm.dat --json"), 0),
        (words(&format!("tradeoff {OBJECTS} --time 0.1 --quiet")), 0),
        (words(&format!("tradeoff {OBJECTS} --time 0.1 --json")), 0),
        (words("--help"), 0),
        (words("render --help"), 0),
        (words("--version"), 0),
    ] {
        for err in [Fate::Read, Fate::Full] {
            assert_eq!(
                code(&arguments, Fate::Read, err),
                Some(read),
                "{arguments:?}"
            );
            assert_eq!(
                code(&arguments, Fate::Closed, err),
                Some(read),
                "{arguments:?}"
            );
            assert_eq!(code(&arguments, Fate::Full, err), Some(74), "{arguments:?}");
        }
    }
}

/// The page is a result of its own: it is there even where the text has nowhere to go.
#[test]
fn files_are_written_although_standard_output_is_lost() {
    let folder = Folder::new();
    let page = folder.path("lens.html");
    let mut arguments = words("lens lenses/dgauss.50mm.dat --report");
    arguments.push(page.clone().into());
    assert_eq!(code(&arguments, Fate::Full, Fate::Read), Some(74));
    assert!(page.exists());
    let page = folder.path("tradeoff.html");
    let mut arguments = words(&format!("tradeoff {OBJECTS} --time 0.1 --quiet --html"));
    arguments.push(page.clone().into());
    assert_eq!(code(&arguments, Fate::Full, Fate::Read), Some(74));
    assert!(page.exists());
}

/// Rayon's variable is no way to a hundred thousand threads.
#[test]
fn a_variable_does_not_choose_the_threads() {
    let folder = Folder::new();
    let image = folder.path("a.exr");
    let mut compare = words("compare --no-flip");
    let render = command("render", OBJECTS, &image, &["--spp", "1"]);
    compare.extend([image.clone().into(), image.into()]);
    for arguments in [
        render,
        compare,
        words(&format!("check {OBJECTS}")),
        words("lens lenses/wide.22mm.dat --analysis"),
        words(&format!("tradeoff {OBJECTS} --time 0.1")),
    ] {
        let started = std::time::Instant::now();
        let run = Command::new(env!("CARGO_BIN_EXE_fstop"))
            .args(&arguments)
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .env("RAYON_NUM_THREADS", "100000")
            .output()
            .expect("the program starts");
        let said = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(0), "{arguments:?}\n{said}");
        assert!(started.elapsed().as_secs() < 60, "{arguments:?}");
    }
}
