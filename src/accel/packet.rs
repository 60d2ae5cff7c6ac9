//! Packets of four triangles and the watertight ray-triangle test.
//!
//! The test is that of Woop, Benthin and Wald ("Watertight Ray/Triangle Intersection", JCGT 2(1), 2013; Pharr, Jakob
//! and Humphreys 2016, §3.6.2): in a space sheared so that the ray is the z axis, the signs of edge functions decide,
//! and both triangles of an edge compute the same one, so no ray slips between them. Where an edge function is 0 its
//! sign is computed in double precision, in which products of single-precision numbers are exact.
//!
//! The distance is then recomputed in double precision. The book's bound on its error in single precision grows with
//! the triangle: comparing with it makes a ground of 1e6 units vanish below a nearby observer, and a ground that is off
//! by 1e-7 of its size would swallow small objects lying on it.

use super::node::Cell;
use super::primitive::PrimitiveId;
use super::ray::TraversalRay;
use crate::math::{DVec3, Vec3};
use wide::f32x4;

/// Triangles in a packet.
pub(super) const LANES: usize = 4;

/// For rays whose angle with a triangle has a sine below this, the distance comes from the edge functions: the rounding
/// of the sheared coordinates then leaves more uncertainty than the intersection with the plane could resolve.
const GRAZING_SINE: f64 = 1e-6;

/// Up to four triangles, under construction. Unused lanes hold NaN, which no test accepts.
pub(super) struct Packet {
    /// Coordinates by corner and axis, then the bits of the lanes' primitive ids.
    rows: [[f32; LANES]; Packet::ROWS],
}

impl Packet {
    const ROWS: usize = 10;
    const IDS: usize = 9;
    /// Number of cells in a packet.
    pub(super) const CELLS: usize = Self::ROWS * LANES / 8;

    pub(super) fn empty() -> Packet {
        let mut rows = [[f32::NAN; LANES]; Packet::ROWS];
        rows[Self::IDS] = bytemuck::cast([PrimitiveId::NONE; LANES]);
        Packet { rows }
    }

    pub(super) fn set_triangle(&mut self, lane: usize, id: PrimitiveId, corners: [Vec3; 3]) {
        self.rows[Self::IDS][lane] = bytemuck::cast(id);
        for (rows, p) in self.rows.chunks_exact_mut(3).zip(corners) {
            for (row, x) in rows.iter_mut().zip(p.to_array()) {
                row[lane] = x;
            }
        }
    }

    pub(super) fn cells(&self) -> [Cell; Packet::CELLS] {
        bytemuck::cast(self.rows)
    }
}

/// A packet as it is stored.
#[derive(Clone, Copy)]
pub(super) struct StoredPacket<'a>(&'a [f32x4; Packet::ROWS]);

