//! `fstop lens LENS`: what a lens is, as text, JSON, a drawing, or a page of plots.

pub(in crate::cli) mod chart;
mod cross_section;
mod images;
mod maps;
mod page;
mod plots;

use super::messages::{self, Failure};
use crate::console;
use crate::optics::analysis::{self, Effort, Film, LensAnalysis, ObjectPlane};
use crate::optics::coating::Coating;
use crate::optics::ghosts::{self, Ghosts};
use crate::optics::prescription::write::LensFormat;
use crate::optics::{Lens, LensReport, Prescription, Surface};
use crate::optics::{best_focus, breathing};
use crate::output;
use clap::Args;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Two lines of use, for the long help.
const EXAMPLES: &str = "Examples:
  fstop lens dgauss.dat --focus 2 --aperture 10
  fstop lens zoom.zmx --report page.html --svg section.svg";

/// Arguments of `fstop lens`.
#[derive(Args, Debug)]
#[command(after_long_help = EXAMPLES)]
pub(super) struct LensArgs {
    /// Lens prescriptions: tables (.dat), Zemax (.zmx), CODE V (.seq), OSLO (.len), optiland or ISET (.json), Optical Bench (.txt)
    #[arg(required = true, value_name = "LENS")]
    lenses: Vec<PathBuf>,
    #[command(flatten)]
    mount: MountArgs,
    #[command(flatten)]
    output: OutputArgs,
    #[command(flatten)]
    maps: maps::MapArgs,
}

/// How a lens is put before its film.
#[derive(Args, Debug)]
#[command(next_help_heading = "How it is mounted")]
struct MountArgs {
    /// Diameter of the aperture stop in mm, instead of the file's
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    aperture: Option<f64>,
    /// Focus at this distance from the film, in meters (`inf` for infinity); `best` or `best:M` for the film of the
    /// smallest spot of real rays instead of Gaussian focus
    #[arg(
        long,
        value_name = "M",
        allow_negative_numbers = true,
        conflicts_with = "film_distance"
    )]
    focus: Option<Focus>,
    /// Distance from the last surface to the film in mm
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    film_distance: Option<f64>,
    /// Diagonal of the film in mm, of proportions 3:2; by default that of 24 x 36 mm, 43.27
    #[arg(long, value_name = "MM", default_value_t = Film::FULL_FRAME.diagonal(), hide_default_value = true)]
    film_diagonal: f64,
    /// What a zoom lens is set to, by the `zoom` line of its file; by default the least
    #[arg(long, value_name = "Z", allow_negative_numbers = true)]
    zoom: Option<f64>,
    /// Multiply every length of the prescription
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    scale: Option<f64>,
}

/// What is written about it.
#[derive(Args, Debug)]
#[command(next_help_heading = "Output")]
struct OutputArgs {
    /// Print JSON instead of text; lengths in mm
    #[arg(long)]
    json: bool,
    /// Trace rays over the field as well: distortion, illumination, sharpness, focus table
    #[arg(long)]
    analysis: bool,
    /// Rows of the tables over the field, 1 to 25, in --analysis and on the page; --json has all
    #[arg(long, value_name = "N", default_value_t = analysis::ROWS as u8, value_parser = clap::value_parser!(u8).range(1..=25))]
    rows: u8,
    /// Write the lens, scaled, to this file: a lens table (.dat), Zemax (.zmx) or JSON (.json); with --zoom or --focus at that
    /// position alone, else with all that it has
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print how focal length, view and brightness change with zoom and focus (breathing), instead of the description
    #[arg(long)]
    table: bool,
    /// Print the ghosts of a distant lamp so many degrees off the axis, instead of the description: light that two surfaces reflect
    /// to the film, the brightest first
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = below_90, conflicts_with = "table")]
    ghosts: Option<f64>,
    /// With --ghosts: a quarter-wave layer of this index and wavelength on all surfaces between air and glass of which the file says none, such as 1.38@550
    #[arg(long, value_name = "INDEX@NM", requires = "ghosts")]
    coating: Option<Coating>,
    /// Draw the cross-section with rays to this SVG file
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Write one page with all plots, readable without network, to this HTML file
    #[arg(long, visible_alias = "page", value_name = "FILE")]
    report: Option<PathBuf>,
    /// Write each image of the page to this folder, in one subfolder per lens, with an overview README.md
    #[arg(long, visible_alias = "pictures", value_name = "FOLDER")]
    images: Option<PathBuf>,
}

