//! What sampling a lobe gives.

use crate::math::{Rgb, Vec3};

/// A direction sampled from a lobe.
#[derive(Clone, Copy, Debug)]
pub struct LobeSample {
    /// Value for the pair of directions; for a specular lobe, the factor of the delta distribution over the cosine.
    pub f: Rgb,
    /// Sampled direction, local.
    pub wi: Vec3,
    /// Density per solid angle; for a specular lobe, the probability.
    pub pdf: f32,
    /// `true` if the light is transmitted.
    pub transmission: bool,
    /// Refractive index on `wi`'s side over that on `wo`'s.
    pub eta: f32,
}

impl LobeSample {
    /// A reflected direction.
    pub(super) fn reflected(wi: Vec3, f: Rgb, pdf: f32) -> LobeSample {
        LobeSample {
            f,
            wi,
            pdf,
            transmission: false,
            eta: 1.0,
        }
    }

    /// A reflected direction, with its value where it could be sampled at all.
    pub(super) fn evaluated(wi: Vec3, pdf: f32, f: impl FnOnce() -> Rgb) -> Option<LobeSample> {
        (pdf > 0.0).then(|| LobeSample::reflected(wi, f(), pdf))
    }

    /// The same as a transmitted direction, `eta` the index on its side over that on the other.
    pub(super) fn transmitted(self, eta: f32) -> LobeSample {
        LobeSample {
            transmission: true,
            eta,
            ..self
        }
    }
}
