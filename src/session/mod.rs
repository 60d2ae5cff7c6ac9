//! From a scene file to an image, as programs that embed fstop do it, `fstop render` among them.
//!
//! ```text
//! Scene::load ──▶ Scene ──into_frames──▶ Frame ──prepare──▶ Prepared ──render──▶ Rendered ──write──▶ file
//!  or Problems     Problems                     or Problems   Problems   Step
//! ```

mod identity;
mod merge;
mod options;
mod outputs;
mod problems;
mod rendered;
mod shards;

pub use crate::budget::OverBudget;
pub use crate::checkpoint::{CheckpointError, Plan, PlanError, Shard};
pub use crate::denoise::{DenoiseError, Denoiser};
pub use crate::files::FileError;
pub use crate::forecast::{Forecast, Process, Stage as MemoryStage, Use as MemoryUse};
pub use crate::render::{Ended, Live, Step};
pub use merge::{MergeError, Merged, merge};
pub use options::{Checkpoint, Policy, ReadOptions, RenderOptions};
pub(crate) use outputs::check_png;
pub use outputs::{OutputNames, Outputs};
pub use problems::Problems;
pub use rendered::{DroppedSamples, Rendered};
pub use shards::{ShardError, ShardFile, Shards, Unfinished};

pub(crate) use crate::budget::{Bytes, parse_size};
use crate::build::{self, PreparedScene};
use crate::cameras::CameraSpec;
use crate::checkpoint::{Identity, Journal, Keep};
use crate::film;
use crate::film::{Encoding, FilmMetadata, Layer, LayerSet, Manifest, NO_GROUP};
use crate::forecast;
use crate::integrators::Counts;
use crate::params::{Dialect, NamedFile};
use crate::render::{Mattes, Statistics};
pub(crate) use crate::render::{THREADS_PER_PROCESSOR, TILE_SIZE, on_threads, threads_started};
use crate::scene::{self, Names, read_scene};
use crate::syntax::{Diagnostic, Diagnostics, FileId, SourceError, SourceMap};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// A scene file that was read: fit to be rendered as far as its text tells.
pub struct Scene {
    name: String,
    sources: Rc<SourceMap>,
    policy: Policy,
    dialect: Dialect,
    frames: Vec<scene::Frame>,
    problems: Problems,
    /// What it was read with.
    reading: BTreeMap<String, String>,
}

impl Scene {
    /// Reads a scene file with all that it includes; `-` is standard input. Meshes and images are loaded by
    /// [`Frame::prepare`].
    ///
    /// # Errors
    /// All problems, those of meshes and images among them, if the policy of `options` refuses the scene.
    pub fn load(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Scene, Problems> {
        Reading::new(options)?.file(path.as_ref())?.scene()
    }

    /// Reads a scene from a text; messages call it `name`. Its files are looked for in the working directory.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn parse(
        name: &str,
        text: impl Into<Vec<u8>>,
        options: &ReadOptions,
    ) -> Result<Scene, Problems> {
        let mut reading = Reading::new(options)?;
        reading.name = name.to_string();
        let main = reading.sources.add_text(name, text);
        reading.read(main);
        reading.scene()
    }

    /// Finds every problem of a scene file, of what it includes and of the meshes and images that it names.
    #[must_use]
    pub fn check(path: impl AsRef<Path>, options: &ReadOptions) -> Problems {
        let reading = Reading::new(options).and_then(|reading| reading.file(path.as_ref()));
        match reading {
            Ok(reading) => reading.all_problems(),
            Err(problems) => problems,
        }
    }

    /// What was found in the file: warnings, notes, and errors that the policy forgives.
    pub fn problems(&self) -> &Problems {
        &self.problems
    }

    /// The memory that rendering each frame will take at most, with one thread for each processor of this machine; the scene was read since
    /// `before`, when [`Process::measured`] was called. Nothing is loaded: files are known by their headers.
    ///
    /// # Errors
    /// A file that cannot be used, by name.
    pub fn forecasts(&self, before: &Process) -> Result<Vec<Forecast>, FileError> {
        let frames = self.frames.iter();
        frames.map(|frame| forecast::of(frame, before)).collect()
    }

    /// Whose defaults and meanings the file was read with.
    pub fn dialect(&self) -> Dialect {
        self.dialect
    }

