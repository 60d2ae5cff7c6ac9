//! `fstop render SCENE`: text to image.

use super::goal::GoalArgs;
use super::messages::Rigor;
use super::outputs::Outputs;
use super::{BAD_INPUT, NOT_ALL, ReadArgs, messages};
use crate::build;
use crate::console;
use crate::film::DroppedSample;
use crate::film::{self, FilmMetadata};
use crate::integrators::witness::{Met, Place};
use crate::materials::Material;
use crate::render::{self, Ended, Progress, RenderJob};
use crate::scene::Frame;
use crate::syntax::{Diagnostic, Diagnostics, SourceMap};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Two lines of use, for the long help.
const EXAMPLES: &str = "Examples:
  fstop render scene.pbrt --error 1% -o image.exr --png image.png
  fstop render scene.pbrt --quick --lens-model thin";

/// Arguments of `fstop render`.
#[derive(Args, Debug)]
#[command(after_long_help = EXAMPLES)]
pub struct RenderArgs {
    /// Scene file; `-` is standard input
    scene: PathBuf,
    /// ImageData to write (.exr, .png, .pfm, .tga); by default what the scene's Film names
    #[arg(
        help_heading = "Output",
        short,
        long = "output",
        visible_alias = "outfile"
    )]
    output: Option<PathBuf>,
    /// Also write a PNG of the image here
    #[arg(help_heading = "Output", long)]
    png: Option<PathBuf>,
    /// Samples a pixel, instead of the scene's; with --error or --time the most
    #[arg(help_heading = "When it is done", long, value_parser = positive, allow_negative_numbers = true)]
    spp: Option<u32>,
    /// Threads; by default one for each processor, at most eight times as many
    #[arg(
        help_heading = "How it runs",
        long,
        visible_alias = "nthreads",
        default_value_t = 0,
        hide_default_value = true,
        allow_negative_numbers = true
    )]
    threads: usize,
    /// Seed of all random numbers
    #[arg(
        help_heading = "When it is done",
        long,
        default_value_t = 0,
        allow_negative_numbers = true
    )]
    seed: u64,
    /// Part of the image, as fractions: x0,x1,y0,y1
    #[arg(
        help_heading = "What is rendered",
        long,
        value_delimiter = ',',
        num_args = 1,
        allow_hyphen_values = true,
        value_name = "x0,x1,y0,y1"
    )]
    crop: Option<Vec<f64>>,
    /// The same as four arguments, as pbrt; used only where the scene gives no crop window
    #[arg(help_heading = "What is rendered", long, num_args = 4, allow_negative_numbers = true, value_names = ["x0", "x1", "y0", "y1"])]
    cropwindow: Option<Vec<f64>>,
    /// Side of the square tiles that threads work on, in pixels; changes no bit of the image
    #[arg(help_heading = "How it runs", long, default_value_t = render::TILE_SIZE, hide = true)]
    tile_size: u32,
    /// Also write the variance of each pixel's mean (channels var.R, var.G, var.B)
    #[arg(help_heading = "Output", long)]
    variance: bool,
    /// A quick look: a quarter of the width and height, one sample a pixel, a quarter of the lights' samples
    #[arg(help_heading = "What is rendered", long)]
    quick: bool,
    /// Print only errors
    #[arg(help_heading = "How it runs", long)]
    quiet: bool,
    /// Render although files are missing or names are not defined (whatever pbrt-v3 goes on after), and
    /// exit with 1: textures' images become a gray of 0.5, lights shine without their maps, spectra
    /// are black, meshes and includes are left out, a lens becomes a pinhole of 27 degrees; a parameter
    /// that names nothing has its default, a directive that does is left out
    #[arg(
        help_heading = "How the scene is read",
        long,
        conflicts_with = "strict"
    )]
    keep_going: bool,
    #[command(flatten)]
    goal: GoalArgs,
    #[command(flatten)]
    read: ReadArgs,
}

/// Renders every frame of the scene.
pub fn run(args: &RenderArgs) -> ExitCode {
    match render_scene(args) {
        Ok(flaws) => {
            let passed = flaws.passed;
            if passed > 0 {
                let errors = if passed == 1 { "error" } else { "errors" };
                messages::warning(format!(
                    "rendered in spite of {passed} {errors}: the image is not that of the whole scene"
                ));
            }
            match flaws {
                Flaws { unwritten, .. } if unwritten > 0 => ExitCode::from(BAD_INPUT),
                Flaws { passed: 0, .. } => ExitCode::SUCCESS,
                _ => ExitCode::from(NOT_ALL),
            }
        }
        Err(message) => {
            if let Some(message) = message {
                messages::error(message);
            }
            ExitCode::from(BAD_INPUT)
        }
    }
}

