//! The innermost steps of traversal (ray-box tests), in the processor's vector instructions.
//!
//! With AVX2, eight boxes fit in one register instead of two; AVX-512 has an instruction that compresses the hit
//! children. Measured (`cargo bench --bench traversal`, AMD EPYC with AVX-512, geometric means over all rays): AVX2
//! saves 5 % of the time, prefetching 13 %, and AVX-512 another 3 %; any-hit searches gain 4 % from compression.

use super::node::{Cell, Child, Node, NodeHits, StoredNode};
use super::ray::TraversalRay;
use crate::math::instruction_set::{Instructions, Proof};
#[cfg(target_arch = "x86_64")]
use pulp::x86::V3;
#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::{__m256, _CMP_LE_OQ, _MM_HINT_T0, _mm_prefetch};

/// Which children's boxes the ray intersects between 0 and `t_max`, and where it enters them: [`StoredNode::test`].
#[inline(always)]
pub(super) fn test_boxes(
    with: impl Instructions,
    node: StoredNode,
    ray: &TraversalRay,
    t_max: f32,
) -> (u32, [f32; 8]) {
    match with.proof() {
        Proof::Baseline => node.test(ray, t_max),
        #[cfg(target_arch = "x86_64")]
        Proof::Avx2(v3) => test_with_avx2(v3, node, ray, t_max),
        #[cfg(target_arch = "x86_64")]
        Proof::Avx512(v4) => test_with_avx2(*v4, node, ray, t_max),
    }
}

/// Compresses the children in these slots to the front; the remaining entries are unspecified: [`NodeHits::compress`].
/// With AVX-512 there is no branch on their count, which would be mispredicted.
#[inline(always)]
pub(super) fn compress(
    with: impl Instructions,
    hits: &NodeHits,
    slots: u32,
) -> [Child; Node::WIDTH] {
    match with.proof() {
        #[cfg(target_arch = "x86_64")]
        Proof::Avx512(v4) => {
            let children = bytemuck::cast(*hits.node.children());
            let base = v4.avx._mm256_set1_epi32(hits.at as i32);
            let seen = v4.avx2._mm256_add_epi32(children, base);
            bytemuck::cast(v4.avx512f._mm256_maskz_compress_epi32(slots as u8, seen))
        }
        _ => hits.compress(slots),
    }
}

/// Prefetches the node or packet in cell `at`.
#[inline(always)]
pub(super) fn prefetch(cells: &[Cell], at: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        /// Cache lines that a node occupies; a packet occupies three.
        const LINES: usize = 4;
        let first = cells.as_ptr().wrapping_add(at);
        for line in 0..LINES {
            // SAFETY: a prefetch does not access memory, so any address is valid.
            #[expect(unsafe_code, reason = "measured: see above")]
            unsafe {
                _mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(2 * line).cast());
            }
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (cells, at);
}

/// [`StoredNode::test`], operation by operation.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn test_with_avx2(v3: V3, node: StoredNode, ray: &TraversalRay, t_max: f32) -> (u32, [f32; 8]) {
    let avx = v3.avx;
    let near = avx._mm256_max_ps(
        avx._mm256_max_ps(
            to_near_planes(v3, node, ray, 0),
            to_near_planes(v3, node, ray, 1),
        ),
        avx._mm256_max_ps(to_near_planes(v3, node, ray, 2), avx._mm256_setzero_ps()),
    );
    let far = avx._mm256_min_ps(
        avx._mm256_min_ps(
            to_far_planes(v3, node, ray, 0),
            to_far_planes(v3, node, ray, 1),
        ),
        to_far_planes(v3, node, ray, 2),
    );
    let end = avx._mm256_min_ps(far, avx._mm256_set1_ps(t_max));
    let hit = avx._mm256_cmp_ps::<_CMP_LE_OQ>(near, end);
    (avx._mm256_movemask_ps(hit) as u32, bytemuck::cast(near))
}

/// Distances at which the ray enters the children's slabs in one axis.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn to_near_planes(v3: V3, node: StoredNode, ray: &TraversalRay, axis: usize) -> __m256 {
    let planes = bytemuck::cast(*node.planes(axis, ray.near_side[axis]));
    to_planes(v3, planes, ray.near_origin[axis], ray.inverse[axis])
}

