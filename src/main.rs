//! The `fstop` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    fstop::cli::run(std::env::args_os())
}
