//! The scene language from outside: every directive and form of parameter, recovery, includes,
//! and the messages exactly as they are printed.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

mod includes;
mod language;
mod messages;
mod recovery;
mod wild;

use fstop::syntax::{Diagnostics, Directive, DirectiveKind, FileId, Parser, SourceMap, Style};
use std::path::{Path, PathBuf};

/// What a scene was read as.
struct Read {
    kinds: Vec<DirectiveKind>,
    messages: Vec<String>,
    errors: usize,
    text: String,
}

fn read(scene: impl Into<Vec<u8>>) -> Read {
    let sources = SourceMap::new();
    let file = sources.add_text("scene.pbrt", scene);
    finish(&sources, file)
}

fn read_file(path: &Path) -> Read {
    let sources = SourceMap::new();
    let file = sources.open(path).expect("a readable file");
    finish(&sources, file)
}

fn finish(sources: &SourceMap, file: FileId) -> Read {
    let diagnostics = Diagnostics::new();
    let kinds = Parser::new(sources, file, &diagnostics)
        .map(|directive: Directive| directive.kind)
        .collect();
    Read {
        kinds,
        messages: diagnostics.kept().into_iter().map(|d| d.message).collect(),
        errors: diagnostics.errors(),
        text: diagnostics.render(sources, Style::Plain),
    }
}

/// Some files, gone with the test.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().expect("a temporary folder"));
        for (name, text) in files {
            let path = folder.path(name);
            std::fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
            std::fs::write(path, text).expect("a file");
        }
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Messages with this folder's name, which changes, replaced.
    fn text(&self, read: &Read) -> String {
        read.text
            .replace(&self.0.path().display().to_string(), "FOLDER")
    }
}
