//! Building the 8-wide tree: obvhs makes a binary one, [`Plan`] says which of its nodes to keep.

use super::aabb::Aabb;
use super::collapse::{Plan, Root};
use super::groups::Groups;
use super::node::{Child, Node};
use super::packet::{LANES, Packet, PrimitiveId};
use super::tree::{Item, MAX_DEPTH, Tree};
use crate::math::Vec3;
use arrayvec::ArrayVec;
use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::build_bvh2;
use rayon::prelude::*;

/// Down to this depth subtrees are built in parallel, in trees of this many primitives.
const PARALLEL_DEPTH: usize = 2;
const PARALLEL_ITEMS: usize = 1 << 12;

/// What binary builder and plan leave, and what is built from.
struct Source<'a, F> {
    items: &'a [Item],
    corners: F,
    groups: Groups,
    plan: Plan,
    /// Groups in the order of the binary tree's leaves.
    indices: Vec<u32>,
}

/// Builds a tree over `items` with finite boxes; `corners` gives the corners of triangles.
pub(super) fn build(items: &[Item], corners: impl Fn(PrimitiveId) -> [Vec3; 3] + Sync) -> Tree {
    if items.is_empty() {
        return Tree {
            cells: Node::empty().cells().to_vec(),
            nodes: 1,
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
    let mut tree = Tree {
        cells: Vec::new(),
        nodes: 0,
    };
    let mut tree = Tree::default();
    let root = source.planned(0, 0);
    match &root {
        // Every tree starts with a node.
        Part::Leaf(_) => source.add(&[root], 0, &mut tree),
        _ => source.add(&source.divided(&root), 0, &mut tree),
    };
    tree.cells.shrink_to_fit();
    tree
}

/// What is to become a child of a node.
enum Part {
    /// A leaf with up to four items of one kind.
    Leaf(ArrayVec<u32, LANES>),
    /// A node with these entries of the plan below it, and its depth.
    Planned(ArrayVec<usize, { Node::WIDTH }>, usize),
    /// Items that the plan does not divide.
    Heap(Vec<u32>),
}

type Parts = ArrayVec<Part, { Node::WIDTH }>;

impl<F: Fn(PrimitiveId) -> [Vec3; 3] + Sync> Source<'_, F> {
    /// What becomes of an entry of the plan.
    fn planned(&self, entry: usize, depth: usize) -> Part {
        match self.plan.root(entry) {
            Root::Node(children) if depth < MAX_DEPTH => Part::Planned(children, depth),
            Root::Node(_) => {
                let mut items = Vec::new();
                let collect = |group| items.extend(self.groups.members(group));
                self.plan.groups_below(entry, &self.indices, collect);
                self.of_items(items.into_iter())
            }
            Root::Leaf => {
                let mut groups = ArrayVec::<u32, LANES>::new();
                let mut rest = Vec::new();
                self.plan
                    .groups_of_leaf(entry, &self.indices, &mut |group| {
                        if let Err(full) = groups.try_push(group) {
                            rest.push(full.element());
                        }
                    });
                let groups = groups.iter().chain(&rest);
                self.of_items(groups.flat_map(|&group| self.groups.members(group)))
            }
        }
    }

    /// A leaf where the items fit in one.
    fn of_items(&self, mut items: impl Iterator<Item = u32>) -> Part {
        let first: ArrayVec<u32, LANES> = items.by_ref().take(LANES).collect();
        let is_triangle = |&i: &u32| self.items[i as usize].id.is_triangle();
        let Some(next) = items.next() else {
            let triangles = first.iter().filter(|i| is_triangle(i)).count();
            return if triangles == 0 || triangles == first.len() {
                Part::Leaf(first)
            } else {
                Part::Heap(first.to_vec())
            };
        };
        let items = first.into_iter().chain([next]).chain(items);
        Part::Heap(items.collect())
    }

    /// The children of what is no leaf.
    fn divided(&self, part: &Part) -> Parts {
        match part {
            Part::Leaf(_) => Parts::new(),
            Part::Planned(children, depth) => {
                let mut parts = children
                    .iter()
                    .map(|&child| self.planned(child, depth + 1))
                    .collect();
                self.join_leaves(&mut parts);
                parts
            }
            Part::Heap(items) => items
                .chunks(items.len().div_ceil(Node::WIDTH))
                .map(|part| self.of_items(part.iter().copied()))
                .collect(),
        }
    }

    /// Makes one leaf of two, again and again, where that is cheaper.
    fn join_leaves(&self, parts: &mut Parts) {
        let leaf = |part: &Part| match part {
            Part::Leaf(items) if self.items[items[0] as usize].id.is_triangle() => {
                Some((items.len(), self.bounds_of(items)))
            }
            _ => None,
        };
        loop {
            let leaves: ArrayVec<Option<(usize, Aabb)>, { Node::WIDTH }> =
                parts.iter().map(leaf).collect();
            let mut best = (0.0, 0, 0);
            for (i, a) in leaves.iter().enumerate() {
                for (j, b) in leaves.iter().enumerate().take(i) {
                    let (Some((n, a)), Some((m, b))) = (a, b) else {
                        continue;
                    };
                    if n + m <= LANES {
                        let gain = a.half_area() + b.half_area() - a.union(*b).half_area();
                        if gain > best.0 {
                            best = (gain, i, j);
                        }
                    }
                }
            }
            let (gain, i, j) = best;
            if gain <= 0.0 {
                return;
            }
            let taken = parts.swap_remove(i);
            if let (Part::Leaf(to), Part::Leaf(from)) = (&mut parts[j], taken) {
                to.extend(from);
            }
        }
    }

    fn bounds_of(&self, items: &[u32]) -> Aabb {
        let items = items.iter().map(|&i| self.items[i as usize].bounds);
        items.fold(Aabb::EMPTY, Aabb::union)
    }

    /// Adds a node with `parts` as its children and all below it; gives the box around that.
    fn add(&self, parts: &[Part], depth: usize, to: &mut Tree) -> Aabb {
        let at = to.cells.len();
        to.cells.extend(Node::empty().cells());
        to.nodes += 1;
        let mut children = ArrayVec::<(Child, Aabb), { Node::WIDTH }>::new();
        for part in parts {
            if let Part::Leaf(items) = part {
                children.push(self.leaf(items, to.cells.len() - at, to));
            }
        }
        let inner = parts.iter().filter(|part| !matches!(part, Part::Leaf(_)));
        if depth < PARALLEL_DEPTH && self.items.len() >= PARALLEL_ITEMS {
            let inner: Vec<&Part> = inner.collect();
            let below: Vec<(Aabb, Tree)> = inner
                .into_par_iter()
                .map(|part| {
                    let mut tree = Tree::default();
                    let bounds = self.add(&self.divided(part), depth + 1, &mut tree);
                    (bounds, tree)
                })
                .collect();
            for (bounds, below) in below {
                children.push((Child::node(to.cells.len() - at), bounds));
                to.cells.extend_from_slice(&below.cells);
                to.nodes += below.nodes;
            }
        } else {
            for part in inner {
                let child = Child::node(to.cells.len() - at);
                let bounds = self.add(&self.divided(part), depth + 1, to);
                children.push((child, bounds));
            }
        }
        // A search for any hit takes what comes first, and is best served by the largest.
        children.sort_by(|(_, a), (_, b)| b.half_area().total_cmp(&a.half_area()));
        let (mut node, mut all) = (Node::empty(), Aabb::EMPTY);
        for (slot, &(child, bounds)) in children.iter().enumerate() {
            node.set(slot, child, bounds);
            all = all.union(bounds);
        }
        to.cells[at..at + Node::CELLS].copy_from_slice(&node.cells());
        all
    }

    /// Adds a leaf, `offset` cells after its node.
    fn leaf(&self, items: &[u32], offset: usize, to: &mut Tree) -> (Child, Aabb) {
        let items = items.iter().map(|&i| self.items[i as usize]);
        let bounds = items
            .clone()
            .fold(Aabb::EMPTY, |all, item| all.union(item.bounds));
        if items.clone().all(|item| item.id.is_triangle()) {
            let mut packet = Packet::empty();
            for (lane, Item { id, .. }) in items.enumerate() {
                packet.set_triangle(lane, id, (self.corners)(id));
            }
            to.cells.extend(packet.cells());
            return (Child::triangles(offset), bounds);
        }
        let mut ids = [PrimitiveId::NONE.bits(); 8];
        for (to, item) in ids.iter_mut().zip(items) {
            *to = item.id.bits();
        }
        to.cells.push(bytemuck::cast(ids));
        (Child::others(offset), bounds)
    }
}
