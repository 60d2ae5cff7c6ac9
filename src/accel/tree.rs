//! Building the 8-wide tree and finding a ray's way through it.

use super::aabb::Aabb;
use super::node::{Child, Node};
use super::packet::{LANES, Packet, PrimitiveId};
use super::ray::TraversalRay;
use crate::math::Vec3;
use crate::math::hash::{mix, mix2, unit_float};
use arrayvec::ArrayVec;
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use rayon::slice::ParallelSliceMut;

/// Primitives in a leaf: one packet. (8, two packets, was slower: more half-filled lanes.)
const LEAF_PRIMITIVES: u32 = LANES as u32;

/// Depth up to which the shape of the binary tree is kept. What is deeper (thousands of
/// primitives in one place) is split evenly, which takes at most 11 levels for 2³² leaves.
const MAX_DEPTH: usize = 32;

/// Up to how much larger a box looks to the binary builder than it is ([`Groups::boxes`]). Boxes that
/// grow faster than this from one to the next run out of single precision after 20,000.
const UNEVENNESS: f32 = 0.01;

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
            return Tree {
                nodes: vec![Node::empty()],
                packets: Vec::new(),
            };
        }
        let groups = Groups::of(items);
        let parameters = BvhBuildParams {
            max_prims_per_leaf: LEAF_PRIMITIVES,
            ..BvhBuildParams::medium_build()
        };
        let binary = build_bvh2(&groups.boxes(items), parameters, &mut Default::default());
        let mut builder = Builder {
            binary: &binary,
            bounds: groups.bounds(items, &binary),
            items,
            groups: &groups,
            corners,
            tree: Tree {
                nodes: Vec::new(),
                packets: Vec::with_capacity(items.len() / 2),
            },
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

/// Items by box: the binary builder pairs neighbours of least cost, and among thousands of equal
/// ones finds a single pair a pass, which takes for ever. So it gets every box once.
struct Groups {
    /// Items, those with equal boxes together.
    order: Vec<u32>,
    /// Where groups start in `order`, and its length.
    starts: Vec<u32>,
}

impl Groups {
    fn of(items: &[Item]) -> Groups {
        let bits = |v: Vec3| {
            v.to_array()
                .into_iter()
                .fold(0, |h, x| mix2(h, u64::from(x.to_bits())))
        };
        let hash = |item: &Item| mix(bits(item.bounds.min)) ^ bits(item.bounds.max);
        let mut keys: Vec<(u64, u32)> = items
            .iter()
            .zip(0..)
            .map(|(item, i)| (hash(item), i))
            .collect();
        keys.par_sort_unstable();
        let mut starts: Vec<u32> = (0..keys.len() as u32)
            .filter(|&i| i == 0 || keys[i as usize - 1].0 != keys[i as usize].0)
            .collect();
        if starts.len() == keys.len() {
            // The usual case; in the file's order neighbours are near each other in memory.
            let order: Vec<u32> = (0..items.len() as u32).collect();
            starts = order.clone();
            starts.push(items.len() as u32);
            return Groups { order, starts };
        }
        starts.push(keys.len() as u32);
        Groups {
            order: keys.into_iter().map(|(_, i)| i).collect(),
            starts,
        }
    }

    fn members(&self, group: u32) -> &[u32] {
        let group = group as usize;
        &self.order[self.starts[group] as usize..self.starts[group + 1] as usize]
    }

    /// The box around a group. (Around all members: hashes may collide.)
    fn group_bounds(&self, group: u32, items: &[Item]) -> Aabb {
        let of = |&i: &u32| items[i as usize].bounds;
        let members = self.members(group).iter();
        members.fold(Aabb::EMPTY, |b, i| b.union(of(i)))
    }

    /// What the binary builder sees: one box a group, each a little larger by a share of its own.
    ///
    /// The builder pairs mutual nearest neighbours, pass by pass. Where every box's nearest is the
    /// one before it (a row of equal boxes, boxes that grow from one to the next) there is one
    /// mutual pair, and as many passes as boxes. Uneven sizes make a third of them mutual.
    fn boxes(&self, items: &[Item]) -> Vec<obvhs::aabb::Aabb> {
        (0..self.starts.len() as u32 - 1)
            .map(|group| {
                let bounds = self.group_bounds(group, items);
                let share = UNEVENNESS * unit_float(mix(u64::from(group)));
                let grown = (bounds.max - bounds.min) * share;
                // Where the sum overflows the box was as large as numbers are.
                let max = (bounds.max + grown).min(Vec3::MAX);
                obvhs::aabb::Aabb::new(bounds.min.into(), max.into())
            })
            .collect()
    }

    /// The true boxes of the binary tree's nodes.
    fn bounds(&self, items: &[Item], binary: &Bvh2) -> Vec<Aabb> {
        let nodes = &binary.nodes;
        let mut order = vec![0];
        let mut next = 0;
        while let Some(&node) = order.get(next) {
            next += 1;
            if !nodes[node].is_leaf() {
                let first = nodes[node].first_index as usize;
                order.extend([first, first + 1]);
            }
        }
        let mut bounds = vec![Aabb::EMPTY; nodes.len()];
        for &node in order.iter().rev() {
            let first = nodes[node].first_index as usize;
            bounds[node] = if nodes[node].is_leaf() {
                let range = first..first + nodes[node].prim_count as usize;
                let groups = binary.primitive_indices[range].iter();
                groups.fold(Aabb::EMPTY, |b, &g| b.union(self.group_bounds(g, items)))
            } else {
                bounds[first].union(bounds[first + 1])
            };
        }
        bounds
    }
}

/// Turns the binary tree into the wide one.
struct Builder<'a, F> {
    binary: &'a Bvh2,
    /// Of the binary tree's nodes.
    bounds: Vec<Aabb>,
    items: &'a [Item],
    groups: &'a Groups,
    corners: F,
    tree: Tree,
}

