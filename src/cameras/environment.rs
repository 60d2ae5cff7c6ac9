//! `Camera "environment"`: the whole sphere of directions as a latitude-longitude image.
//!
//! Parameters (docs/scene-language.md §3.1): `shutteropen` 0, `shutterclose` 1; `lensradius`,
//! `focaldistance`, `frameaspectratio` and `screenwindow` are read by pbrt and change nothing, as
//! do `hither` and `yon` in pbrt-v2 files.
//! Source: Pharr, Jakob and Humphreys 2016, §6.3.
//!
//! Rows run from the camera's +y (up) to −y, columns from +x over +z (ahead) to −x and −z.

use super::camera_transform::{CameraSpaceRay, CameraTransform, Placement};
use super::connection::Hit;
use super::{CameraRay, CameraSample, Clip, FilmGeometry, Shutter};
use crate::math::motion::Motion;
use crate::math::transform::Transform;
use crate::math::{DVec2, DVec3, Vec2};
use crate::params::ParamReader;
use arrayvec::ArrayVec;
use std::borrow::Cow;
use std::f64::consts::{PI, TAU};

/// An environment camera as the scene file describes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnvironmentSpec {
    /// When light is let in.
    pub shutter: Shutter,
}

impl EnvironmentSpec {
    /// Reads the parameters.
    pub fn from_params(params: &ParamReader) -> EnvironmentSpec {
        for name in [
            "lensradius",
            "focaldistance",
            "frameaspectratio",
            "screenwindow",
            "hither",
            "yon",
        ] {
            params.accept(name);
        }
        EnvironmentSpec {
            shutter: Shutter::from_params(params),
        }
    }
}

/// An environment camera ready to make rays.
#[derive(Clone, Debug)]
pub struct Environment {
    spec: EnvironmentSpec,
    transform: CameraTransform,
    /// Azimuth and polar angle that a pixel spans, in radians.
    per_pixel: DVec2,
}

impl Environment {
    /// The same way around the sphere as `shift` in pixels, by less than half of it.
    pub(super) fn shorter_way(&self, shift: Vec2) -> Vec2 {
        let around = (TAU / self.per_pixel.x) as f32;
        Vec2::new(shift.x - around * (shift.x / around).round(), shift.y)
    }

    /// How it stands in the scene.
    pub(super) fn transform(&self) -> &CameraTransform {
        &self.transform
    }

    /// When it lets light in.
    pub(super) fn shutter(&self) -> &Shutter {
        &self.spec.shutter
    }

    /// Puts `spec` behind `film`. Both resolutions are positive.
    pub fn new(
        spec: &EnvironmentSpec,
        film: &FilmGeometry,
        render_from_camera: &Transform,
    ) -> Environment {
        Environment {
            spec: spec.clone(),
            transform: CameraTransform::new(render_from_camera, Clip::NONE),
            per_pixel: DVec2::new(TAU, PI) / film.resolution.as_dvec2(),
        }
    }

    /// The ray for `sample`; its weight is 1. The differentials' directions are the derivatives by
    /// the film position, not the neighboring pixels' own: these may lie a quarter turn away.
    pub fn ray(&self, sample: &CameraSample, want_differentials: bool) -> CameraRay {
        let angles = self.per_pixel * sample.raster.as_dvec2();
        let ((sin_phi, cos_phi), (sin_theta, cos_theta)) = (angles.x.sin_cos(), angles.y.sin_cos());
        let d = DVec3::new(sin_theta * cos_phi, cos_theta, sin_theta * sin_phi);
        let through = |d: DVec3| CameraSpaceRay { o: DVec3::ZERO, d };
        let time = self.spec.shutter.time(sample.time);
        let neighbors = want_differentials.then(|| {
            let across = DVec3::new(-sin_theta * sin_phi, 0.0, sin_theta * cos_phi);
            let down = DVec3::new(cos_theta * cos_phi, -sin_theta, cos_theta * sin_phi);
            [self.per_pixel.x * across, self.per_pixel.y * down].map(|step| through(d + step))
        });
        self.transform.unweighted(&through(d), neighbors, time)
    }

