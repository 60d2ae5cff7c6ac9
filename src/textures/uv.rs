//! `uv`.

use super::{Compiler, Evaluate, Mapping, MappingSpec, TextureClass, TextureValue, Textures};
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

impl<V: TextureValue> TextureClass<V> for Uv<MappingSpec> {
    type Compiled = Uv<Mapping>;

    const COLORS_ONLY: bool = true;

    fn from_params(reader: &ParamReader, ctm: &Transform) -> Self {
        let mapping = MappingSpec::from_params(reader, ctm);
        Uv { mapping }
    }

    fn compile(&self, compiler: &mut Compiler) -> Uv<Mapping> {
        let mapping = self.mapping.compile(compiler.render_from_world);
        Uv { mapping }
    }
}

impl<V: TextureValue> Evaluate<V> for Uv<Mapping> {
    const FILTERS: bool = false;

    fn evaluate(&self, _textures: &Textures, at: &TexturePoint) -> V {
        let st = self.mapping.position(at);
        V::from_texel(Rgb::new(st.x - st.x.floor(), st.y - st.y.floor(), 0.0))
    }
}
