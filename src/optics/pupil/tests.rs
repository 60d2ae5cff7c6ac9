//! Laws of the exit pupil's regions, on lenses small enough to reason about and on wild ones.

use super::*;
use crate::math::hash::{mix2, unit_float};
use crate::optics::{LensRay, Prescription};
use proptest::prelude::*;

const DGAUSS: &str = "29.475 3.76 1.67 25.2\n84.83 0.12 1 25.2\n19.275 4.025 1.67 23\n\
    40.77 3.275 1.699 23\n12.75 5.705 1 18\n0 4.5 0 17.1\n-14.495 1.18 1.603 17\n\
    40.77 6.065 1.658 20\n-20.385 0.19 1 20\n437.065 3.22 1.717 20\n-39.73 0 1 20\n";

fn lens(text: &str, stop: f64, film_distance: f64) -> Lens {
    let mut p = Prescription::parse(text).unwrap();
    p.set_stops(stop);
    Lens::new(&p, film_distance).unwrap()
}

/// Well-spread points of the unit square: the R2 sequence (Roberts 2018).
fn spread(count: u32) -> impl Iterator<Item = Vec2> {
    (0..count).map(|i| {
        let r = |a: f64| (0.5 + f64::from(i) * a).fract() as f32;
        Vec2::new(r(0.754_877_666_246_692_8), r(0.569_840_290_998_053_3))
    })
}

/// Mean projected solid angle of samples of `region`, and the fraction that passes.
fn mean(lens: &Lens, film: [f64; 2], samples: impl Fn(Vec2) -> Option<PupilSample>) -> (f64, f64) {
    let count = 1 << 15;
    let (mut sum, mut passed) = (0.0, 0.0);
    for sample in spread(count).filter_map(samples) {
        if lens.trace_from_film(film, sample.point).is_ok() {
            sum += projected_solid_angle([film[0], film[1], lens.film_z()], &sample);
            passed += 1.0;
        }
    }
    (sum / f64::from(count), passed / f64::from(count))
}

/// Samples everything the rear element lets through.
fn everything(lens: &Lens) -> ExitPupil {
    let mut all = ExitPupil::new(lens, 1e-3, 1);
    all.survey.reach = -1.0;
    all
}

#[test]
fn tiny_stops_are_found_and_their_light_goes_with_their_area() {
    for film in [[0.0, 0.0], [6.0, 5.0], [14.0, -12.0]] {
        let light = |stop: f64| {
            let lens = lens(DGAUSS, stop, 36.77);
            let pupil = ExitPupil::new(&lens, 22.0, RINGS);
            let (mean, passed) = mean(&lens, film, |u| pupil.sample(film, u));
            // Of a stop of 0.1 um the region curves within a ring.
            assert!(passed > 0.2, "{stop} {film:?}: {passed}");
            mean / (stop * stop)
        };
        let reference = light(0.1);
        for stop in [1e-2, 1e-3, 1e-4] {
            // Aberration over a stop of 0.1 mm changes less than the sampling does.
            assert!(
                (light(stop) / reference - 1.0).abs() < 2e-3,
                "{stop} {film:?}"
            );
        }
    }
}

#[test]
fn lenses_without_a_stop_lose_nothing() {
    let text: String = DGAUSS
        .lines()
        .filter(|l| !l.starts_with("0 "))
        .map(|l| format!("{l}\n"))
        .collect();
    let lens = lens(&text, 1.0, 36.77);
    let (pupil, all) = (ExitPupil::new(&lens, 22.0, RINGS), everything(&lens));
    for film in [[0.0, 0.0], [0.0, 9.0], [-12.0, 9.0], [15.0, 13.0]] {
        let (found, passed) = mean(&lens, film, |u| pupil.sample(film, u));
        let (truth, _) = mean(&lens, film, |u| all.sample(film, u));
        // Both estimates have some 1e-3, the wasteful one more.
        assert!(
            (found / truth - 1.0).abs() < 5e-3,
            "{film:?} {found} {truth}"
        );
        assert!(passed > 0.6, "{film:?} {passed}");
    }
}

#[test]
fn awkward_exit_pupils_are_sampled_all_the_same() {
    for (name, text, film_distance) in [
        // The stop in the front focal plane: telecentric, exit pupil at infinity.
        ("telecentric", "0 100 0 5\n50 0 1.5 40\ninf 0 1 40\n", 120.0),
        // A stop imaged onto the film, and one imaged behind it.
        ("at the film", "0 200 0 5\n50 0 1.5 40\ninf 0 1 40\n", 200.0),
        (
            "behind the film",
            "0 200 0 5\n50 0 1.5 40\ninf 0 1 40\n",
            100.0,
        ),
        // Only a stop.
        ("pinhole", "0 0 0 0.4\n", 30.0),
    ] {
        let lens = lens(text, 5.0, film_distance);
        let (pupil, all) = (ExitPupil::new(&lens, 6.0, RINGS), everything(&lens));
        for film in [[0.0, 0.0], [1.0, 1.0], [0.0, -4.0]] {
            let (found, _) = mean(&lens, film, |u| pupil.sample(film, u));
            let (truth, _) = mean(&lens, film, |u| all.sample(film, u));
            let close = (found - truth).abs() <= 2e-2 * truth;
            assert!(close, "{name} {film:?}: {found} {truth}");
        }
    }
}

