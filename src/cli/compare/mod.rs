//! `fstop compare A B`: tests whether two images agree, or all those of two folders.

pub(super) mod folders;
pub(super) mod input;
pub(super) mod json;
mod page;
mod raster;
mod text;

use super::codes::{ANSWER_IS_NO, CANNOT_TELL};
use super::messages::{self, Failure};
use super::results::{Outcome, Row, Thumbnails};
use crate::compare::flip::{self, ExposureRange, FlipMap, PIXELS_PER_DEGREE};
use crate::compare::{
    Answer, CompareError, Comparison, Correction, Estimate, Noise, Options, block_t, compare,
    non_finite, p_values,
};
use crate::console;
use crate::output::{self, OutputError};
use clap::{Args, ValueEnum};
use input::Input;
use std::path::{Path, PathBuf};

/// Examples for the long help.
const EXAMPLES: &str = "Examples:
  fstop compare image.exr reference.exr
  fstop compare before/ after/ --report differences/";

/// Arguments of `fstop compare`.
#[derive(Args, Debug)]
#[command(after_long_help = EXAMPLES)]
pub(super) struct CompareArgs {
    /// Image (.exr, .pfm, .hdr; .png, .tga, .jpg are taken for sRGB). Or a folder of references, whose images are paired by
    /// their names with those of B; then one false-alarm rate is shared among all
    #[arg(value_name = "A")]
    a: PathBuf,
    /// Image to compare with: the reference. Or the folder with the new images
    #[arg(value_name = "B")]
    b: PathBuf,
    /// Print JSON instead of text
    #[arg(help_heading = "Output", long)]
    json: bool,
    /// Write one self-contained page with both images, their differences and all metrics; of folders an index with
    /// thumbnails
    #[arg(help_heading = "Output", long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Write the result as JUnit XML, for build servers
    #[arg(help_heading = "Output", long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Write the result as Markdown, for a pull request
    #[arg(help_heading = "Output", long, value_name = "FILE")]
    markdown: Option<PathBuf>,
    /// Of folders: write index.html with a page for each image that does not agree, junit.xml, summary.md and results.json here
    #[arg(help_heading = "Output", long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Maximum probability that images with the same expectation are reported as different
    #[arg(help_heading = "How they are compared", long, value_name = "P", default_value_t = Options::default().alpha, value_parser = probability, allow_negative_numbers = true)]
    alpha: f64,
    /// Sides of the pixel blocks that are tested, besides single pixels and the whole
    #[arg(help_heading = "How they are compared", long, value_name = "PX,PX", value_delimiter = ',', default_value = "8,32", value_parser = clap::value_parser!(u32).range(2..))]
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
    /// Noise estimated from the difference: side of the squares of pixels that are independent of each other, about twice
    /// the filter's width where samples are splatted
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
    /// Checks the names of pages and reports, which are none of what is `read`.
    fn check_outputs(&self, read: &[&Path]) -> Result<(), OutputError> {
        let files = [&self.html, &self.junit, &self.markdown];
        let files: Vec<&PathBuf> = files.into_iter().flatten().collect();
        files.iter().try_for_each(|file| output::check(file))?;
        output::check_apart(&files, read)
    }

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
pub(in crate::cli) struct Report {
    pub(in crate::cli) inputs: [Input; 2],
    pub(in crate::cli) comparison: Comparison,
    flip: Option<Flip>,
}

/// Both kinds of FLIP.
struct Flip {
    /// As displayed at exposure 0.
    ldr: FlipMap,
    /// Over the reference's range of exposures; `None` if both images are LDR anyway.
    hdr: Option<(ExposureRange, FlipMap)>,
}

impl Report {
    /// Compares an image with a reference.
    pub(in crate::cli) fn new(
        inputs: [Input; 2],
        options: &Options,
    ) -> Result<Report, CompareError> {
        let [a, b] = inputs.each_ref().map(|input| Estimate::of(&input.loaded));
        let comparison = compare(&a, &b, options)?;
        Ok(Report {
            inputs,
            comparison,
            flip: None,
        })
    }

