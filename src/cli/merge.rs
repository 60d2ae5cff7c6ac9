//! `fstop merge SHARD... -o OUT`: makes one image of the shards that `render --shard` has left.

use super::codes::{ANSWER_IS_NO, BAD_INPUT, IO_FAILED};
use super::encoding::EncodingArgs;
use super::messages::{self, Failure};
use super::values::file_name;
use crate::console;
use crate::film;
use crate::output;
use crate::session::{MergeError, Merged, Rendered, check_png, merge};
use clap::Args;
use clap::builder::{OsStringValueParser, TypedValueParser};
use std::path::PathBuf;

/// Examples for the long help.
const EXAMPLES: &str = "Examples:
  fstop merge image.shard-*-of-8.fsc -o image.exr --png image.png
  fstop merge image.shard-*-of-8.fsc -o image.exr --plan image.plan";

/// Arguments of `fstop merge`.
#[derive(Args, Debug)]
#[command(after_long_help = EXAMPLES)]
pub(super) struct MergeArgs {
    /// The files of all shards of one render, in any order
    #[arg(required = true, value_name = "SHARD")]
    shards: Vec<PathBuf>,
    /// Image to write (.exr, .png, .pfm, .tga): the bits that one process would have written
    #[arg(help_heading = "Output", short, long = "output", value_name = "OUT", value_parser = OsStringValueParser::new().try_map(file_name), allow_hyphen_values = true)]
    output: PathBuf,
    /// Also write a PNG of the image here
    #[arg(help_heading = "Output", long, value_parser = OsStringValueParser::new().try_map(file_name), allow_hyphen_values = true)]
    png: Option<PathBuf>,
    /// Also write the variance of each pixel's mean (channels var.R, var.G, var.B); it is that of independent samples
    /// unless the shards were rendered with --variance, too
    #[arg(help_heading = "Output", long)]
    variance: bool,
    #[command(flatten)]
    encoding: EncodingArgs,
    /// Make what there is of the image if shards are missing or not finished; pixels without samples are black
    #[arg(help_heading = "What is merged", long)]
    allow_missing: bool,
    /// For `render --error`: if the error is not reached, write here what all shards do next (`render --shard K/N
    /// --plan FILE`), and exit with 1
    #[arg(help_heading = "What is merged", long, value_name = "FILE")]
    plan: Option<PathBuf>,
    /// Print only errors
    #[arg(help_heading = "How it runs", long)]
    quiet: bool,
}

/// Merges.
pub(super) fn run(args: &MergeArgs) -> u8 {
    merged(args).unwrap_or_else(Failure::exit)
}

fn merged(args: &MergeArgs) -> Result<u8, Failure> {
    let outputs = || {
        [Some(&args.output), args.png.as_ref()]
            .into_iter()
            .flatten()
    };
    for path in outputs() {
        film::check_output(path).map_err(|error| Failure::new(&error, error.is_failure()))?;
    }
    args.png.as_deref().map_or(Ok(()), check_png)?;
    if let Some(path) = &args.plan {
        output::check(path)?;
    }
    let files: Vec<&PathBuf> = outputs().chain(&args.plan).collect();
    output::check_apart(&files, &args.shards)?;
    match merge(&args.shards, args.allow_missing, args.variance) {
        Ok(Merged::Image { mut image, plan }) => {
            image.encoding = args.encoding.encoding();
            if !args.quiet {
                let paths = outputs().map(PathBuf::as_path);
                args.encoding.warn_of_names(&paths.collect::<Vec<_>>());
                args.encoding.warn_of_colors(&image.image);
            }
            // For the other frames of the scene, which may need another round.
            if let Some((path, plan)) = args.plan.as_ref().zip(plan) {
                plan.write(path)?;
            }
            write(args, &image, outputs())
        }
        Ok(Merged::Plan { plan, error, goal }) => {
            let error = error.map_or("unknown".to_string(), |e| format!("{:.3} %", 100.0 * e));
            let goal = format!("the error is {error}, the goal is {:.3} %", 100.0 * goal);
            let Some(path) = &args.plan else {
                return Err(format!("{goal}: plan the next round (--plan FILE)").into());
            };
            plan.write(path)?;
            if !args.quiet {
                let next = path.display();
                console::say(format_args!("{goal}: `--plan {next}` for all shards"));
            }
            Ok(ANSWER_IS_NO)
        }
        Err(error @ MergeError::Missing(_)) => {
            messages::error(error);
            console::say("with --allow-missing the others are merged");
            Ok(ANSWER_IS_NO)
        }
        Err(error) => Err(Failure::new(&error, error.is_failure())),
    }
}

fn write<'a>(
    args: &MergeArgs,
    image: &Rendered,
    outputs: impl Iterator<Item = &'a PathBuf>,
) -> Result<u8, Failure> {
    if let Some(dropped) = &image.dropped {
        messages::warning(format!(
            "{} of the samples were negative or not finite, and count as black; the first is {}",
            dropped.count,
            dropped.first()
        ));
    }
    let mut code = 0;
    for path in outputs {
        if let Err(error) = image.write_or_rescue(path) {
            code = if error.is_failure() {
                IO_FAILED
            } else {
                BAD_INPUT
            };
            messages::error(error);
            continue;
        }
        if !args.quiet {
            let (path, shards, spp) = (path.display(), args.shards.len(), image.spp);
            let partial = if image.stopped {
                ", not all of the image"
            } else {
                ""
            };
            console::say(format_args!(
                "{path}: {spp:.1} samples a pixel on average, of {shards} shards{partial}"
            ));
        }
    }
    Ok(code)
}