/// Samples lie evenly but for what the triangles' areas differ between the ends of a ring, and the weights carry
/// that: their mean is the area of the region.
#[test]
fn samples_are_even_and_weights_make_them_exact() {
    // Where light ends within the film (here at 29 mm or so) the pupil shrinks to nothing in the outermost ring,
    // whose triangles do not shrink alike.
    for (stop, reach, limit) in [(17.1, 22.0, 0.01), (17.1, 60.0, 0.05), (4.0, 60.0, 0.05)] {
        let lens = lens(DGAUSS, stop, 36.77);
        let pupil = ExitPupil::new(&lens, reach, RINGS);
        let (mut deviation, mut rays, mut worst) = (0.0, 0.0, 0.0f64);
        for i in 0..400 {
            // Evenly over the film, to where light ends.
            let radius = (reach * reach * f64::from(i) / 400.0).sqrt();
            let Some(region) = pupil.region(radius) else {
                continue;
            };
            let areas = spread(1 << 10).filter_map(|u| pupil.sample([radius, 0.0], u));
            let areas: Vec<f64> = areas.map(|s| s.area / region.area).collect();
            let mean = areas.iter().sum::<f64>() / areas.len() as f64;
            // The mean of 1024 well-spread samples.
            assert!((mean - 1.0).abs() < 2e-3, "{stop} at {radius}: {mean}");
            deviation += areas.iter().map(|a| (a - 1.0).powi(2)).sum::<f64>();
            rays += areas.len() as f64;
            worst = areas.iter().map(|a| (a - 1.0).abs()).fold(worst, f64::max);
        }
        let rms = (deviation / rays).sqrt();
        println!("{stop} {reach}: {rms} {worst}");
        assert!(rms < limit, "{stop} {reach}: {rms} {worst}");
    }
}

#[test]
fn outside_the_image_circle_there_is_nothing() {
    // A stop far in front of a small lens shades everything beyond some film radius.
    let lens = lens("0 60 0 4\n30 3 1.5 8\n-30 0 1 8\n", 4.0, 31.0);
    let pupil = ExitPupil::new(&lens, 60.0, RINGS);
    assert!(pupil.region(0.0).is_some() && pupil.region(59.0).is_none());
    assert_eq!(pupil.sample([0.0, 59.0], Vec2::splat(0.5)), None);
}

/// Of lenses nobody would make, some have pupils in several parts, with holes, or such as appear and
/// vanish with the film radius: what the survey overlooks there is next to nothing.
#[test]
fn of_wild_lenses_next_to_nothing_is_lost() {
    let (mut passed, mut lost) = (0u32, 0u32);
    for case in 0..100u64 {
        let random = |k: u64| f64::from(unit_float(mix2(case, k)));
        let row = |i: u64| {
            let c = 6.0 * random(10 * i + 1) - 3.0;
            let radius = if c.abs() < 0.3 { 0.0 } else { 20.0 / c };
            let index = 1.0 + random(10 * i + 3);
            let aperture = 0.01 + 30.0 * random(10 * i + 4);
            format!(
                "{radius} {} {index} {aperture}\n",
                10.0 * random(10 * i + 2)
            )
        };
        let text: String = (0..1 + (8.0 * random(0)) as u64).map(row).collect();
        let prescription = Prescription::parse(&text).unwrap();
        let lens = Lens::new(&prescription, 1.0 + 80.0 * random(7)).unwrap();
        if lens.rear().sag(lens.rear().clear_radius()) >= lens.film_distance() {
            // The film lies inside the rear element; the camera warns of it.
            continue;
        }
        let pupil = ExitPupil::new(&lens, 20.0, RINGS);
        for i in 0..20_000u32 {
            let r = |a: f64| (0.5 + f64::from(i) * a).fract();
            let radius = 20.0 * r(0.819_172_513_396_164_4);
            let height = pupil.survey.rear.radius() * r(0.671_043_606_703_789_2).sqrt();
            let (sin, cos) = (std::f64::consts::PI * r(0.549_700_477_901_970_3)).sin_cos();
            let view = pupil.survey.view(radius);
            let p = view.on_plane(pupil.survey.rear.point(height * cos, height * sin));
            if view.passes(p) {
                passed += 1;
                lost += u32::from(
                    !pupil
                        .ring(radius)
                        .is_some_and(|r| r.holds_absolute(radius, p)),
                );
            }
        }
    }
    // Measured over 400 such lenses: 3e-5, all of it from lenses that let almost nothing through.
    assert!(passed > 100_000, "{passed}");
    assert!(
        f64::from(lost) < 1e-4 * f64::from(passed),
        "{lost} of {passed}"
    );
}

