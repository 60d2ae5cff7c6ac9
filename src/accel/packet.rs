//! Four triangles side by side and the watertight test for them.
//!
//! The test is that of Woop, Benthin and Wald ("Watertight Ray/Triangle Intersection", JCGT 2(1),
//! 2013; Pharr, Jakob and Humphreys 2016, §3.6.2): in a space sheared so that the ray is the z
//! axis, signs of edge functions decide, and both triangles of an edge compute the same one, so no
//! ray slips between them. Where an edge function is 0 its sign is taken in double precision, in
//! which products of single-precision numbers are exact.
//!
//! The distance is then computed anew in double precision. The bound of the book on its error in
//! single precision grows with the triangle, so that comparing with it makes a ground of 1e6 units
//! vanish under the feet of whoever stands on it; and a ground that is off by 1e-7 of its size
//! would swallow small things lying on it.

use super::ray::TraversalRay;
use crate::math::{DVec3, Vec3};
use wide::f32x4;

/// Lanes of a packet.
pub(super) const LANES: usize = 4;

/// Rays that make an angle with a triangle whose sine is below this take the distance from the
/// edge functions: what the sheared coordinates' rounding leaves open is then more than what the
/// meeting with the plane could tell.
const GRAZING_SINE: f64 = 1e-6;

/// What a lane may refer to besides triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OtherKind {
    Quadric,
    Instance,
    /// A piece of a curve.
    Curve,
    /// An object that moves.
    Moving,
}

/// What a lane refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PrimitiveId(u32);

impl PrimitiveId {
    const CUT_OUT: u32 = 1 << 31;
    const OTHER: u32 = 1 << 30;
    /// Where the kind of what is no triangle stands.
    const KIND_SHIFT: u32 = 28;
    /// How many triangles, and how many of each other kind, a tree can hold.
    pub const LIMIT: usize = 1 << Self::KIND_SHIFT;
    /// An unused lane.
    pub const NONE: PrimitiveId = PrimitiveId(u32::MAX);

    pub fn triangle(index: u32, cut_out: bool) -> PrimitiveId {
        PrimitiveId(index | if cut_out { Self::CUT_OUT } else { 0 })
    }

    pub fn other(kind: OtherKind, index: usize) -> PrimitiveId {
        PrimitiveId(index as u32 | Self::OTHER | (kind as u32) << Self::KIND_SHIFT)
    }

    #[inline(always)]
    pub fn is_triangle(self) -> bool {
        self.0 & Self::OTHER == 0
    }

    /// No triangle, and not an unused lane.
    #[inline(always)]
    pub fn is_other(self) -> bool {
        self.0 & (Self::OTHER | Self::CUT_OUT) == Self::OTHER
    }

    /// Of what is no triangle.
    #[inline(always)]
    pub fn kind(self) -> OtherKind {
        match self.0 >> Self::KIND_SHIFT & 3 {
            0 => OtherKind::Quadric,
            1 => OtherKind::Instance,
            2 => OtherKind::Curve,
            _ => OtherKind::Moving,
        }
    }

    /// A triangle with an alpha texture.
    #[inline(always)]
    pub fn is_cut_out(self) -> bool {
        self.0 & Self::CUT_OUT != 0
    }

    /// Among its kind.
    #[inline(always)]
    pub fn index(self) -> usize {
        (self.0 & (Self::LIMIT as u32 - 1)) as usize
    }
}

/// Up to four triangles. Lanes without one hold NaN, which no test accepts.
#[derive(Clone, Copy)]
pub(super) struct Packet {
    /// Coordinates by corner and axis.
    corners: [[f32x4; 3]; 3],
    /// What the lanes are.
    pub ids: [PrimitiveId; LANES],
}

impl Packet {
    pub fn empty() -> Packet {
        Packet {
            corners: [[f32x4::splat(f32::NAN); 3]; 3],
            ids: [PrimitiveId::NONE; LANES],
        }
    }

    pub fn set_triangle(&mut self, lane: usize, id: PrimitiveId, corners: [Vec3; 3]) {
        self.ids[lane] = id;
        for (of_corner, p) in self.corners.iter_mut().zip(corners) {
            for (axis, values) in of_corner.iter_mut().enumerate() {
                values.as_mut_array()[lane] = p[axis];
            }
        }
    }

    fn corner(&self, corner: usize, lane: usize) -> DVec3 {
        let [x, y, z] = &self.corners[corner];
        let at = |v: &f32x4| f64::from(v.to_array()[lane]);
        DVec3::new(at(x), at(y), at(z))
    }

