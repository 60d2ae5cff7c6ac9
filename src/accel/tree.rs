//! The 8-wide tree and a ray's way through it.

use super::aabb::Aabb;
use super::instructions::{Best, Instructions};
use super::node::{Cell, Child, Node, StoredNode};
use super::packet::{PrimitiveId, StoredPacket};
use super::ray::TraversalRay;
use crate::math::Vec3;
use arrayvec::ArrayVec;

/// Depth up to which the shape of the binary tree is kept. What is deeper (thousands of
/// primitives in one place) is split evenly, which takes at most 11 levels for 2³² primitives, and
/// one more where leaves would mix triangles and others.
pub(super) const MAX_DEPTH: usize = 32;

/// Every level leaves at most seven siblings waiting, and the last one pushes eight.
const STACK: usize = (MAX_DEPTH + 12) * (Node::WIDTH - 1) + Node::WIDTH;

/// One primitive for the builder.
#[derive(Clone, Copy)]
pub(super) struct Item {
    pub id: PrimitiveId,
    pub bounds: Aabb,
}

/// An 8-wide bounding volume hierarchy.
#[derive(Default)]
pub(super) struct Tree {
    /// Nodes and leaves; the root comes first.
    pub cells: Vec<Cell>,
    /// How many nodes there are.
    pub nodes: usize,
    /// What rays go through it with.
    pub instructions: Best,
}

/// What a traversal looks for.
pub(super) trait Visitor {
    /// Nothing at or beyond this distance is of interest.
    fn t_max(&self) -> f32;
    /// The ray meets a triangle at `t`. True ends the traversal.
    fn triangle(&mut self, id: PrimitiveId, t: f64) -> bool;
    /// The ray may meet a quadric or an instance. True ends the traversal.
    fn other(&mut self, id: PrimitiveId) -> bool;
}

impl Tree {
    /// Memory in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.cells[..])
    }

    /// Shows `visitor` what the ray may meet, nearer boxes first where `ORDERED`. Returns true
    /// where the visitor ended the traversal.
    #[inline(always)]
    pub fn traverse<const ORDERED: bool>(
        &self,
        with: impl Instructions,
        o: Vec3,
        d: Vec3,
        visitor: &mut impl Visitor,
    ) -> bool {
        let ray = &TraversalRay::new(o, d);
        let cells = &self.cells[..];
        let mut stack = ArrayVec::<Waiting, STACK>::new();
        let mut current = Child::node(0);
        loop {
            let at = current.offset();
            let Some(here) = cells.get(at..) else {
                return false;
            };
            if !current.is_leaf() {
                let Some(node) = StoredNode::first_of(here) else {
                    return false;
                };
                let (mut mask, near) = with.boxes(node, ray, visitor.t_max());
                let waiting = |mask: u32| {
                    let slot = (mask.trailing_zeros() & 7) as usize;
                    Waiting::new(node.child(slot).seen_from(at), near[slot])
                };
                if mask != 0 {
                    let first = waiting(mask);
                    mask &= mask - 1;
                    if mask == 0 {
                        current = first.child();
                        continue;
                    }
                    let second = waiting(mask);
                    mask &= mask - 1;
                    let (nearer, farther) = if ORDERED {
                        (first.min(second), first.max(second))
                    } else {
                        (first, second)
                    };
                    let base = stack.len();
                    with.prefetch(cells, first.child().offset());
                    with.prefetch(cells, second.child().offset());
                    // The stack's size is proven above.
                    let _ = stack.try_push(farther);
                    if mask == 0 {
                        current = nearer.child();
                        continue;
                    }
                    let _ = stack.try_push(nearer);
                    while mask != 0 {
                        let next = waiting(mask);
                        with.prefetch(cells, next.child().offset());
                        let _ = stack.try_push(next);
                        mask &= mask - 1;
                    }
                    if ORDERED {
                        sort_far_to_near(&mut stack[base..]);
                    }
                }
            } else if visit_leaf(current, here, ray, visitor) {
                return true;
            }
            current = loop {
                let Some(waiting) = stack.pop() else {
                    return false;
                };
                if waiting.near() <= visitor.t_max() {
                    break waiting.child();
                }
            };
        }
    }
}

/// Shows the visitor what is in the leaf that starts with the first cell.
#[inline(always)]
fn visit_leaf(leaf: Child, cells: &[Cell], ray: &TraversalRay, visitor: &mut impl Visitor) -> bool {
    if leaf.has_others() {
        let ids: [u32; 8] = cells
            .first()
            .map_or([PrimitiveId::NONE.bits(); 8], |&cell| bytemuck::cast(cell));
        return ids
            .into_iter()
            .map(PrimitiveId::from_bits)
            .take_while(|id| id.is_other())
            .any(|id| visitor.other(id));
    }
    let Some(packet) = StoredPacket::first_of(cells) else {
        return false;
    };
    packet.test(ray, visitor.t_max(), |id, t| visitor.triangle(id, t))
}

/// A child that waits, with where the ray enters its box: the number's upper half, so that numbers
/// compare as distances do.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Waiting(u64);

impl Waiting {
    #[inline(always)]
    fn new(child: Child, near: f32) -> Waiting {
        Waiting(u64::from(near.to_bits()) << 32 | u64::from(child.bits()))
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

/// Insertion sort: there are seldom more than four.
#[inline(always)]
fn sort_far_to_near(entries: &mut [Waiting]) {
    for i in 1..entries.len() {
        let mut j = i;
        while j > 0 && entries[j - 1] < entries[j] {
            entries.swap(j - 1, j);
            j -= 1;
        }
    }
}
