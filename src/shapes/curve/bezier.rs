//! Cubic Bézier curves.

use crate::math::{DVec3, Vec3};

/// Four control points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bezier(pub [DVec3; 4]);

impl Bezier {
    /// From the three or four control points of a Bézier curve; three are raised in degree. Others
    /// than three count as four, the missing ones 0.
    pub fn from_bezier(p: &[DVec3]) -> Bezier {
        match *p {
            [a, b, c] => Bezier([a, a.lerp(b, 2.0 / 3.0), b.lerp(c, 1.0 / 3.0), c]),
            _ => Bezier(std::array::from_fn(|i| {
                p.get(i).copied().unwrap_or_default()
            })),
        }
    }

    /// The segment of a uniform B-spline between its middle control points (Farin, "Curves and
    /// Surfaces for CAGD", 2002, §8: blossoms at the knots).
    pub fn from_bspline(p: &[DVec3]) -> Bezier {
        match *p {
            [a, b, c] => Bezier::from_bezier(&[a.midpoint(b), b, b.midpoint(c)]),
            [a, b, c, d] => {
                let (third, two_thirds) = (b.lerp(c, 1.0 / 3.0), b.lerp(c, 2.0 / 3.0));
                let start = a.lerp(b, 2.0 / 3.0).midpoint(third);
                let end = two_thirds.midpoint(c.lerp(d, 1.0 / 3.0));
                Bezier([start, third, two_thirds, end])
            }
            _ => Bezier::from_bezier(p),
        }
    }

    /// Widened from single precision.
    pub fn widened(p: &[Vec3; 4]) -> Bezier {
        Bezier(p.map(Vec3::as_dvec3))
    }

    /// Two levels of de Casteljau's algorithm: the points whose line holds the tangent at `t`.
    fn last_two(&self, t: f64) -> [DVec3; 2] {
        let [a, b, c, d] = self.0;
        let (ab, bc, cd) = (a.lerp(b, t), b.lerp(c, t), c.lerp(d, t));
        [ab.lerp(bc, t), bc.lerp(cd, t)]
    }

    /// The point at `t`, and the derivative there. Where that vanishes (coinciding control points)
    /// the direction from end to end takes its place, as in pbrt-v3.
    pub fn at(&self, t: f64) -> (DVec3, DVec3) {
        let [p, q] = self.last_two(t);
        let derivative = if p == q {
            self.0[3] - self.0[0]
        } else {
            3.0 * (q - p)
        };
        (p.lerp(q, t), derivative)
    }

    /// The halves.
    pub fn halves(&self) -> [Bezier; 2] {
        let [a, b, c, d] = self.0;
        let (ab, bc, cd) = (a.midpoint(b), b.midpoint(c), c.midpoint(d));
        let (abc, bcd) = (ab.midpoint(bc), bc.midpoint(cd));
        let middle = abc.midpoint(bcd);
        [Bezier([a, ab, abc, middle]), Bezier([middle, bcd, cd, d])]
    }

    /// The part from `t0` to `t1`, by blossoming.
    pub fn part(&self, t0: f64, t1: f64) -> Bezier {
        let [a, b] = self.last_two(t0);
        let [c, d] = self.last_two(t1);
        Bezier([a.lerp(b, t0), a.lerp(b, t1), c.lerp(d, t0), c.lerp(d, t1)])
    }

    /// Corners of the box around the control points, which holds the curve.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let [a, b, c, d] = self.0;
        (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)))
    }

    /// Length of the control polygon, not less than that of the curve.
    pub fn hull_length(&self) -> f64 {
        self.0.windows(2).map(|p| p[0].distance(p[1])).sum()
    }

    /// The largest component of a second difference of the control points: the curve is within a
    /// sixth of a multiple of it of its chord.
    pub fn bend(&self) -> f64 {
        let second = |i: usize| self.0[i] - 2.0 * self.0[i + 1] + self.0[i + 2];
        second(0).abs().max(second(1).abs()).max_element()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wild() -> Bezier {
        Bezier([
            DVec3::ZERO,
            DVec3::new(1.0, 2.0, -1.0),
            DVec3::new(-2.0, 1.0, 0.5),
            DVec3::new(0.5, 3.0, 1.0),
        ])
    }

    #[test]
    fn parts_and_halves_are_the_same_curve() {
        let curve = wild();
        let [first, second] = curve.halves();
        for i in 0..=10 {
            let t = f64::from(i) / 10.0;
            let (p, dp) = curve.part(0.2, 0.7).at(t);
            let (q, dq) = curve.at(0.2 + 0.5 * t);
            assert!((p - q).length() < 1e-14 && (dp - 0.5 * dq).length() < 1e-13);
            assert!((first.at(t).0 - curve.at(0.5 * t).0).length() < 1e-15);
            assert!((second.at(t).0 - curve.at(0.5 + 0.5 * t).0).length() < 1e-15);
        }
    }

    #[test]
    fn quadratics_and_splines_become_the_same_cubics() {
        let p: Vec<DVec3> = wild().0.to_vec();
        let quadratic = Bezier::from_bezier(&p[..3]);
        // The B-splines' bases at the uniform parameter t.
        for i in 0..=10 {
            let t = f64::from(i) / 10.0;
            let s = 1.0 - t;
            let expected = s * s * p[0] + 2.0 * s * t * p[1] + t * t * p[2];
            assert!((quadratic.at(t).0 - expected).length() < 1e-14);
            let expected = 0.5 * (s * s * p[0] + (1.0 + 2.0 * s * t) * p[1] + t * t * p[2]);
            assert!((Bezier::from_bspline(&p[..3]).at(t).0 - expected).length() < 1e-14);
            let expected = (s * s * s * p[0]
                + (3.0 * t * t * t - 6.0 * t * t + 4.0) * p[1]
                + (3.0 * s * s * s - 6.0 * s * s + 4.0) * p[2]
                + t * t * t * p[3])
                / 6.0;
            assert!((Bezier::from_bspline(&p).at(t).0 - expected).length() < 1e-14);
        }
    }

    #[test]
    fn a_vanishing_derivative_is_replaced() {
        let curve = Bezier([DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, DVec3::X]);
        assert_eq!(curve.at(0.0).1, DVec3::X);
    }
}
