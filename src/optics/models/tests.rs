//! Models against exact rays.

use super::*;
use crate::optics::Prescription;
use crate::optics::pupil::RINGS;
use crate::optics::surface::Surface;
use proptest::prelude::*;

/// mm: 6000 pixels over 36 mm.
const PIXEL: f64 = 0.006;

fn lens(name: &str, scale: f64, distance: f64) -> Lens {
    let path = format!("{}/tests/golden/{name}.dat", env!("CARGO_MANIFEST_DIR"));
    let mut prescription = Prescription::read(path.as_ref()).unwrap();
    for s in prescription.surfaces.iter_mut().filter(|s| s.is_stop) {
        s.aperture *= scale;
    }
    let film_distance = Lens::focused(&prescription, distance).unwrap();
    Lens::new(&prescription, film_distance).unwrap()
}

/// Film points and pupil samples, as [`Models::error`] takes them.
fn aims(models: &Models, count: usize) -> Vec<([f64; 2], [f64; 3])> {
    (0..count)
        .filter_map(|i| {
            let (film, u) = models.sample(i);
            Some((film, models.pupil.sample(film, u)?.point))
        })
        .collect()
}

#[test]
fn errors_are_those_an_independent_program_measured() {
    // rms in pixels at full stop and a quarter of it, infinity focus, over the image circle: a
    // fit and tracer of another author (other rays, least squares too). Each fit weighs rays its own
    // way, and 0.05 pixels of a table come from its film radii.
    let measured = [
        (
            "dgauss_50",
            21.6,
            1.0,
            [28.0, 2.8, 0.58, 0.10, 0.01, 3.9, 0.61],
        ),
        (
            "dgauss_50",
            21.6,
            0.25,
            [25.0, 1.7, 0.05, 4e-3, 2e-4, 0.29, 0.02],
        ),
        (
            "telephoto_250",
            21.6,
            1.0,
            [12.0, 1.2, 0.10, 8e-3, 6e-4, 1.7, 1.0],
        ),
    ];
    let kinds = [
        ModelKind::Thick,
        ModelKind::Polynomial(3),
        ModelKind::Polynomial(5),
        ModelKind::Polynomial(7),
        ModelKind::Polynomial(9),
        ModelKind::Table(1),
        ModelKind::Table(3),
    ];
    // What is given as 0.01 may be nearly 0.015.
    const ROUNDED: f64 = 0.005;
    for (name, film_radius, scale, expected) in measured {
        let lens = lens(name, scale, f64::INFINITY);
        let pupil = ExitPupil::new(&lens, film_radius, RINGS);
        let models = Models::new(&lens, &pupil, film_radius);
        for (kind, expected) in kinds.into_iter().zip(expected) {
            let error = models.error(&models.model(kind).unwrap(), PIXEL).unwrap();
            assert!(
                error.rms < 1.3 * expected + ROUNDED && error.rms > 0.3 * expected - ROUNDED,
                "{name} {scale} {kind}: {error:?}, expected {expected}"
            );
            assert!(error.rms <= error.p99 && error.p99 <= error.max);
            // Chords between measured directions and film radii lose a thousandth of the area.
            assert!(error.wrong_outcome < 2e-3, "{name} {kind}: {error:?}");
        }
    }
}

#[test]
fn the_exact_model_is_exact() {
    let lens = lens("wide_22", 1.0, 1000.0);
    let pupil = ExitPupil::new(&lens, 15.0, RINGS);
    let models = Models::new(&lens, &pupil, 15.0);
    let model = models.model(ModelKind::Exact).unwrap();
    let error = models.error(&model, PIXEL).unwrap();
    // The measurement itself rounds.
    assert!(error.max < 1e-9 && error.wrong_outcome == 0.0);
    let (film, point) = aims(&models, 1)[0];
    assert_eq!(
        model.trace_from_film(film, point),
        lens.trace_from_film(film, point)
    );
}

