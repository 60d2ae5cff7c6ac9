//! Models against exact rays.

use super::*;
use crate::optics::Prescription;
use crate::optics::pupil::RINGS;
use crate::optics::surface::Surface;
use proptest::prelude::*;

/// mm: 6000 pixels over 36 mm.
const PIXEL: f64 = 0.006;

/// Rays side by side where it does not matter how many: few, which the compiler is done with sooner.
pub(in crate::optics) const FEW: usize = 4;

const KINDS: [ModelKind; 3] = [ModelKind::Exact, ModelKind::Thick, ModelKind::Thin];

fn lens(name: &str, scale: f64, distance: f64) -> Lens {
    let path = format!("{}/tests/golden/{name}.dat", env!("CARGO_MANIFEST_DIR"));
    let mut prescription = Prescription::read(path.as_ref()).unwrap();
    for s in prescription.surfaces.iter_mut().filter(|s| s.is_stop) {
        s.aperture *= scale;
    }
    let film_distance = Lens::focused(&prescription, distance).unwrap();
    Lens::new(&prescription, film_distance).unwrap()
}

/// Film points evenly over the image circle, and pupil samples (Roberts' R sequence in four dimensions, 2018).
fn sample(film_radius: f64, i: usize) -> ([f64; 2], Vec2) {
    let r = |k: i32| (0.5 + (i + 1) as f64 / 1.167_303_978_261_418_7f64.powi(k)).fract();
    let radius = film_radius * r(1).sqrt();
    let (sin, cos) = (std::f64::consts::TAU * r(2)).sin_cos();
    (
        [radius * cos, radius * sin],
        Vec2::new(r(3) as f32, r(4) as f32),
    )
}

/// Rays of a few samples, compiled once for all tests.
#[inline(never)]
pub(in crate::optics) fn few_rays(
    model: &LensModel,
    pupil: &ExitPupil,
    film: &[Lanes<FEW>; 2],
    u: &[Lanes<FEW>; 2],
) -> WeightedRays<Lanes<FEW>, FEW> {
    model.rays(pupil, film, u)
}

/// Film points and points of the exit pupil.
fn aims(pupil: &ExitPupil, film_radius: f64, count: usize) -> Vec<([f64; 2], [f64; 3])> {
    (0..count)
        .filter_map(|i| {
            let (film, u) = sample(film_radius, i);
            Some((film, pupil.sample(film, u)?.point))
        })
        .collect()
}

/// How far apart two rays are in the image of a distant object, mm.
fn ray_error(lens: &Lens, a: &LensRay<f64>, b: &LensRay<f64>) -> f64 {
    let square: f64 = (0..3).map(|i| (a.d[i] - b.d[i]).powi(2)).sum();
    lens.paraxial().cardinals.unwrap().focal_length * square.sqrt()
}

#[test]
fn the_error_of_thick_is_that_an_independent_program_measured() {
    // rms in pixels at full stop and a quarter of it, infinity focus, over the image circle.
    for (name, scale, expected) in [
        ("dgauss_50", 1.0, 28.0),
        ("dgauss_50", 0.25, 25.0),
        ("telephoto_250", 1.0, 12.0),
    ] {
        let lens = lens(name, scale, f64::INFINITY);
        let pupil = ExitPupil::new(&lens, 21.6, RINGS);
        let model = LensModel::new(ModelKind::Thick, &lens, &pupil).unwrap();
        let (mut sum, mut compared, mut passed, mut wrong) = (0.0, 0, 0, 0);
        for (film, point) in aims(&pupil, 21.6, 8192) {
            let (exact, ray) = (
                lens.trace_from_film(film, point),
                model.trace_from_film(film, point),
            );
            passed += u32::from(exact.is_ok());
            wrong += u32::from(exact.is_ok() != ray.is_ok());
            if let (Ok(exact), Ok(ray)) = (exact, ray) {
                sum += (ray_error(&lens, &exact, &ray) / PIXEL).powi(2);
                compared += 1;
            }
        }
        let rms = (sum / f64::from(compared)).sqrt();
        // Other rays, and two digits.
        assert!((rms / expected - 1.0).abs() < 0.1, "{name} {scale}: {rms}");
        assert!(wrong == 0 && passed > 4096, "{name}: {wrong} of {passed}");
    }
}

