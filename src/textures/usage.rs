//! Which textures matter.

use super::TextureSpecs;
use crate::inputs::TextureRead;

/// Which textures of a scene are looked up by anything: a broken image in a texture that nothing
/// uses does not spoil the rendering.
///
/// Filled by those who use textures ([`add`](Self::add)), then completed by what these use in turn
/// ([`complete`](Self::complete)).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TextureUsage {
    /// By `FloatTextureId`.
    pub(super) float: Vec<bool>,
    /// By `SpectrumTextureId`.
    pub(super) spectrum: Vec<bool>,
}

impl TextureUsage {
    /// None of these textures is used yet.
    pub fn new(textures: &TextureSpecs) -> TextureUsage {
        TextureUsage {
            float: vec![false; textures.float.len()],
            spectrum: vec![false; textures.spectrum.len()],
        }
    }

    /// Somebody looks these up.
    pub fn add(&mut self, textures: impl IntoIterator<Item = TextureRead>) {
        for texture in textures {
            let used = match texture {
                TextureRead::Float(id) => self.float.get_mut(id.index()),
                TextureRead::Spectrum(id) => self.spectrum.get_mut(id.index()),
            };
            if let Some(used) = used {
                *used = true;
            }
        }
    }

    /// Adds the textures that used textures use. They all come before their users (others are
    /// refused), and a float texture uses no spectrum texture, so one pass from the last to the
    /// first finds them all.
    pub fn complete(&mut self, textures: &TextureSpecs) {
        for (index, texture) in textures.spectrum.iter().enumerate().rev() {
            if self.spectrum[index] {
                self.add(texture.spec.inputs());
            }
        }
        for (index, texture) in textures.float.iter().enumerate().rev() {
            if self.float[index] {
                self.add(texture.spec.inputs());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::handles::{FloatTextureId, SpectrumTextureId};
    use crate::inputs::{FloatInput, SpectrumInput};
    use crate::math::Rgb;
    use crate::textures::Texture;
    use crate::textures::combinations::{Constant, Mix, Scale};

    #[test]
    fn what_a_used_texture_uses_is_used() {
        let float = |i| FloatInput::Texture(FloatTextureId(i));
        let spectrum = |i| SpectrumInput::Texture(SpectrumTextureId(i));
        let plain = || Texture::Constant(Constant { value: 1.0 });
        let scale = |i| {
            Texture::Scale(Scale {
                tex1: float(i),
                tex2: FloatInput::Constant(2.0),
            })
        };
        let floats = [plain(), plain(), scale(0), scale(2), scale(1)];
        let white = || Texture::Constant(Constant { value: Rgb::ONE });
        let mix = Texture::Mix(Mix {
            tex1: spectrum(1),
            tex2: SpectrumInput::Constant(Rgb::ONE),
            amount: float(3),
        });
        let specs = TextureSpecs::of(&floats, &[white(), white(), mix]);
        let mut usage = TextureUsage::new(&specs);
        usage.complete(&specs);
        assert_eq!(usage, TextureUsage::new(&specs), "nothing uses anything");
        usage.add(spectrum(2).texture());
        // What does not exist is not used.
        usage.add(float(77).texture());
        usage.complete(&specs);
        assert_eq!(usage.float, [true, false, true, true, false]);
        assert_eq!(usage.spectrum, [false, true, true]);
    }
}
