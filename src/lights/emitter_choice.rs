//! Choosing the light from which a path begins.

use super::Light;
use super::selection::power_distribution;
use crate::handles::LightId;
use crate::math::distribution::Distribution1D;

/// Chooses lights by their power. As where a light is chosen for a point, a part of the probability is spread evenly: a weak
/// light may be all that a part of the scene sees.
#[derive(Clone, Debug)]
pub struct EmitterChoice {
    /// Empty where there are no lights.
    probabilities: Distribution1D,
}

impl EmitterChoice {
    /// For `lights` in a scene whose bounding sphere has the radius `scene_radius`. They are numbered as in the slice.
    pub fn new(lights: &[Light], scene_radius: f32) -> EmitterChoice {
        EmitterChoice {
            probabilities: power_distribution(lights, scene_radius),
        }
    }

    /// The number of lights.
    pub fn cells(&self) -> usize {
        self.probabilities.cells()
    }

    /// The choice that takes a part `share` of its probability from `masses`, one for each light, which are not negative.
    pub fn mixed(&self, masses: &[f64], share: f32) -> EmitterChoice {
        let total: f64 = masses.iter().sum();
        let part = |mass: f64| {
            if total > 0.0 {
                (mass / total) as f32
            } else {
                0.0
            }
        };
        let own = if total > 0.0 { 1.0 - share } else { 1.0 };
        let lights = masses.iter().enumerate();
        EmitterChoice {
            probabilities: Distribution1D::new(
                lights.map(|(i, &mass)| own * self.pmf(LightId(i as u32)) + share * part(mass)),
            ),
        }
    }

    /// A light, its probability, and `u` stretched over what chose it: a number in [0, 1) for further use, with as few bits
    /// left as the light is improbable. `None` where there are no lights.
    pub fn sample(&self, u: f32) -> Option<(LightId, f32, f32)> {
        if self.probabilities.cells() == 0 {
            return None;
        }
        let (light, probability, rest) = self.probabilities.sample_discrete(u);
        Some((LightId(light as u32), probability, rest))
    }

    /// Returns `true` if there are several lights, so that [`EmitterChoice::sample`] needs its sample.
    pub fn chooses(&self) -> bool {
        self.probabilities.cells() > 1
    }

    /// Probability with which [`EmitterChoice::sample`] chooses `light`; 0 for one that it was not given.
    pub fn pmf(&self, light: LightId) -> f32 {
        if light.index() < self.probabilities.cells() {
            self.probabilities.probability(light.index())
        } else {
            0.0
        }
    }
}
