//! A ring's region while it is being made: corners that are pushed outward until nothing is left out.

use super::outline::{Outline, cross, reach};
use super::region::Region;
use super::ring::{Moving, Ring};

/// Every corner is moved outward by this part of its distance from the middle: covers what the
/// outlines' own precision (1e-5) and the bends between neighboring directions and radii leave. Costs 0.2 % of
/// the rays.
const MARGIN: f64 = 1e-3;

/// Between the two ends of a ring the region may stick out of the straight lines that join them by more
/// than it does a quarter, half and three quarters of the way: for a bend up to 4/3 as much (at the bend, if
/// it lies near either end), for a square root, as where light ends, or a parabola nothing. Twice as much
/// is made room for.
const BETWEEN: f64 = 2.0;

/// Triangles' areas at a ring's ends differ by less than this part of them ...
const UNEVEN: f64 = 1e-4;

/// ... or as much as these attempts leave.
const ATTEMPTS: usize = 4;

/// The polygon of one ring; see [`Ring`].
#[derive(Clone, Debug)]
pub(super) struct Draft {
    pub center: Moving<f64>,
    pub corners: Vec<Moving<[f64; 2]>>,
}

impl Draft {
    /// Around the outlines at the ring's inner and outer radius, and what sticks out of the straight lines between them at
    /// the outlines `inside`, each with its t. At both ends all triangles have the same area, to [`UNEVEN`].
    pub(super) fn between<'a>(
        ends: [&Outline; 2],
        inside: impl Iterator<Item = (f64, &'a Outline)> + Clone,
    ) -> Draft {
        let hulls = ends.map(|o| &o.hull);
        let mut shares = ends.map(|o| vec![1.0; o.points.len() - 1]);
        let mut attempt = 0;
        loop {
            let [from, to] = [0, 1].map(|end| divided(hulls[end], &shares[end]));
            let mut draft = Draft {
                center: Moving {
                    from: ends[0].center,
                    to: ends[1].center,
                },
                corners: pairs(&from, &to),
            };
            let gaps = draft.gaps(inside.clone());
            draft.fill(&gaps);
            draft.grow();
            // What was filled has made some triangles larger: they are cut smaller next time.
            let uneven = [0, 1].map(|end| draft.even_out(&mut shares[end], end as f64));
            attempt += 1;
            if attempt == ATTEMPTS || uneven[0].max(uneven[1]) < UNEVEN {
                return draft;
            }
        }
    }

    /// Divides each share by the area of its triangle at `t`, relative to the mean, which is how much too large it
    /// is. How far the areas are from even.
    fn even_out(&self, shares: &mut [f64], t: f64) -> f64 {
        let areas: Vec<f64> = self
            .corners
            .windows(2)
            .map(|c| cross(c[0].at(t), c[1].at(t)))
            .collect();
        let mean = areas.iter().sum::<f64>() / areas.len() as f64;
        let mut worst = 0.0f64;
        for (share, area) in shares.iter_mut().zip(areas) {
            let excess = area / mean;
            if excess > 0.0 && excess.is_finite() {
                *share /= excess;
                worst = worst.max((excess - 1.0).abs());
            }
        }
        worst
    }

    /// Around an ellipse at the inner, and one at the outer radius.
    pub(super) fn of_ellipses(inner: &Region, outer: &Region) -> Draft {
        let corners = |e: &Region| e.corners().collect::<Vec<_>>();
        Draft {
            center: Moving {
                from: inner.center,
                to: outer.center,
            },
            corners: pairs(&corners(inner), &corners(outer)),
        }
    }

