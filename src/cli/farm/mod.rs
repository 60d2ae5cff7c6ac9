//! `fstop farm ENGINE`: what a render farm needs to render an image in shards.

mod slurm;

use clap::{Args, Subcommand};

/// Examples for the long help.
const EXAMPLES: &str = "Examples:
  fstop farm slurm scene.pbrt --shards 64 -o image.exr --time 4:00:00 --requeue
  fstop farm slurm scene.pbrt --shards 16 --cpus 8 --mem 12G -- --spp 4096";

/// Arguments of `fstop farm`.
#[derive(Args, Debug)]
#[command(after_long_help = EXAMPLES)]
pub(super) struct FarmArgs {
    #[command(subcommand)]
    engine: Engine,
}

#[derive(Subcommand, Debug)]
enum Engine {
    /// Write two sbatch scripts: a job array that renders the shards, and a job that merges them
    Slurm(slurm::SlurmArgs),
}

/// Writes the engine's files.
pub(super) fn run(args: &FarmArgs) -> u8 {
    match &args.engine {
        Engine::Slurm(args) => slurm::run(args),
    }
}
