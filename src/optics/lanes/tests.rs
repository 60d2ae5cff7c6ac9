//! Bundles against rays one at a time.

use super::*;
use crate::math::Vec2;
use crate::math::instruction_set::{InstructionSet, Instructions, Kernel};
use crate::optics::models::LensModel;
use crate::optics::models::tests::{FEW, few_rays};
use crate::optics::pupil::{RINGS, projected_solid_angle};
use crate::optics::real::Dual;
use crate::optics::trace::LensTracer;
use crate::optics::{ExitPupil, Lens, LensRay, Prescription, Surface};
use proptest::prelude::*;

const LENSES: [&str; 4] = ["dgauss_50", "canon_uw_14", "petzval_50", "zoom_80_200_wide"];

fn lens(name: &str) -> Lens {
    let path = format!("{}/tests/golden/{name}.dat", env!("CARGO_MANIFEST_DIR"));
    let prescription = Prescription::read(path.as_ref()).unwrap();
    let film_distance = Lens::focused(&prescription, f64::INFINITY).unwrap();
    Lens::new(&prescription, film_distance).unwrap()
}

/// Well-spread numbers in the unit cube of four dimensions (Roberts 2018).
fn spread(i: usize) -> [f64; 4] {
    std::array::from_fn(|k| {
        (0.5 + i as f64 / 1.167_303_978_261_418_7f64.powi(k as i32 + 1)).fract()
    })
}

/// Film points within 20 mm, and points of a disk that holds most of the pupil.
fn aims<const N: usize>(lens: &Lens, bundle: usize) -> ([Lanes<N>; 2], [Lanes<N>; 2]) {
    let reach = lens.rear().clear_radius();
    let lane = |k: usize, scale: f64| {
        Lanes(std::array::from_fn(|i| {
            ((2.0 * spread(bundle * N + i)[k] - 1.0) * scale) as f32
        }))
    };
    (
        [lane(0, 14.0), lane(1, 14.0)],
        [lane(2, reach), lane(3, reach)],
    )
}

fn bits(ray: &LensRay<f32>) -> [u32; 6] {
    let [a, b, c] = ray.o.map(f32::to_bits);
    let [d, e, f] = ray.d.map(f32::to_bits);
    [a, b, c, d, e, f]
}

struct Bundle<'a, const N: usize> {
    tracer: &'a FilmTracer,
    film: &'a [Lanes<N>; 2],
    pupil: &'a [Lanes<N>; 2],
}

impl<const N: usize> Kernel for Bundle<'_, N> {
    type Output = Traced<Lanes<N>>;
    #[inline(always)]
    fn run(self, _: impl Instructions) -> Traced<Lanes<N>> {
        self.tracer.trace(self.film, self.pupil)
    }
}

/// Bundles of N with every set of instructions, and one at a time: the same bits.
fn same_bits<const N: usize>() {
    for name in LENSES {
        let lens = lens(name);
        let tracer = FilmTracer::<f32>::new(&lens, lens.length());
        let mut passed = 0;
        for bundle in 0..2048 / N {
            let (film, pupil) = aims::<N>(&lens, bundle);
            let alone = |i: usize| {
                let t = tracer.trace(&film.map(|x| x.0[i]), &pupil.map(|x| x.0[i]));
                t.passed.then_some(t.ray)
            };
            for instructions in InstructionSet::available() {
                let traced = instructions.run(Bundle {
                    tracer: &tracer,
                    film: &film,
                    pupil: &pupil,
                });
                for i in 0..N {
                    let (one, lane) = (alone(i), traced.get(i));
                    assert_eq!(
                        one.as_ref().map(bits),
                        lane.as_ref().map(bits),
                        "{name} {} {i}: {one:?} {lane:?}",
                        instructions.name()
                    );
                }
                passed += traced.passed.count();
            }
        }
        // Some hundredths of the aims at least go through, or the test would say nothing.
        assert!(passed > 30, "{name}: {passed}");
    }
}

