//! `fstop check SCENE...`: reports every problem of scene files, of what they include and of the meshes and images they
//! name; renders nothing.

use super::ReadArgs;
use super::codes::{BAD_INPUT, IO_FAILED};
use super::messages::{self, Failure};
use crate::console;
use crate::session::{Bytes, MemoryStage, MemoryUse, Process, ReadOptions, Scene};
use clap::Args;
use std::fmt::Write;
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
    /// Forecast the memory that `fstop render` will take, instead of loading meshes and images: by their headers
    #[arg(long, help_heading = "Output")]
    memory: bool,
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
    if args.memory {
        return forecast(path, &options);
    }
    let problems = Scene::check(path, &options);
    messages::print(&problems);
    let verdict = match problems.refused() {
        false => "ok",
        true if problems.errors() == 0 => "not fit to render with --strict",
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

/// Prints what rendering a scene will take.
fn forecast(path: &Path, options: &ReadOptions) -> Result<u8, Failure> {
    let before = Process::measured();
    let scene = Scene::load(path, options)?;
    messages::print(scene.problems());
    let forecasts = scene.forecasts(&before)?;
    // Frames are rendered one after the other.
    let largest = forecasts
        .iter()
        .max_by_key(|forecast| forecast.peak.total());
    let Some(forecast) = largest else {
        return Ok(BAD_INPUT);
    };
    let mut text = format!(
        "{}: memory at most, {}\n",
        path.display(),
        forecast.peak.when
    );
    text += &table(&forecast.peak);
    for (with, stage) in [
        ("all, with --variance", &forecast.with_variance),
        ("all, with --error or --time", &forecast.in_passes),
    ] {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  {with:<42} {:>10}",
            Bytes(stage.total()).to_string()
        );
    }
    console::answer(text.trim_end())?;
    Ok(0)
}

/// What there is at one time, one use a line.
fn table(stage: &MemoryStage) -> String {
    let mut text = String::new();
    let used = { MemoryUse::ALL.iter().zip(stage.bytes) }.filter(|(_, bytes)| *bytes > 0);
    for (part, bytes) in used {
        let _ = writeln!(
            text,
            "  {:<42} {:>10}",
            name(*part),
            Bytes(bytes).to_string()
        );
    }
    let _ = writeln!(
        text,
        "  {:<42} {:>10}",
        "all",
        Bytes(stage.total()).to_string()
    );
    text
}

fn name(part: MemoryUse) -> &'static str {
    match part {
        MemoryUse::Program => "program",
        MemoryUse::Description => "the scene as it was read",
        MemoryUse::Images => "images",
        MemoryUse::Shapes => "meshes, quadrics, curves, instances",
        MemoryUse::Trees => "trees (upper bound)",
        MemoryUse::Lights => "lights that shapes form (upper bound)",
        MemoryUse::Film => "film",
    }
}
