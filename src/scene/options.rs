//! The options block: directives are stored and only interpreted at `WorldEnd`, when the dialect of the file is known
//! (docs/scene-language.md §2.3).

use super::names::FocusTarget;
use super::reading::Reading;
use super::transforms::{Ctm, Placement};
use crate::cameras::{CameraChoices, CameraSpec, is_course_form};
use crate::film::sensor::SensorPreset;
use crate::film::{Accumulation, FilmSpec};
use crate::filters::Filter;
use crate::integrators::{IntegratorSettings, MediaSeen};
use crate::params::ParamReader;
use crate::samplers::SamplerSpec;
use crate::syntax::{Diagnostic, Span, Typed};

/// Camera, film, sampler, filter and integrator of one frame, read and checked.
#[derive(Clone, Debug)]
pub struct Options {
    /// The camera.
    pub camera: CameraSpec,
    /// World to camera.
    pub camera_from_world: Placement,
    /// The film.
    pub film: FilmSpec,
    /// The location of the film's directive, if there is one.
    pub film_at: Option<Span>,
    /// The reconstruction filter.
    pub filter: Filter,
    /// The sampler.
    pub sampler: SamplerSpec,
    /// The integrator, and the pixels it is limited to.
    pub integrator: IntegratorSettings,
    /// Which effects of pbrt-v2's volumes are visible.
    pub media_seen: MediaSeen,
    /// What the camera is to focus on, if that has a name.
    pub focus_target: Option<FocusTarget>,
    /// How the image is rendered, as far as its memory depends on it; not of the file.
    pub accumulation: Accumulation,
    /// Memory limit in bytes (`--max-memory`); `None` for what the machine provides.
    pub max_memory: Option<u64>,
}

/// A directive as written in the file.
#[derive(Clone, Debug)]
pub struct StoredDirective {
    /// The directive's word, such as `Film`.
    pub word: &'static str,
    /// Location of the word.
    pub span: Span,
    /// Type and parameters.
    pub typed: Typed,
}

/// The directives of the options block as written in the file; the last of each kind counts.
#[derive(Clone, Debug)]
pub struct StoredOptions {
    /// `Camera`.
    pub camera: Option<StoredDirective>,
    /// The transformations in force at the camera.
    pub camera_ctm: Ctm,
    /// `TransformTimes`: those of the start and end transformations.
    pub transform_times: [f64; 2],
    /// `Film`.
    pub film: Option<StoredDirective>,
    /// `PixelFilter`.
    pub filter: Option<StoredDirective>,
    /// `Sampler`.
    pub sampler: Option<StoredDirective>,
    /// `Integrator` or `SurfaceIntegrator`.
    pub integrator: Option<StoredDirective>,
    /// `VolumeIntegrator`, pbrt-v2 only.
    pub volume_integrator: Option<StoredDirective>,
    /// `Accelerator`: read only to check its parameters, without effect on the image.
    pub accelerator: Option<StoredDirective>,
    /// `Renderer`, pbrt-v2 only.
    pub renderer: Option<StoredDirective>,
}

impl Default for StoredOptions {
    fn default() -> Self {
        StoredOptions {
            camera: None,
            camera_ctm: Ctm::IDENTITY,
            transform_times: [0.0, 1.0],
            film: None,
            filter: None,
            sampler: None,
            integrator: None,
            volume_integrator: None,
            accelerator: None,
            renderer: None,
        }
    }
}

impl StoredOptions {
    /// Returns `true` if the camera is written in the course's form, as its parameter names reveal.
    pub fn has_course_camera(&self) -> bool {
        self.camera.as_ref().is_some_and(|camera| {
            let Typed { kind, params } = &camera.typed;
            kind.text == "realistic" && is_course_form(params)
        })
    }

