//! `uv`.

use super::{Mapping, MappingSpec, TextureValue};
use crate::math::Rgb;
use crate::math::transform::Transform;
use crate::params::ParamReader;
use crate::surface::TexturePoint;

/// Shows the parameterisation: red is the fraction of s, green the fraction of t, blue is 0.
/// Spectrum only. Parameters: a 2-D mapping.
#[derive(Clone, Copy, Debug)]
pub struct Uv<M> {
    /// From points to (s, t).
    pub mapping: M,
}

impl Uv<MappingSpec> {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader, ctm: &Transform) -> Self {
        Uv {
            mapping: MappingSpec::from_params(reader, ctm),
        }
    }

    pub(super) fn compile(&self, render_from_world: &Transform) -> Uv<Mapping> {
        Uv {
            mapping: self.mapping.compile(render_from_world),
        }
    }
}

impl Uv<Mapping> {
    pub(super) fn evaluate<V: TextureValue>(&self, at: &TexturePoint) -> V {
        let st = self.mapping.position(at);
        V::from_texel(Rgb::new(st.x - st.x.floor(), st.y - st.y.floor(), 0.0))
    }
}
