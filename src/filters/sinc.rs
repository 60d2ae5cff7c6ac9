//! The sinc filter, windowed by the central lobe of a wider sinc (Lanczos).
//!
//! `xwidth`, `ywidth`: half widths in pixels, default 4. `tau`: default 3.
//! In pbrt-v3 the sinc has its zeros at whole pixels, `tau` is the window's scale, and the widths
//! only cut it off: sinc(x) · sinc(x/τ). In pbrt-v2 distances were divided by the half width r and
//! `tau` counted the zeros up to there: sinc(τx/r) · sinc(x/r).
//! Source: Pharr, Jakob and Humphreys 2016, §7.8.1; 2010, §7.6.1.

use super::radius::radius_from_params;
use crate::math::DVec2;
use crate::params::ParamReader;
use std::f64::consts::PI;

/// A product of two sincs along each axis, cut off at `radius`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SincFilter {
    /// Half widths in pixels, where the filter is cut off.
    pub radius: DVec2,
    /// Width of the window's central lobe relative to that of the sinc.
    pub tau: f64,
    /// As in pbrt-v2: `tau` counts zeros and the window is as wide as the filter.
    pub counts_zeros: bool,
}

impl Default for SincFilter {
    fn default() -> SincFilter {
        SincFilter {
            radius: DVec2::splat(4.0),
            tau: 3.0,
            counts_zeros: false,
        }
    }
}

impl SincFilter {
    /// Reads `xwidth`, `ywidth` and `tau`.
    pub fn from_params(reader: &ParamReader) -> SincFilter {
        SincFilter {
            radius: radius_from_params(reader, 4.0),
            tau: reader.float("tau", 3.0),
            counts_zeros: reader.means_v2("tau"),
        }
    }

    /// The factor along one axis, `distance` ≥ 0 pixels from the center.
    pub fn factor(&self, distance: f64, radius: f64) -> f64 {
        if distance > radius {
            return 0.0;
        }
        let (filter, window) = if self.counts_zeros {
            (distance / radius * self.tau, distance / radius)
        } else {
            (distance, distance / self.tau)
        };
        sinc(filter) * sinc(window)
    }
}

/// sin(πx)/(πx).
fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-5 {
        1.0
    } else {
        (PI * x).sin() / (PI * x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_lie_at_whole_pixels() {
        let f = SincFilter::default();
        assert_eq!(f.factor(0.0, 4.0), 1.0);
        for x in [1.0, 2.0, 3.0, 4.0] {
            assert!(f.factor(x, 4.0).abs() < 1e-16);
        }
        assert!(f.factor(1.5, 4.0) < 0.0);
        assert_eq!(f.factor(4.1, 4.0), 0.0);
    }

    #[test]
    fn version_2_counts_zeros_up_to_the_edge() {
        let f = SincFilter {
            counts_zeros: true,
            ..SincFilter::default()
        };
        for k in 1..=3 {
            assert!(f.factor(4.0 / 3.0 * f64::from(k), 4.0).abs() < 1e-15);
        }
    }
}
