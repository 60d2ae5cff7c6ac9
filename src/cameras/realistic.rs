//! `Camera "realistic"` (being written).

use super::{CameraError, CameraRay, CameraSample, FilmGeometry};
use crate::math::transform::Transform;
use crate::params::ParamReader;

/// Whose habits to copy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compat {
    /// Nobody's.
    #[default]
    None,
    /// The course kit on pbrt-v2.
    PbrtV2,
}

/// What a ray's radiance counts for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weighting {
    /// Irradiance.
    Physical,
    /// Relative.
    Simple,
}

/// As the scene file describes it.
#[derive(Clone, Debug)]
pub struct RealisticSpec {
    pub(super) compat: Compat,
}

impl RealisticSpec {
    /// Reads the parameters.
    pub fn from_params(_params: &ParamReader) -> Option<RealisticSpec> {
        None
    }
    /// Lines of the report.
    pub fn describe(&self, _film: &FilmGeometry) -> Vec<String> {
        Vec::new()
    }
    /// Warnings.
    pub fn warnings(&self, _film: &FilmGeometry) -> Vec<String> {
        Vec::new()
    }
}

/// Ready to make rays.
#[derive(Clone, Debug)]
pub struct Realistic;

impl Realistic {
    /// Puts `spec` behind `film`.
    pub fn new(
        _spec: &RealisticSpec,
        _film: &FilmGeometry,
        _render_from_camera: &Transform,
    ) -> Result<Realistic, CameraError> {
        Ok(Realistic)
    }
    /// The ray for `sample`.
    pub fn ray(&self, _sample: &CameraSample, _want_differentials: bool) -> Option<CameraRay> {
        None
    }
}
