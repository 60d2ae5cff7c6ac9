//! Cameras: from a point of the film, a time and a point of the lens to a ray into the scene.
//!
//! A [`CameraSpec`] is what the scene file said, read and checked; [`Camera::new`] puts it behind a
//! film and into render space. `perspective` is the pinhole and the thin lens, `orthographic` the
//! parallel projection, `environment` looks in all directions, `realistic` traces a lens prescription
//! surface by surface with [`crate::optics`].
//!
//! Raster coordinates: x to the right, y down, in pixels of the *full* film; (0, 0) is the
//! image's top left corner, and filters may ask for points outside the image. Camera space: x right, y up, z into the
//! scene.

mod blur;
mod camera_transform;
mod clip;
mod connection;
mod environment;
mod kinds;
mod ndc;
mod pinhole;
mod projective;
mod realistic;
mod screen;
mod shutter;
mod thin_lens;

pub use clip::Clip;
pub use connection::{Aim, Landing, LensSample};
pub use environment::{Environment, EnvironmentSpec};
#[cfg(any(test, feature = "internals"))]
pub use kinds::CAMERA_NAMES;
pub use kinds::{Camera, CameraSpec, DepthAndBlur, Depths};
pub use projective::{Projective, ProjectiveSpec};
pub(crate) use realistic::is_course_form;
#[cfg(any(test, feature = "internals"))]
pub use realistic::{Band, Exposure, Form, Weighting, pbrt_pupil_box};
pub use realistic::{Compat, GhostEntry, Precision, Realistic, RealisticSpec};
pub use screen::Screen;
pub use shutter::Shutter;
pub use thin_lens::ThinLens;

use crate::math::motion::Motion;
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::transform::Transform;
use crate::math::{Rgb, UVec2, Vec2, Vec3};
use crate::params::ParamReader;
use crate::syntax::Span;

/// Where, when and through which part of the lens the film is struck.
#[derive(Clone, Copy, Debug)]
pub struct CameraSample {
    /// Point on the film, raster coordinates.
    pub raster: Vec2,
    /// Fraction of the shutter interval, 0 to 1.
    pub time: f32,
    /// Point of the lens, in the unit square; only a camera that has one ([`Camera::has_lens`]) looks at it.
    pub lens: Vec2,
    /// Part of the spectrum, 0 to 1; only a camera that disperses ([`Camera::disperses`]) looks at it.
    pub wavelength: f32,
}

/// Samples that are turned into rays together: a useful ray through the double Gauss takes 28 ns with AVX2 in
/// bundles of 32 and 42 in bundles of 16 (`cargo bench --bench lens`).
pub const BUNDLE: usize = 32;

/// The ray that carries light to a film point.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    /// In render space, direction of unit length.
    pub ray: Ray,
    /// What the radiance along the ray counts for: for `realistic` see [`Weighting`], else 1.
    pub weight: f32,
    /// What each channel counts for besides: 1 but for a camera that disperses, whose rays are each of one part of
    /// the spectrum; then 1 on average.
    pub tint: Rgb,
    /// The rays one pixel to the right and one pixel down, through the same point of the lens (for
    /// `environment` to first order).
    pub differentials: Option<RayDifferentials>,
}

impl CameraRay {
    /// The rays `spacing` pixels to the right and down.
    pub fn scaled_differentials(&self, spacing: f32) -> Option<RayDifferentials> {
        Some(self.differentials?.scaled(&self.ray, spacing))
    }
}

/// The film as cameras see it.
#[derive(Clone, Copy, Debug)]
pub struct FilmGeometry {
    /// Pixels of the full film, before cropping.
    pub resolution: UVec2,
    /// Diagonal in millimeters; only `realistic` looks at it.
    pub diagonal_mm: f64,
}

impl FilmGeometry {
    /// Width and height in millimeters of a film with diagonal `diagonal_mm` and square pixels.
    pub fn size_mm(&self, diagonal_mm: f64) -> [f64; 2] {
        let aspect = f64::from(self.resolution.y) / f64::from(self.resolution.x);
        let width = diagonal_mm / (1.0 + aspect * aspect).sqrt();
        [width, aspect * width]
    }
}

/// Why a camera cannot be made although its parameters could be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// The film has no pixels.
    #[error("the film has no pixels")]
    EmptyFilm,
    /// The film's diagonal is not a positive length.
    #[error("the film's diagonal is {0} mm; expected a positive length")]
    FilmDiagonal(f64),
    /// A tilted film reaches into the lens.
    #[error(
        "the film is tilted so far that it reaches {0:.2} mm into the lens; a smaller tilt or film, or another focus, keeps it behind"
    )]
    FilmInLens(f64),
    /// The lens has no model of the kind that is asked for.
    #[error("{0}")]
    LensModel(crate::optics::models::NoFocalLength),
    /// The camera's transformation cannot be inverted.
    #[error("the camera's transformation cannot be inverted (a Scale by 0?)")]
    SingularTransform,
}

/// What the command line says of cameras; only `realistic` looks at it.
#[derive(Clone, Copy, Debug, Default)]
pub struct CameraChoices {
    /// `--f-number`: sets the stop.
    pub f_number: Option<f64>,
    /// `--focus-point`: what to focus on, in fractions of the image from its upper left corner.
    pub focus_point: Option<[f64; 2]>,
}

impl CameraSpec {
    /// Reads a `Camera` directive. Every problem is reported to the diagnostics under the
    /// parameter that has it. Where no camera can be made of the rest, an ordinary one stands in, so
    /// that what else is wrong with the scene is found out as well.
    /// `choices` of the command line win over the parameters.
    pub fn from_params(params: &ParamReader, choices: &CameraChoices) -> CameraSpec {
        CameraSpec::read(params, choices).unwrap_or_else(|| stand_in(params))
    }

    /// The name of the thing to focus on, and where the scene asks for it; `None` if it asks for none.
    pub fn focus_object(&self) -> Option<(&str, Option<Span>)> {
        match self {
            CameraSpec::Realistic(spec) => spec.focus_object(),
            CameraSpec::Projective(_) | CameraSpec::Environment(_) => None,
        }
    }

    /// Chooses the renderer whose quirks are reproduced (`--compat`); only `realistic` has any.
    pub fn set_compat(&mut self, compat: Compat) {
        if let CameraSpec::Realistic(spec) = self {
            spec.compat = compat;
        }
    }

    /// Returns `true` if ghosts are requested.
    pub fn has_ghosts(&self) -> bool {
        matches!(self, CameraSpec::Realistic(spec) if spec.ghosts)
    }

    /// Chooses what rays are made with (`--lens-model`); only `realistic` has a choice.
    pub fn set_model(&mut self, model: crate::optics::models::ModelKind) {
        if let CameraSpec::Realistic(spec) = self {
            spec.model = model;
        }
    }
}

/// The pinhole that shows what a 50 mm lens would on 35 mm film. It is what those get who keep going
/// where a lens file is missing; any other error is not to be passed over.
fn stand_in(params: &ParamReader) -> CameraSpec {
    /// Degrees that the shorter side of 24 × 36 mm subtends at 50 mm.
    const NORMAL_FOV: f64 = 27.0;
    // Parameters that were not come to are not superfluous.
    params.accept_all();
    CameraSpec::Projective(Box::new(ProjectiveSpec {
        fov: Some(NORMAL_FOV),
        shutter: Shutter::from_params(params),
        ..ProjectiveSpec::default()
    }))
}