    /// In mm², at `t`.
    pub(super) fn area(&self, t: f64) -> f64 {
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
    pub(super) fn beyond(&self, t: f64, p: [f64; 2]) -> (usize, f64) {
        let v = [p[0] - self.center.at(t), p[1].abs()];
        let last = self.corners.len() - 1;
        let i = self
            .corners
            .partition_point(|c| cross(c.at(t), v) >= 0.0)
            .clamp(1, last);
        let (a, b) = (self.corners[i - 1].at(t), self.corners[i].at(t));
        (i - 1, beyond(a, b, v))
    }

    /// How far the outlines found at each t stick out, for each triangle, mm.
    fn gaps<'a>(&self, inside: impl Iterator<Item = (f64, &'a Outline)>) -> Vec<f64> {
        let mut gaps = vec![0.0; self.corners.len() - 1];
        let mut corners = Vec::with_capacity(self.corners.len());
        for (t, outline) in inside {
            corners.clear();
            corners.extend(self.corners.iter().map(|c| c.at(t)));
            let shift = outline.center - self.center.at(t);
            // Points come in the order of their directions, or nearly: each is sought from the last one's triangle.
            let mut i = 1;
            for p in outline.points.iter().chain(&outline.bends) {
                let v = [shift + p[0], p[1]];
                while i + 1 < corners.len() && cross(corners[i], v) > 0.0 {
                    i += 1;
                }
                while i > 1 && cross(corners[i - 1], v) < 0.0 {
                    i -= 1;
                }
                gaps[i - 1] = f64::max(gaps[i - 1], beyond(corners[i - 1], corners[i], v));
            }
        }
        gaps
    }

    /// Moves the corners outward so that what sticks out by `gaps` where it was measured (and by
    /// more elsewhere) lies inside.
    pub(super) fn fill(&mut self, gaps: &[f64]) {
        let last = self.corners.len() - 1;
        for i in 0..=last {
            // A bend may lie in a neighboring triangle at another radius.
            let near = &gaps[i.saturating_sub(2)..(i + 2).min(last)];
            let gap = near.iter().copied().fold(0.0, f64::max);
            self.push(i, BETWEEN * gap);
        }
    }

    /// Moves every corner outward by the margin.
    pub(super) fn grow(&mut self) {
        for c in &mut self.corners {
            c.from = c.from.map(|x| (1.0 + MARGIN) * x);
            c.to = c.to.map(|x| (1.0 + MARGIN) * x);
        }
    }

    /// Moves the corners of triangle `i` outward by `length` mm, at all radii.
    pub(super) fn push_side(&mut self, i: usize, length: f64) {
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
    pub(super) fn finish(&self, radii: [f64; 2]) -> Option<Ring> {
        Ring::new(radii, self.center, &self.corners)
    }
}

/// How far `v`, in a direction between `a` and `b`, is beyond the line through them; negative on this side.
fn beyond(a: [f64; 2], b: [f64; 2], v: [f64; 2]) -> f64 {
    let reach = reach(a, b, v);
    let length = (v[0] * v[0] + v[1] * v[1]).sqrt();
    // A triangle of no area, seen from its own plane, holds nothing.
    if reach.is_finite() && reach > 0.0 {
        length * (1.0 - 1.0 / reach)
    } else {
        length
    }
}

/// A polygon around `hull` (corners of the half with y ≥ 0) whose triangles' areas are in the proportions of `shares`,
/// to first order.
fn divided(hull: &[[f64; 2]], shares: &[f64]) -> Vec<[f64; 2]> {
    let total: f64 = hull.windows(2).map(|p| cross(p[0], p[1])).sum();
    let per_share = total / shares.iter().sum::<f64>();
    let last = hull.len() - 1;
    let mut corners = vec![hull[0]];
    let mut factors = vec![1.0f64; shares.len() + 1];
    // The side of the hull that is being gone along, and how much area lies before it.
    let (mut side, mut before, mut wanted) = (0, 0.0, 0.0);
    let mut passed = Vec::new();
    for (i, share) in shares.iter().enumerate() {
        wanted += share * per_share;
        let area = |side: usize| cross(hull[side], hull[side + 1]);
        while side + 1 < last && before + area(side) < wanted {
            before += area(side);
            side += 1;
            passed.push(hull[side]);
        }
        let corner = if i + 1 == shares.len() {
            passed.extend(&hull[side + 1..last]);
            hull[last]
        } else {
            let (a, b) = (hull[side], hull[side + 1]);
            let s = ((wanted - before) / area(side)).clamp(0.0, 1.0);
            let s = if s.is_nan() { 0.0 } else { s };
            [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])]
        };
        // Corners of the hull between two of the new ones lie outside the line between these.
        for p in passed.drain(..) {
            let factor = reach(corners[i], corner, p);
            if factor.is_finite() {
                factors[i] = factors[i].max(factor);
                factors[i + 1] = factors[i + 1].max(factor);
            }
        }
        corners.push(corner);
    }
    let moved = corners.iter().zip(factors);
    moved.map(|(p, f)| p.map(|x| f * x)).collect()
}

fn pairs(from: &[[f64; 2]], to: &[[f64; 2]]) -> Vec<Moving<[f64; 2]>> {
    let pairs = from.iter().zip(to);
    pairs.map(|(a, b)| Moving { from: *a, to: *b }).collect()
}
