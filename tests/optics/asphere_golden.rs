//! The aspheric lens among the golden data: Nikon Z 58 mm f/0.95 (WO 2019/229849, example 1), and lateral and
//! longitudinal color.

use fstop::cameras::{
    Band, CameraSample, Clip, Compat, FilmGeometry, Form, Realistic, RealisticSpec, Shutter,
    Weighting,
};
use fstop::math::transform::Transform;
use fstop::math::{Rgb, UVec2, Vec2};
use fstop::optics::analysis::{Beam, ChiefFinder, ObjectPlane, Spot};
use fstop::optics::asphere::Asphere;
use fstop::optics::dispersion::{AbbeModel, LINE_C, LINE_D, LINE_F};
use fstop::optics::real::Plain;
use fstop::optics::{Cause, ExitPupil, Lens, LensRay, LensTracer, Paraxial, Prescription};
use serde_json::Value;
use std::path::PathBuf;

fn golden(file: &str) -> String {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    std::fs::read_to_string(folder.join(file)).unwrap()
}

fn data(name: &str) -> Value {
    serde_json::from_str(&golden(&format!("{name}.json"))).unwrap()
}

fn number(data: &Value, path: &str) -> f64 {
    data.pointer(path)
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("no {path}"))
}

const NOCT: &str = "noct_58_f0.95";

/// Its aspheric surfaces, counted from 0, with the coefficients of r⁴, r⁶ … (the patent's example 1).
const NOCT_ASPHERES: [(usize, [f64; 6]); 3] = [
    (
        0,
        [
            -3.82177e-07,
            -6.06486e-11,
            -3.80172e-15,
            -1.32266e-18,
            0.0,
            0.0,
        ],
    ),
    (
        19,
        [
            -1.15028e-06,
            -4.51771e-10,
            2.7267e-13,
            -7.66812e-17,
            0.0,
            0.0,
        ],
    ),
    (
        27,
        [
            3.18645e-06,
            -1.14718e-08,
            7.74567e-11,
            -2.24225e-13,
            3.3479e-16,
            -1.7047e-19,
        ],
    ),
];

/// A golden prescription, the Noct with its aspheric terms.
fn prescription(name: &str) -> Prescription {
    let mut p = Prescription::parse(&golden(&format!("{name}.dat"))).unwrap();
    if name == NOCT {
        for (i, terms) in NOCT_ASPHERES {
            let mut asphere = Asphere::default();
            asphere.terms[1..7].copy_from_slice(&terms);
            p.surfaces[i].asphere = Some(asphere);
        }
    }
    p
}

#[test]
fn first_order_data_and_pupils() {
    let (p, data) = (prescription(NOCT), data(NOCT));
    let paraxial = Paraxial::new(&p.surfaces);
    let c = paraxial.cardinals.unwrap();
    let close = |found: f64, path: &str| {
        let expected = number(&data, path);
        // f64 arithmetic against correctly rounded values.
        let error = (found - expected).abs() / expected.abs().max(1.0);
        assert!(error <= 1e-12, "{path}: {found} {expected}");
    };
    close(c.focal_length, "/first_order/efl");
    close(c.back_focal_distance, "/first_order/bfd");
    close(c.front_principal_plane, "/first_order/z_H");
    close(
        paraxial.exit_pupil.unwrap().diameter,
        "/pupils/1/exit_diameter",
    );
    close(paraxial.entrance_pupil.unwrap().z, "/pupils/1/entrance_z");
}

/// Every golden ray in precision `B`: the same outcome, and position and direction within these tolerances.
fn check_rays<B: Plain + Into<f64> + std::fmt::Debug>(position: f64, direction: f64) {
    let (p, data) = (prescription(NOCT), data(NOCT));
    let film_z = number(&data, "/film_z");
    let length = p.length();
    for row in data["rays"].as_array().unwrap() {
        let x = |i: usize| row[i].as_f64().unwrap();
        let mut p = p.clone();
        for s in p.surfaces.iter_mut().filter(|s| s.is_stop) {
            s.aperture *= x(4);
        }
        let tracer = LensTracer::<B>::new(&p.surfaces);
        let exact = LensRay::<f64>::through([x(0), x(1), film_z], [x(2), x(3), length]);
        let ray = LensRay {
            o: exact.o.map(B::round_from),
            d: exact.d.map(B::round_from),
        };
        let result = tracer.to_scene(&ray);
        let outcome = row[5].as_str().unwrap();
        let surface = row[6].as_u64().unwrap_or(0) as usize;
        let cause = match outcome {
            "ok" => {
                let out = result.unwrap_or_else(|b| panic!("{b} {row}"));
                for i in 0..3 {
                    let (o, d): (f64, f64) = (out.o[i].into(), out.d[i].into());
                    assert!((o - x(7 + i)).abs() < position, "{row}: {o}");
                    assert!((d - x(10 + i)).abs() < direction, "{row}: {d}");
                }
                continue;
            }
            "vig" => Cause::Vignetted,
            "tir" => Cause::TotalReflection,
            _ => Cause::Missed,
        };
        let blocked = result.unwrap_err();
        assert_eq!((blocked.surface, blocked.cause), (surface, cause), "{row}");
    }
}