    /// The images that the file describes; nearly always one.
    pub fn into_frames(self) -> Vec<Frame> {
        let files = Arc::default();
        let frame = |(number, frame)| Frame {
            about: About {
                name: self.name.clone(),
                number,
                sources: Rc::clone(&self.sources),
                policy: self.policy,
                reading: self.reading.clone(),
                files: Arc::clone(&files),
            },
            frame,
        };
        (1..).zip(self.frames).map(frame).collect()
    }

    /// Renders the first frame. `progress` is called now and then, by any of the threads.
    ///
    /// # Errors
    /// As [`Frame::prepare`].
    pub fn render(
        self,
        options: &RenderOptions,
        progress: &(dyn Fn(Step) + Sync),
    ) -> Result<Rendered, Problems> {
        let first = self.into_frames().into_iter().next();
        // A scene without a frame has been refused.
        let frame = first.ok_or_else(|| Problems::one("the file describes no image"))?;
        Ok(frame.prepare(options)?.render(progress))
    }

    /// The files that the frames are written to, and what is odd about their names. None of them exists yet; that they
    /// can be written is checked as far as it can be before rendering.
    ///
    /// # Errors
    /// A file that cannot be written, that the scene reads, or that another image is written to; or a problem that the policy
    /// refuses.
    pub fn outputs(&self, names: &OutputNames) -> Result<(Vec<Outputs>, Problems), Problems> {
        let diagnostics = Diagnostics::new();
        let outputs = outputs::of_frames(names, &self.frames, &diagnostics);
        outputs::check(names, &self.frames, &outputs, &self.sources, &diagnostics);
        let problems = Problems::new(&diagnostics, &self.sources, self.policy);
        if problems.refused() {
            Err(problems)
        } else {
            Ok((outputs, problems))
        }
    }

    /// Returns `true` if a frame's camera has a lens that is set.
    pub(crate) fn has_lens(&self) -> bool {
        let cameras = self.frames.iter().map(|frame| &frame.options.camera);
        { cameras }.any(|camera| matches!(camera, CameraSpec::Realistic(_)))
    }

    /// The files that were read, and those that [`Frame::prepare`] will read.
    pub(crate) fn files_read(&self) -> Vec<PathBuf> {
        self.sources.files_read()
    }

    /// Loads the files of all frames but the first, and lets them go again, on `threads` threads: a broken mesh of the
    /// last frame is found before the first one is rendered.
    ///
    /// # Errors
    /// What the policy refuses; all else is reported when the frame's turn comes.
    pub fn check_later_frames(&self, threads: usize) -> Result<(), Problems> {
        let Some((_, later)) = self.frames.split_first() else {
            return Ok(());
        };
        let diagnostics = on_threads(threads, || {
            let diagnostics = Diagnostics::new();
            for frame in later {
                build::check(frame, &diagnostics);
            }
            diagnostics
        })
        .map_err(|error| Problems::one_if(error, true))?;
        let problems = Problems::new(&diagnostics, &self.sources, self.policy);
        if problems.refused() {
            Err(problems)
        } else {
            Ok(())
        }
    }
}

/// One image of a scene.
pub struct Frame {
    about: About,
    frame: scene::Frame,
}

impl Frame {
    /// Width and height of the whole film in pixels.
    pub fn resolution(&self) -> [u32; 2] {
        self.frame.options.film.resolution.to_array()
    }

    /// Makes the film smaller, at the same aspect, until it has at most `pixels` pixels.
    pub fn shrink(&mut self, pixels: u32) {
        self.frame.options.film.shrink(pixels);
    }