/// An angle with the axis of light that may get into the lens.
fn below_90(text: &str) -> Result<f64, String> {
    let angle = text.parse().ok().filter(|angle: &f64| angle.abs() < 90.0);
    angle.ok_or_else(|| "expected an angle below 90 degrees".to_string())
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
        let (best, meters) = match text.split_once(':') {
            Some(("best", meters)) => (true, meters),
            _ if text == "best" => (true, "inf"),
            _ => (false, text),
        };
        match meters.parse::<f64>() {
            Ok(m) if m > 0.0 => Ok(Focus {
                distance: 1e3 * m,
                best,
            }),
            _ => Err("expected a distance in meters, `inf`, `best` or `best:M`".to_string()),
        }
    }
}

/// A lens ready to be described.
struct Bench {
    /// The file's name without its ending.
    name: String,
    prescription: Prescription,
    /// With its groups where the file has them, and the stop as it is there.
    moving: Prescription,
    lens: Lens,
    film: Film,
    object: ObjectPlane,
}

impl Bench {
    /// A message about this lens.
    fn says(&self, message: &str) -> Failure {
        format!("{}: {message}", self.name).into()
    }

    /// Traces real rays over the field.
    fn analysis(&self) -> LensAnalysis {
        LensAnalysis::new(&self.lens, self.film, self.object, &Effort::REPORT).with_color(
            &self.lens,
            &self.prescription,
            self.object,
        )
    }
}

/// Describes every lens.
pub(super) fn run(args: &LensArgs) -> u8 {
    describe_all(args).map_or_else(Failure::exit, |()| 0)
}

fn describe_all(args: &LensArgs) -> Result<(), Failure> {
    let output = &args.output;
    let one = [&output.svg, &output.report, &output.output];
    let alone = one.iter().any(|file| file.is_some()) || args.maps.files().next().is_some();
    if args.lenses.len() > 1 && alone {
        let message = "--svg, --report, --output and maps take one lens; --images takes several";
        return Err(message.to_string().into());
    }
    let diagonal = args.mount.film_diagonal;
    if !(diagonal > 0.0 && diagonal.is_finite()) {
        let message = format!("--film-diagonal {diagonal}: expected a positive length in mm");
        return Err(message.into());
    }
    if let Some(file) = &output.output
        && LensFormat::of(file).is_none()
    {
        let message = format!(
            "{}: lenses are written as .dat, .zmx or .json",
            file.display()
        );
        return Err(message.into());
    }
    args.maps.check()?;
    let files = output
        .svg
        .iter()
        .chain(&output.report)
        .chain(&output.output)
        .chain(args.maps.files());
    let files: Vec<&Path> = files.map(|file| file.as_ref()).collect();
    files.iter().try_for_each(|file| output::check(file))?;
    output::check_apart(&files, &args.lenses)?;
    let mut overview = Vec::new();
    for path in &args.lenses {
        let (text, part) = describe(args, path)?;
        overview.extend(part);
        console::answer(text)?;
    }
    match &output.images {
        Some(folder) => write(
            &folder.join("README.md"),
            &images::readme(&overview, &command()),
        ),
        None => Ok(()),
    }
}

/// Writes the files about a lens; returns what is printed, and its part of the overview of images.
fn describe(args: &LensArgs, path: &Path) -> Result<(String, Option<String>), Failure> {
    let output = &args.output;
    let named = |e: String| format!("{}: {e}", path.display());
    let bench = mount(&args.mount, path).map_err(|e| e.said(named))?;
    let report = LensReport::new(&bench.lens);
    let wanted = output.analysis || output.report.is_some() || output.images.is_some();
    let analysis = wanted.then(|| LensAnalysis {
        rows: usize::from(output.rows),
        ..bench.analysis()
    });
    if let Some(file) = &output.svg {
        let drawing = cross_section::svg(&bench.lens, bench.film, bench.object);
        write(file, &drawing)?;
    }
    if let Some(file) = &output.output {
        write_lens(&bench, args, file)?;
    }
    args.maps.write(&bench)?;
    let mut part = None;
    if let Some(analysis) = &analysis {
        let content = page::Content::new(&bench, &report, analysis).map_err(named)?;
        if let Some(file) = &output.report {
            write(file, &page::html(&content))?;
        }
        if let Some(folder) = &output.images {
            part = Some(images::write_all(folder, &content)?);
        }
    }
    let shown = analysis.filter(|_| output.analysis);
    if output.table {
        let mut moving = bench.moving;
        if let Some(diameter) = args.mount.aperture {
            moving.set_stops(diameter);
        }
        let rows = breathing::rows(&moving);
        let text = match output.json {
            true => serde_json::to_string_pretty(&rows).map_err(|e| e.to_string())?,
            false => breathing::text(&rows),
        };
        return Ok((text, part));
    }
    if let Some(degrees) = output.ghosts {
        let table = ghosts::table(&Ghosts::new(bench.lens.clone(), output.coating), degrees);
        let text = match output.json {
            true => serde_json::to_string_pretty(&table).map_err(|e| e.to_string())?,
            false => table.to_string(),
        };
        return Ok((text, part));
    }
    if output.json {
        return Ok((json(&report, shown)?, part));
    }
    let mut text = String::new();
    if args.lenses.len() > 1 {
        text = format!("{}\n\n", path.display());
    }
    text += &report.to_string();
    if let Some(analysis) = shown {
        text += &format!("\n{analysis}");
    }
    Ok((text, part))
}

