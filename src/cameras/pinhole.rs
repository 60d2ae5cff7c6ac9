//! Rays of a pinhole that stands still, side by side: most scenes have such a camera, whose rays are all from one point, so that
//! a ray is no more than a direction.

use super::camera_transform::CameraTransform;
use super::{BUNDLE, CameraRay, CameraSample, Shutter};
use crate::math::instruction_set::{Instructions, Kernel, WIDEST, vectorize};
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::{DVec2, DVec3, Rgb, Vec3};

/// A perspective camera without lens, motion and clip planes.
pub(super) struct Pinhole<'a> {
    /// Where its rays start, in render space.
    o: Vec3,
    /// What takes camera-space directions to render space: their x, y and z.
    axes: [DVec3; 3],
    /// Direction through raster point (0, 0), and its change per pixel, where z is 1.
    corner: DVec2,
    per_pixel: DVec2,
    shutter: &'a Shutter,
}

impl<'a> Pinhole<'a> {
    /// At the origin of camera space, placed by `transform`; `None` if that moves or clips.
    pub(super) fn new(
        transform: &CameraTransform,
        (corner, per_pixel): (DVec2, DVec2),
        shutter: &'a Shutter,
    ) -> Option<Pinhole<'a>> {
        let (o, axes) = transform.of_still_pinhole()?;
        Some(Pinhole {
            o,
            axes,
            corner,
            per_pixel,
            shutter,
        })
    }

    /// Writes the rays of at most [`BUNDLE`] samples to the front of `rays`: to the last bit those of
    /// [`Projective::ray`](super::Projective::ray).
    pub(super) fn rays(
        &self,
        samples: &[CameraSample],
        want_differentials: bool,
        rays: &mut [Option<CameraRay>],
    ) {
        vectorize::<WIDEST, _>(Rays {
            pinhole: self,
            samples,
            want_differentials,
            rays,
        });
    }

    /// Render-space directions through raster points, and their lengths before they are divided by them.
    #[inline(always)]
    fn directions(&self, raster: [&Row<f64>; 2]) -> (Directions, Row<f64>) {
        let (mut d, mut lengths) = ([[0.0; BUNDLE]; 3], [0.0; BUNDLE]);
        let [x_axis, y_axis, z_axis] = self.axes;
        for lane in 0..BUNDLE {
            let raster = DVec2::new(raster[0][lane], raster[1][lane]);
            let shown = self.corner + self.per_pixel * raster;
            // Where the numbers end, straight ahead.
            let is_finite = shown.x.abs() < f64::INFINITY && shown.y.abs() < f64::INFINITY;
            let x = if is_finite { shown.x } else { 0.0 };
            let y = if is_finite { shown.y } else { 0.0 };
            let v = z_axis + (y_axis * y + x_axis * x);
            (d[0][lane], d[1][lane], d[2][lane]) = (v.x, v.y, v.z);
            lengths[lane] = v.length();
        }
        (d, lengths)
    }
}

/// A number for each ray.
type Row<T> = [T; BUNDLE];
type Directions = [Row<f64>; 3];

/// Rays to be made.
struct Rays<'a> {
    pinhole: &'a Pinhole<'a>,
    samples: &'a [CameraSample],
    want_differentials: bool,
    rays: &'a mut [Option<CameraRay>],
}

impl Kernel for Rays<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self, _: impl Instructions) {
        let pinhole = self.pinhole;
        let mut raster = [[0.0; BUNDLE]; 2];
        for (lane, sample) in self.samples.iter().take(BUNDLE).enumerate() {
            raster[0][lane] = f64::from(sample.raster.x);
            raster[1][lane] = f64::from(sample.raster.y);
        }
        let [x, y] = raster;
        let (d, lengths) = pinhole.directions([&x, &y]);
        let mut unit = [[0.0f32; BUNDLE]; 3];
        for lane in 0..BUNDLE {
            for axis in 0..3 {
                unit[axis][lane] = (d[axis][lane] / lengths[lane]) as f32;
            }
        }
        let at = |d: &[Row<f32>; 3], lane: usize| Vec3::new(d[0][lane], d[1][lane], d[2][lane]);
        let out = self.rays.iter_mut().zip(self.samples).take(BUNDLE);
        if !self.want_differentials {
            for (lane, (ray, sample)) in out.enumerate() {
                *ray = Some(pinhole.ray(sample, at(&unit, lane), None));
            }
            return;
        }
        let shifted = [[&x.map(|x| x + 1.0), &y], [&x, &y.map(|y| y + 1.0)]];
        let neighbors = shifted.map(|raster| {
            let (d, lengths) = pinhole.directions(raster);
            let mut unit = [[0.0f32; BUNDLE]; 3];
            for lane in 0..BUNDLE {
                let scale = 1.0 / lengths[lane];
                for axis in 0..3 {
                    unit[axis][lane] = (d[axis][lane] * scale) as f32;
                }
            }
            unit
        });
        for (lane, (ray, sample)) in out.enumerate() {
            let differentials = RayDifferentials {
                rx_o: pinhole.o,
                rx_d: at(&neighbors[0], lane),
                ry_o: pinhole.o,
                ry_d: at(&neighbors[1], lane),
            };
            *ray = Some(pinhole.ray(sample, at(&unit, lane), Some(differentials)));
        }
    }
}

