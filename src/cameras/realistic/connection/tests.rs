//! Connections against rays of the same camera.

use super::*;
use crate::cameras::realistic::tests::{double_gauss, samples};
use crate::cameras::realistic::{Band, RealisticSpec, Weighting};
use crate::cameras::{Aim, Camera, CameraSpec, FilmGeometry};
use crate::math::transform::Transform;
use crate::math::{Rgb, UVec2};
use crate::optics::stop_shape::StopPolygon;
use crate::optics::{Lens, Prescription, StopShape};

const FILM: FilmGeometry = FilmGeometry {
    resolution: UVec2::new(600, 400),
    diagonal_mm: 43.2,
};

fn camera(spec: &RealisticSpec) -> Realistic {
    let skewed = DMat4::from_cols(
        DVec3::new(-1.5, 0.2, 0.1).extend(0.0),
        DVec3::new(0.3, 0.8, -0.2).extend(0.0),
        DVec3::new(0.1, -0.3, 2.0).extend(0.0),
        DVec3::new(0.4, -0.1, 0.3).extend(1.0),
    );
    let mut camera = Realistic::new(spec, &FILM, &Transform::from_matrix(skewed)).unwrap();
    camera.prepare_connections([Vec2::splat(-4.0), FILM.resolution.as_vec2() + 4.0]);
    camera
}

impl Realistic {
    /// The importance through an open stop, without tint.
    fn open(&self, traced: &Traced) -> f64 {
        self.importance(self.of_band(traced.band)) * traced.scale
    }
}

/// Cameras of every form, weight and stop, and of two bands.
fn specs() -> Vec<RealisticSpec> {
    let gauss = double_gauss();
    let mut two = gauss.clone();
    two.bands = [(0.99, 0.5), (1.01, 1.5)]
        .map(|(closer, tint)| {
            let p = Prescription {
                surfaces: gauss.lens.surfaces().to_vec(),
                film_distance: 0.0,
                positions: None,
                warnings: Vec::new(),
            };
            Band {
                lens: Lens::new(&p, closer * gauss.lens.film_distance()).unwrap(),
                wavelength: 0.5,
                tint: Rgb::new(tint, 1.0, 2.0 - tint),
            }
        })
        .to_vec();
    vec![
        gauss.clone(),
        RealisticSpec {
            form: Form::Pbrt3,
            weighting: Weighting::Simple,
            ..gauss.clone()
        },
        RealisticSpec {
            stop_shape: Some(StopShape::Gaussian),
            ..gauss.clone()
        },
        RealisticSpec {
            stop_shape: Some(StopShape::Polygon(StopPolygon::of_blades(6, 0.0))),
            ..gauss.clone()
        },
        two,
        RealisticSpec {
            tilt: [9.0, -4.0],
            shift: [3.0, -5.0],
            ..gauss.clone()
        },
        RealisticSpec {
            ghosts: true,
            tilt: [5.0, 2.0],
            ..gauss.clone()
        },
        RealisticSpec {
            tilt: [0.0, 12.0],
            stop_shape: Some(StopShape::Gaussian),
            ..gauss
        },
    ]
}

/// A ray of the camera, connected from a point on it in its own direction, lands where it began, counts for what the ray does, and both densities
/// say the same.
#[test]
fn a_connection_along_a_ray_of_the_camera_undoes_it() {
    for spec in specs() {
        let c = camera(&spec);
        let connections = c.connections.as_deref().unwrap();
        let (mut count, mut missed) = (0, 0);
        for (i, s) in samples(4000, Vec2::ZERO, FILM.resolution.as_vec2()).enumerate() {
            let Some(ray) = c.ray(&s, false) else {
                continue;
            };
            let unit = if spec.form == Form::Course { 1.0 } else { 1e-3 };
            // From a tenth of a meter to ten: a point is rounded to less than a micrometer.
            let distance = unit * 10f32.powf(2.0 + 2.0 * (i % 97) as f32 / 97.0);
            let p = ray.ray.at(distance);
            let placement = c.transform.placement(ray.ray.time);
            let x = connections
                .lens_from_camera
                .transform_point3(placement.point(p));
            let d = placement.direction(-ray.ray.d) * DVec3::new(1.0, 1.0, -1.0);
            let d = d.normalize();
            let density = connections.entrance.density(x, d);
            let inverse = c.connection_density(&s, &ray, p).unwrap();
            count += 1;
            if density == 0.0 {
                assert_eq!(inverse, 0.0);
                missed += 1;
                continue;
            }
            let drawn = Drawn { d, density };
            let traced = c
                .along(&placement, x, &drawn, c.band(s.wavelength))
                .unwrap();
            // The ray is rounded to single precision: one that grazes a rim may end there.
            let Some(landing) = c.land(&traced) else {
                missed += 1;
                continue;
            };
            // Directions are rounded to 1e-7: 5 nm on the film, of pixels of 60 µm, and of points to 1e-5 of them nearby.
            assert!(
                (landing.raster - s.raster).length() < 0.1,
                "{landing:?} {s:?}"
            );
            // The solid angle of its own film and pupil point, which are as uncertain.
            assert!((f64::from(landing.density) * inverse - 1.0).abs() < 1e-3);
            let expected = landing.density * ray.weight * ray.tint;
            let off = (landing.importance - expected).abs().max_element();
            assert!(f64::from(off) < 1e-3 * c.open(&traced), "{off}");
        }
        // A few tenths of a percent of the rays graze.
        assert!(count > 2000 && missed * 200 < count, "{count} {missed}");
    }
}

