//! Textures: values that vary over a surface (docs/scene-language.md §3.9).
//!
//! A [`Texture`] is first what the scene file says; [`TextureSpecs`] are all of a scene.
//! [`Textures::compile`] loads the images, moves
//! mappings to render space and freezes all textures of a scene into one [`Textures`], which
//! materials and other textures look values up in by [`FloatInput`](crate::inputs::FloatInput) and
//! [`SpectrumInput`](crate::inputs::SpectrumInput).
//! Float- and spectrum-valued textures share their code through [`TextureValue`].
//!
//! A texture may use only textures defined before it, so look-ups end; [`TextureSpecs`] takes no chains so
//! deep that they would need much stack.

mod bilerp;
mod checkerboard;
mod class;
mod combinations;
mod compile;
mod dots;
mod imagemap;
mod kinds;
mod mapping;
mod marble;
mod mipmap;
mod nesting;
mod noise;
mod ptex;
mod solid;
mod usage;
mod uv;
mod value;

pub use bilerp::Bilerp;
pub use checkerboard::Checkerboard;
use class::TextureClass;
pub use combinations::Constant;
use compile::Compiler;
pub use compile::{Textures, Wanted};
pub use dots::Dots;
pub use imagemap::Imagemap;
pub use kinds::Texture;
pub use mapping::{Mapping, PointMap, TextureCoordinates};
pub use marble::Marble;
pub use nesting::TextureSpecs;
pub use ptex::Ptex;
pub use usage::TextureUsage;
pub use uv::Uv;
pub use value::TextureValue;

use crate::math::Rgb;

/// A float-valued [`Texture`].
pub type FloatTextureSpec = Texture<f32>;

/// A spectrum-valued [`Texture`].
pub type SpectrumTextureSpec = Texture<Rgb>;
