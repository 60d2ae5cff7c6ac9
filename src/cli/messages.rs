//! Printing what was found in a scene, and what went wrong.

use super::BAD_INPUT;
use crate::console;
use crate::session::Problems;
use crate::syntax::Style;
use std::process::ExitCode;

/// Why a command ends without a result.
pub(super) enum Failure {
    /// The scene is refused.
    Scene(Box<Problems>),
    /// Anything else, in one line.
    Other(String),
}

impl From<Problems> for Failure {
    fn from(problems: Problems) -> Failure {
        Failure::Scene(Box::new(problems))
    }
}

impl From<String> for Failure {
    fn from(message: String) -> Failure {
        Failure::Other(message)
    }
}

impl Failure {
    /// Prints the reason.
    pub(super) fn exit(self) -> ExitCode {
        match self {
            Failure::Scene(problems) => print(&problems),
            Failure::Other(message) => error(message),
        }
        ExitCode::from(BAD_INPUT)
    }
}

/// Prints why a command ends without a result.
pub(super) fn refused(message: String) -> ExitCode {
    error(message);
    ExitCode::from(BAD_INPUT)
}

/// Prints all messages to standard error.
pub(super) fn print(problems: &Problems) {
    match Style::of_stderr() {
        Style::Plain => console::say_text(&problems.to_string()),
        Style::Colored => console::say_text(problems.colored()),
    }
}

/// Prints one line of trouble that has no place in a file.
pub(super) fn error(message: impl std::fmt::Display) {
    console::say(format_args!("error: {message}"));
}

/// Prints one line of advice that has no place in a file.
pub(super) fn warning(message: impl std::fmt::Display) {
    console::say(format_args!("warning: {message}"));
}
