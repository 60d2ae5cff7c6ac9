//! Rays in f64, f32 and f32 lanes, both ways, against 32 digits; and rays on the very edge of something.

use super::cases::{self, prescription};
use super::exact_optics::ExactLens;
use super::neighborhood::{DOUBLE, Found, Neighborhood, SINGLE};
use fstop::optics::lanes::{FilmTracer, Lanes};
use fstop::optics::real::Plain;
use fstop::optics::{Cause, Lens, LensRay, LensTracer, Prescription, Surface};
use proptest::prelude::*;

/// Well-spread numbers from 0 to 1 (Roberts' R sequence in four dimensions, 2018).
pub(super) fn spread(i: usize) -> [f64; 4] {
    std::array::from_fn(|k| {
        (0.5 + (i + 1) as f64 / 1.167_303_978_261_418_7f64.powi(k as i32 + 1)).fract()
    })
}

/// A film point, and a point of the rear vertex plane to aim at: most pass, some just do not.
fn aim(surfaces: &[Surface], film_distance: f64, i: usize) -> ([f64; 2], [f64; 2]) {
    let r = spread(i);
    let rear = surfaces[surfaces.len() - 1].clear_radius();
    let narrowest = surfaces
        .iter()
        .map(Surface::clear_radius)
        .fold(rear, f64::min);
    // A third of them anywhere on the rear element, a third through the size of the narrowest rim, a third near the axis
    // and not oblique.
    let (reach, film) = match i % 3 {
        0 => (1.05 * rear, film_distance.min(rear)),
        1 => (1.05 * narrowest, 0.2 * film_distance.min(rear)),
        _ => (
            0.5 * narrowest.min(film_distance),
            0.01 * film_distance.min(narrowest),
        ),
    };
    let at = |radius: f64, turn: f64| [radius * (6.3 * turn).cos(), radius * (6.3 * turn).sin()];
    (at(film * r[0].sqrt(), r[1]), at(reach * r[2].sqrt(), r[3]))
}

/// One ray in number type `B`, both directions.
fn trace_in<B: Plain>(tracer: &LensTracer<B>, ray: &LensRay<f64>) -> (LensRay<f64>, Found) {
    let rounded = LensRay {
        o: ray.o.map(B::round_from),
        d: ray.d.map(B::round_from),
    };
    let out = if ray.d[2] > 0.0 {
        tracer.to_film(&rounded)
    } else {
        tracer.to_scene(&rounded)
    };
    // What was traced is the rounded ray.
    let traced = LensRay {
        o: rounded.o.map(B::to_f64),
        d: rounded.d.map(B::to_f64),
    };
    let result = out.map(|r| (r.o.map(B::to_f64), r.d.map(B::to_f64)));
    (traced, result.map_err(|b| Some((b.surface, b.cause))))
}

/// Traces `count` rays through the lens in f64, f32 and f32 lanes, and back; the number that passed in f64.
pub(super) fn check_rays(
    name: &str,
    surfaces: &[Surface],
    film_distance: f64,
    count: usize,
) -> Result<usize, String> {
    let exact = ExactLens::new(surfaces);
    let length = exact.length().hi;
    let (double, single) = (
        LensTracer::<f64>::new(surfaces),
        LensTracer::<f32>::new(surfaces),
    );
    let mut passed = 0;
    for i in 0..count {
        let (film, rear) = aim(surfaces, film_distance, i);
        let start = LensRay::through(
            [film[0], film[1], length + film_distance],
            [rear[0], rear[1], length],
        );
        let (ray, found) = trace_in(&double, &start);
        let told = |what: &str, e: String| {
            format!("{name}, {what}, ray {i} from {film:?} to {rear:?}: {e}")
        };
        Neighborhood::new(&exact, ray.o, ray.d, false, DOUBLE)
            .holds(found, length)
            .map_err(|e| told("f64", e))?;
        // In lens coordinates an f32 cannot tell film from lens where they are closer than this; FilmTracer can, below.
        if film_distance > 1e3 * SINGLE * length {
            let (ray, narrow) = trace_in(&single, &start);
            Neighborhood::new(&exact, ray.o, ray.d, false, SINGLE)
                .holds(narrow, length)
                .map_err(|e| told("f32", e))?;
        }
        if let Ok((o, d)) = found {
            passed += 1;
            let back = LensRay {
                o,
                d: d.map(|x| -x),
            };
            let (ray, found) = trace_in(&double, &back);
            Neighborhood::new(&exact, ray.o, ray.d, false, DOUBLE)
                .holds(found, length)
                .map_err(|e| told("f64 to the film", e))?;
            let (ray, narrow) = trace_in(&single, &back);
            Neighborhood::new(&exact, ray.o, ray.d, false, SINGLE)
                .holds(narrow, length)
                .map_err(|e| told("f32 to the film", e))?;
        }
    }
    check_lanes(name, surfaces, film_distance, &exact, count)?;
    Ok(passed)
}

