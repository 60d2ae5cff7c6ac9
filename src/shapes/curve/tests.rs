//! Curves against closed forms and against points along them.

use super::*;
use crate::params::testing::{Outcome, read};
use crate::shapes::local::Local;
use crate::shapes::quadric::tests::points;
use std::f64::consts::PI;

fn reading(params: &str) -> Outcome<Option<CurveSpec>> {
    read("curve", params, CurveSpec::from_params)
}

fn spec(kind: CurveKind, bezier: [DVec3; 4], width: [f64; 2]) -> CurveSpec {
    CurveSpec {
        kind,
        segments: vec![Bezier(bezier)],
        normals: vec![DVec3::Z, DVec3::new(1.0, 0.0, 1.0).normalize()],
        width,
        split_depth: 3,
    }
}

/// From (0, −1, 0) to (0, 1, 0).
fn straight() -> [DVec3; 4] {
    [-3.0, -1.0, 1.0, 3.0].map(|y| DVec3::new(0.0, y / 3.0, 0.0))
}

fn bent() -> [DVec3; 4] {
    [
        DVec3::new(-0.2, -1.0, 0.1),
        DVec3::new(0.9, -0.3, -0.4),
        DVec3::new(-0.8, 0.4, 0.5),
        DVec3::new(0.1, 1.0, 0.0),
    ]
}

/// The nearest meeting with any piece of a curve of one segment, and the surface there.
fn meet(
    curves: &Curves,
    o: DVec3,
    d: DVec3,
) -> Option<(CurveHit, crate::shapes::local::LocalSurface)> {
    let segment = curves.stored(0, 0).next().unwrap();
    let ends = curves.segments[0].normals;
    let normals = segment.normals().map(|_| &ends);
    let (o, d) = match &curves.placement {
        None => (o, d),
        Some(place) => place.inward(o, d),
    };
    let hits = (0..segment.pieces())
        .filter_map(|piece| segment.intersect(piece, normals, o, d, f64::INFINITY));
    let hit = hits.min_by(|a, b| a.t.total_cmp(&b.t))?;
    let local = segment.surface(&hit, curves.kind, curves.flip, o, d)?;
    let surface = match &curves.placement {
        None => local,
        Some(p) => local.transformed(p),
    };
    Some((hit, surface))
}

#[test]
fn a_straight_strip_is_as_wide_and_long_as_it_says() {
    let curves = spec(CurveKind::Flat, straight(), [0.4, 0.2]).place(&Transform::IDENTITY, false);
    for uv in points(400) {
        let o = DVec3::new((uv.x - 0.5) * 0.6, (uv.y - 0.5) * 2.4, -5.0);
        let along = (o.y + 1.0) / 2.0;
        let width = 0.4 - 0.2 * along;
        let inside = (0.0..=1.0).contains(&along) && o.x.abs() < 0.5 * width;
        let Some((hit, surface)) = meet(&curves, o, DVec3::Z) else {
            assert!(!inside, "{o}");
            continue;
        };
        assert!(inside, "{o}");
        assert!((hit.t - 5.0).abs() < 1e-6 && (hit.u - along).abs() < 1e-6);
        // Seen along +z, +y up, the strip's v grows to one side over its whole width.
        assert!(((hit.v - 0.5).abs() - o.x.abs() / width).abs() < 1e-6);
        assert!((surface.point.n - DVec3::Z).length() < 1e-6);
        assert!((surface.dpdv.length() - width).abs() < 1e-6);
        assert!((surface.point.p_error.x - 2.0 * width).abs() < 1e-6);
        // ∂p/∂v leads to where v is larger.
        assert!(surface.dpdv.x.signum() * o.x.signum() == (hit.v - 0.5).signum());
    }
    // Along its own axis, from inside and at the end.
    assert!(meet(&curves, DVec3::new(0.05, -3.0, 0.0), DVec3::Y).is_none_or(|(h, _)| h.t > 0.0));
}

#[test]
fn cylinders_turn_their_normal_by_half_a_turn() {
    let flat = spec(CurveKind::Flat, bent(), [0.3, 0.3]).place(&Transform::IDENTITY, false);
    let round = spec(CurveKind::Cylinder, bent(), [0.3, 0.3]).place(&Transform::IDENTITY, false);
    let mut met = 0;
    for uv in points(2000) {
        let o = DVec3::new((uv.x - 0.5) * 1.5, (uv.y - 0.5) * 2.2, -4.0);
        let (Some((a, flat)), Some((b, round))) =
            (meet(&flat, o, DVec3::Z), meet(&round, o, DVec3::Z))
        else {
            continue;
        };
        met += 1;
        assert_eq!((a.t, a.u, a.v), (b.t, b.u, b.v));
        // Between the flat strip's normal and this the angle is that of v across the half turn.
        let angle = flat.point.n.dot(round.point.n).clamp(-1.0, 1.0).acos();
        assert!((angle - ((a.v - 0.5) * PI).abs()).abs() < 1e-6);
        assert!(
            flat.point.n.dot(flat.dpdu).abs() < 1e-9 && round.point.n.dot(round.dpdu).abs() < 1e-9
        );
    }
    assert!(met > 100);
}

