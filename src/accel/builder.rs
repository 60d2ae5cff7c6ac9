//! Builds the 8-wide tree: obvhs makes a binary one, and [`Plan`] says which of its nodes to keep. That of many primitives is made of
//! [chunks](Chunk).
//!
//! The tree depends only on the primitives, not on the number of threads that build it.

use super::aabb::Aabb;
use super::chunks::Chunk;
use super::collapse::{Plan, Root};
use super::groups::Groups;
use super::node::{Cell, Child, MAX_DEPTH, Node};
use super::packet::{LANES, Packet};
use super::primitive::{Item, PrimitiveId};
use super::tree::Tree;
use crate::math::Vec3;
use crate::math::instruction_set::InstructionSet;
use crate::pages::ask_for_large;
use arrayvec::ArrayVec;
use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::build_bvh2;
use rayon::prelude::*;
use std::ops::Range;

/// Subtrees are built in parallel down to this depth: 64 pieces, enough to keep threads busy even though their sizes
/// differ.
const PARALLEL_DEPTH: usize = 2;

/// Trees with fewer primitives are built on one thread, in a millisecond.
const PARALLEL_ITEMS: usize = 1 << 12;

/// Two leaves are merged even if that makes them more expensive to visit by up to this fraction: rays are as fast, and
/// a triangle takes 3 to 5 bytes less.
const SPARE: f32 = 0.4;

/// Limit on the number of boxes times their average overlap, up to which the binary builder's reinsertion runs in full:
/// about a second. Ordinary meshes of a million triangles have 10⁷; 2.5 million triangles as large as the scene, 10¹²,
/// would take a minute.
const AFFORDABLE_VISITS: f64 = 5e9;

/// Chunks are gathered in blocks of so many bytes: so many that their memory comes from the system and goes back to it at once, which
/// glibc does from 32 MiB on, as blocks are freed while the tree is joined. What of them is not used takes no memory.
pub(super) const BLOCK: usize = 33 << 20;

/// The output of the binary builder and the plan, and the primitives.
struct Source<'a, F> {
    items: &'a [Item],
    corners: F,
    groups: Groups,
    plan: Plan,
    /// Groups in the order of the binary tree's leaves.
    indices: Vec<u32>,
}

/// Builds a tree over `items`, whose boxes are finite; `corners` returns a triangle's corners.
pub(super) fn build(
    mut items: Vec<Item>,
    corners: impl Fn(PrimitiveId) -> [Vec3; 3] + Sync,
) -> Tree {
    if items.is_empty() {
        return Tree {
            cells: Node::empty().cells().to_vec(),
            nodes: 1,
            instructions: InstructionSet::best(),
        };
    }
    let all = cfg!(debug_assertions).then(|| items.clone());
    let build = Build {
        reinsertion: affordable_share(&items),
        corners,
    };
    let chunks = Chunk::of(&mut items);
    let mut blocks = Blocks::for_chunks(&chunks);
    build.chunks(&[&chunks], &mut items, (0, 1), &mut blocks);
    let tree = blocks.joined();
    debug_assert_eq!(all.map_or(Ok(()), |all| tree.validate(&all)), Ok(()));
    tree
}

/// What all chunks have in common.
struct Build<F> {
    /// The share of the usual node reinsertions.
    reinsertion: f32,
    corners: F,
}

impl<F: Fn(PrimitiveId) -> [Vec3; 3] + Sync> Build<F> {
    /// Builds the last of the items, as they are divided into these chunks, and removes them. They become up to so many roots each,
    /// at this depth of the whole: returns their cells and bounding boxes.
    fn chunks(
        &self,
        chunks: &[&Chunk],
        items: &mut Vec<Item>,
        (depth, roots): (usize, usize),
        to: &mut Blocks,
    ) -> Vec<(usize, Aabb)> {
        let build = |range: &Range<usize>| self.built(&items[range.clone()], depth, roots);
        let (first, built) = match chunks {
            [Chunk::Items(range)] => (range.start, vec![build(range)]),
            // Two side by side take more memory, but less time.
            [Chunk::Items(a), Chunk::Items(b)] => {
                let (a_built, b_built) = rayon::join(|| build(a), || build(b));
                (a.start, vec![a_built, b_built])
            }
            _ => {
                let last_first = chunks.iter().rev();
                return last_first
                    .flat_map(|chunk| match chunk {
                        Chunk::Items(_) => self.chunks(&[chunk], items, (depth, roots), to),
                        Chunk::Halves(..) => vec![self.above(chunk, items, depth, to)],
                    })
                    .collect();
            }
        };
        items.truncate(first);
        // Their memory is wanted for the next trees.
        items.shrink_to_fit();
        let built = built.into_iter().flatten();
        built
            .map(|(pieces, bounds)| (to.add(pieces), bounds))
            .collect()
    }

