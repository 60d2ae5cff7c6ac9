//! `fstop render SCENE`: renders a scene file to an image.

use super::ReadArgs;
use super::checkpoint::{self, CheckpointArgs};
use super::codes::{ANSWER_IS_NO, BAD_INPUT, INTERRUPTED, IO_FAILED, LOST, exit_codes};
use super::encoding::EncodingArgs;
use super::events::{self, Events};
use super::goal::GoalArgs;
use super::live::{LiveArgs, Times};
use super::messages::{self, Failure};
use super::progress::{Bar, Form};
use super::shard::{self, ShardArgs};
use super::summary;
use super::values::{file_name, positive, whole};
use crate::console;
use crate::film::{LayerSet, WriteError};
use crate::session::{
    Denoiser, Frame, OutputNames, Outputs, Policy, Prepared, Problems, RenderOptions, Rendered,
    Scene, Step, THREADS_PER_PROCESSOR, TILE_SIZE, threads_started,
};
use clap::Args;
use clap::builder::{OsStringValueParser, TypedValueParser};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Once};
use std::time::{Duration, Instant};

/// Examples for the long help.
const EXAMPLES: &str = concat!(
    exit_codes!(),
    "\n\nExamples:
  fstop render scene.pbrt --error 1% -o image.exr --png image.png
  fstop render scene.pbrt --quick --lens-model thin"
);

/// Arguments of `fstop render`.
#[derive(Args, Debug)]
#[command(after_long_help = EXAMPLES)]
pub(super) struct RenderArgs {
    /// Scene file; `-` is standard input
    scene: PathBuf,
    /// Image to write (.exr, .png, .pfm, .tga); by default the one named by the scene's Film
    #[arg(
        help_heading = "Output",
        short,
        long = "output",
        visible_alias = "outfile",
        value_parser = OsStringValueParser::new().try_map(file_name),
        allow_hyphen_values = true
    )]
    output: Option<PathBuf>,
    /// Also write a PNG of the image here
    #[arg(help_heading = "Output", long, value_parser = OsStringValueParser::new().try_map(file_name), allow_hyphen_values = true)]
    png: Option<PathBuf>,
    /// Samples per pixel, instead of the scene's; with --error or --time the maximum, at least 8
    #[arg(help_heading = "When it is done", long, value_parser = positive, allow_negative_numbers = true)]
    spp: Option<u32>,
    /// Threads; by default one per processor, at most eight times as many
    #[arg(
        help_heading = "How it runs",
        long,
        visible_alias = "nthreads",
        default_value_t = 0,
        hide_default_value = true,
        allow_negative_numbers = true
    )]
    threads: usize,
    /// Seed of all random samples
    #[arg(
        help_heading = "When it is done",
        long,
        default_value_t = 0,
        value_parser = whole,
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
    /// The same as four arguments, as in pbrt; used only if the scene sets no crop window
    #[arg(help_heading = "What is rendered", long, num_args = 4, allow_negative_numbers = true, value_names = ["x0", "x1", "y0", "y1"])]
    cropwindow: Option<Vec<f64>>,
    /// Side of the square tiles that threads work on, in pixels; does not affect the image
    #[arg(help_heading = "How it runs", long, default_value_t = TILE_SIZE, hide = true)]
    tile_size: u32,
    /// Also write the variance of each pixel's mean (channels var.R, var.G, var.B): samples that depend on each other are
    /// then taken in two independent halves
    #[arg(help_heading = "Output", long)]
    variance: bool,
    /// Layers to write besides the image, into the same .exr file: albedo, normal, depth, position, uv, material, instance,
    /// motion, lights, coc, alpha, with commas between; instead of the scene's
    #[arg(help_heading = "Output", long, value_name = "LAYERS", value_parser = LayerSet::parse)]
    aov: Option<LayerSet>,
    /// Also write the image without its noise, as OUTPUT.denoised.exr, by Open Image Denoise, if that library is on this machine
    #[arg(help_heading = "Output", long, conflicts_with = "shard")]
    denoise: bool,
    /// A quick look: a quarter of the width and height, one sample per pixel, a quarter of the lights' samples
    #[arg(help_heading = "What is rendered", long)]
    quick: bool,
    /// How progress is shown on standard error: as lines of JSON, which the guide describes, a bar, a log, or not. By
    /// default a bar on a terminal and a log elsewhere, or with --quiet nothing
    #[arg(help_heading = "How it runs", long, value_enum, value_name = "FORM")]
    progress: Option<Form>,
    /// Print only errors
    #[arg(help_heading = "How it runs", long)]
    quiet: bool,
    /// Continue past errors that pbrt-v3 tolerates (missing files, undefined names), and exit with 1: textures' images
    /// become a gray of 0.5, lights emit without their maps, spectra are black, meshes and includes are left out, a
    /// lens becomes a pinhole of 27 degrees; a parameter with an undefined name gets its default, such a directive is
    /// left out
    #[arg(
        help_heading = "How the scene is read",
        long,
        conflicts_with = "strict"
    )]
    keep_going: bool,
    #[command(flatten)]
    encoding: EncodingArgs,
    #[command(flatten)]
    goal: GoalArgs,
    #[command(flatten)]
    checkpoint: CheckpointArgs,
    #[command(flatten)]
    shard: ShardArgs,
    #[command(flatten)]
    live: LiveArgs,
    #[command(flatten)]
    read: ReadArgs,
}

