//! Building the 8-wide tree: obvhs makes a binary one, [`Plan`] says which of its nodes to keep.

use super::aabb::Aabb;
use super::collapse::{Plan, Root};
use super::groups::Groups;
use super::node::{Child, Node};
use super::packet::{LANES, Packet, PrimitiveId};
use super::tree::{Item, MAX_DEPTH, Tree};
use crate::math::Vec3;
use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::build_bvh2;
use rayon::prelude::*;

/// Subtrees of so many primitives at most are built in parallel. The number does not change the
/// tree.
const PIECE: u32 = 1 << 15;

/// What binary builder and plan leave, and what is built from.
struct Source<'a, F> {
    items: &'a [Item],
    corners: F,
    groups: Groups,
    plan: Plan,
    /// Groups in the order of the binary tree's leaves.
    indices: Vec<u32>,
}

/// A part of the tree being built; children count from its own first node and packet.
#[derive(Default)]
struct Piece {
    nodes: Vec<Node>,
    packets: Vec<Packet>,
}

/// Builds a tree over `items` with finite boxes; `corners` gives the corners of triangles.
pub(super) fn build(items: &[Item], corners: impl Fn(PrimitiveId) -> [Vec3; 3] + Sync) -> Tree {
    if items.is_empty() {
        return Tree {
            nodes: vec![Node::empty()],
            packets: Vec::new(),
        };
    }
    let groups = Groups::of(items);
    let parameters = BvhBuildParams {
        // Leaves are for the plan to make.
        max_prims_per_leaf: 1,
        post_collapse_reinsertion_batch_ratio_multiplier: 0.0,
        ..BvhBuildParams::medium_build()
    };
    let binary = build_bvh2(&groups.boxes(items), parameters, &mut Default::default());
    let plan = Plan::new(&binary, &groups, items);
    let source = Source {
        items,
        corners,
        groups,
        plan,
        indices: binary.primitive_indices,
    };
    let mut piece = Piece::default();
    let (root, bounds) = source.subtree(0, 0, &mut piece);
    if root.is_leaf() {
        let mut node = Node::empty();
        node.set(0, root, bounds);
        piece.nodes.push(node);
    }
    piece.nodes.shrink_to_fit();
    piece.packets.shrink_to_fit();
    Tree {
        nodes: piece.nodes,
        packets: piece.packets,
    }
}

impl<F: Fn(PrimitiveId) -> [Vec3; 3] + Sync> Source<'_, F> {
    /// Builds what is below an entry of the plan, depth first.
    fn subtree(&self, entry: usize, depth: usize, to: &mut Piece) -> (Child, Aabb) {
        let children = match self.plan.root(entry) {
            Root::Node(children) if depth < MAX_DEPTH => children,
            _ => return self.balanced(&self.items_below(entry), to),
        };
        let index = to.nodes.len();
        to.nodes.push(Node::empty());
        let mut all = Aabb::EMPTY;
        for (slot, &child) in children.iter().enumerate() {
            let (child, bounds) = self.subtree(child, depth + 1, to);
            to.nodes[index].set(slot, child, bounds);
            all = all.union(bounds);
        }
        (Child::node(index), all)
    }

    /// The items below an entry from left to right.
    fn items_below(&self, entry: usize) -> Vec<u32> {
        let mut found = Vec::new();
        let collect = |group| found.extend(self.groups.members(group));
        self.plan.groups_below(entry, &self.indices, collect);
        found
    }

    /// A tree of least depth over `items`, which may be all in one place.
    fn balanced(&self, items: &[u32], to: &mut Piece) -> (Child, Aabb) {
        if items.len() <= LANES {
            return self.leaf(items, to);
        }
        let index = to.nodes.len();
        to.nodes.push(Node::empty());
        let mut all = Aabb::EMPTY;
        for (slot, part) in items.chunks(items.len().div_ceil(Node::WIDTH)).enumerate() {
            let (child, bounds) = self.balanced(part, to);
            to.nodes[index].set(slot, child, bounds);
            all = all.union(bounds);
        }
        (Child::node(index), all)
    }

    fn leaf(&self, items: &[u32], to: &mut Piece) -> (Child, Aabb) {
        let (mut packet, mut all, mut others) = (Packet::empty(), Aabb::EMPTY, false);
        for (lane, &item) in items.iter().take(LANES).enumerate() {
            let Item { id, bounds } = self.items[item as usize];
            all = all.union(bounds);
            if id.is_triangle() {
                packet.set_triangle(lane, id, (self.corners)(id));
            } else {
                packet.ids[lane] = id;
                others = true;
            }
        }
        to.packets.push(packet);
        (Child::leaf(to.packets.len() - 1, 1, others), all)
    }
}
