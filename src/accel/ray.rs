//! A ray prepared for box and triangle tests.

use super::node::FAR_MARGIN;
use crate::math::Vec3;

/// Directions with components below this are treated as if the component were 0: over distances
/// of 1e10 the ray drifts by less than any single-precision coordinate can show.
const SMALLEST_COMPONENT: f32 = 1e-30;

/// Stands for 1/0: large enough that the nudge of the origin below times this exceeds any
/// distance, small enough that a product with it is infinite at worst, never NaN.
const LARGEST_INVERSE: f32 = 1e38;

/// What all tests of one ray share.
pub(super) struct TraversalRay {
    /// Origin.
    pub o: Vec3,
    /// Unit direction.
    pub d: Vec3,
    /// Origin for the entering planes, one axis after the other.
    pub near_origin: [f32; 3],
    /// Origin for the leaving planes.
    pub far_origin: [f32; 3],
    /// 1/direction, for the entering planes.
    pub inverse: [f32; 3],
    /// The same with [`FAR_MARGIN`], for the leaving planes.
    pub far_inverse: [f32; 3],
    /// 0 where a box is entered through its lower plane, 1 for the upper.
    pub near_side: [usize; 3],
    /// The axes x, y, z of the sheared space of the triangle test; z is the direction's largest.
    pub axes: [usize; 3],
    /// Origin in these axes.
    pub sheared_o: [f32; 3],
    /// Shear in x and in y, scale in z: they take the direction to (0, 0, 1).
    pub shear: [f32; 3],
}

impl TraversalRay {
    pub fn new(o: Vec3, d: Vec3) -> TraversalRay {
        let mut ray = TraversalRay {
            o,
            d,
            near_origin: o.to_array(),
            far_origin: o.to_array(),
            inverse: [0.0; 3],
            far_inverse: [0.0; 3],
            near_side: [0; 3],
            axes: [0; 3],
            sheared_o: [0.0; 3],
            shear: [0.0; 3],
        };
        for axis in 0..3 {
            ray.near_side[axis] = usize::from(d[axis].is_sign_negative());
            if d[axis].abs() >= SMALLEST_COMPONENT {
                ray.inverse[axis] = 1.0 / d[axis];
                ray.far_inverse[axis] = 1.0 / d[axis] * FAR_MARGIN;
                continue;
            }
            // Parallel to the planes. A slab must hold the ray for ever if the origin is inside or
            // on one of its planes, which 0 × ∞ would not tell: move the origin a little inward
            // for either plane.
            let nudge = (o[axis].abs() * (2.0 * f32::EPSILON)).max(1e-20);
            ray.near_side[axis] = 0;
            ray.near_origin[axis] = o[axis] + nudge;
            ray.far_origin[axis] = o[axis] - nudge;
            ray.inverse[axis] = LARGEST_INVERSE;
            ray.far_inverse[axis] = LARGEST_INVERSE;
        }
        // Woop, Benthin and Wald 2013, §3.1: permute so that the direction is largest in z. (The
        // handedness does not matter: the test accepts both turning senses.)
        let a = d.abs();
        let z = if a.x > a.y && a.x > a.z {
            0
        } else if a.y > a.z {
            1
        } else {
            2
        };
        ray.axes = [(z + 1) % 3, (z + 2) % 3, z];
        let [x, y, z] = ray.axes;
        ray.sheared_o = [o[x], o[y], o[z]];
        ray.shear = [-d[x] / d[z], -d[y] / d[z], 1.0 / d[z]];
        ray
    }
}
