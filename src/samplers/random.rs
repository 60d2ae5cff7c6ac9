//! `random`: independent uniform samples.
//!
//! `pixelsamples` (integer, 4).

use super::SamplerSpec;
use super::count::positive;
use crate::math::Vec2;
use crate::math::hash::{mix, mix2, unit_float};
use crate::params::ParamReader;

/// Reads the parameters.
pub(super) fn from_params(reader: &ParamReader) -> SamplerSpec {
    SamplerSpec::random(positive(reader, "pixelsamples", 4))
}

/// The dimensions of one camera sample: SplitMix64 (Steele, Lea and Flood 2014) from a hashed start.
#[derive(Clone, Copy, Debug)]
pub struct RandomStream {
    state: u64,
}

impl RandomStream {
    /// Sample `index` of the pixel hashed into `seed`.
    pub(super) fn new(seed: u64, index: u32) -> RandomStream {
        RandomStream {
            state: mix2(seed, u64::from(index)),
        }
    }

    /// See [`super::SampleStream::fork`].
    pub(super) fn fork(&mut self) -> RandomStream {
        RandomStream {
            state: self.next_bits(),
        }
    }

    fn next_bits(&mut self) -> u64 {
        // 2⁶⁴ over the golden ratio: steps that never line up.
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.state)
    }

    pub(super) fn next_1d(&mut self) -> f32 {
        unit_float(self.next_bits())
    }

    pub(super) fn next_2d(&mut self) -> Vec2 {
        let bits = self.next_bits();
        Vec2::new(unit_float(bits), unit_float(bits << 24))
    }
}
