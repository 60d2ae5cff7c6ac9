//! Which textures matter.

use super::{TextureSpec, TextureSpecs, TextureValue};
use crate::inputs::{FloatInput, SpectrumInput, TextureRead};
use crate::math::Rgb;

/// Which textures of a scene are looked up by anything: a broken image in a texture that nothing
/// uses does not spoil the rendering.
///
/// Filled by those who use textures ([`float`](Self::float), [`spectrum`](Self::spectrum)), then
/// completed by what these use in turn ([`complete`](Self::complete)).
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

    /// Somebody looks this up.
    pub fn float(&mut self, input: FloatInput) {
        mark::<f32>(&mut self.float, input);
    }

    /// Somebody looks this up.
    pub fn spectrum(&mut self, input: SpectrumInput) {
        mark::<Rgb>(&mut self.spectrum, input);
    }

    /// These are looked up.
    pub fn add(&mut self, textures: &[TextureRead]) {
        for &texture in textures {
            match texture {
                TextureRead::Float(id) => self.float(FloatInput::Texture(id)),
                TextureRead::Spectrum(id) => self.spectrum(SpectrumInput::Texture(id)),
            }
        }
    }

    /// Adds the textures that used textures use. They all come before their users (others are
    /// refused), and a float texture uses no spectrum texture, so one pass from the last to the
    /// first finds them all.
    pub fn complete(&mut self, textures: &TextureSpecs) {
        for (index, texture) in textures.spectrum.iter().enumerate().rev() {
            self.operands(&texture.spec, self.spectrum[index], Self::spectrum);
        }
        for (index, texture) in textures.float.iter().enumerate().rev() {
            self.operands(&texture.spec, self.float[index], Self::float);
        }
    }

    fn operands<V: TextureValue>(
        &mut self,
        spec: &TextureSpec<V>,
        used: bool,
        add: fn(&mut TextureUsage, V::Input),
    ) {
        if !used {
            return;
        }
        let operands = spec.operands();
        for input in operands.own {
            add(self, input);
        }
        if let Some(amount) = operands.amount {
            self.float(amount);
        }
    }
}

fn mark<V: TextureValue>(used: &mut [bool], input: V::Input) {
    if let Some(used) = V::texture_index(input).and_then(|index| used.get_mut(index)) {
        *used = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::handles::{FloatTextureId, SpectrumTextureId};
    use crate::textures::{Constant, Mix, Scale};

    #[test]
    fn what_a_used_texture_uses_is_used() {
        let float = |i| FloatInput::Texture(FloatTextureId(i));
        let spectrum = |i| SpectrumInput::Texture(SpectrumTextureId(i));
        let plain = || TextureSpec::Constant(Constant { value: 1.0 });
        let scale = |i| {
            TextureSpec::Scale(Scale {
                tex1: float(i),
                tex2: FloatInput::Constant(2.0),
            })
        };
        let floats = [plain(), plain(), scale(0), scale(2), scale(1)];
        let white = || TextureSpec::Constant(Constant { value: Rgb::ONE });
        let mix = TextureSpec::Mix(Mix {
            tex1: spectrum(1),
            tex2: SpectrumInput::Constant(Rgb::ONE),
            amount: float(3),
        });
        let specs = TextureSpecs::of(&floats, &[white(), white(), mix]);
        let mut usage = TextureUsage::new(&specs);
        usage.complete(&specs);
        assert_eq!(usage, TextureUsage::new(&specs), "nothing uses anything");
        usage.spectrum(spectrum(2));
        // What does not exist is not used.
        usage.float(float(77));
        usage.complete(&specs);
        assert_eq!(usage.float, [true, false, true, true, false]);
        assert_eq!(usage.spectrum, [false, true, true]);
    }
}