impl Pinhole<'_> {
    #[inline(always)]
    fn ray(
        &self,
        sample: &CameraSample,
        d: Vec3,
        differentials: Option<RayDifferentials>,
    ) -> CameraRay {
        CameraRay {
            ray: Ray {
                o: self.o,
                d,
                t_max: f32::INFINITY,
                time: self.shutter.time(sample.time),
            },
            weight: 1.0,
            tint: Rgb::ONE,
            differentials,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Clip, FilmGeometry, Projective, ProjectiveSpec, ThinLens};
    use super::*;
    use crate::math::motion::Motion;
    use crate::math::transform::Transform;
    use crate::math::{UVec2, Vec2};
    use proptest::prelude::*;

    const FILM: FilmGeometry = FilmGeometry {
        resolution: UVec2::new(640, 400),
        diagonal_mm: 35.0,
    };

    fn perspective(fov: f64) -> ProjectiveSpec {
        ProjectiveSpec {
            fov: Some(fov),
            ..ProjectiveSpec::default()
        }
    }

    /// Somewhere, turned, and of another scale.
    fn place(angle: f64) -> Transform {
        Transform::translate(DVec3::new(3.0, -4.0, 0.5))
            * Transform::rotate(angle, DVec3::new(1.0, 2.0, 3.0))
            * Transform::scale(DVec3::new(2.0, 0.1, -3.0))
    }

    /// Everything of it.
    fn bits(ray: &CameraRay) -> String {
        let CameraRay { weight, tint, .. } = ray;
        let all = [ray.ray.o, ray.ray.d, *tint].map(|v| v.to_array().map(f32::to_bits));
        let rest = [ray.ray.t_max, ray.ray.time, *weight].map(f32::to_bits);
        let differentials = ray
            .differentials
            .map(|d| [d.rx_o, d.rx_d, d.ry_o, d.ry_d].map(|v| v.to_array().map(f32::to_bits)));
        format!("{all:?} {rest:?} {differentials:?}")
    }

    proptest! {
        #[test]
        fn rays_side_by_side_are_those_of_one_sample_each(
            fov in 1e-3f64..179.999,
            angle in 0f64..360.0,
            (x, y) in (-1e4f32..1e4, -1e4f32..1e4),
            count in 1usize..=BUNDLE,
            want_differentials: bool,
        ) {
            let camera = Projective::new(&perspective(fov), &FILM, &place(angle));
            prop_assert!(camera.pinhole().is_some());
            let samples: Vec<CameraSample> = (0..count)
                .map(|i| CameraSample {
                    raster: Vec2::new(x + 0.37 * i as f32, y - 1.73 * i as f32),
                    time: i as f32 / count as f32,
                    lens: Vec2::splat(0.3),
                    wavelength: 0.5,
                })
                .collect();
            let mut rays = [None; BUNDLE];
            camera.rays(&samples, want_differentials, &mut rays);
            for (sample, ray) in samples.iter().zip(&rays) {
                let alone = camera.ray(sample, want_differentials);
                prop_assert_eq!(bits(&ray.unwrap()), bits(&alone));
            }
            prop_assert!(rays[count..].iter().all(Option::is_none));
        }
    }

    #[test]
    fn where_the_numbers_end_rays_run_ahead_as_one_by_one() {
        for distance in [0.0, -3.0, 7.0] {
            let spec = ProjectiveSpec {
                lens: ThinLens {
                    radius: 0.0,
                    focal_distance: distance,
                },
                ..perspective(60.0)
            };
            let camera = Projective::new(&spec, &FILM, &place(70.0));
            let at = |x: f32, y: f32| CameraSample {
                raster: Vec2::new(x, y),
                time: 0.5,
                lens: Vec2::splat(0.5),
                wavelength: 0.5,
            };
            let samples = [at(f32::INFINITY, 3.0), at(4.0, f32::NAN), at(5.0, 6.0)];
            let mut rays = [None; 3];
            camera.rays(&samples, true, &mut rays);
            for (sample, ray) in samples.iter().zip(&rays) {
                assert_eq!(bits(&ray.unwrap()), bits(&camera.ray(sample, true)));
            }
            let [ahead, other] = [0, 2].map(|i| rays[i].unwrap().ray.d);
            assert!(ahead.is_finite() && ahead != other);
        }
    }

    #[test]
    fn lenses_planes_motion_and_parallel_rays_are_no_pinhole() {
        let lens = ThinLens {
            radius: 0.1,
            focal_distance: 3.0,
        };
        let clip = Clip {
            hither: 1.0,
            yon: 2.0,
        };
        let specs = [
            ProjectiveSpec {
                lens,
                ..perspective(50.0)
            },
            ProjectiveSpec {
                clip,
                ..perspective(50.0)
            },
            ProjectiveSpec::default(),
        ];
        for spec in specs {
            let camera = Projective::new(&spec, &FILM, &place(20.0));
            assert!(camera.pinhole().is_none());
        }
        let mut moving = Projective::new(&perspective(50.0), &FILM, &place(20.0));
        let motion = Motion::new(&place(20.0), &place(30.0), [0.0, 1.0]);
        moving.set_motion(motion.expect("both can be inverted"));
        assert!(moving.pinhole().is_none());
    }
}