/// Renders every frame of the scene.
pub(super) fn run(args: &RenderArgs) -> u8 {
    let is_json = args.form() == Form::Json;
    let events = is_json.then(|| Events::start(&args.scene, args.output.as_deref()));
    let flaws = match render_scene(args, events.as_ref()) {
        Ok(flaws) => flaws,
        Err(End::Interrupted { kept: true }) => return INTERRUPTED,
        Err(End::Interrupted { kept: false }) => return LOST,
        Err(End::Failed(failure)) => return failure.exit(),
    };
    if flaws.passed > 0 {
        let errors = if flaws.passed == 1 { "error" } else { "errors" };
        messages::warning(format!(
            "rendered in spite of {} {errors}: the image is not that of the whole scene",
            flaws.passed
        ));
    }
    match flaws {
        Flaws {
            unwritten: Some(code),
            ..
        } => code,
        Flaws { passed: 0, .. } => 0,
        _ => ANSWER_IS_NO,
    }
}

impl RenderArgs {
    fn form(&self) -> Form {
        match self.progress {
            Some(form) => form,
            None if self.quiet => Form::None,
            None => Form::suited(),
        }
    }

    fn policy(&self) -> Policy {
        match self.keep_going {
            true => Policy::KeepGoing,
            false => self.read.policy(),
        }
    }

    fn options(&self) -> Result<RenderOptions, String> {
        let crop = |given: &Option<Vec<f64>>| {
            let window = given
                .as_ref()
                .map(|numbers| <[f64; 4]>::try_from(numbers.as_slice()));
            window
                .transpose()
                .map_err(|_| "--crop: expected four numbers x0,x1,y0,y1".to_string())
        };
        Ok(RenderOptions {
            spp: self.spp,
            error: self.goal.error,
            confidence: self.goal.confidence,
            time: self.goal.time,
            seed: self.seed,
            threads: self.threads,
            crop: crop(&self.crop)?,
            default_crop: crop(&self.cropwindow)?,
            quick: self.quick,
            variance: self.variance,
            layers: self.aov,
            denoise: self.denoise,
            encoding: self.encoding.encoding(),
            tile_size: self.tile_size,
            checkpoint: None,
            stop: Some(Arc::default()),
        })
    }

    /// Reads a scene as these options say.
    pub(super) fn scene(&self, path: &Path) -> Result<Scene, Problems> {
        Scene::load(path, &self.read.options(self.policy()))
    }

    /// Refuses a scene that cannot be rendered in shards with these options, as far as is known before its files are loaded.
    pub(super) fn check_shards(&self, scene: Scene) -> Result<(), Failure> {
        let options = self.options()?;
        let mut frames = scene.into_frames().into_iter();
        Ok(frames.try_for_each(|frame| frame.check_shards(&options))?)
    }

    pub(super) fn is_quiet(&self) -> bool {
        self.quiet
    }

    /// Loads a frame, and says what was found. From then on signals stop the render where it can be continued; before,
    /// nothing is lost, and they end the program as usual.
    pub(super) fn prepare(
        &self,
        frame: Frame,
        options: &RenderOptions,
        listening: &Once,
    ) -> Result<Prepared, Problems> {
        let frame = frame.prepare(options)?;
        self.print(frame.problems());
        if !self.quiet {
            frame.description().iter().for_each(console::say);
        }
        if let Some(stop) = &options.stop {
            listening.call_once(|| checkpoint::listen(stop));
        }
        Ok(frame)
    }

    /// Prints what was found, as far as it is asked for. Errors always are.
    fn print(&self, problems: &Problems) {
        if !self.quiet || problems.errors() > 0 {
            messages::print(problems);
        }
    }
}

/// What is wrong with the images of a scene that was rendered.
#[derive(Default)]
pub(super) struct Flaws {
    /// Number of errors tolerated.
    passed: usize,
    /// The exit code where files could not be written where they should be.
    unwritten: Option<u8>,
}

