//! A file that a scene names.

use super::ParamReader;
use crate::syntax::Span;
use std::path::PathBuf;

/// A file, and where the scene names it: a file that turns out to be broken when it is loaded is
/// reported at the name, like one that is not there.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedFile {
    /// Where the file is.
    pub path: PathBuf,
    /// The string that names it.
    pub span: Span,
}

impl ParamReader<'_> {
    /// As [`ParamReader::named_file`] for a file that may be left out: as in pbrt-v3 an empty name,
    /// which exporters write for want of a file, is as good as none.
    pub fn optional_file(&self, name: &str) -> Option<NamedFile> {
        let given = self.find_string(name)?;
        if given.is_empty() {
            return None;
        }
        self.named_file(name)
    }

    /// [`ParamReader::file`] together with the place of the name.
    pub fn named_file(&self, name: &str) -> Option<NamedFile> {
        let path = self.file(name)?;
        Some(NamedFile {
            path,
            span: self.strings(name)?.first()?.span,
        })
    }
}
