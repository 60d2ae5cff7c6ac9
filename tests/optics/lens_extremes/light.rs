//! How much light arrives: the exit pupil's samples and the camera's rays, in double precision and in lanes.
//!
//! On the axis the truth has a closed form for every lens: all light within a cone, whose angle is found by halving, and
//! so a projected solid angle of π sin² of it (or a sum of such).

use super::cases::{self, Case, case, prescription};
use super::rays::{lens, spread};
use fstop::cameras::{
    BUNDLE, Camera, CameraSample, CameraSpec, Clip, Compat, FilmGeometry, Form, Precision,
    RealisticSpec, Shutter, Weighting,
};
use fstop::math::transform::Transform;
use fstop::math::{UVec2, Vec2};
use fstop::optics::models::ModelKind;
use fstop::optics::pupil::{PupilSampling, RINGS};
use fstop::optics::{ExitPupil, Lens, LensRay, Prescription};
use proptest::prelude::*;
use std::f64::consts::PI;

/// sin² of the cone of light that reaches the middle of the film, and the sum of it and of rings beyond, where aberration
/// lets rays through again.
fn squared_sines(lens: &Lens) -> [f64; 2] {
    let passes = |sine: f64| {
        let d = [sine, 0.0, -(1.0 - sine * sine).max(0.0).sqrt()];
        let ray = LensRay {
            o: [0.0, 0.0, lens.film_z()],
            d,
        };
        lens.tracer().to_scene(&ray).is_ok()
    };
    // Sines from 1e-12 to 1, a hundredth apart: one side of each change of outcome counts.
    let at = |i: i32| 10f64.powf(-12.0 + f64::from(i) / 230.0).min(1.0);
    let (mut sum, mut cone) = (0.0, None);
    let mut light = passes(at(0));
    for i in 1..=2760 {
        if passes(at(i)) == light {
            continue;
        }
        let (mut low, mut high) = (at(i - 1), at(i));
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if passes(middle) == light {
                low = middle
            } else {
                high = middle
            }
        }
        sum += if light { low * low } else { -high * high };
        if light && cone.is_none() {
            cone = Some(sum);
        }
        light = !light;
    }
    let all = if light { sum + 1.0 } else { sum };
    [cone.unwrap_or(all), all]
}

/// Mean projected solid angle of samples of the exit pupil, seen from the middle of the film.
fn sampled(lens: &Lens, film_radius: f64, count: usize) -> f64 {
    let pupil = ExitPupil::new(lens, film_radius, RINGS);
    let weights = (0..count).filter_map(|i| {
        let u = spread(i);
        let sample = pupil.sample([0.0, 0.0], Vec2::new(u[0] as f32, u[1] as f32))?;
        let weight = pupil.projected_solid_angle([0.0, 0.0], &sample);
        assert!(weight.is_finite() && weight >= 0.0, "{sample:?}");
        lens.trace_from_film([0.0, 0.0], sample.point)
            .is_ok()
            .then_some(weight)
    });
    weights.sum::<f64>() / count as f64
}

fn camera(lens: &Lens, diagonal: f64, precision: Precision) -> Result<Camera, String> {
    let spec = RealisticSpec {
        lens_name: "extreme.dat".to_string(),
        nominal_focal_length: None,
        lens: lens.clone(),
        form: Form::Course,
        weighting: Weighting::Physical,
        compat: Compat::None,
        pupil_sampling: PupilSampling::default(),
        model: ModelKind::Exact,
        precision,
        stop_shape: None,
        bands: Vec::new(),
        ghosts: false,
        coating: None,
        film_diagonal: None,
        shutter: Shutter::default(),
        shift: [0.0; 2],
        tilt: [0.0; 2],
        autofocus: None,
        exposure: Default::default(),
        clip: Clip::NONE,
    };
    Camera::new(
        &CameraSpec::Realistic(Box::new(spec)),
        &film(diagonal),
        &Transform::IDENTITY,
    )
    .map_err(|e| e.to_string())
}

/// Nine by nine pixels.
fn film(diagonal_mm: f64) -> FilmGeometry {
    FilmGeometry {
        resolution: UVec2::splat(9),
        diagonal_mm,
    }
}

/// What the camera shows of a white scene at the raster point `at`; every ray must be sound.
fn white(camera: &Camera, at: Vec2, count: usize) -> f64 {
    let samples: Vec<CameraSample> = (0..count)
        .map(|i| {
            let u = spread(i);
            CameraSample {
                raster: at,
                time: 0.5,
                lens: Vec2::new(u[0] as f32, u[1] as f32),
                wavelength: 0.5,
            }
        })
        .collect();
    let mut sum = 0.0;
    for bundle in samples.chunks(BUNDLE) {
        let mut rays = [None; BUNDLE];
        camera.rays(bundle, false, &mut rays);
        for ray in rays.iter().flatten() {
            assert!(ray.weight.is_finite() && ray.weight >= 0.0, "{ray:?}");
            assert!(
                ray.ray.o.is_finite() && (ray.ray.d.length() - 1.0).abs() < 1e-5,
                "{ray:?}"
            );
            sum += f64::from(ray.weight);
        }
    }
    sum / count as f64
}

/// The pupil's mean and that of both cameras, against the truth.
fn check(
    Case {
        name,
        text,
        film_distance,
    }: &Case,
    tolerance: f64,
) -> Result<(), String> {
    let lens = Lens::new(&prescription(text), *film_distance).map_err(|e| e.to_string())?;
    check_lens(name, &lens, tolerance)
}