impl Flaws {
    pub(super) fn passed(passed: usize) -> Flaws {
        Flaws {
            passed,
            unwritten: None,
        }
    }
}

/// Why there is no image.
pub(super) enum End {
    /// Messages say it.
    Failed(Failure),
    /// A signal, and whether there is a checkpoint.
    Interrupted { kept: bool },
}

impl<T: Into<Failure>> From<T> for End {
    fn from(failure: T) -> End {
        End::Failed(failure.into())
    }
}

fn render_scene(args: &RenderArgs, events: Option<&Events>) -> Result<Flaws, End> {
    let began = Instant::now();
    let mut options = args.options()?;
    check_threads(args);
    let scene = args.scene(&args.scene)?;
    let reading = began.elapsed();
    args.print(scene.problems());
    if !args.quiet {
        args.read.warn_of_no_lens(&scene);
    }
    let mut flaws = Flaws {
        passed: scene.problems().recoverable_errors(),
        unwritten: None,
    };
    let names = OutputNames {
        image: args.output.clone(),
        png: args.png.clone(),
        denoised: args.denoise,
    };
    // Not after a night's work either.
    let denoiser = args.denoise.then(Denoiser::find).transpose()?;
    // All of them before the first is rendered: a misspelled folder should not be noticed after a night's work.
    let (outputs, problems) = scene.outputs(&names)?;
    let read = scene.files_read();
    let shards = args.shard.range()?;
    args.checkpoint.check(&outputs, &read)?;
    if shards.is_none() {
        checkpoint::check_unfinished(&outputs, &read)?;
    }
    args.live.check(&outputs, &read, &args.checkpoint)?;
    args.print(&problems);
    scene.check_later_frames(options.threads)?;
    warn_of_no_effect(args, &outputs, shards.is_some());
    let listening = Once::new();
    let frames = outputs.len();
    for ((frame, one), number) in { scene.into_frames() }.into_iter().zip(&outputs).zip(1..) {
        if { options.stop.as_ref() }.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
            let kept = shards.is_some();
            return Err(End::Interrupted { kept });
        }
        if let Some(events) = events {
            events.frame(number, frames, one);
        }
        let of_frame = match shards {
            Some(range) => {
                let every = args.checkpoint.every();
                let shards = args.shard.of_frame(range, one, number, every);
                let how = (&listening, events);
                shard::render_shards(args, &options, frame, &shards, how)?
            }
            None => {
                options.checkpoint = args.checkpoint.of_frame(one, number);
                let of = (one, number, reading, denoiser.as_ref());
                render_frame(args, &options, frame, of, (&listening, events))?
            }
        };
        flaws.passed += of_frame.passed;
        // Bad input, which is the smaller code, outweighs a full disk.
        flaws.unwritten = flaws.unwritten.into_iter().chain(of_frame.unwritten).min();
    }
    Ok(flaws)
}

/// Warns of options that these files, or shards, have no place for.
fn warn_of_no_effect(args: &RenderArgs, outputs: &[Outputs], in_shards: bool) {
    if in_shards {
        let [half, exposure] = args.encoding.given();
        shard::warn(&[("--png", args.png.is_some()), half, exposure]);
    } else if !args.quiet && !outputs.iter().any(Outputs::keep_variances) {
        if args.variance {
            messages::warning("--variance has no effect: only .exr files keep variances");
        }
        if args.aov.is_some() {
            messages::warning("--aov has no effect: only .exr files keep layers");
        }
    }
}

/// Warns of a request for more threads than are started.
fn check_threads(args: &RenderArgs) {
    let started = threads_started(args.threads);
    if args.threads > started && !args.quiet {
        let requested = args.threads;
        messages::warning(format!(
            "--threads {requested}: {started} are used, {THREADS_PER_PROCESSOR} for each processor"
        ));
    }
}