    /// Builds the node above what the items are divided into, and all below it.
    fn above(
        &self,
        chunk: &Chunk,
        items: &mut Vec<Item>,
        depth: usize,
        to: &mut Blocks,
    ) -> (usize, Aabb) {
        let mut node = Tree::default();
        let mut children = reserve_node(&mut node);
        let at = to.add(Pieces(vec![node]));
        let parts = chunk.parts();
        // As many children as a node has room for; where there are fewer parts, these are not divided any more.
        let roots = Node::WIDTH / parts.len();
        for pair in parts.rchunks(2) {
            for (root, bounds) in self.chunks(pair, items, (depth + 1, roots), to) {
                children.push((Child::node(root - at), bounds));
            }
        }
        (at, finish(children, to.from(at)))
    }

    /// Builds these items, of which there is at least one.
    fn built(&self, items: &[Item], depth: usize, roots: usize) -> Vec<(Pieces, Aabb)> {
        let groups = Groups::of(items);
        let usual = BvhBuildParams::very_fast_build();
        let parameters = BvhBuildParams {
            // The plan forms the leaves.
            max_prims_per_leaf: 1,
            // The plan makes up for what slower presets improve: they take up to three times as long, for rays that are a
            // few per cent faster at most.
            reinsertion_batch_ratio: usual.reinsertion_batch_ratio * self.reinsertion,
            ..usual
        };
        let mut binary = build_bvh2(&groups.boxes(items), parameters, &mut Default::default());
        let plan = Plan::new(&binary, &groups, items);
        // Frees a third of the memory used while building.
        binary.nodes = Vec::new();
        let source = Source {
            items,
            corners: &self.corners,
            groups,
            plan,
            indices: binary.primitive_indices,
        };
        let parallel_levels = if items.len() >= PARALLEL_ITEMS {
            PARALLEL_DEPTH
        } else {
            0
        };
        let mut entries = ArrayVec::new();
        source.plan.forest(0, roots, &mut entries);
        let build = |entry| {
            let root = source.planned(entry, depth);
            let parts = match root {
                // Every tree starts with a node.
                Part::Leaf(..) => Parts::from_iter([root]),
                _ => source.divided(&root),
            };
            source.pieces(&parts, parallel_levels)
        };
        entries.into_iter().map(build).collect()
    }
}

/// The share of the usual node reinsertions that is affordable: all of them, unless boxes overlap excessively. One
/// search visits every overlapping node, about the summed area of the boxes divided by that of their bounding box, and
/// there is one search per box.
fn affordable_share(items: &[Item]) -> f32 {
    // In fixed chunks, so that the sum does not depend on the number of threads.
    let half_area = |item: &Item| f64::from(item.bounds.half_area());
    let chunks = items.par_chunks(PARALLEL_ITEMS);
    let areas: Vec<f64> = chunks
        .map(|items| items.iter().map(half_area).sum())
        .collect();
    let area: f64 = areas.iter().sum();
    let boxes = items.par_iter().map(|item| item.bounds);
    let all = boxes.reduce(|| Aabb::EMPTY, Aabb::union);
    let visits = items.len() as f64 * area / f64::from(all.half_area());
    // NaN (areas that overflow, or no boxes) does not reduce the search.
    if visits > AFFORDABLE_VISITS {
        (AFFORDABLE_VISITS / visits) as f32
    } else {
        1.0
    }
}

/// A future child of a node.
enum Part {
    /// A leaf with up to four items of one kind, and its bounding box.
    Leaf(ArrayVec<PrimitiveId, LANES>, Aabb),
    /// A node with these entries of the plan below it, and its depth.
    Planned(ArrayVec<usize, { Node::WIDTH }>, usize),
    /// Items that the plan does not subdivide.
    Heap(Vec<u32>),
}

type Parts = ArrayVec<Part, { Node::WIDTH }>;