#[test]
fn a_lane_has_the_bits_of_a_ray_alone() {
    // As many as cameras make.
    same_bits::<8>();
    same_bits::<32>();
}

#[test]
fn outcomes_are_those_of_f64_away_from_the_rims() {
    for name in LENSES {
        let lens = lens(name);
        let tracer = FilmTracer::<f32>::new(&lens, lens.length());
        // The same lens with rims one part in 1e5 wider and narrower: single precision puts a ray within
        // 1e-4 mm of where it belongs (tests/golden/README.md), and no rim is smaller than 5 mm here.
        let scaled = |scale: f64| {
            let mut surfaces = lens.surfaces().to_vec();
            surfaces.iter_mut().for_each(|s| s.aperture *= scale);
            LensTracer::<f64>::new(&surfaces)
        };
        let (narrow, wide) = (scaled(1.0 - 5e-5), scaled(1.0 + 5e-5));
        let mut passed = 0;
        for bundle in 0..8192 / FEW {
            let (film, pupil) = aims::<FEW>(&lens, bundle);
            let traced = tracer.trace(&film, &pupil);
            for i in 0..FEW {
                let film = film.map(|x| f64::from(x.0[i]));
                let pupil = [
                    f64::from(pupil[0].0[i]),
                    f64::from(pupil[1].0[i]),
                    lens.length(),
                ];
                let ray = lens.film_ray(film, pupil);
                let (inside, outside) = (narrow.to_scene(&ray), wide.to_scene(&ray).is_err());
                match traced.get(i) {
                    Some(lane) => {
                        assert!(!outside, "{name} {film:?} {pupil:?}");
                        let Ok(truth) = inside else { continue };
                        passed += 1;
                        for k in 0..3 {
                            // The golden tolerances of single precision.
                            assert!((f64::from(lane.o[k]) - truth.o[k]).abs() < 1e-4);
                            assert!((f64::from(lane.d[k]) - truth.d[k]).abs() < 5e-6);
                        }
                    }
                    None => assert!(inside.is_err(), "{name} {film:?} {pupil:?}"),
                }
            }
        }
        assert!(passed > 100);
    }
}

#[test]
fn derivatives_in_lanes_are_those_of_f64() {
    let lens = lens("dgauss_50");
    let tracer = FilmTracer::<f32>::new(&lens, lens.length());
    for bundle in 0..1024 / FEW {
        let (film, pupil) = aims::<FEW>(&lens, bundle);
        let parameters = [0, 1].map(|axis| Dual::parameter(film[axis], axis));
        let traced = tracer.trace(&parameters, &pupil.map(Dual::fixed));
        for i in 0..FEW {
            if !traced.passed.at(i) {
                continue;
            }
            let from = [
                f64::from(film[0].0[i]),
                f64::from(film[1].0[i]),
                lens.film_z(),
            ];
            let to = [
                f64::from(pupil[0].0[i]),
                f64::from(pupil[1].0[i]),
                lens.length(),
            ];
            let Ok(truth) = lens.tracer().to_scene_with_derivatives(from, to) else {
                continue;
            };
            for k in 0..3 {
                for axis in 0..2 {
                    let error = |lane: f32, truth: f64| {
                        (f64::from(lane) - truth).abs() / (1.0 + truth.abs())
                    };
                    // A hundred times f32's rounding: a chain of eleven surfaces, each with a square root whose
                    // derivative grows toward grazing incidence.
                    assert!(error(traced.ray.o[k].by[axis].0[i], truth.o[k].by[axis]) < 1e-5);
                    assert!(error(traced.ray.d[k].by[axis].0[i], truth.d[k].by[axis]) < 1e-5);
                }
            }
        }
    }
}

