//! 8-wide nodes, and the cells that a tree is stored in.
//!
//! A tree is one array of cells of eight single-precision numbers. A node takes seven: its children's lower and upper
//! planes in x, y and z, one lane per child, and the bits of the references to them. The leaves of a node follow it
//! directly, so that they share its page of memory.

use super::aabb::Aabb;
use super::ray::TraversalRay;
use crate::math::Vec3;
use wide::f32x8;

/// 32 bytes of a tree.
pub(super) type Cell = f32x8;

/// Depth up to which the structure of the binary tree is kept. Deeper subtrees (thousands of primitives in one place)
/// are split evenly, which takes at most 11 levels for 2³² primitives, and one more where leaves would mix triangles
/// and others.
pub(super) const MAX_DEPTH: usize = 32;

/// A reference to a node, to a packet of triangles or to a cell of other primitives: a cell index, relative to the
/// referring node or absolute.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub(super) struct Child(u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    const OTHERS: u32 = 1 << 30;
    /// Maximum number of cells in a tree.
    pub(super) const MAX_CELLS: usize = 1 << 30;

    /// A node.
    #[inline(always)]
    pub(super) fn node(offset: usize) -> Child {
        Child(offset as u32)
    }

    /// A packet of triangles.
    pub(super) fn triangles(offset: usize) -> Child {
        Child(Self::LEAF | offset as u32)
    }

    /// Non-triangle primitives.
    pub(super) fn others(offset: usize) -> Child {
        Child(Self::LEAF | Self::OTHERS | offset as u32)
    }

    #[inline(always)]
    pub(super) fn from_bits(bits: u32) -> Child {
        Child(bits)
    }

    #[inline(always)]
    pub(super) fn bits(self) -> u32 {
        self.0
    }

    /// The absolute reference for one relative to the node in cell `parent`.
    #[inline(always)]
    pub(super) fn seen_from(self, parent: usize) -> Child {
        Child(self.0.wrapping_add(parent as u32))
    }

    #[inline(always)]
    pub(super) fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    /// Returns `true` if the leaf holds non-triangle primitives.
    #[inline(always)]
    pub(super) fn has_others(self) -> bool {
        self.0 & Self::OTHERS != 0
    }

    #[inline(always)]
    pub(super) fn offset(self) -> usize {
        (self.0 & (Self::MAX_CELLS as u32 - 1)) as usize
    }
}

/// A node with up to eight children, under construction.
pub(super) struct Node {
    /// Lower and upper planes in each axis; the boxes of unused children are empty.
    bounds: [[[f32; 8]; 2]; 3],
    children: [Child; 8],
}

impl Node {
    pub(super) const WIDTH: usize = 8;
    /// Number of cells in a node.
    pub(super) const CELLS: usize = 7;

    pub(super) fn empty() -> Node {
        Node {
            bounds: [[[f32::INFINITY; 8], [f32::NEG_INFINITY; 8]]; 3],
            children: [Child(0); 8],
        }
    }

    /// Sets a child, whose reference is relative to this node.
    pub(super) fn set(&mut self, slot: usize, child: Child, bounds: Aabb) {
        self.children[slot] = child;
        for axis in 0..3 {
            self.bounds[axis][0][slot] = bounds.min[axis];
            self.bounds[axis][1][slot] = bounds.max[axis];
        }
    }

    pub(super) fn cells(&self) -> [Cell; Node::CELLS] {
        let [x, y, z] = self.bounds.map(|axis| axis.map(f32x8::new));
        let children = bytemuck::cast(self.children.map(Child::bits));
        [x[0], x[1], y[0], y[1], z[0], z[1], children]
    }
}

/// A node as it is stored.
#[derive(Clone, Copy)]
pub(super) struct StoredNode<'a>(&'a [Cell; Node::CELLS]);

impl<'a> StoredNode<'a> {
    /// The node that starts with the first of these cells.
    #[inline(always)]
    pub(super) fn first_of(cells: &'a [Cell]) -> Option<StoredNode<'a>> {
        cells.first_chunk().map(StoredNode)
    }

    /// The children's lower (`side` 0) or upper (1) planes in an axis.
    #[inline(always)]
    pub(super) fn planes(self, axis: usize, side: usize) -> &'a Cell {
        &self.0[2 * axis + (side & 1)]
    }

    /// The box of the child in `slot` (modulo 8); empty if there is none.
    pub(super) fn bounds(self, slot: usize) -> Aabb {
        let corner = |side: usize| {
            let at = |axis: usize| self.planes(axis, side).to_array()[slot & 7];
            Vec3::new(at(0), at(1), at(2))
        };
        Aabb {
            min: corner(0),
            max: corner(1),
        }
    }

    /// The bits of all child references.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    pub(super) fn children(self) -> &'a Cell {
        &self.0[6]
    }

    /// The child in `slot` (modulo 8), relative to the node.
    #[inline(always)]
    pub(super) fn child(self, slot: usize) -> Child {
        let children: &[u32; 8] = bytemuck::cast_ref(&self.0[6]);
        Child(children[slot & 7])
    }

    /// Which children's boxes the ray intersects between 0 and `t_max` (a bit mask), and where it enters them.
    #[inline(always)]
    pub(super) fn test(self, ray: &TraversalRay, t_max: f32) -> (u32, [f32; 8]) {
        let entering = |axis: usize| {
            let planes = *self.planes(axis, ray.near_side[axis]);
            (planes - f32x8::splat(ray.near_origin[axis])) * f32x8::splat(ray.inverse[axis])
        };
        let leaving = |axis: usize| {
            let planes = *self.planes(axis, 1 - ray.near_side[axis]);
            (planes - f32x8::splat(ray.far_origin[axis])) * f32x8::splat(ray.far_inverse[axis])
        };
        let near = entering(0)
            .fast_max(entering(1))
            .fast_max(entering(2).fast_max(f32x8::ZERO));
        let far = leaving(0).fast_min(leaving(1)).fast_min(leaving(2));
        let hit = near.simd_le(far.fast_min(f32x8::splat(t_max)));
        (hit.to_bitmask(), near.to_array())
    }
}

/// The children of a node that a ray may hit.
pub(super) struct NodeHits<'a> {
    pub node: StoredNode<'a>,
    /// The node's cell.
    pub at: usize,
    /// A bit per child, at least one of them set.
    pub mask: u32,
    /// Where the ray enters the boxes.
    pub near: [f32; 8],
}

impl NodeHits<'_> {
    /// The child in `slot` (modulo 8).
    #[inline(always)]
    pub(super) fn child(&self, slot: u32) -> Child {
        self.node.child(slot as usize).seen_from(self.at)
    }

    /// Compresses the children in these slots to the front; the remaining entries are unspecified.
    #[inline(always)]
    pub(super) fn compress(&self, mut slots: u32) -> [Child; Node::WIDTH] {
        let mut children = [Child::node(0); Node::WIDTH];
        let mut count = 0;
        while slots != 0 {
            children[count & 7] = self.child(slots.trailing_zeros());
            count += 1;
            slots &= slots - 1;
        }
        children
    }
}
