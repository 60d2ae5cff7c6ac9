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
        if is_x86_feature_detected!("avx2") {
            return unsafe { super::simd::go_avx2::<ORDERED>(self, ray, visitor) };
        }
        self.traverse_with::<ORDERED, _>(super::simd::Baseline, ray, visitor)
    }

    #[inline(always)]
    pub fn traverse_with<const ORDERED: bool, S: super::simd::Simd>(
        &self,
        simd: S,
        ray: &TraversalRay,
        visitor: &mut impl Visitor,
    ) -> bool {
        let mut stack = ArrayVec::<Waiting, STACK>::new();
        let mut current = Child::node(0);
        loop {
            if !current.is_leaf() {
                let node = &self.nodes[current.index()];
                let (mut mask, near) = simd.boxes(node, ray, visitor.t_max());
                let waiting = |mask: u32| {
                    let slot = (mask.trailing_zeros() & 7) as usize;
                    Waiting::new(node.children[slot], near[slot])
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
                    // The stack's size is proven above.
                    let _ = stack.try_push(farther);
                    if mask == 0 {
                        current = nearer.child();
                        continue;
                    }
                    let _ = stack.try_push(nearer);
                    while mask != 0 {
                        let _ = stack.try_push(waiting(mask));
                        mask &= mask - 1;
                    }
                    if ORDERED {
                        sort_far_to_near(&mut stack[base..]);
                    }
                }
            } else if self.visit_leaf(current, ray, visitor) {
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

/// A child that waits, with where the ray enters its box: the number's upper half, so that numbers
/// compare as distances do.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Waiting(u64);

impl Waiting {
    #[inline(always)]
    fn new(child: Child, near: f32) -> Waiting {
        Waiting(u64::from(near.to_bits()) << 32 | u64::from(child.0))
    }

    #[inline(always)]
    fn child(self) -> Child {
        Child(self.0 as u32)
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
