//! The 8-wide tree and a ray's way through it.

use super::aabb::Aabb;
use super::node::{Child, Node};
use super::packet::{Packet, PrimitiveId};
use super::ray::TraversalRay;
use arrayvec::ArrayVec;

/// Depth up to which the shape of the binary tree is kept. What is deeper (thousands of
/// primitives in one place) is split evenly, which takes at most 11 levels for 2³² leaves.
pub(super) const MAX_DEPTH: usize = 32;

/// Every level leaves at most seven siblings waiting, and the last one pushes eight.
const STACK: usize = (MAX_DEPTH + 11) * (Node::WIDTH - 1) + Node::WIDTH;

/// One primitive for the builder.
#[derive(Clone, Copy)]
pub(super) struct Item {
    pub id: PrimitiveId,
    pub bounds: Aabb,
}

/// An 8-wide bounding volume hierarchy.
pub(super) struct Tree {
    pub nodes: Vec<Node>,
    pub packets: Vec<Packet>,
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
        size_of_val(&self.nodes[..]) + size_of_val(&self.packets[..])
    }

    /// Shows `visitor` what the ray may meet, nearer boxes first where `ORDERED`. Returns true
    /// where the visitor ended the traversal.
    #[inline]
    pub fn traverse<const ORDERED: bool>(
        &self,
        ray: &TraversalRay,
        visitor: &mut impl Visitor,
    ) -> bool {
        let mut stack = ArrayVec::<(Child, f32), STACK>::new();
        let mut node = &self.nodes[0];
        loop {
            let (mut mask, near) = node.test(ray, visitor.t_max());
            let base = stack.len();
            while mask != 0 {
                let slot = mask.trailing_zeros() as usize;
                mask &= mask - 1;
                // The stack's size is proven above.
                let _ = stack.try_push((node.children[slot & 7], near[slot & 7]));
            }
            if ORDERED {
                sort_far_to_near(&mut stack[base..]);
            }
            node = loop {
                let Some((child, near)) = stack.pop() else {
                    return false;
                };
                if near > visitor.t_max() {
                    continue;
                }
                if !child.is_leaf() {
                    break &self.nodes[child.index()];
                }
                if self.visit_leaf(child, ray, visitor) {
                    return true;
                }
            };
        }
    }

    #[inline(always)]
    fn visit_leaf(&self, leaf: Child, ray: &TraversalRay, visitor: &mut impl Visitor) -> bool {
        for packet in &self.packets[leaf.packets()] {
            if packet.test(ray, visitor.t_max(), |lane, t| {
                visitor.triangle(packet.ids[lane], t)
            }) {
                return true;
            }
            if leaf.has_others()
                && packet
                    .ids
                    .iter()
                    .any(|id| id.is_other() && visitor.other(*id))
            {
                return true;
            }
        }
        false
    }
}

/// Insertion sort: there are seldom more than three.
#[inline(always)]
fn sort_far_to_near(entries: &mut [(Child, f32)]) {
    for i in 1..entries.len() {
        let mut j = i;
        while j > 0 && entries[j - 1].1 < entries[j].1 {
            entries.swap(j - 1, j);
            j -= 1;
        }
    }
}
