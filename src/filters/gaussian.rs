//! The Gaussian filter, lowered so that it reaches zero at its edge.
//!
//! `xwidth`, `ywidth`: half widths in pixels, default 2. `alpha`: how fast it falls, per square
//! pixel, default 2. Source: Pharr, Jakob and Humphreys 2016, §7.8.1.

use super::radius::radius_from_params;
use crate::math::DVec2;
use crate::params::ParamReader;

/// max(0, exp(−αx²) − exp(−αr²)) along each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianFilter {
    /// Half widths in pixels.
    pub radius: DVec2,
    /// Falloff per square pixel.
    pub alpha: f64,
}

impl Default for GaussianFilter {
    fn default() -> GaussianFilter {
        GaussianFilter {
            radius: DVec2::splat(2.0),
            alpha: 2.0,
        }
    }
}

impl GaussianFilter {
    /// Reads `xwidth`, `ywidth` and `alpha`.
    pub fn from_params(reader: &ParamReader) -> GaussianFilter {
        GaussianFilter {
            radius: radius_from_params(reader, 2.0),
            alpha: reader.float("alpha", 2.0),
        }
    }

    /// The factor along one axis, `distance` ≥ 0 pixels from the center.
    pub fn factor(&self, distance: f64, radius: f64) -> f64 {
        let bell = |x: f64| (-self.alpha * x * x).exp();
        (bell(distance) - bell(radius)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reaches_zero_at_its_edge() {
        let f = GaussianFilter::default();
        assert_eq!(f.factor(2.0, 2.0), 0.0);
        assert_eq!(f.factor(2.5, 2.0), 0.0);
        assert_eq!(f.factor(0.0, 2.0), 1.0 - (-8.0f64).exp());
    }
}
