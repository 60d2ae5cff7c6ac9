//! Writes `docs/generated/samplers.md` and its figure: mean squared error against samples per pixel, for every
//! sampler on five scenes.
//!
//! `cargo run --release --features studies --example sampler_curves` takes about five minutes of a processor.
//!
//! Each scene has a long reference of other random numbers, rendered in two halves whose difference tells its
//! own error, which is taken off. Every point is the mean of [`PICTURES`] images.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]
#![allow(clippy::print_stderr)]

mod figure;

use fstop::build::build;
use fstop::film::Image;
use fstop::render::{Progress, RenderJob, TILE_SIZE, render};
use fstop::samplers::{Points, Sampler, SamplerSpec, Stratified, sampler_names};
use fstop::scene::{Frame, ReadSettings, read_scene};
use fstop::syntax::SourceMap;
use fstop::tradeoff::measure::{Estimate, Measurement, Reference};
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::error::Error;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// The scenes beside this file, and what they ask of a sampler.
const SCENES: [(&str, &str); 5] = [
    ("box", "bounces and soft shadows"),
    ("lens", "depth of field, traced lens"),
    ("glossy", "rough metal, sky"),
    ("motion", "motion blur, thin lens"),
    ("lamps", "64 lights, instances"),
];

/// Samples a pixel. Those that are no powers of two are squares, which are what a grid is good at.
const COUNTS: [u32; 12] = [1, 2, 4, 8, 9, 16, 32, 36, 64, 100, 128, 256];

/// Images with different seeds for each point: a mean squared error is known to some 3 %.
const PICTURES: u64 = 4;

/// Samples a pixel of each half of the reference.
const HALF_REFERENCE: u32 = 2048;

/// The fit of a slope leaves out the first counts, where samples are too few to be spread.
const FIT_FROM: u32 = 4;

const HEAD: &str = "# Samplers: measured

Written by `cargo run --release --features studies --example sampler_curves`, not by hand. [Samplers](../samplers.md) says what is measured, and
how.

## Names

";

const CURVES: &str = "
## Error against samples

Relative mean squared error at each number of samples per pixel.

![Relative mean squared error against samples per pixel](samplers.svg)

";

/// What one sampler does on one scene.
pub struct Curve {
    /// The sampler.
    pub name: String,
    /// Samples a pixel, and the relative mean squared error.
    pub points: Vec<(u32, Estimate)>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut curves = Vec::new();
    for (name, what) in SCENES {
        eprintln!("{name}");
        curves.push((format!("{name}: {what}"), measure(name)?));
    }
    let folder = root.join("docs/generated");
    let page = format!("{HEAD}{}{CURVES}{}", names()?, tables(&curves)?);
    std::fs::write(folder.join("samplers.md"), page)?;
    std::fs::write(folder.join("samplers.svg"), figure::draw(&curves)?)?;
    Ok(())
}

/// The samplers that differ, as the tables name them.
fn samplers(scene: &str) -> Vec<(&'static str, Points)> {
    let grid = |dimensions| Points::Stratified(Stratified::new(1, 1, true, dimensions));
    let mut all = vec![
        ("random", Points::Random),
        ("stratified", grid(None)),
        ("sobol", Points::Sobol),
    ];
    if scene == "lens" {
        // Only the first pair: what the film's strata alone are worth.
        all.insert(1, ("stratified, film only", grid(Some(1))));
    }
    all
}

fn measure(scene: &str) -> Result<Vec<Curve>, Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/sampler_curves");
    let frame = read(&folder.join(scene).with_extension("pbrt"), None)?;
    let (built, _) = build(frame, 0);
    let mut job = built.ok_or("the scene cannot be built")?.job;
    let reference = reference(&mut job);
    let mut curves = Vec::new();
    for (name, points) in samplers(scene) {
        let spec = SamplerSpec {
            points,
            ..SamplerSpec::sobol(1)
        };
        let point = |&count: &u32| {
            let take = |seed| picture(&mut job, &spec, count, seed);
            let images: Vec<Image> = (1..=PICTURES).map(take).collect();
            // Times are of no interest here.
            let measured = Measurement::new(&reference, count, &images, &[1.0; PICTURES as usize]);
            (count, measured.squared_error)
        };
        curves.push(Curve {
            name: name.to_string(),
            points: COUNTS.iter().map(point).collect(),
        });
    }
    Ok(curves)
}

