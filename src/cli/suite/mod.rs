//! `fstop suite`: many scenes, rendered by any program, compared with references at one false-alarm rate.

mod image;
mod plan;
mod run;
mod update;

use super::messages::Failure;
use clap::{Args, Subcommand};

/// Examples for the long help.
const EXAMPLES: &str = "Examples:
  fstop suite run suite.toml
  fstop suite plan suite.toml --difference 0.5% --block 32";

/// Arguments of `fstop suite`.
#[derive(Args, Debug)]
#[command(after_long_help = EXAMPLES)]
pub(super) struct SuiteArgs {
    #[command(subcommand)]
    action: Action,
}

#[derive(Subcommand, Debug)]
enum Action {
    /// Render the scenes, compare their images with the references, and write reports
    Run(run::RunArgs),
    /// Say how many samples it takes to find a difference
    Plan(plan::PlanArgs),
}

/// Runs it.
pub(super) fn run(args: &SuiteArgs) -> u8 {
    let done = match &args.action {
        Action::Run(args) => run::run(args),
        Action::Plan(args) => plan::run(args),
    };
    done.unwrap_or_else(Failure::exit)
}
