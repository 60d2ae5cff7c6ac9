//! `bilerp`.

use super::{Compiler, Mapping, TextureClass, TextureValue, Textures};
use crate::math::transform::Transform;
use crate::params::ParamReader;
use crate::surface::TexturePoint;

/// Bilinear interpolation between four corner values, carried on (not repeated) outside the unit
/// square. Parameters: `v00` (0), `v01` (1) at s = 0, t = 1, `v10` (0), `v11` (1), constants of the
/// texture's kind; a 2-D mapping.
#[derive(Clone, Copy, Debug)]
pub struct Bilerp<V> {
    /// From points to (s, t).
    pub mapping: Mapping,
    /// Value at (0, 0).
    pub v00: V,
    /// Value at (0, 1).
    pub v01: V,
    /// Value at (1, 0).
    pub v10: V,
    /// Value at (1, 1).
    pub v11: V,
}

impl<V: TextureValue> TextureClass<V> for Bilerp<V> {
    const FILTERS: bool = false;

    fn from_params(reader: &ParamReader, ctm: &Transform) -> Self {
        Bilerp {
            mapping: Mapping::from_params(reader, ctm),
            v00: V::constant_from_params(reader, "v00", 0.0),
            v01: V::constant_from_params(reader, "v01", 1.0),
            v10: V::constant_from_params(reader, "v10", 0.0),
            v11: V::constant_from_params(reader, "v11", 1.0),
        }
    }

    fn prepare(&mut self, compiler: &mut Compiler) {
        self.mapping.place(compiler.render_from_world);
    }

    fn evaluate(&self, _textures: &Textures, at: &TexturePoint) -> V {
        let st = self.mapping.position(at);
        self.v00 * ((1.0 - st.x) * (1.0 - st.y))
            + self.v01 * ((1.0 - st.x) * st.y)
            + self.v10 * (st.x * (1.0 - st.y))
            + self.v11 * (st.x * st.y)
    }
}
