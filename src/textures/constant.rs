//! `constant`.

use super::{Compiler, Evaluate, TextureClass, TextureValue, Textures};
use crate::math::transform::Transform;
use crate::params::ParamReader;
use crate::surface::TexturePoint;

/// The same value everywhere. Parameters: `value` (1), of the texture's kind.
#[derive(Clone, Copy, Debug)]
pub struct Constant<V> {
    /// The value.
    pub value: V,
}

impl<V: TextureValue> TextureClass<V> for Constant<V> {
    type Compiled = Constant<V>;

    fn from_params(reader: &ParamReader, _ctm: &Transform) -> Constant<V> {
        Constant {
            value: V::constant_from_params(reader, "value", 1.0),
        }
    }
    fn compile(&self, _compiler: &mut Compiler) -> Constant<V> {
        *self
    }
}

impl<V: TextureValue> Evaluate<V> for Constant<V> {
    const FILTERS: bool = false;

    fn evaluate(&self, _textures: &Textures, _at: &TexturePoint) -> V {
        self.value
    }
}
