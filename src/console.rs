//! Standard output and standard error, as they are in the wild: closed, full, read by nobody. All that
//! the program prints goes through here; a lint forbids the macros that panic.

use std::fmt::Display;
use std::io::{ErrorKind, Write};

/// Prints a line to standard error. Where that fails there is nobody left to tell, and the work goes on.
pub(crate) fn say(message: impl Display) {
    say_text(&format!("{message}\n"));
}

/// Prints a text to standard error as it is. In one piece, so that lines of several threads or processes do not mix.
pub(crate) fn say_text(text: &str) {
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

/// Prints a result to standard output, with a line end after it. A reader who has left (`| head`) has
/// had enough.
///
/// # Errors
/// The result got lost for any other reason, such as a full disk.
pub(crate) fn answer(result: impl Display) -> Result<(), String> {
    let mut output = std::io::stdout().lock();
    let text = format!("{result}\n");
    delivered(
        output
            .write_all(text.as_bytes())
            .and_then(|()| output.flush()),
    )
}

/// What writing to standard output came to.
///
/// # Errors
/// As of [`answer`].
pub(crate) fn delivered(written: std::io::Result<()>) -> Result<(), String> {
    match written {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(format!("cannot write to standard output: {error}"))
        }
        _ => Ok(()),
    }
}
