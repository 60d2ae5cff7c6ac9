//! A ring's region while it is being made: corners that are pushed outward until nothing is left out.

use super::ellipse::Ellipse;
use super::outline::{Outline, cross, reach};
use super::ring::{Moving, Ring};

/// Every corner is moved outward by this part of its distance from the middle: covers what the
/// outlines' own precision (1e-5) and the bends between neighbouring directions and radii leave. Costs 0.2 % of
/// the rays.
const MARGIN: f64 = 1e-3;

/// Between the two ends of a ring the region may stick out of the straight lines that join them by more
/// than it does a quarter, half and three quarters of the way: for a bend up to 4/3 as much (at the bend, if
/// it lies near either end), for a square root, as where light ends, or a parabola nothing. Twice as much
/// is made room for.
const BETWEEN: f64 = 2.0;

/// The polygon of one ring; see [`Ring`].
#[derive(Clone, Debug)]
pub(super) struct Draft {
    pub center: Moving<f64>,
    pub corners: Vec<Moving<[f64; 2]>>,
}

impl Draft {
    /// Around the outlines at the ring's inner and outer radius.
    pub fn between(inner: &Outline, outer: &Outline) -> Draft {
        Draft {
            center: Moving {
                from: inner.center,
                to: outer.center,
            },
            corners: pairs(&inner.circumscribed(), &outer.circumscribed()),
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
        let reach = reach(a, b, v);
        // A triangle of no area, seen from its own plane, holds nothing.
        let length = v[0].hypot(v[1]);
        let beyond = if reach.is_finite() && reach > 0.0 {
            length * (1.0 - 1.0 / reach)
        } else {
            length
        };
        (i - 1, beyond)
    }

    /// How far the outlines found at each t stick out, for each triangle, mm.
    pub fn gaps<'a>(&self, inside: impl Iterator<Item = (f64, &'a Outline)>) -> Vec<f64> {
        let mut gaps = vec![0.0; self.corners.len() - 1];
        for (t, outline) in inside {
            let points = outline.points.iter().copied().chain(outline.bends());
            for p in points {
                let (i, beyond) = self.beyond(t, [outline.center + p[0], p[1]]);
                gaps[i] = f64::max(gaps[i], beyond);
            }
        }
        gaps
    }

    /// Moves the corners outward so that what sticks out by `gaps` where it was measured (and by
    /// more elsewhere) lies inside.
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
    pairs.map(|(a, b)| Moving { from: *a, to: *b }).collect()
}