#[test]
fn rays_in_double_precision() {
    check_rays::<f64>(1e-11, 1e-12);
}

#[test]
fn rays_in_single_precision() {
    check_rays::<f32>(1e-4, 5e-6);
}

#[test]
fn chief_rays_and_spots_of_the_aspheric_lens() {
    let (p, data) = (prescription(NOCT), data(NOCT));
    let lens = Lens::new(&p, number(&data, "/film_z") - p.length()).unwrap();
    let pupil = ExitPupil::new(&lens, 1.1 * number(&data, "/image_radius"), 64);
    let chief = ChiefFinder::new(&lens);
    for field in data["fields"].as_array().unwrap() {
        let height = number(field, "/h");
        let ray = chief.find(height).unwrap();
        let expected = number(field, "/chief_object_angle_deg");
        assert!((ray.field_angle().to_degrees() - expected).abs() < 1e-8);
        let beam = Beam::new(&lens, &pupil, &ray, ObjectPlane::INFINITY).unwrap();
        let found = Spot::trace(&lens, &beam, 128).rms_radius();
        let expected = number(field, "/spot_rms_um/1") * 1e-3;
        // The edge of a beam 128 cells wide.
        assert!(
            (found / expected - 1.0).abs() < 1e-2,
            "{height}: {found} {expected}"
        );
    }
}

/// Lenses whose golden data tell of color, with the Abbe number behind each surface as their sources have it (0: air).
#[rustfmt::skip]
const COLORED: [(&str, &[f64]); 8] = [
    ("canon_uw_14", &[50.2, 0.0, 60.7, 0.0, 55.5, 0.0, 49.7, 0.0, 55.5, 38.0, 0.0, 64.1, 0.0, 51.0, 0.0, 49.7, 0.0, 0.0, 33.8, 30.1, 0.0, 23.9, 70.1, 0.0, 49.7, 0.0]),
    ("course_dgauss_100", &[47.1, 0.0, 47.1, 30.1, 0.0, 0.0, 38.0, 57.3, 0.0, 48.0, 0.0]),
    ("nikon_50_f1.2", &[46.57, 0.0, 29.42, 0.0, 26.52, 0.0, 0.0, 25.42, 46.57, 0.0, 25.42, 40.76, 0.0, 40.76, 0.0, 46.67, 0.0]),
    ("noct_58_f0.95", &[35.77, 55.07, 0.0, 44.46, 67.9, 0.0, 43.79, 0.0, 67.9, 0.0, 67.9, 32.33, 0.0, 0.0, 44.46, 82.57, 0.0, 40.69, 0.0, 32.33, 32.33, 0.0, 40.69, 30.13, 0.0, 40.69, 46.76, 0.0]),
    ("retrofocus_35", &[58.1, 0.0, 53.2, 0.0, 46.2, 0.0, 27.5, 0.0, 0.0, 27.5, 0.0, 53.9, 0.0, 57.3, 0.0]),
    ("tessar_100", &[58.019, 0.0, 36.366, 0.0, 0.0, 56.409, 58.019, 0.0]),
    ("triplet_50", &[60.281, 0.0, 36.366, 0.0, 0.0, 60.281, 0.0]),
    ("zoom_80_200_wide", &[25.41, 82.52, 0.0, 82.52, 0.0, 23.82, 0.0, 70.41, 0.0, 45.37, 0.0, 70.41, 23.82, 0.0, 45.37, 0.0, 82.52, 0.0, 82.52, 45.0, 0.0, 0.0, 47.47, 0.0, 82.52, 36.27, 0.0, 48.97, 0.0, 33.89, 0.0, 49.45, 0.0]),
];

