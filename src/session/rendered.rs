//! A finished image, and how it came to be.

use super::RenderOptions;
use crate::build::PreparedScene;
use crate::checkpoint::Journal;
use crate::film::{self, DroppedSample, Film, FilmMetadata, Image, WriteError};
use crate::integrators::witness::{Met, Place};
use crate::materials::Material;
use crate::render::{self, Ended, Progress, RenderJob, Step};
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
    /// Whether it was stopped before its end: then pixels may lack samples.
    pub stopped: bool,
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
        film: &Film,
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
        film::write(path.as_ref(), &self.image, &self.metadata)
    }

    /// As [`Rendered::write`], but where the file cannot be made the image is saved to another place, which the
    /// error names.
    ///
    /// # Errors
    /// As [`Rendered::write`]; [`WriteError::Elsewhere`] where the image is safe, but not where it was wanted.
    pub fn write_or_rescue(&self, path: impl AsRef<Path>) -> Result<(), WriteError> {
        film::write_somewhere(path.as_ref(), &self.image, &self.metadata)
    }

    /// Returns `true` if no light was found at all.
    pub fn is_black(&self) -> bool {
        self.image
            .pixels
            .iter()
            .all(|pixel| *pixel == crate::math::Rgb::ZERO)
    }
}

/// Renders on the current rayon pool: with the scene's number of samples, or until the image is good enough.
pub(super) fn take(
    scene: &PreparedScene,
    name: &str,
    options: &RenderOptions,
    journal: Option<&Journal>,
    report: &(dyn Fn(Step) + Sync),
) -> Rendered {
    let job = &scene.job;
    let stop = options.stop.as_deref();
    let (film, spp, first_dropped, error, passes, stopped) = match options.goal() {
        None => {
            let spp = job.sampler.spp();
            let pixels = job.film.pixel_bounds().area() as u64;
            let paths = job.light_paths(spp);
            let all = pixels * u64::from(spp) + paths;
            let progress = Progress::new(all, report).kept(journal, stop);
            let film = render::render(job, options.tile_size, &progress);
            let first = film.first_dropped();
            let first = first.map(|dropped| (dropped, render::locate(job, &job.sampler, dropped)));
            let sampled = film.bounds().intersection(job.sampled).area() as u64;
            let (all, done) = (sampled * u64::from(spp), film.samples());
            let taken = done as f64 / sampled.max(1) as f64;
            let stopped = done < all || film.paths() < paths;
            (film, taken, first, None, None, stopped)
        }
        Some(goal) => {
            // The size of tiles decides which pixels share their number of samples.
            let progress = Progress::new(0, report).kept(journal, stop);
            let done = render::render_until(job, render::TILE_SIZE, &goal, &progress);
            let first = done.first_dropped;
            let first = first.map(|(dropped, s)| (dropped, render::locate(job, &s, dropped)));
            (
                done.film,
                done.spp,
                first,
                done.error,
                Some((done.passes, done.ended)),
                done.ended == Ended::Stopped,
            )
        }
    };
    let finished = Finished {
        film,
        spp,
        error,
        passes,
        stopped,
    };
    let first_dropped = first_dropped.map(|(first, at)| (first, place(job, at)));
    let dropped = DroppedSamples::of(&finished.film, first_dropped);
    let metadata = metadata(scene, name, options);
    finished.develop(metadata, options.variance, dropped)
}

/// What the image's file says of it, but for what is known at its end.
pub(super) fn metadata(scene: &PreparedScene, name: &str, options: &RenderOptions) -> FilmMetadata {
    FilmMetadata {
        seed: options.seed,
        scene: name.to_string(),
        ..scene.metadata.clone()
    }
}

/// A film with all its samples.
pub(super) struct Finished {
    pub film: Film,
    /// Samples a pixel, on average.
    pub spp: f64,
    /// Estimated relative error.
    pub error: Option<f64>,
    pub passes: Option<(u32, Ended)>,
    pub stopped: bool,
}

impl Finished {
    pub(super) fn develop(
        self,
        metadata: FilmMetadata,
        variance: bool,
        dropped: Option<DroppedSamples>,
    ) -> Rendered {
        let mut image = self.film.develop();
        if !variance {
            image.variance = None;
        }
        Rendered {
            samples: self.film.bounds().area() as f64 * self.spp,
            dropped,
            metadata: FilmMetadata {
                spp: self.spp.round().clamp(1.0, f64::from(u32::MAX)) as u32,
                relative_error: self.error,
                ..metadata
            },
            image,
            spp: self.spp,
            passes: self.passes,
            stopped: self.stopped,
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
