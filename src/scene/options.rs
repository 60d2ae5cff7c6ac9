//! The options block: directives that are stored and only understood at `WorldEnd`, when it is
//! known which dialect the file speaks (scene-language 2.3).

use super::interpreter::Reading;
use super::transforms::Ctm;
use crate::cameras::CameraSpec;
use crate::film::FilmSpec;
use crate::filters::Filter;
use crate::integrators::IntegratorSettings;
use crate::math::transform::Transform;
use crate::params::{Dialect, ParamReader};
use crate::samplers::SamplerSpec;
use crate::syntax::{Diagnostic, ParamList, Typed};

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

/// The directives of the options block as they stand in the file; the last of each kind counts.
#[derive(Clone, Debug, Default)]
pub struct StoredOptions {
    /// `Camera` with the transformations in force there.
    pub camera: Option<(Typed, Ctm)>,
    /// `Film`.
    pub film: Option<Typed>,
    /// `PixelFilter`.
    pub filter: Option<Typed>,
    /// `Sampler`.
    pub sampler: Option<Typed>,
    /// `Integrator` or `SurfaceIntegrator`.
    pub integrator: Option<Typed>,
    /// `Accelerator`: read for its parameters' sake, without effect on the picture.
    pub accelerator: Option<Typed>,
    /// `Renderer`, pbrt-v2 only.
    pub renderer: Option<Typed>,
}

impl StoredOptions {
    /// Is the camera written in the course's form? Its own parameter names give it away.
    pub fn has_course_camera(&self) -> bool {
        const COURSE_NAMES: [&str; 3] = ["specfile", "aperture_diameter", "filmdiag"];
        self.camera.as_ref().is_some_and(|(camera, _)| {
            camera.kind.text == "realistic" && COURSE_NAMES.iter().any(|name| camera.params.named(name).is_some())
        })
    }

    /// Reads everything; every problem is reported. `None` where there is no camera to render with.
    pub fn read(&self, reading: &Reading) -> Option<Options> {
        let dialect = reading.dialect;
        self.read_accelerator(reading);
        self.read_renderer(reading);
        let film = reading.read_or("Film", self.film.as_ref(), "image", |reader| {
            if reader.kind() != "image" {
                reader.unknown_kind("film", reader.kind(), &["image"], "`image` is used");
            }
            FilmSpec::from_params(reader)
        });
        let filter = reading.read_or("PixelFilter", self.filter.as_ref(), "box", Filter::from_params);
        let default_sampler = if dialect == Dialect::V2 { "lowdiscrepancy" } else { "halton" };
        let sampler = reading.read_or("Sampler", self.sampler.as_ref(), default_sampler, SamplerSpec::from_params);
        let integrator = match &self.integrator {
            Some(typed) => reading.read("Integrator", typed, IntegratorSettings::from_params),
            None => IntegratorSettings::default_for(dialect),
        };
        let camera = reading.read_or(
            "Camera",
            self.camera.as_ref().map(|(typed, _)| typed),
            "perspective",
            CameraSpec::from_params,
        )?;
        let camera_from_world = match &self.camera {
            Some((typed, ctm)) => {
                warn_about_motion(reading, typed, ctm);
                ctm.start
            }
            None => Transform::IDENTITY,
        };
        Some(Options { camera, camera_from_world, film, filter, sampler, integrator })
    }

    /// Accelerators do not change the picture: their parameters are legal and unused.
    fn read_accelerator(&self, reading: &Reading) {
        const PARAMETERS: [&str; 9] = [
            "maxnodeprims", "splitmethod", "intersectcost", "traversalcost", "emptybonus", "maxprims", "maxdepth",
            "refineimmediately", "nx",
        ];
        let Some(typed) = &self.accelerator else { return };
        reading.read("Accelerator", typed, |reader: &ParamReader| {
            for name in PARAMETERS {
                reader.accept(name);
            }
            let known = ["bvh", "kdtree", "grid"];
            if !known.contains(&reader.kind()) {
                reader.unknown_kind("accelerator", reader.kind(), &known, "fstop's own is used, as for every scene");
            }
        });
    }

    /// pbrt-v2's renderers: all are answered by the one there is.
    fn read_renderer(&self, reading: &Reading) {
        let Some(typed) = &self.renderer else { return };
        reading.read("Renderer", typed, |reader: &ParamReader| {
            reader.accept_all();
            if reader.kind() != "sampler" {
                reader.note(format!("renderer `{}` is replaced by the ordinary one", reader.kind()));
            }
        });
    }
}

/// A camera that moves is held where it starts.
fn warn_about_motion(reading: &Reading, typed: &Typed, ctm: &Ctm) {
    if ctm.is_animated() {
        reading.diagnostics.push(
            Diagnostic::warning("a moving camera is held at its start: motion blur is not supported yet")
                .at(typed.kind.span),
        );
    }
}

/// An empty parameter list for defaults.
pub(super) const NO_PARAMETERS: ParamList = ParamList::EMPTY;
