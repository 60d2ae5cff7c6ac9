//! The region of one ring of film radii: a star-shaped polygon that changes with the film radius.
//!
//! Corners are known at the ring's inner and outer radius and move on straight lines in between, so
//! each triangle between the middle and two neighbouring corners has an area quadratic in the film radius, and so
//! have their sums: the inverse of the area's distribution over direction is exact at every radius, for a
//! few multiplications and no trigonometry.

use super::mapping::{Polar, PupilSampling, redrawn};
use super::outline::cross;
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
    pub fn at(&self, t: f64) -> f64 {
        self.from + t * (self.to - self.from)
    }
}

impl Moving<[f64; 2]> {
    pub fn at(&self, t: f64) -> [f64; 2] {
        [0, 1].map(|i| self.from[i] + t * (self.to[i] - self.from[i]))
    }
}

/// One corner of the half with y ≥ 0.
#[derive(Clone, Copy, Debug)]
struct Corner {
    /// Relative to the middle, mm.
    at: Moving<[f64; 2]>,
    /// Area of both halves' triangles before this corner, mm²: coefficients of 1, t and t².
    before: [f64; 3],
}

impl Corner {
    fn before(&self, t: f64) -> f64 {
        self.before[0] + t * (self.before[1] + t * self.before[2])
    }
}

/// A region for all film points of a ring, symmetric about the film point's azimuth.
#[derive(Clone, Debug)]
pub(super) struct Ring {
    /// Film radii that it serves, mm.
    pub radii: [f64; 2],
    /// One over their difference.
    per_width: f64,
    center: Moving<f64>,
    corners: Vec<Corner>,
}

/// The extent of a region, and its area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Distance of the middle from the lens axis, in the direction of the film point, mm.
    pub center: f64,
    /// Half the extent along that direction, mm.
    pub along: f64,
    /// Half the extent across it, mm.
    pub across: f64,
    /// In mm².
    pub area: f64,
}

impl Ring {
    /// For film radii from `radii[0]` to `radii[1]`, where t runs from 0 to 1. `None` unless the
    /// corners go once around the middle, counterclockwise, at every t.
    pub fn new(radii: [f64; 2], center: Moving<f64>, corners: &[Moving<[f64; 2]>]) -> Option<Ring> {
        let mut before = [0.0; 3];
        let mut finished = Vec::with_capacity(corners.len());
        for (i, corner) in corners.iter().enumerate() {
            if i > 0 {
                let area = triangle(&corners[i - 1], corner);
                if !never_negative(area) {
                    return None;
                }
                before = [0, 1, 2].map(|k| before[k] + area[k]);
            }
            finished.push(Corner {
                at: *corner,
                before,
            });
        }
        let positive = |t: f64| before[0] + t * (before[1] + t * before[2]) > 0.0;
        let finite = center.from.is_finite() && center.to.is_finite();
        (finite && positive(0.0) && positive(0.5) && positive(1.0)).then_some(Ring {
            radii,
            per_width: 1.0 / (radii[1] - radii[0]),
            center,
            corners: finished,
        })
    }

    /// Where `radius` lies in the ring.
    pub fn t(&self, radius: f64) -> f64 {
        ((radius - self.radii[0]) * self.per_width).clamp(0.0, 1.0)
    }

    /// In mm².
    pub fn area(&self, t: f64) -> f64 {
        self.corners[self.corners.len() - 1].before(t)
    }

    /// A point of the region at `t`, relative to the lens axis, along and across the film point's
    /// azimuth.
    pub fn sample(&self, t: f64, u: Vec2, sampling: PupilSampling) -> [f64; 2] {
        let p = match sampling {
            PupilSampling::Concentric => self.point(t, Polar::concentric(u)),
            PupilSampling::Polar => self.point(t, Polar::square_root(u)),
            PupilSampling::Rejection => self.by_rejection(t, u),
        };
        [self.center.at(t) + p[0], p[1]]
    }

    /// The first candidate in the bounding box that lies in the region.
    #[cold]
    fn by_rejection(&self, t: f64, u: Vec2) -> [f64; 2] {
        let (low, high) = self.bounds(t);
        let in_box = |u: Vec2| {
            let u = u.as_dvec2();
            let p = [low + u.x * (high[0] - low), (2.0 * u.y - 1.0) * high[1]];
            self.holds(t, p).then_some(p)
        };
        redrawn(u, in_box).unwrap_or_else(|u| self.point(t, Polar::concentric(u)))
    }

    /// The point `p` of the region, relative to its middle.
    #[inline]
    fn point(&self, t: f64, p: Polar) -> [f64; 2] {
        // The part of half a turn, and which half.
        let half = 2.0 * p.turn.min(1.0 - p.turn);
        let side = 1f64.copysign(0.5 - p.turn);
        let last = self.corners.len() - 1;
        let wanted = half * self.area(t);
        // Triangles have about the same area, so the one wanted is near its share.
        let mut i = ((half * last as f64) as usize).min(last - 1);
        let (mut before, mut after) = (self.corners[i].before(t), self.corners[i + 1].before(t));
        while wanted > after && i + 1 < last {
            i += 1;
            (before, after) = (after, self.corners[i + 1].before(t));
        }
        while wanted < before && i > 0 {
            i -= 1;
            (before, after) = (self.corners[i].before(t), before);
        }
        let area = after - before;
        let s = if area > 0.0 {
            ((wanted - before) / area).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let (a, b) = (self.corners[i].at.at(t), self.corners[i + 1].at.at(t));
        [
            p.radius * (a[0] + s * (b[0] - a[0])),
            side * p.radius * (a[1] + s * (b[1] - a[1])),
        ]
    }

    /// Smallest x, and largest x and y, relative to the middle.
    fn bounds(&self, t: f64) -> (f64, [f64; 2]) {
        let points = self.corners.iter().map(|c| c.at.at(t));
        points.fold((0.0, [0.0; 2]), |(low, high), p| {
            (
                f64::min(low, p[0]),
                [f64::max(high[0], p[0]), f64::max(high[1], p[1])],
            )
        })
    }

    /// Is `p`, relative to the lens axis, within the region of film radius `radius`?
    #[cfg(test)]
    pub fn holds_absolute(&self, radius: f64, p: [f64; 2]) -> bool {
        let t = self.t(radius);
        self.holds(t, [p[0] - self.center.at(t), p[1]])
    }

    /// Is `p`, relative to the middle, within the region?
    fn holds(&self, t: f64, p: [f64; 2]) -> bool {
        let p = [p[0], p[1].abs()];
        let at = |i: usize| self.corners[i].at.at(t);
        // Corners run counterclockwise through half a turn: the last one that p has passed.
        let i = self
            .corners
            .partition_point(|c| cross(c.at.at(t), p) >= 0.0)
            .clamp(1, self.corners.len() - 1);
        let (a, b) = (at(i - 1), at(i));
        cross([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]) >= 0.0
    }

    /// The region's extent.
    pub fn region(&self, t: f64) -> Region {
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

/// Is c₀ + c₁t + c₂t² ≥ 0 for t from 0 to 1, and finite?
fn never_negative(c: [f64; 3]) -> bool {
    let at = |t: f64| c[0] + t * (c[1] + t * c[2]);
    let lowest = (-0.5 * c[1] / c[2]).clamp(0.0, 1.0);
    let lowest = if lowest.is_nan() { 0.0 } else { lowest };
    // Written so that a NaN is refused.
    at(0.0) >= 0.0 && at(1.0) >= 0.0 && at(lowest) >= 0.0 && at(1.0).is_finite()
}
