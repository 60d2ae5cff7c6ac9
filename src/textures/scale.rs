//! `scale`.

use super::{Compiler, Evaluate, TextureClass, TextureValue, Textures};
use crate::math::transform::Transform;
use crate::params::ParamReader;
use crate::surface::TexturePoint;

/// The product of two textures. Parameters: `tex1`, `tex2` (1), both of the texture's own kind.
#[derive(Clone, Copy, Debug)]
pub struct Scale<V: TextureValue> {
    /// First factor.
    pub tex1: V::Input,
    /// Second factor.
    pub tex2: V::Input,
}

impl<V: TextureValue> TextureClass<V> for Scale<V> {
    type Compiled = Scale<V>;

    fn from_params(reader: &ParamReader, _ctm: &Transform) -> Scale<V> {
        Scale {
            tex1: V::input_from_params(reader, "tex1", 1.0),
            tex2: V::input_from_params(reader, "tex2", 1.0),
        }
    }

    fn inputs(&self) -> Vec<V::Input> {
        vec![self.tex1, self.tex2]
    }

    fn compile(&self, _compiler: &mut Compiler) -> Scale<V> {
        *self
    }
}

impl<V: TextureValue> Evaluate<V> for Scale<V> {
    const FILTERS: bool = false;

    fn evaluate(&self, textures: &Textures, at: &TexturePoint) -> V {
        V::lookup(self.tex1, textures, at) * V::lookup(self.tex2, textures, at)
    }
}
