//! The study of one scene.

use super::candidates::{Candidate, Setting, candidates};
use super::clock::processor_time;
use super::measure::{Measurement, Reference};
use super::recommendation::{Recommendation, recommend};
use crate::build::{PreparedScene, reset};
use crate::cameras::CameraError;
use crate::render::{Ended, Goal, Progress, RenderJob, TILE_SIZE, render, render_until};
use crate::scene::options::Options;
use crate::session::{Prepared, on_threads};
use std::time::{Duration, Instant};

/// Settings of a study.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Total time.
    pub time: Duration,
    /// The relative error to recommend a setting for.
    pub target: f64,
    /// Seed of all random samples.
    pub seed: u64,
}

/// The results of a study.
#[derive(Clone, Debug)]
pub struct Study {
    /// Resolution of the images in pixels.
    pub resolution: [u32; 2],
    /// Relative error of the reference.
    pub reference_error: f64,
    /// Its samples per pixel.
    pub reference_spp: f64,
    /// Average number of processors in use: CPU time divided by this is wall-clock time.
    pub processors: f64,
    /// Every setting with its error and cost; the unchanged scene first.
    pub measured: Vec<(Candidate, Measurement)>,
    /// Settings that could not be rendered, and why.
    pub failed: Vec<(Candidate, CameraError)>,
    /// The squared error falls with the samples to the power −`slope`.
    pub slope: Option<f64>,
    /// The recommended settings.
    pub recommendation: Option<Recommendation>,
    /// The result of rendering the recommendation; `None` if it would have taken too long.
    pub verified: Option<Measurement>,
}

/// Images of each setting: the fewest that give a meaningful confidence interval.
const IMAGES: u64 = 5;

/// Maximum number of times that samples are added if the recommendation turns out to be too few.
const ATTEMPTS: u64 = 3;

/// Fraction of the time for the reference: as much as for all settings together, since its error limits the accuracy of
/// theirs.
const FOR_REFERENCE: f64 = 0.45;
/// Fraction for the settings; the rest is for the recommendation.
const FOR_SETTINGS: f64 = 0.4;

/// Studies a frame, on its threads. `say` hears what is being done.
///
/// # Errors
/// The threads that the system does not give; a camera that cannot be made anew, in words.
pub fn study(
    frame: Prepared,
    settings: &Settings,
    say: &(dyn Fn(String) + Sync),
) -> Result<Study, String> {
    let threads = frame.threads();
    let (scene, options) = (frame.scene, frame.scene_options);
    let study = || study_scene(scene, &options, settings, say).map_err(|error| error.to_string());
    on_threads(threads, study)?
}

fn study_scene(
    mut built: PreparedScene,
    options: &Options,
    settings: &Settings,
    say: &dyn Fn(String),
) -> Result<Study, CameraError> {
    let job = &mut built.job;
    let total = settings.time.as_secs_f64();
    say("rendering the reference".into());
    reset(job, options, seed(settings.seed, 0))?;
    let goal = Goal {
        error: None,
        time: Some(Duration::from_secs_f64(FOR_REFERENCE * total)),
        max_spp: Goal::MAX_SPP,
    };
    let (started, worked) = (Instant::now(), processor_time());
    let done = render_until(job, TILE_SIZE, &goal, &Progress::hidden());
    debug_assert!(done.ended != Ended::Error);
    let waited = started.elapsed().as_secs_f64().max(1e-9);
    let spp_per_second = done.spp / waited;
    let processors = ((processor_time() - worked).as_secs_f64() / waited).max(0.01);
    // Without any noise there is none to subtract.
    let reference_error = done.error.unwrap_or(0.0);
    let reference = Reference::new(done.film.develop(), reference_error);

    // The sample candidates end at four times the count of the other settings, and all of them together cost twice the
    // last one.
    let spp_in = |seconds: f64| seconds * spp_per_second / IMAGES as f64;
    let settings_count = candidates(options, 1, &[]).len() as f64;
    let affordable = spp_in(FOR_SETTINGS * total) / (settings_count + 2.0 * 4.0);
    let spp = power_of_two(affordable);
    let counts: Vec<u32> = (0..8)
        .map(|k| (4 * spp) >> k)
        .take_while(|&n| n > 0)
        .collect();
    let candidates = candidates(options, spp, &counts);
    let mut images: Vec<Images> = candidates.into_iter().map(Images::new).collect();
    for turn in 0..IMAGES {
        say(format!("settings, round {} of {IMAGES}", turn + 1));
        for value in &mut images {
            value.take(job, settings.seed, turn + 1);
        }
    }
    let (mut measured, mut failed) = (Vec::new(), Vec::new());
    for value in images {
        match value.failure {
            Some(error) => failed.push((value.candidate, error)),
            None => {
                let spp = value.candidate.options.sampler.spp;
                let m = Measurement::new(&reference, spp, &value.images, &value.seconds);
                measured.push((value.candidate, m));
            }
        }
    }
    let mut recommendation = recommend(&measured, settings.target);
    let mut verified = None;
    let mut images_taken = IMAGES;
    while let Some(advice) = &mut recommendation {
        // Some time is kept regardless of how long the settings took.
        let left = (total - started.elapsed().as_secs_f64()).max(0.1 * total);
        if advice.seconds / processors * 3.0 > left {
            break;
        }
        say(format!(
            "rendering the recommendation, {} samples a pixel",
            advice.spp
        ));
        let mut value = Images::new(advised(options, &measured, advice));
        for _ in 0..3 {
            images_taken += 1;
            value.take(job, settings.seed, images_taken);
        }
        let m = Measurement::new(&reference, advice.spp, &value.images, &value.seconds);
        let miss = m.error().value / settings.target;
        advice.seconds = m.seconds.value;
        verified = Some(m);
        if miss <= 1.0 {
            break;
        }
        if images_taken >= IMAGES + 3 * ATTEMPTS {
            break;
        }
        // The rendered settings are no longer the recommended ones.
        verified = None;
        advice.ask_for_more(miss);
    }
    let size = job.film.pixel_bounds().size();
    Ok(Study {
        resolution: [size.x, size.y],
        reference_error,
        reference_spp: done.spp,
        processors,
        slope: super::recommendation::slope(&measured),
        measured,
        failed,
        recommendation,
        verified,
    })
}

