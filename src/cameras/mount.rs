//! How a camera stands in the scene: from camera-space rays to render-space rays.

use super::Clip;
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::transform::Transform;
use crate::math::{DMat4, DVec3, Vec3};

/// Takes rays from camera space to render space. Everything is f64 until the finished ray.
#[derive(Clone, Copy, Debug)]
pub struct Mount {
    /// The matrix alone: the inverse is not needed here.
    render_from_camera: DMat4,
    clip: Clip,
}

/// A ray of camera space. The direction need not have unit length.
#[derive(Clone, Copy, Debug)]
pub struct CameraSpaceRay {
    /// Origin.
    pub o: DVec3,
    /// Direction.
    pub d: DVec3,
}

impl Mount {
    /// A camera placed by `render_from_camera`.
    pub fn new(render_from_camera: &Transform, clip: Clip) -> Mount {
        Mount {
            render_from_camera: render_from_camera.m,
            clip,
        }
    }

    /// The render-space ray at `time`, cut to what lies between the clip planes.
    pub fn ray(&self, ray: &CameraSpaceRay, time: f32) -> Ray {
        let (start, end) = self.clip.interval(ray.o.z, ray.d.z);
        let d = self.render_from_camera.transform_vector3(ray.d);
        let length = d.length();
        let o = self
            .render_from_camera
            .project_point3(ray.o + ray.d * start);
        Ray {
            o: o.as_vec3(),
            d: (d / length).as_vec3(),
            t_max: ((end - start) * length) as f32,
            time,
        }
    }

    /// The rays of the neighbouring pixels, each through its own origin in camera space.
    pub fn differentials(&self, x: &CameraSpaceRay, y: &CameraSpaceRay) -> RayDifferentials {
        let place = |r: &CameraSpaceRay| -> (Vec3, Vec3) {
            (
                self.render_from_camera.project_point3(r.o).as_vec3(),
                self.render_from_camera
                    .transform_vector3(r.d)
                    .normalize()
                    .as_vec3(),
            )
        };
        let ((rx_o, rx_d), (ry_o, ry_d)) = (place(x), place(y));
        RayDifferentials {
            rx_o,
            rx_d,
            ry_o,
            ry_d,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_have_unit_length_and_clip_distances_are_in_render_units() {
        // Camera units are millimetres, render units metres.
        let clip = Clip {
            hither: 10.0,
            yon: 2000.0,
        };
        let mount = Mount::new(&Transform::scale(DVec3::splat(1e-3)), clip);
        let ray = mount.ray(
            &CameraSpaceRay {
                o: DVec3::ZERO,
                d: DVec3::new(0.0, 0.6, 0.8),
            },
            0.0,
        );
        assert!((ray.d.length() - 1.0).abs() < 1e-7);
        // z = 10 mm is reached after 12.5 mm, z = 2000 mm after 2500 mm.
        assert!((ray.o - Vec3::new(0.0, 7.5e-3, 1e-2)).length() < 1e-9);
        assert!((ray.t_max - 2.4875).abs() < 1e-6);
    }
}
