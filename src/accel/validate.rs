//! The invariants of a built tree.

use super::aabb::Aabb;
use super::node::{Child, MAX_DEPTH, Node, StoredNode};
use super::packet::{LANES, StoredPacket};
use super::primitive::{Item, PrimitiveId};
use super::tree::Tree;
use std::collections::HashMap;

/// Levels that the traversal's stack has room for; see [`MAX_DEPTH`].
const LEVELS: usize = MAX_DEPTH + 12;

impl Tree {
    /// Walks the whole tree; the error names the invariant that is broken: every reference leads to a node or a leaf,
    /// boxes contain everything below them, every one of `items` is in exactly one leaf, and the number of nodes
    /// matches the count, no deeper than the traversal stack allows.
    pub(super) fn validate(&self, items: &[Item]) -> Result<(), String> {
        let bounds = items.iter().map(|item| (item.id, item.bounds));
        let mut walk = Validation {
            tree: self,
            expected: bounds.collect(),
            nodes: 0,
        };
        walk.node(Child::node(0), None, 0)?;
        if !walk.expected.is_empty() {
            return Err(format!("{} items are in no leaf", walk.expected.len()));
        }
        if walk.nodes != self.nodes {
            return Err(format!("{} nodes, counted as {}", walk.nodes, self.nodes));
        }
        Ok(())
    }
}

/// The state of a validation.
struct Validation<'a> {
    tree: &'a Tree,
    /// The boxes of the items not found yet, by their ids.
    expected: HashMap<PrimitiveId, Aabb>,
    nodes: usize,
}

impl Validation<'_> {
    /// Checks a node and all below it, which must lie in `outer`.
    fn node(&mut self, at: Child, outer: Option<Aabb>, depth: usize) -> Result<(), String> {
        if depth > LEVELS {
            return Err(format!("deeper than {LEVELS} levels"));
        }
        self.nodes += 1;
        let cells = self.tree.cells.get(at.offset()..).unwrap_or_default();
        let node = StoredNode::first_of(cells)
            .ok_or_else(|| format!("no node at cell {}", at.offset()))?;
        for slot in 0..Node::WIDTH {
            let bounds = node.bounds(slot);
            if bounds.is_empty() {
                continue;
            }
            if outer.is_some_and(|outer| outer.union(bounds) != outer) {
                return Err(format!(
                    "child {slot} of the node at {at:?} is outside its box"
                ));
            }
            let child = node.child(slot).seen_from(at.offset());
            if child.is_leaf() {
                self.leaf(child, bounds)?;
            } else {
                self.node(child, Some(bounds), depth + 1)?;
            }
        }
        Ok(())
    }

    /// Checks a leaf, whose items must lie in `outer`.
    fn leaf(&mut self, at: Child, outer: Aabb) -> Result<(), String> {
        let cells = self.tree.cells.get(at.offset()..).unwrap_or_default();
        let ids: Vec<PrimitiveId> = if at.has_others() {
            let cell = cells.first().ok_or_else(|| format!("no leaf at {at:?}"))?;
            bytemuck::cast::<_, [PrimitiveId; 8]>(*cell).to_vec()
        } else {
            let packet =
                StoredPacket::first_of(cells).ok_or_else(|| format!("no packet at {at:?}"))?;
            (0..LANES).map(|lane| packet.id(lane)).collect()
        };
        for id in ids.into_iter().filter(|&id| id != PrimitiveId::NONE) {
            let bounds = self.expected.remove(&id);
            let bounds = bounds.ok_or_else(|| format!("{id:?} is in two leaves, or no item"))?;
            if outer.union(bounds) != outer {
                return Err(format!("{id:?} is outside the box of its leaf"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::builder;
    use super::*;
    use crate::math::Vec3;
    use crate::math::hash::{mix2, unit_float};

    fn corners(id: PrimitiveId) -> [Vec3; 3] {
        let i = id.index() as u64;
        [0u64, 1, 2].map(|k| {
            let at = |axis| unit_float(mix2(i / 3, 9 * k + axis));
            Vec3::new(at(0), at(1), at(2))
        })
    }

    fn items(count: u32) -> Vec<Item> {
        let ids = (0..count).map(|i| PrimitiveId::triangle(i, false));
        ids.map(|id| Item {
            id,
            bounds: corners(id).into_iter().fold(Aabb::EMPTY, Aabb::with_point),
        })
        .collect()
    }

    #[test]
    fn built_trees_are_valid() {
        // One leaf, one node, a tree built on one thread, one on several, and one of chunks; every box occurs three times.
        for count in [0, 1, 3, 20, 1000, 20_000, 300_000] {
            let items = items(count);
            let tree = builder::build(items.clone(), corners);
            assert_eq!(tree.validate(&items), Ok(()), "{count}");
        }
    }

    #[test]
    fn damage_is_found() {
        let items = items(100);
        let damaged = |damage: fn(&mut Tree)| {
            let mut tree = builder::build(items.clone(), corners);
            damage(&mut tree);
            tree.validate(&items).expect_err("a broken invariant")
        };
        assert!(damaged(|tree| tree.nodes += 1).contains("counted"));
        assert!(damaged(|tree| tree.cells.truncate(Node::CELLS)).contains("no "));
        let fewer = builder::build(items[1..].to_vec(), corners);
        assert!(
            fewer
                .validate(&items)
                .is_err_and(|e| e.contains("in no leaf"))
        );
        assert!(fewer.validate(&items[2..]).is_err());
        let mut shifted = items.clone();
        shifted[7].bounds.max.x += 10.0;
        let tree = builder::build(items.clone(), corners);
        assert!(
            tree.validate(&shifted)
                .is_err_and(|e| e.contains("outside"))
        );
    }
}