/// Bundles of rays by way of [`FilmTracer`], which aims from film to rear vertex plane.
fn check_lanes(
    name: &str,
    surfaces: &[Surface],
    film_distance: f64,
    exact: &ExactLens,
    count: usize,
) -> Result<(), String> {
    const N: usize = 8;
    let lens = Prescription {
        surfaces: surfaces.to_vec(),
        film_distance,
        positions: None,
        warnings: Vec::new(),
    };
    let lens = Lens::new(&lens, film_distance).map_err(|e| e.to_string())?;
    let tracer: FilmTracer = FilmTracer::new(&lens, lens.length());
    for bundle in 0..count / N {
        let mut film = [Lanes::<N>::splat(0.0); 2];
        let mut rear = film;
        for lane in 0..N {
            let (from, to) = aim(surfaces, film_distance, bundle * N + lane);
            for axis in 0..2 {
                film[axis].0[lane] = from[axis] as f32;
                rear[axis].0[lane] = to[axis] as f32;
            }
        }
        let traced = tracer.trace(&film, &rear);
        for lane in 0..N {
            let found = traced
                .get(lane)
                .map(|r| (r.o.map(f64::from), r.d.map(f64::from)))
                .ok_or(None);
            let o = [
                f64::from(film[0].0[lane]),
                f64::from(film[1].0[lane]),
                film_distance,
            ];
            let d = [
                f64::from(rear[0].0[lane]) - o[0],
                f64::from(rear[1].0[lane]) - o[1],
                -film_distance,
            ];
            let told = |e| format!("{name}, lane {lane} from {o:?} along {d:?}: {e}");
            Neighborhood::new(exact, o, d, true, SINGLE)
                .holds(found, exact.length().hi)
                .map_err(told)?;
        }
    }
    Ok(())
}

#[test]
fn rays_are_right_to_rounding_in_every_extreme_lens() {
    for case in cases::all() {
        let surfaces = case.prescription().surfaces;
        let count = if surfaces.len() > 50 { 24 } else { 96 };
        let passed = check_rays(&case.name, &surfaces, case.film_distance, count)
            .unwrap_or_else(|e| panic!("{e}"));
        assert!(
            passed >= count / 8,
            "{}: only {passed} of {count} rays passed",
            case.name
        );
    }
}

/// The same ray in f64, f32 and a lane; what each says.
fn everywhere(text: &str, o: [f64; 3], d: [f64; 3]) -> [Found; 2] {
    let surfaces = prescription(text).surfaces;
    let ray = LensRay { o, d };
    [
        trace_in(&LensTracer::<f64>::new(&surfaces), &ray).1,
        trace_in(&LensTracer::<f32>::new(&surfaces), &ray).1,
    ]
}

/// Does a lane pass that starts at `film`, 4 mm behind the rear vertex, parallel to the axis?
fn parallel_lane_passes(text: &str, film: [f32; 2]) -> bool {
    let lens = Lens::new(&prescription(text), 4.0).expect("a lens");
    let film = film.map(Lanes::<8>::splat);
    FilmTracer::<f32>::new(&lens, lens.length())
        .trace(&film, &film)
        .get(5)
        .is_some()
}

