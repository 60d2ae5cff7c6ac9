//! How a camera stands in the scene: from camera-space rays to render-space rays.

use super::{CameraRay, Clip};
use crate::math::motion::Motion;
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::transform::Transform;
use crate::math::{DMat4, DVec3, Rgb, Vec3};
use crate::optics::lanes::Lanes;
use crate::optics::real::{Index, Number};
use crate::optics::trace::LensRay;
use glam::{DMat3, DVec4};
use std::borrow::Cow;

/// Takes rays from camera space to render space. Everything is f64 until the finished ray.
#[derive(Clone, Debug)]
pub(super) struct CameraTransform {
    /// Where it stands if it does not move.
    still: Placement,
    /// Of a camera that moves.
    motion: Option<Box<Motion>>,
    is_affine: bool,
}

/// A ray of camera space. The direction need not have unit length.
#[derive(Clone, Copy, Debug)]
pub(super) struct CameraSpaceRay {
    /// Origin.
    pub o: DVec3,
    /// Direction.
    pub d: DVec3,
}

impl CameraTransform {
    /// A camera placed by `render_from_camera`.
    pub(super) fn new(render_from_camera: &Transform, clip: Clip) -> CameraTransform {
        CameraTransform {
            is_affine: render_from_camera.m.row(3).to_array() == [0.0, 0.0, 0.0, 1.0],
            still: Placement::new(render_from_camera.m, render_from_camera.inverse, clip),
            motion: None,
        }
    }

    /// Lets the camera move: `motion` places it instead, depending on a ray's time.
    pub(super) fn set_motion(&mut self, motion: Motion) {
        self.motion = Some(Box::new(motion));
    }

    /// Returns `true` if it depends on time.
    pub(super) fn moves(&self) -> bool {
        self.motion.is_some()
    }

    fn render_from_camera(&self, time: f32) -> DMat4 {
        match &self.motion {
            None => self.still.render_from_camera,
            Some(motion) => DMat4::from(motion.at(f64::from(time))),
        }
    }

    /// Returns `true` if camera space is placed without a projection, under which étendue has no simple law.
    pub(super) fn is_affine(&self) -> bool {
        self.is_affine
    }

