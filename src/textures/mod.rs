//! Textures: values that vary over a surface (docs/scene-language.md §3.9).
//!
//! A [`TextureSpec`] is what the scene file says. [`Textures::compile`] loads the images, moves
//! mappings to render space and freezes all textures of a scene into one [`Textures`], which
//! materials and other textures look values up in by [`FloatInput`] and
//! [`SpectrumInput`](crate::inputs::SpectrumInput).
//! Float- and spectrum-valued textures share their code through [`TextureValue`].
//!
//! A texture may use only textures declared before it, so look-ups end; chains deeper than
//! [`MAX_DEPTH`] are refused at compilation, so they need little stack as well.

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
pub use compile::{TextureProblem, Textures};
pub use constant::Constant;
pub use dots::Dots;
pub use fbm::Fbm;
pub use imagemap::ImagemapSpec;
use kinds::Texture;
pub use kinds::TextureSpec;
pub use mapping::{Mapping, MappingSpec, PointMap, TextureCoordinates};
pub use marble::Marble;
pub use mix::Mix;
pub use nesting::{MAX_LOOKUPS, Nesting};
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

/// Deepest nesting of textures in textures. Scenes in the wild stay below 10; the stack of a
/// worker thread has room for far more than this.
pub const MAX_DEPTH: usize = 256;

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

impl<V: TextureValue> TextureSpec<V> {
    /// How much it nests other textures, where the nesting of float textures and of textures of its
    /// own kind is known.
    pub fn nesting(&self, floats: &[Nesting], own: &[Nesting]) -> Nesting {
        let Operands {
            own: inputs,
            amount,
        } = self.operands();
        let inputs = inputs.into_iter().filter_map(V::texture_index);
        let amount = amount.and_then(f32::texture_index);
        let below = inputs
            .filter_map(|i| own.get(i))
            .chain(amount.and_then(|i| floats.get(i)));
        below.fold(Nesting::NONE, |nesting, inner| Nesting {
            depth: nesting.depth.max(1 + inner.depth),
            lookups: nesting.lookups.saturating_add(inner.lookups),
        })
    }
}

/// Inputs of a texture: of its own kind, and a float.
struct Operands<V: TextureValue> {
    own: Vec<V::Input>,
    amount: Option<FloatInput>,
}