#[test]
fn the_exact_model_is_exact() {
    let lens = lens("wide_22", 1.0, 1000.0);
    let pupil = ExitPupil::new(&lens, 15.0, RINGS);
    let model = LensModel::new(ModelKind::Exact, &lens, &pupil).unwrap();
    for (film, point) in aims(&pupil, 15.0, 100) {
        assert_eq!(
            model.trace_from_film(film, point),
            lens.trace_from_film(film, point)
        );
    }
}

#[test]
fn paraxial_models_are_right_near_the_axis() {
    for name in ["telephoto_250", "retrofocus_35"] {
        let lens = lens(name, 1.0, f64::INFINITY);
        let pupil = ExitPupil::new(&lens, 1.0, 4);
        for kind in [ModelKind::Thick, ModelKind::Thin] {
            let model = LensModel::new(kind, &lens, &pupil).unwrap();
            // The error of the paraxial map is of the third order.
            let error = |h: f64| {
                let (film, point) = ([h, 0.3 * h], [-h, h, pupil.plane_z()]);
                let exact = lens.trace_from_film(film, point).unwrap();
                ray_error(&lens, &exact, &model.trace_from_film(film, point).unwrap())
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

#[test]
fn lanes_and_derivatives_are_those_of_the_model() {
    let lens = lens("petzval_50", 1.0, f64::INFINITY);
    let pupil = ExitPupil::new(&lens, 12.0, RINGS);
    for kind in [ModelKind::Exact, ModelKind::Thick] {
        let model = LensModel::new(kind, &lens, &pupil).unwrap();
        let mut compared = 0;
        for aims in aims(&pupil, 12.0, 1024).chunks_exact(FEW) {
            let lane =
                |f: &dyn Fn(usize) -> f64| Lanes::<FEW>(std::array::from_fn(|i| f(i) as f32));
            let film = [lane(&|i| aims[i].0[0]), lane(&|i| aims[i].0[1])];
            let point = [lane(&|i| aims[i].1[0]), lane(&|i| aims[i].1[1])];
            let traced = model.single.trace(&film, &point);
            for i in 0..FEW {
                let film = film.map(|x| f64::from(x.0[i]));
                let [x, y] = point.each_ref().map(|x| f64::from(x.0[i]));
                let point = [x, y, pupil.plane_z()];
                let (Some(lane), Ok(ray)) = (traced.get(i), model.trace_from_film(film, point))
                else {
                    continue;
                };
                compared += 1;
                let lane = LensRay {
                    o: lane.o.map(f64::from),
                    d: lane.d.map(f64::from),
                };
                // Tens of roundings to 6e-8 of numbers of about 1.
                assert!(ray_error(&lens, &ray, &lane) / PIXEL < 0.02, "{kind}");
                derivatives_are_right(&model, film, point);
            }
        }
        // Of 1024 aims in the polygons around the pupil, two thirds at least.
        assert!(compared > 700, "{kind}: {compared}");
    }
}

/// In lanes: `crate::cameras::realistic`'s tests.
fn derivatives_are_right(model: &LensModel, film: [f64; 2], point: [f64; 3]) {
    let Ok(exact) = model.trace_with_derivatives(film, point) else {
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
            let by = exact.d[k].by[axis];
            assert!(
                (by - difference).abs() < 1e-7,
                "{} {axis} {k}",
                model.kind()
            );
        }
    }
}

#[test]
fn the_thin_lens_has_its_pupil_in_the_principal_plane() {
    let lens = lens("telephoto_250", 1.0, f64::INFINITY);
    let pupil = ExitPupil::new(&lens, 20.0, RINGS);
    let model = LensModel::new(ModelKind::Thin, &lens, &pupil).unwrap();
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
    let (mut sum, count) = (0.0, 1024 / FEW);
    let film = [Lanes::<FEW>::splat(0.0); 2];
    for i in 0..count {
        let u = |k: i32| {
            Lanes(std::array::from_fn(|j| {
                (0.5 + (FEW * i + j) as f64 / 1.324_717_957_244_746f64.powi(k)).fract() as f32
            }))
        };
        let rays = few_rays(&model, &pupil, &film, &[u(1), u(2)]);
        assert_eq!(rays.traced.passed.count(), FEW as u32);
        let light = rays.projected_solid_angle.0;
        sum += light.iter().map(|x| f64::from(*x)).sum::<f64>();
    }
    let mean = sum / (FEW * count) as f64;
    // The weight varies by 2 % over the disk; a thousand well-spread samples of that.
    let expected = std::f64::consts::PI / (4.0 * n * n + 1.0);
    assert!((mean / expected - 1.0).abs() < 1e-4, "{mean} {expected}");
}

#[test]
fn thick_weighs_what_the_lens_weighs() {
    // Sampled, traced in lanes and weighted: the same light as the exact lens.
    let lens = lens("dgauss_50", 1.0, f64::INFINITY);
    let pupil = ExitPupil::new(&lens, 21.0, RINGS);
    let light = |kind| {
        let model = LensModel::new(kind, &lens, &pupil).unwrap();
        let mut sum = 0.0;
        for i in 0..4096 / FEW {
            let s: [_; FEW] = std::array::from_fn(|j| sample(21.0, FEW * i + j));
            let film = [
                Lanes(s.map(|s| s.0[0] as f32)),
                Lanes(s.map(|s| s.0[1] as f32)),
            ];
            let u = [Lanes(s.map(|s| s.1.x)), Lanes(s.map(|s| s.1.y))];
            let rays = few_rays(&model, &pupil, &film, &u);
            for j in (0..FEW).filter(|j| rays.traced.passed.at(*j)) {
                sum += f64::from(rays.projected_solid_angle.0[j]);
            }
        }
        sum
    };
    assert_eq!(light(ModelKind::Thick), light(ModelKind::Exact));
}

#[test]
fn any_point_of_the_line_will_do() {
    let lens = lens("dgauss_50", 1.0, f64::INFINITY);
    let pupil = ExitPupil::new(&lens, 20.0, RINGS);
    let model = LensModel::new(ModelKind::Thick, &lens, &pupil).unwrap();
    for (film, point) in aims(&pupil, 20.0, 100) {
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
fn a_lens_without_focal_length_has_no_planes() {
    let afocal = Prescription::parse("inf 5 1.5 20\ninf 0 1 20\n").unwrap();
    let lens = Lens::new(&afocal, 50.0).unwrap();
    let pupil = ExitPupil::new(&lens, 5.0, 4);
    for kind in [ModelKind::Thick, ModelKind::Thin] {
        let error = LensModel::new(kind, &lens, &pupil).unwrap_err();
        assert_eq!(error, NoFocalLength(kind));
    }
    assert!(LensModel::new(ModelKind::Exact, &lens, &pupil).is_ok());
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
        for kind in KINDS {
            let Ok(model) = LensModel::new(kind, &lens, &pupil) else { continue };
            for (film, point) in aims(&pupil, film_radius, 32).into_iter().chain(wild.iter().copied()) {
                let Ok(ray) = model.trace_from_film(film, point) else { continue };
                prop_assert!(ray.o.iter().chain(&ray.d).all(|x| x.is_finite()), "{kind} {ray:?}");
                let length: f64 = ray.d.iter().map(|x| x * x).sum();
                prop_assert!((length - 1.0).abs() < 1e-12, "{kind} {ray:?}");
            }
        }
    }
}
