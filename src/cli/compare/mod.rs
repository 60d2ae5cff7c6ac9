//! `fstop compare A B`: tests whether two images agree.

mod input;
mod json;
mod page;
mod raster;
mod text;

use super::codes::ANSWER_IS_NO;
use super::messages::Failure;
use crate::compare::flip::{self, ExposureRange, FlipMap, PIXELS_PER_DEGREE};
use crate::compare::{
    Comparison, Correction, Estimate, Noise, Options, compare, non_finite, p_values,
};
use crate::console;
use crate::output;
use clap::{Args, ValueEnum};
use input::Input;
use std::path::PathBuf;

/// Examples for the long help.
const EXAMPLES: &str = "Examples:
  fstop compare image.exr reference.exr
  fstop compare a.exr b.exr --json --html page.html";

/// Arguments of `fstop compare`.
#[derive(Args, Debug)]
#[command(after_long_help = EXAMPLES)]
pub(super) struct CompareArgs {
    /// Image (.exr, .pfm, .hdr; .png, .tga, .jpg are taken for sRGB)
    #[arg(value_name = "A")]
    a: PathBuf,
    /// Image to compare with: the reference
    #[arg(value_name = "B")]
    b: PathBuf,
    /// Print JSON instead of text
    #[arg(help_heading = "Output", long)]
    json: bool,
    /// Write one self-contained page with both images, their differences and all metrics
    #[arg(help_heading = "Output", long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Maximum probability that images with the same expectation are reported as different
    #[arg(help_heading = "How they are compared", long, value_name = "P", default_value_t = Options::default().alpha, value_parser = probability, allow_negative_numbers = true)]
    alpha: f64,
    /// Sides of the pixel blocks that are tested, besides single pixels and the whole
    #[arg(help_heading = "How they are compared", long, value_name = "PX", value_delimiter = ',', default_values_t = [8, 32], value_parser = clap::value_parser!(u32).range(2..))]
    tile: Vec<u32>,
    /// How the probability is divided among the tests
    #[arg(help_heading = "How they are compared", long, value_enum, default_value_t = CorrectionArg::Holm)]
    correction: CorrectionArg,
    /// Relative difference to ignore
    #[arg(help_heading = "How they are compared", long, value_name = "REL", default_value_t = Options::default().relative_tolerance, value_parser = tolerance, allow_negative_numbers = true)]
    tolerance: f64,
    /// Source of the noise estimate
    #[arg(help_heading = "How they are compared", long, value_enum, default_value_t = NoiseArg::Auto)]
    noise: NoiseArg,
    /// Noise estimated from the difference: side of the squares of pixels that are independent of each other, the
    /// filter's width where samples are splatted
    #[arg(help_heading = "How they are compared", long, value_name = "PX", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    cell: u32,
    /// Plain Welch's test, without the common variance that guards against rare bright samples
    #[arg(help_heading = "How they are compared", long)]
    plain_welch: bool,
    /// Skip FLIP, which takes the longest
    #[arg(help_heading = "How they are compared", long)]
    no_flip: bool,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum CorrectionArg {
    /// Holm's: valid however tests depend on each other
    Holm,
    /// Šidák's: slightly more powerful
    Sidak,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum NoiseArg {
    /// Variances in the files if there are any, otherwise as spatial
    Auto,
    /// Variances in the files, or an error
    Stored,
    /// The scatter of the difference within blocks
    Spatial,
    /// No noise: images of the same seed, drawings
    None,
}

fn probability(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(p) if p > 0.0 && p < 1.0 => Ok(p),
        _ => Err("expected a probability above 0 and below 1".to_owned()),
    }
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if (0.0..=1.0).contains(&x) => Ok(x),
        _ => Err("expected a fraction from 0 to 1".to_owned()),
    }
}

impl CompareArgs {
    fn options(&self) -> Options {
        Options {
            alpha: self.alpha,
            blocks: std::iter::once(1)
                .chain(self.tile.iter().copied())
                .collect(),
            relative_tolerance: self.tolerance,
            correction: match self.correction {
                CorrectionArg::Holm => Correction::Holm,
                CorrectionArg::Sidak => Correction::Sidak,
            },
            noise: match self.noise {
                NoiseArg::Auto => Noise::Auto,
                NoiseArg::Stored => Noise::Stored,
                NoiseArg::Spatial => Noise::Spatial,
                NoiseArg::None => Noise::None,
            },
            cell: self.cell,
            common_variance: !self.plain_welch,
        }
    }
}

/// The whole report.
struct Report {
    inputs: [Input; 2],
    comparison: Comparison,
    flip: Option<Flip>,
}

/// Both kinds of FLIP.
struct Flip {
    /// As displayed at exposure 0.
    ldr: FlipMap,
    /// Over the reference's range of exposures; `None` if both images are LDR anyway.
    hdr: Option<(ExposureRange, FlipMap)>,
}

/// Compares two images.
pub(super) fn run(args: &CompareArgs) -> u8 {
    match report(args) {
        Ok(true) => 0,
        Ok(false) => ANSWER_IS_NO,
        Err(failure) => failure.exit(),
    }
}

/// Prints the report; returns `true` if the images agree.
fn report(args: &CompareArgs) -> Result<bool, Failure> {
    if let Some(file) = &args.html {
        output::check(file)?;
    }
    let inputs = input::read_pair(&args.a, &args.b)?;
    let options = args.options();
    let [a, b] = inputs.each_ref().map(|input| Estimate::of(&input.loaded));
    let comparison = compare(&a, &b, &options).map_err(|e| e.to_string())?;
    let p = args.html.is_some().then(|| p_values(&a, &b, &options));
    let p = p.transpose().map_err(|e| e.to_string())?;
    let flip = (!args.no_flip).then(|| see(&inputs));
    let report = Report {
        inputs,
        comparison,
        flip,
    };
    if let (Some(file), Some(p)) = (&args.html, p) {
        output::write(file, page::html(&report, &p).as_bytes())?;
    }
    let said = if args.json {
        json::text(&report)?
    } else {
        text::text(&report)
    };
    console::answer(said)?;
    Ok(report.comparison.agrees())
}

/// FLIP, for images whose non-finite pixels are black in both.
fn see(inputs: &[Input; 2]) -> Flip {
    let [a, b] = inputs.each_ref().map(|input| &input.loaded.image);
    let (clean_a, clean_b, _) = non_finite::clean(a, b);
    let (a, b) = (clean_a.as_ref().unwrap_or(a), clean_b.as_ref().unwrap_or(b));
    Flip {
        ldr: flip::ldr(a, b, PIXELS_PER_DEGREE),
        hdr: inputs.iter().any(|input| !input.srgb).then(|| {
            let exposures = ExposureRange::of(b);
            (exposures, flip::hdr(a, b, &exposures, PIXELS_PER_DEGREE))
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_out_of_range_are_refused() {
        for text in ["0", "1", "-0.1", "nan", "x", ""] {
            assert!(probability(text).is_err(), "{text}");
        }
        assert_eq!(probability("1e-4"), Ok(1e-4));
        for text in ["-1e-9", "1.5", "nan", "inf", ""] {
            assert!(tolerance(text).is_err(), "{text}");
        }
        assert_eq!((tolerance("0"), tolerance("1")), (Ok(0.0), Ok(1.0)));
    }
}
