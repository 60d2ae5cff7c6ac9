//! `fbm`.

use super::noise::Octaves;
use super::octaves_from_params;
use super::solid::SolidMapping;
use crate::math::transform::Transform;
use crate::params::ParamReader;
use crate::surface::TexturePoint;

/// Fractional Brownian motion: octaves of noise in space, 1.99 times finer each, those too fine for
/// the film left out. About −1 to 1. Parameters: integer `octaves` (8, at most 128), float
/// `roughness` (0.5). The CTM at the directive takes points to the noise (Pharr, Jakob and
/// Humphreys 2016, §10.6.3).
#[derive(Clone, Copy, Debug)]
pub struct Fbm {
    mapping: SolidMapping,
    octaves: Octaves,
}

impl Fbm {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader, ctm: &Transform) -> Fbm {
        Fbm {
            mapping: SolidMapping::new(ctm),
            octaves: octaves_from_params(reader),
        }
    }

    pub(super) fn compile(&self, render_from_world: &Transform) -> Fbm {
        Fbm {
            mapping: self.mapping.from_render(render_from_world),
            ..*self
        }
    }

    pub(super) fn evaluate(&self, at: &TexturePoint) -> f32 {
        self.octaves.fbm(&self.mapping.point(at))
    }
}
