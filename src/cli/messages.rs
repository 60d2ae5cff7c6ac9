//! Printing what was found in a scene, and what went wrong.

use super::codes::{BAD_INPUT, IO_FAILED};
use crate::compare::CompareError;
use crate::console::{self, Level};
use crate::optics::PrescriptionError;
use crate::output::OutputError;
use crate::session::{DenoiseError, FileError, Problems};
use crate::syntax::{Severity, Style};

/// Why a command ends without a result.
pub(super) enum Failure {
    /// The scene is refused.
    Scene(Box<Problems>),
    /// Input or output that failed here, in one line.
    Io(String),
    /// Anything else, in one line.
    Other(String),
}

impl Failure {
    pub(super) fn new(message: impl ToString, is_io: bool) -> Failure {
        match is_io {
            true => Failure::Io(message.to_string()),
            false => Failure::Other(message.to_string()),
        }
    }

    /// What there is to say, as plain text.
    pub(super) fn text(&self) -> String {
        match self {
            Failure::Scene(problems) => problems.to_string(),
            Failure::Io(message) | Failure::Other(message) => message.clone(),
        }
    }

    /// Says more, such as which file it is about.
    pub(super) fn said(self, say: impl FnOnce(String) -> String) -> Failure {
        match self {
            Failure::Scene(problems) => Failure::Scene(problems),
            Failure::Io(message) => Failure::Io(say(message)),
            Failure::Other(message) => Failure::Other(say(message)),
        }
    }
}

impl From<console::Lost> for Failure {
    fn from(lost: console::Lost) -> Failure {
        Failure::new(lost, true)
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Failure {
        Failure::new(&error, error.is_failure())
    }
}

impl From<DenoiseError> for Failure {
    fn from(error: DenoiseError) -> Failure {
        // Another machine may have the library.
        Failure::new(&error, true)
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Failure {
        Failure::new(&error, error.is_failure)
    }
}

impl From<PrescriptionError> for Failure {
    fn from(error: PrescriptionError) -> Failure {
        Failure::new(&error, error.is_failure())
    }
}

impl From<CompareError> for Failure {
    fn from(error: CompareError) -> Failure {
        Failure::Other(error.to_string())
    }
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
    /// Prints the reason, and returns the exit code.
    pub(super) fn exit(self) -> u8 {
        let code = self.code();
        match self {
            Failure::Scene(problems) => {
                print(&problems);
                if problems.errors() == 0 {
                    error("refused because of --strict, which treats warnings as errors");
                }
            }
            Failure::Io(message) | Failure::Other(message) => error(message),
        }
        code
    }

    fn code(&self) -> u8 {
        match self {
            Failure::Scene(problems) if problems.is_failure() => IO_FAILED,
            Failure::Io(_) => IO_FAILED,
            Failure::Scene(_) | Failure::Other(_) => BAD_INPUT,
        }
    }
}

/// Prints all messages to standard error.
pub(super) fn print(problems: &Problems) {
    if console::is_json() {
        let say = |(severity, text): &(Severity, String)| {
            let level = match severity {
                Severity::Error => Level::Error,
                Severity::Warning => Level::Warning,
                Severity::Note => Level::Note,
            };
            console::say_json(level, text);
        };
        return problems.messages().iter().for_each(say);
    }
    match Style::of_stderr() {
        Style::Plain => console::say_text(&problems.to_string()),
        Style::Colored => console::say_text(problems.colored()),
    }
}

/// Prints one line of trouble that has no place in a file.
pub(super) fn error(message: impl std::fmt::Display) {
    console::say_trouble(Level::Error, message);
}

/// Prints one line of advice that has no place in a file.
pub(super) fn warning(message: impl std::fmt::Display) {
    console::say_trouble(Level::Warning, message);
}
