//! Unknown and unsupported types.
//!
//! What is done about them follows pbrt-v3 where that makes an image (docs/scene-language.md §2.3, §3.8,
//! §3.9): a warning says what was put in their place. Where pbrt-v3 makes none, it is an error.
//! Either way the parameters are left in peace: nobody can say which of them the type would use.

use super::ParamReader;
use super::{Dialect, iset3d, v2, v4};
use crate::syntax::{Diagnostic, ParamType, suggest};

impl ParamReader<'_> {
    /// Reports an error: the directive's type is none of `known`, and nothing can take its place.
    pub fn unknown_kind(&self, known: &[&'static str]) {
        let message = format!("{} is not a known type", self.described());
        self.report_kind(self.new_error(message), known);
    }

    /// Warns that the directive's type is none of `known`, and says what was `done` about it.
    pub fn unknown_kind_replaced(&self, known: &[&'static str], done: &str) {
        let message = format!("{} is not a known type: {done}", self.described());
        self.report_kind(Diagnostic::warning(message), known);
    }

    /// Warns that the directive's type is not modeled yet, and says what was `done` about it.
    pub fn unsupported_kind(&self, done: &str) {
        let message = format!("{} is not supported yet: {done}", self.described());
        self.report_kind(Diagnostic::warning(message), &[]);
    }

    fn report_kind(&self, diagnostic: Diagnostic, known: &[&'static str]) {
        self.accept_all();
        let suggestion = suggest::nearest(self.kind(), known.iter().copied());
        let diagnostic = diagnostic.at(self.kind_span());
        self.context
            .diagnostics
            .push(if ParamType::declares(self.kind()) {
                let (word, kind) = (self.word(), self.kind());
                diagnostic.with_help(format!(
                "`{kind}` looks like a parameter: is the type of this `{word}` missing before it?"
            ))
            } else if let Some(note) = v4::note(self.word(), self.kind()) {
                self.context.diagnostics.looks_like_v4();
                diagnostic.with_note(note)
            } else if let Some(note) =
                v2::note(self.word(), self.kind()).filter(|_| self.dialect() == Dialect::V3)
            {
                diagnostic.with_note(note)
            } else if let Some(note) = iset3d::note(self.word(), self.kind()) {
                diagnostic.with_note(note)
            } else if suggestion.is_none() && !known.is_empty() {
                diagnostic.with_note(format!("known types: {}", known.join(", ")))
            } else {
                diagnostic.with_suggestion(suggestion)
            });
    }
}
