//! Estimates of what several groups of lights bring to a point, computed together.

use super::light_bounds::LightBounds;
use crate::math::Vec3;
use wide::f32x4;

/// Groups in one set of lanes.
pub(super) const LANES: usize = 8;

/// What light is chosen for: a point, and how it is turned.
#[derive(Clone, Copy, Debug)]
pub(super) struct Receiver {
    p: Vec3,
    n: Vec3,
    /// The share received is this plus `by_cosine` × cosine.
    always: f32,
    by_cosine: f32,
}

impl Receiver {
    /// A point with unit normal `n`, whose both sides count; zero in a medium.
    pub(super) fn new(p: Vec3, n: Vec3) -> Receiver {
        /// What a light at the horizon counts for: a shading normal may see it above.
        const AT_HORIZON: f32 = 0.1;
        let always = if n == Vec3::ZERO { 1.0 } else { AT_HORIZON };
        Receiver {
            p,
            n,
            always,
            by_cosine: 1.0 - always,
        }
    }
}

/// Lanes of a half, one register of every processor.
pub(super) const HALF: usize = LANES / 2;

/// Eight [`LightBounds`]es in the form they are estimated with; lanes without one bring nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct Lanes([Half; 2]);

impl Lanes {
    pub(super) fn empty() -> Lanes {
        Lanes([Half::empty(), Half::empty()])
    }

    /// Puts bounds into a lane. Distances below `min_distance`, or half the box's diagonal, do not
    /// count as nearer.
    pub(super) fn set(&mut self, lane: usize, bounds: &LightBounds, min_distance: f32) {
        if let Some(half) = self.0.get_mut(lane / HALF) {
            half.set(lane % HALF, bounds, min_distance);
        }
    }

    /// About the irradiance that each lane brings to a receiver.
    #[inline]
    pub(super) fn at(&self, to: &Receiver) -> [f32; LANES] {
        let [[a, b, c, d], [e, f, g, h]] = [self.0[0].at(to), self.0[1].at(to)];
        [a, b, c, d, e, f, g, h]
    }

    /// That of the first lanes.
    #[inline]
    pub(super) fn at_first(&self, to: &Receiver) -> [f32; HALF] {
        self.0[0].at(to)
    }
}

/// Four of them.
#[derive(Clone, Debug, Default)]
struct Half {
    center: [f32x4; 3],
    axis: [f32x4; 3],
    /// Of the sphere around the box.
    radius: f32x4,
    /// The largest that 1/distance² counts for.
    most: f32x4,
    intensity: f32x4,
    cos_spread: f32x4,
    sin_spread: f32x4,
    cos_falloff: f32x4,
    everywhere: f32x4,
}

impl Half {
    fn empty() -> Half {
        Half {
            most: f32x4::ONE,
            ..Half::default()
        }
    }

    /// See [`Lanes::set`].
    fn set(&mut self, lane: usize, bounds: &LightBounds, min_distance: f32) {
        let put = |lanes: &mut f32x4, value: f32| {
            if let Some(slot) = lanes.as_mut_array().get_mut(lane) {
                *slot = value;
            }
        };
        let center = bounds.center();
        for axis in 0..3 {
            put(&mut self.center[axis], center[axis]);
            put(&mut self.axis[axis], bounds.axis[axis]);
        }
        let radius = 0.5 * bounds.diagonal2().sqrt();
        let least = radius.max(min_distance);
        put(&mut self.radius, radius);
        put(&mut self.most, 1.0 / (least * least).max(f32::MIN_POSITIVE));
        put(&mut self.intensity, bounds.intensity);
        let (sin, cos) = bounds.spread.sin_cos();
        put(&mut self.cos_spread, cos);
        put(&mut self.sin_spread, sin);
        put(&mut self.cos_falloff, bounds.falloff.cos());
        put(&mut self.everywhere, bounds.everywhere);
    }

