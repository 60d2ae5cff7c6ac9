//! Building the 8-wide tree and finding a ray's way through it.

use super::aabb::Aabb;
use super::node::{Child, Node};
use super::packet::{LANES, Packet, PrimitiveId};
use super::ray::TraversalRay;
use crate::math::Vec3;
use arrayvec::ArrayVec;
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

/// Primitives in a leaf: one packet. (8, two packets, was slower: more half-filled lanes.)
const LEAF_PRIMITIVES: u32 = LANES as u32;

/// Depth up to which the shape of the binary tree is kept. What is deeper (thousands of
/// primitives in one place) is split evenly, which takes at most 11 levels for 2³² leaves.
const MAX_DEPTH: usize = 32;

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
    /// Builds a tree over `items` with finite boxes; `corners` gives the corners of triangles.
    pub fn build(items: &[Item], corners: impl Fn(PrimitiveId) -> [Vec3; 3]) -> Tree {
        if items.is_empty() {
            return Tree { nodes: vec![Node::empty()], packets: Vec::new() };
        }
        let boxes: Vec<obvhs::aabb::Aabb> = items
            .iter()
            .map(|item| obvhs::aabb::Aabb::new(item.bounds.min.into(), item.bounds.max.into()))
            .collect();
        let parameters = BvhBuildParams {
            max_prims_per_leaf: LEAF_PRIMITIVES,
            ..BvhBuildParams::medium_build()
        };
        let binary = build_bvh2(&boxes, parameters, &mut Default::default());
        drop(boxes);
        let mut builder = Builder {
            binary: &binary,
            items,
            corners,
            tree: Tree { nodes: Vec::new(), packets: Vec::with_capacity(items.len() / 2) },
        };
        let (root, bounds) = builder.subtree(0, 0);
        if root.is_leaf() {
            let mut node = Node::empty();
            node.set(0, root, bounds);
            builder.tree.nodes.push(node);
        }
        builder.tree.nodes.shrink_to_fit();
        builder.tree.packets.shrink_to_fit();
        builder.tree
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.packets[..])
    }

    /// Shows `visitor` what the ray may meet, nearer boxes first where `ORDERED`. Returns true
    /// where the visitor ended the traversal.
    #[inline]
    pub fn traverse<const ORDERED: bool>(&self, ray: &TraversalRay, visitor: &mut impl Visitor) -> bool {
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
            if packet.test(ray, visitor.t_max(), |lane, t| visitor.triangle(packet.ids[lane], t)) {
                return true;
            }
            if leaf.has_others() && packet.ids.iter().any(|id| id.is_other() && visitor.other(*id)) {
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

/// Turns the binary tree into the wide one.
struct Builder<'a, F> {
    binary: &'a Bvh2,
    items: &'a [Item],
    corners: F,
    tree: Tree,
}

impl<F: Fn(PrimitiveId) -> [Vec3; 3]> Builder<'_, F> {
    fn bounds(&self, node: usize) -> Aabb {
        let aabb = &self.binary.nodes[node].aabb;
        Aabb { min: aabb.min.into(), max: aabb.max.into() }
    }

    /// Builds what is below node `root` of the binary tree.
    fn subtree(&mut self, root: usize, depth: usize) -> (Child, Aabb) {
        let bounds = self.bounds(root);
        if self.binary.nodes[root].is_leaf() {
            return (self.leaf(root), bounds);
        }
        if depth >= MAX_DEPTH {
            let leaves = self.leaves_below(root);
            return (self.balanced(&leaves), bounds);
        }
        let index = self.tree.nodes.len();
        self.tree.nodes.push(Node::empty());
        for (slot, &member) in self.open(root).iter().enumerate() {
            let (child, bounds) = self.subtree(member, depth + 1);
            self.tree.nodes[index].set(slot, child, bounds);
        }
        (Child::node(index), bounds)
    }

    /// Up to eight nodes that together are `root`: the largest inner one is replaced by its two
    /// children until there are eight (Wald, Benthin and Boulos 2008).
    fn open(&self, root: usize) -> ArrayVec<usize, { Node::WIDTH }> {
        let nodes = &self.binary.nodes;
        let first = nodes[root].first_index as usize;
        let mut members = ArrayVec::from_iter([first, first + 1]);
        while members.len() < Node::WIDTH {
            let area = |&i: &usize| nodes[i].aabb.half_area();
            let largest = (0..members.len())
                .filter(|&m| !nodes[members[m]].is_leaf())
                .max_by(|&a, &b| area(&members[a]).total_cmp(&area(&members[b])));
            let Some(largest) = largest else { break };
            let first = nodes[members[largest]].first_index as usize;
            members[largest] = first;
            members.push(first + 1);
        }
        members
    }

    /// The leaves below `root` from left to right.
    fn leaves_below(&self, root: usize) -> Vec<usize> {
        let (mut leaves, mut stack) = (Vec::new(), vec![root]);
        while let Some(i) = stack.pop() {
            let node = &self.binary.nodes[i];
            if node.is_leaf() {
                leaves.push(i);
            } else {
                stack.extend([node.first_index as usize + 1, node.first_index as usize]);
            }
        }
        leaves
    }

    /// A tree of least depth over `leaves`.
    fn balanced(&mut self, leaves: &[usize]) -> Child {
        if let [leaf] = leaves {
            return self.leaf(*leaf);
        }
        let index = self.tree.nodes.len();
        self.tree.nodes.push(Node::empty());
        for (slot, part) in leaves.chunks(leaves.len().div_ceil(Node::WIDTH)).enumerate() {
            let bounds = part.iter().fold(Aabb::EMPTY, |b, &leaf| b.union(self.bounds(leaf)));
            let child = self.balanced(part);
            self.tree.nodes[index].set(slot, child, bounds);
        }
        Child::node(index)
    }

    fn leaf(&mut self, node: usize) -> Child {
        let node = &self.binary.nodes[node];
        let range = node.first_index as usize..(node.first_index + node.prim_count) as usize;
        let first = self.tree.packets.len();
        let mut others = false;
        for members in self.binary.primitive_indices[range].chunks(LANES) {
            let mut packet = Packet::empty();
            for (lane, &member) in members.iter().enumerate() {
                let id = self.items[member as usize].id;
                if id.is_triangle() {
                    packet.set_triangle(lane, id, (self.corners)(id));
                } else {
                    packet.ids[lane] = id;
                    others = true;
                }
            }
            self.tree.packets.push(packet);
        }
        Child::leaf(first, self.tree.packets.len() - first, others)
    }
}
