//! `constant`, `scale` and `mix`: one value, and combinations of two.

use super::value::textures_of;
use super::{TextureClass, TextureValue, Textures};
use crate::inputs::{FloatInput, TexturesRead};
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
    const FILTERS: bool = false;

    fn from_params(reader: &ParamReader, _ctm: &Transform) -> Constant<V> {
        let value = V::constant_from_params(reader, "value", 1.0);
        Constant { value }
    }

    fn evaluate(&self, _textures: &Textures, _at: &TexturePoint) -> V {
        self.value
    }
}

/// The product of two textures. Parameters: `tex1`, `tex2` (1), both of the texture's own kind.
#[derive(Clone, Copy, Debug)]
pub struct Scale<V: TextureValue> {
    /// First factor.
    pub tex1: V::Input,
    /// Second factor.
    pub tex2: V::Input,
}

impl<V: TextureValue> TextureClass<V> for Scale<V> {
    const FILTERS: bool = false;

    fn from_params(reader: &ParamReader, _ctm: &Transform) -> Scale<V> {
        Scale {
            tex1: V::input_from_params(reader, "tex1", 1.0),
            tex2: V::input_from_params(reader, "tex2", 1.0),
        }
    }

    fn inputs(&self) -> TexturesRead {
        textures_of::<V>([self.tex1, self.tex2])
    }

    fn evaluate(&self, textures: &Textures, at: &TexturePoint) -> V {
        V::lookup(self.tex1, textures, at) * V::lookup(self.tex2, textures, at)
    }
}

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
    const FILTERS: bool = false;

    fn from_params(reader: &ParamReader, _ctm: &Transform) -> Mix<V> {
        Mix {
            tex1: V::input_from_params(reader, "tex1", 0.0),
            tex2: V::input_from_params(reader, "tex2", 1.0),
            amount: reader.float_input("amount", 0.5),
        }
    }

    fn inputs(&self) -> TexturesRead {
        let mut textures = textures_of::<V>([self.tex1, self.tex2]);
        textures.extend(self.amount.texture());
        textures
    }

    fn evaluate(&self, textures: &Textures, at: &TexturePoint) -> V {
        let amount = textures.float(&self.amount, at);
        V::lookup(self.tex1, textures, at) * (1.0 - amount)
            + V::lookup(self.tex2, textures, at) * amount
    }
}
