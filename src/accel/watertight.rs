//! What the watertight ray-triangle test asks of a single triangle: the distance to it, and which side of an edge a ray passes that seems to
//! meet it.
//!
//! The test is that of Woop, Benthin and Wald ("Watertight Ray/Triangle Intersection", JCGT 2(1), 2013; Pharr, Jakob
//! and Humphreys 2016, §3.6.2): in a space sheared so that the ray is the z axis, the signs of edge functions decide,
//! and both triangles of an edge compute the same one, so no ray slips between them. Where an edge function is 0 its
//! sign is computed in double precision, in which products of single-precision numbers are exact.
//!
//! The distance is then recomputed in double precision. The book's bound on its error in single precision grows with
//! the triangle: comparing with it makes a ground of 1e6 units vanish below a nearby observer, and a ground that is off
//! by 1e-7 of its size would swallow small objects lying on it.

use super::ray::TraversalRay;
use crate::math::{DVec3, Vec3};

/// For rays whose angle with a triangle has a sine below this, the distance comes from the edge functions: the rounding
/// of the sheared coordinates then leaves more uncertainty than the intersection with the plane could resolve.
const GRAZING_SINE: f64 = 1e-6;

/// How much farther than the end of the search corners may be, for the rounding of their distances.
pub(super) const REACH: f32 = 1.0 + 8.0 * f32::EPSILON;

/// A triangle's plane.
#[derive(Clone, Copy)]
pub(super) struct Plane {
    corners: [Vec3; 3],
    /// Twice the triangle's area along its normal.
    n: DVec3,
    /// Rays along which `n` is no longer than the square root of this graze the triangle.
    grazing: f64,
}

impl Plane {
    #[inline(always)]
    pub(super) fn of(corners: [Vec3; 3]) -> Plane {
        let [p, q, r] = corners;
        let (p, q, r) = (p.as_dvec3(), q.as_dvec3(), r.as_dvec3());
        let n = (q - p).cross(r - p);
        Plane {
            corners,
            n,
            grazing: GRAZING_SINE * GRAZING_SINE * n.length_squared(),
        }
    }

    /// Those of the triangle.
    pub(super) fn corners(&self) -> [Vec3; 3] {
        self.corners
    }

    /// Distance along `o + t d`, which is known to cross the triangle inside; negative if that is behind the origin.
    #[inline(always)]
    pub(super) fn distance(&self, o: Vec3, d: Vec3) -> f64 {
        let slope = self.n.dot(d.as_dvec3());
        if slope * slope > self.grazing {
            self.n.dot(self.corners[0].as_dvec3() - o.as_dvec3()) / slope
        } else {
            grazing_distance(o, d, self.corners)
        }
    }
}

/// The distance from the edge functions, for a triangle seen almost edge-on.
#[cold]
fn grazing_distance(o: Vec3, d: Vec3, corners: [Vec3; 3]) -> f64 {
    let p = sheared(o, d, corners);
    let e = edges(p);
    let sum: f64 = e.iter().zip(p).map(|(e, p)| e * p[2]).sum();
    sum / (e[0] + e[1] + e[2])
}

/// Returns `true` if the ray crosses the triangle inside, by edge functions with exact signs. Exactly edge-on it does not.
#[cold]
pub(super) fn is_inside_exactly(o: Vec3, d: Vec3, corners: [Vec3; 3]) -> bool {
    let e = edges(sheared(o, d, corners)).map(|e| e as f32);
    let all = |sign: f32| e.iter().all(|e| e * sign >= 0.0);
    (all(1.0) || all(-1.0)) && e[0] + e[1] + e[2] != 0.0
}

/// Twice the signed areas that the axis z makes with the sides of a triangle.
fn edges(p: [[f64; 3]; 3]) -> [f64; 3] {
    let edge = |a: [f64; 3], b: [f64; 3]| a[0] * b[1] - a[1] * b[0];
    [edge(p[1], p[2]), edge(p[2], p[0]), edge(p[0], p[1])]
}

/// The corners in the ray's sheared space, rounded as the test has them.
fn sheared(o: Vec3, d: Vec3, corners: [Vec3; 3]) -> [[f64; 3]; 3] {
    let ray = TraversalRay::new(o, d);
    let [sx, sy, sz] = ray.shear;
    corners.map(|p| {
        let p = p.to_array();
        let [x, y, z] = [0, 1, 2].map(|k| p[ray.axes[k]] - ray.sheared_o[k]);
        [x + sx * z, y + sy * z, z * sz].map(f64::from)
    })
}
