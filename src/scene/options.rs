//! The options block: directives that are stored and only understood at `WorldEnd`, when it is
//! known which dialect the file speaks (scene-language 2.3).

use super::reading::Reading;
use super::transforms::Ctm;
use crate::cameras::CameraSpec;
use crate::film::FilmSpec;
use crate::filters::Filter;
use crate::integrators::IntegratorSettings;
use crate::math::transform::Transform;
use crate::params::{Dialect, ParamReader};
use crate::samplers::SamplerSpec;
use crate::syntax::{Diagnostic, Span, Typed};

/// Camera, film, sampler, filter and integrator of one frame, read and checked.
#[derive(Debug)]
pub struct Options {
    /// The camera.
    pub camera: CameraSpec,
    /// World to camera at the start time.
    pub camera_from_world: Transform,
    /// The film.
    pub film: FilmSpec,
    /// The reconstruction filter.
    pub filter: Filter,
    /// The sampler.
    pub sampler: SamplerSpec,
    /// The integrator, and the pixels it is confined to.
    pub integrator: IntegratorSettings,
}

/// A directive as it stands in the file, with the place of its word.
type Stored = Option<(Typed, Span)>;

/// The directives of the options block as they stand in the file; the last of each kind counts.
#[derive(Clone, Debug)]
pub struct StoredOptions {
    /// `Camera`.
    pub camera: Stored,
    /// The transformations in force there.
    pub camera_ctm: Ctm,
    /// `Film`.
    pub film: Stored,
    /// `PixelFilter`.
    pub filter: Stored,
    /// `Sampler`.
    pub sampler: Stored,
    /// `Integrator` or `SurfaceIntegrator`.
    pub integrator: Stored,
    /// `Accelerator`: read for its parameters' sake, without effect on the picture.
    pub accelerator: Stored,
    /// `Renderer`, pbrt-v2 only.
    pub renderer: Stored,
}

impl Default for StoredOptions {
    fn default() -> Self {
        StoredOptions {
            camera: None,
            camera_ctm: Ctm::IDENTITY,
            film: None,
            filter: None,
            sampler: None,
            integrator: None,
            accelerator: None,
            renderer: None,
        }
    }
}

impl StoredOptions {
    /// Is the camera written in the course's form? Its own parameter names give it away.
    pub fn has_course_camera(&self) -> bool {
        const COURSE_NAMES: [&str; 3] = ["specfile", "aperture_diameter", "filmdiag"];
        self.camera.as_ref().is_some_and(|(camera, _)| {
            camera.kind.text == "realistic"
                && COURSE_NAMES
                    .iter()
                    .any(|name| camera.params.named(name).is_some())
        })
    }

    /// Reads everything; every problem is reported. `None` where there is no camera to render with.
    pub fn read(&self, reading: &Reading) -> Option<Options> {
        let dialect = reading.dialect();
        self.read_accelerator(reading);
        self.read_renderer(reading);
        let film = reading.read_or("Film", self.film.as_ref(), "image", |reader| {
            if reader.kind() != "image" {
                reader.unknown_kind(&["image"]);
            }
            FilmSpec::from_params(reader)
        });
        let filter = reading.read_or(
            "PixelFilter",
            self.filter.as_ref(),
            "box",
            Filter::from_params,
        );
        let default_sampler = if dialect == Dialect::V2 {
            "lowdiscrepancy"
        } else {
            "halton"
        };
        let sampler = reading.read_or(
            "Sampler",
            self.sampler.as_ref(),
            default_sampler,
            SamplerSpec::from_params,
        );
        let integrator = match &self.integrator {
            Some((typed, span)) => {
                reading.read("Integrator", *span, typed, IntegratorSettings::from_params)
            }
            None => IntegratorSettings::default_for(dialect),
        };
        let camera = reading.read_or(
            "Camera",
            self.camera.as_ref(),
            "perspective",
            CameraSpec::from_params,
        )?;
        if let Some((_, span)) = &self.camera
            && self.camera_ctm.is_animated()
        {
            let message = "a moving camera is held at its start: motion blur is not supported yet";
            reading
                .diagnostics()
                .push(Diagnostic::warning(message).at(*span));
        }
        Some(Options {
            camera,
            camera_from_world: self.camera_ctm.start,
            film,
            filter,
            sampler,
            integrator,
        })
    }

    /// Accelerators do not change the picture: their parameters are legal and unused.
    fn read_accelerator(&self, reading: &Reading) {
        const PARAMETERS: [&str; 9] = [
            "maxnodeprims",
            "splitmethod",
            "intersectcost",
            "traversalcost",
            "emptybonus",
            "maxprims",
            "maxdepth",
            "refineimmediately",
            "nx",
        ];
        let Some((typed, span)) = &self.accelerator else {
            return;
        };
        reading.read("Accelerator", *span, typed, |reader: &ParamReader| {
            for name in PARAMETERS {
                reader.accept(name);
            }
            let known = ["bvh", "kdtree", "grid"];
            if !known.contains(&reader.kind()) {
                reader.unknown_type(&known, "fstop's own is used, as for every scene");
            }
        });
    }

    /// pbrt-v2's renderers: all are answered by the one there is.
    fn read_renderer(&self, reading: &Reading) {
        let Some((typed, span)) = &self.renderer else {
            return;
        };
        reading.read("Renderer", *span, typed, |reader: &ParamReader| {
            reader.accept_all();
            if reader.kind() != "sampler" {
                reader.note(format!(
                    "renderer `{}` is replaced by the ordinary one",
                    reader.kind()
                ));
            }
        });
    }
}
