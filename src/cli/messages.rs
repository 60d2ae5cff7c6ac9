//! Printing what was found in a scene.

use crate::build;
use crate::console;
use crate::film;
use crate::params::NamedFile;
use crate::scene::{Frame, ReadSettings, SceneDescription, read_scene};
use crate::syntax::{Diagnostic, Diagnostics, SourceMap, Style};
use std::path::Path;

/// Reads a scene; `-` is standard input. No scene where the file itself cannot be read.
pub fn read(
    path: &Path,
    settings: &ReadSettings,
    sources: &SourceMap,
) -> (Option<SceneDescription>, Diagnostics) {
    let main = if path == Path::new("-") {
        sources.open_stdin()
    } else {
        sources.open(path)
    };
    match main {
        Ok(main) => {
            let (scene, diagnostics) = read_scene(sources, main, settings);
            (Some(scene), diagnostics)
        }
        Err(error) => {
            let diagnostics = Diagnostics::new();
            diagnostics.push(Diagnostic::error(error.to_string()));
            (None, diagnostics)
        }
    }
}

/// Adds what only shows when the files of the frames are loaded, and what is wrong with the names
/// of their images.
pub fn examine(frames: &[Frame], sources: &SourceMap, diagnostics: &Diagnostics) {
    for frame in frames {
        if let Some(file) = &frame.options.film.filename {
            if let Err(error) = film::check_name(&file.path) {
                diagnostics.push(Diagnostic::error(error.to_string()).at(file.span));
            }
            check_place(file, sources, diagnostics);
        }
        build::check(frame, diagnostics);
    }
}

/// Reports an image that the scene would have written outside of the only folder it may use.
pub fn check_place(file: &NamedFile, sources: &SourceMap, diagnostics: &Diagnostics) {
    let folder = sources.search_folder(file.span.file);
    if let Err(problem) = folder.admits_output(&file.path) {
        let message = format!("the image cannot be `{}`: {problem}", file.path.display());
        let diagnostic = Diagnostic::error(message).at(file.span);
        diagnostics.push(diagnostic.with_help("name another: -o image.exr"));
    }
}

/// Prints all messages to standard error.
pub fn print(diagnostics: &Diagnostics, sources: &SourceMap) {
    console::say_text(&diagnostics.render(sources, Style::of_stderr()));
}

/// Prints one line of trouble that has no place in a file.
pub fn error(message: impl std::fmt::Display) {
    console::say(format_args!("error: {message}"));
}

/// Prints one line of advice that has no place in a file.
pub fn warning(message: impl std::fmt::Display) {
    console::say(format_args!("warning: {message}"));
}

/// What a scene is refused for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rigor {
    /// Errors.
    Usual,
    /// Warnings too (`--strict`).
    Strict,
    /// Errors, but not those that leave a scene to render (`--keep-going`).
    KeepGoing,
}

/// Must the scene be refused?
pub fn refused(diagnostics: &Diagnostics, rigor: Rigor) -> bool {
    let (errors, warnings) = (diagnostics.errors(), diagnostics.warnings());
    match rigor {
        Rigor::Usual => errors > 0,
        Rigor::Strict => errors + warnings > 0,
        Rigor::KeepGoing => errors > diagnostics.recoverable_errors(),
    }
}
