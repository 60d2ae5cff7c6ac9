//! Parameters that are legal but change nothing here, and remarks.

use super::ParamReader;
use crate::syntax::{Diagnostic, ParamGroup};

impl ParamReader<'_> {
    /// A parameter of this name is legal, whatever its type, and has no effect.
    pub fn accept(&self, name: &str) {
        if !self.offers(name) {
            return;
        }
        for group in ParamGroup::ALL {
            self.asked.record(name, group);
        }
        for param in self.own.params.iter().filter(|p| p.name == name) {
            param.used.set(true);
        }
    }

    /// Every parameter is legal and without effect: the directive's type is not modeled.
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
}
