//! The analysis of lenses against golden data computed by others (tests/golden/README.md).

use crate::common::golden_lenses::{self, LENSES, number};
use fstop::optics::analysis::{
    Beam, ChiefFinder, ObjectPlane, ReferenceScale, Seidel, Spot, illumination,
};
use fstop::optics::best_focus;
use fstop::optics::pupil::RINGS;
use fstop::optics::{ExitPupil, Lens};
use serde_json::Value;

/// A lens at its golden film distance, and its golden data.
fn read(name: &str) -> (Lens, Value) {
    let (p, data) = golden_lenses::read(name);
    let film_distance = number(&data, "/film_z") - p.length();
    (Lens::new(&p, film_distance).unwrap(), data)
}

#[test]
fn chief_rays_and_distortion() {
    for name in LENSES {
        let (lens, data) = read(name);
        let chief = ChiefFinder::new(&lens);
        let corner = number(&data, "/image_radius");
        let scale = ReferenceScale::new(&chief, ObjectPlane::INFINITY, corner);
        for field in data["fields"].as_array().unwrap().iter().skip(1) {
            let height = number(field, "/h");
            let ray = chief.find(height).unwrap();
            let expected = number(field, "/chief_object_angle_deg");
            let angle = ray.field_angle().to_degrees();
            assert!(
                (angle - expected).abs() < 1e-8,
                "{name} {height}: {angle} {expected}"
            );
            // The tangent of the angle says nothing beyond a right angle.
            let Some(expected) = field["distortion_tan_pct"].as_f64() else {
                assert!(angle > 90.0, "{name} {height}: {angle}");
                continue;
            };
            let found = 100.0 * (height / scale.ideal_height(&ray) - 1.0);
            // The golden film is rounded to 1e-6 mm, its reference is the exact focal length; ours the chief ray at
            // 1e-4 of the corner, whose distortion is 1e-8 of the corner's.
            assert!(
                (found - expected).abs() < 1e-5 + 1e-7 * expected.abs(),
                "{name} {height}: {found} {expected}"
            );
        }
    }
}

#[test]
fn the_largest_chief_ray() {
    for name in LENSES {
        let (lens, data) = read(name);
        let [height, angle] = ChiefFinder::new(&lens).limit(440.0).unwrap();
        let expected = number(&data, "/chief_limit/film_height");
        assert!(
            (height - expected).abs() < 1e-6,
            "{name}: {height} {expected}"
        );
        // Grazing rays turn quickly with the height.
        let expected = number(&data, "/chief_limit/object_angle_deg");
        assert!(
            (angle - expected).abs() < 1e-5,
            "{name}: {angle} {expected}"
        );
    }
}

#[test]
fn spots_and_illumination() {
    for name in LENSES {
        let (lens, data) = read(name);
        let chief = ChiefFinder::new(&lens);
        let pupil = ExitPupil::new(&lens, 1.1 * number(&data, "/image_radius"), RINGS);
        let samples = 1 << 14;
        let omega = |h| illumination::projected_solid_angle(&lens, &pupil, h, samples);
        let axis = omega(0.0);
        for field in data["fields"].as_array().unwrap() {
            let height = number(field, "/h");
            let expected = number(field, "/rel_illum/1");
            // 16384 well-spread points: some 1e-3.
            let found = omega(height) / axis;
            assert!(
                (found / expected - 1.0).abs() < 3e-3,
                "{name} {height}: illumination {found} {expected}"
            );
            if !golden_lenses::has_spots(&data) {
                continue;
            }
            let expected = number(field, "/spot_rms_um/1") * 1e-3;
            let beam = Beam::new(
                &lens,
                &pupil,
                &chief.find(height).unwrap(),
                ObjectPlane::INFINITY,
            )
            .unwrap();
            let found = Spot::trace(&lens, &beam, 128).rms_radius();
            // The edge of a beam 128 cells wide is known to 128^(-3/2) of its area, and the farthest rays are
            // there.
            assert!(
                (found / expected - 1.0).abs() < 1e-2,
                "{name} {height}: spot {found} {expected}"
            );
        }
    }
}

/// Autofocus finds the film of the smallest spot: the golden shift from the paraxial focus.
#[test]
fn best_focus_at_infinity() {
    for name in LENSES {
        let (p, data) = golden_lenses::read(name);
        if !golden_lenses::has_spots(&data) {
            continue;
        }
        let best = best_focus::film_distance(&p, f64::INFINITY).unwrap();
        let expected = number(&data, "/fields/0/best_focus_shift");
        let found = p.length() + best - number(&data, "/film_z");
        // The golden value is that of a quadrature good to 1e-4, on a film rounded to 1e-6 mm.
        assert!(
            (found - expected).abs() < 3e-4 * expected.abs() + 2e-6,
            "{name}: {found} {expected}"
        );
    }
}

#[test]
fn seidel_sums_are_those_of_another_program() {
    let data: Value = serde_json::from_str(include_str!("../golden/seidel.json")).unwrap();
    for (name, golden) in data.as_object().unwrap() {
        let (p, _) = golden_lenses::read(name);
        let film_distance = Lens::focused(&p, f64::INFINITY).unwrap();
        let lens = Lens::new(&p, film_distance).unwrap();
        let height = number(golden, "/image_height");
        let sum = Seidel::new(&lens, ObjectPlane::INFINITY, height)
            .unwrap()
            .sum;
        for (i, found) in sum.values()[..5].iter().enumerate() {
            let expected = -number(golden, &format!("/seidel/{i}"));
            // Both add some ten terms ten times as large, in double precision.
            assert!(
                (found - expected).abs() < 1e-12,
                "{name} {i}: {found} {expected}"
            );
        }
    }
}