#[test]
fn the_rim_belongs_to_the_opening() {
    // 3² + 4² is 5² in every number type.
    for text in [
        "0 0 0 10\n",
        "inf 0 1.5 10\n",
        "60 0 1.5 10\n",
        "-60 0 1.5 10\n",
        "60 0 1.5 10 k=-0.5\n",
    ] {
        for (x, y) in [(3.0, 4.0), (-4.0, 3.0), (0.0, 5.0), (5.0, 0.0)] {
            for sign in [1.0, -1.0] {
                let at = |x: f64, y: f64| everywhere(text, [x, y, -9.0 * sign], [0.0, 0.0, sign]);
                for found in at(x, y) {
                    let (o, _) = found.unwrap_or_else(|e| panic!("{text} at {x} {y}: {e:?}"));
                    assert_eq!([o[0], o[1]], [x, y]);
                }
                // One unit in the last place beyond, of a square of which half a unit counts.
                let beyond = |x: f64| {
                    if x == 0.0 {
                        x
                    } else {
                        x * (1.0 + 2.0 * f64::EPSILON)
                    }
                };
                assert_eq!(
                    at(beyond(x), beyond(y))[0],
                    Err(Some((0, Cause::Vignetted))),
                    "{text}"
                );
                let beyond = |x: f64| x * (1.0 + 2.0 * f64::from(f32::EPSILON));
                assert_eq!(
                    at(beyond(x), beyond(y))[1],
                    Err(Some((0, Cause::Vignetted))),
                    "{text}"
                );
            }
            let beyond = |x: f64| (x * (1.0 + 2.0 * f64::from(f32::EPSILON))) as f32;
            assert!(parallel_lane_passes(text, [x as f32, y as f32]), "{text}");
            assert!(
                !parallel_lane_passes(text, [beyond(x), beyond(y)]),
                "{text}"
            );
        }
    }
}

#[test]
fn an_aperture_of_nothing_lets_the_axis_through_and_nothing_else() {
    let mut closed = prescription("50 5 1.5 20\n-50 2 1 20\n0 3 0 8\n60 0 1.5 20\n");
    closed.set_stops(0.0);
    let tracer = LensTracer::<f64>::new(&closed.surfaces);
    let toward_scene = |x: f64| tracer.to_scene(&LensRay::new([x, 0.0, 40.0], [0.0, 0.0, -1.0]));
    assert_eq!(
        toward_scene(0.0).map(|r| (r.o[0], r.d)),
        Ok((0.0, [0.0, 0.0, -1.0]))
    );
    for x in [5e-324, 1e-300, 1e-9, 1.0] {
        // Squares of heights below 1e-162 are 0.
        let expected = if x < 1e-162 {
            None
        } else {
            Some((2, Cause::Vignetted))
        };
        assert_eq!(
            toward_scene(x).err().map(|b| (b.surface, b.cause)),
            expected,
            "{x}"
        );
    }
}

#[test]
fn grazing_rays_miss_or_refract_as_snell_says() {
    // Along the surface, and next to it.
    for d_z in [0.0, -0.0, -5e-324, -1e-300, -1e-40] {
        for found in everywhere("inf 0 1.5 20\n", [0.0, 0.0, 1.0], [1.0, 0.0, d_z]) {
            // Beyond the rim, or, where even that overflows, nowhere.
            let (surface, cause) = found
                .expect_err("no such ray passes")
                .expect("with a cause");
            assert!(
                surface == 0 && cause != Cause::TotalReflection,
                "{d_z} {cause:?}"
            );
        }
    }
    // Inside the rim: from 1e-12 mm behind a plane at a slope of 1e-12. From air into glass: sin of the refracted
    // angle is 1/n, cos √(1 − 1/n²).
    let into_glass = LensRay {
        o: [0.0, 0.0, -1e-12],
        d: [1.0, 0.0, 1e-12],
    };
    let tracer = LensTracer::<f64>::new(&prescription("inf 0 1.5 20\n").surfaces);
    let out = tracer.to_film(&into_glass).expect("it refracts");
    assert!(
        (out.d[0] - 1.0 / 1.5f64).abs() < 1e-12
            && (out.d[2] - (1.0f64 - 1.0 / 2.25).sqrt()).abs() < 1e-12
    );
    // Tangent to a sphere at its equator, and one unit short of it: there the cosine of incidence is √ε, and into glass
    // the ray leaves the equator at the critical angle; out of glass it is totally reflected.
    for (radius, side) in [(8.0, 1.0), (-8.0, -1.0)] {
        let text = format!("{radius} 0 1.5 30\n");
        let at = |x: f64| everywhere(&text, [x, 0.0, -20.0 * side], [0.0, 0.0, side]);
        for beyond in [8.0, 8.0 * (1.0 + f64::EPSILON), 9.0] {
            assert_eq!(at(beyond), [Err(Some((0, Cause::Missed))); 2], "{text}");
        }
        for (found, epsilon) in at(8.0 * (1.0 - f64::from(f32::EPSILON) / 2.0))
            .into_iter()
            .zip([SINGLE, SINGLE])
            .chain(
                at(8.0 * (1.0 - f64::EPSILON / 2.0))
                    .into_iter()
                    .zip([DOUBLE]),
            )
        {
            if side < 0.0 {
                assert_eq!(found, Err(Some((0, Cause::TotalReflection))));
                continue;
            }
            let (o, d) = found.expect("it is refracted");
            // All errors are of the order of that cosine.
            let cosine = (2.0 * epsilon).sqrt();
            assert!(
                (o[0] - 8.0).abs() < 16.0 * epsilon && (o[2] - radius).abs() < 9.0 * cosine,
                "{o:?}"
            );
            let sine = 1.0 / 1.5;
            assert!(
                (d[0] + (1.0f64 - sine * sine).sqrt()).abs() < 2.0 * cosine
                    && (d[2] - sine).abs() < 2.0 * cosine,
                "{d:?}"
            );
        }
    }
}

