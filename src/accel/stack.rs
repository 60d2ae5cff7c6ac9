//! The traversal stack: child nodes still to be visited, and the order in which a node's children are visited.

use super::box_test::{compress, prefetch};
use super::node::{Cell, Child, MAX_DEPTH, Node, NodeHits};
use crate::math::instruction_set::Instructions;
use arrayvec::ArrayVec;

/// Every level leaves at most seven siblings on the stack, and the last one eight; below [`MAX_DEPTH`], trees are split
/// evenly, which takes at most 11 levels for 2³² primitives, and one more where leaves would mix triangles and others.
const DEPTH: usize = (MAX_DEPTH + 12) * (Node::WIDTH - 1) + Node::WIDTH;

/// Removes and returns the first hit.
#[inline(always)]
fn take(hits: &mut NodeHits) -> StackEntry {
    let slot = hits.mask.trailing_zeros();
    hits.mask &= hits.mask.wrapping_sub(1);
    StackEntry::new(hits.child(slot), hits.near[slot as usize & 7])
}

/// The order in which a ray visits nodes.
pub(super) trait Order: Default {
    /// Returns the child to visit next and pushes the others.
    fn choose(&mut self, with: impl Instructions, hits: NodeHits, cells: &[Cell]) -> Child;
    /// Pops the next child that is not beyond `t_max`.
    fn pop(&mut self, t_max: f32) -> Option<Child>;
}

/// Nearest child first: for the closest hit.
#[derive(Default)]
pub(super) struct NearestFirst(ArrayVec<StackEntry, DEPTH>);

impl Order for NearestFirst {
    #[inline(always)]
    fn choose(&mut self, _: impl Instructions, mut hits: NodeHits, cells: &[Cell]) -> Child {
        let mut nearest = take(&mut hits);
        if hits.mask == 0 {
            return nearest.child();
        }
        prefetch(cells, nearest.child().offset());
        let other = take(&mut hits);
        prefetch(cells, other.child().offset());
        let base = self.0.len();
        // There is room here and below: see `DEPTH`.
        let _ = self.0.try_push(nearest.max(other));
        nearest = nearest.min(other);
        while hits.mask != 0 {
            let other = take(&mut hits);
            prefetch(cells, other.child().offset());
            let farther = nearest.max(other);
            nearest = nearest.min(other);
            // Insertion sort: there are seldom more than four. (Sorting all eight in an AVX-512 register, without
            // branches, took 5 % more time.)
            let mut i = self.0.len();
            let _ = self.0.try_push(farther);
            while i > base && self.0[i - 1] < farther {
                self.0[i] = self.0[i - 1];
                i -= 1;
            }
            self.0[i] = farther;
        }
        nearest.child()
    }

    #[inline(always)]
    fn pop(&mut self, t_max: f32) -> Option<Child> {
        loop {
            let waiting = self.0.pop()?;
            if waiting.near() <= t_max {
                return Some(waiting.child());
            }
        }
    }
}

/// Last child first, regardless of distance: for any hit.
#[derive(Default)]
pub(super) struct LastFirst(ArrayVec<Child, { DEPTH + Node::WIDTH }>);

impl Order for LastFirst {
    #[inline(always)]
    fn choose(&mut self, with: impl Instructions, hits: NodeHits, cells: &[Cell]) -> Child {
        let last = (hits.mask.leading_zeros() ^ 31) & 7;
        let rest = hits.mask & !(1 << last);
        let len = self.0.len() + rest.count_ones() as usize;
        // All eight are written, as that is one store, and there is room for them.
        let _ = self.0.try_extend_from_slice(&compress(with, &hits, rest));
        self.0.truncate(len);
        // The next child. (If there is none, the value is unused.)
        let next = hits.child(rest.leading_zeros() ^ 31);
        prefetch(cells, next.offset());
        hits.child(last)
    }

    #[inline(always)]
    fn pop(&mut self, _: f32) -> Option<Child> {
        self.0.pop()
    }
}

/// A child on the stack, with the distance at which the ray enters its box in the upper half, so that entries compare
/// as distances do.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct StackEntry(u64);

impl StackEntry {
    #[inline(always)]
    fn new(child: Child, near: f32) -> StackEntry {
        StackEntry(u64::from(near.to_bits()) << 32 | u64::from(child.bits()))
    }

    #[inline(always)]
    fn child(self) -> Child {
        Child::from_bits(self.0 as u32)
    }

    #[inline(always)]
    fn near(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }
}
