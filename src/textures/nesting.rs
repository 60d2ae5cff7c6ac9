//! The textures of a scene in the order of their definition: each uses only those before it, and not too many.

use super::{Constant, FloatTextureSpec, SpectrumTextureSpec, Texture, TextureValue};
use crate::handles::{FloatTextureId, SpectrumTextureId};
use crate::inputs::TextureRead;
use crate::math::Rgb;

/// Deepest nesting of textures in textures. Scenes in the wild stay below 10; the stack of a
/// worker thread has room for far more than this.
const MAX_DEPTH: usize = 256;

/// The most textures that may be evaluated for one value: about a millisecond of work. No image
/// would ever be finished with many more, in pbrt-v3 neither.
const MAX_LOOKUPS: u64 = 1 << 16;

/// Why a texture cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NestingProblem {
    /// Too many textures stand one inside the other.
    #[error("nests textures more than {MAX_DEPTH} deep")]
    TooDeep,
    /// Too many textures are evaluated for one value.
    #[error("looks up more than {MAX_LOOKUPS} textures for each value")]
    TooMany,
    /// A texture that it uses does not come before it.
    #[error("uses a texture that is not defined before it")]
    NotYetDefined,
}

/// The textures of a scene as it describes them.
#[derive(Clone, Debug, Default)]
pub struct TextureSpecs {
    /// By `FloatTextureId`.
    pub(super) float: Vec<NestedTexture<f32>>,
    /// By `SpectrumTextureId`.
    pub(super) spectrum: Vec<NestedTexture<Rgb>>,
}

/// A texture with how much it uses others, those that they use in turn included.
#[derive(Clone, Debug)]
pub(super) struct NestedTexture<V: TextureValue> {
    pub(super) spec: Texture<V>,
    cost: Cost,
}

/// What looking a texture up takes at most.
#[derive(Clone, Copy, Debug)]
struct Cost {
    /// How many textures stand one inside the other, 1 for a texture that uses none.
    depth: usize,
    /// How many textures are evaluated for one value. A texture named twice counts twice, so
    /// that thirty textures of two operands each can come to a thousand million.
    lookups: u64,
}

impl Cost {
    /// Of a texture that uses none.
    const ALONE: Cost = Cost {
        depth: 1,
        lookups: 1,
    };
}

impl TextureSpecs {
    /// Adds a float texture. One that cannot be used is replaced by a constant 0.5.
    pub fn add_float(
        &mut self,
        spec: FloatTextureSpec,
    ) -> (FloatTextureId, Option<NestingProblem>) {
        let (texture, problem) = self.nested(spec);
        self.float.push(texture);
        (FloatTextureId(self.float.len() as u32 - 1), problem)
    }

    /// Adds a spectrum texture. One that cannot be used is replaced by a constant 0.5.
    pub fn add_spectrum(
        &mut self,
        spec: SpectrumTextureSpec,
    ) -> (SpectrumTextureId, Option<NestingProblem>) {
        let (texture, problem) = self.nested(spec);
        self.spectrum.push(texture);
        (SpectrumTextureId(self.spectrum.len() as u32 - 1), problem)
    }

    /// The texture after those there are; another in its place, and why, where it cannot be used.
    fn nested<V: TextureValue>(
        &self,
        spec: Texture<V>,
    ) -> (NestedTexture<V>, Option<NestingProblem>) {
        match self.cost(&spec.inputs()) {
            Ok(cost) => (NestedTexture { spec, cost }, None),
            Err(problem) => {
                let value = V::splat(0.5);
                let constant = NestedTexture {
                    spec: Texture::Constant(Constant { value }),
                    cost: Cost::ALONE,
                };
                (constant, Some(problem))
            }
        }
    }

    /// What a texture costs that uses these.
    fn cost(&self, inputs: &[TextureRead]) -> Result<Cost, NestingProblem> {
        let mut cost = Cost::ALONE;
        for input in inputs {
            let used = match input {
                TextureRead::Float(id) => self.float.get(id.index()).map(|t| t.cost),
                TextureRead::Spectrum(id) => self.spectrum.get(id.index()).map(|t| t.cost),
            };
            let used = used.ok_or(NestingProblem::NotYetDefined)?;
            cost.depth = cost.depth.max(1 + used.depth);
            cost.lookups = cost.lookups.saturating_add(used.lookups);
        }
        match cost {
            Cost { depth, .. } if depth > MAX_DEPTH => Err(NestingProblem::TooDeep),
            Cost { lookups, .. } if lookups > MAX_LOOKUPS => Err(NestingProblem::TooMany),
            _ => Ok(cost),
        }
    }

    /// These textures, all of which can be used.
    #[cfg(test)]
    pub(crate) fn of(float: &[FloatTextureSpec], spectrum: &[SpectrumTextureSpec]) -> TextureSpecs {
        let mut specs = TextureSpecs::default();
        for spec in float {
            assert_eq!(specs.add_float(spec.clone()).1, None);
        }
        for spec in spectrum {
            assert_eq!(specs.add_spectrum(spec.clone()).1, None);
        }
        specs
    }
}
