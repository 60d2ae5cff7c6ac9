//! What a caller decides about reading and rendering a scene.

use crate::cameras::{CameraChoices, Compat};
use crate::film::{Accumulation, Encoding, FilmSpec, Layer, LayerSet};
use crate::optics::models::ModelKind;
use crate::render::{Goal, TILE_SIZE};
use crate::scene::dialect::DialectChoice;
use crate::scene::{Frame, ReadSettings};
use crate::syntax::{Diagnostics, SourceMap};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// What a scene is refused for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Policy {
    /// Errors.
    #[default]
    Errors,
    /// Warnings too (`--strict`).
    Warnings,
    /// Errors, but not those that leave a scene to render, such as a missing mesh (`--keep-going`).
    KeepGoing,
}

impl Policy {
    pub(super) fn refuses(self, diagnostics: &Diagnostics) -> bool {
        let (errors, warnings) = (diagnostics.errors(), diagnostics.warnings());
        match self {
            Policy::Errors => errors > 0,
            Policy::Warnings => errors + warnings > 0,
            Policy::KeepGoing => errors > diagnostics.recoverable_errors(),
        }
    }
}

/// How a scene is read. Made by `ReadOptions::default()` and changed field by field.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct ReadOptions {
    /// What it is refused for.
    pub policy: Policy,
    /// pbrt-v3, pbrt-v2, or decided by its content.
    pub dialect: DialectChoice,
    /// The renderer whose quirks of the realistic camera are reproduced.
    pub compat: Option<Compat>,
    /// Realistic cameras: what rays are made with, instead of the scene's choice.
    pub lens_model: Option<ModelKind>,
    /// Realistic cameras: the f-number that sets the stop, instead of the scene's choice.
    pub f_number: Option<f64>,
    /// Realistic cameras: the point of the image to focus on, in fractions of its size from the upper left, instead of the scene's choice.
    pub focus_point: Option<[f64; 2]>,
    /// Bytes that images, meshes and film may take; `None` for what the machine has to give.
    pub max_memory: Option<u64>,
    /// The only folder that files are read from, for scenes of strangers; `None` for any.
    pub files_within: Option<PathBuf>,
    /// Say also what changes nothing but the noise.
    pub details: bool,
}

impl ReadOptions {
    pub(super) fn settings(&self) -> ReadSettings {
        ReadSettings {
            dialect: self.dialect,
            compat: self.compat,
            lens_model: self.lens_model,
            camera: CameraChoices {
                f_number: self.f_number,
                focus_point: self.focus_point,
            },
            details: self.details,
            max_memory: self.max_memory,
        }
    }

    pub(super) fn sources(&self) -> Result<SourceMap, String> {
        let Some(folder) = &self.files_within else {
            return Ok(SourceMap::new());
        };
        let outside = |problem| format!("--files-within {}: {problem}", folder.display());
        SourceMap::within(folder).map_err(outside)
    }
}

/// How a frame is rendered. Made by `RenderOptions::default()` and changed field by field.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RenderOptions {
    /// Samples a pixel, instead of the scene's; with `error` or `time` the most.
    pub spp: Option<u32>,
    /// Render until the image's estimated relative error is at most this, a positive number.
    pub error: Option<f64>,
    /// With `error`: only when the true error is as small with this confidence, a probability of at least a half and below one.
    pub confidence: Option<f64>,
    /// Render until this time has passed since the first sample.
    pub time: Option<Duration>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Threads; 0 for one for each processor, at most eight times as many. The image does not depend on it.
    pub threads: usize,
    /// Part of the image, as fractions of its size: x0, x1, y0, y1. Instead of the scene's.
    pub crop: Option<[f64; 4]>,
    /// As `crop`, but only where the scene gives none (pbrt's `--cropwindow`).
    pub default_crop: Option<[f64; 4]>,
    /// A quarter of the width and height, one sample a pixel, a quarter of the lights' samples.
    pub quick: bool,
    /// Keep the variance of each pixel's mean in the image.
    pub variance: bool,
    /// Layers of the image, instead of the scene's; only `.exr` files keep them.
    pub layers: Option<LayerSet>,
    /// Layers by which [`Rendered::denoised`](crate::Rendered::denoised) finds edges, too.
    pub denoise: bool,
    /// How the image's files store its numbers.
    pub encoding: Encoding,
    /// Side of the square tiles that threads work on, in pixels; changes no bit of the image.
    pub tile_size: u32,
    /// Where the render is kept, to be continued if it is interrupted.
    pub checkpoint: Option<Checkpoint>,
    /// Stops the render when it becomes `true`.
    pub stop: Option<Arc<AtomicBool>>,
}

