//! Exact tracing: known answers, derivatives, and any lens and ray.

use super::surface::Surface;
use super::trace::*;
use crate::optics::Prescription;
use proptest::prelude::*;

fn tracer(text: &str) -> LensTracer<f64> {
    LensTracer::new(&Prescription::parse(text).unwrap().surfaces)
}

fn blocked<T: std::fmt::Debug>(result: Result<T, Blocked>) -> (usize, Cause) {
    let b = result.unwrap_err();
    (b.surface, b.cause)
}

#[test]
fn a_plane_obeys_snell_and_reflects_totally() {
    let t = tracer("inf 0 1.5 100\n");
    // From glass at sin θ = 0.5 into air at sin θ' = 0.75.
    let from = |sin: f64| LensRay::new([0.0, 0.0, 10.0], [sin, 0.0, -(1.0 - sin * sin).sqrt()]);
    let out = t.to_scene(&from(0.5)).unwrap();
    assert!((out.d[0] - 0.75).abs() < 1e-15);
    assert!((out.o[0] - 10.0 * 0.5 / 0.75f64.sqrt()).abs() < 1e-14);
    assert_eq!(
        blocked(t.to_scene(&from(0.67))),
        (0, Cause::TotalReflection)
    );
}

#[test]
fn a_sphere_images_its_aplanatic_points_perfectly() {
    // Rays toward the point at distance n·R behind the center of a sphere of glass meet at
    // R/n from the center, at every angle (Born and Wolf §4.2.3).
    let (n, r) = (1.5f64, 20.0f64);
    let t = tracer("20 0 1.5 39.9\n");
    for h in [1.0, 5.0, 10.0, 15.0] {
        let aim = [0.0, 0.0, r + n * r];
        let ray = LensRay::through([h, 0.0, -1.0], aim);
        let out = t.to_film(&ray).unwrap();
        let z = out.o[2] - out.d[2] * out.o[0] / out.d[0];
        assert!((z - (r + r / n)).abs() < 1e-12, "{h} {z}");
    }
}

#[test]
fn nothing_cancels_from_a_millimeter_to_a_million_kilometers() {
    // The sag of the meeting point at height h is exactly h²/2R to 1e-16 for large R.
    for exponent in 3..13 {
        let r = 10f64.powi(exponent);
        let t = LensTracer::<f64>::new(&[Surface {
            radius: r,
            index: 1.5,
            aperture: 20.0,
            ..Surface::default()
        }]);
        let out = t
            .to_scene(&LensRay::new([3.0, 4.0, 50.0], [0.0, 0.0, -1.0]))
            .unwrap();
        let sag = 25.0 / (r * (1.0 + (1.0 - 25.0 / (r * r)).sqrt()));
        assert!(
            (out.o[2] / sag - 1.0).abs() < 1e-14,
            "{r}: {} {sag}",
            out.o[2]
        );
    }
}

#[test]
fn the_reason_for_blocking_is_told() {
    let t = tracer("10 4 1.5 30\n0 2 0 5\n-10 0 1 30\n");
    let down = |x: f64| LensRay::new([x, 0.0, 100.0], [0.0, 0.0, -1.0]);
    // Passes the sphere of radius 10; meets it near its equator; meets the stop's rim.
    assert_eq!(blocked(t.to_scene(&down(12.0))), (2, Cause::Missed));
    assert_eq!(blocked(t.to_scene(&down(3.5))), (1, Cause::Vignetted));
    assert!(t.to_scene(&down(0.5)).is_ok());
    // Runs the wrong way, sideways, or is no ray at all.
    for d in [
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 0.0],
        [0.0; 3],
        [f64::NAN, 0.0, -1.0],
        [f64::INFINITY; 3],
    ] {
        assert_eq!(
            blocked(t.to_scene(&LensRay::new([0.0, 0.0, 100.0], d))),
            (2, Cause::Missed)
        );
    }
    for o in [f64::NAN, f64::INFINITY, 1e300] {
        assert!(
            t.to_scene(&LensRay {
                o: [o, 0.0, 100.0],
                d: [0.0, 0.0, -1.0]
            })
            .is_err()
        );
    }
}