fn picture(job: &mut RenderJob, spec: &SamplerSpec, count: u32, seed: u64) -> Image {
    job.sampler = Sampler::new(&spec.clone().with_spp(count), seed);
    render(job, TILE_SIZE, false, &Progress::hidden()).image()
}

/// The mean of two independent images, and half their difference as its error.
fn reference(job: &mut RenderJob) -> Reference {
    let spec = SamplerSpec::sobol(1);
    let [a, b] = [101, 102].map(|seed| picture(job, &spec, HALF_REFERENCE, seed));
    let mut mean = a.clone();
    for (m, other) in mean.pixels.iter_mut().zip(&b.pixels) {
        *m = 0.5 * (*m + *other);
    }
    // With an error of nothing so far, the distance of a half is the error of the mean.
    let own = Measurement::new(&Reference::new(mean.clone(), 0.0), 1, &[a, b], &[1.0; 2]);
    Reference::new(mean, own.error().value)
}

/// The first frame of a scene file, or of `text` that is to stand at its place.
fn read(path: &Path, text: Option<String>) -> Result<Frame, Box<dyn Error>> {
    let sources = SourceMap::new();
    let file = match text {
        Some(text) => sources.add_text(&path.display().to_string(), text),
        None => sources.open(path)?,
    };
    let (scene, diagnostics) = read_scene(&sources, file, &ReadSettings::default());
    if diagnostics.has_errors() {
        return Err(format!("{}: the scene has errors", path.display()).into());
    }
    let frame = scene.frames.into_iter().next();
    Ok(frame.ok_or("no frame")?)
}

/// Which of the scene language's names share their points.
fn names() -> Result<String, Box<dyn Error>> {
    let mut table = String::from("| points | `Sampler` |\n|---|---|\n");
    for (label, points) in samplers("") {
        let mut same = Vec::new();
        for name in sampler_names() {
            let text = format!("Sampler \"{name}\"\nWorldBegin\nWorldEnd\n");
            let frame = read(&PathBuf::from("sampler.pbrt"), Some(text))?;
            let own = frame.options.sampler.points;
            if std::mem::discriminant(&own) == std::mem::discriminant(&points) {
                same.push(format!("`{name}`"));
            }
        }
        writeln!(table, "| {label} | {} |", same.join(", "))?;
    }
    Ok(table)
}

fn tables(curves: &[(String, Vec<Curve>)]) -> Result<String, std::fmt::Error> {
    let mut text = String::from("| scene | sampler |");
    for count in COUNTS {
        write!(text, " {count} |")?;
    }
    text += " slope | gain at 64 | at 256 |\n|---|---|";
    text += &"---:|".repeat(COUNTS.len() + 3);
    text.push('\n');
    for (scene, curves) in curves {
        let at = |curve: &Curve, count: u32| {
            let point = curve.points.iter().find(|(n, _)| *n == count);
            point.map_or(f64::NAN, |(_, e)| e.value)
        };
        for curve in curves {
            write!(text, "| {scene} | {} |", curve.name)?;
            for (_, e) in &curve.points {
                write!(text, " {:.2e} |", e.value)?;
            }
            let slope = slope(curve);
            write!(text, " {:.2} ± {:.2} |", slope.value, slope.within)?;
            for count in [64, 256] {
                let random = curves.first().map_or(f64::NAN, |c| at(c, count));
                write!(text, " {:.1} |", random / at(curve, count))?;
            }
            text.push('\n');
        }
    }
    Ok(text)
}

/// The power of the number of samples that the error falls with: least squares over the logarithms, with
/// its 95 % confidence interval by Student's t.
fn slope(curve: &Curve) -> Estimate {
    let points: Vec<(f64, f64)> = curve
        .points
        .iter()
        .filter(|(count, e)| *count >= FIT_FROM && e.value > 0.0)
        .map(|(count, e)| (f64::from(*count).ln(), e.value.ln()))
        .collect();
    let n = points.len() as f64;
    let (x, y) = points
        .iter()
        .fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
    let spread: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let value = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / spread;
    let rest: f64 = points
        .iter()
        .map(|p| (p.1 - y - value * (p.0 - x)).powi(2))
        .sum();
    let quantile = StudentsT::new(0.0, 1.0, n - 2.0).map_or(f64::NAN, |t| t.inverse_cdf(0.975));
    let within = quantile * (rest / (n - 2.0) / spread).sqrt();
    Estimate { value, within }
}
