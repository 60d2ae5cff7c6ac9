//! 8-wide nodes.

use super::aabb::Aabb;
use super::ray::TraversalRay;
use wide::f32x8;

/// Boxes are tested as if they ended this much later. Entering and leaving distances carry three
/// roundings each; the triangle test's sheared coordinates about five, relative to the same
/// differences. Eight units of roundoff and as many again for the other side keep every ray that
/// the triangle test would accept (compare Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013).
pub(super) const FAR_MARGIN: f32 = 1.0 + 8.0 * f32::EPSILON;

/// A reference to a child: the number of a node, or a leaf (top bit) with packets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Child(pub u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    const OTHERS: u32 = 1 << 30;
    const COUNT_SHIFT: u32 = 27;
    /// Packets a tree can hold.
    pub const MAX_PACKETS: usize = 1 << Self::COUNT_SHIFT;

    pub fn node(index: usize) -> Child {
        Child(index as u32)
    }

    /// Packets `first` to `first + count`, 1 ≤ count ≤ 8; `others` where
    /// some lane is no triangle.
    pub fn leaf(first: usize, count: usize, others: bool) -> Child {
        let others = if others { Self::OTHERS } else { 0 };
        Child(Self::LEAF | others | (count as u32 - 1) << Self::COUNT_SHIFT | first as u32)
    }

    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    /// Of a node.
    #[inline(always)]
    pub fn index(self) -> usize {
        self.0 as usize
    }

    /// Of a leaf.
    #[inline(always)]
    pub fn packets(self) -> std::ops::Range<usize> {
        let first = (self.0 & (Self::MAX_PACKETS as u32 - 1)) as usize;
        first..first + 1 + (self.0 >> Self::COUNT_SHIFT & 7) as usize
    }

    /// Of a leaf.
    #[inline(always)]
    pub fn has_others(self) -> bool {
        self.0 & Self::OTHERS != 0
    }
}

/// A node with up to eight children.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Lower and upper planes in each axis, one lane a child.
    pub bounds: [[[f32; 8]; 2]; 3],
    /// Children; the boxes of unused ones are empty.
    pub children: [Child; 8],
}

impl Node {
    pub const WIDTH: usize = 8;

    pub fn empty() -> Node {
        let inside_out = [[f32::INFINITY; 8], [f32::NEG_INFINITY; 8]];
        Node {
            bounds: [inside_out; 3],
            children: [Child(0); 8],
        }
    }

    pub fn set(&mut self, slot: usize, child: Child, bounds: Aabb) {
        self.children[slot] = child;
        for axis in 0..3 {
            self.bounds[axis][0][slot] = bounds.min[axis];
            self.bounds[axis][1][slot] = bounds.max[axis];
        }
    }

    /// Which children's boxes the ray meets between 0 and `t_max`, and where it enters them.
    #[inline(always)]
    pub fn test(&self, ray: &TraversalRay, t_max: f32) -> (u32, [f32; 8]) {
        let plane =
            |axis: usize, side: usize, o: f32x8| (f32x8::new(self.bounds[axis][side]) - o) * ray.inverse[axis];
        let entering = |axis: usize| plane(axis, ray.near_side[axis], ray.near_origin[axis]);
        let leaving = |axis: usize| plane(axis, 1 - ray.near_side[axis], ray.far_origin[axis]);
        let near = entering(0)
            .fast_max(entering(1))
            .fast_max(entering(2).fast_max(f32x8::ZERO));
        let far = leaving(0).fast_min(leaving(1)).fast_min(leaving(2)) * f32x8::splat(FAR_MARGIN);
        let hit = near.simd_le(far.fast_min(f32x8::splat(t_max)));
        (hit.to_bitmask(), near.to_array())
    }
}