#[test]
fn ribbons_face_their_normals() {
    let ribbon = spec(CurveKind::Ribbon, straight(), [0.4, 0.4]).place(&Transform::IDENTITY, false);
    for i in 1..20 {
        let y = -1.0 + 0.1 * f64::from(i);
        let turn = (y + 1.0) / 2.0 * PI / 4.0;
        // Turned by up to 45° it looks as much narrower.
        let half = 0.2 * turn.cos();
        let at = |x: f64| meet(&ribbon, DVec3::new(x, y, -5.0), DVec3::Z);
        let (_, surface) = at(0.99 * half).unwrap();
        assert!(at(1.01 * half).is_none());
        let n = DVec3::new(turn.sin(), 0.0, turn.cos());
        assert!(
            (surface.point.n - n).length() < 1e-6,
            "{} {n}",
            surface.point.n
        );
    }
    // Ends with the same normal turn nothing.
    let mut even = spec(CurveKind::Ribbon, straight(), [0.4, 0.4]);
    even.normals = vec![DVec3::Z; 2];
    let even = even.place(&Transform::IDENTITY, false);
    assert!(meet(&even, DVec3::new(0.19, 0.1, -5.0), DVec3::Z).is_some());
    assert!(meet(&even, DVec3::new(0.21, 0.1, -5.0), DVec3::Z).is_none());
}

/// Rays toward the neighborhood of the curve, from all sides.
fn rays() -> impl Iterator<Item = (DVec3, DVec3)> {
    points(3000).zip(points(6000).skip(3000)).map(|(a, b)| {
        let z = 2.0 * a.x - 1.0;
        let (sin, cos) = (a.y * 2.0 * PI).sin_cos();
        let rho = (1.0 - z * z).sqrt();
        let o = DVec3::new(rho * cos, rho * sin, z) * 4.0;
        let target = Bezier(bent()).at(b.x).0 + DVec3::new(b.y - 0.5, a.x - 0.5, a.y - 0.5) * 0.5;
        (o, target - o)
    })
}