impl<F: Fn(PrimitiveId) -> [Vec3; 3] + Sync> Source<'_, F> {
    /// The part that an entry of the plan becomes.
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

    /// A leaf if the items fit in one.
    fn of_items(&self, mut items: impl Iterator<Item = u32>) -> Part {
        let first: ArrayVec<u32, LANES> = items.by_ref().take(LANES).collect();
        let Some(next) = items.next() else {
            let (mut ids, mut bounds) = (ArrayVec::<PrimitiveId, LANES>::new(), Aabb::EMPTY);
            for &i in &first {
                let item = &self.items[i as usize];
                ids.push(item.id);
                bounds = bounds.union(item.bounds);
            }
            let triangles = ids.iter().filter(|id| id.is_triangle()).count();
            return if triangles == 0 || triangles == ids.len() {
                Part::Leaf(ids, bounds)
            } else {
                Part::Heap(first.to_vec())
            };
        };
        let items = first.into_iter().chain([next]).chain(items);
        Part::Heap(items.collect())
    }

    /// The children of a part that is not a leaf.
    fn divided(&self, part: &Part) -> Parts {
        match part {
            Part::Leaf(..) => Parts::new(),
            Part::Planned(children, depth) => {
                let mut parts = children
                    .iter()
                    .map(|&child| self.planned(child, depth + 1))
                    .collect();
                join_leaves(&mut parts);
                parts
            }
            Part::Heap(items) => items
                .chunks(items.len().div_ceil(Node::WIDTH))
                .map(|part| self.of_items(part.iter().copied()))
                .collect(),
        }
    }

    /// Adds a node with `parts` as its children and everything below it; returns its bounding box.
    fn add(&self, parts: &[Part], to: &mut Tree) -> Aabb {
        let at = to.cells.len();
        let mut children = self.start(parts, to);
        for part in parts.iter().filter(|part| !part.is_leaf()) {
            let child = Child::node(to.cells.len() - at);
            children.push((child, self.add(&self.divided(part), to)));
        }
        finish(children, &mut to.cells[at..])
    }

    /// Like `add`, building subtrees in parallel down to so many levels.
    fn pieces(&self, parts: &[Part], parallel_levels: usize) -> (Pieces, Aabb) {
        let mut tree = Tree::default();
        if parallel_levels == 0 {
            let bounds = self.add(parts, &mut tree);
            return (Pieces(vec![tree]), bounds);
        }
        let mut children = self.start(parts, &mut tree);
        let inner: Vec<&Part> = parts.iter().filter(|part| !part.is_leaf()).collect();
        let build = |part: &Part| self.pieces(&self.divided(part), parallel_levels - 1);
        let below: Vec<(Pieces, Aabb)> = inner.into_par_iter().map(build).collect();
        let mut offset = tree.cells.len();
        for (pieces, bounds) in &below {
            children.push((Child::node(offset), *bounds));
            offset += pieces.cells();
        }
        let all = finish(children, &mut tree.cells);
        let below = below.into_iter().flat_map(|(pieces, _)| pieces.0);
        (Pieces([tree].into_iter().chain(below).collect()), all)
    }

    /// Reserves a node, and adds the leaves among its children.
    fn start(&self, parts: &[Part], to: &mut Tree) -> Children {
        let at = to.cells.len();
        reserve_node(to);
        let leaf = |part: &Part| {
            let Part::Leaf(ids, bounds) = part else {
                return None;
            };
            let offset = to.cells.len() - at;
            if !ids.iter().all(|id| id.is_triangle()) {
                let mut cell = [PrimitiveId::NONE; 8];
                cell[..ids.len()].copy_from_slice(ids);
                to.cells.push(bytemuck::cast(cell));
                return Some((Child::others(offset), *bounds));
            }
            let mut packet = Packet::empty();
            for (lane, &id) in ids.iter().enumerate() {
                packet.set_triangle(lane, id, (self.corners)(id));
            }
            to.cells.extend(packet.cells());
            Some((Child::triangles(offset), *bounds))
        };
        parts.iter().filter_map(leaf).collect()
    }
}

impl Part {
    fn is_leaf(&self) -> bool {
        matches!(self, Part::Leaf(..))
    }
}

/// A node's children with their boxes.
type Children = ArrayVec<(Child, Aabb), { Node::WIDTH }>;

/// Reserves a node, which has no children yet.
fn reserve_node(to: &mut Tree) -> Children {
    to.cells.extend(Node::empty().cells());
    to.nodes += 1;
    Children::new()
}

/// Writes the node to the first cells; returns its bounding box.
fn finish(mut children: Children, cells: &mut [Cell]) -> Aabb {
    // An any-hit search pops the last child first, and is served best by the largest.
    children.sort_by(|(_, a), (_, b)| a.half_area().total_cmp(&b.half_area()));
    let (mut node, mut all) = (Node::empty(), Aabb::EMPTY);
    for (slot, &(child, bounds)) in children.iter().enumerate() {
        node.set(slot, child, bounds);
        all = all.union(bounds);
    }
    cells[..Node::CELLS].copy_from_slice(&node.cells());
    all
}

