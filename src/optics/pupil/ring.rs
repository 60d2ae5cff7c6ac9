//! The region of one ring of film radii: a star-shaped polygon that changes with the film radius.
//!
//! Corners are known at the ring's inner and outer radius and move on straight lines in between. At both ends
//! the triangles between the middle and two neighboring corners have the same area (`draft`), and between the ends all
//! but: so the triangle for a sample of the unit square is found without a search and without trigonometry
//! (`table`), and the sample's weight carries the triangle's own area.

use super::mapping::redrawn;
use super::outline::cross;
use super::region::Region;
use crate::math::Vec2;

/// Where a region's middle or corner is, as a function of t: 0 at the inner, 1 at the outer end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Moving<T> {
    /// At t = 0.
    pub from: T,
    /// At t = 1.
    pub to: T,
}

impl Moving<f64> {
    pub(super) fn at(&self, t: f64) -> f64 {
        self.from + t * (self.to - self.from)
    }
}

impl Moving<[f64; 2]> {
    pub(super) fn at(&self, t: f64) -> [f64; 2] {
        [0, 1].map(|i| self.from[i] + t * (self.to[i] - self.from[i]))
    }
}

/// A region for all film points of a ring, symmetric about the film point's azimuth.
#[derive(Clone, Debug)]
pub(super) struct Ring {
    /// Film radii that it serves, mm.
    pub radii: [f64; 2],
    /// One over their difference.
    per_width: f64,
    /// Distance of the middle from the lens axis, mm.
    pub center: Moving<f64>,
    /// Of the half with y ≥ 0, from +x to −x, relative to the middle, mm.
    pub corners: Vec<Moving<[f64; 2]>>,
    /// Of the whole region, mm²: coefficients of 1, t and t².
    area: [f64; 3],
}

impl Ring {
    /// For film radii from `radii[0]` to `radii[1]`, where t runs from 0 to 1. `None` unless the
    /// corners go once around the middle, counterclockwise, at every t.
    pub(super) fn new(
        radii: [f64; 2],
        center: Moving<f64>,
        corners: &[Moving<[f64; 2]>],
    ) -> Option<Ring> {
        let mut whole = [0.0; 3];
        for pair in corners.windows(2) {
            // Both halves' triangles.
            let area = triangle(&pair[0], &pair[1]);
            if !never_negative(area) {
                return None;
            }
            whole = [0, 1, 2].map(|k| whole[k] + area[k]);
        }
        let positive = |t: f64| quadratic(whole, t) > 0.0;
        let finite = center.from.is_finite() && center.to.is_finite();
        (finite && positive(0.0) && positive(0.5) && positive(1.0)).then_some(Ring {
            radii,
            per_width: 1.0 / (radii[1] - radii[0]),
            center,
            corners: corners.to_vec(),
            area: whole,
        })
    }

    /// Where `radius` lies in the ring.
    pub(super) fn t(&self, radius: f64) -> f64 {
        ((radius - self.radii[0]) * self.per_width).clamp(0.0, 1.0)
    }

    /// In mm².
    pub(super) fn area(&self, t: f64) -> f64 {
        quadratic(self.area, t)
    }

    /// By rejection a point of the region at `t`, evenly over its area, relative to the lens axis, along and across
    /// the film point's azimuth: the first candidate in the bounding box that lies in the region; where
    /// none does, the last one's numbers.
    pub(super) fn by_rejection(&self, t: f64, u: Vec2) -> Result<[f64; 2], Vec2> {
        let (low, high) = self.bounds(t);
        let in_box = |u: Vec2| {
            let u = u.as_dvec2();
            let p = [low + u.x * (high[0] - low), (2.0 * u.y - 1.0) * high[1]];
            self.holds(t, p).then_some([self.center.at(t) + p[0], p[1]])
        };
        redrawn(u, in_box)
    }

    /// Smallest x, and largest x and y, relative to the middle.
    fn bounds(&self, t: f64) -> (f64, [f64; 2]) {
        let points = self.corners.iter().map(|c| c.at(t));
        points.fold((0.0, [0.0; 2]), |(low, high), p| {
            (
                f64::min(low, p[0]),
                [f64::max(high[0], p[0]), f64::max(high[1], p[1])],
            )
        })
    }

    /// Returns `true` if `p`, relative to the lens axis, is within the region of film radius `radius`.
    #[cfg(test)]
    pub(super) fn holds_absolute(&self, radius: f64, p: [f64; 2]) -> bool {
        let t = self.t(radius);
        self.holds(t, [p[0] - self.center.at(t), p[1]])
    }

    /// Returns `true` if `p`, relative to the middle, is within the region.
    fn holds(&self, t: f64, p: [f64; 2]) -> bool {
        self.triangle(t, p).is_some()
    }

    /// The area of the region if it were all like the triangle that `p`, relative to the lens axis, lies in, along and across the film point's azimuth;
    /// `None` outside.
    pub(super) fn triangle_at(&self, t: f64, p: [f64; 2]) -> Option<f64> {
        let [a, b] = self.triangle(t, [p[0] - self.center.at(t), p[1]])?;
        Some(cross(a, b) * (self.corners.len() - 1) as f64)
    }

    /// The corners on either side of `p`, relative to the middle; `None` unless it lies within the region.
    fn triangle(&self, t: f64, p: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        let p = [p[0], p[1].abs()];
        let at = |i: usize| self.corners[i].at(t);
        // Corners run counterclockwise through half a turn: the last one that p has passed.
        let i = self
            .corners
            .partition_point(|c| cross(c.at(t), p) >= 0.0)
            .clamp(1, self.corners.len() - 1);
        let (a, b) = (at(i - 1), at(i));
        let inside = cross([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]) >= 0.0;
        inside.then_some([a, b])
    }

    /// The region's extent.
    pub(super) fn region(&self, t: f64) -> Region {
        let (low, high) = self.bounds(t);
        Region {
            center: self.center.at(t) + 0.5 * (low + high[0]),
            along: 0.5 * (high[0] - low),
            across: high[1],
            area: self.area(t),
        }
    }
}

/// Twice the area of the triangle 0, `a`, `b`, as coefficients of 1, t and t².
fn triangle(a: &Moving<[f64; 2]>, b: &Moving<[f64; 2]>) -> [f64; 3] {
    let change = |m: &Moving<[f64; 2]>| [m.to[0] - m.from[0], m.to[1] - m.from[1]];
    let (da, db) = (change(a), change(b));
    [
        cross(a.from, b.from),
        cross(a.from, db) + cross(da, b.from),
        cross(da, db),
    ]
}

/// c₀ + c₁t + c₂t².
fn quadratic(c: [f64; 3], t: f64) -> f64 {
    c[0] + t * (c[1] + t * c[2])
}

/// Returns `true` if c₀ + c₁t + c₂t² ≥ 0 for t from 0 to 1, and finite.
fn never_negative(c: [f64; 3]) -> bool {
    let at = |t: f64| quadratic(c, t);
    let lowest = (-0.5 * c[1] / c[2]).clamp(0.0, 1.0);
    let lowest = if lowest.is_nan() { 0.0 } else { lowest };
    // Written so that a NaN is refused.
    at(0.0) >= 0.0 && at(1.0) >= 0.0 && at(lowest) >= 0.0 && at(1.0).is_finite()
}
