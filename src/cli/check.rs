//! `fstop check SCENE...`: reports every problem of scene files, of what they include and of the meshes and images they
//! name; renders nothing.

use super::{BAD_INPUT, ReadArgs, messages};
use crate::console;
use crate::session::Scene;
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

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

/// Checks every file; exit code 0 if all can be rendered, otherwise 2.
pub(super) fn run(args: &CheckArgs) -> ExitCode {
    let mut all_fit = true;
    for scene in &args.scenes {
        match check(scene, args) {
            Ok(fit) => all_fit &= fit,
            Err(lost) => return messages::refused(lost),
        }
    }
    match all_fit {
        true => ExitCode::SUCCESS,
        false => ExitCode::from(BAD_INPUT),
    }
}

/// Returns `true` if it is fit to render.
fn check(path: &Path, args: &CheckArgs) -> Result<bool, String> {
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
    Ok(!problems.refused())
}
