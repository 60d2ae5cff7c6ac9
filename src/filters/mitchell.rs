//! Mitchell and Netravali's cubic filter, a compromise between blur and ringing.
//!
//! `xwidth`, `ywidth`: half widths in pixels, default 2; the cubic's support of ±2 is stretched to
//! them. `B`, `C`: its two parameters, default 1/3 each.
//! Source: Mitchell and Netravali, "Reconstruction Filters in Computer Graphics", 1988, equation 8.

use super::radius::radius_from_params;
use crate::math::DVec2;
use crate::params::ParamReader;

/// The cubic of parameters `b` and `c`; negative in its outer half for c > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MitchellFilter {
    /// Half widths in pixels.
    pub radius: DVec2,
    /// Blur.
    pub b: f64,
    /// Ringing.
    pub c: f64,
}

impl Default for MitchellFilter {
    fn default() -> MitchellFilter {
        MitchellFilter {
            radius: DVec2::splat(2.0),
            b: 1.0 / 3.0,
            c: 1.0 / 3.0,
        }
    }
}

impl MitchellFilter {
    /// Reads `xwidth`, `ywidth`, `B` and `C`.
    pub fn from_params(reader: &ParamReader) -> MitchellFilter {
        MitchellFilter {
            radius: radius_from_params(reader, 2.0),
            b: reader.float("B", 1.0 / 3.0),
            c: reader.float("C", 1.0 / 3.0),
        }
    }

    /// The factor along one axis, `distance` ≥ 0 pixels from the center.
    pub fn factor(&self, distance: f64, radius: f64) -> f64 {
        let (b, c) = (self.b, self.c);
        let x = 2.0 * distance / radius;
        let cubic = if x < 1.0 {
            (12.0 - 9.0 * b - 6.0 * c) * x.powi(3)
                + (-18.0 + 12.0 * b + 6.0 * c) * x * x
                + (6.0 - 2.0 * b)
        } else if x < 2.0 {
            (-b - 6.0 * c) * x.powi(3)
                + (6.0 * b + 30.0 * c) * x * x
                + (-12.0 * b - 48.0 * c) * x
                + (8.0 * b + 24.0 * c)
        } else {
            0.0
        };
        cubic / 6.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighboring_cubics_sum_to_one() {
        // The defining property of the whole family: shifted by whole pixels they add up to 1.
        for (b, c) in [(1.0 / 3.0, 1.0 / 3.0), (0.0, 0.5), (1.0, 0.0)] {
            let f = MitchellFilter {
                radius: DVec2::splat(2.0),
                b,
                c,
            };
            for i in 0..100 {
                let x = i as f64 / 100.0;
                let sum: f64 = (-2..=2)
                    .map(|k| f.factor((x + f64::from(k)).abs(), 2.0))
                    .sum();
                // A dozen rounded operations on terms up to 20.
                assert!((sum - 1.0).abs() < 1e-13);
            }
        }
    }
}
