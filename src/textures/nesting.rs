//! The textures of a scene in the order of their definition: each uses only those before it, and not too many.

use super::{Constant, FloatTextureSpec, SpectrumTextureSpec, TextureSpec, TextureValue};
use crate::handles::{FloatTextureId, SpectrumTextureId};
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
    pub(super) spec: TextureSpec<V>,
    /// How many textures stand one inside the other at most, 1 for a texture that uses none.
    depth: usize,
    /// How many textures are evaluated for one value at most. A texture named twice counts twice, so
    /// that thirty textures of two operands each can come to a thousand million.
    lookups: u64,
}

impl TextureSpecs {
    /// Adds a float texture. One that cannot be used is replaced by a constant 0.5.
    pub fn add_float(
        &mut self,
        spec: FloatTextureSpec,
    ) -> (FloatTextureId, Option<NestingProblem>) {
        let (texture, problem) = NestedTexture::new(spec, &self.float, &self.float);
        self.float.push(texture);
        (FloatTextureId(self.float.len() as u32 - 1), problem)
    }

    /// Adds a spectrum texture. One that cannot be used is replaced by a constant 0.5.
    pub fn add_spectrum(
        &mut self,
        spec: SpectrumTextureSpec,
    ) -> (SpectrumTextureId, Option<NestingProblem>) {
        let (texture, problem) = NestedTexture::new(spec, &self.float, &self.spectrum);
        self.spectrum.push(texture);
        (SpectrumTextureId(self.spectrum.len() as u32 - 1), problem)
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

impl<V: TextureValue> NestedTexture<V> {
    /// After `floats` and, of its own kind, `own`.
    fn new(
        spec: TextureSpec<V>,
        floats: &[NestedTexture<f32>],
        own: &[NestedTexture<V>],
    ) -> (NestedTexture<V>, Option<NestingProblem>) {
        let operands = spec.operands();
        let inputs = operands.own.into_iter().filter_map(V::texture_index);
        let inputs = inputs.map(|i| own.get(i).map(|t| (t.depth, t.lookups)));
        let amount = operands.amount.and_then(f32::texture_index);
        let amount = amount.map(|i| floats.get(i).map(|t| (t.depth, t.lookups)));
        let (mut depth, mut lookups, mut defined) = (1, 1u64, true);
        for used in inputs.chain(amount) {
            let (inner_depth, inner_lookups) = used.unwrap_or_default();
            depth = depth.max(1 + inner_depth);
            lookups = lookups.saturating_add(inner_lookups);
            defined &= used.is_some();
        }
        let problem = match () {
            _ if !defined => NestingProblem::NotYetDefined,
            _ if depth > MAX_DEPTH => NestingProblem::TooDeep,
            _ if lookups > MAX_LOOKUPS => NestingProblem::TooMany,
            _ => {
                return (
                    NestedTexture {
                        spec,
                        depth,
                        lookups,
                    },
                    None,
                );
            }
        };
        let value = V::splat(0.5);
        let constant = NestedTexture {
            spec: TextureSpec::Constant(Constant { value }),
            depth: 1,
            lookups: 1,
        };
        (constant, Some(problem))
    }
}
