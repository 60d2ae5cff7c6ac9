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
