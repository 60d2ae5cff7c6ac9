//! Running the built `fstop` as a user would, from the project's folder so that paths in messages
//! do not depend on where the project lies, and comparing what it prints with what was recorded.

use std::path::{Path, PathBuf};
use std::process::Command;

/// What a run of the program left behind.
pub(crate) struct Run {
    /// Exit code; a signal counts as a failure of the test.
    pub code: i32,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

/// Runs `fstop` with the arguments in the project's folder.
pub(crate) fn fstop<A: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = A>) -> Run {
    fstop_in(Path::new(env!("CARGO_MANIFEST_DIR")), arguments)
}

/// Runs `fstop` with the arguments in a folder.
pub(crate) fn fstop_in<A: AsRef<std::ffi::OsStr>>(
    folder: &Path,
    arguments: impl IntoIterator<Item = A>,
) -> Run {
    let output = Command::new(env!("CARGO_BIN_EXE_fstop"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Run {
        code: output.status.code().expect("not ended by a signal"),
        stdout: text(&output.stdout),
        stderr: text(&output.stderr),
    }
}

/// The scene files of `tests/scenes/KIND`, sorted, relative to the project's folder.
pub(crate) fn scenes(kind: &str) -> Vec<PathBuf> {
    let folder = Path::new("tests/scenes").join(kind);
    let absolute = Path::new(env!("CARGO_MANIFEST_DIR")).join(&folder);
    let mut scenes: Vec<PathBuf> = std::fs::read_dir(&absolute)
        .expect("a folder of scenes")
        .map(|entry| folder.join(entry.expect("an entry").file_name()))
        .filter(|path| path.extension().is_some_and(|ending| ending == "pbrt"))
        .collect();
    scenes.sort();
    scenes
}

/// Compares `text` with what is recorded beside the scene as `NAME.expected`; no file stands for
/// no text. With `FSTOP_BLESS=1` the text is recorded instead. Returns what is wrong, if anything.
pub(crate) fn differs_from_recorded(scene: &Path, text: &str) -> Option<String> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(scene.with_extension("expected"));
    if std::env::var_os("FSTOP_BLESS").is_some_and(|value| value == "1") {
        let done = match (text.is_empty(), file.exists()) {
            (true, true) => std::fs::remove_file(&file),
            (true, false) => Ok(()),
            (false, _) => std::fs::write(&file, text),
        };
        done.expect("a writable file");
        return None;
    }
    let expected = std::fs::read_to_string(&file).unwrap_or_default();
    (text != expected).then(|| {
        format!(
            "{}\n--- recorded\n{expected}\n--- found\n{text}\n(FSTOP_BLESS=1 records it anew)",
            scene.display()
        )
    })
}

/// Returns `true` if a signal, such as `-INT`, ends what these tests start and has no handler: they may have been started to ignore it.
#[cfg(unix)]
pub(crate) fn is_heard(signal: &str) -> bool {
    let kill = format!("kill {signal} $$");
    let ended = std::process::Command::new("sh")
        .args(["-c", &kill])
        .status();
    ended.is_ok_and(|status| status.code().is_none())
}
