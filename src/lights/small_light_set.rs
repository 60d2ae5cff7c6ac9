//! Choosing one of up to eight lights: as [`super::light_tree`] does, with the same estimates, but without a tree.

use super::lanes::{HALF, LANES, Lanes, Receiver};
use super::light_tree::{Candidate, pick, sum};
use super::selection::Selected;
use crate::handles::LightId;
use crate::math::float::is_positive;

/// Share of the probability that is spread evenly. With 0.1, as many lights have it, the squared error of benches/peer's lamps and creature is
/// 1.04 and 1.03 times as high, with 0.3 it is 0.99 and 1.00: estimates know nothing of shadows.
pub(super) const EVEN_SHARE: f32 = 0.2;

/// Up to eight lights, in lanes of the same numbers.
#[derive(Clone, Debug)]
pub(super) struct SmallLightSet {
    lanes: Lanes,
    /// What is shared out evenly among groups: sums to 1.
    even: [f32; LANES],
    len: usize,
}

impl SmallLightSet {
    /// From the candidates for all lights, of which those beyond the eighth are left out. Distances below `min_distance`
    /// do not count as nearer.
    pub(super) fn new(candidates: &[Candidate], min_distance: f32) -> SmallLightSet {
        let mut few = SmallLightSet {
            lanes: Lanes::empty(),
            even: [0.0; LANES],
            len: candidates.len().min(LANES),
        };
        for candidate in candidates {
            let lane = candidate.light.index();
            if let Some(even) = few.even.get_mut(lane) {
                *even = candidate.even;
                few.lanes.set(lane, &candidate.bounds, min_distance);
            }
        }
        few
    }

    /// How many lights there are.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// A light for the number `u`.
    pub(super) fn sample(&self, to: &Receiver, u: f32) -> Option<Selected> {
        let probabilities = self.probabilities(to);
        let (lane, rest) = pick(&probabilities, u * sum(&probabilities));
        Some(Selected {
            light: LightId(lane as u32),
            pmf: probabilities[lane],
            rest,
        })
    }

    /// Probability with which [`SmallLightSet::sample`] chooses `light`.
    pub(super) fn pmf(&self, to: &Receiver, light: LightId) -> f32 {
        let probabilities = self.probabilities(to);
        probabilities.get(light.index()).copied().unwrap_or(0.0)
    }

    fn probabilities(&self, to: &Receiver) -> [f32; LANES] {
        let estimates = if self.len <= HALF {
            let [a, b, c, d] = self.lanes.at_first(to);
            [a, b, c, d, 0.0, 0.0, 0.0, 0.0]
        } else {
            self.lanes.at(to)
        };
        let total = sum(&estimates);
        // Nothing arrives, or the point is not finite.
        if !is_positive(total) {
            return self.even;
        }
        std::array::from_fn(|i| {
            EVEN_SHARE * self.even[i] + (1.0 - EVEN_SHARE) * (estimates[i] / total)
        })
    }
}
