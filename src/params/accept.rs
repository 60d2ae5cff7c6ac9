//! Parameters that are legal but change nothing here, types nobody knows, and remarks.

use super::ParamReader;
use crate::syntax::{Diagnostic, ParamGroup, suggest};

impl ParamReader<'_> {
    /// A parameter of this name is legal, whatever its type, and has no effect.
    pub fn accept(&self, name: &str) {
        for group in ParamGroup::ALL {
            self.asked.record(name, group);
        }
        for param in self.own.params.iter().filter(|p| p.name == name) {
            param.used.set(true);
        }
    }

    /// Every parameter is legal and without effect: the directive's type is not modelled.
    pub fn accept_all(&self) {
        for param in &self.own.params {
            param.used.set(true);
        }
    }

    /// Says something worth knowing about the directive.
    pub fn note(&self, message: impl Into<String>) {
        self.context
            .diagnostics
            .push(Diagnostic::note(message).at(self.kind_span));
    }

    /// Warns that the directive's type is none of `known` and says what was done instead.
    pub fn unknown_type(&self, known: &[&'static str], done: &str) {
        let message = format!(
            "`{} \"{}\"` is not a known type: {done}",
            self.word,
            self.kind()
        );
        self.context.diagnostics.push(
            Diagnostic::warning(message)
                .at(self.kind_span)
                .with_suggestion(suggest::nearest(self.kind(), known.iter().copied())),
        );
    }
}