/// Distances at which the ray leaves them.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn to_far_planes(v3: V3, node: StoredNode, ray: &TraversalRay, axis: usize) -> __m256 {
    let planes = bytemuck::cast(*node.planes(axis, 1 - ray.near_side[axis]));
    to_planes(v3, planes, ray.far_origin[axis], ray.far_inverse[axis])
}

// A function, not a closure: where LLVM does not inline a closure, it compiles it without the target features of the
// enclosing function.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn to_planes(v3: V3, planes: __m256, origin: f32, inverse: f32) -> __m256 {
    let avx = v3.avx;
    let from = avx._mm256_sub_ps(planes, avx._mm256_set1_ps(origin));
    avx._mm256_mul_ps(from, avx._mm256_set1_ps(inverse))
}

#[cfg(test)]
mod tests {
    use super::super::aabb::Aabb;
    use super::super::builder;

    use super::super::primitive::{Item, PrimitiveId};
    use super::super::stack::{LastFirst, NearestFirst, Order};
    use super::super::tree::{Tree, Visitor, Visitors};
    use crate::math::Vec3;
    use crate::math::hash::{mix2, unit_float};
    use crate::math::instruction_set::InstructionSet;

    /// Records everything it visits.
    struct Recorder {
        t_max: f32,
        seen: Vec<(PrimitiveId, u64)>,
    }

    impl Visitor for &mut Recorder {
        fn t_max(&self) -> f32 {
            self.t_max
        }

        fn triangle(&mut self, id: PrimitiveId, t: f64) -> bool {
            self.seen.push((id, t.to_bits()));
            self.t_max = self.t_max.min(t as f32);
            false
        }

        fn ball(&mut self, _: PrimitiveId, _: f64) -> bool {
            false
        }

        fn other(&mut self, _: PrimitiveId) -> bool {
            false
        }
    }

    /// One ray.
    struct One<'a>(Option<(Vec3, Vec3, &'a mut Recorder)>);

    impl<'a> Visitors for One<'a> {
        type Visitor = &'a mut Recorder;

        fn next(&mut self) -> Option<(Vec3, Vec3, &'a mut Recorder)> {
            self.0.take()
        }

        fn finish(&mut self, _: &'a mut Recorder) {}
    }

    #[test]
    fn all_instructions_see_the_same_in_the_same_order() {
        let point = |i: u64, k: u64| {
            let at = |axis| 2.0 * unit_float(mix2(i, 3 * k + axis)) - 1.0;
            Vec3::new(at(0), at(1), at(2))
        };
        let corners = |id: PrimitiveId| {
            let i = id.index() as u64;
            [1, 2, 3].map(|k| point(i, 0) + 0.1 * point(i, k))
        };
        let items: Vec<Item> = (0..5000)
            .map(|i| {
                let id = PrimitiveId::triangle(i, false);
                let bounds = corners(id).into_iter().fold(Aabb::EMPTY, Aabb::with_point);
                Item { id, bounds }
            })
            .collect();
        let mut tree = builder::build(items.clone(), corners);
        let mut hits = 0;
        for i in 0..2000 {
            let mut d = point(i, 11).normalize();
            if i % 4 == 0 {
                // Along the boxes' planes, with a zero of either sign.
                d = Vec3::new(if i % 8 == 0 { 0.0 } else { -0.0 }, d.y, d.z).normalize();
            }
            let o = point(i, 10);
            hits += compare::<NearestFirst>(&mut tree, o, d);
            compare::<LastFirst>(&mut tree, o, d);
        }
        assert!(hits > 1000, "{hits}");
    }

    /// The number of triangles visited, the same with every instruction set.
    fn compare<O: Order>(tree: &mut Tree, o: Vec3, d: Vec3) -> usize {
        let records = InstructionSet::available().into_iter().map(|set| {
            let mut recorder = Recorder {
                t_max: 3.0,
                seen: Vec::new(),
            };
            tree.instructions = set;
            tree.traverse::<O, _>(One(Some((o, d, &mut recorder))));
            recorder.seen
        });
        let records: Vec<_> = records.collect();
        assert!(records.windows(2).all(|pair| pair[0] == pair[1]));
        records[0].len()
    }
}