#[test]
fn paraxial_models_are_right_near_the_axis() {
    for distance in [f64::INFINITY, 800.0] {
        for name in ["telephoto_250", "retrofocus_35"] {
            // A film distance for 800 mm exists for the 35 mm lens only.
            if name == "telephoto_250" && distance.is_finite() {
                continue;
            }
            let lens = lens(name, 1.0, distance);
            let pupil = ExitPupil::new(&lens, 1.0, 4);
            let models = Models::new(&lens, &pupil, 1.0);
            for kind in [ModelKind::Thick, ModelKind::Thin] {
                let model = models.model(kind).unwrap();
                // The error of the paraxial map is of the third order.
                let error = |h: f64| {
                    let (film, point) = ([h, 0.3 * h], [-h, h, pupil.plane_z()]);
                    let exact = lens.trace_from_film(film, point).unwrap();
                    let ray = model.trace_from_film(film, point).unwrap();
                    models.ray_error(&exact, &ray)
                };
                let (large, small) = (error(0.4), error(0.2));
                assert!(large < 1e-4, "{name} {kind}: {large}");
                assert!(
                    (large / small - 8.0).abs() < 0.3,
                    "{name} {kind}: {large} {small}"
                );
            }
        }
    }
}

#[test]
fn lanes_and_derivatives_are_those_of_the_model() {
    let lens = lens("petzval_50", 1.0, f64::INFINITY);
    let pupil = ExitPupil::new(&lens, 12.0, RINGS);
    let models = Models::new(&lens, &pupil, 12.0);
    for kind in [
        ModelKind::Exact,
        ModelKind::Polynomial(9),
        ModelKind::Table(3),
        ModelKind::Thick,
    ] {
        let model = models.model(kind).unwrap();
        let mut compared = 0;
        for aims in aims(&models, 1024).chunks_exact(16) {
            let lane = |f: &dyn Fn(usize) -> f64| Lanes::<16>(std::array::from_fn(|i| f(i) as f32));
            let film = [lane(&|i| aims[i].0[0]), lane(&|i| aims[i].0[1])];
            let point = [lane(&|i| aims[i].1[0]), lane(&|i| aims[i].1[1])];
            let traced = model.trace_lanes(&film, &point);
            let dual = model.trace_lanes_with_derivatives(&film, &point);
            for i in 0..16 {
                let film = film.map(|x| f64::from(x.0[i]));
                let point = [
                    f64::from(point[0].0[i]),
                    f64::from(point[1].0[i]),
                    pupil.plane_z(),
                ];
                let (Some(lane), Ok(ray)) = (traced.get(i), model.trace_from_film(film, point))
                else {
                    continue;
                };
                compared += 1;
                let lane = LensRay {
                    o: lane.o.map(f64::from),
                    d: lane.d.map(f64::from),
                };
                // Tens of roundings to 6e-8 of numbers of about 1: the largest seen is 0.005 pixels.
                assert!(models.ray_error(&ray, &lane) / PIXEL < 0.02, "{kind}");
                derivatives_are_right(&model, &dual, i, film, point);
            }
        }
        // Of 1024 aims in the ellipses around the pupil, two thirds at least.
        assert!(compared > 700, "{kind}: {compared}");
    }
}

fn derivatives_are_right(
    model: &LensModel,
    lanes: &Traced<Dual<Lanes<16>>>,
    i: usize,
    film: [f64; 2],
    point: [f64; 3],
) {
    let (Ok(exact), true) = (
        model.trace_with_derivatives(film, point),
        lanes.passed.at(i),
    ) else {
        return;
    };
    for axis in 0..2 {
        let at = |h: f64| {
            let mut film = film;
            film[axis] += h;
            model.trace_from_film(film, point)
        };
        // Central differences: truncation h², rounding 1e-15/h.
        let h = 1e-4;
        let (Ok(a), Ok(b)) = (at(h), at(-h)) else {
            return;
        };
        for k in 0..3 {
            let difference = (a.d[k] - b.d[k]) / (2.0 * h);
            // Tables have kinks at their film radii, where the two sides differ by 1e-3.
            let tolerance = if let ModelKind::Table(_) = model.kind() {
                3e-3
            } else {
                1e-7
            };
            assert!(
                (exact.d[k].by[axis] - difference).abs() < tolerance,
                "{} {axis} {k}",
                model.kind()
            );
            let lane = f64::from(lanes.ray.d[k].by[axis].0[i]);
            // Single precision: a millionth or so, of coefficients that add up to tens.
            assert!(
                (lane - exact.d[k].by[axis]).abs() < 1e-4,
                "{}",
                model.kind()
            );
        }
    }
}