    /// Loads meshes and images, builds the trees, and opens the checkpoint.
    ///
    /// # Errors
    /// A checkpoint of another render, or one that cannot be made. Files that cannot be used, what memory has no room for, and whatever else the policy refuses; a crop window
    /// without a pixel; threads that the system does not give.
    pub fn prepare(mut self, options: &RenderOptions) -> Result<Prepared, Problems> {
        let light_layers = self.apply_options(options).map_err(Problems::one)?;
        let Frame { about, frame } = self;
        let scene_options = frame.options.clone();
        let wanted = frame.options.film.layers;
        let names = wanted
            .has_mattes()
            .then(|| Names::of(&frame, &about.sources));
        let built = on_threads(options.threads, || build::build(frame, options.seed));
        let (scene, diagnostics) = built.map_err(|error| Problems::one_if(error, true))?;
        let problems = Problems::new(&diagnostics, &about.sources, about.policy);
        let Some(mut scene) = scene.filter(|_| !problems.refused()) else {
            return Err(problems);
        };
        if wanted.contains(Layer::Motion) && !scene.job.camera.connects() {
            return Err(Problems::one(NO_MOTION));
        }
        scene.metadata.light_layers = light_layers;
        if let Some(names) = &names {
            set_cryptomatte_names(&mut scene, names);
        }
        // Last, so that no checkpoint gives way to a render that never starts.
        let identity = about.identity(&scene_options.film, options);
        let (journal, replaced) = journal(&identity, options, scene.job.has_splats())
            .map_err(|error| Problems::one_if(error.to_string(), error.is_failure()))?;
        Ok(Prepared {
            identity,
            name: about.name,
            scene,
            scene_options,
            options: options.clone(),
            problems,
            journal,
            replaced,
            live: None,
            statistics: None,
        })
    }

    /// Applies the options, as far as they suit the frame. Returns the names of the layers of light.
    fn apply_options(&mut self, options: &RenderOptions) -> Result<Vec<String>, String> {
        options.apply(&mut self.frame)?;
        if self.frame.options.integrator.spec.gathers_photons() {
            refuse_confidence_with_photons(options)?;
            refuse_layers_with_photons(&self.frame.options.film)?;
        }
        Ok(light_layers(&self.frame)?)
    }
}

/// What is known of a frame besides its contents.
struct About {
    name: String,
    number: usize,
    sources: Rc<SourceMap>,
    policy: Policy,
    reading: BTreeMap<String, String>,
    /// Hashes of the scene's files, once they are needed: all frames were read from the same.
    files: Arc<OnceLock<BTreeMap<String, String>>>,
}

impl About {
    /// What a frame's image depends on. Hashing the files is left until it is asked for.
    fn identity(
        &self,
        film: &film::FilmSpec,
        options: &RenderOptions,
    ) -> Arc<dyn Fn() -> Identity + Send + Sync> {
        let settings = identity::settings(self.number, film, &self.reading, options);
        let main = (self.name.clone(), identity::hash_of_main(&self.sources));
        let (named, files) = (self.sources.named_files(), Arc::clone(&self.files));
        Arc::new(move || Identity {
            program: identity::program(),
            files: files.get_or_init(|| identity::files(&main, &named)).clone(),
            settings: settings.clone(),
        })
    }
}

/// No bound on the error of `sppm`: pixels that share photons do not tell each other's noise.
fn refuse_confidence_with_photons(options: &RenderOptions) -> Result<(), &'static str> {
    match options.confidence {
        Some(_) => Err(
            "--confidence: pixels of `sppm` share photons, so that their differences do not tell how sure the error is: \
             leave the option out",
        ),
        None => Ok(()),
    }
}

/// What the layers of light are called, if any are wanted.
fn light_layers(frame: &scene::Frame) -> Result<Vec<String>, &'static str> {
    let names = frame.light_groups.names.iter().map(String::as_str);
    let strategies = frame.options.integrator.spec.strategies();
    match frame.options.film.layers.lights() {
        0 => Ok(Vec::new()),
        _ if !strategies.is_empty() => Ok(strategies),
        _ if names.len() == 0 => Err(
            "--aov lights: no light of the scene is in a group: say, `LightSource \"point\" \"string group\" \"key\"`, or leave the layer out",
        ),
        _ => Ok({ [NO_GROUP].into_iter().chain(names) }
            .map(|group| format!("light_{group}"))
            .collect()),
    }
}

/// Gives Cryptomattes the names of materials, shapes and instances.
fn set_cryptomatte_names(scene: &mut PreparedScene, names: &Names) {
    let Names {
        materials,
        shapes,
        instances,
    } = names;
    scene.job.mattes = Mattes::new(materials, shapes, instances);
    scene.metadata.manifests = vec![
        Manifest::new(Layer::Material, materials),
        Manifest::new(Layer::Instance, instances.iter().chain(shapes)),
    ];
}

/// Motion, where it is not known from where on the film a point is seen.
const NO_MOTION: &str = "--aov motion: of this camera it is not known where on its film a point of the scene is seen (it is placed by a \
    projection, imitates pbrt-v2, or its lens is not the traced one): leave the layer out";