impl RenderArgs {
    fn rigor(&self) -> Rigor {
        if self.keep_going {
            Rigor::KeepGoing
        } else {
            self.read.rigor()
        }
    }

    /// Prints what was found, as far as it is asked for. Errors always are.
    fn print(&self, diagnostics: &Diagnostics, sources: &SourceMap) {
        if !self.quiet || messages::refused(diagnostics, self.rigor()) || diagnostics.has_errors() {
            messages::print(diagnostics, sources);
        }
    }
}

/// `Err(None)` where the trouble has been printed already.
type Outcome<T = ()> = Result<T, Option<String>>;

/// What is wrong with the images of a scene that was rendered.
struct Flaws {
    /// Errors that it was rendered in spite of.
    passed: usize,
    /// Files that are not where they should be.
    unwritten: usize,
}

fn render_scene(args: &RenderArgs) -> Outcome<Flaws> {
    let sources = args.read.sources().map_err(Some)?;
    let threads = threads(args);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| Some(format!("cannot start {threads} threads: {e}")))?;
    let (scene, diagnostics) = messages::read(&args.scene, &args.read.settings(), &sources);
    let refused = messages::refused(&diagnostics, args.rigor());
    if let Some(scene) = scene.as_ref().filter(|_| refused) {
        // Nothing will be rendered: whoever mends the scene wants to know all that `check` knows.
        messages::examine(&scene.frames, &sources, &diagnostics);
    }
    args.print(&diagnostics, &sources);
    let mut flaws = Flaws {
        passed: diagnostics.recoverable_errors(),
        unwritten: 0,
    };
    let scene = scene.filter(|_| !refused).ok_or(None)?;
    let outputs = outputs(args, &scene.frames, &sources)?;
    // All of them before the first is rendered: nobody wants to learn of a misspelt folder after a
    // night's work.
    check_outputs(args, &scene.frames, &outputs, &sources)?;
    check_later_frames(args, &scene.frames, &sources, &pool)?;
    let keeps_variances = |outputs: &Outputs| outputs.paths().any(film::keeps_variances);
    if args.variance && !args.quiet && !outputs.iter().any(keeps_variances) {
        messages::warning("--variance has no effect: only .exr files keep variances");
    }
    for (frame, outputs) in scene.frames.into_iter().zip(&outputs) {
        let of_frame = render_frame(args, frame, outputs, &sources, &pool)?;
        flaws.passed += of_frame.passed;
        flaws.unwritten += of_frame.unwritten;
    }
    Ok(flaws)
}

/// The files of all frames. Two frames that name the same image get one each, which pbrt-v3 does
/// not do: there the last one is all that is left.
fn outputs(args: &RenderArgs, frames: &[Frame], sources: &SourceMap) -> Outcome<Vec<Outputs>> {
    let diagnostics = Diagnostics::new();
    let mut all: Vec<Outputs> = Vec::with_capacity(frames.len());
    for (number, frame) in (1..).zip(frames) {
        let mut outputs = Outputs::new(args.output.as_deref(), args.png.as_deref(), frame, number);
        if all.iter().any(|earlier| earlier.same_image(&outputs)) {
            outputs.number_image(number);
            let message = format!(
                "an earlier frame is written to this file: `{}` is used for frame {number}",
                outputs.image().display()
            );
            let named = frame.options.film.filename.as_ref();
            diagnostics.push(match named {
                Some(file) => Diagnostic::warning(message).at(file.span),
                None => Diagnostic::warning(message),
            });
        }
        all.push(outputs);
    }
    args.print(&diagnostics, sources);
    if messages::refused(&diagnostics, args.rigor()) {
        return Err(None);
    }
    Ok(all)
}

/// Refuses outputs that cannot be written; where the scene names them, at that place.
fn check_outputs(
    args: &RenderArgs,
    frames: &[Frame],
    outputs: &[Outputs],
    sources: &SourceMap,
) -> Outcome {
    let diagnostics = Diagnostics::new();
    for (frame, outputs) in frames.iter().zip(outputs) {
        let named = frame.options.film.filename.as_ref();
        let named = named.filter(|_| args.output.is_none());
        if let Some(file) = named {
            messages::check_place(file, sources, &diagnostics);
        }
        if let Some(file) = named
            && let Err(error) = film::check_output(&file.path)
        {
            diagnostics.push(Diagnostic::error(error.to_string()).at(file.span));
        } else if let Err(error) = outputs.check() {
            diagnostics.push(Diagnostic::error(error));
        }
    }
    if diagnostics.has_errors() {
        messages::print(&diagnostics, sources);
        return Err(None);
    }
    Ok(())
}

