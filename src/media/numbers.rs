//! Random numbers for walks of unknown length.

use crate::math::hash::{mix, unit_float};
use crate::samplers::SampleStream;

/// Independent numbers in [0, 1), as many as a walk through a medium takes: its steps have nothing
/// that well-spread points could improve, and those cost several times as much. SplitMix64
/// (Steele, Lea and Flood 2014).
#[derive(Clone, Debug)]
pub struct Numbers {
    state: u64,
}

impl Numbers {
    /// Begins where two numbers of the sample's stream say.
    pub fn new(stream: &mut SampleStream) -> Numbers {
        let u = stream.next_2d();
        // Every bit of both.
        let state = u64::from(u.x.to_bits()) | u64::from(u.y.to_bits()) << 32;
        Numbers { state: mix(state) }
    }

    /// The next one.
    pub fn next(&mut self) -> f32 {
        // 2⁶⁴ over the golden ratio.
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        unit_float(mix(self.state))
    }

    /// A step with mean 1 and exponential density.
    pub fn step(&mut self) -> f32 {
        -(1.0 - self.next()).ln()
    }
}
