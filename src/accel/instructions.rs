//! The vector instructions of the processor at hand.
//!
//! The crate is built for the least common processor, so that one binary runs everywhere. The way
//! through a tree is compiled once more for AVX2, where eight boxes are one register and not two, and
//! for AVX-512, whose twice as many registers hold a whole ray; the best is taken at run time. The
//! results are the same to the bit: the same operations are done in the same order, and neither
//! Rust nor LLVM merges a product and a sum by itself.
//!
//! This is the one place of the traversal with `unsafe`, and it is measured to be worth it
//! (`cargo bench --bench traversal`, AMD EPYC with AVX-512, geometric means over all rays): AVX2 saves
//! 5 % of the time, fetching ahead 13 %, and AVX-512 another 3 %; its instruction that puts hit children
//! side by side saves searches for any hit 4 %.

use super::node::{Cell, Child, Node, StoredNode};
use super::ray::TraversalRay;
use super::stack::{Hits, Order};
use super::tree::{Tree, Visitor};
use crate::math::Vec3;
#[cfg(target_arch = "x86_64")]
use crate::processor::{Avx2, Avx512};

/// What is done differently with each set of instructions.
pub(super) trait Instructions: Copy {
    /// Which children's boxes the ray meets between 0 and `t_max`, and where it enters them.
    fn boxes(self, node: StoredNode, ray: &TraversalRay, t_max: f32) -> (u32, [f32; 8]);
    /// The children in these slots, side by side from the first; anything after them.
    #[inline(always)]
    fn compress(self, hits: &Hits, mut slots: u32) -> [Child; Node::WIDTH] {
        let mut children = [Child::node(0); Node::WIDTH];
        let mut count = 0;
        while slots != 0 {
            children[count & 7] = hits.child(slots.trailing_zeros());
            count += 1;
            slots &= slots - 1;
        }
        children
    }
    /// Says that the node or packet in cell `at` will be wanted soon.
    fn prefetch(self, cells: &[Cell], at: usize);
}

/// What every processor has.
#[derive(Clone, Copy)]
struct Baseline;

impl Instructions for Baseline {
    #[inline(always)]
    fn boxes(self, node: StoredNode, ray: &TraversalRay, t_max: f32) -> (u32, [f32; 8]) {
        node.test(ray, t_max)
    }

    #[inline(always)]
    fn prefetch(self, cells: &[Cell], at: usize) {
        #[cfg(target_arch = "x86_64")]
        x86::prefetch(cells, at);
        #[cfg(not(target_arch = "x86_64"))]
        let _ = (cells, at);
    }
}

/// Which instructions to use, found once for a tree.
#[derive(Clone, Copy, Default)]
pub(super) enum Best {
    /// [`Baseline`].
    #[default]
    Baseline,
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512),
}

impl Best {
    /// The best of this processor.
    pub fn find() -> Best {
        #[cfg(target_arch = "x86_64")]
        {
            let avx512 = Avx512::find().map(Best::Avx512);
            avx512
                .or_else(|| Avx2::find().map(Best::Avx2))
                .unwrap_or_default()
        }
        #[cfg(not(target_arch = "x86_64"))]
        Best::Baseline
    }

    /// [`Tree::traverse`] along `o + t d` with these instructions.
    #[inline(always)]
    fn traverse<O: Order>(self, tree: &Tree, o: Vec3, d: Vec3, visitor: &mut impl Visitor) -> bool {
        match self {
            Best::Baseline => tree.traverse::<O>(Baseline, o, d, visitor),
            #[cfg(target_arch = "x86_64")]
            Best::Avx2(proof) => x86::traverse::<O>(proof, tree, o, d, visitor),
            #[cfg(target_arch = "x86_64")]
            Best::Avx512(proof) => x86::traverse_512::<O>(proof, tree, o, d, visitor),
        }
    }
}