/// `sppm` has no layers: its camera paths gather photons, and there are no others.
fn refuse_layers_with_photons(film: &film::FilmSpec) -> Result<(), String> {
    match film.layers {
        LayerSet::NONE => Ok(()),
        layers => Err(format!(
            "layers {layers}: `sppm` makes no layers: leave them out (`--aov`, or `aov` of the `Film`), or render them by themselves with `Integrator \"path\"` \
             and a few samples, as no layer depends on the integrator",
        )),
    }
}

/// The checkpoint, and what was wrong with the one that it replaces.
fn journal(
    identity: &Arc<dyn Fn() -> Identity + Send + Sync>,
    options: &RenderOptions,
    has_splats: bool,
) -> Result<(Option<Journal>, Vec<String>), CheckpointError> {
    let Some(checkpoint) = &options.checkpoint else {
        return Ok((None, Vec::new()));
    };
    let keep = Keep {
        path: &checkpoint.path,
        identity,
        facts: None,
        // Passes that the clock has planned are continued only if all of them are known; so are those with light paths.
        after: match options.time.is_some() || has_splats && options.goal().is_some() {
            true => Duration::ZERO,
            false => checkpoint.after,
        },
        every: checkpoint.every,
    };
    match Journal::open(&keep) {
        Err(CheckpointError::Differs { differences, .. }) if !checkpoint.required => {
            Ok((Some(Journal::replacing(&keep)), differences))
        }
        Err(CheckpointError::OtherVersion(_)) if !checkpoint.required => {
            let difference = "it is of another version of fstop, or damaged".to_string();
            Ok((Some(Journal::replacing(&keep)), vec![difference]))
        }
        opened => Ok((Some(opened?), Vec::new())),
    }
}

/// A frame with all that rendering needs in memory.
pub struct Prepared {
    name: String,
    pub(crate) scene: PreparedScene,
    pub(crate) scene_options: scene::options::Options,
    options: RenderOptions,
    problems: Problems,
    journal: Option<Journal>,
    replaced: Vec<String>,
    identity: Arc<dyn Fn() -> Identity + Send + Sync>,
    /// The image as it grows, if somebody looks.
    live: Option<Arc<Live>>,
    /// What its paths do, if somebody asks.
    statistics: Option<Statistics>,
}

impl Prepared {
    /// What was found in the files: warnings, notes, and errors that the policy forgives.
    pub fn problems(&self) -> &Problems {
        &self.problems
    }

    pub(crate) fn threads(&self) -> usize {
        self.options.threads
    }

    pub(crate) fn threads_started(&self) -> usize {
        threads_started(self.options.threads)
    }

    /// The image as it will grow while [`Prepared::render`] works, to be looked at by any thread.
    pub fn live(&mut self) -> Arc<Live> {
        let film = &self.scene.job.film;
        Arc::clone(self.live.get_or_insert_with(|| Arc::new(Live::new(film))))
    }

    /// Paths will be counted, where the integrator can.
    pub(crate) fn count(&mut self) {
        let job = &self.scene.job;
        let gathers = job.integrator.photons(&job.world).is_some();
        self.statistics = (!gathers).then(|| Statistics::new(&job.world));
    }

    /// What has been counted, by this process.
    pub(crate) fn counts(&self) -> Option<Counts> {
        self.statistics.as_ref().map(Statistics::counts)
    }

    /// What an image's file says of it, but for what is known at its end.
    pub(crate) fn metadata(&self) -> FilmMetadata {
        rendered::metadata(&self.scene, &self.name, &self.options)
    }

    /// How its files store numbers.
    pub(crate) fn encoding(&self) -> Encoding {
        self.options.encoding
    }

    /// What a photographer wants to know of the camera, one fact a line.
    pub fn description(&self) -> &[String] {
        &self.scene.description
    }

    /// Where there is a checkpoint to continue, the time that was spent on it.
    pub fn resumes(&self) -> Option<Duration> {
        let journal = self.journal.as_ref().filter(|journal| journal.resumes());
        journal.map(Journal::spent)
    }

    /// Bytes at the end of the checkpoint that could not be used: cut off, or damaged.
    pub(crate) fn lost(&self) -> u64 {
        self.journal.as_ref().map_or(0, Journal::lost)
    }

