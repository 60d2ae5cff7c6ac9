//! From the unit square to a region: three ways, each even over the region's area.

use crate::math::Vec2;
use crate::math::hash::{mix2, unit_float};
use crate::optics::real::{Index, Plain};

/// How lens samples are spread over the exit pupil (`"string pupilsampling"`). All three give the
/// same image but for its noise.
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

/// A point of a star-shaped region that is its own mirror image: how far out and which way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spot<T> {
    /// Distance from the middle, relative to the outline's in that direction.
    pub radius: T,
    /// The part of the area of the half with y ≥ 0 between +x and the direction, or its mirror image;
    /// 0 to 1.
    pub half: T,
    /// 1 for that half, −1 for the other.
    pub side: T,
}

impl<T: Index> Spot<T> {
    /// The concentric mapping. `half` needs no trigonometry: along the side of a square it is linear.
    /// Choices between values, not between paths: which triangle of the square a sample falls into
    /// cannot be predicted, and differs within a bundle.
    #[inline(always)]
    pub(super) fn concentric(u: [T; 2]) -> Spot<T> {
        let (zero, one) = (T::Base::ZERO, T::Base::ONE);
        let [two, four, quarter] = [2.0, 4.0, 0.25].map(T::Base::round_from);
        let [x, y] = u.map(|x| x.times(two).plus(-one));
        let (across, up) = (x.abs(), y.abs());
        let flat = (across - up).greater(zero);
        let (short, long) = (T::select(flat, up, x), T::select(flat, x, up));
        // In the middle of the square both are 0.
        let middle = T::select(flat, across, up).at_most(zero);
        let slope = short / T::select(middle, T::constant(one), long);
        let left = T::select(x.greater(zero), T::constant(zero), T::constant(four));
        let eighths = T::select(flat, left + slope, T::constant(two) - slope);
        Spot {
            radius: T::select(flat, across, up),
            half: eighths.times(quarter),
            side: sign(y),
        }
    }

    /// The square-root polar mapping.
    #[inline(always)]
    pub(super) fn square_root(u: [T; 2]) -> Spot<T> {
        let one = T::Base::ONE;
        // From −1, where the turn begins, over 0 half-way to 1.
        let turn = u[1].times(T::Base::round_from(2.0)).plus(-one);
        Spot {
            radius: u[0].sqrt(),
            half: T::constant(one) - turn.abs(),
            side: -sign(turn),
        }
    }
}

/// 1, or −1 for what is negative.
#[inline(always)]
fn sign<T: Index>(x: T) -> T {
    let one = T::constant(T::Base::ONE);
    T::select(x.at_least(T::Base::ZERO), one, -one)
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
                let p = Spot::concentric(u.as_dvec2().to_array());
                assert!((0.0..=1.0).contains(&p.radius) && (0.0..=1.0).contains(&p.half));
                let (sin, cos) = (std::f64::consts::PI * p.half).sin_cos();
                let sin = p.side * sin;
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
