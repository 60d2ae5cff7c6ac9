//! The 8-wide tree and its traversal.

use super::aabb::Aabb;
use super::box_test::test_boxes;
use super::node::{Cell, Child, Node, NodeHits, StoredNode};
use super::packet::StoredPacket;
use super::primitive::PrimitiveId;
use super::ray::TraversalRay;
use super::stack::Order;
use crate::math::Vec3;
use crate::math::instruction_set::{InstructionSet, Instructions, Kernel};
use std::marker::PhantomData;

/// An 8-wide bounding volume hierarchy.
#[derive(Default)]
pub(super) struct Tree {
    /// Nodes and leaves; the root comes first.
    pub cells: Vec<Cell>,
    /// Number of nodes.
    pub nodes: usize,
    /// The instruction set used for traversal.
    pub instructions: InstructionSet,
}

/// Receives the primitives that a traversal reaches.
pub(super) trait Visitor {
    /// Anything at or beyond this distance is ignored.
    fn t_max(&self) -> f32;
    /// The ray hits a triangle at `t`. Returning `true` ends the traversal.
    fn triangle(&mut self, id: PrimitiveId, t: f64) -> bool;
    /// The ray may hit a non-triangle primitive. Returning `true` ends the traversal.
    fn other(&mut self, id: PrimitiveId) -> bool;
}

impl Tree {
    /// Memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.cells[..])
    }

    /// The boxes of the root's children.
    pub(super) fn parts(&self) -> impl Iterator<Item = Aabb> + '_ {
        let root = StoredNode::first_of(&self.cells).into_iter();
        root.flat_map(|root| (0..Node::WIDTH).map(move |slot| root.bounds(slot)))
            .filter(|bounds| !bounds.is_empty())
    }

    /// Calls `visitor` for everything that the ray `o + t d` may hit, in the order given by `O`. Returns `true` if the
    /// visitor ended the traversal.
    #[inline(always)]
    pub(super) fn traverse<O: Order>(&self, o: Vec3, d: Vec3, visitor: &mut impl Visitor) -> bool {
        self.instructions.run(Traversal {
            cells: &self.cells,
            o,
            d,
            visitor,
            order: PhantomData::<O>,
        })
    }
}

/// The traversal of a tree by one ray.
struct Traversal<'a, O, V> {
    cells: &'a [Cell],
    o: Vec3,
    d: Vec3,
    visitor: &'a mut V,
    order: PhantomData<O>,
}

impl<O: Order, V: Visitor> Kernel for Traversal<'_, O, V> {
    type Output = bool;

    #[inline(always)]
    fn run(self, with: impl Instructions) -> bool {
        let Traversal { cells, visitor, .. } = self;
        let ray = &TraversalRay::new(self.o, self.d);
        let mut stack = O::default();
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
                let (mask, near) = test_boxes(with, node, ray, visitor.t_max());
                let hits = NodeHits {
                    node,
                    at,
                    mask,
                    near,
                };
                if mask != 0 {
                    current = stack.choose(with, hits, cells);
                    continue;
                }
            } else if visit_leaf(current, here, ray, visitor) {
                return true;
            }
            let Some(next) = stack.pop(visitor.t_max()) else {
                return false;
            };
            current = next;
        }
    }
}

/// Calls the visitor for the primitives of the leaf that starts with the first cell.
#[inline(always)]
fn visit_leaf(leaf: Child, cells: &[Cell], ray: &TraversalRay, visitor: &mut impl Visitor) -> bool {
    if leaf.has_others() {
        let first = cells.first();
        let ids: [PrimitiveId; 8] =
            first.map_or([PrimitiveId::NONE; 8], |&cell| bytemuck::cast(cell));
        return ids
            .into_iter()
            .take_while(|id| id.is_other())
            .any(|id| visitor.other(id));
    }
    let Some(packet) = StoredPacket::first_of(cells) else {
        return false;
    };
    packet.test(ray, visitor.t_max(), |id, t| visitor.triangle(id, t))
}
