//! `uv`.

use super::{Compiler, Mapping, TextureClass, TextureValue, Textures};
use crate::math::Rgb;
use crate::math::transform::Transform;
use crate::params::ParamReader;
use crate::surface::TexturePoint;

/// Shows the parameterisation: red is the fraction of s, green the fraction of t, blue is 0.
/// Spectrum only. Parameters: a 2-D mapping.
#[derive(Clone, Copy, Debug)]
pub struct Uv {
    /// From points to (s, t).
    pub mapping: Mapping,
}

impl<V: TextureValue> TextureClass<V> for Uv {
    const FILTERS: bool = false;

    const COLORS_ONLY: bool = true;

    fn from_params(reader: &ParamReader, ctm: &Transform) -> Self {
        let mapping = Mapping::from_params(reader, ctm);
        Uv { mapping }
    }

    fn prepare(&mut self, compiler: &mut Compiler) {
        self.mapping.place(compiler.render_from_world);
    }

    fn evaluate(&self, _textures: &Textures, at: &TexturePoint) -> V {
        let st = self.mapping.position(at);
        V::from_texel(Rgb::new(st.x - st.x.floor(), st.y - st.y.floor(), 0.0))
    }
}