#[test]
fn total_reflection_begins_where_it_does() {
    for n in [1.0000001f64, 1.5, 2.0, 4.0, 6.0] {
        for radius in ["inf", "1e9", "-1e9", "20", "-20"] {
            let surfaces = prescription(&format!("{radius} 0 {n} 4\n")).surfaces;
            let exact = ExactLens::new(&surfaces);
            let (double, single) = (
                LensTracer::<f64>::new(&surfaces),
                LensTracer::<f32>::new(&surfaces),
            );
            let mut outcomes = [0; 2];
            for units in (-40..=40).chain([-4000, 4000]) {
                for epsilon in [DOUBLE, SINGLE] {
                    // From glass toward the vertex, at the critical angle give or take some units in the last place.
                    let sine = (1.0 / n * (1.0 + f64::from(units) * 2.0 * epsilon)).min(1.0);
                    let cosine = (1.0 - sine * sine).sqrt();
                    let ray = LensRay {
                        o: [-sine, 0.0, cosine],
                        d: [sine, 0.0, -cosine],
                    };
                    let (traced, found) = if epsilon == DOUBLE {
                        trace_in(&double, &ray)
                    } else {
                        trace_in(&single, &ray)
                    };
                    Neighborhood::new(&exact, traced.o, traced.d, false, epsilon)
                        .holds(found, 0.0)
                        .unwrap_or_else(|e| panic!("{n} {radius} {units}: {e}"));
                    if let Ok((_, d)) = found {
                        assert!(d.iter().all(|x| x.is_finite()) && d[2] <= 0.0, "{d:?}");
                    }
                    outcomes[usize::from(found.is_ok())] += 1;
                }
            }
            assert!(
                outcomes.iter().all(|count| *count > 40),
                "{n} {radius} {outcomes:?}"
            );
        }
    }
}

