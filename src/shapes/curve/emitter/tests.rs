//! Chosen directions against closed forms, and against meeting the strip by chance.

use super::*;
use crate::math::sampling::uniform_sphere;
use crate::math::transform::Transform;
use crate::shapes::curve::CurveSpec;
use crate::shapes::quadric::tests::points;

fn reference(p: Vec3) -> ReferencePoint {
    ReferencePoint {
        p,
        p_error: Vec3::ZERO,
        n: Vec3::ZERO,
        time: 0.0,
        reception: Default::default(),
    }
}

fn emitter(
    kind: CurveKind,
    control: [DVec3; 4],
    width: [f64; 2],
    place: &Transform,
) -> CurveEmitter {
    let spec = CurveSpec {
        kind,
        segments: vec![Bezier(control)],
        normals: vec![DVec3::Z, DVec3::new(1.0, 0.0, 1.0).normalize()],
        width,
        split_depth: 3,
    };
    let mut emitters = CurveEmitter::of_curves(&spec.place(place, false)).collect::<Vec<_>>();
    assert_eq!(emitters.len(), 1);
    emitters.remove(0)
}

/// From (−1, 0, 0) to (1, 0, 0).
fn straight() -> [DVec3; 4] {
    [-3.0, -1.0, 1.0, 3.0].map(|x| DVec3::new(x / 3.0, 0.0, 0.0))
}

fn bent() -> [DVec3; 4] {
    [
        DVec3::new(-0.2, -1.0, 0.1),
        DVec3::new(1.9, -0.3, -0.4),
        DVec3::new(-1.8, 0.4, 0.5),
        DVec3::new(0.1, 1.0, 0.0),
    ]
}

/// The mean of 1/pdf over what meets the strip: its solid angle, with the standard error, and the
/// share of samples that meet it.
fn solid_angle(emitter: &CurveEmitter, from: &ReferencePoint, n: usize) -> (f64, f64, f64) {
    let values: Vec<f64> = points(n)
        .map(|u| emitter.sample(from, u.as_vec2()))
        .map(|s| s.map_or(0.0, |s| 1.0 / f64::from(s.pdf)))
        .collect();
    let (mean, error) = mean(&values);
    let met = values.iter().filter(|v| **v > 0.0).count();
    (mean, error, met as f64 / n as f64)
}

fn mean(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
    (mean, (variance / n).sqrt())
}

/// A ray meets a straight strip of even width if it passes the axis within half the width, and has
/// its nearest point between the ends. At azimuth ψ around the axis, from the distance h, that is at
/// x = h cos ψ cot θ along the axis: cos θ = x / √(x² + h² cos² ψ).
fn straight_solid_angle(p: Vec3, width: f64) -> f64 {
    let h = f64::from(p.y).hypot(f64::from(p.z));
    let cosine = |x: f64, azimuth: f64| x / x.hypot(h * azimuth.cos());
    let reach = (0.5 * width / h).asin();
    let n = 2000;
    let sum: f64 = (0..n)
        .map(|i| reach * (2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0))
        .map(|a| cosine(1.0 - f64::from(p.x), a) - cosine(-1.0 - f64::from(p.x), a))
        .sum();
    sum * 2.0 * reach / f64::from(n)
}

#[test]
fn the_solid_angle_of_a_straight_strip_is_the_closed_form() {
    for kind in [CurveKind::Flat, CurveKind::Cylinder] {
        for (p, least) in [
            (Vec3::new(0.2, 1.0, 0.5), 0.9),
            (Vec3::new(0.9, 0.1, 0.05), 0.9),
            (Vec3::new(40.0, 3.0, 80.0), 0.9),
            // Along the strip.
            (Vec3::new(9.0, 0.2, 0.1), 0.4),
        ] {
            for width in [0.001, 0.1] {
                let emitter = emitter(kind, straight(), [width; 2], &Transform::IDENTITY);
                let (found, error, met) = solid_angle(&emitter, &reference(p), 20_000);
                let expected = straight_solid_angle(p, width);
                // Four standard errors of pseudo-random points; these are more even.
                let allowed = 4.0 * error + 1e-5 * expected;
                assert!(
                    (found - expected).abs() < allowed,
                    "{p} {width}: {found} ± {error} but {expected}"
                );
                // Nearly all of the box is strip, but where its ends are seen.
                assert!(width > 0.01 || met > least, "{p} {width}: {met}");
            }
        }
    }
}

fn places() -> [Transform; 3] {
    let turn = Transform::rotate(50.0, DVec3::new(1.0, -1.0, 2.0));
    [
        Transform::translate(DVec3::new(0.1, 0.0, 0.2)) * turn,
        turn * Transform::scale(DVec3::new(0.5, 1.4, -0.8)) * turn,
        turn * Transform::scale(DVec3::splat(1.3)),
    ]
}

