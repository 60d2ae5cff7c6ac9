//! Selects the nodes of the binary tree that become nodes and leaves of the wide one, minimizing the expected cost of a
//! ray by the surface area heuristic (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs", HPG 2017, §3.1).
//!
//! Below a binary node there may be a forest of up to i roots, 1 ≤ i ≤ 7, each a wide node or a leaf. The cheapest
//! forest is one of i − 1 roots, or one of k roots on the left and i − k on the right; a single root is a leaf, or a
//! wide node over the cheapest forest of eight. The cost of a visit is weighted by surface area, which is proportional
//! to the probability that a ray hits the box (Goldsmith and Salmon 1987). One bottom-up sweep finds all decisions.

use super::groups::Groups;
use super::node::Node;
use super::packet::LANES;
use super::primitive::{Item, OtherKind};
use arrayvec::ArrayVec;
use obvhs::bvh2::Bvh2;
use rayon::prelude::*;

/// Cost of testing a leaf's packet, in units of testing a node's eight boxes. (Ray times are the same for 0.3 to 0.8,
/// and worse above; less means fewer nodes.)
const PACKET_COST: f32 = 0.3;

/// Cost of a non-triangle primitive, in the same units. That of a piece of a curve is below its true cost, so that
/// leaves hold several, which serves curves' memory as well as their time.
fn other_cost(kind: OtherKind) -> f32 {
    match kind {
        OtherKind::Curve => 0.3,
        OtherKind::Quadric => 2.0,
        // The ray is transformed, set up again, and traverses another tree.
        OtherKind::Instance => 6.0,
    }
}

/// Maximum number of roots in a forest whose roots are not yet the children of a node.
const ROOTS: usize = Node::WIDTH - 1;

/// Levels of the binary tree smaller than this are not worth splitting between threads.
const PARALLEL: usize = 2048;

/// The binary tree, breadth first, with the decisions.
pub(super) struct Plan {
    entries: Vec<Entry>,
}

/// A node of the binary tree.
#[derive(Clone, Copy)]
struct Entry {
    /// Index of the left child, which the right one follows; for a leaf, that of its first group.
    first: u32,
    /// Number of groups in a leaf; 0 for inner nodes.
    groups: u32,
    /// Half area of the binary builder's box, which is up to 1 % too large.
    half_area: f32,
    decision: Decision,
}

/// Three bits for each number of roots: how many are on the left. 0 for one root means a leaf; for more, that one root
/// fewer is cheaper. The split of a wide node's eight is stored for one root.
#[derive(Clone, Copy, Default)]
struct Decision(u32);

impl Decision {
    fn left(self, roots: usize) -> usize {
        (self.0 >> (3 * (roots - 1)) & 7) as usize
    }

    fn set(&mut self, roots: usize, left: usize) {
        self.0 |= (left as u32) << (3 * (roots - 1));
    }
}

/// What the sweep knows about the subtree of a binary node.
#[derive(Clone, Copy)]
struct Below {
    items: u32,
    others: u32,
    /// Cost of the non-triangle primitives.
    others_cost: f32,
    /// Cost of the cheapest forest, by its number of roots minus one.
    cost: [f32; ROOTS],
}

/// What a node of the wide tree consists of.
pub(super) enum Root {
    /// A leaf with the items below the entry.
    Leaf,
    /// A node with these entries as children.
    Node(ArrayVec<usize, { Node::WIDTH }>),
}

impl Plan {
    /// Finds the cheapest wide tree. Leaves of the binary tree hold groups.
    pub(super) fn new(binary: &Bvh2, groups: &Groups, items: &[Item]) -> Plan {
        let (mut entries, levels) = breadth_first(binary);
        let mixed = items.par_iter().any(|item| !item.id.is_triangle());
        let leaf = |entry: &Entry| {
            let first = entry.first as usize;
            let members = &binary.primitive_indices[first..first + entry.groups as usize];
            let count = |&group: &u32| groups.members(group).len() as u32;
            let mut below = Below {
                items: members.iter().map(count).sum(),
                // Without other primitives the items, which are scattered in memory, need not be read.
                others: 0,
                others_cost: 0.0,
                cost: [0.0; ROOTS],
            };
            if mixed {
                let ids = members.iter().flat_map(|&group| groups.members(group));
                let ids = ids.map(|i| items[i as usize].id);
                for id in ids.filter(|id| !id.is_triangle()) {
                    below.others += 1;
                    below.others_cost += other_cost(id.kind());
                }
            }
            below.cost = [leaf_cost(entry, &below); ROOTS];
            below
        };
        let mut below: Vec<Below> = Vec::new();
        for level in levels.into_iter().rev() {
            let first_below = level.end;
            let decide = |entry: &mut Entry| {
                if entry.groups > 0 {
                    return leaf(entry);
                }
                let left = entry.first as usize - first_below;
                inner(entry, &below[left], &below[left + 1])
            };
            let level = &mut entries[level];
            below = if level.len() < PARALLEL {
                level.iter_mut().map(decide).collect()
            } else {
                level.par_iter_mut().map(decide).collect()
            };
        }
        Plan { entries }
    }