    /// Where the camera stands at `time`; of one that [`CameraTransform::is_affine`].
    pub(super) fn placement(&self, time: f32) -> Cow<'_, Placement> {
        match &self.motion {
            None => Cow::Borrowed(&self.still),
            Some(motion) => {
                let m = motion.at(f64::from(time));
                let (from_camera, from_render) = (DMat4::from(m), DMat4::from(m.inverse()));
                Cow::Owned(Placement::new(from_camera, from_render, self.still.clip))
            }
        }
    }

    /// What takes a render-space point (x, y, z, 1) to its camera-space z at `time`.
    pub(super) fn z(&self, time: f32) -> DVec4 {
        match &self.motion {
            None => self.still.camera_from_render.row(2),
            Some(motion) => DMat4::from(motion.at(f64::from(time)).inverse()).row(2),
        }
    }

    /// How far it is from the camera's origin.
    pub(super) fn distance(&self, p: Vec3, time: f32) -> f64 {
        let origin = self.render_from_camera(time).transform_point3(DVec3::ZERO);
        (p.as_dvec3() - origin).length()
    }

    /// The render-space ray at `time`, cut to what lies between the clip planes.
    pub(super) fn ray(&self, ray: &CameraSpaceRay, time: f32) -> Ray {
        let (start, end) = self.still.clip.interval(ray.o.z, ray.d.z);
        let render_from_camera = self.render_from_camera(time);
        let d = render_from_camera.transform_vector3(ray.d);
        let length = d.length();
        let o = render_from_camera.project_point3(ray.o + ray.d * start);
        Ray {
            o: o.as_vec3(),
            d: (d / length).as_vec3(),
            t_max: ((end - start) * length) as f32,
            time,
        }
    }

    /// Where all rays of a pinhole at the origin start, and what takes camera-space directions to render space; `None` if the camera moves
    /// or clips.
    pub(super) fn of_still_pinhole(&self) -> Option<(Vec3, [DVec3; 3])> {
        let is_still = self.motion.is_none() && self.still.clip == Clip::NONE;
        let m = &self.still.render_from_camera;
        let axes = [m.x_axis, m.y_axis, m.z_axis].map(DVec4::truncate);
        is_still.then(|| (m.project_point3(DVec3::ZERO).as_vec3(), axes))
    }

    /// The rays of the neighboring pixels at `time`, each through its own origin in camera space.
    pub(super) fn differentials(
        &self,
        x: &CameraSpaceRay,
        y: &CameraSpaceRay,
        time: f32,
    ) -> RayDifferentials {
        let render_from_camera = self.render_from_camera(time);
        let place = |r: &CameraSpaceRay| -> (Vec3, Vec3) {
            let d = render_from_camera.transform_vector3(r.d).normalize();
            (
                render_from_camera.project_point3(r.o).as_vec3(),
                d.as_vec3(),
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

    /// The camera's `ray` at `time` with a weight of 1, and those of the neighboring pixels in x and y where they are given.
    pub(super) fn unweighted(
        &self,
        ray: &CameraSpaceRay,
        neighbors: Option<[CameraSpaceRay; 2]>,
        time: f32,
    ) -> CameraRay {
        CameraRay {
            ray: self.ray(ray, time),
            weight: 1.0,
            tint: Rgb::ONE,
            differentials: neighbors.map(|[x, y]| self.differentials(&x, &y, time)),
        }
    }
}

/// Where a camera stands at one time, for what goes from the scene to the camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    render_from_camera: DMat4,
    /// For connections only: no ray of the camera needs it.
    camera_from_render: DMat4,
    /// Of `camera_from_render`.
    determinant: f64,
    clip: Clip,
}

impl Placement {
    fn new(render_from_camera: DMat4, camera_from_render: DMat4, clip: Clip) -> Placement {
        Placement {
            determinant: camera_from_render.determinant(),
            render_from_camera,
            camera_from_render,
            clip,
        }
    }

    /// The camera-space point at `p`.
    pub(super) fn point(&self, p: Vec3) -> DVec3 {
        self.camera_from_render.transform_point3(p.as_dvec3())
    }

    /// The render-space point at the camera-space point `p`.
    pub(super) fn placed(&self, p: DVec3) -> DVec3 {
        self.render_from_camera.transform_point3(p)
    }

    /// The render-space unit normal of a surface with the normal `n` in camera space.
    pub(super) fn normal(&self, n: DVec3) -> DVec3 {
        let inverse = DMat3::from_mat4(self.camera_from_render);
        (inverse.transpose() * n).normalize_or_zero()
    }

    /// The part of a render-space ray between the clip planes; `None` where its end is hidden.
    pub(super) fn clipped(&self, ray: &Ray) -> Option<Ray> {
        let (start, end) = { self.clip }.interval(self.point(ray.o).z, self.direction(ray.d).z);
        let ends = ray.t_max.is_finite();
        let is_seen = f64::from(ray.t_max) > start && (!ends || f64::from(ray.t_max) < end);
        is_seen.then(|| Ray {
            o: ray.o + ray.d * start as f32,
            t_max: (f64::from(ray.t_max).min(end) - start) as f32,
            ..*ray
        })
    }

    /// The camera-space direction of `d`; it does not keep its length.
    pub(super) fn direction(&self, d: Vec3) -> DVec3 {
        self.camera_from_render.transform_vector3(d.as_dvec3())
    }

    /// Camera space's area perpendicular to a line over the same lines' perpendicular area in render space; the line runs
    /// along `d` of any length in camera space. A linear map multiplies volumes by its determinant and lengths along
    /// the line by some factor; areas across it by their quotient.
    pub(super) fn area_across(&self, d: DVec3) -> f64 {
        let along = self.render_from_camera.transform_vector3(d).length() / d.length();
        (self.determinant * along).abs()
    }

    /// The end in render space of what a shadow ray from the camera-space point `x` must find free for light to run to `y`,
    /// where the camera's ray to `x` starts; `None` where the clip planes hide `x`.
    pub(super) fn end(&self, x: DVec3, y: DVec3) -> Option<DVec3> {
        let d = x - y;
        let (start, end) = self.clip.interval(y.z, d.z);
        let seen = start < 1.0 && end > 1.0;
        seen.then(|| self.render_from_camera.transform_point3(y + d * start))
    }
}

/// A [`CameraTransform`] for bundles of rays of lens coordinates, in single precision: every matrix is multiplied out beforehand,
/// in double precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct BatchTransform {
    /// Rows that take a point of lens coordinates (mm) to render space.
    points: [[f32; 4]; 3],
    /// The same for directions; they do not keep their length.
    directions: [[f32; 3]; 3],
    /// Camera-space z of a point, from its z in lens coordinates: factor and offset.
    height: [f32; 2],
    /// Camera-space z of `hither` and `yon`, where anything is clipped.
    clip: Option<[f32; 2]>,
}