#[test]
fn the_thin_lens_has_its_pupil_in_the_principal_plane() {
    let lens = lens("telephoto_250", 1.0, f64::INFINITY);
    let pupil = ExitPupil::new(&lens, 20.0, RINGS);
    let models = Models::new(&lens, &pupil, 20.0);
    let model = models.model(ModelKind::Thin).unwrap();
    let c = lens.paraxial().cardinals.unwrap();
    let half = Vec2::splat(0.5);
    // The ray through the middle of the pupil comes from the middle of the front principal plane.
    let aim = model.sample_pupil(&pupil, [15.0, 0.0], half).unwrap();
    assert_eq!(aim.point, [0.0, 0.0, c.rear_principal_plane]);
    let ray = model.trace_from_film([15.0, 0.0], aim.point).unwrap();
    let to_axis = ray.o[2] - ray.d[2] * ray.o[0] / ray.d[0];
    assert!((to_axis - c.front_principal_plane).abs() < 1e-9);
    // Irradiance on the axis is π/4N² cos⁴ of the marginal angle, over the whole disk π/(4N² + 1).
    let n = lens.paraxial().f_number.unwrap();
    let (mut sum, count) = (0.0, 64);
    let film = [Lanes::<16>::splat(0.0); 2];
    for i in 0..count {
        let u = |k: i32| {
            Lanes(std::array::from_fn(|j| {
                (0.5 + (16 * i + j) as f64 / 1.324_717_957_244_746f64.powi(k)).fract() as f32
            }))
        };
        let rays = model.rays(&pupil, &film, &[u(1), u(2)]);
        assert_eq!(rays.traced.passed.count(), 16);
        sum += rays
            .projected_solid_angle
            .0
            .iter()
            .map(|x| f64::from(*x))
            .sum::<f64>();
    }
    let mean = sum / f64::from(16 * count as i32);
    // The weight varies by 2 % over the disk; a thousand well-spread samples of that.
    let expected = std::f64::consts::PI / (4.0 * n * n + 1.0);
    assert!((mean / expected - 1.0).abs() < 1e-4, "{mean} {expected}");
}

#[test]
fn models_weigh_what_the_lens_weighs() {
    // Sampled, traced in lanes and weighted: the same light as the exact lens in f64.
    let lens = lens("dgauss_50", 1.0, f64::INFINITY);
    let pupil = ExitPupil::new(&lens, 21.0, RINGS);
    let models = Models::new(&lens, &pupil, 21.0);
    let light = |kind| {
        let model = models.model(kind).unwrap();
        let mut sum = 0.0;
        for i in 0..256 {
            let s: [_; 16] = std::array::from_fn(|j| models.sample(16 * i + j));
            let film = [
                Lanes(s.map(|s| s.0[0] as f32)),
                Lanes(s.map(|s| s.0[1] as f32)),
            ];
            let u = [Lanes(s.map(|s| s.1.x)), Lanes(s.map(|s| s.1.y))];
            let rays = model.rays(&pupil, &film, &u);
            for j in (0..16).filter(|j| rays.traced.passed.at(*j)) {
                sum += f64::from(rays.projected_solid_angle.0[j]);
            }
        }
        sum
    };
    let exact = light(ModelKind::Exact);
    for kind in [
        ModelKind::Polynomial(5),
        ModelKind::Table(1),
        ModelKind::Thick,
    ] {
        // As many rays are on the wrong side of the rims as `wrong_outcome` says, a thousandth.
        assert!((light(kind) / exact - 1.0).abs() < 2e-3, "{kind}");
    }
}

