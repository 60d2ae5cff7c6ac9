//! Packets of four triangles, tested side by side ([`super::watertight`]).

use super::node::Cell;
use super::primitive::PrimitiveId;
use super::ray::TraversalRay;
use super::watertight::{Plane, REACH, is_inside_exactly};
use crate::math::Vec3;
use wide::f32x4;

/// Triangles in a packet.
pub(super) const LANES: usize = 4;

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
    fn corners(self, lane: usize) -> [Vec3; 3] {
        let at = |row: usize| {
            let row: &[f32; LANES] = bytemuck::cast_ref(&self.0[row]);
            row[lane & 3]
        };
        let corner = |first: usize| Vec3::new(at(first), at(first + 1), at(first + 2));
        [corner(0), corner(3), corner(6)]
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
            .simd_le(f32x4::splat(t_max * REACH));
        let ahead = z0.fast_max(z1).fast_max(z2).simd_ge(zero);
        // An edge function that is 0 may have either sign, which is computed exactly only where it matters.
        let on_edge = e[0].simd_eq(zero) | e[1].simd_eq(zero) | e[2].simd_eq(zero);
        let near = reached & ahead;
        let (inside, area) = within(e);
        let mut lanes = (inside & (area | on_edge) & near).to_bitmask();
        if lanes == 0 {
            return false;
        }
        let on_edge = on_edge.to_bitmask();
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let corners = self.corners(lane);
            if on_edge >> lane & 1 != 0 && !is_inside_exactly(ray.o, ray.d, corners) {
                continue;
            }
            let t = Plane::of(corners).distance(ray.o, ray.d);
            if t > 0.0 && accept(self.id(lane), t) {
                return true;
            }
        }
        false
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
