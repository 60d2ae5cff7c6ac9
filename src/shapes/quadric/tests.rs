use super::*;
use crate::shapes::cone::Cone;
use crate::shapes::cylinder::Cylinder;
use crate::shapes::disk::Disk;
use crate::shapes::hyperboloid::Hyperboloid;
use crate::shapes::local::LocalHit;
use crate::shapes::paraboloid::Paraboloid;
use crate::shapes::sphere::Sphere;

/// Points of the unit square, evenly spread (Roberts' R2 sequence).
pub(crate) fn points(n: usize) -> impl Iterator<Item = DVec2> {
    (0..n).map(|i| {
        let i = i as f64 + 0.5;
        DVec2::new(
            (i * 0.754_877_666_246_692_7).fract(),
            (i * 0.569_840_290_998_053_2).fract(),
        )
    })
}

fn in_unit_square(uv: DVec2) -> bool {
    // Parameters of points that were rounded onto a cut.
    (-1e-9..=1.0 + 1e-9).contains(&uv.x) && (-1e-9..=1.0 + 1e-9).contains(&uv.y)
}

/// Derivatives against finite differences.
pub(crate) fn check_derivatives(shape: &impl ObjectSurface) {
    // Truncation error of the differences is STEP times curvatures of order 10.
    const STEP: f64 = 1e-5;
    for u in points(500) {
        // Away from cuts and poles, where the moved point may not exist.
        let u = DVec2::splat(0.05) + u * 0.9;
        let p = shape.sample(u);
        let at = shape.at(p);
        assert!((at.n.length() - 1.0).abs() < 1e-12);
        assert_eq!(shape.normal(p), at.n);
        assert!(
            (at.dpdu.cross(at.dpdv).normalize() - at.n).length() < 1e-9,
            "{at:?}"
        );
        for (axis, dp, dn) in [(0, at.dpdu, at.dndu), (1, at.dpdv, at.dndv)] {
            // Back onto the surface from above; from both sides of a thin one the nearer counts.
            let above = p + dp * STEP + at.n * 1e-3;
            let Some((_, q)) = shape.intersect(above, -at.n) else {
                panic!("no surface at {p} + {dp} ε");
            };
            let moved = shape.at(q);
            let mut expected = DVec2::ZERO;
            expected[axis] = STEP;
            assert!(
                (moved.uv - at.uv - expected).length() < 30.0 * STEP * STEP * dp.length().max(1.0)
            );
            let change = (moved.n - at.n) / STEP;
            assert!(
                (change - dn).length() < 30.0 * STEP * dn.length().max(1.0),
                "{change} {dn}"
            );
        }
    }
}

/// Rays toward points of the surface meet it there or before, and only where there is surface.
pub(crate) fn check_hits(shape: &impl ObjectSurface) {
    for (i, u) in points(2000).enumerate() {
        let target = shape.sample(u);
        let o = DVec3::new(
            (i as f64 * 0.7).sin(),
            (i as f64 * 1.1).cos(),
            (i as f64 * 0.3).sin(),
        ) * (1.0 + i as f64 * 0.01);
        let d = target - o;
        let Some((t, p)) = shape.intersect(o, d) else {
            // Rounding may put a point of the cut outside.
            let uv = shape.at(target).uv;
            assert!(
                uv.cmplt(DVec2::splat(1e-6)).any() || uv.cmpgt(DVec2::splat(1.0 - 1e-6)).any(),
                "missed {target} from {o}"
            );
            continue;
        };
        assert!(t <= 1.0 + 1e-7, "{t}");
        assert_eq!(shape.distance(o, d), Some(t));
        // Grazing hits are the ill-conditioned ones.
        assert!((o + d * t - p).length() < 1e-6 * d.length());
        assert!(in_unit_square(shape.at(p).uv), "{:?}", shape.at(p));
    }
}

/// Points are uniform over the area: with density 1/A, the mean of f/|∂p/∂u × ∂p/∂v| is the
/// integral of f over (u, v) divided by A, for f = 1, u and v.
pub(crate) fn check_uniform(shape: &impl ObjectSurface) {
    let n = 400_000;
    let (mut one, mut first) = (0.0, DVec2::ZERO);
    for u in points(n) {
        let at = shape.at(shape.sample(u));
        let weight = shape.area() / at.dpdu.cross(at.dpdv).length();
        one += weight / n as f64;
        first += at.uv * weight / n as f64;
    }
    // The integrand has an integrable singularity at poles and apexes; the sequence's error there
    // falls with the square root of the count.
    assert!((one - 1.0).abs() < 1e-2, "{one}");
    assert!((first - DVec2::splat(0.5)).length() < 1e-2, "{first}");
}

#[test]
fn roots_do_not_cancel() {
    // t² − 2·10⁸ t + 1: the small root is 5·10⁻⁹ (1 + 2.5·10⁻¹⁷).
    let [s, t] = roots(1.0, -1e8, 1.0, 1e16 - 1.0).unwrap();
    assert!((s / 5e-9 - 1.0).abs() < 1e-15 && (t / 2e8 - 1.0).abs() < 1e-15);
    assert_eq!(roots(0.0, 2.0, -8.0, 4.0).unwrap(), [2.0, 2.0]);
    assert_eq!(roots(0.0, -2.0, 8.0, 4.0).unwrap(), [2.0, 2.0]);
    assert_eq!(roots(1.0, 0.0, 0.0, 0.0).unwrap(), [0.0, 0.0]);
    assert!(roots(1.0, 0.0, 1.0, -1.0).is_none());
    assert!(roots(0.0, 0.0, 1.0, 0.0).is_none());
}

