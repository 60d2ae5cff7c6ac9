//! A ray set up for box and triangle tests.

use crate::math::Vec3;
use wide::f32x4;

/// Direction components below this are treated as 0: over distances of 1e10 the ray drifts by less than any
/// single-precision coordinate can show.
const SMALLEST_COMPONENT: f32 = 1e-30;

/// Used for 1/0: large enough that the nudge of the origin below times this exceeds any distance, small enough that a
/// product with it is infinite at worst, never NaN.
const LARGEST_INVERSE: f32 = 1e38;

/// The far planes of boxes are moved out by this factor. Entry and exit distances carry three roundings each; the
/// triangle test's sheared coordinates about five, relative to the same differences. Eight units of roundoff, and as
/// many again for the other side, keep every ray that the triangle test would accept (compare Ize, "Robust BVH Ray
/// Traversal", JCGT 2(2), 2013).
const FAR_MARGIN: f32 = 1.0 + 8.0 * f32::EPSILON;

/// The origin is nudged by no less, at 0.
const SMALLEST_NUDGE: f32 = 1e-20;

/// Precomputed values shared by all tests of one ray.
pub(super) struct TraversalRay {
    /// Origin.
    pub o: Vec3,
    /// Unit direction.
    pub d: Vec3,
    /// Origin for the entry planes, by axis; the fourth is not an axis.
    pub near_origin: [f32; 4],
    /// Origin for the exit planes.
    pub far_origin: [f32; 4],
    /// 1/direction, for the entry planes.
    pub inverse: [f32; 4],
    /// 1/direction times [`FAR_MARGIN`], for the exit planes.
    pub far_inverse: [f32; 4],
    /// 0 where a box is entered through its lower plane, 1 for the upper.
    pub near_side: [usize; 3],
    /// The axes x, y, z of the sheared space of the triangle test; z is the direction's largest.
    pub axes: [usize; 3],
    /// Origin in these axes.
    pub sheared_o: [f32; 3],
    /// Shear in x and y, scale in z: they map the direction to (0, 0, 1).
    pub shear: [f32; 3],
}

impl TraversalRay {
    /// Inlined into the traversal, so that the values stay in registers.
    #[inline(always)]
    pub(super) fn new(o: Vec3, d: Vec3) -> TraversalRay {
        let origin = f32x4::new([o.x, o.y, o.z, 0.0]);
        let direction = f32x4::new([d.x, d.y, d.z, 1.0]);
        // Where the ray is parallel to an axis's planes, it must always be within their slab if the origin is inside or
        // on one of the planes, which 0 × ∞ would not tell. So the origin moves a little inward for either plane. (All
        // of this by selection: spilled to memory for the sake of a branch, the ray takes a tenth of a short search.)
        let is_parallel = direction.abs().simd_lt(f32x4::splat(SMALLEST_COMPONENT));
        let nudge = origin.abs() * f32x4::splat(2.0 * f32::EPSILON);
        let nudge = nudge.fast_max(f32x4::splat(SMALLEST_NUDGE)) & is_parallel;
        let large = f32x4::splat(LARGEST_INVERSE);
        let inverse = f32x4::ONE / direction;
        let far_inverse = inverse * f32x4::splat(FAR_MARGIN);
        // The signs of negative directions.
        let upper_first = (direction & !is_parallel).to_bitmask() as usize;
        let a = d.abs();
        // Woop, Benthin and Wald 2013, §3.1: permute so that the direction is largest in z. (The handedness does not
        // matter: the test accepts both windings.) Without branches, which would be mispredicted.
        let x_largest = (a.x > a.y) & (a.x > a.z);
        let not_x = 2 - usize::from(a.y > a.z);
        let z = if x_largest { 0 } else { not_x };
        let [x, y] = AXES_AFTER[z];
        let at = |v: Vec3, axis: usize| [v.x, v.y, v.z, 0.0][axis & 3];
        let shear = f32x4::new([-at(d, x), -at(d, y), 1.0, 1.0]) / f32x4::splat(at(d, z));
        let [shear_x, shear_y, scale, _] = shear.to_array();
        TraversalRay {
            o,
            d,
            near_origin: (origin + nudge).to_array(),
            far_origin: (origin - nudge).to_array(),
            inverse: is_parallel.select(large, inverse).to_array(),
            far_inverse: is_parallel.select(large, far_inverse).to_array(),
            near_side: [upper_first & 1, upper_first >> 1 & 1, upper_first >> 2 & 1],
            axes: [x, y, z],
            sheared_o: [at(o, x), at(o, y), at(o, z)],
            shear: [shear_x, shear_y, scale],
        }
    }
}

/// The two axes that follow each.
const AXES_AFTER: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];