/// [`Tree::traverse`] along `o + t d` with the best instructions of this processor.
#[inline(always)]
pub(super) fn traverse<O: Order>(
    tree: &Tree,
    o: Vec3,
    d: Vec3,
    visitor: &mut impl Visitor,
) -> bool {
    tree.instructions.traverse::<O>(tree, o, d, visitor)
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::*;
    use std::arch::x86_64::*;

    /// Lines of the cache that a node takes; a packet takes three.
    const LINES: usize = 4;

    #[inline(always)]
    pub fn prefetch(cells: &[Cell], at: usize) {
        let first = cells.as_ptr().wrapping_add(at);
        for line in 0..LINES {
            // SAFETY: fetching ahead reads nothing: no address is wrong for it.
            #[expect(unsafe_code, reason = "measured: see above")]
            unsafe {
                _mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(2 * line).cast());
            }
        }
    }

    /// [`Tree::traverse`] with AVX2.
    #[inline]
    pub fn traverse<O: Order>(
        proof: Avx2,
        tree: &Tree,
        o: Vec3,
        d: Vec3,
        visitor: &mut impl Visitor,
    ) -> bool {
        // SAFETY: the proof is of all that the function is compiled for.
        #[expect(unsafe_code, reason = "measured: see above")]
        unsafe {
            traverse_avx2::<O>(proof, tree, o, d, visitor)
        }
    }

    /// [`Tree::traverse`] with AVX-512.
    #[inline]
    pub fn traverse_512<O: Order>(
        proof: Avx512,
        tree: &Tree,
        o: Vec3,
        d: Vec3,
        visitor: &mut impl Visitor,
    ) -> bool {
        // SAFETY: the proof is of all that the function is compiled for.
        #[expect(unsafe_code, reason = "measured: see above")]
        unsafe {
            traverse_avx512::<O>(proof, tree, o, d, visitor)
        }
    }

    impl Instructions for Avx2 {
        #[inline(always)]
        fn boxes(self, node: StoredNode, ray: &TraversalRay, t_max: f32) -> (u32, [f32; 8]) {
            // SAFETY: `self` is proof of all that the function is compiled for.
            #[expect(unsafe_code, reason = "measured: see above")]
            unsafe {
                boxes(node, ray, t_max)
            }
        }

        #[inline(always)]
        fn prefetch(self, cells: &[Cell], at: usize) {
            prefetch(cells, at);
        }
    }

    impl Instructions for Avx512 {
        #[inline(always)]
        fn boxes(self, node: StoredNode, ray: &TraversalRay, t_max: f32) -> (u32, [f32; 8]) {
            self.avx2().boxes(node, ray, t_max)
        }

        #[inline(always)]
        fn prefetch(self, cells: &[Cell], at: usize) {
            prefetch(cells, at);
        }

        #[inline(always)]
        fn compress(self, hits: &Hits, slots: u32) -> [Child; Node::WIDTH] {
            // SAFETY: `self` is proof of all that the function is compiled for.
            #[expect(unsafe_code, reason = "measured: see above")]
            unsafe {
                compress(hits, slots)
            }
        }
    }

    /// [`Instructions::compress`] without branches for how many there are: they could not be
    /// foreseen.
    #[target_feature(enable = "avx2,avx512f,avx512vl")]
    #[inline]
    fn compress(hits: &Hits, slots: u32) -> [Child; Node::WIDTH] {
        let children = bytemuck::cast(*hits.node.children());
        let seen = _mm256_add_epi32(children, _mm256_set1_epi32(hits.at as i32));
        bytemuck::cast(_mm256_maskz_compress_epi32(slots as u8, seen))
    }

    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    fn traverse_avx2<O: Order>(
        with: Avx2,
        tree: &Tree,
        o: Vec3,
        d: Vec3,
        visitor: &mut impl Visitor,
    ) -> bool {
        tree.traverse::<O>(with, o, d, visitor)
    }

    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512dq,avx512bw")]
    fn traverse_avx512<O: Order>(
        with: Avx512,
        tree: &Tree,
        o: Vec3,
        d: Vec3,
        visitor: &mut impl Visitor,
    ) -> bool {
        tree.traverse::<O>(with, o, d, visitor)
    }

    /// [`StoredNode::test`], operation by operation.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn boxes(node: StoredNode, ray: &TraversalRay, t_max: f32) -> (u32, [f32; 8]) {
        let planes =
            |axis: usize, side: usize| -> __m256 { bytemuck::cast(*node.planes(axis, side)) };
        let entering = |axis: usize| {
            let from = _mm256_sub_ps(
                planes(axis, ray.near_side[axis]),
                _mm256_set1_ps(ray.near_origin[axis]),
            );
            _mm256_mul_ps(from, _mm256_set1_ps(ray.inverse[axis]))
        };
        let leaving = |axis: usize| {
            let from = _mm256_sub_ps(
                planes(axis, 1 - ray.near_side[axis]),
                _mm256_set1_ps(ray.far_origin[axis]),
            );
            _mm256_mul_ps(from, _mm256_set1_ps(ray.far_inverse[axis]))
        };
        let near = _mm256_max_ps(
            _mm256_max_ps(entering(0), entering(1)),
            _mm256_max_ps(entering(2), _mm256_setzero_ps()),
        );
        let far = _mm256_min_ps(_mm256_min_ps(leaving(0), leaving(1)), leaving(2));
        let end = _mm256_min_ps(far, _mm256_set1_ps(t_max));
        let hit = _mm256_cmp_ps::<_CMP_LE_OQ>(near, end);
        (_mm256_movemask_ps(hit) as u32, bytemuck::cast(near))
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::super::aabb::Aabb;
    use super::super::builder;
    use super::super::packet::PrimitiveId;
    use super::super::stack::{LastFirst, NearestFirst};
    use super::super::tree::Item;
    use super::*;
    use crate::math::hash::{mix2, unit_float};

    /// Writes down all that it is shown.
    struct Scribe {
        t_max: f32,
        seen: Vec<(PrimitiveId, u64)>,
    }

    impl Visitor for Scribe {
        fn t_max(&self) -> f32 {
            self.t_max
        }

        fn triangle(&mut self, id: PrimitiveId, t: f64) -> bool {
            self.seen.push((id, t.to_bits()));
            self.t_max = self.t_max.min(t as f32);
            false
        }

        fn other(&mut self, _: PrimitiveId) -> bool {
            false
        }
    }

    #[test]
    fn all_instructions_see_the_same_in_the_same_order() {
        let sets: Vec<Best> = [
            Avx2::find().map(Best::Avx2),
            Avx512::find().map(Best::Avx512),
        ]
        .into_iter()
        .flatten()
        .collect();
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
        let tree = builder::build(&items, corners);
        let mut hits = 0;
        for i in 0..2000 {
            let mut d = point(i, 11).normalize();
            if i % 4 == 0 {
                // Along planes of boxes, and with a zero of either sign.
                d = Vec3::new(if i % 8 == 0 { 0.0 } else { -0.0 }, d.y, d.z).normalize();
            }
            let o = point(i, 10);
            hits += compare::<NearestFirst>(&tree, &sets, o, d);
            compare::<LastFirst>(&tree, &sets, o, d);
        }
        assert!(hits > 1000, "{hits}");
    }

    /// How many triangles all instructions see.
    fn compare<O: Order>(tree: &Tree, sets: &[Best], o: Vec3, d: Vec3) -> usize {
        let seen_with = |set: Best| {
            let mut scribe = Scribe {
                t_max: 3.0,
                seen: Vec::new(),
            };
            set.traverse::<O>(tree, o, d, &mut scribe);
            scribe.seen
        };
        let expected = seen_with(Best::Baseline);
        for &set in sets {
            assert_eq!(seen_with(set), expected);
        }
        expected.len()
    }
}