fn check_lens(name: &str, lens: &Lens, tolerance: f64) -> Result<(), String> {
    let [cone, truth] = squared_sines(lens).map(|s| PI * s);
    // A film so small that it all sees what its middle sees.
    let diagonal = 1e-3 * lens.film_distance().min(lens.rear().clear_radius());
    let count = 1 << 12;
    // Even over the area, samples of a pupil much wider than its distance are few where the light comes from: weights
    // go with cos⁴, whose relative deviation is tan θ/√3.
    let squared = (truth / PI).min(1.0);
    let noise = (squared / (1.0 - squared) / (3.0 * count as f64)).sqrt();
    // Of lenses nobody would make the survey of the pupil may overlook rings outside a dark one (see
    // `of_wild_lenses_next_to_nothing_is_lost` in src/optics/pupil/tests.rs), and nothing else.
    let right = |found: f64| {
        let most = tolerance + noise;
        let dark = found < 1e-18 && truth < 1e-18;
        dark || noise > 1.0 || (found >= cone * (1.0 - most) && found <= truth * (1.0 + most))
    };
    let found = sampled(lens, diagonal, count);
    if !right(found) {
        return Err(format!("{name}: pupil {found}, truth {truth}"));
    }
    let narrowest = lens
        .surfaces()
        .iter()
        .map(|s| s.clear_radius())
        .fold(f64::INFINITY, f64::min);
    // An f32 is good to 1e-7 of the way through the lens, times what the glass does to it: rims must be larger.
    let single = narrowest > 1e-4 * lens.length();
    for precision in [Precision::Double, Precision::Single]
        .into_iter()
        .take(1 + usize::from(single))
    {
        let camera = camera(lens, diagonal, precision)?;
        // A film in a medium gets its squared index times what one in air does.
        let found = white(&camera, Vec2::splat(4.5), count) / lens.rear().index.powi(2);
        if !right(found) {
            return Err(format!(
                "{name}: camera ({precision:?}) {found}, truth {truth}"
            ));
        }
        let said = [camera.describe(&film(diagonal)), camera.warnings()]
            .concat()
            .join("\n");
        if said.contains("NaN") {
            return Err(format!("{name}: {said}"));
        }
    }
    Ok(())
}

#[test]
fn every_extreme_lens_lets_the_right_amount_of_light_through() {
    let mut wrong = Vec::new();
    for case in cases::all() {
        // 4096 well-spread samples of pupils up to a few film distances wide: within half a percent.
        wrong.extend(check(&case, 5e-3).err());
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_hole_shows_the_solid_angle_it_has() {
    // Radius a at distance Z: π a²/(a² + Z²).
    for (a, z) in [
        (5e-4f64, 50.0),
        (5e-4, 1e-3),
        (5e-7, 1e-6),
        (5e-4, 1e6),
        (5.0, 1e6),
        (500.0, 1e6),
        (500.0, 250.0),
    ] {
        let lens = Lens::new(&prescription(&format!("0 0 0 {}\n", 2.0 * a)), z).expect("a lens");
        let sine = a / a.hypot(z);
        assert!((squared_sines(&lens)[1] / (sine * sine) - 1.0).abs() < 1e-11);
        check_lens(&format!("{a} at {z}"), &lens, 5e-3).unwrap_or_else(|e| panic!("{e}"));
    }
}

#[test]
fn a_closed_stop_is_dark_and_said_to_be() {
    let mut closed = prescription("50 5 1.5 20\n-50 2 1 20\n0 3 0 8\n60 0 1.5 20\n");
    closed.set_stops(0.0);
    let lens = Lens::new(&closed, 40.0).expect("a lens");
    for precision in [Precision::Double, Precision::Single] {
        let camera = camera(&lens, 20.0, precision).expect("a camera");
        for at in [4.5, 0.5, -3.0] {
            assert_eq!(white(&camera, Vec2::splat(at), 512), 0.0);
        }
        assert!(
            camera
                .warnings()
                .iter()
                .any(|w| w.contains("no light reaches the middle")),
            "{:?}",
            camera.warnings()
        );
    }
}

#[test]
fn a_film_inside_the_lens_is_refused_and_one_inside_its_last_element_warned_of() {
    let lens = prescription("50 5 1.5 20\n-50 0 1 20\n");
    for distance in [
        0.0,
        -0.0,
        -1e-6,
        -5.0,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
    ] {
        let error = Lens::new(&lens, distance)
            .expect_err("no film there")
            .to_string();
        assert!(error.contains("expected a positive distance"), "{error}");
    }
    // A rim 6.8 mm behind the vertex. In front of the film everything is as it should be, off its middle too.
    for film_distance in [3.0, 6.0, 6.7, 0.5] {
        let case = case("inside", "inf 3 1.5 30\n20 0 1 30\n", film_distance);
        let camera = camera(&case.lens(), 1e-3, Precision::Single).expect("a camera");
        assert!(
            camera
                .warnings()
                .iter()
                .any(|w| w.contains("inside the rear element")),
            "{:?}",
            camera.warnings()
        );
        check(&case, 5e-3).unwrap_or_else(|e| panic!("{film_distance}: {e}"));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Between the extremes too.
    #[test]
    fn every_lens_lets_the_right_amount_of_light_through(
        surfaces in lens(1..8),
        film_distance in (-3.0..4.0f64).prop_map(|e| 10f64.powf(e)),
    ) {
        let lens = Prescription { surfaces, film_distance, positions: None, warnings: Vec::new() };
        let lens = Lens::new(&lens, film_distance).expect("surfaces and a film");
        check_lens("", &lens, 0.02).map_err(TestCaseError::fail)?;
    }
}
