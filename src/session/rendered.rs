//! A finished image, and how it came to be.

use super::RenderOptions;
use crate::build::PreparedScene;
use crate::checkpoint::Journal;
use crate::denoise::{DenoiseError, Denoiser};
use crate::film::{self, Developed, DroppedSample, Encoding, FilmMetadata, Image, WriteError};
use crate::integrators::witness::{Met, Place};
use crate::materials::Material;
use crate::render::{self, Ended, Live, Progress, Progressive, RenderJob, Statistics, Step};
use std::path::Path;

/// A rendered image.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Rendered {
    /// The pixels.
    pub image: Image,
    /// What a file says of it.
    pub metadata: FilmMetadata,
    /// Samples a pixel, on average.
    pub spp: f64,
    /// Samples in all.
    pub samples: f64,
    /// Where it was rendered to an error or a time: passes, and why it ended.
    pub passes: Option<(u32, Ended)>,
    /// Samples that were not finite.
    pub dropped: Option<DroppedSamples>,
    /// `true` if it was stopped before its end: then pixels may lack samples.
    pub stopped: bool,
    /// How its files store numbers.
    pub encoding: Encoding,
    /// As [`RenderOptions::threads`], for writing it.
    threads: usize,
}

/// Samples that were not finite, and count as black.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DroppedSamples {
    /// How many.
    pub count: u64,
    /// The first one's pixel, from 0, in order of rows.
    pub pixel: [u32; 2],
    /// Its number in the pixel, from 0.
    pub sample: u64,
    /// If it was not one of the camera's samples, but a path from a light that came to the pixel, the number of that, from 0.
    pub light_path: Option<u64>,
    /// In words, where its path went wrong.
    pub place: String,
}

impl DroppedSamples {
    /// Those of a film. `first` is the first one, and the place where it went wrong, if it is one of the camera's samples.
    pub(super) fn of(
        film: &Developed,
        first: Option<(DroppedSample, String)>,
    ) -> Option<DroppedSamples> {
        let count = film.dropped();
        if let Some((DroppedSample { pixel, sample }, place)) = first {
            return Some(DroppedSamples {
                count,
                pixel: pixel.to_array(),
                sample,
                light_path: None,
                place,
            });
        }
        let first = film.first_dropped_splat()?;
        Some(DroppedSamples {
            count,
            pixel: first.pixel.to_array(),
            sample: 0,
            light_path: Some(first.path),
            place: "somewhere on its way".to_string(),
        })
    }

    /// In words, the first one, and where it went wrong.
    #[must_use]
    pub fn first(&self) -> String {
        let [x, y] = self.pixel;
        let which = match self.light_path {
            None => format!("sample {} of", self.sample),
            Some(number) => format!("light path {number}, at"),
        };
        format!("{which} pixel {x}, {y} (both from 0), {}", self.place)
    }
}

impl Rendered {
    /// Writes the image; the ending names the format: `.exr`, `.png`, `.pfm` or `.tga`.
    ///
    /// # Errors
    /// A file that cannot be written; an image that the format cannot hold.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), WriteError> {
        let path = path.as_ref();
        self.on_threads(|| film::write_as(path, &self.image, &self.metadata, &self.encoding))
    }

    /// As [`Rendered::write`], but where the file cannot be made the image is saved to another place, which the
    /// error names.
    ///
    /// # Errors
    /// As [`Rendered::write`]; [`WriteError::Elsewhere`] where the image is safe, but not where it was wanted.
    pub fn write_or_rescue(&self, path: impl AsRef<Path>) -> Result<(), WriteError> {
        let path = path.as_ref();
        self.on_threads(|| film::write_somewhere(path, &self.image, &self.metadata, &self.encoding))
    }

    /// The image without its noise, as an image of its own: without variances, layers and error.
    ///
    /// # Errors
    /// What the library says.
    pub fn denoised(&self, denoiser: &Denoiser) -> Result<Rendered, DenoiseError> {
        let threads = super::threads_started(self.threads);
        let image = denoiser.denoised(&self.image, threads)?;
        let metadata = FilmMetadata {
            relative_error: None,
            confidence: None,
            error_bound: None,
            freedom: None,
            pool: None,
            denoised: Some(denoiser.name()),
            ..self.metadata.clone()
        };
        Ok(Rendered {
            image,
            metadata,
            ..self.clone()
        })
    }

    /// If the system refuses them, without.
    fn on_threads<T: Send>(&self, work: impl Fn() -> T + Send + Sync) -> T {
        super::on_threads(self.threads, &work).unwrap_or_else(|_| work())
    }

    /// Returns `true` if no light was found at all.
    pub fn is_black(&self) -> bool {
        self.image
            .pixels
            .iter()
            .all(|pixel| *pixel == crate::math::Rgb::ZERO)
    }
}

/// Who looks at the image as it grows, and who asks what its paths do.
type Onlookers<'a> = (Option<&'a Live>, Option<&'a Statistics>);

