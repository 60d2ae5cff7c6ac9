//! `fbm`.

use super::noise::Octaves;
use super::solid::SolidMapping;
use super::{Compiler, Evaluate, TextureClass, TextureValue, Textures, octaves_from_params};
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

impl<V: TextureValue> TextureClass<V> for Fbm {
    type Compiled = Fbm;

    fn from_params(reader: &ParamReader, ctm: &Transform) -> Fbm {
        Fbm {
            mapping: SolidMapping::new(ctm),
            octaves: octaves_from_params(reader),
        }
    }

    fn compile(&self, compiler: &mut Compiler) -> Fbm {
        Fbm {
            mapping: self.mapping.from_render(compiler.render_from_world),
            ..*self
        }
    }
}

impl<V: TextureValue> Evaluate<V> for Fbm {
    fn evaluate(&self, _textures: &Textures, at: &TexturePoint) -> V {
        V::splat(self.octaves.fbm(&self.mapping.point(at)))
    }
}
