//! `wrinkled`.

use super::noise::Octaves;
use super::solid::SolidMapping;
use super::{Compiler, Evaluate, TextureClass, TextureValue, Textures, octaves_from_params};
use crate::math::transform::Transform;
use crate::params::ParamReader;
use crate::surface::TexturePoint;

/// Turbulence: octaves of the magnitude of noise in space, with creases where it changes its sign;
/// octaves too fine for the film are replaced by their mean. Never negative. Parameters: integer
/// `octaves` (8, at most 128), float `roughness` (0.5). The CTM at the directive takes points to
/// the noise (Pharr, Jakob and Humphreys 2016, §10.6.3-10.6.4).
#[derive(Clone, Copy, Debug)]
pub struct Wrinkled {
    mapping: SolidMapping,
    octaves: Octaves,
}

impl<V: TextureValue> TextureClass<V> for Wrinkled {
    type Compiled = Wrinkled;

    fn from_params(reader: &ParamReader, ctm: &Transform) -> Wrinkled {
        Wrinkled {
            mapping: SolidMapping::new(ctm),
            octaves: octaves_from_params(reader),
        }
    }

    fn compile(&self, compiler: &mut Compiler) -> Wrinkled {
        Wrinkled {
            mapping: self.mapping.from_render(compiler.render_from_world),
            ..*self
        }
    }
}

impl<V: TextureValue> Evaluate<V> for Wrinkled {
    fn evaluate(&self, _textures: &Textures, at: &TexturePoint) -> V {
        V::splat(self.octaves.turbulence(&self.mapping.point(at)))
    }
}