#[test]
fn weighted_rays_are_those_made_one_at_a_time() {
    for name in ["dgauss_50", "petzval_50"] {
        let lens = lens(name);
        let pupil = ExitPupil::new(&lens, 20.0, RINGS);
        let model = LensModel::exact(&lens, pupil.plane_z());
        let (mut passed, mut other_triangle) = (0, 0);
        for bundle in 0..2048 / FEW {
            let s: [[f64; 4]; FEW] = std::array::from_fn(|i| spread(FEW * bundle + i));
            let lane = |k: usize, a: f64, b: f64| Lanes(s.map(|s| (a * s[k] + b) as f32));
            let film = [lane(0, 20.0, -10.0), lane(1, 20.0, -10.0)];
            let u = [lane(2, 1.0, 0.0), lane(3, 1.0, 0.0)];
            let rays = few_rays(&model, &pupil, &film, &u);
            for i in 0..FEW {
                let at = film.map(|x| f64::from(x.0[i]));
                let Some(aim) = pupil.sample(at, Vec2::new(u[0].0[i], u[1].0[i])) else {
                    assert!(!rays.traced.passed.at(i));
                    continue;
                };
                let (Ok(truth), Some(ray)) =
                    (lens.trace_from_film(at, aim.point), rays.traced.get(i))
                else {
                    continue;
                };
                passed += 1;
                let weight = projected_solid_angle([at[0], at[1], lens.film_z()], &aim);
                // The area is a difference of products that are sixteen times as large, each rounded by 6e-8. Between
                // two triangles or rings rounding may choose the other one, whose area differs.
                let off = (f64::from(rays.projected_solid_angle.0[i]) / weight - 1.0).abs();
                other_triangle += u32::from(off > 1e-5);
                assert!(off < 0.5, "{name}: {off}");
                for k in 0..3 {
                    // The aim itself is rounded: 1e-6 of a pupil some centimeters wide, seen
                    // from some centimeters away, on top of the tracer's own 1e-4 mm and 5e-6.
                    assert!((f64::from(ray.o[k]) - truth.o[k]).abs() < 2e-4);
                    assert!((f64::from(ray.d[k]) - truth.d[k]).abs() < 1e-5);
                }
            }
        }
        // Nearly all pass that meet the image circle.
        assert!(passed > 1500, "{name}: {passed}");
        // 1e-6 of half a turn is 1e-4 of a triangle.
        assert!(other_triangle <= 5, "{name}: {other_triangle}");
    }
}

#[test]
fn every_lens_is_right_to_a_fiftieth_of_a_pixel() {
    for name in [
        "canon_uw_14",
        "course_dgauss_100",
        "dgauss_50",
        "fisheye_10",
        "nikon_50_f1.2",
        "petzval_50",
        "retrofocus_35",
        "telephoto_250",
        "tessar_100",
        "triplet_50",
        "wide_22",
        "zoom_80_200_wide",
    ] {
        let lens = lens(name);
        let focal_length = lens.paraxial().cardinals.unwrap().focal_length;
        // The plane of the exit pupil, if it is not too near the film to aim at.
        let exit = lens.paraxial().exit_pupil.unwrap();
        let tracer = FilmTracer::<f32>::new(&lens, exit.z);
        let (mut compared, mut worst) = (0, 0.0f64);
        for bundle in 0..8192 / FEW {
            let (film, _) = aims::<FEW>(&lens, bundle);
            let lane = |k: usize| {
                Lanes(std::array::from_fn(|i| {
                    ((2.0 * spread(bundle * FEW + i)[k] - 1.0) * 0.6 * exit.diameter) as f32
                }))
            };
            let point = [lane(2), lane(3)];
            let traced = tracer.trace(&film, &point);
            for i in 0..FEW {
                let film = film.map(|x| f64::from(x.0[i]));
                let point = [f64::from(point[0].0[i]), f64::from(point[1].0[i]), exit.z];
                let (Some(lane), Ok(truth)) = (traced.get(i), lens.trace_from_film(film, point))
                else {
                    continue;
                };
                compared += 1;
                let angle2: f64 = (0..3)
                    .map(|k| (f64::from(lane.d[k]) - truth.d[k]).powi(2))
                    .sum();
                worst = worst.max(focal_length * angle2.sqrt() / 0.006);
            }
        }
        // docs/generated/lens-precision.md has the figures: 0.010 at worst.
        assert!(
            compared > 500 && worst < 0.02,
            "{name}: {worst} of {compared}"
        );
    }
}