    /// Calls `accept(lane, t)` for every triangle that the ray meets at 0 < t, possibly at or
    /// beyond `t_max`, until it returns true.
    #[inline(always)]
    pub fn test(
        &self,
        ray: &TraversalRay,
        t_max: f32,
        mut accept: impl FnMut(usize, f64) -> bool,
    ) -> bool {
        let [ax, ay, az] = ray.axes;
        let (sx, sy, sz) = (
            f32x4::splat(ray.shear[0]),
            f32x4::splat(ray.shear[1]),
            f32x4::splat(ray.shear[2]),
        );
        let (ox, oy, oz) = (
            f32x4::splat(ray.o[ax]),
            f32x4::splat(ray.o[ay]),
            f32x4::splat(ray.o[az]),
        );
        let sheared = |c: &[f32x4; 3]| {
            let z = c[az] - oz;
            (c[ax] - ox + sx * z, c[ay] - oy + sy * z, z * sz)
        };
        // Written out: `array::map` is not inlined here, which cost a fifth of the time.
        let (x0, y0, z0) = sheared(&self.corners[0]);
        let (x1, y1, z1) = sheared(&self.corners[1]);
        let (x2, y2, z2) = sheared(&self.corners[2]);
        let mut e = [x1 * y2 - y1 * x2, x2 * y0 - y2 * x0, x0 * y1 - y0 * x1];
        let zero = f32x4::ZERO;
        if (e[0].simd_eq(zero) | e[1].simd_eq(zero) | e[2].simd_eq(zero)).any() {
            e = exact_edges([x0, x1, x2], [y0, y1, y2]);
        }
        let positive = e[0].simd_ge(zero) & e[1].simd_ge(zero) & e[2].simd_ge(zero);
        let negative = e[0].simd_le(zero) & e[1].simd_le(zero) & e[2].simd_le(zero);
        // z are the distances of the corners, and the meeting point is between them.
        let reached = z0
            .fast_min(z1)
            .fast_min(z2)
            .simd_le(f32x4::splat(t_max * (1.0 + 8.0 * f32::EPSILON)));
        let ahead = z0.fast_max(z1).fast_max(z2).simd_ge(zero);
        let mut lanes = ((positive | negative) & reached & ahead).to_bitmask();
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let [e0, e1, e2] = &e;
            let weights = [
                e0.to_array()[lane],
                e1.to_array()[lane],
                e2.to_array()[lane],
            ];
            let depths = [
                z0.to_array()[lane],
                z1.to_array()[lane],
                z2.to_array()[lane],
            ];
            if let Some(t) = self.distance(ray, lane, weights, depths)
                && accept(lane, t)
            {
                return true;
            }
        }
        false
    }

    /// Distance to the plane of the triangle in `lane`, which the ray is known to cross inside.
    /// `None` where that is behind the origin or the triangle is seen exactly edge-on.
    #[inline]
    fn distance(
        &self,
        ray: &TraversalRay,
        lane: usize,
        weights: [f32; 3],
        depths: [f32; 3],
    ) -> Option<f64> {
        let determinant = weights[0] + weights[1] + weights[2];
        if determinant == 0.0 {
            return None;
        }
        let p = self.corner(0, lane);
        let n = (self.corner(1, lane) - p).cross(self.corner(2, lane) - p);
        let slope = n.dot(ray.d.as_dvec3());
        let t = if slope * slope > GRAZING_SINE * GRAZING_SINE * n.length_squared() {
            n.dot(p - ray.o.as_dvec3()) / slope
        } else {
            let sum: f32 = weights.iter().zip(depths).map(|(w, z)| w * z).sum();
            f64::from(sum / determinant)
        };
        (t > 0.0).then_some(t)
    }
}

/// The edge functions from sheared coordinates with exact signs.
#[cold]
fn exact_edges(x: [f32x4; 3], y: [f32x4; 3]) -> [f32x4; 3] {
    let (x, y) = (x.map(|x| x.to_array()), y.map(|y| y.to_array()));
    let edge = |i: usize, j: usize| {
        f32x4::new(std::array::from_fn(|lane| {
            let forward = f64::from(x[i][lane]) * f64::from(y[j][lane]);
            let backward = f64::from(y[i][lane]) * f64::from(x[j][lane]);
            (forward - backward) as f32
        }))
    };
    [edge(1, 2), edge(2, 0), edge(0, 1)]
}
