//! Derivatives of camera rays. All that needs no private part of the camera is in `tests/optics`.

use super::{Compat, Form, Realistic, RealisticSpec, Weighting};
use crate::cameras::{CameraSample, Clip, FilmGeometry, Shutter};
use crate::math::transform::Transform;
use crate::math::{UVec2, Vec2};
use crate::optics::pupil::PupilSampling;
use crate::optics::{Lens, Prescription};

/// The double Gauss of the course, its stop open.
const DGAUSS: &str = "29.475 3.76 1.67 25.2\n84.83 0.12 1 25.2\n19.275 4.025 1.67 23\n\
    40.77 3.275 1.699 23\n12.75 5.705 1 18\n0 4.5 0 17.1\n-14.495 1.18 1.603 17\n\
    40.77 6.065 1.658 20\n-20.385 0.19 1 20\n437.065 3.22 1.717 20\n-39.73 0 1 20\n";

pub(super) fn double_gauss() -> RealisticSpec {
    let prescription = Prescription::parse(DGAUSS).unwrap();
    let distance = Lens::focused(&prescription, 1000.0).unwrap();
    RealisticSpec {
        lens_name: "dgauss.dat".to_string(),
        lens: Lens::new(&prescription, distance).unwrap(),
        form: Form::Course,
        weighting: Weighting::Physical,
        compat: Compat::None,
        pupil_sampling: PupilSampling::default(),
        model: Default::default(),
        precision: Default::default(),
        stop_shape: None,
        bands: Vec::new(),
        film_diagonal: None,
        shutter: Shutter::default(),
        clip: Clip::NONE,
    }
}

/// Well-spread samples of the pixels from `low` to `high` and of the lens.
pub(super) fn samples(count: u32, low: Vec2, high: Vec2) -> impl Iterator<Item = CameraSample> {
    (0..count).map(move |i| {
        // The four-dimensional R sequence (Roberts 2018).
        let r = |k: i32| (0.5 + f64::from(i) / 1.167_303_978_261_418_7f64.powi(k)).fract() as f32;
        CameraSample {
            raster: low + Vec2::new(r(1), r(2)) * (high - low),
            time: 0.5,
            lens: Vec2::new(r(3), r(4)),
            wavelength: 0.5,
        }
    })
}

#[test]
fn differentials_point_to_the_neighbors_and_decide_nothing() {
    let film = FilmGeometry {
        resolution: UVec2::new(4000, 3000),
        diagonal_mm: 43.2,
    };
    let c = Realistic::new(&double_gauss(), &film, &Transform::IDENTITY).unwrap();
    let mut compared = 0;
    for s in samples(4000, Vec2::ZERO, Vec2::new(4000.0, 3000.0)) {
        let (plain, full) = (c.ray(&s, false), c.ray(&s, true));
        assert_eq!(plain.is_some(), full.is_some());
        let (Some(plain), Some(full)) = (plain, full) else {
            continue;
        };
        assert_eq!(
            (plain.ray.o, plain.ray.d, plain.weight),
            (full.ray.o, full.ray.d, full.weight)
        );
        let rd = full.differentials.unwrap();
        // The true ray of the next pixel through the same pupil point.
        let film_point = c.film_point(s.raster);
        let pupil = c.main.aim(film_point, s.lens).unwrap().point;
        let next = |raster: Vec2| {
            let out = c
                .spec
                .lens
                .trace_from_film(c.film_point(raster), pupil)
                .ok()?;
            let ray = c.camera_ray(&out);
            Some((ray.o.as_vec3(), ray.d.as_vec3()))
        };
        for (shift, o, d) in [(Vec2::X, rd.rx_o, rd.rx_d), (Vec2::Y, rd.ry_o, rd.ry_d)] {
            let Some((next_o, next_d)) = next(s.raster + shift) else {
                continue;
            };
            // A pixel is 9 um; the second derivative of its shift is of the order of its square over
            // the radii, 1e-5 of it. Single precision adds 1e-6 mm and 1e-7.
            assert!((o - next_o).length() < 5e-6, "{o} {next_o}");
            assert!((d - next_d).length() < 5e-7, "{d} {next_d}");
            compared += 1;
        }
    }
    assert!(compared > 3000);
}
