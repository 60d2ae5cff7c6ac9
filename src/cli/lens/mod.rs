//! `fstop lens LENS`: what a lens is, as text, JSON, a drawing, or a page of plots.

mod chart;
mod cross_section;
mod page;
mod pictures;
mod plots;

use super::{BAD_INPUT, messages};
use crate::optics::analysis::{Effort, Film, LensAnalysis, ObjectPlane};
use crate::optics::best_focus;
use crate::optics::{Lens, LensReport, Prescription};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `fstop lens`.
#[derive(Args, Debug)]
pub struct LensArgs {
    /// Lens prescriptions (.dat tables, Zemax .zmx)
    #[arg(required = true, value_name = "LENS")]
    lenses: Vec<PathBuf>,
    /// Diameter of the aperture stop in mm, instead of the file's
    #[arg(long, value_name = "MM")]
    aperture: Option<f64>,
    /// Focus at this distance from the film, in metres (`inf` for infinity); `best` or `best:M` for the film of the
    /// smallest spot of real rays instead of Gaussian focus
    #[arg(long, value_name = "M", conflicts_with = "film_distance")]
    focus: Option<Focus>,
    /// Distance from the last surface to the film in mm
    #[arg(long, value_name = "MM")]
    film_distance: Option<f64>,
    /// Diagonal of the film in mm, of proportions 3:2
    #[arg(long, value_name = "MM", default_value_t = Film::FULL_FRAME.diagonal())]
    film_diagonal: f64,
    /// Multiply every length of the prescription
    #[arg(long, value_name = "S")]
    scale: Option<f64>,
    /// Print JSON instead of text; lengths in mm
    #[arg(long)]
    json: bool,
    /// Trace rays over the field as well: distortion, illumination, sharpness, focus table
    #[arg(long)]
    analysis: bool,
    /// Draw the cross-section with rays to this SVG file
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Write one page with all plots, readable without network, to this HTML file
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Write each picture of the page to this folder, in one subfolder per lens, with an overview README.md
    #[arg(long, value_name = "FOLDER")]
    pictures: Option<PathBuf>,
}

/// Where to focus.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Focus {
    /// From the film, mm.
    distance: f64,
    /// By real rays.
    best: bool,
}

impl std::str::FromStr for Focus {
    type Err = String;

    fn from_str(text: &str) -> Result<Focus, String> {
        let (best, metres) = match text.split_once(':') {
            Some(("best", metres)) => (true, metres),
            _ if text == "best" => (true, "inf"),
            _ => (false, text),
        };
        match metres.parse::<f64>() {
            Ok(m) if m > 0.0 => Ok(Focus {
                distance: 1e3 * m,
                best,
            }),
            _ => Err("expected a distance in metres, `inf`, `best` or `best:M`".to_string()),
        }
    }
}

/// A lens ready to be described.
struct Bench {
    /// The file's name without its ending.
    name: String,
    lens: Lens,
    film: Film,
    object: ObjectPlane,
}

/// Describes every lens.
pub fn run(args: &LensArgs) -> ExitCode {
    match describe_all(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            messages::error(message);
            ExitCode::from(BAD_INPUT)
        }
    }
}