/// Writes the lens to `file`, and beside it the catalogue of its glasses where the format needs one.
fn write_lens(bench: &Bench, args: &LensArgs, file: &Path) -> Result<(), Failure> {
    let Some(format) = LensFormat::of(file) else {
        return Ok(());
    };
    let chosen = args.mount.zoom.is_some() || args.mount.focus.is_some();
    let mut lens = &bench.moving;
    let still;
    if chosen {
        still = Prescription {
            // Where it is, with the stop as the file has it.
            surfaces: at_position_of(&bench.moving, &bench.prescription),
            film_distance: bench.lens.film_distance(),
            positions: None,
            warnings: Vec::new(),
        };
        lens = &still;
    }
    let written = lens.write_as(format, &bench.name);
    let written = written.map_err(|e| bench.says(&e.to_string()))?;
    if let Some(catalogue) = &written.catalogue {
        let beside = file.with_extension("agf");
        write(&beside, catalogue)?;
        messages::warning(format_args!(
            "{}: the glasses' dispersion is in {}, which belongs beside it",
            file.display(),
            beside.display()
        ));
    }
    write(file, &written.text)
}

/// The surfaces of `moving` with the thicknesses of `still`.
fn at_position_of(moving: &Prescription, still: &Prescription) -> Vec<Surface> {
    let both = moving.surfaces.iter().zip(&still.surfaces);
    let at = |(moving, still): (&Surface, &Surface)| Surface {
        thickness: still.thickness,
        ..*moving
    };
    both.map(at).collect()
}

fn json(report: &LensReport, analysis: Option<LensAnalysis>) -> Result<String, String> {
    let mut value = serde_json::to_value(report).map_err(|e| e.to_string())?;
    if let Some(analysis) = analysis {
        value["analysis"] = serde_json::to_value(analysis).map_err(|e| e.to_string())?;
    }
    serde_json::to_string_pretty(&value).map_err(|e| e.to_string())
}

/// Reads a lens and puts it before its film as the arguments say.
fn mount(args: &MountArgs, path: &Path) -> Result<Bench, Failure> {
    let ending = path.extension().unwrap_or_default();
    if ending.eq_ignore_ascii_case("pbrt") {
        let hint = "this is a scene; give the lens file that its `Camera` names as \"lensfile\"";
        return Err(hint.to_string().into());
    }
    let mut prescription = Prescription::read(path)?;
    for warning in &prescription.warnings {
        messages::warning(format_args!("{}: {warning}", path.display()));
    }
    if let Some(scale) = args.scale {
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(format!("--scale {scale}: expected a positive number").into());
        }
        prescription = prescription.scaled(scale);
    }
    let moving = prescription.clone();
    let distance = args.focus.map_or(f64::INFINITY, |focus| focus.distance);
    prescription = prescription
        .at_position(args.zoom, distance)
        .map_err(|e| format!("--zoom: {e}"))?;
    if let Some(diameter) = args.aperture {
        if !(diameter >= 0.0 && diameter.is_finite()) {
            let message = format!("--aperture {diameter}: expected a diameter in mm, 0 or more");
            return Err(message.into());
        }
        for warning in prescription.set_stops(diameter) {
            messages::warning(warning);
        }
    }
    let film_distance = film_distance(args, &prescription)?;
    let lens = Lens::new(&prescription, film_distance).map_err(|e| e.to_string())?;
    let object = match args.focus {
        Some(focus) => ObjectPlane::at_distance(&lens, focus.distance),
        None => ObjectPlane::in_focus(&lens),
    };
    let name = path.file_stem().unwrap_or(OsStr::new("lens"));
    Ok(Bench {
        object,
        name: name.to_string_lossy().into_owned(),
        prescription,
        moving,
        lens,
        film: Film::of_diagonal(args.film_diagonal),
    })
}

