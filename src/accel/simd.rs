use super::node::{Node, FAR_MARGIN};
use super::ray::TraversalRay;
use std::arch::x86_64::*;
pub(super) trait Simd: Copy { fn boxes(self, node: &Node, ray: &TraversalRay, t_max: f32) -> (u32, [f32; 8]); }
#[derive(Clone, Copy)] pub(super) struct Baseline;
impl Simd for Baseline {
    #[inline(always)] fn boxes(self, node: &Node, ray: &TraversalRay, t_max: f32) -> (u32, [f32; 8]) { node.test(ray, t_max) }
}
#[derive(Clone, Copy)] pub(super) struct Avx2;
impl Simd for Avx2 {
    #[inline(always)] fn boxes(self, node: &Node, ray: &TraversalRay, t_max: f32) -> (u32, [f32; 8]) { unsafe { boxes_avx2(node, ray, t_max) } }
}
#[target_feature(enable = "avx2")]
#[inline]
fn boxes_avx2(node: &Node, ray: &TraversalRay, t_max: f32) -> (u32, [f32; 8]) {
    let load = |a: &[f32; 8]| unsafe { _mm256_load_ps(a.as_ptr()) };
    let w = |a: &wide::f32x8| -> __m256 { unsafe { std::mem::transmute(*a) } };
    let plane = |axis: usize, side: usize, o: __m256| _mm256_mul_ps(_mm256_sub_ps(load(&node.bounds[axis][side]), o), w(&ray.inverse[axis]));
    let e = |axis: usize| plane(axis, ray.near_side[axis], w(&ray.near_origin[axis]));
    let l = |axis: usize| plane(axis, 1 - ray.near_side[axis], w(&ray.far_origin[axis]));
    let near = _mm256_max_ps(_mm256_max_ps(e(0), e(1)), _mm256_max_ps(e(2), _mm256_setzero_ps()));
    let far = _mm256_mul_ps(_mm256_min_ps(_mm256_min_ps(l(0), l(1)), l(2)), _mm256_set1_ps(FAR_MARGIN));
    let hit = _mm256_cmp_ps::<_CMP_LE_OQ>(near, _mm256_min_ps(far, _mm256_set1_ps(t_max)));
    (_mm256_movemask_ps(hit) as u32, unsafe { std::mem::transmute(near) })
}
#[target_feature(enable = "avx2")]
pub(super) fn go_avx2<const ORDERED: bool>(tree: &super::tree::Tree, ray: &TraversalRay, v: &mut impl super::tree::Visitor) -> bool { tree.traverse_with::<ORDERED, _>(Avx2, ray, v) }