    /// Reads all options; every problem is reported, and invalid values are replaced. With `details`, notes also what
    /// only affects noise. `choices` are the command line's.
    pub fn read(&self, reading: &Reading, details: bool, choices: &CameraChoices) -> Options {
        self.read_accelerator(reading);
        self.read_renderer(reading);
        let realistic = |given: &&StoredDirective| given.typed.kind.text == "realistic";
        let sensor = { self.camera.as_ref().filter(realistic) }
            .and_then(|camera| reading.look(camera, SensorPreset::from_params));
        let film = reading.read_or("Film", self.film.as_ref(), "image", |reader| {
            if reader.kind() != "image" {
                reader.unknown_kind(&["image"]);
            }
            FilmSpec::from_params(reader, sensor)
        });
        let filter = self.filter.as_ref();
        let filter = reading.read_or("PixelFilter", filter, "box", Filter::from_params);
        let sampler = self.read_sampler(reading, details);
        let integrator = self.integrator.as_ref();
        let usual = reading.dialect().default_integrator();
        let from_params = IntegratorSettings::from_params;
        let integrator = IntegratorSettings {
            place: integrator.map(|given| given.typed.kind.span),
            ..reading.read_or("Integrator", integrator, usual, from_params)
        };
        let volume_integrator = self.volume_integrator.as_ref();
        let media_seen = reading.read_or(
            "VolumeIntegrator",
            volume_integrator,
            "emission",
            MediaSeen::from_params,
        );
        let camera_from_world = self.camera_ctm.placement(self.transform_times);
        let camera = self.camera.as_ref();
        if let Some(camera) = camera.filter(|_| !camera_from_world.is_invertible()) {
            let message = "the transformation of this camera cannot be inverted (a `Scale` by 0?)";
            let error = Diagnostic::error(message).at(camera.span);
            reading.diagnostics().push(error);
        }
        let camera = reading.read_or("Camera", camera, "perspective", |reader| {
            CameraSpec::from_params(reader, choices)
        });
        Options {
            camera,
            camera_from_world,
            film,
            film_at: self.film.as_ref().map(|film| film.span),
            filter,
            sampler: integrator.spec.own_sampler().unwrap_or(sampler),
            integrator,
            media_seen,
            focus_target: None,
            accumulation: Accumulation::Once,
            max_memory: None,
        }
    }

    fn read_sampler(&self, reading: &Reading, details: bool) -> SamplerSpec {
        let Some(given) = &self.sampler else {
            let usual = |reader: &ParamReader| SamplerSpec::from_params(reader);
            return reading.defaults("Sampler", "halton", usual);
        };
        reading.read_stored(given, |reader| {
            let sampler = SamplerSpec::from_params(reader);
            if let Some(note) = sampler.note.filter(|_| details) {
                reader.note(note);
            }
            sampler
        })
    }

    /// Accelerators do not change the image: their parameters are accepted and unused.
    fn read_accelerator(&self, reading: &Reading) {
        const KNOWN: [&str; 3] = ["bvh", "kdtree", "grid"];
        const PARAMETERS: [&str; 8] = [
            "maxnodeprims",
            "splitmethod",
            "intersectcost",
            "traversalcost",
            "emptybonus",
            "maxprims",
            "maxdepth",
            "refineimmediately",
        ];
        let Some(given) = &self.accelerator else {
            return;
        };
        reading.read_stored(given, |reader: &ParamReader| {
            for name in PARAMETERS {
                reader.accept(name);
            }
            if !KNOWN.contains(&reader.kind()) {
                reader.unknown_kind_replaced(&KNOWN, "fstop's own is used, as for every scene");
            }
        });
    }

    /// Reads pbrt-v2's renderers, all of which map to the only one here.
    fn read_renderer(&self, reading: &Reading) {
        let Some(given) = &self.renderer else { return };
        reading.read_stored(given, |reader: &ParamReader| {
            reader.accept_all();
            if reader.kind() != "sampler" {
                let kind = reader.kind();
                reader.note(format!("renderer `{kind}` is replaced by the ordinary one"));
            }
        });
    }
}
