//! What every class of texture implements in its own file.

use super::compile::Compiler;
use super::{TextureValue, Textures};
use crate::inputs::TexturesRead;
use crate::math::transform::Transform;
use crate::params::ParamReader;
use crate::surface::TexturePoint;

/// A class of texture with values of type `V`.
pub(super) trait TextureClass<V: TextureValue> {
    /// `true` if there are no float textures of it.
    const COLORS_ONLY: bool = false;

    /// `true` if it uses the footprint.
    const FILTERS: bool = true;

    /// Reads the parameters under the transformation `ctm`.
    fn from_params(reader: &ParamReader, ctm: &Transform) -> Self;

    /// The textures it looks values up in.
    fn inputs(&self) -> TexturesRead {
        Vec::new()
    }

    /// Moves it from world to render space, and asks for the files it needs.
    fn prepare(&mut self, _compiler: &mut Compiler) {}

    /// The value at a point, once it is prepared.
    fn evaluate(&self, textures: &Textures, at: &TexturePoint) -> V;

    /// Returns `true` if this one uses the footprint.
    fn needs_footprint(&self) -> bool {
        Self::FILTERS
    }
}