    /// See [`Lanes::at`].
    ///
    /// The lights are seen within an angle whose sine is radius/distance. Instead of turning
    /// directions by that angle, which would be the paper's bound (see [`super::clusters`]), the sine is
    /// added to the cosine: it is almost as much, and saves two roots.
    #[inline(always)]
    fn at(&self, to: &Receiver) -> [f32; HALF] {
        // `fast_max` and `fast_min` do not care for NaN, which only a point that is none brings: whatever they return, no light that can
        // reach a sound point is lost.
        let one = f32x4::ONE;
        // Written out: `array::map` is not inlined here (see `accel::packet`).
        let x = f32x4::splat(to.p.x) - self.center[0];
        let y = f32x4::splat(to.p.y) - self.center[1];
        let z = f32x4::splat(to.p.z) - self.center[2];
        let distance2 = x * x + y * y + z * z;
        let over_distance = one / distance2.fast_max(f32x4::splat(f32::MIN_POSITIVE)).sqrt();
        let size = self.radius * over_distance;
        let cos = (x * self.axis[0] + y * self.axis[1] + z * self.axis[2]) * over_distance;
        let sin = (one - cos * cos).fast_max(f32x4::ZERO).sqrt();
        // Past the directions that shine most.
        let within = cos.simd_ge(self.cos_spread);
        let past = within.bitselect(one, cos * self.cos_spread + sin * self.sin_spread);
        let seen = (past + size).fast_min(one);
        let share = seen.fast_max(f32x4::ZERO) & seen.simd_ge(self.cos_falloff);
        let n = to.n;
        let along = x * f32x4::splat(n.x) + y * f32x4::splat(n.y) + z * f32x4::splat(n.z);
        let facing = (along.abs() * over_distance + size).fast_min(one);
        let received = f32x4::splat(to.always) + f32x4::splat(to.by_cosine) * facing;
        let falloff = (over_distance * over_distance).fast_min(self.most);
        (self.everywhere + self.intensity * share * received * falloff).to_array()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;

    fn estimate(bounds: &LightBounds, p: Vec3, n: Vec3) -> f32 {
        let mut lanes = Lanes::empty();
        lanes.set(3, bounds, 0.0);
        let estimates = lanes.at(&Receiver::new(p, n));
        let others = (0..LANES).filter(|&k| k != 3);
        assert!(others.clone().all(|k| estimates[k] == 0.0));
        estimates[3]
    }

    #[test]
    fn a_small_face_is_estimated_exactly() {
        let face = LightBounds::point(Vec3::Y, Rgb::ONE).on_side(Vec3::NEG_Y);
        // Single precision.
        let close = |a: f32, b: f32| assert!((a - b).abs() < 1e-5 * b.max(1e-3), "{a} {b}");
        close(estimate(&face, Vec3::NEG_Y, Vec3::ZERO), 0.25);
        close(estimate(&face, Vec3::NEG_Y, Vec3::NEG_Y), 0.25);
        close(estimate(&face, Vec3::X, Vec3::ZERO), 0.5f32.sqrt() / 2.0);
        let received = 0.1 + 0.9 * 0.5f32.sqrt();
        close(
            estimate(&face, Vec3::X, Vec3::X),
            received * 0.5f32.sqrt() / 2.0,
        );
        assert_eq!(estimate(&face, Vec3::Y * 2.0, Vec3::ZERO), 0.0);
        let light = LightBounds::point(Vec3::Y, Rgb::ONE);
        close(estimate(&light, Vec3::Y * 3.0, Vec3::ZERO), 0.25);
        let spot = light.within_cone(Vec3::X, 0.8, 0.9);
        close(
            estimate(&spot, Vec3::new(4.0, 1.0, 0.0), Vec3::ZERO),
            1.0 / 16.0,
        );
        assert_eq!(estimate(&spot, Vec3::new(4.0, 5.0, 0.0), Vec3::ZERO), 0.0);
        close(
            estimate(&LightBounds::everywhere(Rgb::ONE * 0.3), Vec3::Z, Vec3::Z),
            0.3,
        );
    }

    #[test]
    fn wide_groups_are_never_dark_where_a_member_shines() {
        // Faces around a box, looking outward or upward: wherever one of them shines in full, their
        // common estimate is not 0.
        for turn in 0..16 {
            let n = Vec3::new(
                (turn as f32).cos(),
                0.3 * (turn % 3) as f32,
                (turn as f32).sin(),
            );
            let n = n.normalize();
            let face = |at: Vec3| LightBounds::point(at, Rgb::ONE).on_side(n);
            let other = LightBounds::point(Vec3::new(2.0, 0.5, -1.0), Rgb::ONE).on_side(Vec3::Y);
            let all = face(Vec3::X).merged(&face(Vec3::Z)).merged(&other);
            for distance in [0.2, 1.0, 5.0, 100.0] {
                let p = Vec3::X + n * distance;
                assert!(estimate(&face(Vec3::X), p, Vec3::ZERO) > 0.0);
                assert!(estimate(&all, p, Vec3::ZERO) > 0.0, "{n} {distance}");
            }
        }
    }
}
