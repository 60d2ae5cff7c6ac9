//! `bilerp`.

use super::{Compiler, Evaluate, Mapping, MappingSpec, TextureClass, TextureValue, Textures};
use crate::math::transform::Transform;
use crate::params::ParamReader;
use crate::surface::TexturePoint;

/// Bilinear interpolation between four corner values, carried on (not repeated) outside the unit
/// square. Parameters: `v00` (0), `v01` (1) at s = 0, t = 1, `v10` (0), `v11` (1), constants of the
/// texture's kind; a 2-D mapping.
#[derive(Clone, Copy, Debug)]
pub struct Bilerp<V, M> {
    /// From points to (s, t).
    pub mapping: M,
    /// Value at (0, 0).
    pub v00: V,
    /// Value at (0, 1).
    pub v01: V,
    /// Value at (1, 0).
    pub v10: V,
    /// Value at (1, 1).
    pub v11: V,
}

impl<V: TextureValue> TextureClass<V> for Bilerp<V, MappingSpec> {
    type Compiled = Bilerp<V, Mapping>;

    fn from_params(reader: &ParamReader, ctm: &Transform) -> Self {
        Bilerp {
            mapping: MappingSpec::from_params(reader, ctm),
            v00: V::constant_from_params(reader, "v00", 0.0),
            v01: V::constant_from_params(reader, "v01", 1.0),
            v10: V::constant_from_params(reader, "v10", 0.0),
            v11: V::constant_from_params(reader, "v11", 1.0),
        }
    }

    fn compile(&self, compiler: &mut Compiler) -> Bilerp<V, Mapping> {
        Bilerp {
            mapping: self.mapping.compile(compiler.render_from_world),
            v00: self.v00,
            v01: self.v01,
            v10: self.v10,
            v11: self.v11,
        }
    }
}

impl<V: TextureValue> Evaluate<V> for Bilerp<V, Mapping> {
    const FILTERS: bool = false;

    fn evaluate(&self, _textures: &Textures, at: &TexturePoint) -> V {
        let st = self.mapping.position(at);
        self.v00 * ((1.0 - st.x) * (1.0 - st.y))
            + self.v01 * ((1.0 - st.x) * st.y)
            + self.v10 * (st.x * (1.0 - st.y))
            + self.v11 * (st.x * st.y)
    }
}