/// The images of one setting so far.
struct Images {
    candidate: Candidate,
    images: Vec<crate::film::Image>,
    seconds: Vec<f64>,
    failure: Option<CameraError>,
}

impl Images {
    fn new(candidate: Candidate) -> Images {
        Images {
            candidate,
            images: Vec::new(),
            seconds: Vec::new(),
            failure: None,
        }
    }

    fn take(&mut self, job: &mut RenderJob, study_seed: u64, number: u64) {
        if self.failure.is_some() {
            return;
        }
        if let Err(error) = reset(job, &self.candidate.options, seed(study_seed, number)) {
            self.failure = Some(error);
            return;
        }
        let started = processor_time();
        let film = render(job, TILE_SIZE, &Progress::hidden());
        self.seconds
            .push((processor_time() - started).as_secs_f64());
        self.images.push(film.develop());
    }
}

/// The scene with all recommended settings.
fn advised(
    options: &Options,
    measured: &[(Candidate, Measurement)],
    advice: &Recommendation,
) -> Candidate {
    let mut all = options.clone();
    for &i in &advice.turned {
        let (candidate, _) = &measured[i];
        match candidate.setting {
            Setting::Sampler => all.sampler = candidate.options.sampler.clone(),
            Setting::MaxDepth | Setting::LightChoice => turn_integrator(&mut all, candidate),
            Setting::LensModel | Setting::Precision | Setting::PupilSampling => {
                turn_camera(&mut all, candidate)
            }
            Setting::Scene | Setting::Samples | Setting::Filter => {}
        }
    }
    all.sampler = all.sampler.with_spp(advice.spp);
    Candidate {
        setting: Setting::Scene,
        value: "as recommended".into(),
        options: all,
    }
}

fn turn_camera(all: &mut Options, candidate: &Candidate) {
    use crate::cameras::CameraSpec::Realistic;
    if let (Realistic(to), Realistic(from)) = (&mut all.camera, &candidate.options.camera) {
        match candidate.setting {
            Setting::LensModel => to.model = from.model,
            Setting::Precision => to.precision = from.precision,
            _ => to.pupil_sampling = from.pupil_sampling,
        }
    }
}

fn turn_integrator(all: &mut Options, candidate: &Candidate) {
    use crate::integrators::{
        IntegratorSpec::{Path, VolPath},
        VolPath as Walk,
    };
    let (to, from) = (&mut all.integrator.spec, &candidate.options.integrator.spec);
    match (to, from) {
        (Path(to), Path(from)) | (VolPath(Walk { path: to }), VolPath(Walk { path: from })) => {
            match candidate.setting {
                Setting::MaxDepth => to.max_depth = from.max_depth,
                _ => to.light_strategy = from.light_strategy,
            }
        }
        (to, from) => *to = from.clone(),
    }
}

/// Seeds of the study's images: far from those that a user would try.
fn seed(study: u64, image: u64) -> u64 {
    crate::math::hash::mix2(study ^ 0x7261_6465_6f66_6600, image)
}

/// The largest power of two not above `x`, at least 1.
fn power_of_two(x: f64) -> u32 {
    1 << (x.max(1.0).log2().floor().min(20.0) as u32)
}