/// The prescription with its Abbe numbers.
fn with_abbe_numbers(name: &str, abbe: &[f64]) -> Prescription {
    let mut p = prescription(name);
    assert_eq!(p.surfaces.len(), abbe.len());
    for (s, v) in p.surfaces.iter_mut().zip(abbe) {
        s.abbe = (*v > 0.0).then_some(*v);
    }
    p
}

#[test]
fn color_agrees_with_the_two_term_formula_of_the_golden_data() {
    for (name, abbe) in COLORED {
        let (p, data) = (with_abbe_numbers(name, abbe), data(name));
        for (line, wavelength) in [("C", LINE_C), ("F", LINE_F)] {
            let q = p.at_wavelength(wavelength, AbbeModel::TwoTerm);
            for (i, s) in q.surfaces.iter().enumerate() {
                let expected = number(&data, &format!("/chromatic/{line}/n/{i}"));
                // Some roundings, here and in Python.
                assert!((s.index - expected).abs() < 1e-14, "{name} {line} {i}");
            }
            let c = Paraxial::new(&q.surfaces).cardinals.unwrap();
            let at = |key: &str| number(&data, &format!("/chromatic/{line}/{key}"));
            // 1e-15 of the indices, amplified by some hundred mm of focal length and 30 surfaces.
            assert!((c.focal_length - at("efl")).abs() < 1e-10, "{name} {line}");
            assert!(
                (c.back_focal_distance - at("bfd")).abs() < 1e-10,
                "{name} {line}"
            );
        }
        let focus = |wavelength| {
            let q = p.at_wavelength(wavelength, AbbeModel::TwoTerm);
            Paraxial::new(&q.surfaces)
                .cardinals
                .unwrap()
                .back_focal_distance
        };
        let axial = focus(LINE_F) - focus(LINE_C);
        assert!((axial - number(&data, "/chromatic/axial_color_F_minus_C_bfd")).abs() < 1e-10);
    }
}

#[test]
fn lateral_color_agrees_with_the_golden_data() {
    for (name, abbe) in COLORED {
        let (p, data) = (with_abbe_numbers(name, abbe), data(name));
        let film_distance = number(&data, "/film_z") - p.length();
        let lens = Lens::new(&p, film_distance).unwrap();
        let chief = ChiefFinder::new(&lens);
        for row in data["chromatic"]["lateral"].as_array().unwrap() {
            let height = number(row, "/h_d");
            let tangent = chief.find(height).unwrap().tangent();
            for (key, wavelength) in [("/h_C", LINE_C), ("/h_F", LINE_F)] {
                let q = p.at_wavelength(wavelength, AbbeModel::TwoTerm);
                let lens = Lens::new(&q, film_distance).unwrap();
                let chief = ChiefFinder::new(&lens);
                // The film height whose chief ray comes in at that angle: the secant method.
                let error = |h: f64| chief.find(h).unwrap().tangent() - tangent;
                let (mut a, mut b) = (height, height * 1.0001);
                for _ in 0..6 {
                    let (fa, fb) = (error(a), error(b));
                    if fb == fa || fb.abs() < 1e-13 {
                        break;
                    }
                    (a, b) = (b, b - fb * (b - a) / (fb - fa));
                }
                let expected = number(row, key);
                // Golden chief rays have 1e-9 mm.
                assert!((b - expected).abs() < 1e-7, "{name} {key}: {b} {expected}");
            }
        }
    }
}

/// A camera of the lens with its stop, mm, set, whose rays see the indices of C, d and F in turn.
fn three_colored(p: &Prescription, film_distance: f64, stop: f64) -> Realistic {
    let mut p = p.clone();
    p.set_stops(stop);
    let lens = |wavelength| {
        let lens = p.at_wavelength(wavelength, AbbeModel::TwoTerm);
        Lens::new(&lens, film_distance).unwrap()
    };
    let bands = [(LINE_C, Rgb::X), (LINE_D, Rgb::Y), (LINE_F, Rgb::Z)];
    let spec = RealisticSpec {
        lens_name: String::new(),
        nominal_focal_length: None,
        lens: lens(LINE_D),
        form: Form::Course,
        weighting: Weighting::Physical,
        compat: Compat::None,
        pupil_sampling: Default::default(),
        model: Default::default(),
        stop_shape: None,
        precision: Default::default(),
        ghosts: false,
        coating: None,
        bands: bands
            .map(|(wavelength, tint)| Band {
                lens: lens(wavelength),
                wavelength,
                tint: 3.0 * tint,
            })
            .to_vec(),
        film_diagonal: None,
        shutter: Shutter::default(),
        shift: [0.0; 2],
        tilt: [0.0; 2],
        autofocus: None,
        exposure: Default::default(),
        clip: Clip::NONE,
    };
    Realistic::new(&spec, &FILM, &Transform::IDENTITY).unwrap()
}

