//! What float- and spectrum-valued textures have in common.

use super::mipmap::Mipmap;
use super::{Texture, Textures};
use crate::inputs::{FloatInput, SpectrumInput, TextureRead, TexturesRead};
use crate::math::Rgb;
use crate::math::color::luminance;
use crate::params::ParamReader;
use crate::surface::TexturePoint;
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Mul};

/// The value of a texture: `f32` or [`Rgb`].
pub trait TextureValue:
    Copy
    + Debug
    + Default
    + PartialEq
    + Send
    + Sync
    + Add<Output = Self>
    + AddAssign
    + Mul<Output = Self>
    + Mul<f32, Output = Self>
    + 'static
{
    /// A constant or a texture of this kind.
    type Input: Copy + Debug + Send + Sync;

    /// `true` if there are several channels.
    const HAS_COLORS: bool;

    /// `v` in all channels.
    fn splat(v: f32) -> Self;

    /// An image's texel as this kind of value, still encoded.
    fn from_texel(texel: Rgb) -> Self;

    /// As pbrt-v3 takes the value of a Ptex file with colors, decoded.
    fn from_ptex(color: Rgb) -> Self;

    /// Applies `f` to every channel.
    fn map(self, f: impl Fn(f32) -> f32) -> Self;

    /// The constant parameter `name`.
    fn constant_from_params(reader: &ParamReader, name: &str, default: f32) -> Self;

    /// The parameter `name`, constant or texture.
    fn input_from_params(reader: &ParamReader, name: &str, default: f32) -> Self::Input;

    /// The texture an input refers to; `None` for a constant.
    fn texture(input: Self::Input) -> Option<TextureRead>;

    /// The input's value at a point.
    fn lookup(input: Self::Input, textures: &Textures, at: &TexturePoint) -> Self;

    /// The filtered image of this kind at `index`.
    fn mipmap(textures: &Textures, index: usize) -> &Mipmap<Self>;
}

/// The textures among these inputs.
pub(super) fn textures_of<V: TextureValue>(inputs: [V::Input; 2]) -> TexturesRead {
    inputs.into_iter().filter_map(V::texture).collect()
}

impl TextureValue for f32 {
    type Input = FloatInput;

    const HAS_COLORS: bool = false;

    fn splat(v: f32) -> f32 {
        v
    }

    fn from_texel(texel: Rgb) -> f32 {
        luminance(texel)
    }

    fn from_ptex(color: Rgb) -> f32 {
        (color.x + color.y + color.z) / 3.0
    }

    fn map(self, f: impl Fn(f32) -> f32) -> f32 {
        f(self)
    }

    fn constant_from_params(reader: &ParamReader, name: &str, default: f32) -> f32 {
        reader.float(name, default as f64) as f32
    }

    fn input_from_params(reader: &ParamReader, name: &str, default: f32) -> FloatInput {
        reader.float_input(name, default)
    }

    fn texture(input: FloatInput) -> Option<TextureRead> {
        input.texture()
    }

    fn lookup(input: FloatInput, textures: &Textures, at: &TexturePoint) -> f32 {
        textures.float(&input, at)
    }

    fn mipmap(textures: &Textures, index: usize) -> &Mipmap<f32> {
        &textures.float_maps[index]
    }
}

impl TextureValue for Rgb {
    type Input = SpectrumInput;

    const HAS_COLORS: bool = true;

    fn splat(v: f32) -> Rgb {
        Rgb::splat(v)
    }

    fn from_texel(texel: Rgb) -> Rgb {
        texel
    }

    fn from_ptex(color: Rgb) -> Rgb {
        color
    }

    fn map(self, f: impl Fn(f32) -> f32) -> Rgb {
        Rgb::new(f(self.x), f(self.y), f(self.z))
    }

    fn constant_from_params(reader: &ParamReader, name: &str, default: f32) -> Rgb {
        reader.spectrum(name, Rgb::splat(default))
    }

    fn input_from_params(reader: &ParamReader, name: &str, default: f32) -> SpectrumInput {
        reader.spectrum_input(name, Rgb::splat(default))
    }

    fn texture(input: SpectrumInput) -> Option<TextureRead> {
        input.texture()
    }

    fn lookup(input: SpectrumInput, textures: &Textures, at: &TexturePoint) -> Rgb {
        textures.spectrum(&input, at)
    }

    fn mipmap(textures: &Textures, index: usize) -> &Mipmap<Rgb> {
        &textures.spectrum_maps[index]
    }
}

impl Textures {
    /// The value of `input` at a point. A texture that does not exist counts as 0.
    pub fn float(&self, input: &FloatInput, at: &TexturePoint) -> f32 {
        match *input {
            FloatInput::Constant(v) => v,
            FloatInput::Texture(id) => value_of(self.float.get(id.index()), self, at),
        }
    }

    /// The value of `input` at a point. A texture that does not exist counts as black.
    pub fn spectrum(&self, input: &SpectrumInput, at: &TexturePoint) -> Rgb {
        match *input {
            SpectrumInput::Constant(v) => v,
            SpectrumInput::Texture(id) => value_of(self.spectrum.get(id.index()), self, at),
        }
    }
}

fn value_of<V: TextureValue>(
    texture: Option<&Texture<V>>,
    textures: &Textures,
    at: &TexturePoint,
) -> V {
    texture.map_or(V::default(), |t| t.evaluate(textures, at))
}
