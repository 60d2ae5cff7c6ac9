//! The `fstop` command-line program.

use std::process::ExitCode;

fn main() -> ExitCode {
    fstop::cli::run(std::env::args_os())
}
