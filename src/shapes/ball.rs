//! A full sphere under rotations, reflections and uniform scales, which stays one: rays meet it, and light is sampled
//! from it ([`super::emitter`]), where it is, without object space.

use super::Form;
use super::local::LocalPoint;
use super::quadric::{ROUNDINGS, roots_if_any};
use crate::math::DVec3;
use crate::math::transform::Transform;

/// A sphere in the space of the tree that holds it.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    /// Center.
    pub center: DVec3,
    /// Radius.
    pub radius: f64,
    /// The normal points to the center.
    pub inward: bool,
}

impl Ball {
    /// The ball that `form` is in place, if it is one.
    pub(super) fn new(form: &Form, level_from_object: &Transform, inward: bool) -> Option<Ball> {
        let (Form::Sphere(sphere), Some(scale)) = (form, level_from_object.similarity()) else {
            return None;
        };
        sphere.is_full().then_some(Ball {
            center: level_from_object.m.w_axis.truncate(),
            radius: sphere.radius * scale,
            inward,
        })
    }

    /// Distance to the nearest point along the ray `o + t d`, t > 0, in units of `d`'s length.
    #[inline(always)]
    pub(super) fn distance(&self, o: DVec3, d: DVec3) -> Option<f64> {
        let equation = self.equation(o, d);
        if equation.discriminant.is_nan() || equation.discriminant < 0.0 {
            return None;
        }
        let t = equation.nearest();
        (t > 0.0).then_some(t)
    }

    /// The same without a branch, for rays side by side: not above 0 if there is none.
    #[inline(always)]
    pub(crate) fn distance_if_any(&self, o: DVec3, d: DVec3) -> f64 {
        self.equation(o, d).nearest()
    }

    /// Both places where the line `o + t d` crosses it, in units of `d`'s length, and whether it leaves on the side that the normal points to.
    pub(crate) fn crossings(&self, o: DVec3, d: DVec3) -> [(f64, bool); 2] {
        let Equation {
            a,
            b,
            c,
            discriminant,
        } = self.equation(o, d);
        let [enters, leaves] = roots_if_any(a, b, c, discriminant);
        [(enters, self.inward), (leaves, !self.inward)]
    }

    #[inline(always)]
    fn equation(&self, o: DVec3, d: DVec3) -> Equation {
        let o = o - self.center;
        let (a, b, r2) = (d.length_squared(), o.dot(d), self.radius * self.radius);
        // a (r² − |o⊥|²) with o⊥ the part of o across the ray: b² − a c cancels badly for distant origins (Hearn and
        // Baker; Haines et al., Ray Tracing Gems 2019, ch. 7).
        let across = o - d * (b / a);
        Equation {
            a,
            b,
            // An origin that has been moved off the sphere by `error` is on its right side by this difference.
            c: o.length_squared() - r2,
            discriminant: a * (r2 - across.length_squared()),
        }
    }

    /// Returns `true` if the ray is outside where it begins and at `t_max`, which it reaches before it is nearest to the center: then it meets
    /// nothing on the way, as most shadow rays to a light of this shape, and no root is needed to know. Where rounding might decide,
    /// [`Ball::distance`] is asked.
    #[inline(always)]
    pub(super) fn is_beyond(&self, o: DVec3, d: DVec3, t_max: f64) -> bool {
        /// Of squares that cancel: they lose some 1e-15 of themselves, and roots may lie the square root of that, 3e-8, off their place.
        const MARGIN: f64 = 1e-9;
        let o = o - self.center;
        let (a, b, o2, r2) = (
            d.length_squared(),
            o.dot(d),
            o.length_squared(),
            self.radius * self.radius,
        );
        let (c, end2) = (o2 - r2, a * t_max * t_max);
        let margin = MARGIN * (o2 + r2 + end2);
        (c > margin) & (c + 2.0 * b * t_max + end2 > margin) & (a * t_max < -b)
    }

    /// Where the ray first meets it.
    #[inline]
    pub(super) fn meet(&self, o: DVec3, d: DVec3) -> Option<LocalPoint> {
        let t = self.distance(o, d)?;
        let outward = (o - self.center + d * t).normalize_or(DVec3::Z);
        let n = self.normal(outward);
        Some(LocalPoint {
            p: self.center + outward * self.radius,
            p_error: self.error(),
            n,
            shading_n: n,
        })
    }

    /// Half-widths of the box around a point computed on it, outside which a ray that begins sees the right side: what
    /// the squares in [`Ball::distance`] lose is relative to center and radius together.
    #[inline(always)]
    pub(super) fn error(&self) -> DVec3 {
        let largest = self.center.abs().max_element() + self.radius;
        DVec3::splat(largest * (ROUNDINGS * f64::EPSILON))
    }

    /// The normal, given the one that points away from the center.
    #[inline(always)]
    pub(super) fn normal(&self, outward: DVec3) -> DVec3 {
        if self.inward { -outward } else { outward }
    }
}

/// a t² + 2 b t + c = 0 for the distance t, in units of the direction's length, and b² − a c.
struct Equation {
    a: f64,
    b: f64,
    c: f64,
    discriminant: f64,
}

impl Equation {
    /// The least root above 0, if there is one: NaN if there are none. (Where a = 0, for no direction, `discriminant` is no number.)
    #[inline(always)]
    fn nearest(&self) -> f64 {
        let [less, more] = roots_if_any(self.a, self.b, self.c, self.discriminant);
        if less > 0.0 { less } else { more }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{mix2, unit_float};

    #[test]
    fn what_is_beyond_is_not_met_before() {
        let (mut beyond, mut near) = (0, 0);
        for i in 0..100_000 {
            let number = |k: u64| f64::from(unit_float(mix2(i, k)));
            let vector = |k: u64| DVec3::new(number(k), number(k + 1), number(k + 2)) * 2.0 - 1.0;
            let ball = Ball {
                center: vector(0),
                radius: 10f64.powf(-3.0 * number(3)),
                inward: false,
            };
            let target = ball.center + ball.radius * vector(4).normalize_or(DVec3::Z);
            let o = target + vector(7) * 10f64.powf(4.0 * number(10) - 3.0);
            let distance = (target - o).length();
            let d = (target - o) / distance;
            for end in [1.0, 1.0 - 1e-4, 0.5] {
                let t_max = end * distance;
                let met = ball.distance(o, d).is_some_and(|t| t < t_max);
                let is_beyond = ball.is_beyond(o, d, t_max);
                assert!(!(met && is_beyond), "{ball:?} {o} {d}");
                beyond += usize::from(is_beyond);
                near += usize::from(!is_beyond && !met);
            }
        }
        // It tells of most rays that are free, a third of which end on the ball itself.
        assert!(near < beyond, "{near} {beyond}");
        let ball = Ball {
            center: DVec3::ZERO,
            radius: 1.0,
            inward: false,
        };
        assert!(!ball.is_beyond(2.0 * DVec3::Z, DVec3::X, f64::INFINITY));
    }
}
