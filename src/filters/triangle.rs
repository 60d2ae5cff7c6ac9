//! The triangle (tent) filter: falls linearly to zero at its edge.
//!
//! `xwidth`, `ywidth`: half widths in pixels, default 2.
//! Source: Pharr, Jakob and Humphreys 2016, §7.8.1.

use super::radius::radius_from_params;
use crate::math::DVec2;
use crate::params::ParamReader;

/// max(0, r − |x|) along each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleFilter {
    /// Half widths in pixels.
    pub radius: DVec2,
}

impl Default for TriangleFilter {
    fn default() -> TriangleFilter {
        TriangleFilter {
            radius: DVec2::splat(2.0),
        }
    }
}

impl TriangleFilter {
    /// Reads `xwidth` and `ywidth`.
    pub fn from_params(reader: &ParamReader) -> TriangleFilter {
        TriangleFilter {
            radius: radius_from_params(reader, 2.0),
        }
    }

    /// The factor along one axis, `distance` ≥ 0 pixels from the center.
    pub fn factor(&self, distance: f64, radius: f64) -> f64 {
        (radius - distance).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn falls_linearly_to_zero() {
        let f = TriangleFilter::default();
        assert_eq!(
            [0.0, 0.5, 2.0, 3.0].map(|x| f.factor(x, 2.0)),
            [2.0, 1.5, 0.0, 0.0]
        );
    }
}
