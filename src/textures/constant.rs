//! `constant`.

use super::TextureValue;
use crate::params::ParamReader;

/// The same value everywhere. Parameters: `value` (1), of the texture's kind.
#[derive(Clone, Copy, Debug)]
pub struct Constant<V> {
    /// The value.
    pub value: V,
}

impl<V: TextureValue> Constant<V> {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Constant<V> {
        Constant {
            value: V::constant_from_params(reader, "value", 1.0),
        }
    }
}
