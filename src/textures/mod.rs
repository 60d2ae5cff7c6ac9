//! Textures: values that vary over a surface (docs/scene-language.md §3.9).
//!
//! A [`TextureSpec`] is what the scene file says. [`Textures::compile`] loads the images, moves
//! mappings to render space and freezes all textures of a scene into one [`Textures`], which
//! materials and other textures look values up in by [`FloatInput`] and
//! [`SpectrumInput`](crate::params::SpectrumInput).
//! Float- and spectrum-valued textures share their code through [`TextureValue`].
//!
//! A texture may use only textures declared before it, so look-ups end; chains deeper than
//! [`MAX_DEPTH`] are refused at compilation, so they need little stack as well.

mod bilerp;
mod checkerboard;
mod compile;
mod constant;
mod dots;
mod fbm;
mod imagemap;
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
pub use compile::{TextureProblem, Textures};
pub use constant::Constant;
pub use dots::Dots;
pub use fbm::Fbm;
pub use imagemap::{Imagemap, ImagemapSpec};
pub use mapping::{Mapping, MappingSpec, PointMap, TextureCoordinates};
pub use marble::Marble;
pub use mix::Mix;
pub use nesting::{MAX_LOOKUPS, Nesting};
pub use noise::Octaves;
pub use ptex::{Ptex, PtexSpec};
pub use scale::Scale;
pub use solid::SolidMapping;
pub use usage::TextureUsage;
pub use uv::Uv;
pub use value::TextureValue;
pub use windy::Windy;
pub use wrinkled::Wrinkled;

use crate::math::Rgb;
use crate::math::transform::Transform;
use crate::params::{FloatInput, ParamReader};
use crate::surface::TexturePoint;

/// Deepest nesting of textures in textures. Scenes in the wild stay below 10; the stack of a
/// worker thread has room for far more than this.
pub const MAX_DEPTH: usize = 256;

/// The classes a scene may name, for "did you mean".
const CLASSES: [&str; 13] = [
    "constant",
    "scale",
    "mix",
    "bilerp",
    "uv",
    "checkerboard",
    "imagemap",
    "dots",
    "fbm",
    "wrinkled",
    "windy",
    "marble",
    "ptex",
];

/// A texture as the scene file describes it, in world space.
#[derive(Clone, Debug)]
pub enum TextureSpec<V: TextureValue> {
    /// `constant`
    Constant(Constant<V>),
    /// `scale`
    Scale(Scale<V>),
    /// `mix`
    Mix(Mix<V>),
    /// `bilerp`
    Bilerp(Bilerp<V, MappingSpec>),
    /// `uv`
    Uv(Uv<MappingSpec>),
    /// `checkerboard`
    Checkerboard(Checkerboard<V, MappingSpec>),
    /// `imagemap`
    Imagemap(ImagemapSpec),
    /// `dots`
    Dots(Dots<V, MappingSpec>),
    /// `fbm`
    Fbm(Fbm),
    /// `wrinkled`
    Wrinkled(Wrinkled),
    /// `windy`
    Windy(Windy),
    /// `marble`
    Marble(Marble),
    /// `ptex`
    Ptex(PtexSpec),
}

/// A float-valued [`TextureSpec`].
pub type FloatTextureSpec = TextureSpec<f32>;

/// A spectrum-valued [`TextureSpec`].
pub type SpectrumTextureSpec = TextureSpec<Rgb>;

/// A texture ready for look-ups, in render space.
#[derive(Clone, Debug)]
pub(crate) enum Texture<V: TextureValue> {
    Constant(Constant<V>),
    Scale(Scale<V>),
    Mix(Mix<V>),
    Bilerp(Bilerp<V, Mapping>),
    Uv(Uv<Mapping>),
    Checkerboard(Checkerboard<V, Mapping>),
    Imagemap(Imagemap),
    Dots(Dots<V, Mapping>),
    Fbm(Fbm),
    Wrinkled(Wrinkled),
    Windy(Windy),
    Marble(Marble),
    Ptex(Ptex),
}

/// The float texture that `Texture "name" "float" "class"` describes under the transformation
/// `ctm`; `None`, with a message, where there is no such class.
pub fn from_params_float(reader: &ParamReader, ctm: &Transform) -> Option<FloatTextureSpec> {
    if matches!(reader.kind(), "uv" | "marble") {
        reader.accept_all();
        reader.warn(
            "",
            format!(
                "a `{}` texture has colors only: no float texture is defined",
                reader.kind()
            ),
        );
        return None;
    }
    from_params(reader, ctm)
}