impl<'a> StoredPacket<'a> {
    /// The packet that starts with the first of these cells.
    #[inline(always)]
    pub(super) fn first_of(cells: &'a [Cell]) -> Option<StoredPacket<'a>> {
        let cells = cells.first_chunk::<{ Packet::CELLS }>()?;
        Some(StoredPacket(bytemuck::cast_ref(cells)))
    }

    /// The primitive in `lane` (modulo 4).
    #[inline(always)]
    pub(super) fn id(self, lane: usize) -> PrimitiveId {
        let ids: &[PrimitiveId; LANES] = bytemuck::cast_ref(&self.0[Packet::IDS]);
        ids[lane & 3]
    }

    /// Coordinates of a corner in an axis (modulo 4; the fourth is not an axis).
    #[inline(always)]
    fn row(self, corner: usize, axis: usize) -> f32x4 {
        self.0[3 * corner + (axis & 3)]
    }

    #[inline(always)]
    fn corner(self, corner: usize, lane: usize) -> DVec3 {
        let at = |axis: usize| {
            let row: &[f32; LANES] = bytemuck::cast_ref(&self.0[3 * corner + axis]);
            f64::from(row[lane & 3])
        };
        DVec3::new(at(0), at(1), at(2))
    }

    /// Calls `accept(id, t)` for every triangle that the ray intersects at 0 < t, possibly at or beyond `t_max`, until
    /// it returns `true`.
    #[inline(always)]
    pub(super) fn test(
        self,
        ray: &TraversalRay,
        t_max: f32,
        mut accept: impl FnMut(PrimitiveId, f64) -> bool,
    ) -> bool {
        let [ax, ay, az] = ray.axes;
        let [sx, sy, sz] = ray.shear.map(f32x4::splat);
        let [ox, oy, oz] = ray.sheared_o.map(f32x4::splat);
        let sheared = |corner: usize| {
            let z = self.row(corner, az) - oz;
            let x = self.row(corner, ax) - ox + sx * z;
            let y = self.row(corner, ay) - oy + sy * z;
            (x, y, z * sz)
        };
        // Written out: `array::map` is not inlined here, which cost a fifth of the time.
        let (x0, y0, z0) = sheared(0);
        let (x1, y1, z1) = sheared(1);
        let (x2, y2, z2) = sheared(2);
        let e = [x1 * y2 - y1 * x2, x2 * y0 - y2 * x0, x0 * y1 - y0 * x1];
        let zero = f32x4::ZERO;
        // z holds the distances of the corners, and the intersection is between them.
        let reached = z0
            .fast_min(z1)
            .fast_min(z2)
            .simd_le(f32x4::splat(t_max * (1.0 + 8.0 * f32::EPSILON)));
        let ahead = z0.fast_max(z1).fast_max(z2).simd_ge(zero);
        // An edge function that is 0 may have either sign, which is computed exactly only where it matters.
        let on_edge = e[0].simd_eq(zero) | e[1].simd_eq(zero) | e[2].simd_eq(zero);
        let near = reached & ahead;
        let (inside, area) = within(e);
        let mut lanes = (inside & (area | on_edge) & near).to_bitmask();
        if lanes == 0 {
            return false;
        }
        if lanes & on_edge.to_bitmask() != 0 {
            let (inside, area) = within(exact_edges([x0, x1, x2], [y0, y1, y2]));
            lanes = (inside & area & near).to_bitmask();
        }
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let t = self.distance(ray, lane);
            if t > 0.0 && accept(self.id(lane), t) {
                return true;
            }
        }
        false
    }

    /// Distance to the plane of the triangle in `lane`, which the ray is known to cross inside; negative if that is
    /// behind the origin.
    #[inline(always)]
    fn distance(self, ray: &TraversalRay, lane: usize) -> f64 {
        let p = self.corner(0, lane);
        let n = (self.corner(1, lane) - p).cross(self.corner(2, lane) - p);
        let slope = n.dot(ray.d.as_dvec3());
        if slope * slope > GRAZING_SINE * GRAZING_SINE * n.length_squared() {
            n.dot(p - ray.o.as_dvec3()) / slope
        } else {
            self.grazing_distance(ray, lane)
        }
    }

    /// The distance from the edge functions, for a triangle seen almost edge-on.
    #[cold]
    fn grazing_distance(self, ray: &TraversalRay, lane: usize) -> f64 {
        let [ax, ay, az] = ray.axes;
        let [sx, sy, sz] = ray.shear;
        let [ox, oy, oz] = ray.sheared_o;
        let sheared = |corner: usize| {
            let at = |axis: usize| self.row(corner, axis).to_array()[lane & 3];
            let z = at(az) - oz;
            let (x, y) = (at(ax) - ox + sx * z, at(ay) - oy + sy * z);
            [x, y, z * sz].map(f64::from)
        };
        let p = [0, 1, 2].map(sheared);
        let edge = |a: [f64; 3], b: [f64; 3]| a[0] * b[1] - a[1] * b[0];
        let e = [edge(p[1], p[2]), edge(p[2], p[0]), edge(p[0], p[1])];
        let sum: f64 = e.iter().zip(p).map(|(e, p)| e * p[2]).sum();
        sum / (e[0] + e[1] + e[2])
    }
}

/// Lanes where the ray is inside by the edge functions, and those where these are not all 0: exactly edge-on, there is
/// no intersection.
#[inline(always)]
fn within(e: [f32x4; 3]) -> (f32x4, f32x4) {
    let zero = f32x4::ZERO;
    let least = e[0].fast_min(e[1]).fast_min(e[2]);
    let most = e[0].fast_max(e[1]).fast_max(e[2]);
    let area = (e[0] + e[1] + e[2]).simd_ne(zero);
    (least.simd_ge(zero) | most.simd_le(zero), area)
}

/// The edge functions from sheared coordinates, with exact signs.
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