    /// What is different in the render whose checkpoint is replaced; empty if there was none.
    pub fn replaced(&self) -> &[String] {
        &self.replaced
    }

    /// Writes what the checkpoint does not have yet. Returns whether there is one, and what went wrong with writing it,
    /// now or before: it holds what was written until then.
    pub fn keep(&self) -> (bool, Option<CheckpointError>) {
        self.journal.as_ref().map_or((false, None), Journal::flush)
    }

    /// Removes the checkpoint, when the image is safe.
    ///
    /// # Errors
    /// A folder that lets nothing go.
    pub fn forget(&self) -> Result<(), CheckpointError> {
        self.journal.as_ref().map_or(Ok(()), Journal::remove)
    }

    /// Renders the image: a pure function of scene, options and seed, but for the options that count time.
    /// `progress` is called now and then, by any of the threads.
    pub fn render(&self, progress: &(dyn Fn(Step) + Sync)) -> Rendered {
        let journal = self.journal.as_ref();
        let seen = (self.live.as_deref(), self.statistics.as_ref());
        let take = || {
            rendered::take(
                &self.scene,
                &self.name,
                &self.options,
                (journal, seen),
                progress,
            )
        };
        // Threads that were there a moment ago: if the system refuses them now, those that are there do it.
        on_threads(self.options.threads, take).unwrap_or_else(|_| take())
    }
}

/// A scene file being read.
struct Reading<'a> {
    name: String,
    sources: Rc<SourceMap>,
    options: &'a ReadOptions,
    dialect: Dialect,
    frames: Vec<scene::Frame>,
    diagnostics: Diagnostics,
}

impl<'a> Reading<'a> {
    fn new(options: &'a ReadOptions) -> Result<Reading<'a>, Problems> {
        Ok(Reading {
            name: String::new(),
            sources: Rc::new(options.sources().map_err(Problems::one)?),
            options,
            dialect: Dialect::V3,
            frames: Vec::new(),
            diagnostics: Diagnostics::new(),
        })
    }

    /// `-` is standard input.
    fn file(mut self, path: &Path) -> Result<Self, Problems> {
        let main: Result<FileId, SourceError> = match path == Path::new("-") {
            true => self.sources.open_stdin(),
            false => self.sources.open(path),
        };
        self.name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let main =
            main.map_err(|error| Problems::one_if(error.to_string(), error.problem.is_failure()))?;
        self.read(main);
        Ok(self)
    }

    fn read(&mut self, main: FileId) {
        let (scene, diagnostics) = read_scene(&self.sources, main, &self.options.settings());
        (self.dialect, self.frames) = (scene.dialect, scene.frames);
        self.diagnostics = diagnostics;
    }

    fn problems(&self) -> Problems {
        Problems::new(&self.diagnostics, &self.sources, self.options.policy)
    }

    fn scene(self) -> Result<Scene, Problems> {
        let problems = self.problems();
        if problems.refused() {
            // All at once, so that the scene can be mended in one go.
            return Err(self.all_problems());
        }
        Ok(Scene {
            name: self.name,
            sources: self.sources,
            policy: self.options.policy,
            dialect: self.dialect,
            frames: self.frames,
            problems,
            reading: identity::of_reading(self.options),
        })
    }

    /// Adds what only shows when the files of the frames are loaded, and what is wrong with the names of their images.
    fn all_problems(self) -> Problems {
        for frame in &self.frames {
            if let Some(file) = &frame.options.film.filename {
                if let Err(error) = film::check_name(&file.path) {
                    self.diagnostics
                        .push(Diagnostic::error(error.to_string()).at(file.span));
                }
                check_place(file, &self.sources, &self.diagnostics);
            }
            build::check(frame, &self.diagnostics);
        }
        self.problems()
    }
}

/// Reports an image that the scene would have written outside of the only folder it may use.
fn check_place(file: &NamedFile, sources: &SourceMap, diagnostics: &Diagnostics) {
    let folder = sources.search_folder(file.span.file);
    if let Err(problem) = folder.admits_output(&file.path) {
        let message = format!("the image cannot be `{}`: {problem}", file.path.display());
        let diagnostic = Diagnostic::error(message).at(file.span);
        diagnostics.push(diagnostic.with_help("name another: -o image.exr"));
    }
}
