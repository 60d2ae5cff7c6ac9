//! What primitives and trees take in memory, in bytes, for forecasts.

use super::aabb::Aabb;
use super::builder::BLOCK;
use super::chunks::Chunk;
use super::curves::CurveStore;
use super::instance::Instance;
use super::level::StoredQuadric;
use super::primitive::Item;
use crate::handles::ObjectId;
use crate::math::transform::Transform;
use crate::shapes::quadric::Quadric;

/// A primitive's part of a finished tree. Measured for triangles: 79 on a grid and 66 on a ball, of the 97 and 84 that
/// they have with vertices (docs/performance.md).
pub const TREE: u64 = 79;

/// A primitive's part of all that there is at once while a chunk of a tree is built (obvhs 0.4, parallel): its item and box, the
/// binary tree's two nodes and index, two nodes of the lists that are merged, and half a sorting key of 32 bytes.
const BUILDING: u64 = {
    let aabb = size_of::<obvhs::aabb::Aabb>();
    let node = size_of::<obvhs::bvh2::node::Bvh2Node>();
    (ITEM + aabb + 2 * node + 4 + 2 * node + 16) as u64
};

const ITEM: usize = size_of::<Item>();

/// What there is at most at once while the tree of so many primitives is built: two chunks are, while the others are items or done; or
/// chunks are joined.
pub fn building(primitives: usize) -> u64 {
    let (all, chunk) = (primitives as u64, Chunk::most(primitives) as u64);
    if all <= chunk {
        return all * BUILDING;
    }
    let first = all * ITEM as u64 + 2 * chunk * BUILDING;
    let last = all * TREE + 2 * chunk * (BUILDING - TREE);
    first.max(last).max(all * TREE + BLOCK as u64)
}

/// A quadric that was placed but not yet stored.
pub const QUADRIC: usize = size_of::<Quadric>();

/// A quadric as trees refer to it.
pub const STORED_QUADRIC: usize = size_of::<StoredQuadric>();

/// An instance.
pub const INSTANCE: usize = size_of::<Instance>();

/// What an instance takes besides while the tree is built: as it was added, and its box.
pub const PLACING_INSTANCE: usize = size_of::<(ObjectId, Transform)>() + size_of::<Aabb>();

/// A curve, besides its segments.
pub const CURVE: usize = CurveStore::OWNER;

/// A segment of a curve.
pub const CURVE_SEGMENT: usize = CurveStore::SEGMENT;