#[test]
fn derivatives_are_those_of_the_ray() {
    let t = tracer(
        "29.475 3.76 1.67 25.2\n84.83 0.12 1 25.2\n0 4.5 0 17.1\n-39.73 0 1.7 20\n60 0 1 20\n",
    );
    let (film, pupil) = ([4.0, -3.0, 45.0], [1.0, 2.0, 5.0]);
    let exact = t.to_scene_with_derivatives(film, pupil).unwrap();
    for axis in 0..2 {
        let at = |h: f64| {
            let mut from = film;
            from[axis] += h;
            t.to_scene(&LensRay::through(from, pupil)).unwrap()
        };
        // Central differences: h² of truncation and 1e-15/h of rounding.
        let h = 1e-5;
        let (a, b) = (at(h), at(-h));
        for i in 0..3 {
            assert!(((a.o[i] - b.o[i]) / (2.0 * h) - exact.o[i].by[axis]).abs() < 1e-8);
            assert!(((a.d[i] - b.d[i]) / (2.0 * h) - exact.d[i].by[axis]).abs() < 1e-9);
        }
    }
}

fn wild_surface() -> impl Strategy<Value = Surface> {
    let radius = prop_oneof![
        Just(f64::INFINITY),
        (-1.0..9.0f64, any::<bool>()).prop_map(|(e, s)| if s {
            10f64.powf(e)
        } else {
            -(10f64.powf(e))
        }),
    ];
    (
        radius,
        -5.0..50.0f64,
        1.0..2.5f64,
        0.001..100.0f64,
        any::<bool>(),
    )
        .prop_map(|(radius, thickness, index, aperture, is_stop)| Surface {
            radius,
            thickness: thickness.max(0.0),
            index,
            abbe: None,
            aperture,
            is_stop,
            ..Surface::default()
        })
}

fn wild_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -50.0..50.0f64,
        1 => any::<f64>(),
        1 => prop::sample::select(vec![0.0, -0.0, 1e-308, 1e308, f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Whatever the lens and the ray, what passes is finite, inside every aperture, and has unit length.
    #[test]
    fn tracing_never_panics_nor_returns_nonsense(
        surfaces in prop::collection::vec(wild_surface(), 1..12),
        o in prop::array::uniform3(wild_number()),
        d in prop::array::uniform3(wild_number()),
    ) {
        let t = LensTracer::<f64>::new(&surfaces);
        for (ray, first) in [(LensRay::new(o, d), true), (LensRay { o, d }, false)] {
            for (out, end) in [(t.to_scene(&ray), &surfaces[0]), (t.to_film(&ray), &surfaces[surfaces.len() - 1])] {
                let Ok(out) = out else { continue };
                prop_assert!(out.o.iter().chain(&out.d).all(|x| x.is_finite()));
                let length: f64 = out.d.iter().map(|x| x * x).sum();
                prop_assert!((length - 1.0).abs() < 1e-14);
                // A direction that was not of unit length to begin with proves nothing more.
                prop_assert!(!first || out.o[0].hypot(out.o[1]) <= 0.5 * end.aperture * (1.0 + 1e-12));
            }
        }
        let t = LensTracer::<f32>::new(&surfaces);
        let ray = LensRay::new(o.map(|x| x as f32), d.map(|x| x as f32));
        if let Ok(out) = t.to_scene(&ray) {
            prop_assert!(out.o.iter().chain(&out.d).all(|x| x.is_finite()));
        }
    }

    /// A ray that passes comes back the way it came.
    #[test]
    fn paths_are_reversible(
        surfaces in prop::collection::vec(wild_surface(), 1..6),
        x in -5.0..5.0f64,
        l in -0.2..0.2f64,
    ) {
        let t = LensTracer::<f64>::new(&surfaces);
        let behind = surfaces.iter().map(|s| s.thickness).sum::<f64>();
        let start = LensRay::new([x, 0.3, behind + 1.0], [l, 0.1, -1.0]);
        let Ok(out) = t.to_scene(&start) else { return Ok(()) };
        let back = LensRay { o: out.o, d: out.d.map(|x| -x) };
        // Rounding may put a ray that grazed a rim or the critical angle on the other side of it.
        let Ok(back) = t.to_film(&back) else { return Ok(()) };
        // Ill-conditioned where it grazed a surface: 1e-12 holds away from there.
        for i in 0..3 {
            prop_assert!((back.d[i] + start.d[i]).abs() < 1e-6, "{:?} {:?}", back, start);
        }
    }
}