#[test]
fn the_middle_of_the_square_is_the_middle_of_the_pupil() {
    let lens = lens("dgauss_50");
    let pupil = ExitPupil::new(&lens, 20.0, RINGS);
    let model = LensModel::exact(&lens, pupil.plane_z());
    let (zero, half) = (Lanes::<FEW>::splat(0.0), Lanes::<FEW>::splat(0.5));
    let ray = few_rays(&model, &pupil, &[zero; 2], &[half; 2])
        .traced
        .get(3)
        .unwrap();
    // The ellipse is centered to 1e-4 of its size, about 10 mm; the direction is that over the focal length.
    assert!(ray.o[0].abs() < 1e-2 && ray.d[0].abs() < 1e-4 && ray.d[2] < -0.999_999);
    assert!(ray.o.iter().chain(&ray.d).all(|x| x.is_finite()));
}

fn wild() -> impl Strategy<Value = f32> {
    prop_oneof![
        3 => -50.0..50.0f32,
        1 => any::<f32>(),
        1 => prop::sample::select(vec![0.0, -0.0, 1e-38, f32::MAX, f32::NAN, f32::INFINITY, f32::NEG_INFINITY]),
    ]
}

fn wild_surface() -> impl Strategy<Value = Surface> {
    let radius = (-1.0..9.0f64, -1.0..1.0f64).prop_map(|(e, s)| 10f64.powf(e).copysign(s));
    (
        prop_oneof![4 => radius, 1 => Just(f64::INFINITY)],
        prop_oneof![4 => 0.0..50.0f64, 1 => Just(1e5)],
        prop_oneof![4 => 1.0..4.0f64, 1 => Just(1.0), 1 => Just(1.000_000_1)],
        prop_oneof![4 => 0.001..1000.0f64, 1 => Just(0.0)],
    )
        .prop_map(|(radius, thickness, index, aperture)| Surface {
            radius,
            thickness,
            index,
            aperture,
            ..Surface::default()
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Whatever the lens, the film and the rays: a lane that passes is finite, of unit length, and has the
    /// bits of the ray alone; the others do not disturb it.
    #[test]
    fn no_input_makes_nonsense(
        surfaces in prop::collection::vec(wild_surface(), 1..12),
        film_distance in prop_oneof![1e-6..100.0f64, Just(1e-6), Just(1e6)],
        plane in prop_oneof![-100.0..100.0f64, Just(-1e9)],
        film in prop::array::uniform2(prop::array::uniform8(wild())),
        pupil in prop::array::uniform2(prop::array::uniform8(wild())),
    ) {
        let prescription = Prescription { surfaces, ..Prescription::parse("0 0 0 1\n").unwrap() };
        let Ok(lens) = Lens::new(&prescription, film_distance) else { return Ok(()) };
        let tracer = FilmTracer::<f32>::new(&lens, plane);
        let (film, pupil) = (film.map(Lanes), pupil.map(Lanes));
        let traced = tracer.trace(&film, &pupil);
        for i in 0..8 {
            let alone = tracer.trace(&film.map(|x| x.0[i]), &pupil.map(|x| x.0[i]));
            let alone = alone.passed.then_some(alone.ray);
            let lane = traced.get(i);
            prop_assert_eq!(lane.as_ref().map(bits), alone.as_ref().map(bits));
            let Some(ray) = lane else { continue };
            prop_assert!(ray.o.iter().chain(&ray.d).all(|x| x.is_finite()));
            let length: f32 = ray.d.iter().map(|x| x * x).sum();
            // Four roundings.
            prop_assert!((length - 1.0).abs() < 5e-7);
        }
    }
}