/// A tree in pieces, one after the other.
struct Pieces(Vec<Tree>);

impl Pieces {
    fn cells(&self) -> usize {
        self.0.iter().map(|piece| piece.cells.len()).sum()
    }
}

/// A tree as it grows, in blocks one after the other.
struct Blocks {
    blocks: Vec<Vec<Cell>>,
    /// Cells that a block has room for; pieces with more are blocks of their own.
    room: usize,
    /// Number of nodes.
    nodes: usize,
}

impl Blocks {
    fn for_chunks(chunks: &Chunk) -> Blocks {
        Blocks {
            blocks: Vec::new(),
            room: match chunks {
                Chunk::Items(_) => 0,
                Chunk::Halves(..) => BLOCK / size_of::<Cell>(),
            },
            nodes: 0,
        }
    }

    fn cells(&self) -> usize {
        self.blocks.iter().map(Vec::len).sum()
    }

    /// Returns the number of the first cell.
    fn add(&mut self, pieces: Pieces) -> usize {
        let at = self.cells();
        for Tree { cells, nodes, .. } in pieces.0 {
            self.nodes += nodes;
            match self.blocks.last_mut() {
                Some(last) if last.capacity() - last.len() >= cells.len() => last.extend(cells),
                _ if cells.len() >= self.room => self.blocks.push(cells),
                _ => {
                    let mut block = Vec::with_capacity(self.room);
                    block.extend(cells);
                    self.blocks.push(block);
                }
            }
        }
        at
    }

    /// The rest of the block that a cell is in, from there on.
    fn from(&mut self, mut cell: usize) -> &mut [Cell] {
        for block in &mut self.blocks {
            if cell < block.len() {
                return &mut block[cell..];
            }
            cell -= block.len();
        }
        &mut []
    }

    /// Children are addressed relative to their node, so concatenation suffices. (Space is reserved at once: a growing
    /// vector of cells would be copied at every growth, because of their alignment.)
    fn joined(self) -> Tree {
        let mut tree = Tree {
            cells: Vec::with_capacity(self.cells()),
            nodes: self.nodes,
            instructions: InstructionSet::best(),
        };
        // Before the first access: even writing zeros would already map small pages.
        ask_for_large(tree.cells.spare_capacity_mut());
        for block in self.blocks {
            tree.cells.extend_from_slice(&block);
        }
        tree
    }
}

/// Merges two of the leaves among the parts, repeatedly, as long as that is cheaper.
fn join_leaves(parts: &mut Parts) {
    let joined = |a: &Part, b: &Part| match (a, b) {
        (Part::Leaf(a, in_a), Part::Leaf(b, in_b))
            if a.len() + b.len() <= LANES && a.iter().chain(b).all(|id| id.is_triangle()) =>
        {
            let saved = in_a.half_area() + in_b.half_area() - in_a.union(*in_b).half_area();
            let apart = in_a.half_area() + in_b.half_area();
            (saved > -SPARE * apart).then_some(saved)
        }
        _ => None,
    };
    loop {
        let pairs = (1..parts.len()).flat_map(|i| (0..i).map(move |j| (j, i)));
        let best = pairs
            .filter_map(|(j, i)| Some((joined(&parts[j], &parts[i])?, j, i)))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, j, i)) = best else { return };
        let taken = parts.swap_remove(i);
        if let (Part::Leaf(to, bounds), Part::Leaf(ids, others)) = (&mut parts[j], taken) {
            to.extend(ids);
            *bounds = bounds.union(others);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_boxes_that_overlap_without_end_are_searched_less() {
        // Boxes in a row, and boxes that all cover the whole, `i` times.
        let item = |i: u32, min: f32, max: f32| Item {
            id: PrimitiveId::triangle(i, false),
            bounds: Aabb {
                min: Vec3::splat(min),
                max: Vec3::splat(max),
            },
        };
        let row: Vec<Item> = (0..100_000)
            .map(|i| item(i, i as f32, i as f32 + 1.0))
            .collect();
        assert_eq!(affordable_share(&row), 1.0);
        let alike = vec![item(0, 0.0, 1.0); 100_000];
        // 10⁵ boxes that cover everything 10⁵ times.
        let expected = AFFORDABLE_VISITS / 1e10;
        assert!((f64::from(affordable_share(&alike)) / expected - 1.0).abs() < 1e-6);
        // Points, and no boxes at all.
        assert_eq!(affordable_share(&[item(0, 1.0, 1.0); 3]), 1.0);
    }
}
