//! The box filter: constant within its radius.
//!
//! `xwidth`, `ywidth`: half widths in pixels, default 0.5, which is the pixel itself.
//! Source: Pharr, Jakob and Humphreys 2016, §7.8.1.

use super::radius::radius_from_params;
use crate::math::DVec2;
use crate::params::ParamReader;

/// Constant within `radius`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxFilter {
    /// Half widths in pixels.
    pub radius: DVec2,
}

impl Default for BoxFilter {
    fn default() -> BoxFilter {
        BoxFilter {
            radius: DVec2::splat(0.5),
        }
    }
}

impl BoxFilter {
    /// Reads `xwidth` and `ywidth`.
    pub fn from_params(reader: &ParamReader) -> BoxFilter {
        BoxFilter {
            radius: radius_from_params(reader, 0.5),
        }
    }

    /// The factor along one axis, `distance` ≤ `radius` pixels from the center.
    pub fn factor(&self, _distance: f64, _radius: f64) -> f64 {
        1.0
    }
}