/// A few placements: similarity, uneven, sheared, mirrored, far away.
fn placements() -> Vec<Transform> {
    let turn = Transform::rotate(40.0, DVec3::new(1.0, 2.0, -0.5));
    let move_far = Transform::translate(DVec3::new(3e5, -2e5, 1e5));
    vec![
        Transform::IDENTITY,
        turn * Transform::scale(DVec3::splat(1e-4)),
        move_far * turn * Transform::scale(DVec3::new(2.0, 0.5, 3.0)) * turn,
        Transform::scale(DVec3::new(-1.0, 1.0, 1.0)) * turn,
        Transform::scale(DVec3::splat(1e6)),
    ]
}

fn hyperboloid(p1: DVec3) -> Hyperboloid {
    Hyperboloid::new(p1, DVec3::new(0.6, 0.7, 1.0), 360.0).unwrap()
}

fn forms() -> [Form; 9] {
    [
        Form::Sphere(Sphere::new(1.0, -1.0, 1.0, 360.0)),
        Form::Sphere(Sphere::new(1.0, -0.5, 0.7, 270.0)),
        Form::Disk(Disk::new(0.3, 1.0, 0.2, 360.0)),
        Form::Cylinder(Cylinder::new(1.0, -1.0, 1.0, 360.0)),
        Form::Cone(Cone::new(1.0, 1.5, 360.0)),
        Form::Cone(Cone::new(1.0, 1e-3, 200.0)),
        Form::Paraboloid(Paraboloid::new(1.0, 0.2, 1.5, 360.0)),
        Form::Hyperboloid(hyperboloid(DVec3::new(0.6, -0.7, -1.0))),
        // Shaded with the normal of the sweep.
        Form::Hyperboloid(hyperboloid(DVec3::new(0.9, 0.0, 0.0))),
    ]
}

#[test]
fn orientation_follows_the_table() {
    // docs/scene-language.md §4.4: outward in object space, negated by ReverseOrientation XOR a mirror.
    let sphere = Form::Sphere(Sphere::new(1.0, -1.0, 1.0, 360.0));
    let mirror = Transform::scale(DVec3::new(1.0, 1.0, -1.0));
    for (transform, reverse, outward) in [
        (Transform::IDENTITY, false, true),
        (Transform::IDENTITY, true, false),
        (mirror, false, false),
        (mirror, true, true),
    ] {
        let quadric = Quadric::new(sphere, transform, reverse);
        let surface = quadric.surface(DVec3::X);
        assert_eq!(surface.point.n.x > 0.0, outward);
        assert_eq!(surface.point.n, surface.point.shading_n);
    }
}

#[test]
fn areas_follow_the_transformation() {
    for form in forms() {
        let stretched = Transform::scale(DVec3::splat(3.0));
        let area = Quadric::new(form, stretched, false).area();
        assert!((area / (9.0 * form.area()) - 1.0).abs() < 1e-12);
    }
    // A disk squeezed to an ellipse with axes 2 and 0.5.
    let disk = Form::Disk(Disk::new(0.0, 1.0, 0.0, 360.0));
    let area = Quadric::new(disk, Transform::scale(DVec3::new(2.0, 0.5, 7.0)), false).area();
    assert!((area / std::f64::consts::PI - 1.0).abs() < 1e-12);
    // Prolate spheroid with axes 1, 1, 2: 2π(1 + (2/e) asin e), e² = 3/4.
    let sphere = Form::Sphere(Sphere::new(1.0, -1.0, 1.0, 360.0));
    let area = Quadric::new(sphere, Transform::scale(DVec3::new(1.0, 1.0, 2.0)), false).area();
    let e = 0.75f64.sqrt();
    let expected = std::f64::consts::TAU * (1.0 + 2.0 / e * e.asin());
    assert!((area / expected - 1.0).abs() < 1e-4); // the midpoint rule's error
}

#[test]
fn hits_lie_within_their_error_boxes_at_every_scale() {
    for form in forms() {
        for transform in placements() {
            let quadric = Quadric::new(form, transform, false);
            for u in points(300) {
                let object = form.sample(u);
                let surface = quadric.surface(object);
                let ray =
                    crate::math::ray::Ray::new(crate::math::Vec3::ZERO, crate::math::Vec3::X, 0.0);
                let hit = surface.hit(&ray);
                let off = (hit.p.as_dvec3() - surface.point.p).abs();
                assert!(
                    off.cmple(hit.p_error.as_dvec3()).all(),
                    "{off} {}",
                    hit.p_error
                );
                // And the bound is not much more than the rounding: 2 ulp of the largest
                // coordinate.
                let ulp = f64::from(hit.p.abs().max_element()) * f64::from(f32::EPSILON);
                assert!(f64::from(hit.p_error.max_element()) < 2.0 * ulp);
            }
        }
    }
}

#[test]
fn normals_stay_perpendicular_and_derivatives_follow() {
    for form in forms() {
        for transform in placements() {
            let quadric = Quadric::new(form, transform, true);
            for u in points(100) {
                let object = form.sample(DVec2::splat(0.05) + u * 0.9);
                let s = quadric.surface(object);
                assert!(
                    s.point.n.dot(s.dpdu.normalize()).abs() < 1e-9
                        && s.point.n.dot(s.dpdv.normalize()).abs() < 1e-9
                );
                // n over a step of u, against ∂n/∂u.
                let step = 1e-5;
                let at = form.at(object);
                let Some((_, moved)) = form.intersect(object + at.dpdu * step + at.n * 1e-3, -at.n)
                else {
                    continue;
                };
                let change = (quadric.surface(moved).point.n - s.point.n) / step;
                assert!((change - s.dndu).length() < 1e-2 * s.dndu.length().max(1.0));
            }
        }
    }
}
