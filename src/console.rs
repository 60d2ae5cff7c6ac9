//! Standard output and standard error, which may be closed or full. Everything the program prints goes through here; a
//! lint forbids the macros that panic.

use serde_json::json;
use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// `true` if every line of standard error is JSON, for programs. The stream is the process's, and so is this.
static JSON: AtomicBool = AtomicBool::new(false);

/// From now on messages are JSON, one object a line.
pub(crate) fn speak_json() {
    JSON.store(true, Relaxed);
}

/// Returns `true` if messages are JSON.
pub(crate) fn is_json() -> bool {
    JSON.load(Relaxed)
}

/// How much a message matters.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Level {
    Error,
    Warning,
    Note,
}

impl Level {
    fn word(self) -> &'static str {
        match self {
            Level::Error => "error",
            Level::Warning => "warning",
            Level::Note => "note",
        }
    }
}

/// Prints a line to standard error. A failure is ignored: there is nowhere to report it, and work continues.
pub(crate) fn say(message: impl Display) {
    match is_json() {
        true => say_json(Level::Note, &message.to_string()),
        false => say_text(&format!("{message}\n")),
    }
}

/// Prints a line of trouble that has no place in a file.
pub(crate) fn say_trouble(level: Level, message: impl Display) {
    match is_json() {
        true => say_json(level, &message.to_string()),
        false => say_text(&format!("{}: {message}\n", level.word())),
    }
}

/// Prints a message for programs.
pub(crate) fn say_json(level: Level, text: &str) {
    let event = json!({"event": "message", "level": level.word(), "text": text});
    say_text(&format!("{event}\n"));
}

/// Prints a text to standard error unchanged, in one write, so that lines of several threads or processes do not mix.
pub(crate) fn say_text(text: &str) {
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

/// A result that did not reach standard output.
#[derive(Debug, thiserror::Error)]
#[error("cannot write to standard output: {0}")]
pub(crate) struct Lost(std::io::Error);

/// Prints a result to standard output, followed by a line break. A closed pipe (`| head`) is not an error.
///
/// # Errors
/// Fails if the result is lost for any other reason, such as a full disk.
pub(crate) fn answer(result: impl Display) -> Result<(), Lost> {
    let mut output = std::io::stdout().lock();
    let text = format!("{result}\n");
    delivered(
        output
            .write_all(text.as_bytes())
            .and_then(|()| output.flush()),
    )
}

/// The outcome of writing to standard output.
///
/// # Errors
/// As for [`answer`].
pub(crate) fn delivered(written: std::io::Result<()>) -> Result<(), Lost> {
    match written {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Lost(error)),
        _ => Ok(()),
    }
}