/// Renders on the current rayon pool: with the scene's number of samples, or until the image is good enough.
pub(super) fn take(
    scene: &PreparedScene,
    name: &str,
    options: &RenderOptions,
    (journal, (live, statistics)): (Option<&Journal>, Onlookers),
    report: &(dyn Fn(Step) + Sync),
) -> Rendered {
    let job = &scene.job;
    let stop = options.stop.as_deref();
    let goal = options.goal();
    let all = goal.map_or_else(|| samples_and_paths(job), |_| 0);
    let progress = Progress::new(all, report)
        .kept(journal, stop)
        .shown(live, statistics);
    let gathers = job.integrator.photons(&job.world).is_some();
    let (finished, first_dropped) = match goal {
        None if options.variance && job.sampler.is_halved() && !gathers => {
            let done = render::render_halves(job, options.tile_size, &progress);
            let (finished, first) = of_progressive(done);
            (
                Finished {
                    error: None,
                    passes: None,
                    ..finished
                },
                first,
            )
        }
        None => of_one_set(job, options, &progress),
        // The size of tiles decides which pixels share their number of samples.
        Some(goal) => {
            let done = render::render_until(job, render::TILE_SIZE, &goal, &progress);
            of_progressive(done)
        }
    };
    let first_dropped = first_dropped.map(|(first, at)| (first, place(job, at)));
    let dropped = DroppedSamples::of(&finished.film, first_dropped);
    let metadata = metadata(scene, name, options);
    Rendered {
        encoding: options.encoding,
        ..finished.develop(metadata, options.variance, dropped, options.threads)
    }
}

/// The first sample that was dropped, and where on its path.
type FirstDropped = Option<(DroppedSample, Option<Place>)>;

fn of_one_set(
    job: &RenderJob,
    options: &RenderOptions,
    progress: &Progress,
) -> (Finished, FirstDropped) {
    let spp = job.sampler.spp();
    let paths = job.light_paths(spp);
    let film = render::render(job, options.tile_size, options.variance, progress);
    let first = film.first_dropped();
    let first = first.map(|dropped| (dropped, render::locate_in_one_set(job, dropped)));
    let sampled = film.bounds().intersection(job.sampled).area() as u64;
    let (all, done) = (sampled * u64::from(spp), film.samples());
    let finished = Finished {
        spp: done as f64 / sampled.max(1) as f64,
        error: None,
        bound: None,
        passes: None,
        stopped: done < all || film.paths() < paths,
        film,
    };
    (finished, first)
}

fn of_progressive(done: Progressive) -> (Finished, FirstDropped) {
    let first = done.first_dropped;
    let finished = Finished {
        film: done.film,
        spp: done.spp,
        error: done.error,
        bound: done.bound,
        passes: Some((done.passes, done.ended)),
        stopped: done.ended == Ended::Stopped,
    };
    (finished, first)
}

/// Of an image that is rendered to the sampler's number of samples.
fn samples_and_paths(job: &RenderJob) -> u64 {
    let spp = job.sampler.spp();
    job.film.pixel_bounds().area() as u64 * u64::from(spp) + job.light_paths(spp)
}

/// What the image's file says of it, but for what is known at its end.
pub(super) fn metadata(scene: &PreparedScene, name: &str, options: &RenderOptions) -> FilmMetadata {
    FilmMetadata {
        seed: options.seed,
        confidence: options.goal().and_then(|goal| goal.confidence),
        scene: name.to_string(),
        light_paths: scene.job.light_path_use(),
        ..scene.metadata.clone()
    }
}

/// A film with all its samples.
pub(super) struct Finished {
    pub film: Developed,
    /// Samples a pixel, on average.
    pub spp: f64,
    /// Estimated relative error.
    pub error: Option<f64>,
    /// What the true one is below, if a confidence was asked for.
    pub bound: Option<f64>,
    pub passes: Option<(u32, Ended)>,
    pub stopped: bool,
}

impl Finished {
    pub(super) fn develop(
        self,
        metadata: FilmMetadata,
        variance: bool,
        dropped: Option<DroppedSamples>,
        threads: usize,
    ) -> Rendered {
        let samples = self.film.bounds().area() as f64 * self.spp;
        let pool = self.film.pooled();
        let mut image = self.film.image();
        // Of two halves each has a mean of its own.
        let means = if pool.is_some() { 2.0 } else { 1.0 };
        let freedom = self.spp.round() - means;
        if !variance {
            (image.variance, image.independent) = (None, None);
        }
        Rendered {
            samples,
            dropped,
            metadata: FilmMetadata {
                spp: self.spp.round().clamp(1.0, f64::from(u32::MAX)) as u32,
                relative_error: self.error,
                error_bound: self.bound,
                freedom: variance.then_some(freedom).filter(|freedom| *freedom > 0.0),
                pool: pool.filter(|_| variance),
                ..metadata
            },
            image,
            spp: self.spp,
            passes: self.passes,
            stopped: self.stopped,
            encoding: Encoding::default(),
            threads,
        }
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