#[test]
fn any_point_of_the_line_will_do() {
    let lens = lens("dgauss_50", 1.0, f64::INFINITY);
    let pupil = ExitPupil::new(&lens, 20.0, RINGS);
    let models = Models::new(&lens, &pupil, 20.0);
    let model = models.model(ModelKind::Polynomial(5)).unwrap();
    for (film, point) in aims(&models, 100) {
        let k = 0.4;
        let from = [film[0], film[1], lens.film_z()];
        let between = std::array::from_fn(|i| from[i] + k * (point[i] - from[i]));
        let (Ok(a), Ok(b)) = (
            model.trace_from_film(film, point),
            model.trace_from_film(film, between),
        ) else {
            continue;
        };
        for i in 0..3 {
            assert!((a.d[i] - b.d[i]).abs() < 1e-13);
        }
        // Derivatives are by the film point with that very point held fixed: so they differ.
        let dual = model.trace_with_derivatives(film, between).unwrap();
        let h = 1e-5;
        let moved = model.trace_from_film([film[0] + h, film[1]], between);
        let back = model.trace_from_film([film[0] - h, film[1]], between);
        if let (Ok(p), Ok(m)) = (moved, back) {
            assert!(((p.d[0] - m.d[0]) / (2.0 * h) - dual.d[0].by[0]).abs() < 1e-8);
        }
    }
}

#[test]
fn the_model_turns_with_the_film_point() {
    let lens = lens("fisheye_10", 1.0, f64::INFINITY);
    let pupil = ExitPupil::new(&lens, 10.0, RINGS);
    let models = Models::new(&lens, &pupil, 10.0);
    let (sin, cos) = 2f64.sin_cos();
    let turn = |p: [f64; 2]| [cos * p[0] - sin * p[1], sin * p[0] + cos * p[1]];
    for kind in [
        ModelKind::Polynomial(7),
        ModelKind::Table(3),
        ModelKind::Thick,
    ] {
        let model = models.model(kind).unwrap();
        for (film, point) in aims(&models, 200) {
            let [x, y] = turn([point[0], point[1]]);
            let a = model.trace_from_film(film, point);
            let b = model.trace_from_film(turn(film), [x, y, point[2]]);
            let (Ok(a), Ok(b)) = (a, b) else { continue };
            let [l, m] = turn([a.d[0], a.d[1]]);
            // The table's azimuth is off by 1e-12 of the film, the more the nearer to its middle.
            assert!((b.d[0] - l).abs() + (b.d[1] - m).abs() + (b.d[2] - a.d[2]).abs() < 1e-9);
        }
    }
}

#[test]
fn automatic_takes_the_cheapest_that_is_good_enough() {
    for name in ["triplet_50", "zoom_80_200_wide"] {
        let lens = lens(name, 1.0, f64::INFINITY);
        let pupil = ExitPupil::new(&lens, 20.0, RINGS);
        let models = Models::new(&lens, &pupil, 20.0);
        for tolerance in [1e9, 1.0, 0.1, 0.0] {
            let choice = models.choose(tolerance, PIXEL).unwrap();
            let (last, before) = choice.tried.split_last().unwrap();
            assert_eq!(last.0, choice.model.kind());
            assert!(last.2.unwrap().p99 <= tolerance);
            for (kind, cost, error) in before {
                assert!(*cost <= last.1 && error.unwrap().p99 > tolerance, "{kind}");
            }
            assert!(
                choice.reason().starts_with(&last.0.to_string()),
                "{}",
                choice.reason()
            );
        }
        assert_eq!(
            models.choose(1e9, PIXEL).unwrap().model.kind(),
            ModelKind::Thick
        );
        assert_eq!(
            models.choose(0.0, PIXEL).unwrap().model.kind(),
            ModelKind::Exact
        );
    }
}

