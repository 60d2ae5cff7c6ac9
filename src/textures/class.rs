//! What every class of texture implements in its own file.

use super::compile::Compiler;
use super::{TextureValue, Textures};
use crate::inputs::FloatInput;
use crate::math::transform::Transform;
use crate::params::ParamReader;
use crate::surface::TexturePoint;

/// A class of texture with values of type `V`, as the scene file describes it.
pub(super) trait TextureClass<V: TextureValue>: Sized {
    /// The texture in render space.
    type Compiled: Evaluate<V>;

    /// Whether there are no float textures of it.
    const COLORS_ONLY: bool = false;

    /// Reads the parameters under the transformation `ctm`.
    fn from_params(reader: &ParamReader, ctm: &Transform) -> Self;

    /// The inputs of the texture's own kind.
    fn inputs(&self) -> Vec<V::Input> {
        Vec::new()
    }

    /// The input that is a float whatever the texture's kind.
    fn amount(&self) -> Option<FloatInput> {
        None
    }

    /// Moves it to render space.
    fn compile(&self, compiler: &mut Compiler) -> Self::Compiled;
}

/// A texture ready for look-ups.
pub(super) trait Evaluate<V: TextureValue> {
    /// Whether it uses the footprint.
    const FILTERS: bool = true;

    /// The value at a point.
    fn evaluate(&self, textures: &Textures, at: &TexturePoint) -> V;

    /// Returns `true` if this one uses the footprint.
    fn needs_footprint(&self) -> bool {
        Self::FILTERS
    }
}