fn describe_all(args: &LensArgs) -> Result<(), String> {
    if args.lenses.len() > 1 && (args.svg.is_some() || args.report.is_some()) {
        return Err("--svg and --report take one lens; --pictures takes several".to_string());
    }
    if !(args.film_diagonal > 0.0 && args.film_diagonal.is_finite()) {
        return Err(format!(
            "--film-diagonal {}: expected a positive length in mm",
            args.film_diagonal
        ));
    }
    let mut overview = Vec::new();
    for path in &args.lenses {
        let named = |e: String| format!("{}: {e}", path.display());
        let bench = mount(args, path).map_err(named)?;
        let report = LensReport::new(&bench.lens);
        let wanted = args.analysis || args.report.is_some() || args.pictures.is_some();
        let analysis = wanted
            .then(|| LensAnalysis::new(&bench.lens, bench.film, bench.object, &Effort::REPORT));
        if let Some(file) = &args.svg {
            write(
                file,
                &cross_section::svg(&bench.lens, bench.film, bench.object),
            )?;
        }
        if let Some(analysis) = &analysis {
            let content = page::Content::new(&bench, &report, analysis).map_err(named)?;
            if let Some(file) = &args.report {
                write(file, &page::html(&content))?;
            }
            if let Some(folder) = &args.pictures {
                overview.push(pictures::write_all(folder, &content)?);
            }
        }
        let shown = analysis.filter(|_| args.analysis);
        println!("{}", text(args, path, &report, shown)?);
    }
    match &args.pictures {
        Some(folder) => write(&folder.join("README.md"), &pictures::readme(&overview)),
        None => Ok(()),
    }
}

/// What is printed.
fn text(
    args: &LensArgs,
    path: &Path,
    report: &LensReport,
    analysis: Option<LensAnalysis>,
) -> Result<String, String> {
    if args.json {
        let mut value = serde_json::to_value(report).map_err(|e| e.to_string())?;
        if let Some(analysis) = analysis {
            value["analysis"] = serde_json::to_value(analysis).map_err(|e| e.to_string())?;
        }
        return serde_json::to_string_pretty(&value).map_err(|e| e.to_string());
    }
    let mut text = String::new();
    if args.lenses.len() > 1 {
        text = format!("{}\n\n", path.display());
    }
    text += &report.to_string();
    if let Some(analysis) = analysis {
        text += &format!("\n{analysis}");
    }
    Ok(text)
}

/// Reads a lens and puts it before its film as the arguments say.
fn mount(args: &LensArgs, path: &Path) -> Result<Bench, String> {
    let mut prescription = Prescription::read(path).map_err(|e| e.to_string())?;
    for warning in &prescription.warnings {
        eprintln!("warning: {}: {warning}", path.display());
    }
    if let Some(scale) = args.scale {
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(format!("--scale {scale}: expected a positive number"));
        }
        prescription = prescription.scaled(scale);
    }
    if let Some(diameter) = args.aperture {
        if !(diameter >= 0.0 && diameter.is_finite()) {
            return Err(format!("--aperture {diameter}: expected a diameter in mm"));
        }
        for warning in prescription.set_stops(diameter) {
            eprintln!("warning: {warning}");
        }
    }
    let lens =
        Lens::new(&prescription, film_distance(args, &prescription)?).map_err(|e| e.to_string())?;
    let object = match args.focus {
        Some(focus) => ObjectPlane::at_distance(&lens, focus.distance),
        None => ObjectPlane::in_focus(&lens),
    };
    Ok(Bench {
        object,
        name: path
            .file_stem()
            .map_or_else(|| "lens".to_string(), |s| s.to_string_lossy().into_owned()),
        lens,
        film: Film::of_diagonal(args.film_diagonal),
    })
}

/// The film distance asked for, or the file's, or that of infinity where it has none.
fn film_distance(args: &LensArgs, prescription: &Prescription) -> Result<f64, String> {
    match (args.focus, args.film_distance) {
        (Some(focus), _) if focus.best => {
            best_focus::film_distance(prescription, focus.distance).map_err(|e| e.to_string())
        }
        (Some(focus), _) => {
            Lens::focused(prescription, focus.distance).map_err(|e| e.to_string())
        }
        (None, Some(mm)) => Ok(mm),
        (None, None) if prescription.film_distance > 0.0 => Ok(prescription.film_distance),
        (None, None) => Lens::focused(prescription, f64::INFINITY).map_err(|e| {
            format!("the file gives no film distance and none follows from infinity focus ({e}); use --film-distance")
        }),
    }
}

fn write(file: &Path, text: &str) -> Result<(), String> {
    std::fs::write(file, text).map_err(|e| format!("cannot write {}: {e}", file.display()))
}
