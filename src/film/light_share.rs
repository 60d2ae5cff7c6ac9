//! How many light paths there are.

use serde::{Deserialize, Serialize};

/// Light paths for each camera sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightShare(pub f32);

impl LightShare {
    /// How many belong to so many camera samples.
    pub fn paths(self, samples: u64) -> u64 {
        (samples as f64 * f64::from(self.0)).ceil() as u64
    }
}

/// How many paths are traced from the lights, and how many camera paths are joined to one. Two images for which that differs have other noise, and what one of them
/// knows well the other may have missed in all its samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightPathUse {
    /// Light paths for each camera sample that are joined to the lens, as planned; 0 if none are.
    pub per_sample: f32,
    /// The share of camera paths that are joined to a light path.
    pub joined: f32,
}