impl CameraTransform {
    /// For lens coordinates whose points `camera_from_lens` takes to camera space, and whose directions go to camera space by turning z
    /// round. `None` for a camera placed by a projection, which a bundle cannot follow.
    pub(super) fn placing(&self, camera_from_lens: &DMat4) -> Option<BatchTransform> {
        let m = self.still.render_from_camera;
        if m.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
            return None;
        }
        let whole = m * *camera_from_lens;
        let turned = m * DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
        let row = |m: &DMat4, i: usize| m.row(i).as_vec4().to_array();
        Some(BatchTransform {
            points: [0, 1, 2].map(|i| row(&whole, i)),
            directions: [0, 1, 2].map(|i| {
                let [x, y, z, _] = row(&turned, i);
                [x, y, z]
            }),
            height: [camera_from_lens.z_axis.z, camera_from_lens.w_axis.z].map(|x| x as f32),
            clip: (self.still.clip != Clip::NONE)
                .then_some([self.still.clip.hither as f32, self.still.clip.yon as f32]),
        })
    }
}

/// Origin and unit direction of a bundle of rays.
pub(super) type Lines<const N: usize> = [[Lanes<N>; 3]; 2];

impl BatchTransform {
    /// Origin, unit direction and t_max in render space, as [`CameraTransform::ray`].
    #[inline(always)]
    pub(super) fn ray<const N: usize>(
        &self,
        ray: &LensRay<Lanes<N>>,
    ) -> ([Lanes<N>; 3], [Lanes<N>; 3], Lanes<N>) {
        let (mut o, d, length) = self.line(ray);
        let mut t_max = Lanes::splat(f32::INFINITY);
        if let Some([hither, yon]) = self.clip {
            let z = ray.o[2].times(self.height[0]).plus(self.height[1]);
            let dz = -ray.d[2];
            // Parameters of the planes; what does not run forward is not clipped.
            let forward = dz.greater(0.0);
            let zero = Lanes::splat(0.0);
            let start = (Lanes::splat(hither) - z) / dz;
            let start = Lanes::select(start.greater(0.0) & forward, start, zero);
            let end = (Lanes::splat(yon) - z) / dz;
            for (o, d) in o.iter_mut().zip(&d) {
                *o = *o + *d * (start * length);
            }
            t_max = Lanes::select(forward, (end - start) * length, t_max);
        }
        (o, d, t_max)
    }

    /// Origin and unit direction in render space, whatever the clip planes.
    #[inline(always)]
    pub(super) fn unclipped<const N: usize>(&self, ray: &LensRay<Lanes<N>>) -> Lines<N> {
        let (o, d, _) = self.line(ray);
        [o, d]
    }

    /// Origin, unit direction, and the length that the direction had.
    #[inline(always)]
    fn line<const N: usize>(
        &self,
        ray: &LensRay<Lanes<N>>,
    ) -> ([Lanes<N>; 3], [Lanes<N>; 3], Lanes<N>) {
        let product =
            |v: &[Lanes<N>; 3], [a, b, c]: [f32; 3]| v[0].times(a) + v[1].times(b) + v[2].times(c);
        let o = self
            .points
            .map(|[a, b, c, shift]| product(&ray.o, [a, b, c]).plus(shift));
        let d = self.directions.map(|row| product(&ray.d, row));
        let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
        (o, d.map(|x| x / length), length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_have_unit_length_and_clip_distances_are_in_render_units() {
        // Camera units are millimeters, render units meters.
        let clip = Clip {
            hither: 10.0,
            yon: 2000.0,
        };
        let transform = CameraTransform::new(&Transform::scale(DVec3::splat(1e-3)), clip);
        let ray = transform.ray(
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

    #[test]
    fn a_moving_camera_is_where_it_is_at_the_rays_time() {
        let end = Transform::translate(DVec3::X) * Transform::rotate(90.0, DVec3::Y);
        let mut transform = CameraTransform::new(&Transform::IDENTITY, Clip::NONE);
        let motion = Motion::new(&Transform::IDENTITY, &end, [2.0, 4.0]);
        transform.set_motion(motion.expect("both can be inverted"));
        let ahead = CameraSpaceRay {
            o: DVec3::ZERO,
            d: DVec3::Z,
        };
        for (time, o, angle) in [(0.0, 0.0, 0.0), (3.0, 0.5, 45.0f32), (9.0, 1.0, 90.0)] {
            let ray = transform.ray(&ahead, time);
            let (sin, cos) = angle.to_radians().sin_cos();
            assert!((ray.o - Vec3::X * o).length() < 1e-6);
            assert!((ray.d - Vec3::new(sin, 0.0, cos)).length() < 1e-6);
            let neighbors = transform.differentials(&ahead, &ahead, time);
            assert_eq!((neighbors.rx_o, neighbors.ry_d), (ray.o, ray.d));
        }
    }
}