    /// Adds what a viewer would see.
    pub(in crate::cli) fn with_flip(mut self) -> Report {
        self.flip = Some(see(&self.inputs));
        self
    }

    /// As one page.
    pub(in crate::cli) fn page(&self, options: &Options) -> Result<String, Failure> {
        let [a, b] = self
            .inputs
            .each_ref()
            .map(|input| Estimate::of(&input.loaded));
        let p = p_values(&a, &b, options).map_err(|e| e.to_string())?;
        let sides = options.blocks.iter().filter(|&&side| side > 1);
        let t = sides.map(|&side| Ok((side, block_t(&a, &b, options, side)?)));
        let t = t.collect::<Result<_, CompareError>>();
        let t = t.map_err(|e| e.to_string())?;
        Ok(page::html(self, &page::Maps { p, t }))
    }

    /// What is to be kept in mind, of the files as well.
    fn cautions(&self) -> Vec<String> {
        let mut cautions = input::notes(&self.inputs);
        cautions.extend(self.comparison.cautions());
        cautions
    }

    /// As one of many results, without its noise and pixels.
    pub(in crate::cli) fn row(&self, name: &str, options: &Options) -> Row {
        let [a, b] = self
            .inputs
            .each_ref()
            .map(|input| Estimate::of(&input.loaded));
        let t = block_t(
            &a,
            &b,
            options,
            options
                .blocks
                .iter()
                .copied()
                .find(|&side| side > 1)
                .unwrap_or(8),
        );
        let mut row = Row::new(name, Outcome::Compared(Box::new(self.comparison.clone())));
        row.notes.extend(input::notes(&self.inputs));
        row.thumbnails = Thumbnails::of(a.image, b.image, t.ok().as_ref());
        row
    }
}

/// What becomes of an image that cannot be compared with its reference. One of another size has changed, whatever it shows.
pub(in crate::cli) fn incomparable(error: &CompareError) -> Outcome {
    match error {
        CompareError::Size(..) | CompareError::Window(..) => Outcome::Other(error.to_string()),
        _ => Outcome::Failed(error.to_string()),
    }
}

/// Compares two images, or two folders of them.
pub(super) fn run(args: &CompareArgs) -> u8 {
    let done = match (args.a.is_dir(), args.b.is_dir()) {
        (true, true) => folders::run(args),
        (false, false) => report(args),
        (is_folder, _) => {
            let [folder, file] = if is_folder {
                [&args.a, &args.b]
            } else {
                [&args.b, &args.a]
            };
            if !file.exists() {
                let message = format!("{}: cannot read: there is no such folder", file.display());
                return Failure::new(message, true).exit();
            }
            let [folder, file] = [folder, file].map(|path| path.display());
            Err(format!(
                "`{folder}` is a folder and `{file}` is not: two images or two folders are compared"
            )
            .into())
        }
    };
    done.unwrap_or_else(Failure::exit)
}

/// Prints the report, and returns the exit code.
fn report(args: &CompareArgs) -> Result<u8, Failure> {
    if args.report.is_some() {
        return Err(
            "--report is for folders; the page of two images is written by --html"
                .to_owned()
                .into(),
        );
    }
    args.check_outputs(&[&args.a, &args.b])?;
    let inputs = input::read_pair(&args.a, &args.b)?;
    let options = args.options();
    let mut report = Report::new(inputs, &options)?;
    if args.cell > 1 && !report.comparison.noise.is_spatial() {
        messages::warning(
            "--cell has no effect: the noise is not estimated from the difference (--noise spatial)",
        );
    }
    if !args.no_flip {
        report = report.with_flip();
    }
    if let Some(file) = &args.html {
        output::write(file, report.page(&options)?.as_bytes())?;
    }
    if args.junit.is_some() || args.markdown.is_some() {
        folders::write_results(args, &folders::of_one(args, &report, &options))?;
    }
    let said = if args.json {
        json::text(&report)?
    } else {
        text::text(&report)
    };
    console::answer(said)?;
    Ok(match report.comparison.answer() {
        Answer::Agree => 0,
        Answer::Differ => ANSWER_IS_NO,
        Answer::CannotTell => CANNOT_TELL,
    })
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