#[test]
fn rays_meet_what_comes_within_half_a_width() {
    let width = [0.2, 0.1];
    let curves = spec(CurveKind::Flat, bent(), width).place(&Transform::IDENTITY, false);
    let (mut hits, mut misses) = (0, 0);
    for (o, d) in rays() {
        // The point of the curve nearest to the line, in units of half the width there.
        let nearest = (0..=2000)
            .map(|i| {
                let u = f64::from(i) / 2000.0;
                let p = Bezier(bent()).at(u).0 - o;
                let off = p - d * (p.dot(d) / d.length_squared());
                let half = 0.5 * (width[0] * (1.0 - u) + width[1] * u);
                (off.length() / half, u, p.dot(d) / d.length_squared())
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap();
        let hit = meet(&curves, o, d);
        // Beyond an end there is nothing, and pieces are straight to a twentieth of the width.
        let end = !(0.02..0.98).contains(&nearest.1);
        if nearest.0 < 0.85 && !end {
            let (hit, surface) = hit.expect("a meeting");
            hits += 1;
            // Another part of the curve may be in front.
            assert!(hit.t <= nearest.2 + 0.2 / d.length());
            assert!((surface.point.p - (o + d * hit.t)).length() < 1e-6);
            assert!((0.0..=1.0).contains(&hit.v) && (0.0..=1.0).contains(&hit.u));
            // And it is within the box of some piece.
            let segment = curves.stored(0, 0).next().unwrap();
            let inside = (0..segment.pieces()).any(|i| {
                let (min, max) = segment.bounds(i);
                surface.point.p.cmpge(min - 1e-6).all() && surface.point.p.cmple(max + 1e-6).all()
            });
            assert!(inside);
        } else if nearest.0 > 1.15 {
            assert!(hit.is_none());
            misses += 1;
        }
    }
    assert!(hits > 500 && misses > 500, "{hits} {misses}");
}

#[test]
fn boxes_do_not_change_what_is_met() {
    let place = |depth| {
        let spec = CurveSpec {
            split_depth: depth,
            ..spec(CurveKind::Flat, bent(), [0.05, 0.02])
        };
        spec.place(&Transform::IDENTITY, false)
    };
    let (whole, cut) = (place(0), place(3));
    assert_eq!(cut.stored(0, 0).next().unwrap().pieces(), 8);
    let differ = rays()
        .filter(|&(o, d)| meet(&whole, o, d).is_some() != meet(&cut, o, d).is_some())
        .count();
    // Pieces are straightened to a twentieth of a width, and hits within that of an edge may differ:
    // of all rays 1.4 in a hundred come so near.
    assert!(differ < 30, "{differ}");
}

#[test]
fn transformations_that_keep_no_angles_are_those_of_the_object() {
    let turn = Transform::rotate(35.0, DVec3::new(1.0, 2.0, 0.5));
    let object = spec(CurveKind::Cylinder, bent(), [0.2, 0.1]).place(&Transform::IDENTITY, false);
    for (transform, similar) in [
        (turn * Transform::scale(DVec3::splat(3.0)), true),
        (
            turn * Transform::scale(DVec3::new(3.0, 0.5, 1.5)) * turn,
            false,
        ),
        (turn * Transform::scale(DVec3::new(-1.0, 1.0, 1.0)), false),
    ] {
        let curves = spec(CurveKind::Cylinder, bent(), [0.2, 0.1]).place(&transform, false);
        assert_eq!(curves.placement.is_none(), similar);
        let mut met = 0;
        for (o, d) in rays() {
            let there = meet(&curves, transform.point(o), transform.vector(d));
            let (Some((a, expected)), Some((b, found))) = (meet(&object, o, d), there) else {
                continue;
            };
            met += 1;
            // Single precision in the points.
            assert!((a.t - b.t).abs() < 1e-5 && (a.u - b.u).abs() < 1e-4);
            assert!((a.v - b.v).abs() < 1e-3, "{} {}", a.v, b.v);
            let side = if transform.swaps_handedness() {
                -1.0
            } else {
                1.0
            };
            let n = transform.normal(expected.point.n).normalize() * side;
            assert!((n - found.point.n).length() < 1e-2, "{n} {}", found.point.n);
            assert!((transform.point(expected.point.p) - found.point.p).length() < 1e-4);
        }
        assert!(met > 500);
        // The same seen from elsewhere.
        let anchor = DVec3::new(5.0, -3.0, 2.0);
        let moved = curves.clone().relative_to(anchor);
        let (o, d) = rays()
            .find(|&(o, d)| meet(&object, o, d).is_some())
            .unwrap();
        let (o, d) = (transform.point(o), transform.vector(d));
        let (a, b) = (
            meet(&curves, o, d).unwrap(),
            meet(&moved, o - anchor, d).unwrap(),
        );
        assert!(
            (a.0.t - b.0.t).abs() < 1e-5 && (a.1.point.p - b.1.point.p - anchor).length() < 1e-4
        );
    }
}

#[test]
fn parameters_are_read_and_checked() {
    let four = "\"point P\" [0 0 0 1 0 0 1 1 0 0 1 0]";
    let outcome = reading(four);
    assert!(outcome.messages.is_empty());
    let curve = outcome.value.unwrap();
    assert_eq!(
        (curve.kind, curve.width, curve.segments.len()),
        (CurveKind::Flat, [1.0; 2], 1)
    );
    let curve = |params: &str| reading(&format!("{params} {four}"));
    assert_eq!(
        curve("\"float width\" 2 \"float width1\" .5")
            .value
            .unwrap()
            .width,
        [2.0, 0.5]
    );
    assert_eq!(
        curve("\"float splitdepth\" 1").value.unwrap().split_depth,
        1
    );
    assert_eq!(
        curve("\"integer splitdepth\" 9").value.unwrap().split_depth,
        3
    );
    // Four points are two segments of a quadratic B-spline, one of a cubic, and no quadratic Bézier.
    let bspline = curve("\"string basis\" \"bspline\" \"integer degree\" 2")
        .value
        .unwrap();
    assert_eq!(bspline.segments.len(), 2);
    assert_eq!(bspline.segments[0].0[3], bspline.segments[1].0[0]);
    assert_eq!(
        curve("\"string basis\" \"bspline\"")
            .value
            .unwrap()
            .segments
            .len(),
        1
    );
    for wrong in [
        "\"integer degree\" 2",
        "\"integer degree\" 4",
        "\"string type\" \"ribbon\"",
        "\"string type\" \"ribbon\" \"normal N\" [0 0 1]",
        "\"string type\" \"ribbon\" \"normal N\" [0 0 1 0 0 0]",
    ] {
        let outcome = curve(wrong);
        assert!(outcome.value.is_none() && outcome.errors == 1, "{wrong}");
    }
    assert!(reading("").value.is_none());
    assert!(reading("\"point P\" [0 0 0 1 0 0]").value.is_none());
    for odd in [
        "\"normal N\" [0 0 1 0 0 1]",
        "\"float width\" -1 \"float width0\" 1",
        "\"string type\" \"round\"",
    ] {
        let outcome = curve(odd);
        assert!(outcome.value.is_some() && outcome.warnings == 1, "{odd}");
    }
    assert_eq!(
        curve("\"string type\" \"round\"").value.unwrap().kind,
        CurveKind::Cylinder
    );
}
