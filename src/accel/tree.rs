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
    /// The ray hits a sphere at `t`. Returning `true` ends the traversal.
    fn ball(&mut self, id: PrimitiveId, t: f64) -> bool;
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

    /// Calls a visitor for everything that each of the rays may hit, in the order given by `O`.
    #[inline(always)]
    pub(super) fn traverse<O: Order, V: Visitors>(&self, rays: V) {
        self.instructions.run(Traversal {
            cells: &self.cells,
            rays,
            order: PhantomData::<O>,
        });
    }
}

/// Rays that traverse a tree one after the other, each with its visitor.
pub(super) trait Visitors {
    /// The visitor of one ray.
    type Visitor: Visitor;
    /// The next ray `o + t d`.
    fn next(&mut self) -> Option<(Vec3, Vec3, Self::Visitor)>;
    /// The visitor has seen all.
    fn finish(&mut self, visitor: Self::Visitor);
}

/// The traversal of a tree: one function for many rays, so that it is entered once.
struct Traversal<'a, O, V> {
    cells: &'a [Cell],
    rays: V,
    order: PhantomData<O>,
}

impl<O: Order, V: Visitors> Kernel for Traversal<'_, O, V> {
    type Output = ();

    #[inline(always)]
    fn run(mut self, with: impl Instructions) {
        while let Some((o, d, mut visitor)) = self.rays.next() {
            // Comparisons with NaN would let such rays into unused slots of nodes. (Directions have unit length, so the sum
            // is finite if both are.)
            if (o + d).is_finite() {
                let ray = TraversalRay::new(o, d);
                traverse::<O>(with, self.cells, &ray, &mut visitor);
            }
            self.rays.finish(visitor);
        }
    }
}

/// The way of one ray, until the visitor ends it.
#[inline(always)]
fn traverse<O: Order>(
    with: impl Instructions,
    cells: &[Cell],
    ray: &TraversalRay,
    visitor: &mut impl Visitor,
) {
    let mut stack = O::default();
    let mut current = Child::node(0);
    loop {
        let at = current.offset();
        let Some(here) = cells.get(at..) else {
            return;
        };
        if !current.is_leaf() {
            let Some(node) = StoredNode::first_of(here) else {
                return;
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
            return;
        }
        let Some(next) = stack.pop(visitor.t_max()) else {
            return;
        };
        current = next;
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
