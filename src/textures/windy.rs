//! `windy`.

use super::noise::Octaves;
use super::solid::SolidMapping;
use crate::math::transform::Transform;
use crate::surface::TexturePoint;

/// How strongly the wind blows here: coarse noise, ten times as large as the waves.
const WIND: Octaves = Octaves {
    most: 3,
    roughness: 0.5,
};

/// The height of the waves it makes.
const WAVES: Octaves = Octaves {
    most: 6,
    roughness: 0.5,
};

/// Waves on water, as strong as a wind that varies over it; of either sign. No parameters. The CTM
/// at the directive takes points to the noise (Pharr, Jakob and Humphreys 2016, §10.6.5).
#[derive(Clone, Copy, Debug)]
pub struct Windy {
    mapping: SolidMapping,
}

impl Windy {
    /// Under the transformation `ctm`.
    pub fn new(ctm: &Transform) -> Windy {
        Windy {
            mapping: SolidMapping::new(ctm),
        }
    }

    pub(super) fn compile(&self, render_from_world: &Transform) -> Windy {
        Windy {
            mapping: self.mapping.from_render(render_from_world),
        }
    }

    pub(super) fn evaluate(&self, at: &TexturePoint) -> f32 {
        let at = self.mapping.point(at);
        WIND.fbm(&at.scaled(0.1)).abs() * WAVES.fbm(&at)
    }
}
