//! Derivatives of camera rays. All that needs no private part of the camera is in `tests/optics`.

use super::autofocus::{Autofocus, LensMaker, Stop, Zone};
use super::{Compat, Form, PupilTarget, Realistic, RealisticSpec, Weighting};
use crate::cameras::{BUNDLE, CameraChoices, CameraRay, CameraSample, Clip, FilmGeometry, Shutter};
use crate::math::ray::Ray;
use crate::math::transform::Transform;
use crate::math::{UVec2, Vec2};
use crate::optics::models::ModelKind;
use crate::optics::pupil::PupilSampling;
use crate::optics::{Lens, Prescription};
use crate::params::testing::{Surroundings, read_in};
use crate::syntax::SearchFolder;

/// The double Gauss of the course, its stop open.
const DGAUSS: &str = "29.475 3.76 1.67 25.2\n84.83 0.12 1 25.2\n19.275 4.025 1.67 23\n\
    40.77 3.275 1.699 23\n12.75 5.705 1 18\n0 4.5 0 17.1\n-14.495 1.18 1.603 17\n\
    40.77 6.065 1.658 20\n-20.385 0.19 1 20\n437.065 3.22 1.717 20\n-39.73 0 1 20\n";

pub(super) fn double_gauss() -> RealisticSpec {
    let prescription = Prescription::parse(DGAUSS).unwrap();
    let distance = Lens::focused(&prescription, 1000.0).unwrap();
    RealisticSpec {
        lens_name: "dgauss.dat".to_string(),
        nominal_focal_length: None,
        lens: Lens::new(&prescription, distance).unwrap(),
        form: Form::Course,
        weighting: Weighting::Physical,
        compat: Compat::None,
        pupil_sampling: PupilSampling::default(),
        model: Default::default(),
        precision: Default::default(),
        stop_shape: None,
        bands: Vec::new(),
        ghosts: false,
        coating: None,
        film_diagonal: None,
        shift: [0.0; 2],
        tilt: [0.0; 2],
        autofocus: None,
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
    let tilted = RealisticSpec {
        tilt: [8.0, -3.0],
        shift: [2.0, 1.0],
        ..double_gauss()
    };
    for spec in [double_gauss(), tilted] {
        let c = Realistic::new(&spec, &film, &Transform::IDENTITY).unwrap();
        point_to_the_neighbors(&c);
    }
}

fn point_to_the_neighbors(c: &Realistic) {
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
        let (_, pupil) = c.aimed(&c.main, film_point, s.lens).unwrap();
        let pupil = pupil.point;
        let next = |raster: Vec2| {
            let out = c
                .spec
                .lens
                .trace_from_film(c.on_flat(c.film_point(raster), pupil), pupil)
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

/// The neighbors of rays made side by side are those of rays made alone, whatever the model of the lens.
#[test]
fn bundles_have_the_differentials_of_rays_alone() {
    let film = FilmGeometry {
        resolution: UVec2::new(400, 300),
        diagonal_mm: 43.2,
    };
    for model in [ModelKind::Exact, ModelKind::Thick, ModelKind::Thin] {
        let spec = RealisticSpec {
            model,
            ..double_gauss()
        };
        let c = Realistic::new(&spec, &film, &Transform::IDENTITY).unwrap();
        let all: Vec<_> = samples(2048, Vec2::ZERO, Vec2::new(400.0, 300.0)).collect();
        let mut compared = 0;
        for bundle in all.chunks(BUNDLE) {
            let mut rays = [None; BUNDLE];
            c.rays_in_lanes(bundle, true, &mut rays).unwrap();
            for (sample, ray) in bundle.iter().zip(rays) {
                let (Some(ray), Some(alone)) = (ray, c.ray(sample, true)) else {
                    continue;
                };
                let steps = |ray: &CameraRay| {
                    let next = ray.differentials.as_ref().unwrap();
                    [next.rx_d - ray.ray.d, next.ry_d - ray.ray.d]
                };
                for (step, alone) in steps(&ray).into_iter().zip(steps(&alone)) {
                    // Differences of unit vectors in single precision; a pixel of 90 um is 2e-3.
                    let off = (step - alone).length();
                    assert!(off < 1e-6, "{model}: {step} {alone}");
                    assert!(alone.length() > 1e-3, "{model}: {alone}");
                }
                compared += 1;
            }
        }
        assert!(compared > 1000, "{model}: {compared}");
    }
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

/// Irradiance of points of a tilted film by rays of the camera, and by directions spread evenly over what the film faces, which knows nothing of
/// pupils and weights.
#[test]
fn a_tilted_film_sees_all_the_light_that_falls_on_it() {
    const COUNT: u32 = 1 << 17;
    let film = FilmGeometry {
        resolution: UVec2::new(300, 200),
        diagonal_mm: 40.0,
    };
    for (tilt, shift) in [([10.0, 0.0], [0.0, 0.0]), ([-6.0, 14.0], [3.0, -4.0])] {
        let spec = RealisticSpec {
            tilt,
            shift,
            ..double_gauss()
        };
        let c = Realistic::new(&spec, &film, &Transform::IDENTITY).unwrap();
        let tilted = c.tilted.as_ref().unwrap();
        let [(sin, cos), (sin_y, cos_y)] = tilt.map(|t: f64| t.to_radians().sin_cos());
        let turned = |v: [f64; 3]| {
            let [x, y, z] = [v[0], cos * v[1] - sin * v[2], sin * v[1] + cos * v[2]];
            [cos_y * x - sin_y * z, y, sin_y * x + cos_y * z]
        };
        for [x, y] in [[150.0, 100.0], [20.0, 30.0], [290.0, 100.0], [140.0, 195.0]] {
            let raster = Vec2::new(x, y);
            let by_rays = samples(COUNT, raster, raster).filter_map(|s| c.ray(&s, false));
            let by_rays = by_rays.map(|r| f64::from(r.weight)).sum::<f64>() / f64::from(COUNT);
            let from = tilted.point(c.film_point(raster)).to_array();
            let passed = samples(COUNT, raster, raster).filter(|s| {
                // A disk of direction cosines is the hemisphere's projection.
                let p = crate::math::sampling::concentric_disk(s.lens).as_dvec2();
                let z = -(1.0 - p.length_squared()).max(0.0).sqrt();
                let d = turned([p.x, p.y, z]);
                let ray = crate::optics::LensRay { o: from, d };
                d[2] < 0.0 && spec.lens.tracer().to_scene(&ray).is_ok()
            });
            let truth = std::f64::consts::PI * passed.count() as f64 / f64::from(COUNT);
            // Some 3000 of the directions pass, evenly spread: to half a percent.
            assert!(truth > 0.02, "{tilt:?} at {raster}: {truth}");
            assert!(
                (by_rays / truth - 1.0).abs() < 0.01,
                "{tilt:?} at {raster}: {by_rays} {truth}"
            );
        }
    }
}

/// Scheimpflug: the rays of any point of a tilted film meet on the plane that is said to be sharp, and on no other.
#[test]
fn what_is_sharp_on_a_tilted_film_lies_in_its_plane() {
    let film = FilmGeometry {
        resolution: UVec2::new(300, 200),
        diagonal_mm: 12.0,
    };
    let mut prescription = Prescription::parse(DGAUSS).unwrap();
    prescription.set_stops(4.0);
    let distance = Lens::focused(&prescription, 1000.0).unwrap();
    for tilt in [[4.0, 0.0], [-3.0, 2.0]] {
        let spec = RealisticSpec {
            lens: Lens::new(&prescription, distance).unwrap(),
            tilt,
            ..double_gauss()
        };
        let c = Realistic::new(&spec, &film, &Transform::IDENTITY).unwrap();
        let plane = spec.sharp_plane().unwrap();
        let flat = crate::optics::focus::SharpPlane {
            normal: [0.0, 0.0, 1.0],
            distance: spec.lens.plane_of_focus().unwrap(),
        };
        // Root mean square distance of the rays' points from their mean, over the plane's distance.
        let spot = |plane: &crate::optics::focus::SharpPlane, raster: Vec2| {
            let n = glam::DVec3::from(plane.normal);
            let points: Vec<glam::DVec3> = samples(256, raster, raster)
                .filter_map(|s| c.ray(&s, false))
                .map(|r| {
                    // The course's camera space is the lens' with z turned round.
                    let turned =
                        |v: crate::math::Vec3| v.as_dvec3() * glam::DVec3::new(1.0, 1.0, -1.0);
                    let (o, d) = (turned(r.ray.o), turned(r.ray.d));
                    o + d * ((plane.distance - n.dot(o)) / n.dot(d))
                })
                .collect();
            let count = points.len() as f64;
            let mean = points.iter().sum::<glam::DVec3>() / count;
            let spread = points.iter().map(|p| p.distance_squared(mean)).sum::<f64>();
            (spread / count).sqrt() / mean.length()
        };
        for [x, y] in [[150.0, 5.0], [150.0, 195.0], [5.0, 100.0], [295.0, 190.0]] {
            let raster = Vec2::new(x, y);
            let (sharp, other) = (spot(&plane, raster), spot(&flat, raster));
            // A third of a pixel of 33 um, seen 50 mm from it: aberrations at f/12, and field curvature; out of the plane's focus by
            // some 0.3 mm at f/12 the spot is a pixel wide.
            let pixel = 0.033 / 50.0;
            assert!(
                sharp < 0.15 * pixel,
                "{tilt:?} at {raster}: {sharp} {other}"
            );
            // Along the line that the film turns about both planes are one.
            let apart = y == 100.0 || other > 2.0 * sharp;
            assert!(apart, "{tilt:?} at {raster}: {sharp} {other}");
        }
    }
}

/// A film that a tilt turns into the lens is refused.
#[test]
fn a_film_does_not_reach_into_the_lens() {
    let film = FilmGeometry {
        resolution: UVec2::new(30, 20),
        diagonal_mm: 100.0,
    };
    let spec = RealisticSpec {
        tilt: [0.0, 80.0],
        ..double_gauss()
    };
    let refused = Realistic::new(&spec, &film, &Transform::IDENTITY);
    assert!(matches!(refused, Err(crate::cameras::CameraError::FilmInLens(by)) if by > 0.0));
}

/// `worldToNDC` shows where a tilted film has the image of a point: where a ray near the axis through the middle of the pupil began. And the
/// circle of confusion is as wide as the rays through the pupil's edge are apart at the point, in pixels.
#[test]
fn a_tilted_films_image_is_where_it_is_said_to_be_and_as_sharp() {
    let film = FilmGeometry {
        resolution: UVec2::new(300, 200),
        diagonal_mm: 4.0,
    };
    let mut prescription = Prescription::parse(DGAUSS).unwrap();
    prescription.set_stops(3.0);
    let distance = Lens::focused(&prescription, 1000.0).unwrap();
    let spec = RealisticSpec {
        lens: Lens::new(&prescription, distance).unwrap(),
        tilt: [14.0, -20.0],
        shift: [0.3, -0.2],
        ..double_gauss()
    };
    let c = Realistic::new(&spec, &film, &Transform::IDENTITY).unwrap();
    let seen = crate::cameras::CameraSpec::Realistic(Box::new(spec.clone()));
    let ndc = seen.ndc_from_camera(&film).unwrap();
    // All but flat, the film's matrix is all but the flat film's.
    let matrix = |tilt| {
        let spec = RealisticSpec {
            tilt,
            ..spec.clone()
        };
        crate::cameras::CameraSpec::Realistic(Box::new(spec)).ndc_from_camera(&film)
    };
    let (flat, nearly) = (matrix([0.0; 2]).unwrap(), matrix([1e-9, 1e-9]).unwrap());
    // A billionth of a degree, some 2e-11, of numbers up to 1e5: 50 mm in a film of 4, times the distance of the pinhole.
    assert!(nearly.abs_diff_eq(flat, 1e-5), "{nearly} {flat}");
    let exit = spec.lens.paraxial().exit_pupil.unwrap().z;
    let PupilTarget::Pupil(pupil) = &c.main.aim else {
        panic!("an exit pupil");
    };
    let half = pupil.region(0.0).unwrap().along;
    for [x, y] in [[150.0, 100.0], [20.0, 30.0], [290.0, 10.0], [140.0, 195.0]] {
        let raster = Vec2::new(x, y);
        let through = |raster: Vec2, at: [f64; 3]| {
            let from = c.on_flat(c.film_point(raster), at);
            let ray = c.camera_ray(&spec.lens.trace_from_film(from, at).unwrap());
            move |z: f64| ray.o + ray.d * ((z - ray.o.z) / ray.d.z)
        };
        for z in [500.0, 900.0, 3000.0] {
            let p = through(raster, [0.0, 0.0, exit])(z);
            let shown = ndc.project_point3(p);
            // Distortion 2 mm off the axis, and pupil aberration: a twentieth of a pixel of 11 um.
            let off = [
                shown.x - f64::from(x) / 300.0,
                shown.y - f64::from(y) / 200.0,
            ];
            let pixels = (300.0 * off[0]).hypot(200.0 * off[1]);
            assert!(pixels < 0.05, "{raster} at {z}: {pixels} pixels");
            let edge = |side: f64| through(raster, [0.5 * side * half, 0.0, pupil.plane_z()])(z).x;
            let next = through(raster + Vec2::X, [0.0, 0.0, exit])(z).x;
            let truth = 2.0 * ((edge(1.0) - edge(-1.0)) / (next - p.x)).abs();
            let coc = c.blur(p.as_vec3(), 0.5).diameter(z);
            // Spherical aberration of f/17 and single precision: a few hundredths of a pixel.
            assert!(
                (coc - truth).abs() < 0.05 + 0.01 * truth,
                "{raster} at {z}: {coc} {truth}"
            );
        }
    }
}

/// What a point of the image shows is sharp there once the lens is focused on it: in either form, on a flat film and on a tilted one.
#[test]
fn what_is_focused_on_becomes_sharp() {
    let film = FilmGeometry {
        resolution: UVec2::new(300, 200),
        diagonal_mm: 30.0,
    };
    let forms = [(Form::Course, 1.0), (Form::Pbrt3, 1e-3)];
    let tilts = [[0.0; 2], [6.0, -4.0]];
    for ((form, unit), tilt) in forms.iter().flat_map(|f| tilts.map(|t| (*f, t))) {
        let maker = LensMaker {
            prescription: Prescription::parse(DGAUSS).unwrap(),
            zoom: None,
            stop: Stop::Diameter(4.0),
            best: false,
            dispersion: false,
        };
        let mut spec = RealisticSpec {
            form,
            tilt,
            shift: [1.0, -2.0],
            autofocus: Some(Box::new(Autofocus {
                zones: vec![Zone::Point([0.3, 0.6])],
                object: None,
                place: None,
                chosen: None,
                maker,
            })),
            ..double_gauss()
        };
        let camera =
            |spec: &RealisticSpec| Realistic::new(spec, &film, &Transform::IDENTITY).unwrap();
        // A wall, 700 mm away.
        let wall = |ray: &Ray| Some(ray.at((700.0 * unit - ray.o.z) / ray.d.z));
        let raster = Vec2::new(90.0, 120.0);
        let spot = |c: &Realistic| {
            let rays = samples(256, raster, raster).filter_map(|s| c.ray(&s, false));
            let points: Vec<glam::DVec3> = rays
                .filter_map(|r| Some(wall(&r.ray)?.as_dvec3()))
                .collect();
            let count = points.len() as f64;
            let mean = points.iter().sum::<glam::DVec3>() / count;
            let spread = points.iter().map(|p| p.distance_squared(mean)).sum::<f64>();
            (spread / count).sqrt() / f64::from(unit)
        };
        // At f/2, focused at 1 m.
        assert!(spot(&camera(&spec)) > 1.0, "{form:?} {tilt:?}");
        for _ in 0..3 {
            spec = camera(&spec).refocused(&film, &wall).unwrap().unwrap();
        }
        assert_eq!(
            spec.autofocus.as_ref().unwrap().chosen,
            Some(Zone::Point([0.3, 0.6]))
        );
        // A pixel is 1.2 mm there. Focused at 1 m a stop of 4 mm has spots of 0.4 mm; aberrations of f/12 are some hundredths.
        let found = spot(&camera(&spec));
        assert!(found < 0.08, "{form:?} {tilt:?}: {found} mm");
    }
}

/// ISET3d's cameras have the film's distance in meters.
#[test]
fn a_film_distance_in_meters_is_told() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("d.dat"), DGAUSS).unwrap();
    let here = Surroundings {
        search: SearchFolder::new(folder.path()),
        word: "Camera",
        ..Surroundings::default()
    };
    let warned = |distance: &str| {
        let params = format!("\"string lensfile\" \"d.dat\" \"float filmdistance\" {distance}");
        let choices = CameraChoices::default();
        let outcome = read_in(&here, "realistic", &params, |p| {
            RealisticSpec::from_params(p, &choices).is_some()
        });
        assert!(outcome.value, "{}", outcome.text);
        outcome
            .text
            .contains("ISET3d's cameras have meters: write 36.77?")
    };
    assert!(warned("0.03677"));
    // Inside the lens, but not what a thousandth explains.
    assert!(!warned("0.003") && !warned("36.77"));
}