impl<F: Fn(PrimitiveId) -> [Vec3; 3]> Builder<'_, F> {
    /// Builds what is below node `root` of the binary tree.
    fn subtree(&mut self, root: usize, depth: usize) -> (Child, Aabb) {
        let bounds = self.bounds[root];
        if self.binary.nodes[root].is_leaf() || depth >= MAX_DEPTH {
            let items = self.items_below(root);
            return (self.balanced(&items), bounds);
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

    /// The items below `root` from left to right.
    fn items_below(&self, root: usize) -> Vec<u32> {
        let (mut found, mut stack) = (Vec::new(), vec![root]);
        while let Some(i) = stack.pop() {
            let node = &self.binary.nodes[i];
            if node.is_leaf() {
                let range =
                    node.first_index as usize..(node.first_index + node.prim_count) as usize;
                for &group in &self.binary.primitive_indices[range] {
                    found.extend(self.groups.members(group));
                }
            } else {
                stack.extend([node.first_index as usize + 1, node.first_index as usize]);
            }
        }
        found
    }

    /// A tree of least depth over `items`, which may be all in one place.
    fn balanced(&mut self, items: &[u32]) -> Child {
        if items.len() <= LANES {
            return self.leaf(items);
        }
        let index = self.tree.nodes.len();
        self.tree.nodes.push(Node::empty());
        for (slot, part) in items.chunks(items.len().div_ceil(Node::WIDTH)).enumerate() {
            let bounds = part
                .iter()
                .fold(Aabb::EMPTY, |b, &i| b.union(self.items[i as usize].bounds));
            let child = self.balanced(part);
            self.tree.nodes[index].set(slot, child, bounds);
        }
        Child::node(index)
    }

    fn leaf(&mut self, items: &[u32]) -> Child {
        let first = self.tree.packets.len();
        let mut others = false;
        for members in items.chunks(LANES) {
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
