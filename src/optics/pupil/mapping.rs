//! From the unit square to a region: three ways, each even over the region's area.

use crate::math::Vec2;
use crate::math::hash::{mix2, unit_float};

/// How lens samples are spread over the exit pupil (`"string pupilsampling"`). All three give the
/// same picture but for its noise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PupilSampling {
    /// Squares around the middle of the unit square become outlines of the region (Shirley and Chiu,
    /// "A Low Distortion Map between Disk and Square", J. Graphics Tools 2(3), 1997). Continuous and
    /// of little distortion: keeps well-spread samples well spread.
    #[default]
    Concentric,
    /// The first number is the square of the distance from the middle, relative to the outline, and
    /// the second the direction: the square-root polar mapping of the course's lecture. Continuous, but
    /// stretches the middle.
    Polar,
    /// The unit square becomes the region's bounding box; points outside the region are drawn
    /// again, by numbers hashed from the first. Not continuous: kept to compare with.
    Rejection,
}

/// A point of a star-shaped region: how far out and which way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Polar {
    /// Distance from the middle, relative to the outline's in that direction.
    pub radius: f64,
    /// The part of the region's area between +x and the direction, counterclockwise; 0 to 1.
    pub turn: f64,
}

impl Polar {
    /// The concentric mapping. `turn` needs no trigonometry: along the side of a square it is linear.
    /// Written as choices between values, not between paths: which triangle of the square a
    /// sample falls into cannot be predicted.
    #[inline]
    pub fn concentric(u: Vec2) -> Polar {
        let [x, y] = u.as_dvec2().to_array().map(|x| 2.0 * x - 1.0);
        let flat = x.abs() > y.abs();
        let (long, short) = if flat { (x, y) } else { (y, x) };
        // In the middle of the square both are 0.
        let slope = short / if long == 0.0 { 1.0 } else { long };
        let eighths = if flat { slope } else { 2.0 - slope };
        // A negative distance along an axis points the other way.
        let eighths = eighths + if long < 0.0 { 4.0 } else { 0.0 };
        let eighths = eighths + if eighths < 0.0 { 8.0 } else { 0.0 };
        Polar {
            radius: long.abs(),
            turn: 0.125 * eighths,
        }
    }

    /// The square-root polar mapping.
    pub fn square_root(u: Vec2) -> Polar {
        Polar {
            radius: f64::from(u.x).sqrt(),
            turn: f64::from(u.y),
        }
    }
}

/// Candidates after which rejection gives up and the last one is mapped instead: no convex region
/// fills less than half its box, so this happens less than once in 2^32 samples of one.
const ATTEMPTS: u32 = 32;

/// The first of `u` and numbers hashed from it that `lands`; where none does, the last.
pub(super) fn redrawn<P>(u: Vec2, lands: impl Fn(Vec2) -> Option<P>) -> Result<P, Vec2> {
    let mut u = u;
    for attempt in 0..ATTEMPTS {
        if let Some(p) = lands(u) {
            return Ok(p);
        }
        u = next(u, attempt);
    }
    Err(u)
}

/// Two numbers from [0, 1)² that have nothing to do with `u` that one could see.
fn next(u: Vec2, attempt: u32) -> Vec2 {
    let bits = (u64::from(u.x.to_bits()) << 32) | u64::from(u.y.to_bits());
    let hash = mix2(bits, u64::from(attempt));
    // The upper and the next 24 bits.
    Vec2::new(unit_float(hash), unit_float(hash << 24))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sampling::concentric_disk;

    #[test]
    fn concentric_is_shirley_and_chius_without_trigonometry() {
        for i in 0..=64 {
            for j in 0..=64 {
                let u = Vec2::new(i as f32 / 64.0, j as f32 / 64.0);
                let p = Polar::concentric(u);
                assert!((0.0..=1.0).contains(&p.radius) && (0.0..=1.0).contains(&p.turn));
                let (sin, cos) = (std::f64::consts::TAU * p.turn).sin_cos();
                let disk = concentric_disk(u).as_dvec2();
                // The disk's mapping is in f32.
                assert!((p.radius * cos - disk.x).abs() < 1e-6, "{u} {p:?} {disk}");
                assert!((p.radius * sin - disk.y).abs() < 1e-6, "{u} {p:?} {disk}");
            }
        }
    }

    #[test]
    fn redrawing_ends_and_spreads() {
        // Nothing lands: it ends all the same.
        assert!(redrawn(Vec2::splat(0.5), |_| None::<()>).is_err());
        // Candidates after the first have mean 1/2 and variance 1/12 in both coordinates,
        // whatever the first was; 4096 of them leave 0.0045 of the mean's standard deviation.
        let draws: Vec<Vec2> = (0..4096u32)
            .map(|i| {
                let first = Vec2::new(i as f32 / 4096.0, 0.25);
                redrawn(first, |u| (u != first).then_some(u)).unwrap()
            })
            .collect();
        let mean = draws.iter().sum::<Vec2>() / 4096.0;
        let square = draws.iter().map(|u| *u * *u).sum::<Vec2>() / 4096.0;
        assert!(
            (mean - Vec2::splat(0.5)).abs().max_element() < 5.0 * 0.0045,
            "{mean}"
        );
        assert!(
            (square - Vec2::splat(1.0 / 3.0)).abs().max_element() < 0.025,
            "{square}"
        );
    }
}
