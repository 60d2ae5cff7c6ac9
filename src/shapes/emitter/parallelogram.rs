//! A flat emitter of two triangles, as rectangular lights are made of.
//!
//! Sampled as one piece: its points are spread over the whole light by one pair of numbers, where a choice
//! between the triangles would need a third, and there is one light to choose instead of two.

use super::{AreaPoint, BranchlessEmitter, EmitterSample};
use crate::math::{DVec3, Vec2, Vec3};
use crate::shapes::triangle::Orientation;
use crate::surface::ReferencePoint;

/// How far the fourth corner may be from completing the parallelogram, in units of the largest coordinate:
/// what rounding to single precision leaves. The error box of sampled points covers it.
const CLOSURE: f64 = 4.0 * f32::EPSILON as f64;

/// Two triangles that share an edge and make a parallelogram.
#[derive(Clone, Copy, Debug)]
pub struct ParallelogramEmitter {
    /// The corner that both edges start from, render space.
    corner: DVec3,
    edges: [DVec3; 2],
    /// Unit normal of the side that shines.
    n: DVec3,
    /// Area in render space.
    pub(super) area: f64,
    /// See [`super::EmitterSample::p_error`].
    error: DVec3,
}

impl ParallelogramEmitter {
    /// From two triangles with their corners in order; `None` where they are no parallelogram, or have no area.
    pub(super) fn of_triangles(
        a: [Vec3; 3],
        b: [Vec3; 3],
        orientation: Orientation,
    ) -> Option<ParallelogramEmitter> {
        // The corner of the first that the second has not got, and the other way round.
        let alone = a.iter().position(|p| !b.contains(p))?;
        let opposite = *b.iter().find(|p| !a.contains(p))?;
        let [corner, next, last] = [0, 1, 2].map(|i| a[(alone + i) % 3].as_dvec3());
        let edges = [next - corner, last - corner];
        let cross = edges[0].cross(edges[1]);
        // Both must turn the same way, or one of them shines from the other side.
        let [p, q, r] = b.map(Vec3::as_dvec3);
        let largest = [corner, next, last, opposite.as_dvec3()]
            .into_iter()
            .fold(DVec3::ZERO, |m, p| m.max(p.abs()));
        let gap = (next + last - corner - opposite.as_dvec3()).abs();
        let closes = gap.max_element() <= CLOSURE * largest.max_element();
        let area = cross.length();
        if !closes || !area.is_finite() || area == 0.0 || (q - p).cross(r - p).dot(cross) <= 0.0 {
            return None;
        }
        Some(ParallelogramEmitter {
            corner,
            edges,
            n: orientation.geometric(cross * area.recip()),
            area,
            error: largest * (8.0 * f64::EPSILON) + gap,
        })
    }

    #[inline(always)]
    pub(super) fn point(&self, u: Vec2) -> AreaPoint {
        AreaPoint {
            p: self.corner + self.edges[0] * f64::from(u.x) + self.edges[1] * f64::from(u.y),
            error: self.error,
            n: self.n,
            area: self.area,
        }
    }
}

impl BranchlessEmitter for ParallelogramEmitter {
    #[inline(always)]
    fn sample(&self, from: &ReferencePoint, u: Vec2) -> (EmitterSample, bool) {
        self.point(u).seen(from)
    }
}
