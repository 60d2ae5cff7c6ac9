//! `fstop lens LENS`.

use super::BAD_INPUT;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `fstop lens`.
#[derive(Args, Debug)]
pub struct LensArgs {
    /// Lens prescription (.dat)
    lens: PathBuf,
}

pub fn run(_args: &LensArgs) -> ExitCode {
    ExitCode::from(BAD_INPUT)
}
