//! Boxes that media fill: unit cubes in spaces of their own.

use crate::math::DVec3;
use crate::math::ray::Ray;
use crate::math::transform::Transform;
use glam::DAffine3;

/// From render space to the unit cube.
#[derive(Clone, Debug)]
pub(super) struct BoxSpace(pub(super) DAffine3);

/// The segment of a ray inside a box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chord {
    /// The ray's origin in the unit cube's space.
    pub o: DVec3,
    /// Its direction there.
    pub d: DVec3,
    /// Distances at which the ray enters and leaves.
    pub start: f64,
    /// See `start`.
    pub end: f64,
}

impl BoxSpace {
    /// Of a box that `render_from_box` places.
    pub(super) fn new(render_from_box: &Transform) -> BoxSpace {
        BoxSpace(DAffine3::from_mat4(render_from_box.inverse))
    }

    /// The segment of the ray inside the box, before `t_max`.
    pub(super) fn chord(&self, ray: &Ray, t_max: f64) -> Option<Chord> {
        let o = self.0.transform_point3(ray.o.as_dvec3());
        let d = self.0.transform_vector3(ray.d.as_dvec3());
        let (mut start, mut end) = (0.0f64, t_max);
        for axis in 0..3 {
            if d[axis] == 0.0 {
                if !(0.0..=1.0).contains(&o[axis]) {
                    return None;
                }
                continue;
            }
            let (a, b) = (-o[axis] / d[axis], (1.0 - o[axis]) / d[axis]);
            start = start.max(a.min(b));
            end = end.min(a.max(b));
        }
        (start < end).then_some(Chord { o, d, start, end })
    }
}