    /// Where the camera stands at `time`; `None` if no connection can be made.
    pub(super) fn placement(&self, time: f32) -> Option<Cow<'_, Placement>> {
        self.transform
            .is_affine()
            .then(|| self.transform.placement(time))
    }

    /// How the camera-space point `x` is seen. A pixel is as wide in angle everywhere, and so the smaller the nearer to
    /// a pole.
    pub(super) fn hit(&self, x: DVec3) -> Hit {
        let from_axis = x.x.hypot(x.z);
        let angles = DVec2::new(x.z.atan2(x.x).rem_euclid(TAU), from_axis.atan2(x.y));
        // Solid angle sinθ dφ dθ, with sinθ = from_axis/|x|, on a sphere of radius |x|.
        let per_pixel = from_axis * x.length() * self.per_pixel.x * self.per_pixel.y;
        Hit {
            origin: DVec3::ZERO,
            raster: angles / self.per_pixel,
            density: 1.0 / per_pixel,
        }
    }

    /// See [`super::Camera::raster_copies`].
    pub(super) fn raster_copies(&self, raster: Vec2, reach: f32) -> ArrayVec<Vec2, 8> {
        let size = (DVec2::new(TAU, PI) / self.per_pixel).round().as_vec2();
        // Once around; and over a pole, half a turn on.
        let over = |y: f32| Vec2::new(raster.x + 0.5 * size.x, y);
        let mut copies = ArrayVec::new();
        for first in [raster, over(-raster.y), over(2.0 * size.y - raster.y)] {
            for turns in [-1.0, 0.0, 1.0] {
                let p = first + Vec2::new(turns * size.x, 0.0);
                let near = p.cmpge(Vec2::splat(-reach)) & p.cmple(size + reach);
                if near.all() && p != raster && !copies.is_full() {
                    copies.push(p);
                }
            }
        }
        copies
    }

    pub(super) fn set_motion(&mut self, motion: Motion) {
        self.transform.set_motion(motion);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{UVec2, Vec3};
    use crate::params::testing::read;

    const FILM: FilmGeometry = FilmGeometry {
        resolution: UVec2::new(800, 400),
        diagonal_mm: 35.0,
    };

    fn camera() -> Environment {
        Environment::new(&EnvironmentSpec::default(), &FILM, &Transform::IDENTITY)
    }

    fn ray(x: f32, y: f32) -> CameraRay {
        let sample = CameraSample {
            raster: Vec2::new(x, y),
            time: 0.5,
            lens: Vec2::ZERO,
            wavelength: 0.5,
        };
        camera().ray(&sample, true)
    }

    #[test]
    fn up_is_the_top_row_and_ahead_a_quarter_across() {
        for ((x, y), d) in [
            ((0.0, 0.0), Vec3::Y),
            ((123.0, 400.0), Vec3::NEG_Y),
            ((0.0, 200.0), Vec3::X),
            ((200.0, 200.0), Vec3::Z),
            ((400.0, 200.0), Vec3::NEG_X),
            ((600.0, 200.0), Vec3::NEG_Z),
            ((200.0, 100.0), Vec3::new(0.0, 0.5f32.sqrt(), 0.5f32.sqrt())),
        ] {
            // Sines of multiples of π in double precision.
            assert!((ray(x, y).ray.d - d).length() < 1e-7, "{x} {y}");
        }
    }

    #[test]
    fn differentials_are_derivatives() {
        for (x, y) in [(30.0, 100.0), (500.0, 399.0), (799.0, 0.5)] {
            let r = ray(x, y);
            let found = r.differentials.unwrap();
            let step = 1.0 / 16.0;
            for (direction, neighbor) in [
                (found.rx_d, ray(x + step, y).ray.d),
                (found.ry_d, ray(x, y + step).ray.d),
            ] {
                // Across the ray; along it only lengths would differ. The second derivative of a
                // direction is at most (2π/800)², single precision adds 16 · 1e-7.
                let across = |d: Vec3| d - r.ray.d * d.dot(r.ray.d);
                let expected = across(neighbor) / step;
                assert!((across(direction) - expected).length() < 1e-5);
            }
            assert_eq!((found.rx_o, found.ry_o), (Vec3::ZERO, Vec3::ZERO));
        }
    }

    #[test]
    fn copies_of_a_film_point_have_its_ray() {
        let copies = |x: f32, y: f32| camera().raster_copies(Vec2::new(x, y), 3.0);
        assert!(copies(300.0, 200.0).is_empty());
        assert_eq!(copies(1.0, 200.0).as_slice(), [Vec2::new(801.0, 200.0)]);
        assert_eq!(copies(799.0, 5.0).as_slice(), [Vec2::new(-1.0, 5.0)]);
        assert_eq!(copies(100.0, 398.0).as_slice(), [Vec2::new(500.0, 402.0)]);
        // Over the pole, where that point lies at the seam, and around.
        assert_eq!(copies(401.0, 2.0).len(), 2);
        for (x, y) in [(1.0, 2.0), (401.0, 2.0), (799.5, 399.0), (398.0, 1.0)] {
            for p in copies(x, y) {
                // Sines of angles of up to 2π.
                assert!(
                    (ray(p.x, p.y).ray.d - ray(x, y).ray.d).length() < 1e-6,
                    "{p}"
                );
            }
        }
    }

    #[test]
    fn what_pbrt_reads_in_vain_is_no_mistake() {
        let text = r#""float lensradius" 1 "float focaldistance" 2 "float screenwindow" [0 1 0 1]
            "float frameaspectratio" 2 "float shutterclose" 3"#;
        let outcome = read("environment", text, EnvironmentSpec::from_params);
        assert!(outcome.messages.is_empty(), "{:?}", outcome.messages);
        assert_eq!(outcome.value.shutter.close, 3.0);
    }
}
