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
        shift: [0.0; 2],
        shutter: Shutter::default(),
        exposure: Default::default(),
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

/// A lens shifted by whole pixels shows at each pixel what one in the middle shows that many pixels on, in either precision, and reaches
/// beyond the unshifted film's corner without losing light.
#[test]
fn a_shifted_lens_shows_what_lies_there() {
    let film = FilmGeometry {
        resolution: UVec2::new(300, 200),
        diagonal_mm: 30.0,
    };
    let pitch = film.size_mm(30.0)[0] / 300.0;
    let straight = double_gauss();
    let shifted = RealisticSpec {
        shift: [20.0 * pitch, 35.0 * pitch],
        ..double_gauss()
    };
    let [straight, shifted] =
        [straight, shifted].map(|s| Realistic::new(&s, &film, &Transform::IDENTITY).unwrap());
    for s in samples(2000, Vec2::ZERO, Vec2::new(300.0, 200.0)) {
        // Right and up: raster y runs down.
        let there = CameraSample {
            raster: s.raster + Vec2::new(20.0, -35.0),
            ..s
        };
        let [a, b] = [
            shifted.film_point(s.raster),
            straight.film_point(there.raster),
        ];
        // Single precision of a raster coordinate of 300 pixels: 2e-5 pixels of 0.08 mm.
        assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 5e-6, "{a:?} {b:?}");
    }
    // All of the corner that is farther out has an exit pupil: irradiance by 4096 samples of one point, to 10/4096 and the pixel's size.
    let irradiance = |c: &Realistic, raster: Vec2| {
        let rays = samples(4096, raster, raster).filter_map(|s| c.ray(&s, false));
        rays.map(|r| f64::from(r.weight)).sum::<f64>() / 4096.0
    };
    for [x, y] in [[0.0, 0.0], [300.0, 0.0], [150.0, 100.0], [299.0, 1.0]] {
        let raster = Vec2::new(x, y);
        let here = irradiance(&shifted, raster);
        let there = irradiance(&straight, raster + Vec2::new(20.0, -35.0));
        assert!(
            there > 0.0 && (here / there - 1.0).abs() < 0.02,
            "{raster}: {here} {there}"
        );
    }
}

/// Exposure is a factor, and no shape of the weight depends on it.
#[test]
fn exposure_multiplies_every_weight() {
    let film = FilmGeometry {
        resolution: UVec2::new(30, 20),
        diagonal_mm: 30.0,
    };
    let camera = |weighting, exposure| {
        let spec = RealisticSpec {
            weighting,
            exposure,
            ..double_gauss()
        };
        Realistic::new(&spec, &film, &Transform::IDENTITY).unwrap()
    };
    let exposure = super::Exposure {
        time: Some(0.25),
        iso: Some(200.0),
    };
    for weighting in [Weighting::Physical, Weighting::Simple] {
        let [usual, set] = [Default::default(), exposure].map(|e| camera(weighting, e));
        for s in samples(100, Vec2::ZERO, Vec2::new(30.0, 20.0)) {
            let weights = [&usual, &set].map(|c| c.ray(&s, false).map(|r| r.weight));
            // The shutter's interval is 1; a power of two is exact.
            assert_eq!(weights[0].map(|w| 0.5 * w), weights[1]);
        }
    }
}
