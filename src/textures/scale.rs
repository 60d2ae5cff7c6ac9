//! `scale`.

use super::{TextureValue, Textures};
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

impl<V: TextureValue> Scale<V> {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Scale<V> {
        Scale {
            tex1: V::input_from_params(reader, "tex1", 1.0),
            tex2: V::input_from_params(reader, "tex2", 1.0),
        }
    }

    pub(super) fn evaluate(&self, textures: &Textures, at: &TexturePoint) -> V {
        V::lookup(self.tex1, textures, at) * V::lookup(self.tex2, textures, at)
    }
}
