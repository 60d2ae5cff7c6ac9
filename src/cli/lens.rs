//! `fstop lens LENS`: surfaces, focal length, f-number, focal and principal planes, pupils.

use super::{BAD_INPUT, messages};
use crate::optics::{Lens, LensReport, Prescription};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `fstop lens`.
#[derive(Args, Debug)]
pub struct LensArgs {
    /// Lens prescription (.dat)
    lens: PathBuf,
    /// Diameter of the aperture stop in mm, instead of the file's
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    aperture: Option<f64>,
    /// Focus at this distance from the film, in metres
    #[arg(
        long,
        value_name = "M",
        allow_negative_numbers = true,
        conflicts_with = "film_distance"
    )]
    focus: Option<f64>,
    /// Distance from the last surface to the film in mm
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    film_distance: Option<f64>,
    /// Multiply every length of the prescription
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    scale: Option<f64>,
    /// Print JSON instead of text; lengths in mm
    #[arg(long)]
    json: bool,
}

/// Prints what a lens is.
pub fn run(args: &LensArgs) -> ExitCode {
    match describe(args) {
        Ok(text) => {
            println!("{text}");
            ExitCode::SUCCESS
        }
        Err(message) => {
            messages::error(message);
            ExitCode::from(BAD_INPUT)
        }
    }
}

fn describe(args: &LensArgs) -> Result<String, String> {
    let mut prescription = Prescription::read(&args.lens).map_err(|e| e.to_string())?;
    if let Some(scale) = args.scale {
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(format!("--scale {scale}: expected a positive number"));
        }
        prescription = prescription.scaled(scale);
    }
    if let Some(diameter) = args.aperture {
        if !(diameter >= 0.0 && diameter.is_finite()) {
            return Err(format!(
                "--aperture {diameter}: expected a diameter in mm, 0 or more"
            ));
        }
        for warning in prescription.set_stops(diameter) {
            eprintln!("warning: {warning}");
        }
    }
    if let Some(mm) = args.film_distance
        && !(mm > 0.0 && mm.is_finite())
    {
        return Err(format!("--film-distance {mm}: expected a positive number"));
    }
    if let Some(metres) = args.focus
        && (metres.is_nan() || metres <= 0.0)
    {
        return Err(format!("--focus {metres}: expected a positive number"));
    }
    let film_distance = match (args.focus, args.film_distance) {
        (Some(metres), _) => {
            Lens::focused(&prescription, metres * 1e3).map_err(|e| e.to_string())?
        }
        (None, Some(mm)) => mm,
        (None, None) if prescription.film_distance > 0.0 => prescription.film_distance,
        // Course files leave the film to the scene: shown focused at infinity.
        (None, None) => Lens::focused(&prescription, f64::INFINITY).map_err(|e| e.to_string())?,
    };
    let lens = Lens::new(&prescription, film_distance).map_err(|e| e.to_string())?;
    let report = LensReport::new(&lens);
    if args.json {
        serde_json::to_string_pretty(&report).map_err(|e| e.to_string())
    } else {
        Ok(report.to_string())
    }
}
