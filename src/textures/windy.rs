//! `windy`.

use super::noise::Octaves;
use super::solid::SolidMapping;
use super::{Compiler, Evaluate, TextureClass, TextureValue, Textures};
use crate::math::transform::Transform;
use crate::params::ParamReader;
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

impl<V: TextureValue> TextureClass<V> for Windy {
    type Compiled = Windy;

    fn from_params(_reader: &ParamReader, ctm: &Transform) -> Windy {
        Windy {
            mapping: SolidMapping::new(ctm),
        }
    }

    fn compile(&self, compiler: &mut Compiler) -> Windy {
        Windy {
            mapping: self.mapping.from_render(compiler.render_from_world),
        }
    }
}

impl<V: TextureValue> Evaluate<V> for Windy {
    fn evaluate(&self, _textures: &Textures, at: &TexturePoint) -> V {
        let at = self.mapping.point(at);
        V::splat(WIND.fbm(&at.scaled(0.1)).abs() * WAVES.fbm(&at))
    }
}
