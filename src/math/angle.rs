//! Angles of points in a plane.

use std::f32::consts::PI;

/// The azimuth from +x toward +y as a fraction of a full turn, in [0, 1]; absolute error below 2e-7. The arc tangent on [0, 1] is the polynomial of
/// Abramowitz and Stegun 1964, 4.4.49: faster than a call of `atan2`.
#[inline]
pub(crate) fn turns(x: f32, y: f32) -> f32 {
    let (low, high) = (x.abs().min(y.abs()), x.abs().max(y.abs()));
    let t = if high > 0.0 { low / high } else { 0.0 };
    let t2 = t * t;
    let factors = [
        0.002_866_225_7,
        -0.016_165_737,
        0.042_909_614,
        -0.075_289_64,
        0.106_562_64,
        -0.142_089,
        0.199_935_51,
        -0.333_331_45,
        1.0,
    ];
    let angle = t * factors.iter().fold(0.0, |sum, factor| sum * t2 + factor);
    let octant = angle * (0.5 / PI);
    let quadrant = if y.abs() > x.abs() {
        0.25 - octant
    } else {
        octant
    };
    let half = if x < 0.0 { 0.5 - quadrant } else { quadrant };
    if y < 0.0 { 1.0 - half } else { half }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{mix2, unit_float};

    #[test]
    fn turns_are_those_of_the_arc_tangent() {
        let coordinate = |i: u64, k: u64| 2.0 * unit_float(mix2(i, k)) - 1.0;
        let edges = [-1.0, -0.0, 0.0, 1.0, 1e-30, -1e-30];
        let edges = edges.map(|x| edges.map(|y| (x, y)));
        let random = (0..100_000).map(|i| (coordinate(i, 0), coordinate(i, 1)));
        for (x, y) in edges.into_iter().flatten().chain(random) {
            let expected = f64::from(y).atan2(x.into()) / std::f64::consts::TAU;
            let error = f64::from(turns(x, y)) - expected;
            // A turn more or less is the same azimuth.
            let error = (error - error.round()).abs();
            assert!((x, y) == (0.0, 0.0) || error < 2e-7, "{x} {y} {error}");
        }
    }
}