/// Square, 30.5 mm from middle to edge.
const FILM: FilmGeometry = FilmGeometry {
    resolution: UVec2::new(1, 1),
    diagonal_mm: 61.0 * std::f64::consts::SQRT_2,
};

/// The camera's ray from `height` mm toward the film's top, through the middle of the pupil or so, in band number `band`: its
/// direction's tangent toward x, and where it is, x and z in mm.
fn camera_ray(camera: &Realistic, height: f64, u: f32, band: usize) -> (f64, [f64; 2]) {
    let sample = CameraSample {
        // The lens turns the image over.
        raster: Vec2::new((0.5 - height / 61.0) as f32, 0.5),
        time: 0.0,
        lens: Vec2::new(u, 0.5),
        wavelength: (band as f32 + 0.5) / 3.0,
    };
    let ray = camera.ray(&sample, false).expect("lit");
    assert_eq!(ray.tint[band], 3.0);
    let (o, d) = (ray.ray.o.as_dvec3(), ray.ray.d.as_dvec3());
    (d.x / d.z, [o.x, o.z])
}

#[test]
fn the_camera_shows_the_golden_lateral_color() {
    for (name, abbe) in COLORED {
        let (p, data) = (with_abbe_numbers(name, abbe), data(name));
        // A stop so small that all rays of a film point are its chief ray.
        let camera = three_colored(&p, number(&data, "/film_z") - p.length(), 1e-3);
        let mut largest = 0.0f64;
        for row in data["chromatic"]["lateral"].as_array().unwrap() {
            let tangents = ["/h_C", "/h_d", "/h_F"]
                .iter()
                .enumerate()
                .map(|(band, key)| camera_ray(&camera, number(row, key), 0.5, band).0);
            let tangents: Vec<f64> = tangents.collect();
            // The three film points see the same direction. A film point is right to 2e-6 mm (single precision
            // over 61 mm), a direction to 1e-7, and the middle of the pupil to its size.
            let efl = number(&data, "/chromatic/C/efl").abs();
            let scale = 1.0 + tangents[1] * tangents[1];
            let tolerance = (4e-6 / efl + 3e-7) * scale + 1e-5 * scale / efl;
            for other in [0, 2] {
                let off = (tangents[other] - tangents[1]).abs();
                assert!(off < tolerance, "{name} {other}: {off} {tolerance}");
            }
            largest = largest.max((number(row, "/h_F") - number(row, "/h_C")).abs());
        }
        // The three film points are a hundred times farther apart than that.
        assert!(largest > 2e-3, "{name}: {largest}");
    }
}

#[test]
fn the_camera_shows_the_golden_longitudinal_color() {
    let mut telling = 0;
    for (name, abbe) in COLORED {
        let (p, data) = (with_abbe_numbers(name, abbe), data(name));
        // With the film in the focal point of C its rays leave collimated, and those of F as from the
        // distance that Newton's formula tells.
        let bfd = |line: &str| number(&data, &format!("/chromatic/{line}/bfd"));
        let efl = number(&data, "/chromatic/F/efl");
        // At f/50 or so spherical aberration is nothing, less its change between the colors.
        let camera = three_colored(&p, bfd("C"), efl.abs() / 50.0);
        let slope = |band: usize| {
            let ends = [0.98, 0.02].map(|u| camera_ray(&camera, 0.0, u, band));
            let [(a, [xa, za]), (b, [xb, zb])] = ends;
            // Change of the direction per mm of height, at the same z.
            let height = (xa - za * a) - (xb - zb * b);
            ((a - b) / height, height.abs())
        };
        let expected = (bfd("F") - bfd("C")) / (efl * efl);
        let ((red, height), (blue, _)) = (slope(0), slope(2));
        // Four directions in single precision, and two hundredths for what f/50 leaves of aberration and its change
        // between the colors.
        let tolerance = 4.0 * 6e-8 / height + 0.02 * expected.abs();
        let off = (blue - red - expected).abs();
        assert!(off < tolerance, "{name}: {off} {tolerance} {expected}");
        telling += u32::from(tolerance < 0.2 * expected.abs());
    }
    // Achromats whose C and F meet tell nothing.
    assert!(telling >= 4, "{telling}");
}