/// Projected solid angle of all that passes, by directions evenly spread over it: independent of
/// everything the pupil's survey does.
fn by_directions(lens: &Lens, film: [f64; 2]) -> f64 {
    let count = 1 << 18;
    let passes = |u: &Vec2| {
        let p = Spot::square_root(u.as_dvec2().to_array());
        let (sin, cos) = (std::f64::consts::PI * p.half).sin_cos();
        // The unit disk of direction cosines is the hemisphere's projection.
        let d = [p.radius * cos, p.radius * p.side * sin];
        let z = -(1.0 - p.radius * p.radius).max(0.0).sqrt();
        let ray = LensRay {
            o: [film[0], film[1], lens.film_z()],
            d: [d[0], d[1], z],
        };
        lens.tracer().to_scene(&ray).is_ok()
    };
    let passed = spread(count).filter(passes).count();
    std::f64::consts::PI * passed as f64 / f64::from(count)
}

#[test]
fn extreme_lenses_are_sampled_right() {
    let window = "inf 0.01 1.5 30\ninf 0.01 1 30\n".repeat(100);
    for (name, text, film_distance, heights) in [
        // As near behind the double Gauss as the film can be; its radius there is 10 mm.
        ("film at the rear vertex", DGAUSS, 1e-6, [0.0, 2.0, 4.0]),
        (
            "two stops",
            "50 5 1.5 30\n-50 2 1 30\n0 6 0 9\n0 0 0 8\n",
            30.0,
            [0.0, 5.0, 12.0],
        ),
        ("200 surfaces", window.as_str(), 20.0, [0.0, 10.0, 20.0]),
        (
            "strong index",
            "30 5 4 20\n40 0 1 20\n",
            8.0,
            [0.0, 5.0, 10.0],
        ),
        ("one surface", "60 0 1.5 20\n", 40.0, [0.0, 8.0, 15.0]),
        (
            "surfaces that cross",
            "20 1 1.5 25\n-20 0 1 25\n",
            15.0,
            [0.0, 5.0, 9.0],
        ),
    ] {
        let prescription = Prescription::parse(text).unwrap();
        let lens = Lens::new(&prescription, film_distance).unwrap();
        let pupil = ExitPupil::new(&lens, 20.0, RINGS);
        for h in heights {
            let film = [0.6 * h, -0.8 * h];
            let truth = by_directions(&lens, film);
            let (found, _) = mean(&lens, film, |u| pupil.sample(film, u));
            // 2^18 well-spread directions, of which at least one in 160 passes, leave half a percent
            // at most; the pupil's samples less.
            assert!(truth > 0.02, "{name} at {h}: {truth}");
            assert!(
                (found / truth - 1.0).abs() < 0.01,
                "{name} at {h}: {found} {truth}"
            );
        }
    }
}

#[test]
fn lenses_that_let_nothing_through_are_dark() {
    let mut closed = Prescription::parse(DGAUSS).unwrap();
    closed.surfaces[5].aperture = 0.0;
    let lens = Lens::new(&closed, 36.77).unwrap();
    let pupil = ExitPupil::new(&lens, 22.0, RINGS);
    for h in [0.0, 3.0, 25.0] {
        let sample = pupil.sample([h, 0.0], Vec2::new(0.3, 0.4));
        // Beyond the survey's reach the rear element is sampled, and nothing passes.
        let passes = |s: PupilSample| lens.trace_from_film([h, 0.0], s.point).is_ok();
        assert!(!sample.is_some_and(passes), "{h}: {sample:?}");
    }
    for nonsense in [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e300] {
        let pupil = ExitPupil::new(&lens, nonsense, 0);
        let sample = pupil.sample([nonsense, 1.0], Vec2::splat(0.5));
        assert!(sample.is_none_or(|s| s.area.is_finite()), "{sample:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Whatever the lens, making its regions ends, and sampling them gives finite points.
    #[test]
    fn wild_lenses_have_finite_regions(
        rows in prop::collection::vec((-3.0..3.0f64, 0.0..20.0f64, 1.0..2.0f64, 0.01..40.0f64), 1..8),
        film_distance in 0.01..200.0f64,
    ) {
        let text: String = rows
            .iter()
            .map(|(c, t, n, a)| format!("{} {t} {n} {a}\n", if c.abs() < 0.3 { 0.0 } else { 20.0 / c }))
            .collect();
        let lens = Lens::new(&Prescription::parse(&text).unwrap(), film_distance).unwrap();
        let pupil = ExitPupil::new(&lens, 20.0, 8);
        for (i, u) in spread(64).enumerate() {
            let film = [i as f64 * 0.4, -0.1 * i as f64];
            if let Some(s) = pupil.sample(film, u) {
                prop_assert!(s.point.iter().all(|x| x.is_finite()) && s.area.is_finite() && s.area > 0.0);
                prop_assert!(pupil.projected_solid_angle(film, &s).is_finite());
            }
        }
    }
}
