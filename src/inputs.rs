//! Inputs of materials, textures and shapes: constants, or textures that are looked up at every hit.

use crate::handles::{FloatTextureId, SpectrumTextureId};
use crate::math::Rgb;

/// A float that may vary over a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FloatInput {
    /// The same everywhere.
    Constant(f32),
    /// Looked up in a texture.
    Texture(FloatTextureId),
}

/// A color or per-channel factor that may vary over a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpectrumInput {
    /// The same everywhere.
    Constant(Rgb),
    /// Looked up in a texture.
    Texture(SpectrumTextureId),
}

impl FloatInput {
    /// The texture it is looked up in; `None` for a constant.
    pub fn texture(self) -> Option<TextureRead> {
        match self {
            FloatInput::Constant(_) => None,
            FloatInput::Texture(id) => Some(TextureRead::Float(id)),
        }
    }
}

impl SpectrumInput {
    /// The texture it is looked up in; `None` for a constant.
    pub fn texture(self) -> Option<TextureRead> {
        match self {
            SpectrumInput::Constant(_) => None,
            SpectrumInput::Texture(id) => Some(TextureRead::Spectrum(id)),
        }
    }
}

/// A texture that an input is looked up in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureRead {
    /// One of the float textures.
    Float(FloatTextureId),
    /// One of the spectrum textures.
    Spectrum(SpectrumTextureId),
}

/// The textures of all inputs of one thing, in the order in which they were read.
pub type TexturesRead = Vec<TextureRead>;