/// Loads the files of all frames but the first, and lets them go again: a broken mesh in the last
/// frame is found before the first one has been rendered for an hour. What is no hindrance is said
/// when the frame's turn comes.
fn check_later_frames(
    args: &RenderArgs,
    frames: &[Frame],
    sources: &SourceMap,
    pool: &rayon::ThreadPool,
) -> Outcome {
    let Some((_, later)) = frames.split_first() else {
        return Ok(());
    };
    let diagnostics = pool.install(|| {
        let diagnostics = Diagnostics::new();
        for frame in later {
            build::check(frame, &diagnostics);
        }
        diagnostics
    });
    if messages::refused(&diagnostics, args.rigor()) {
        messages::print(&diagnostics, sources);
        return Err(None);
    }
    Ok(())
}

/// Threads for each processor beyond which more of them only cost memory and time.
const THREADS_PER_PROCESSOR: usize = 8;

/// The number of threads to start: as asked for, 0 for one for each processor, and no more than
/// [`THREADS_PER_PROCESSOR`]. The image does not depend on it.
fn threads(args: &RenderArgs) -> usize {
    let processors = super::processors();
    let most = THREADS_PER_PROCESSOR * processors;
    if args.threads > most && !args.quiet {
        messages::warning(format!(
            "--threads {}: {most} are used, {THREADS_PER_PROCESSOR} for each processor",
            args.threads
        ));
    }
    match args.threads {
        // Not left to rayon, which would take any number from RAYON_NUM_THREADS.
        0 => processors,
        threads => threads.min(most),
    }
}

/// A count from the command line.
fn positive(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(0) | Err(_) => Err(format!("expected a whole number from 1 to {}", u32::MAX)),
        Ok(count) => Ok(count),
    }
}

fn render_frame(
    args: &RenderArgs,
    mut frame: Frame,
    outputs: &Outputs,
    sources: &SourceMap,
    pool: &rayon::ThreadPool,
) -> Outcome<Flaws> {
    apply(args, &mut frame).map_err(Some)?;
    let started = Instant::now();
    let (built, diagnostics) = pool.install(|| build::build(frame, args.seed));
    let refused = messages::refused(&diagnostics, args.rigor());
    args.print(&diagnostics, sources);
    let built = built.filter(|_| !refused).ok_or(None)?;
    if !args.quiet {
        report_start(&built);
    }
    let job = &built.job;
    let rendering = Instant::now();
    let taken = pool.install(|| take(args, job));
    let mut image = taken.film.develop();
    if !args.variance {
        image.variance = None;
    }
    let metadata = FilmMetadata {
        seed: args.seed,
        spp: taken.spp.round().clamp(1.0, f64::from(u32::MAX)) as u32,
        relative_error: taken.progressive.as_ref().and_then(|p| p.error),
        scene: args
            .scene
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        ..built.metadata
    };
    let mut written = Vec::new();
    for path in outputs.paths() {
        match film::write_somewhere(path, &image, &metadata) {
            Ok(()) => written.push(path.display().to_string()),
            Err(error) => messages::error(error),
        }
    }
    let unwritten = outputs.paths().count() - written.len();
    if !args.quiet {
        report_end(&taken, job, &written, started, rendering);
    }
    Ok(Flaws {
        passed: diagnostics.recoverable_errors(),
        unwritten,
    })
}

/// What the command line says about the frame's options.
fn apply(args: &RenderArgs, frame: &mut Frame) -> Result<(), String> {
    if args.quick {
        frame.make_quick();
    }
    let options = &mut frame.options;
    // Where it is only the most, the scene's own number still says how textures are filtered.
    if let Some(spp) = args.spp.filter(|_| args.goal.goal(None).is_none()) {
        options.sampler = options.sampler.clone().with_spp(spp);
    }
    let scene_crops = options.film.crop_window != [0.0, 1.0, 0.0, 1.0];
    let crop = args
        .crop
        .as_ref()
        .or(args.cropwindow.as_ref().filter(|_| !scene_crops));
    if let Some(crop) = crop {
        options
            .film
            .set_crop(crop)
            .map_err(|e| format!("--crop: {e}"))?;
    }
    Ok(())
}

