//! `mix`.

use super::{Compiler, Evaluate, TextureClass, TextureValue, Textures};
use crate::inputs::FloatInput;
use crate::math::transform::Transform;
use crate::params::ParamReader;
use crate::surface::TexturePoint;

/// Linear interpolation between two textures: (1 − amount) · tex1 + amount · tex2, the opposite
/// sense of the `mix` *material*. Parameters: `tex1` (0), `tex2` (1), of the texture's own kind;
/// float `amount` (0.5).
#[derive(Clone, Copy, Debug)]
pub struct Mix<V: TextureValue> {
    /// Value where the amount is 0.
    pub tex1: V::Input,
    /// Value where the amount is 1.
    pub tex2: V::Input,
    /// Weight of `tex2`; may lie outside 0…1.
    pub amount: FloatInput,
}

impl<V: TextureValue> TextureClass<V> for Mix<V> {
    type Compiled = Mix<V>;

    fn from_params(reader: &ParamReader, _ctm: &Transform) -> Mix<V> {
        Mix {
            tex1: V::input_from_params(reader, "tex1", 0.0),
            tex2: V::input_from_params(reader, "tex2", 1.0),
            amount: reader.float_input("amount", 0.5),
        }
    }

    fn inputs(&self) -> Vec<V::Input> {
        vec![self.tex1, self.tex2]
    }

    fn amount(&self) -> Option<FloatInput> {
        Some(self.amount)
    }

    fn compile(&self, _compiler: &mut Compiler) -> Mix<V> {
        *self
    }
}

impl<V: TextureValue> Evaluate<V> for Mix<V> {
    const FILTERS: bool = false;

    fn evaluate(&self, textures: &Textures, at: &TexturePoint) -> V {
        let amount = textures.float(&self.amount, at);
        V::lookup(self.tex1, textures, at) * (1.0 - amount)
            + V::lookup(self.tex2, textures, at) * amount
    }
}
