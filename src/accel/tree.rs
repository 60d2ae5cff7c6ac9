//! The 8-wide tree and a ray's way through it.

use super::aabb::Aabb;
use super::instructions::{Best, Instructions};
use super::node::{Cell, Child, Node, StoredNode};
use super::packet::{PrimitiveId, StoredPacket};
use super::ray::TraversalRay;
use super::stack::{Hits, Order};
use crate::math::Vec3;

/// Depth up to which the shape of the binary tree is kept. What is deeper (thousands of
/// primitives in one place) is split evenly, which takes at most 11 levels for 2³² primitives, and
/// one more where leaves would mix triangles and others.
pub(super) const MAX_DEPTH: usize = 32;

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

    /// The boxes of the root's children.
    pub fn parts(&self) -> impl Iterator<Item = Aabb> + '_ {
        let root = StoredNode::first_of(&self.cells).into_iter();
        root.flat_map(|root| (0..Node::WIDTH).map(move |slot| root.bounds(slot)))
            .filter(|bounds| !bounds.is_empty())
    }

    /// Shows `visitor` what the ray may meet, in the order that `O` says. Returns true where the visitor ended the traversal.
    #[inline(always)]
    pub fn traverse<O: Order>(
        &self,
        with: impl Instructions,
        o: Vec3,
        d: Vec3,
        visitor: &mut impl Visitor,
    ) -> bool {
        let ray = &TraversalRay::new(o, d);
        let cells = &self.cells[..];
        let mut waiting = O::new();
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
                let (mask, near) = with.boxes(node, ray, visitor.t_max());
                let hits = Hits {
                    node,
                    at,
                    mask,
                    near,
                };
                if mask != 0 {
                    current = waiting.choose(with, hits, cells);
                    continue;
                }
            } else if visit_leaf(current, here, ray, visitor) {
                return true;
            }
            let Some(next) = waiting.pop(visitor.t_max()) else {
                return false;
            };
            current = next;
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
