//! Random samples for tracking in media, where the number of steps is unknown.

use crate::math::hash::{mix, unit_float};
use crate::samplers::SampleStream;

/// Independent uniform samples in [0, 1), as many as tracking through a medium needs: its steps do not benefit from
/// well-distributed points, which cost several times as much. SplitMix64 (Steele, Lea and Flood 2014).
#[derive(Clone, Debug)]
pub(super) struct Numbers {
    state: u64,
}

impl Numbers {
    /// A sequence seeded by two dimensions of the sample's stream.
    pub(super) fn new(stream: &mut SampleStream) -> Numbers {
        let u = stream.next_2d();
        // All bits of both.
        let state = u64::from(u.x.to_bits()) | u64::from(u.y.to_bits()) << 32;
        Numbers { state: mix(state) }
    }

    /// The next sample.
    pub(super) fn next(&mut self) -> f32 {
        // 2⁶⁴ over the golden ratio.
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        unit_float(mix(self.state))
    }

    /// A step length with mean 1 and exponential density.
    pub(super) fn step(&mut self) -> f32 {
        -(1.0 - self.next()).ln()
    }
}
