//! The vector instructions of the processor at hand.
//!
//! The crate is built for the least common processor, so that one binary runs everywhere. The way
//! through a tree is compiled once more for AVX2, which is taken at run time where it is there:
//! eight boxes then are one register and not two. The results are the same to the bit: the same
//! operations are done in the same order, and neither Rust nor LLVM merges a product and a sum by
//! itself.

use super::node::{Cell, StoredNode};
use super::ray::TraversalRay;
use super::tree::{Tree, Visitor};

/// What is done differently with each set of instructions.
pub(super) trait Instructions: Copy {
    /// Which children's boxes the ray meets between 0 and `t_max`, and where it enters them.
    fn boxes(self, node: StoredNode, ray: &TraversalRay, t_max: f32) -> (u32, [f32; 8]);
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

/// [`Tree::traverse`] with the best instructions of this processor.
#[inline]
pub(super) fn traverse<const ORDERED: bool>(
    tree: &Tree,
    ray: &TraversalRay,
    visitor: &mut impl Visitor,
) -> bool {
    #[cfg(target_arch = "x86_64")]
    if let Some(avx2) = x86::Avx2::find() {
        return avx2.traverse::<ORDERED>(tree, ray, visitor);
    }
    tree.traverse::<ORDERED>(Baseline, ray, visitor)
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
            unsafe { _mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(2 * line).cast()) }
        }
    }

    /// Proof that the processor has AVX2.
    #[derive(Clone, Copy)]
    pub struct Avx2(());

    impl Avx2 {
        #[inline]
        pub fn find() -> Option<Avx2> {
            is_x86_feature_detected!("avx2").then_some(Avx2(()))
        }

        #[inline]
        pub fn traverse<const ORDERED: bool>(
            self,
            tree: &Tree,
            ray: &TraversalRay,
            visitor: &mut impl Visitor,
        ) -> bool {
            // SAFETY: there is proof.
            unsafe { traverse::<ORDERED>(self, tree, ray, visitor) }
        }
    }

    impl Instructions for Avx2 {
        #[inline(always)]
        fn boxes(self, node: StoredNode, ray: &TraversalRay, t_max: f32) -> (u32, [f32; 8]) {
            // SAFETY: there is proof.
            unsafe { boxes(node, ray, t_max) }
        }

        #[inline(always)]
        fn prefetch(self, cells: &[Cell], at: usize) {
            prefetch(cells, at);
        }
    }

    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt")]
    fn traverse<const ORDERED: bool>(
        with: Avx2,
        tree: &Tree,
        ray: &TraversalRay,
        visitor: &mut impl Visitor,
    ) -> bool {
        tree.traverse::<ORDERED>(with, ray, visitor)
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