/// The spectrum texture that `Texture "name" "spectrum" "class"` describes; see
/// [`from_params_float`].
pub fn from_params_spectrum(reader: &ParamReader, ctm: &Transform) -> Option<SpectrumTextureSpec> {
    from_params(reader, ctm)
}

fn from_params<V: TextureValue>(reader: &ParamReader, ctm: &Transform) -> Option<TextureSpec<V>> {
    Some(match reader.kind() {
        "constant" => TextureSpec::Constant(Constant::from_params(reader)),
        "scale" => TextureSpec::Scale(Scale::from_params(reader)),
        "mix" => TextureSpec::Mix(Mix::from_params(reader)),
        "bilerp" => TextureSpec::Bilerp(Bilerp::from_params(reader, ctm)),
        "uv" => TextureSpec::Uv(Uv::from_params(reader, ctm)),
        "checkerboard" => TextureSpec::Checkerboard(Checkerboard::from_params(reader, ctm)),
        "imagemap" => TextureSpec::Imagemap(ImagemapSpec::from_params(reader, ctm)),
        "dots" => TextureSpec::Dots(Dots::from_params(reader, ctm)),
        "fbm" => TextureSpec::Fbm(Fbm::from_params(reader, ctm)),
        "wrinkled" => TextureSpec::Wrinkled(Wrinkled::from_params(reader, ctm)),
        "windy" => TextureSpec::Windy(Windy::new(ctm)),
        "marble" => TextureSpec::Marble(Marble::from_params(reader, ctm)),
        "ptex" => TextureSpec::Ptex(PtexSpec::from_params(reader)),
        _ => {
            reader.unknown_kind_replaced(&CLASSES, "no texture is defined");
            return None;
        }
    })
}

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

    /// The textures this one looks values up in.
    fn operands(&self) -> Operands<V> {
        match self {
            TextureSpec::Scale(t) => Operands {
                own: vec![t.tex1, t.tex2],
                amount: None,
            },
            TextureSpec::Mix(t) => Operands {
                own: vec![t.tex1, t.tex2],
                amount: Some(t.amount),
            },
            TextureSpec::Checkerboard(t) => Operands {
                own: vec![t.tex1, t.tex2],
                amount: None,
            },
            TextureSpec::Dots(t) => Operands {
                own: vec![t.inside, t.outside],
                amount: None,
            },
            TextureSpec::Constant(_)
            | TextureSpec::Bilerp(_)
            | TextureSpec::Uv(_)
            | TextureSpec::Imagemap(_)
            | TextureSpec::Fbm(_)
            | TextureSpec::Wrinkled(_)
            | TextureSpec::Windy(_)
            | TextureSpec::Marble(_)
            | TextureSpec::Ptex(_) => Operands {
                own: Vec::new(),
                amount: None,
            },
        }
    }
}

/// Inputs of a texture: of its own kind, and a float.
struct Operands<V: TextureValue> {
    own: Vec<V::Input>,
    amount: Option<FloatInput>,
}

impl<V: TextureValue> Texture<V> {
    fn evaluate(&self, textures: &Textures, at: &TexturePoint) -> V {
        match self {
            Texture::Constant(t) => t.value,
            Texture::Scale(t) => t.evaluate(textures, at),
            Texture::Mix(t) => t.evaluate(textures, at),
            Texture::Bilerp(t) => t.evaluate(at),
            Texture::Uv(t) => t.evaluate(at),
            Texture::Checkerboard(t) => t.evaluate(textures, at),
            Texture::Imagemap(t) => t.evaluate(textures, at),
            Texture::Dots(t) => t.evaluate(textures, at),
            Texture::Fbm(t) => V::splat(t.evaluate(at)),
            Texture::Wrinkled(t) => V::splat(t.evaluate(at)),
            Texture::Windy(t) => V::splat(t.evaluate(at)),
            Texture::Marble(t) => V::from_texel(t.evaluate(at)),
            Texture::Ptex(t) => t.evaluate(textures, at),
        }
    }

    fn needs_footprint(&self) -> bool {
        match self {
            Texture::Imagemap(_)
            | Texture::Fbm(_)
            | Texture::Wrinkled(_)
            | Texture::Windy(_)
            | Texture::Marble(_)
            | Texture::Ptex(_) => true,
            Texture::Checkerboard(t) => t.needs_footprint(),
            Texture::Constant(_)
            | Texture::Scale(_)
            | Texture::Mix(_)
            | Texture::Bilerp(_)
            | Texture::Uv(_)
            | Texture::Dots(_) => false,
        }
    }
}