/// A file that keeps what a render has done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checkpoint {
    /// The file, usually `.fsc`.
    pub path: PathBuf,
    /// It is only made when the render has taken so long.
    pub after: Duration,
    /// The longest time whose work may be lost.
    pub every: Duration,
    /// A checkpoint of another render in its place is refused, not replaced.
    pub required: bool,
}

impl Default for RenderOptions {
    fn default() -> RenderOptions {
        RenderOptions {
            spp: None,
            error: None,
            confidence: None,
            time: None,
            seed: 0,
            threads: 0,
            crop: None,
            default_crop: None,
            quick: false,
            variance: false,
            layers: None,
            denoise: false,
            encoding: Encoding::default(),
            tile_size: TILE_SIZE,
            checkpoint: None,
            stop: None,
        }
    }
}

/// One place for both.
const LIGHTS_OR_STRATEGIES: &str = "--aov lights: `bdpt` shows its strategies (`visualizestrategies`, `visualizeweights`) in place of groups of \
    lights: leave one of them out";

impl RenderOptions {
    /// What to render until, if not the scene's number of samples.
    pub(super) fn goal(&self) -> Option<Goal> {
        (self.error.is_some() || self.time.is_some()).then(|| Goal {
            error: self.error,
            confidence: self.confidence.filter(|_| self.error.is_some()),
            time: self.time,
            max_spp: self.spp.unwrap_or(Goal::MAX_SPP),
        })
    }

    pub(super) fn apply(&self, frame: &mut Frame) -> Result<(), String> {
        self.check_goal()?;
        if self.quick {
            frame.make_quick();
        }
        let options = &mut frame.options;
        // Where it is only the most, the scene's own number still says how textures are filtered.
        if let Some(spp) = self.spp.filter(|_| self.goal().is_none()) {
            options.sampler = options.sampler.clone().with_spp(spp);
        }
        self.change(&mut options.film)?;
        options.accumulation = match (self.goal().is_some(), self.variance) {
            (true, _) => Accumulation::InPasses,
            (false, true) => Accumulation::WithVariances,
            (false, false) => Accumulation::Once,
        };
        if self.denoise && !options.integrator.spec.gathers_photons() {
            let layers = options.film.layers;
            options.film.layers = layers.with(Layer::Albedo).with(Layer::Normal);
        }
        let wanted = options.film.layers;
        if wanted.contains(Layer::Lights) && !options.integrator.spec.strategies().is_empty() {
            return Err(LIGHTS_OR_STRATEGIES.to_string());
        }
        frame.options.film.layers = frame.layers(wanted);
        Ok(())
    }

    /// A goal that no image can reach would be tried for ever.
    fn check_goal(&self) -> Result<(), &'static str> {
        let is_error = |error: f64| error > 0.0 && error.is_finite();
        let is_confidence = |share: f64| (0.5..1.0).contains(&share);
        match (self.error, self.confidence) {
            (Some(error), _) if !is_error(error) => Err("--error: expected a positive number"),
            (_, Some(share)) if !is_confidence(share) => {
                Err("--confidence: expected a probability of at least a half and below one")
            }
            _ => Ok(()),
        }
    }

    /// The film of a frame that the options have not been applied to.
    pub(super) fn film(&self, film: &FilmSpec) -> Result<FilmSpec, String> {
        let mut film = film.clone();
        if self.quick {
            film.make_quick();
        }
        self.change(&mut film)?;
        Ok(film)
    }

    fn change(&self, film: &mut FilmSpec) -> Result<(), String> {
        film.layers = self.layers.unwrap_or(film.layers);
        let scene_crops = film.crop_window != [0.0, 1.0, 0.0, 1.0];
        match self.crop.or(self.default_crop.filter(|_| !scene_crops)) {
            Some(crop) => film
                .set_crop(&crop)
                .map_err(|error| format!("--crop: {error}")),
            None => Ok(()),
        }
    }
}
