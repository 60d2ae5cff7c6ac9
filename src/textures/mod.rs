//! Textures: values that vary over a surface (docs/scene-language.md §3.9).
//!
//! A [`TextureSpec`] is what the scene file says, [`TextureSpecs`] are all of a scene.
//! [`Textures::compile`] loads the images, moves
//! mappings to render space and freezes all textures of a scene into one [`Textures`], which
//! materials and other textures look values up in by [`FloatInput`] and
//! [`SpectrumInput`](crate::inputs::SpectrumInput).
//! Float- and spectrum-valued textures share their code through [`TextureValue`].
//!
//! A texture may use only textures defined before it, so look-ups end; [`TextureSpecs`] takes no chains so
//! deep that they would need much stack.

mod bilerp;
mod checkerboard;
mod class;
mod compile;
mod constant;
mod dots;
mod fbm;
mod imagemap;
mod kinds;
mod mapping;
mod marble;
mod mipmap;
mod mix;
mod nesting;
mod noise;
mod ptex;
mod scale;
mod solid;
mod usage;
mod uv;
mod value;
mod windy;
mod wrinkled;

pub use bilerp::Bilerp;
pub use checkerboard::Checkerboard;
use class::{Evaluate, TextureClass};
use compile::Compiler;
pub use compile::Textures;
pub use constant::Constant;
pub use dots::Dots;
pub use fbm::Fbm;
pub use imagemap::ImagemapSpec;
use kinds::Texture;
pub use kinds::TextureSpec;
pub use mapping::{Mapping, MappingSpec, PointMap, TextureCoordinates};
pub use marble::Marble;
pub use mix::Mix;
pub use nesting::TextureSpecs;
pub use noise::Octaves;
pub use ptex::PtexSpec;
pub use scale::Scale;
pub use solid::SolidMapping;
pub use usage::TextureUsage;
pub use uv::Uv;
pub use value::TextureValue;
pub use windy::Windy;
pub use wrinkled::Wrinkled;

use crate::inputs::FloatInput;
use crate::math::Rgb;
use crate::math::transform::Transform;
use crate::params::ParamReader;
use crate::surface::TexturePoint;

/// A float-valued [`TextureSpec`].
pub type FloatTextureSpec = TextureSpec<f32>;

/// A spectrum-valued [`TextureSpec`].
pub type SpectrumTextureSpec = TextureSpec<Rgb>;

/// The most octaves: 1.99¹²⁸ is the largest frequency in single precision.
const MAX_OCTAVES: i64 = 128;

/// `octaves` (8) and `roughness` (0.5) of a texture made of noise.
fn octaves_from_params(reader: &ParamReader) -> Octaves {
    Octaves {
        most: reader.integer_within("octaves", 8, 0..=MAX_OCTAVES) as u8,
        roughness: reader.float("roughness", 0.5) as f32,
    }
}

/// Inputs of a texture: of its own kind, and a float.
struct Operands<V: TextureValue> {
    own: Vec<V::Input>,
    amount: Option<FloatInput>,
}
