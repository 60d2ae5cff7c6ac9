//! `fstop check SCENE...`: reports every problem of scene files, of what they include and of the meshes and images they
//! name; renders nothing.

use super::ReadArgs;
use super::codes::{BAD_INPUT, IO_FAILED};
use super::messages::{self, Failure};
use crate::console;
use crate::session::Scene;
use clap::Args;
use std::path::{Path, PathBuf};

/// Examples for the long help.
const EXAMPLES: &str = "Examples:
  fstop check scenes/*.pbrt
  fstop check --strict --verbose scene.pbrt";

/// Arguments of `fstop check`.
#[derive(Args, Debug)]
#[command(after_long_help = EXAMPLES)]
pub(super) struct CheckArgs {
    /// Scene files; `-` is standard input
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Also report what only affects noise: which sampler replaces the scene's
    #[arg(short, long, help_heading = "How the scene is read")]
    verbose: bool,
    #[command(flatten)]
    read: ReadArgs,
}

/// Checks every file.
pub(super) fn run(args: &CheckArgs) -> u8 {
    let checked = args.scenes.iter().map(|scene| check(scene, args));
    let codes: Vec<u8> = match checked.collect() {
        Ok(codes) => codes,
        Err(failure) => return Failure::exit(failure),
    };
    // A scene that is wrong everywhere weighs more than one that could not be read here.
    let worst = { codes.iter() }.find(|&&code| code == BAD_INPUT);
    let worst = worst.or(codes.iter().max());
    worst.copied().unwrap_or(0)
}

/// Returns the exit code of one scene: 0 if it is fit to render.
fn check(path: &Path, args: &CheckArgs) -> Result<u8, Failure> {
    let mut options = args.read.options(args.read.policy());
    options.details = args.verbose;
    let problems = Scene::check(path, &options);
    messages::print(&problems);
    let verdict = match problems.refused() {
        false => "ok",
        true => "not fit to render",
    };
    let summary = problems.summary();
    let found = summary.map_or_else(String::new, |found| format!(" ({found})"));
    console::answer(format_args!("{}: {verdict}{found}", path.display()))?;
    Ok(match problems.refused() {
        false => 0,
        true if problems.is_failure() => IO_FAILED,
        true => BAD_INPUT,
    })
}
