//! A ring's region while it is being made: corners that are pushed outward until nothing is left out.

use super::ellipse::Ellipse;
use super::outline::{Outline, cross};
use super::ring::{Moving, Ring};

/// Every corner is moved outward by this part of its distance from the middle: covers what the
/// outlines' own precision (1e-5) and the bends between neighbouring directions and radii leave. Costs 0.2 % of
/// the rays.
const MARGIN: f64 = 1e-3;

/// Between two outlines the region may stick out of the straight lines that join them by more than
/// it does half-way: for a bend up to twice as much (at the bend, if it lies near either end), for a
/// square root 1.2 times, for a parabola not at all.
const BETWEEN: f64 = 2.0;

/// The polygon of one ring; see [`Ring`].
#[derive(Clone, Debug)]
pub(super) struct Draft {
    pub center: Moving<f64>,
    pub corners: Vec<Moving<[f64; 2]>>,
}

impl Draft {
    /// Between the outlines at the ring's inner and outer radius.
    pub fn between(inner: &Outline, outer: &Outline) -> Draft {
        Draft {
            center: Moving {
                from: inner.center,
                to: outer.center,
            },
            corners: pairs(&inner.points, &outer.points),
        }
    }

    /// Around an ellipse at the inner, and one at the outer radius.
    pub fn of_ellipses(inner: &Ellipse, outer: &Ellipse) -> Draft {
        let corners = |e: &Ellipse| e.corners().collect::<Vec<_>>();
        Draft {
            center: Moving {
                from: inner.center,
                to: outer.center,
            },
            corners: pairs(&corners(inner), &corners(outer)),
        }
    }

    /// In mm², at `t`.
    pub fn area(&self, t: f64) -> f64 {
        let mut last = self.corners[0].at(t);
        let mut sum = 0.0;
        for corner in &self.corners[1..] {
            let next = corner.at(t);
            sum += cross(last, next);
            last = next;
        }
        sum
    }

    /// The triangle in whose direction `p` (relative to the lens axis) lies, and how far `p` is
    /// beyond its outer side, mm; negative inside.
    pub fn beyond(&self, t: f64, p: [f64; 2]) -> (usize, f64) {
        let v = [p[0] - self.center.at(t), p[1].abs()];
        let last = self.corners.len() - 1;
        let i = self
            .corners
            .partition_point(|c| cross(c.at(t), v) >= 0.0)
            .clamp(1, last);
        let (a, b) = (self.corners[i - 1].at(t), self.corners[i].at(t));
        // v = α a + β b; α + β is 1 on the side.
        let reach = (cross(v, b) + cross(a, v)) / cross(a, b);
        // A triangle of no area, seen from its own plane, holds nothing.
        let length = v[0].hypot(v[1]);
        let beyond = if reach.is_finite() && reach > 0.0 {
            length * (1.0 - 1.0 / reach)
        } else {
            length
        };
        (i - 1, beyond)
    }

    /// Makes room for what bends outward between neighbouring corners: where the region is convex
    /// it does not reach beyond the lines through the sides on either side.
    pub fn circumscribe(&mut self) {
        let from: Vec<[f64; 2]> = self.corners.iter().map(|c| c.from).collect();
        let to: Vec<[f64; 2]> = self.corners.iter().map(|c| c.to).collect();
        let (inner, outer) = (room_for_bends(&from), room_for_bends(&to));
        for (i, c) in self.corners.iter_mut().enumerate() {
            c.from = c.from.map(|x| inner[i] * x);
            c.to = c.to.map(|x| outer[i] * x);
        }
    }

    /// How far the outline found half-way sticks out, for each triangle, mm.
    pub fn gaps(&self, middle: &Outline) -> Vec<f64> {
        let mut gaps = vec![0.0; self.corners.len() - 1];
        for p in middle.absolute() {
            let (i, beyond) = self.beyond(0.5, p);
            gaps[i] = f64::max(gaps[i], beyond);
        }
        gaps
    }

    /// Moves the corners outward so that what sticks out by `gaps` half-way (and by more
    /// elsewhere) lies inside.
    pub fn fill(&mut self, gaps: &[f64]) {
        let last = self.corners.len() - 1;
        for i in 0..=last {
            // A bend may lie in a neighbouring triangle at another radius.
            let near = &gaps[i.saturating_sub(2)..(i + 2).min(last)];
            let gap = near.iter().copied().fold(0.0, f64::max);
            self.push(i, BETWEEN * gap);
        }
    }

    /// Moves every corner outward by the margin.
    pub fn grow(&mut self) {
        for c in &mut self.corners {
            c.from = c.from.map(|x| (1.0 + MARGIN) * x);
            c.to = c.to.map(|x| (1.0 + MARGIN) * x);
        }
    }

    /// Moves the corners of triangle `i` outward by `length` mm, at all radii.
    pub fn push_side(&mut self, i: usize, length: f64) {
        self.push(i, length);
        self.push(i + 1, length);
    }

    fn push(&mut self, i: usize, length: f64) {
        let p = self.corners[i].at(0.5);
        let scale = length / p[0].hypot(p[1]);
        if scale > 0.0 && scale.is_finite() {
            let c = &mut self.corners[i];
            c.from = [0, 1].map(|k| c.from[k] + scale * p[k]);
            c.to = [0, 1].map(|k| c.to[k] + scale * p[k]);
        }
    }

    /// Ready to sample; `None` where it is no star (see [`Ring::new`]).
    pub fn finish(&self, radii: [f64; 2]) -> Option<Ring> {
        Ring::new(radii, self.center, &self.corners)
    }
}

fn pairs(from: &[[f64; 2]], to: &[[f64; 2]]) -> Vec<Moving<[f64; 2]>> {
    let pairs = from.iter().zip(to);
    pairs
        .map(|(a, b)| Moving { from: *a, to: *b })
        .collect()
}

/// For each corner, by what to multiply it so that the polygon holds every convex region through
/// all of them.
fn room_for_bends(points: &[[f64; 2]]) -> Vec<f64> {
    let last = points.len() - 1;
    // The other half is the mirror image.
    let at = |i: isize| match i {
        i if i < 0 => [points[1][0], -points[1][1]],
        i if i as usize > last => [points[last - 1][0], -points[last - 1][1]],
        i => points[i as usize],
    };
    let sides: Vec<f64> = (0..last as isize)
        .map(|i| bend(at(i - 1), at(i), at(i + 1), at(i + 2)))
        .collect();
    (0..=last)
        .map(|i| sides[i.saturating_sub(1)].max(sides[i.min(last - 1)]))
        .collect()
}

/// How far the lines `a`–`b` and `d`–`c` meet beyond the side `b`–`c`, as a factor on the distance from 0
/// (at least 1).
fn bend(a: [f64; 2], b: [f64; 2], c: [f64; 2], d: [f64; 2]) -> f64 {
    let minus = |p: [f64; 2], q: [f64; 2]| [p[0] - q[0], p[1] - q[1]];
    let (ab, dc, bc) = (minus(b, a), minus(c, d), minus(c, b));
    let s = cross(bc, dc) / cross(ab, dc);
    let apex = [b[0] + s * ab[0], b[1] + s * ab[1]];
    let factor = (cross(apex, c) + cross(b, apex)) / cross(b, c);
    // Nearly parallel lines meet far off; corners of the region sharper than 1.2 would need a right
    // angle seen from less than a seventh of the region's size.
    if factor.is_finite() && s > 0.0 {
        factor.clamp(1.0, 1.2)
    } else {
        1.0
    }
}