fn report_start(built: &build::PreparedScene) {
    for line in &built.description {
        console::say(line);
    }
}

/// In words, where a path went wrong.
fn place(job: &RenderJob, place: Option<Place>) -> String {
    let Some(Place { depth, met }) = place else {
        return "before its path began".to_string();
    };
    let met = match met {
        Met::Background => "in the light from beyond the scene".to_string(),
        Met::Medium => "in a medium".to_string(),
        Met::Surface(None) => "at a surface without material".to_string(),
        Met::Surface(Some(id)) => {
            let material = job.world.materials.get(id.index());
            format!("at a `{}`", material.map_or("?", Material::name))
        }
    };
    format!("{met} at depth {depth}")
}

/// The image as it was taken.
struct RenderedFilm {
    film: film::Film,
    /// Samples a pixel on average.
    spp: f64,
    /// The first sample that was dropped, and where on its path.
    first_dropped: Option<(DroppedSample, Option<Place>)>,
    /// Where it was rendered in passes: how good it became.
    progressive: Option<PassesSummary>,
}

/// How a render in passes ended.
struct PassesSummary {
    /// `None` where it is not known.
    error: Option<f64>,
    passes: u32,
    ended: Ended,
}

/// Renders the image: with the scene's number of samples, or until it is good enough.
fn take(args: &RenderArgs, job: &RenderJob) -> RenderedFilm {
    let Some(goal) = args.goal.goal(args.spp) else {
        let pixels = job.film.pixel_bounds().area() as u64;
        let progress = Progress::new(pixels, job.sampler.spp(), args.quiet);
        let film = render::render(job, args.tile_size, &progress);
        progress.finish();
        let located = |dropped| (dropped, render::locate(job, &job.sampler, dropped));
        return RenderedFilm {
            first_dropped: film.first_dropped().map(located),
            film,
            spp: f64::from(job.sampler.spp()),
            progressive: None,
        };
    };
    let progress = Progress::of_passes(args.quiet);
    // The size of tiles decides which pixels share their number of samples.
    let done = render::render_until(job, render::TILE_SIZE, &goal, &progress);
    progress.finish();
    let located = |(dropped, sampler)| (dropped, render::locate(job, &sampler, dropped));
    RenderedFilm {
        first_dropped: done.first_dropped.map(located),
        film: done.film,
        spp: done.spp,
        progressive: Some(PassesSummary {
            error: done.error,
            passes: done.passes,
            ended: done.ended,
        }),
    }
}

fn report_end(
    taken: &RenderedFilm,
    job: &RenderJob,
    written: &[String],
    started: Instant,
    rendering: Instant,
) {
    let film = &taken.film;
    let samples = film.bounds().area() as f64 * taken.spp;
    let seconds = rendering.elapsed().as_secs_f64();
    if let Some((first, at)) = taken.first_dropped {
        messages::warning(format!(
            "{} of the samples were not finite and count as black; the first is sample {} of pixel \
             {}, {} (both from 0), {}",
            film.dropped(),
            first.sample,
            first.pixel.x,
            first.pixel.y,
            place(job, at)
        ));
    }
    let written = match written {
        [] => "not written".to_string(),
        written => written.join(" and "),
    };
    let quality = match &taken.progressive {
        None => format!("{} samples a pixel", taken.spp),
        Some(reached) => quality(reached, film, taken.spp),
    };
    console::say(format_args!(
        "{written}: {quality}, {:.2} s ({:.2} M samples/s), {:.2} s in all",
        seconds,
        samples / seconds / 1e6,
        started.elapsed().as_secs_f64(),
    ));
}

/// How good an image rendered in passes is.
fn quality(reached: &PassesSummary, film: &film::Film, spp: f64) -> String {
    let black = film.pixels().iter().all(|p| p.mean() == glam::DVec3::ZERO);
    let error = match reached.error {
        Some(error) => format!("relative error {:.3} %", 100.0 * error),
        None if black => "no light was found".to_string(),
        None => "unknown error (no noise was found)".to_string(),
    };
    format!(
        "{error} after {spp:.1} samples a pixel on average in {} passes ({})",
        reached.passes,
        match reached.ended {
            Ended::Error => "good enough",
            Ended::Time => "time is up",
            Ended::Samples => "no more samples allowed",
        }
    )
}