fn emitters() -> Vec<CurveEmitter> {
    let kinds = [CurveKind::Flat, CurveKind::Cylinder, CurveKind::Ribbon];
    let mut all = Vec::new();
    for (i, kind) in kinds.into_iter().enumerate() {
        for (j, place) in places().iter().enumerate() {
            let control = if (i + j) % 2 == 0 { bent() } else { straight() };
            all.push(emitter(kind, control, [0.3, 0.05], place));
        }
    }
    all
}

/// Far, near, and within the box around the curve.
const PLACES: [Vec3; 3] = [
    Vec3::new(2.5, -1.0, 1.5),
    Vec3::new(0.3, 0.6, 0.7),
    Vec3::new(0.05, 0.1, 0.02),
];

/// A receiver as curves are: new rays start well beside it.
fn thick(p: Vec3) -> ReferencePoint {
    ReferencePoint {
        p_error: Vec3::splat(0.1),
        n: Vec3::new(0.6, 0.0, 0.8),
        ..reference(p)
    }
}

#[test]
fn densities_integrate_to_one() {
    for (i, emitter) in emitters().iter().enumerate() {
        for from in PLACES.map(reference).into_iter().chain(PLACES.map(thick)) {
            let densities: Vec<f64> = points(10_000)
                .map(|u| uniform_sphere(u.as_vec2()).normalize())
                .map(|wi| 4.0 * PI * f64::from(emitter.density(&from, wi)))
                .collect();
            let (sum, error) = mean(&densities);
            assert!(
                (sum - 1.0).abs() < 4.0 * error + 1e-5,
                "{i} {}: {sum} ± {error}",
                from.p
            );
        }
    }
}

/// What rays meet by chance can be chosen, and choosing finds as much of it: the solid angle, and the
/// light's first moments, by either way.
#[test]
fn chosen_directions_find_what_rays_meet_by_chance() {
    for (i, emitter) in emitters().iter().enumerate() {
        for from in PLACES.map(reference).into_iter().chain(PLACES.map(thick)) {
            let n = 10_000;
            let mut by_chance = vec![[0.0; 4]; n];
            for (u, value) in points(n).zip(&mut by_chance) {
                let wi = uniform_sphere(u.as_vec2()).normalize();
                let o = offset_ray_origin(from.p, from.p_error, from.n, wi);
                let o = o.as_dvec3() - emitter.anchor;
                if emitter.meet(o, wi.as_dvec3()).is_some() {
                    assert!(emitter.density(&from, wi) > 0.0, "{i} {} {wi}", from.p);
                    *value =
                        [1.0, wi.x.into(), wi.y.into(), wi.z.into()].map(|v: f64| 4.0 * PI * v);
                }
            }
            let mut chosen = vec![[0.0; 4]; n];
            for (u, value) in points(n).zip(&mut chosen) {
                if let Some(s) = emitter.sample(&from, u.as_vec2()) {
                    let w = 1.0 / f64::from(s.pdf);
                    *value = [1.0, s.wi.x.into(), s.wi.y.into(), s.wi.z.into()].map(|v: f64| w * v);
                    // The point is where the chosen ray is.
                    let o = offset_ray_origin(from.p, from.p_error, from.n, s.wi);
                    assert!((s.p - o).cross(s.wi).length() < 1e-6);
                }
            }
            for moment in 0..4 {
                let of = |values: &[[f64; 4]]| {
                    mean(&values.iter().map(|v| v[moment]).collect::<Vec<_>>())
                };
                let ((a, a_error), (b, b_error)) = (of(&by_chance), of(&chosen));
                assert!(
                    (a - b).abs() < 4.0 * a_error.hypot(b_error) + 1e-5,
                    "{i} {} moment {moment}: {a} ± {a_error} but {b} ± {b_error}",
                    from.p
                );
            }
        }
    }
}

#[test]
fn degenerate_curves_are_never_chosen_and_never_panic() {
    let point = [DVec3::ONE; 4];
    let nan = [DVec3::NAN; 4];
    for (control, width) in [(point, 0.1), (straight(), 0.0), (nan, 0.1), (point, 0.0)] {
        let emitter = emitter(CurveKind::Flat, control, [width; 2], &Transform::IDENTITY);
        for p in [Vec3::ONE, Vec3::ZERO, Vec3::new(3.0, 1.0, 1.0)] {
            for u in points(50) {
                let sample = emitter.sample(&reference(p), u.as_vec2());
                assert!(sample.is_none_or(|s| s.pdf.is_finite()));
            }
            let density = emitter.density(&reference(p), Vec3::X);
            assert!(density.is_nan() || density >= 0.0);
        }
    }
}