/// The film distance asked for, or the file's, or that of infinity where it has none.
fn film_distance(args: &MountArgs, prescription: &Prescription) -> Result<f64, String> {
    if let Some(mm) = args.film_distance
        && !(mm > 0.0 && mm.is_finite())
    {
        return Err(format!("--film-distance {mm}: expected a positive number"));
    }
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

/// The command line, to be given again: its program without the folder it lies in.
fn command() -> String {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    format!("fstop {}", arguments.join(" "))
}

fn write(file: &Path, text: &str) -> Result<(), Failure> {
    Ok(output::write(file, text.as_bytes())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An achromat with a stop, from the course's kind of table.
    const ACHROMAT: &str = "0 2 0 0 12\n61 4 1.5168 64.2 20\n-45 2 1.6727 32.2 20\n-130 0 1 0 20\n";

    fn bench(text: &str) -> Bench {
        let prescription = Prescription::parse(text).unwrap();
        let film_distance = best_focus::film_distance(&prescription, f64::INFINITY).unwrap();
        Bench {
            name: "an <achromat>".to_string(),
            lens: Lens::new(&prescription, film_distance).unwrap(),
            moving: prescription.clone(),
            prescription,
            film: Film::FULL_FRAME,
            object: ObjectPlane::INFINITY,
        }
    }

    #[test]
    fn focus_is_a_distance_or_best() {
        let focus = |text: &str| text.parse::<Focus>();
        let expected = |distance, best| Ok(Focus { distance, best });
        assert_eq!(focus("2"), expected(2000.0, false));
        assert_eq!(focus("inf"), expected(f64::INFINITY, false));
        assert_eq!(focus("best"), expected(f64::INFINITY, true));
        assert_eq!(focus("best:0.5"), expected(500.0, true));
        for wrong in ["", "best:", "-1", "0", "nan", "worst:2", "best:x"] {
            assert!(focus(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_page_has_everything_and_needs_no_network() {
        let bench = bench(ACHROMAT);
        let (report, analysis) = (LensReport::new(&bench.lens), bench.analysis());
        let content = page::Content::new(&bench, &report, &analysis).unwrap();
        let html = page::html(&content);
        for part in [
            "an &lt;achromat&gt;",
            "Cross-section",
            "Spot diagrams",
            "Ray aberrations",
            "MTF over the field",
            "Distortion",
            "Relative illumination",
            "Lateral color",
            "Field curves",
            "Longitudinal aberration",
            "Chromatic focal shift",
            "MTF by frequency",
            "MTF through focus",
            "Pupil footprints",
            "Distortion grid",
            "Seidel sums",
            "Focus table",
            "Prescription",
        ] {
            assert!(html.contains(part), "{part}");
        }
        // Surfaces of no power add to no sum, neither from above nor from below.
        for text in html.split(['<', '>', ' ']).filter(|t| t.starts_with('-')) {
            let is_zero = text.parse::<f64>().is_ok_and(|number| number == 0.0);
            assert!(!is_zero, "{text}");
        }
        // The name of SVG's namespace is no address to fetch.
        let links = html.replace("http://www.w3.org/2000/svg", "");
        for outside in ["http:", "https:", "src=", "@import", "url("] {
            assert!(!links.contains(outside), "{outside}");
        }
        let images: usize = content.figures.iter().map(|f| f.svgs.len()).sum();
        assert_eq!(html.matches("<svg").count(), images);
        assert_eq!(html.matches("</svg>").count(), images);
        assert!(!html.contains("NaN"));
    }

    #[test]
    fn awkward_lenses_have_a_page_too() {
        // A pinhole, a window, a lens without a stop in front of its focus, one that lets nothing through.
        for text in [
            "0 0 0 0.4\n",
            "inf 5 1.5 20\ninf 0 1 20\n",
            "50 5 1.5 60 20 k=-1 A4=1e-6\n-50 0 1 0 20\n",
            "0 50 0 1e-3\n0 0 1.5 1e-3\n20 0 1 30\n",
        ] {
            let prescription = Prescription::parse(text).unwrap();
            let lens = Lens::new(&prescription, 30.0).unwrap();
            let bench = Bench {
                name: "awkward".to_string(),
                object: ObjectPlane::in_focus(&lens),
                moving: prescription.clone(),
                prescription,
                lens,
                film: Film::FULL_FRAME,
            };
            let (report, analysis) = (LensReport::new(&bench.lens), bench.analysis());
            let content = page::Content::new(&bench, &report, &analysis).unwrap();
            let html = page::html(&content);
            assert!(!html.contains("NaN") && !html.contains("inf,"), "{text}");
        }
    }
}
