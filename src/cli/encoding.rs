//! How images are stored: options of `render` and `merge`.

use super::messages;
use crate::film::{Encoding, Image};
use clap::Args;
use std::path::Path;

/// How numbers are stored.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct EncodingArgs {
    /// Write colors, albedo, normals and alpha of .exr files in half floats, at half the size: 11 bits, at most 65504
    #[arg(help_heading = "Output", long)]
    half: bool,
    /// Make the images in .png and .tga files brighter by so many stops (factors of 2), or darker by negative ones
    #[arg(help_heading = "Output", long, value_name = "STOPS", default_value_t = 0.0, hide_default_value = true,
        value_parser = stops, allow_negative_numbers = true)]
    exposure: f64,
}

/// Stops that numbers can be multiplied by.
fn stops(text: &str) -> Result<f64, String> {
    /// What single precision can hold from the darkest to the brightest.
    const MAX_STOPS: f64 = 120.0;
    let number: Option<f64> = text.parse().ok();
    { number.filter(|stops| stops.abs() <= MAX_STOPS) }
        .ok_or_else(|| format!("expected a number of stops from -{MAX_STOPS} to {MAX_STOPS}"))
}

impl EncodingArgs {
    pub(super) fn encoding(&self) -> Encoding {
        Encoding {
            half: self.half,
            stops: self.exposure,
        }
    }

    /// Each option with whether it is given.
    pub(super) fn given(&self) -> [(&'static str, bool); 2] {
        [("--half", self.half), ("--exposure", self.exposure != 0.0)]
    }

    /// The options as words of the shell, each after a space.
    pub(super) fn words(&self) -> String {
        let half = if self.half { " --half" } else { "" };
        match self.exposure {
            0.0 => half.to_string(),
            stops => format!("{half} --exposure={stops}"),
        }
    }

    /// Warns of what has no effect on files of these names.
    pub(super) fn warn_of_names(&self, paths: &[&Path]) {
        let is = |path: &Path, endings: &[&str]| {
            let ending = path.extension().and_then(|e| e.to_str());
            ending.is_some_and(|e| endings.iter().any(|other| e.eq_ignore_ascii_case(other)))
        };
        if self.half && !paths.iter().any(|path| is(path, &["exr"])) {
            messages::warning("--half has no effect: only .exr files have half floats");
        }
        if self.exposure != 0.0 && !paths.iter().any(|path| is(path, &["png", "tga"])) {
            messages::warning(
                "--exposure has no effect: it applies to .png and .tga files; others keep the film's values",
            );
        }
    }

    /// Warns of colors that are clamped.
    pub(super) fn warn_of_colors(&self, image: &Image) {
        let beyond = if self.half { image.beyond_half() } else { 0 };
        if beyond > 0 {
            let pixels = if beyond == 1 {
                "pixel is"
            } else {
                "pixels are"
            };
            messages::warning(format!(
                "--half: {beyond} {pixels} brighter than 65504, the most of a half float, and stored as that"
            ));
        }
    }
}