#[test]
fn what_cannot_be_modelled_is_said() {
    let afocal = Prescription::parse("inf 5 1.5 20\ninf 0 1 20\n").unwrap();
    let lens = Lens::new(&afocal, 50.0).unwrap();
    let pupil = ExitPupil::new(&lens, 5.0, 4);
    let models = Models::new(&lens, &pupil, 5.0);
    let no = |kind| models.model(kind).unwrap_err();
    assert_eq!(
        no(ModelKind::Thick),
        Unavailable::NoFocalLength(ModelKind::Thick)
    );
    assert_eq!(
        no(ModelKind::Thin),
        Unavailable::NoFocalLength(ModelKind::Thin)
    );
    assert_eq!(
        no(ModelKind::Polynomial(4)),
        Unavailable::Degree(ModelKind::Polynomial(4))
    );
    assert_eq!(
        no(ModelKind::Polynomial(13)),
        Unavailable::Degree(ModelKind::Polynomial(13))
    );
    assert_eq!(
        no(ModelKind::Table(8)),
        Unavailable::Degree(ModelKind::Table(8))
    );
    // It can be fitted all the same, and chosen.
    assert!(models.model(ModelKind::Polynomial(5)).is_ok());
    assert!(models.choose(0.1, PIXEL).is_ok());
    // A stop of no size lets no light through.
    let dark = Prescription::parse("50 5 1.5 20\n-50 2 1 20\n0 1 0 0\n-50 0 1 20\n");
    if let Ok(dark) = dark {
        let lens = Lens::new(&dark, 50.0).unwrap();
        let pupil = ExitPupil::new(&lens, 5.0, 4);
        let models = Models::new(&lens, &pupil, 5.0);
        let polynomial = models.model(ModelKind::Polynomial(3));
        assert!(polynomial.is_err() || pupil.region(0.0).is_some());
    }
}

fn wild_lens() -> impl Strategy<Value = Vec<Surface>> {
    let radius = (0.5..9.0f64, -1.0..1.0f64).prop_map(|(e, s)| 10f64.powf(e).copysign(s));
    let surface = (
        prop_oneof![6 => radius, 1 => Just(f64::INFINITY)],
        0.0..20.0f64,
        prop_oneof![4 => 1.0..2.0f64, 1 => Just(1.0), 1 => Just(4.0)],
        prop_oneof![6 => 1.0..50.0f64, 1 => Just(1e-3), 1 => Just(1e3)],
        any::<bool>(),
    )
        .prop_map(|(radius, thickness, index, aperture, is_stop)| Surface {
            radius: if is_stop { f64::INFINITY } else { radius },
            thickness,
            index: if is_stop { 1.0 } else { index },
            aperture,
            is_stop,
            ..Surface::default()
        });
    prop::collection::vec(surface, 1..5)
}

fn wild_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -30.0..30.0f64,
        1 => any::<f64>(),
        1 => prop::sample::select(vec![0.0, 1e-300, 1e300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
    ]
}

proptest! {
    // Every case measures a lens: some tens of milliseconds.
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whatever the lens and the ray: a ray of finite numbers and unit length, or none.
    #[test]
    fn no_lens_and_no_ray_makes_nonsense(
        surfaces in wild_lens(),
        film_distance in prop_oneof![5.0..100.0f64, Just(1e-6), Just(1e6)],
        film_radius in prop_oneof![0.1..30.0f64, Just(1e-9), Just(1e4)],
        wild in prop::collection::vec((prop::array::uniform2(wild_number()), prop::array::uniform3(wild_number())), 32),
    ) {
        let prescription = Prescription { surfaces, ..Prescription::parse("0 0 0 1\n").unwrap() };
        let lens = Lens::new(&prescription, film_distance).unwrap();
        let pupil = ExitPupil::new(&lens, film_radius, 4);
        let models = Models::new(&lens, &pupil, film_radius);
        for kind in [ModelKind::Polynomial(5), ModelKind::Table(2), ModelKind::Thick, ModelKind::Thin] {
            let Ok(model) = models.model(kind) else { continue };
            if let Some(error) = models.error(&model, PIXEL) {
                prop_assert!(!error.p99.is_nan());
            }
            for (film, point) in aims(&models, 32).into_iter().chain(wild.iter().copied()) {
                let Ok(ray) = model.trace_from_film(film, point) else { continue };
                prop_assert!(ray.o.iter().chain(&ray.d).all(|x| x.is_finite()), "{kind} {ray:?}");
                let length: f64 = ray.d.iter().map(|x| x * x).sum();
                prop_assert!((length - 1.0).abs() < 1e-12, "{kind} {ray:?}");
            }
        }
    }
}
