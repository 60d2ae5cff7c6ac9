//! The study of one scene.

use super::candidates::{Candidate, candidates};
use super::clock::processor_time;
use super::measure::{Measurement, Reference};
use super::recommendation::{Recommendation, recommend, slope};
use crate::build::reset;
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
    let (mut scene, options) = (frame.scene, frame.scene_options);
    let work = || {
        let (job, options) = (&mut scene.job, &options);
        let steps = Steps {
            job,
            options,
            settings,
            say,
        };
        steps.study().map_err(|error| error.to_string())
    };
    on_threads(threads, work)?
}

/// What all steps of a study need.
struct Steps<'a> {
    job: &'a mut RenderJob,
    options: &'a Options,
    settings: &'a Settings,
    say: &'a dyn Fn(String),
}

/// The reference with what rendering it took.
struct Yardstick {
    reference: Reference,
    started: Instant,
    /// Samples per pixel.
    spp: f64,
    spp_per_second: f64,
    error: f64,
    /// Average number of processors in use.
    processors: f64,
}

impl Steps<'_> {
    fn study(mut self) -> Result<Study, CameraError> {
        (self.say)("rendering the reference".into());
        reset(self.job, self.options, seed(self.settings.seed, 0))?;
        let yardstick = self.render_reference();
        let (mut measured, mut failed) = (Vec::new(), Vec::new());
        for value in self.render_settings(yardstick.spp_per_second) {
            match value.failure {
                Some(error) => failed.push((value.candidate, error)),
                None => {
                    let m = value.measured(&yardstick.reference);
                    measured.push((value.candidate, m));
                }
            }
        }
        let mut recommendation = recommend(&measured, self.settings.target);
        let verified = recommendation
            .as_mut()
            .and_then(|advice| self.verify(advice, &measured, &yardstick));
        let size = self.job.film.pixel_bounds().size();
        Ok(Study {
            resolution: [size.x, size.y],
            reference_error: yardstick.error,
            reference_spp: yardstick.spp,
            processors: yardstick.processors,
            slope: slope(&measured),
            measured,
            failed,
            recommendation,
            verified,
        })
    }

    fn render_reference(&mut self) -> Yardstick {
        let goal = Goal {
            error: None,
            confidence: None,
            time: Some(self.settings.time.mul_f64(FOR_REFERENCE)),
            max_spp: Goal::MAX_SPP,
        };
        let (started, worked) = (Instant::now(), processor_time());
        let done = render_until(self.job, TILE_SIZE, &goal, &Progress::hidden());
        debug_assert!(done.ended != Ended::Error);
        let waited = started.elapsed().as_secs_f64().max(1e-9);
        let worked = (processor_time() - worked).as_secs_f64();
        // Without any noise there is none to subtract.
        let error = done.error.unwrap_or(0.0);
        Yardstick {
            reference: Reference::new(done.film.image(), error),
            started,
            spp: done.spp,
            spp_per_second: done.spp / waited,
            error,
            processors: (worked / waited).max(0.01),
        }
    }

    /// The images of all settings. The sample candidates end at four times the count of the other settings, and all of
    /// them together cost twice the last one.
    fn render_settings(&mut self, spp_per_second: f64) -> Vec<Images> {
        let seconds = FOR_SETTINGS * self.settings.time.as_secs_f64();
        let (_, radius) = self.job.world.geometry.bounds().bounding_sphere();
        let settings_count = candidates(self.options, radius, 1, &[]).len() as f64;
        let affordable = seconds * spp_per_second / IMAGES as f64 / (settings_count + 2.0 * 4.0);
        let spp = power_of_two(affordable);
        let counts = (0..8).map(|k| (4 * spp) >> k);
        let counts: Vec<u32> = counts.take_while(|&n| n > 0).collect();
        let candidates = candidates(self.options, radius, spp, &counts);
        let mut images: Vec<Images> = candidates.into_iter().map(Images::new).collect();
        for turn in 1..=IMAGES {
            (self.say)(format!("settings, round {turn} of {IMAGES}"));
            for value in &mut images {
                value.take(self.job, self.settings.seed, turn);
            }
        }
        images
    }

    /// Renders the recommendation, with more samples each time that they turn out too few; `None` if no result is that
    /// of the final recommendation.
    fn verify(
        &mut self,
        advice: &mut Recommendation,
        measured: &[(Candidate, Measurement)],
        yardstick: &Yardstick,
    ) -> Option<Measurement> {
        let total = self.settings.time.as_secs_f64();
        for attempt in 0..ATTEMPTS {
            // Some time is kept regardless of how long the settings took.
            let left = (total - yardstick.started.elapsed().as_secs_f64()).max(0.1 * total);
            if advice.seconds / yardstick.processors * 3.0 > left {
                return None;
            }
            let spp = advice.spp;
            (self.say)(format!(
                "rendering the recommendation, {spp} samples a pixel"
            ));
            let turned = advice.turned.iter().map(|&i| &measured[i].0);
            let mut value = Images::new(Candidate::of_all(turned, spp, self.options));
            let before = IMAGES + 3 * attempt;
            for number in before + 1..=before + 3 {
                value.take(self.job, self.settings.seed, number);
            }
            let m = value.measured(&yardstick.reference);
            let miss = m.error().value / self.settings.target;
            advice.seconds = m.seconds.value;
            if miss <= 1.0 || attempt + 1 == ATTEMPTS {
                return Some(m);
            }
            advice.ask_for_more(miss);
        }
        None
    }
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
        let film = render(job, TILE_SIZE, true, &Progress::hidden());
        self.seconds
            .push((processor_time() - started).as_secs_f64());
        self.images.push(film.image());
    }

    fn measured(&self, reference: &Reference) -> Measurement {
        let spp = self.candidate.options.sampler.spp;
        Measurement::new(reference, spp, &self.images, &self.seconds)
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