#[test]
fn numbers_that_are_none_make_no_rays_and_harm_no_neighbor() {
    let surfaces = prescription(
        "50 5 1.5 20\n-50 2 1 20\n0 3 0 10\n60 4 1.62 20 k=-0.3 A4=1e-6\n-45 0 1 20\n",
    )
    .surfaces;
    let (double, single) = (
        LensTracer::<f64>::new(&surfaces),
        LensTracer::<f32>::new(&surfaces),
    );
    let good = LensRay {
        o: [0.5, 0.2, 40.0],
        d: [0.0, 0.0, -1.0],
    };
    assert!(double.to_scene(&good).is_ok() && trace_in(&single, &good).1.is_ok());
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for place in 0..6 {
            let mut ray = good;
            if place < 3 {
                ray.o[place] = bad
            } else {
                ray.d[place - 3] = bad
            }
            // An infinite direction along the axis has no length that could be made 1.
            for ray in [ray, LensRay::new(ray.o, ray.d)] {
                assert!(double.to_scene(&ray).is_err(), "{ray:?}");
                assert!(
                    double
                        .to_film(&LensRay {
                            o: ray.o,
                            d: ray.d.map(|x| -x)
                        })
                        .is_err(),
                    "{ray:?}"
                );
                assert!(trace_in(&single, &ray).1.is_err(), "{ray:?}");
            }
        }
    }
    let lens = Lens::new(
        &Prescription {
            surfaces,
            film_distance: 0.0,
            positions: None,
            warnings: Vec::new(),
        },
        26.0,
    )
    .expect("a lens");
    for bad in [f64::NAN, f64::INFINITY, 1e300, -1e300] {
        assert!(lens.trace_from_film([bad, 0.0], [0.0, 0.0, 7.0]).is_err());
        assert!(lens.trace_from_film([0.0, 0.0], [0.0, bad, 7.0]).is_err());
        // A point infinitely far in front is no point to aim at.
        assert!(bad.abs() < 1e301 || lens.trace_from_film([0.0, 0.0], [0.0, 0.0, bad]).is_err());
    }
    let tracer = FilmTracer::<f32>::new(&lens, lens.length());
    let plain = tracer.trace(&[Lanes::<8>::splat(0.5); 2], &[Lanes::splat(0.1); 2]);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
        for place in 0..4 {
            let mut numbers = [
                Lanes::<8>::splat(0.5),
                Lanes::splat(0.5),
                Lanes::splat(0.1),
                Lanes::splat(0.1),
            ];
            numbers[place].0[3] = bad;
            let [x, y, u, v] = numbers;
            let traced = tracer.trace(&[x, y], &[u, v]);
            assert_eq!(traced.get(3), None, "{bad} {place}");
            for lane in [0, 1, 2, 4, 5, 6, 7] {
                assert_eq!(traced.get(lane), plain.get(lane));
            }
        }
    }
}

/// A length from 10^low to 10^high, evenly over the orders of magnitude.
fn length(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low..high).prop_map(|e| 10f64.powf(e))
}

/// Any row between the extremes.
fn row() -> impl Strategy<Value = Surface> {
    let radius = prop_oneof![
        1 => Just(f64::INFINITY),
        5 => (length(-1.0, 9.0), any::<bool>()).prop_map(|(r, convex)| if convex { r } else { -r }),
    ];
    let thickness = prop_oneof![1 => Just(0.0), 4 => length(-3.0, 2.0), 1 => length(2.0, 5.0)];
    let index =
        prop_oneof![2 => Just(1.0), 4 => 1.0..4.0f64, 1 => (0.0..1e-6f64).prop_map(|x| 1.0 + x)];
    (
        radius,
        thickness,
        index,
        length(-3.0, 3.0),
        prop::bool::weighted(0.2),
    )
        .prop_map(|(radius, thickness, index, aperture, is_stop)| Surface {
            radius: if is_stop { f64::INFINITY } else { radius },
            thickness,
            index,
            aperture,
            is_stop,
            ..Surface::default()
        })
}

/// Any lens between the extremes; the last row's thickness is the film's affair.
pub(super) fn lens(rows: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Surface>> {
    prop::collection::vec(row(), rows).prop_map(|mut rows| {
        if let Some(last) = rows.last_mut() {
            last.thickness = 0.0;
        }
        rows
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(80))]

    /// Between the extremes rays are as right as at them.
    #[test]
    fn rays_are_right_to_rounding_in_every_lens(
        surfaces in lens(1..10),
        film_distance in length(-6.0, 6.0),
    ) {
        if let Err(e) = check_rays("", &surfaces, film_distance, 24) {
            return Err(TestCaseError::fail(e));
        }
    }
}

#[test]
fn a_ray_nearly_parallel_to_the_vertex_plane_is_as_right_as_a_point_there() {
    // The first surface turns it until d.z is 8e-7: it meets the vertex plane 50 radii away.
    let grazed = Surface {
        radius: 0.297_519_357_774_339_74,
        index: 1.000_000_473_371_666,
        aperture: 1.0,
        ..Surface::default()
    };
    check_rays("grazed", &[grazed], 1.267_741_914_285_226_3e-5, 24)
        .unwrap_or_else(|e| panic!("{e}"));
}