fn render_frame(
    args: &RenderArgs,
    options: &RenderOptions,
    frame: Frame,
    (outputs, number, reading, denoiser): (&Outputs, usize, Duration, Option<&Denoiser>),
    (listening, events): (&Once, Option<&Events>),
) -> Result<Flaws, End> {
    let started = Instant::now();
    let mut frame = args.prepare(frame, options, listening)?;
    if !args.quiet {
        checkpoint::announce(&frame);
    }
    let rendering = Instant::now();
    let is_open = args.goal.is_given();
    let mut onlookers = args.live.start(&mut frame, outputs, args.quiet);
    let rendered = watched(args, events, is_open, |report| frame.render(report));
    let partial = onlookers.stop_writing();
    if rendered.stopped {
        return Err(interrupted(args, &frame, &rendered, outputs));
    }
    let writing = Instant::now();
    if !args.quiet {
        let paths: Vec<_> = outputs.paths().collect();
        args.encoding.warn_of_names(&paths);
        args.encoding.warn_of_colors(&rendered.image);
    }
    let (mut written, mut unwritten) = write(&rendered, outputs.paths());
    if let Some(denoiser) = denoiser {
        let (more, failed) = write_denoised(&rendered, outputs, denoiser);
        written.extend(more);
        unwritten = unwritten.into_iter().chain(failed).min();
    }
    let times = Times {
        reading,
        started,
        rendering,
        writing,
    };
    if let Err(error) = args.live.write(&frame, &rendered, number, &times) {
        messages::error(format!("--stats {error}"));
        unwritten = unwritten.into_iter().chain([IO_FAILED]).min();
    }
    if !args.quiet {
        summary::print(&rendered, &written, started, rendering);
    }
    if unwritten.is_none() {
        clean_up(&frame, outputs);
        // Only what this render has left behind.
        for path in partial {
            let _ = std::fs::remove_file(path);
        }
    }
    onlookers.show(&rendered);
    Ok(Flaws {
        passed: frame.problems().recoverable_errors(),
        unwritten,
    })
}

/// Writes the image without its noise, as [`write`].
fn write_denoised(
    rendered: &Rendered,
    outputs: &Outputs,
    denoiser: &Denoiser,
) -> (Vec<String>, Option<u8>) {
    match rendered.denoised(denoiser) {
        Ok(denoised) => write(&denoised, outputs.denoised()),
        Err(error) => {
            messages::error(error);
            (Vec::new(), Some(IO_FAILED))
        }
    }
}

/// Writes the image. Returns the names of the files, and the exit code where one could not be written where it should be.
fn write(
    rendered: &Rendered,
    paths: impl Iterator<Item = impl AsRef<Path>>,
) -> (Vec<String>, Option<u8>) {
    let (mut written, mut unwritten) = (Vec::new(), None);
    for path in paths {
        let path = path.as_ref();
        match rendered.write_or_rescue(path) {
            Ok(()) => {
                events::written(path);
                written.push(path.display().to_string());
            }
            Err(error) => {
                if let WriteError::Elsewhere { place, .. } = &error {
                    events::written(place);
                    written.push(place.display().to_string());
                }
                let code = if error.is_failure() {
                    IO_FAILED
                } else {
                    BAD_INPUT
                };
                unwritten = unwritten.into_iter().chain([code]).min();
                messages::error(error);
            }
        }
    }
    (written, unwritten)
}

/// Runs what reports its steps, and shows them as is asked for. `in_passes`: its length is not known in advance.
pub(super) fn watched<T>(
    args: &RenderArgs,
    events: Option<&Events>,
    in_passes: bool,
    run: impl FnOnce(&(dyn Fn(Step) + Sync)) -> T,
) -> T {
    if let Some(events) = events {
        events.sampling(args.goal.time);
        let done = run(&|step| events.step(step));
        events.frame_done();
        return done;
    }
    if args.form() == Form::None {
        return run(&|_| ());
    }
    let bar = Bar::new(args.form(), in_passes);
    let done = run(&|step| bar.show(step));
    bar.finish();
    done
}

/// Removes what only an interrupted render needs.
fn clean_up(frame: &Prepared, outputs: &Outputs) {
    // Too late to help this render, but not the next one.
    if let (_, Some(error)) = frame.keep() {
        messages::warning(error);
    }
    if let Err(error) = frame.forget() {
        messages::warning(error);
    }
    // Only what this render has left behind: the name may be somebody else's.
    if frame.resumes().is_some() || !frame.replaced().is_empty() {
        for path in outputs.paths().map(checkpoint::partial) {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Keeps what there is of an interrupted render, and says how it continues.
fn interrupted(args: &RenderArgs, frame: &Prepared, rendered: &Rendered, outputs: &Outputs) -> End {
    let (kept, error) = frame.keep();
    if let Some(error) = error {
        messages::error(error);
    }
    let mut written = Vec::new();
    let has_samples = rendered.samples > 0.0;
    let partial = { outputs.paths() }.map(checkpoint::partial);
    for path in partial.filter(|_| has_samples) {
        match rendered.write(&path) {
            Ok(()) => {
                events::written(&path);
                written.push(path.display().to_string());
            }
            Err(error) => messages::error(error),
        }
    }
    if !args.quiet {
        let how = match kept {
            true => "the same command continues",
            false => "there is no checkpoint: the same command starts anew",
        };
        let spp = rendered.spp;
        let written = written.join(" and ");
        console::say(format_args!(
            "interrupted after {spp:.1} samples a pixel on average ({written}); {how}"
        ));
    }
    End::Interrupted { kept }
}
