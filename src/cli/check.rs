//! `fstop check SCENE...`: every problem of the files, of what they include and of the meshes and
//! pictures they name; nothing is rendered.

use super::{BAD_INPUT, ReadArgs, messages};
use crate::console;
use crate::syntax::SourceMap;
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `fstop check`.
#[derive(Args, Debug)]
pub struct CheckArgs {
    /// Scene files; `-` is standard input
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    #[command(flatten)]
    read: ReadArgs,
}

/// Checks every file; exit code 0 where all are fit to render, else 2.
pub fn run(args: &CheckArgs) -> ExitCode {
    let mut all_fit = true;
    for scene in &args.scenes {
        match check(scene, &args.read) {
            Ok(fit) => all_fit &= fit,
            Err(lost) => {
                messages::error(lost);
                return ExitCode::from(BAD_INPUT);
            }
        }
    }
    if all_fit {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(BAD_INPUT)
    }
}

/// Whether it is fit to render.
fn check(path: &Path, args: &ReadArgs) -> Result<bool, String> {
    let sources = SourceMap::new();
    let (scene, diagnostics) = messages::read(path, &args.settings(), &sources);
    if let Some(scene) = scene {
        messages::examine(&scene.frames, &diagnostics);
    }
    messages::print(&diagnostics, &sources);
    let fit = !messages::refused(&diagnostics, args.rigour());
    let verdict = if fit { "ok" } else { "not fit to render" };
    let summary = diagnostics.summary();
    let found = summary.map_or_else(String::new, |found| format!(" ({found})"));
    console::answer(format_args!("{}: {verdict}{found}", path.display()))?;
    Ok(fit)
}
