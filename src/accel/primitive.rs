//! Primitives, which the leaves of a tree refer to.

use super::aabb::Aabb;

/// Primitives other than triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OtherKind {
    Quadric,
    /// An instance of an object, or a moving shape.
    Instance,
    /// A piece of a curve.
    Curve,
}

/// A primitive of one level: its kind, and its index among that kind.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, bytemuck::Pod, bytemuck::Zeroable,
)]
#[repr(transparent)]
pub(super) struct PrimitiveId(u32);

impl PrimitiveId {
    const CUT_OUT: u32 = 1 << 31;
    const OTHER: u32 = 1 << 30;
    /// Lowest bit of the kind of a non-triangle primitive.
    const KIND_SHIFT: u32 = 28;
    /// Maximum number of triangles, and of each other kind, in a tree.
    pub(super) const LIMIT: usize = 1 << Self::KIND_SHIFT;
    /// An unused lane.
    pub(super) const NONE: PrimitiveId = PrimitiveId(u32::MAX);

    pub(super) fn triangle(index: u32, cut_out: bool) -> PrimitiveId {
        PrimitiveId(index | if cut_out { Self::CUT_OUT } else { 0 })
    }

    pub(super) fn other(kind: OtherKind, index: usize) -> PrimitiveId {
        PrimitiveId(index as u32 | Self::OTHER | (kind as u32) << Self::KIND_SHIFT)
    }

    #[inline(always)]
    pub(super) fn is_triangle(self) -> bool {
        self.0 & Self::OTHER == 0
    }

    /// Returns `true` for a non-triangle primitive, and `false` for an unused lane.
    #[inline(always)]
    pub(super) fn is_other(self) -> bool {
        self.0 & (Self::OTHER | Self::CUT_OUT) == Self::OTHER
    }

    /// The kind of a non-triangle primitive.
    #[inline(always)]
    pub(super) fn kind(self) -> OtherKind {
        match self.0 >> Self::KIND_SHIFT & 3 {
            0 => OtherKind::Quadric,
            1 => OtherKind::Instance,
            _ => OtherKind::Curve,
        }
    }

    /// Returns `true` for a triangle with an alpha texture.
    #[inline(always)]
    pub(super) fn is_cut_out(self) -> bool {
        self.0 & Self::CUT_OUT != 0
    }

    /// The index among its kind.
    #[inline(always)]
    pub(super) fn index(self) -> usize {
        (self.0 & (Self::LIMIT as u32 - 1)) as usize
    }
}

/// One primitive for the builder.
#[derive(Clone, Copy)]
pub(super) struct Item {
    pub id: PrimitiveId,
    pub bounds: Aabb,
}
