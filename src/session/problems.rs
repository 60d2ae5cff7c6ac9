//! What was found in a scene, for people.

use super::Policy;
use crate::syntax::{Diagnostic, Diagnostics, Severity, SourceMap, Style};
use std::fmt;

/// All messages about a scene, each with its line and a caret; no messages where all is well. As an error: why a scene
/// is not rendered.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Problems {
    messages: Vec<(Severity, String)>,
    plain: String,
    colored: String,
    summary: Option<String>,
    errors: usize,
    recoverable: usize,
    refused: bool,
    is_failure: bool,
}

impl Problems {
    pub(crate) fn new(diagnostics: &Diagnostics, sources: &SourceMap, policy: Policy) -> Problems {
        Problems {
            messages: diagnostics.messages(sources, Style::Plain),
            plain: diagnostics.render(sources, Style::Plain),
            colored: diagnostics.render(sources, Style::Colored),
            summary: diagnostics.summary(),
            errors: diagnostics.errors(),
            recoverable: diagnostics.recoverable_errors(),
            refused: policy.refuses(diagnostics),
            is_failure: policy.refuses(diagnostics)
                && diagnostics.errors() == diagnostics.failures()
                && (policy != Policy::Warnings || diagnostics.warnings() == 0),
        }
    }

    /// An error without a place in a file.
    pub(super) fn one(message: impl Into<String>) -> Problems {
        Problems::one_of(Diagnostic::error(message))
    }

    /// As [`Problems::one`]; `is_failure` says that of another machine or at another time it might not be true.
    pub(super) fn one_if(message: impl Into<String>, is_failure: bool) -> Problems {
        Problems::one_of(Diagnostic::error(message).failed_if(is_failure))
    }

    fn one_of(diagnostic: Diagnostic) -> Problems {
        let diagnostics = Diagnostics::new();
        diagnostics.push(diagnostic);
        Problems::new(&diagnostics, &SourceMap::new(), Policy::Errors)
    }

    /// Returns `true` if there is nothing to say.
    pub fn is_empty(&self) -> bool {
        self.plain.is_empty()
    }

    /// Number of errors, forgiven ones among them.
    pub fn errors(&self) -> usize {
        self.errors
    }

    /// Number of errors after which pbrt-v3 continues, and `Policy::KeepGoing` too.
    pub fn recoverable_errors(&self) -> usize {
        self.recoverable
    }

    /// Returns `true` if the policy that the scene was read with refuses it.
    pub fn refused(&self) -> bool {
        self.refused
    }

    /// Returns `true` if the scene is refused for nothing but input or output that failed, as when a disk is full or a
    /// server does not answer: the same render may succeed on another machine.
    pub fn is_failure(&self) -> bool {
        self.is_failure
    }

    /// Such as `2 errors and 1 warning`; `None` where there is neither.
    pub fn summary(&self) -> Option<&str> {
        self.summary.as_deref()
    }

    /// The messages one by one, as plain text.
    pub(crate) fn messages(&self) -> &[(Severity, String)] {
        &self.messages
    }

    /// The messages with ANSI colors, for a terminal.
    pub fn colored(&self) -> &str {
        &self.colored
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.plain)
    }
}

impl std::error::Error for Problems {}