    /// The leaf or node that the entry becomes as a root; entry 0 is the root of the tree.
    pub(super) fn root(&self, entry: usize) -> Root {
        let root = &self.entries[entry];
        let left = root.decision.left(1);
        if root.groups > 0 || left == 0 {
            return Root::Leaf;
        }
        let mut children = ArrayVec::new();
        self.forests(entry, Node::WIDTH, left, &mut children);
        Root::Node(children)
    }

    /// The roots of the cheapest forest at the entry, with up to so many of them, at most [`ROOTS`].
    pub(super) fn forest(
        &self,
        entry: usize,
        mut roots: usize,
        found: &mut ArrayVec<usize, { Node::WIDTH }>,
    ) {
        let root = &self.entries[entry];
        while roots > 1 && root.decision.left(roots) == 0 {
            roots -= 1;
        }
        if roots == 1 || root.groups > 0 {
            // There is room: at most as many roots are requested as a node has children.
            let _ = found.try_push(entry);
        } else {
            self.forests(entry, roots, root.decision.left(roots), found);
        }
    }

    /// Those below the entry: up to `roots`, of which `left` are on its left.
    fn forests(
        &self,
        entry: usize,
        roots: usize,
        left: usize,
        found: &mut ArrayVec<usize, { Node::WIDTH }>,
    ) {
        let first = self.entries[entry].first as usize;
        self.forest(first, left, found);
        self.forest(first + 1, roots - left, found);
    }

    /// The groups of an entry that is a leaf.
    pub(super) fn groups_of_leaf(&self, entry: usize, binary: &[u32], found: &mut impl FnMut(u32)) {
        // At most four levels deep: leaves of the plan hold few items.
        let Entry { first, groups, .. } = self.entries[entry];
        let first = first as usize;
        if groups == 0 {
            self.groups_of_leaf(first, binary, found);
            self.groups_of_leaf(first + 1, binary, found);
        } else {
            binary[first..first + groups as usize]
                .iter()
                .for_each(|&group| found(group));
        }
    }

    /// The groups below any entry, from left to right.
    pub(super) fn groups_below(&self, entry: usize, binary: &[u32], mut found: impl FnMut(u32)) {
        let mut stack = vec![entry];
        while let Some(i) = stack.pop() {
            let Entry { first, groups, .. } = self.entries[i];
            let first = first as usize;
            if groups == 0 {
                stack.extend([first + 1, first]);
            } else {
                binary[first..first + groups as usize]
                    .iter()
                    .for_each(|&group| found(group));
            }
        }
    }
}

/// The nodes of the binary tree level by level, and the range of each level.
fn breadth_first(binary: &Bvh2) -> (Vec<Entry>, Vec<std::ops::Range<usize>>) {
    let mut entries = Vec::with_capacity(binary.nodes.len());
    let mut levels = Vec::new();
    let mut level = vec![0u32];
    while !level.is_empty() {
        let start = entries.len();
        let mut next = Vec::new();
        let mut first_below = start + level.len();
        for &i in &level {
            let node = &binary.nodes[i as usize];
            let mut entry = Entry {
                first: node.first_index,
                groups: node.prim_count,
                half_area: node.aabb().half_area(),
                decision: Decision::default(),
            };
            if !node.is_leaf() {
                next.extend([node.first_index, node.first_index + 1]);
                entry.first = first_below as u32;
                first_below += 2;
            }
            entries.push(entry);
        }
        levels.push(start..entries.len());
        level = next;
    }
    (entries, levels)
}

fn leaf_cost(entry: &Entry, below: &Below) -> f32 {
    let packets = (below.items as usize).div_ceil(LANES) as f32;
    entry.half_area * (packets * PACKET_COST + below.others_cost)
}

fn inner(entry: &mut Entry, left: &Below, right: &Below) -> Below {
    let mut below = Below {
        items: left.items + right.items,
        others: left.others + right.others,
        others_cost: left.others_cost + right.others_cost,
        cost: [f32::INFINITY; ROOTS],
    };
    // The children of a node, or a forest of that many roots, with k of them on the left.
    let cheapest = |roots: usize| {
        let mut best = (1, f32::INFINITY);
        for k in 1.max(roots.saturating_sub(ROOTS))..=ROOTS.min(roots - 1) {
            let cost = left.cost[k - 1] + right.cost[roots - k - 1];
            if cost < best.1 {
                best = (k, cost);
            }
        }
        best
    };
    let (split, cost) = cheapest(Node::WIDTH);
    below.cost[0] = cost + entry.half_area;
    entry.decision.set(1, split);
    let alike = below.others == 0 || below.others == below.items;
    let leaf_cost = leaf_cost(entry, &below);
    if alike && below.items as usize <= LANES && leaf_cost <= below.cost[0] {
        below.cost[0] = leaf_cost;
        entry.decision = Decision::default();
    }
    for roots in 2..=ROOTS {
        let (split, cost) = cheapest(roots);
        below.cost[roots - 1] = below.cost[roots - 2];
        if cost < below.cost[roots - 2] {
            below.cost[roots - 1] = cost;
            entry.decision.set(roots, split);
        }
    }
    below
}