#[test]
fn bundles_land_as_rays_alone() {
    for spec in specs() {
        let c = camera(&spec);
        let from = |p: Vec3| ReferencePoint {
            p,
            ..Default::default()
        };
        let aims: Vec<Traced> = samples(6000, Vec2::ZERO, FILM.resolution.as_vec2())
            .filter_map(|s| {
                let ray = c.ray(&s, false)?;
                let unit = if spec.form == Form::Course { 1.0 } else { 1e-3 };
                let sample = LensSample {
                    lens: s.lens,
                    wavelength: s.raster.x.fract(),
                };
                Some(c.aim(&from(ray.ray.at(900.0 * unit)), &sample)?.2)
            })
            .collect();
        assert!(aims.len() > 3000);
        let (mut differ, mut all, mut few) = (0, ArrayVec::new(), ArrayVec::new());
        for bundle in aims.chunks(BUNDLE) {
            c.land_all(bundle, &mut all);
            assert_eq!(all.len(), bundle.len());
            // Whatever the others are.
            c.land_all(&bundle[bundle.len() / 2..], &mut few);
            assert_eq!(&all[bundle.len() / 2..], &few[..]);
            for (traced, found) in bundle.iter().zip(&all) {
                match (c.land(traced), found) {
                    (Some(a), Some(b)) => {
                        // A few roundings of 20 mm, of pixels of 60 µm.
                        assert!((a.raster - b.raster).length() < 1e-3, "{a:?} {b:?}");
                        // The stop's transmission there, by no more of its radius.
                        let off = (a.importance - b.importance).abs().max_element();
                        assert!(f64::from(off) < 1e-4 * c.open(traced), "{a:?} {b:?}");
                        let both = a.density > 0.0 && b.density > 0.0;
                        assert!(!both || (a.density / b.density - 1.0).abs() < 1e-3);
                        differ += i32::from(!both && a.density != b.density);
                    }
                    (None, None) => {}
                    _ => differ += 1,
                }
            }
        }
        // Rays that graze a rim.
        assert!(differ <= 5, "{differ}");
    }
}

#[test]
fn cameras_whose_rays_are_not_those_of_the_lens_do_not_connect() {
    for spec in [
        RealisticSpec {
            compat: Compat::PbrtV2,
            ..double_gauss()
        },
        RealisticSpec {
            model: ModelKind::Thick,
            ..double_gauss()
        },
        RealisticSpec {
            model: ModelKind::Thin,
            ..double_gauss()
        },
    ] {
        let c = camera(&spec);
        assert!(!c.connects() && c.connections.is_none());
    }
    // And one that has not been prepared finds nothing.
    let spec = CameraSpec::Realistic(Box::new(double_gauss()));
    let c = Camera::new(&spec, &FILM, &Transform::IDENTITY).unwrap();
    let from = ReferencePoint {
        p: Vec3::new(0.0, 0.0, 1000.0),
        ..Default::default()
    };
    let sample = LensSample {
        lens: Vec2::splat(0.4),
        wavelength: 0.5,
    };
    let none: Option<Aim> = c.aim(&from, &sample);
    assert!(c.connects() && none.is_none());
}
