//! Densities against sampling, and sampling against the true surface.

use super::*;
use crate::math::DVec2;
use crate::math::ray::Ray;
use crate::math::sampling::uniform_sphere;
use crate::math::transform::Transform;
use crate::shapes::Form;
use crate::shapes::cone::Cone as ConeForm;
use crate::shapes::cylinder::Cylinder;
use crate::shapes::disk::Disk;
use crate::shapes::hyperboloid::Hyperboloid;
use crate::shapes::local::LocalHit;
use crate::shapes::paraboloid::Paraboloid;
use crate::shapes::quadric::tests::points;
use crate::shapes::sphere::Sphere;
use crate::shapes::triangle::Triangle;

fn reference(p: Vec3) -> ReferencePoint {
    ReferencePoint {
        p,
        ..Default::default()
    }
}

/// Something light is sampled from, with a way to meet it.
enum Shape {
    Flat(Vec<Triangle>, Emitter),
    Quadric(Box<Quadric>, Emitter),
}

impl Shape {
    fn quadric(form: Form, transform: Transform, reverse: bool) -> Shape {
        let quadric = Quadric::new(form, transform, reverse);
        let emitter = Emitter::of_quadric(&quadric);
        Shape::Quadric(Box::new(quadric), emitter)
    }

    fn triangle(p: [Vec3; 3]) -> Shape {
        let emitter = TriangleEmitter::new(p, None, Orientation::default());
        Shape::Flat(vec![flat(p)], Emitter::Triangle(emitter))
    }

    fn parallelogram([a, b, c, d]: [Vec3; 4]) -> Shape {
        let corners = [[a, b, c], [d, a, c]];
        let [first, second] = corners;
        let emitter =
            ParallelogramEmitter::of_triangles(first, second, Orientation::default()).unwrap();
        Shape::Flat(
            corners.map(flat).into(),
            Emitter::Parallelogram(Box::new(emitter)),
        )
    }

    fn emitter(&self) -> &Emitter {
        match self {
            Shape::Flat(_, emitter) | Shape::Quadric(_, emitter) => emitter,
        }
    }

    /// All meetings of the ray with the surface, in order.
    fn hits(&self, o: DVec3, d: DVec3) -> Vec<SurfaceHit> {
        let ray = Ray::new(o.as_vec3(), d.as_vec3(), 0.0);
        match self {
            Shape::Flat(triangles, _) => {
                let meeting = |triangle: &Triangle| {
                    let hit = triangle.surface(triangle.barycentrics(o, d)?);
                    // Points moved into the triangle are not on the ray, or behind.
                    let t = (hit.point.p - o).dot(d);
                    let met = t > 0.0 && (o + d * t - hit.point.p).length() < 1e-9 * (1.0 + t);
                    met.then(|| hit.hit(&ray))
                };
                triangles.iter().filter_map(meeting).collect()
            }
            Shape::Quadric(quadric, _) => {
                let (mut hits, mut start) = (vec![], 0.0);
                while let Some((t, p)) = quadric.intersect(o + d * start, d) {
                    hits.push(quadric.surface(p).hit(&ray));
                    // Past this sheet.
                    start += t + 1e-7 * (1.0 + start + t);
                }
                hits
            }
        }
    }
}

/// One flat triangle.
fn flat(p: [Vec3; 3]) -> Triangle {
    Triangle {
        p: p.map(Vec3::as_dvec3),
        normals: None,
        tangents: None,
        uv: None,
        orientation: Orientation::default(),
    }
}

fn shapes() -> Vec<Shape> {
    let turn = Transform::rotate(50.0, DVec3::new(1.0, -1.0, 2.0));
    let uneven = turn * Transform::scale(DVec3::new(0.5, 1.4, -0.8)) * turn;
    let ends = [DVec3::new(0.6, 0.0, -0.1), DVec3::new(0.2, 0.5, 1.1)];
    let hyperboloid = Hyperboloid::new(ends[0], ends[1], 250.0).unwrap();
    let even = turn * Transform::scale(DVec3::splat(1.3));
    let mut shapes = vec![Shape::triangle([
        Vec3::new(-1.0, -0.5, 0.2),
        Vec3::new(1.0, -0.7, 0.0),
        Vec3::new(0.2, 1.1, -0.4),
    ])];
    shapes.push(Shape::parallelogram([
        Vec3::new(-1.0, -0.5, 0.25),
        Vec3::new(1.0, -0.75, 0.0),
        Vec3::new(1.25, 0.5, -0.5),
        Vec3::new(-0.75, 0.75, -0.25),
    ]));
    for transform in [even, uneven] {
        for form in [
            Form::Sphere(Sphere::new(1.0, -1.0, 1.0, 360.0)),
            Form::Sphere(Sphere::new(1.0, -0.6, 0.8, 220.0)),
            Form::Disk(Disk::new(0.1, 1.0, 0.3, 300.0)),
            Form::Cylinder(Cylinder::new(0.7, -0.8, 0.9, 280.0)),
            Form::Cone(ConeForm::new(0.8, 1.2, 360.0)),
            Form::Paraboloid(Paraboloid::new(0.8, 0.1, 1.1, 300.0)),
            Form::Hyperboloid(hyperboloid),
        ] {
            shapes.push(Shape::quadric(form, transform, false));
        }
    }
    shapes
}

/// Points that look at the shapes: outside, near, and inside the closed ones; none in the plane of a
/// disk, which nothing is sampled from.
const PLACES: [Vec3; 3] = [
    Vec3::new(2.5, -1.0, 1.5),
    Vec3::new(0.3, 0.2, 1.9),
    Vec3::new(0.1, -0.05, 0.35),
];

/// Choices are points; along a direction several may lie behind each other, and the density of
/// the direction is the sum over them. Only the cone of a full sphere chooses the nearest.
fn total_density(shape: &Shape, from: &ReferencePoint, wi: DVec3) -> f64 {
    let hits = shape.hits(from.p.as_dvec3(), wi);
    let from_outside = |s: &Ball| s.cone(from).is_some();
    let counted = match shape.emitter() {
        Emitter::Sphere(sphere) if from_outside(sphere) => 1,
        _ => hits.len(),
    };
    hits.iter()
        .take(counted)
        .map(|hit| f64::from(shape.emitter().pdf(from, wi.as_vec3(), hit)))
        .sum()
}

#[test]
fn densities_integrate_to_one() {
    for (i, shape) in shapes().iter().enumerate() {
        for place in PLACES {
            let from = reference(place);
            let n = 200_000;
            let (mut sum, mut squares) = (0.0, 0.0);
            for u in points(n) {
                let d = total_density(
                    shape,
                    &from,
                    uniform_sphere(u.as_vec2()).as_dvec3().normalize(),
                );
                sum += d * 2.0 * TAU;
                squares += (d * 2.0 * TAU).powi(2);
            }
            let mean = sum / n as f64;
            let deviation = ((squares / n as f64 - mean * mean) / n as f64).sqrt();
            // The point set is more even than random, so five standard deviations of random
            // points are far beyond its error; rare edge-on directions carry large densities.
            assert!(
                (mean - 1.0).abs() < 5.0 * deviation + 1e-3,
                "shape {i} from {place}: {mean} ± {deviation}"
            );
        }
    }
}

#[test]
fn samples_carry_the_density_of_their_point() {
    for (i, shape) in shapes().iter().enumerate() {
        for place in PLACES {
            let from = reference(place);
            let mut compared = 0;
            for u in points(500) {
                let Some(sample) = shape.emitter().sample(&from, u.as_vec2()) else {
                    continue;
                };
                let wi = (sample.p.as_dvec3() - place.as_dvec3()).normalize();
                // The point is on the surface.
                let hits = shape.hits(place.as_dvec3(), wi);
                let at = |hit: &&SurfaceHit| (hit.p - sample.p).length() < 2e-3;
                let Some(hit) = hits.iter().find(at) else {
                    // At a rim the rounded direction may just miss; and seen edge-on.
                    continue;
                };
                if hit.n.dot(wi.as_vec3()).abs() < 0.02 {
                    continue;
                }
                assert!(
                    hit.n.dot(sample.n) > 0.99,
                    "shape {i}: {} {}",
                    hit.n,
                    sample.n
                );
                let pdf = shape.emitter().pdf(&from, wi.as_vec3(), hit);
                // The sampled point is rounded, which tilts its direction against steep normals.
                assert!(
                    (pdf / sample.pdf - 1.0).abs() < 1e-2,
                    "shape {i}: {pdf} {}",
                    sample.pdf
                );
                compared += 1;
            }
            assert!(compared > 400, "shape {i} from {place}: {compared}");
        }
    }
}

#[test]
fn samples_land_where_the_density_says() {
    // Chi-squared over the octants and signs of direction in which samples are: expected counts
    // by integrating the density on a uniform grid of directions.
    let bin = |d: DVec3| {
        let face = if d.x.abs() > d.y.abs() && d.x.abs() > d.z.abs() {
            0
        } else if d.y.abs() > d.z.abs() {
            1
        } else {
            2
        };
        face * 8 + usize::from(d.x > 0.0) * 4 + usize::from(d.y > 0.0) * 2 + usize::from(d.z > 0.0)
    };
    for (i, shape) in shapes().iter().enumerate() {
        // From within the bounding box, so that samples lie in many directions.
        let from = reference(PLACES[2]);
        let (n, grid) = (4_000, 200_000);
        let (mut observed, mut expected) = ([0.0f64; 24], [0.0f64; 24]);
        let mut random = 1u64;
        for _ in 0..n {
            let mut next = || {
                random += 1;
                crate::math::hash::unit_float(crate::math::hash::mix2(77, random))
            };
            let u = Vec2::new(next(), next());
            let Some(sample) = shape.emitter().sample(&from, u) else {
                continue;
            };
            observed[bin(sample.p.as_dvec3() - from.p.as_dvec3())] += 1.0;
        }
        for u in points(grid) {
            let d = uniform_sphere(u.as_vec2()).as_dvec3().normalize();
            expected[bin(d)] +=
                total_density(shape, &from, d) * 2.0 * TAU / grid as f64 * f64::from(n);
        }
        let (mut chi2, mut bins) = (0.0, 0);
        for (o, e) in observed.iter().zip(expected) {
            if e > 20.0 {
                chi2 += (o - e) * (o - e) / e;
                bins += 1;
            } else {
                assert!(*o < 60.0, "shape {i}: {o} samples where {e} were expected");
            }
        }
        // The 1 − 10⁻⁶ quantile for 23 degrees of freedom is 70; expected counts are themselves
        // good to a percent.
        assert!(
            bins >= 2 && chi2 < 90.0,
            "shape {i}: χ² = {chi2} in {bins} bins"
        );
    }
}

#[test]
fn mean_inverse_density_is_the_solid_angle() {
    // A disk on the axis at distance h seen under 2π(1 − h/√(h² + r²)), however it is scaled.
    let disk = Form::Disk(Disk::new(0.0, 1.0, 0.0, 360.0));
    for (transform, radius) in [
        (Transform::scale(DVec3::splat(2.0)), 2.0f64),
        (Transform::scale(DVec3::new(3.0, 3.0, 0.1)), 3.0),
        (Transform::scale(DVec3::new(-1.0, 1.0, 1.0)), 1.0),
    ] {
        let shape = Shape::quadric(disk, transform, false);
        let h = 1.5f64;
        let from = reference(Vec3::new(0.0, 0.0, h as f32));
        let inverse =
            |u: DVec2| f64::from(1.0 / shape.emitter().sample(&from, u.as_vec2()).unwrap().pdf);
        let n = 100_000;
        let mean = points(n).map(inverse).sum::<f64>() / n as f64;
        let expected = TAU * (1.0 - h / h.hypot(radius));
        assert!((mean / expected - 1.0).abs() < 1e-3, "{mean} {expected}");
        assert!((shape.emitter().area() / (0.5 * TAU * radius * radius) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn spheres_near_far_and_tiny_are_sampled_by_their_cone() {
    for (radius, distance) in [
        (1.0f64, 1.000_001f64),
        (1.0, 3.0),
        (1e-4, 1e3),
        (1e-2, 1e6),
        (1e5, 1.5e5),
    ] {
        let transform = Transform::translate(DVec3::new(0.0, distance, 0.0))
            * Transform::scale(DVec3::splat(radius));
        let shape = Shape::quadric(
            Form::Sphere(Sphere::new(1.0, -1.0, 1.0, 360.0)),
            transform,
            false,
        );
        let from = reference(Vec3::ZERO);
        // The solid angle, by the series for small ones: 2π(1 − cos) ≈ π sin² (1 + sin²/4).
        let s2 = (radius / distance).powi(2);
        let solid_angle = if s2 < 1e-4 {
            0.5 * TAU * s2 * (1.0 + 0.25 * s2)
        } else {
            TAU * (1.0 - (1.0 - s2).sqrt())
        };
        for u in points(500) {
            let sample = shape.emitter().sample(&from, u.as_vec2()).unwrap();
            assert!((f64::from(sample.pdf) * solid_angle - 1.0).abs() < 1e-5);
            // On the sphere, within the box; on the near side.
            let center = DVec3::new(0.0, distance, 0.0);
            let off = ((sample.p.as_dvec3() - center).length() - radius).abs();
            assert!(off <= sample.p_error.as_dvec3().length() * 1.01, "{off}");
            assert!(
                sample
                    .n
                    .as_dvec3()
                    .dot((sample.p.as_dvec3() - from.p.as_dvec3()).normalize())
                    < 1e-5
            );
        }
    }
}

#[test]
fn emitters_shine_on_the_side_that_hits_report() {
    // Scene-language 4.4 and 4.5: sampling uses the same side as hits, mirrored or reversed.
    let mirror = Transform::scale(DVec3::new(1.0, -1.0, 1.0));
    for transform in [Transform::IDENTITY, mirror] {
        for reverse in [false, true] {
            for form in [
                Form::Sphere(Sphere::new(1.0, -1.0, 1.0, 360.0)),
                Form::Sphere(Sphere::new(1.0, -0.9, 1.0, 360.0)),
            ] {
                let quadric = Quadric::new(form, transform, reverse);
                let sample = Emitter::of_quadric(&quadric)
                    .sample(&reference(Vec3::X * 3.0), Vec2::splat(0.4))
                    .unwrap();
                let outward = sample.n.dot(sample.p) > 0.0;
                let hit = quadric.surface(DVec3::X);
                assert_eq!(outward, hit.point.n.x > 0.0);
            }
            let mut data = crate::assets::mesh::MeshData {
                indices: vec![[0, 1, 2]],
                positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
                ..Default::default()
            };
            for normals in [vec![], vec![Vec3::NEG_Z; 3]] {
                data.normals = normals;
                let mesh = TriangleMesh::new(data.clone(), &transform, reverse);
                let sample = Emitter::of_mesh(&mesh)
                    .next()
                    .unwrap()
                    .sample(&reference(Vec3::splat(2.0)), Vec2::splat(0.4))
                    .unwrap();
                let up = data.normals.is_empty() ^ reverse;
                assert_eq!(sample.n.z > 0.0, up);
            }
        }
    }
}

#[test]
fn nothing_is_sampled_where_there_is_no_area() {
    let data = crate::assets::mesh::MeshData {
        indices: vec![[0, 1, 1], [0, 1, 2]],
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::splat(f64::NAN)],
        ..Default::default()
    };
    for emitter in Emitter::of_mesh(&TriangleMesh::new(data, &Transform::IDENTITY, false)) {
        assert!(
            emitter
                .sample(&reference(Vec3::splat(2.0)), Vec2::splat(0.4))
                .is_none()
        );
    }
    // From a point of the plane of a disk it cannot be seen.
    let disk = Shape::quadric(
        Form::Disk(Disk::new(0.0, 1.0, 0.0, 360.0)),
        Transform::IDENTITY,
        false,
    );
    assert!(
        disk.emitter()
            .sample(&reference(Vec3::X * 5.0), Vec2::splat(0.3))
            .is_none()
    );
}

#[test]
fn two_triangles_are_one_lamp_where_they_make_a_parallelogram() {
    let corner = |x: f32, y: f32| Vec3::new(100.1 + x, 0.3 * y, y - 0.7);
    let (a, b, c, d) = (
        corner(0.0, 0.0),
        corner(1.3, 0.1),
        corner(1.7, 1.1),
        corner(0.4, 1.0),
    );
    let emitter =
        |first, second| ParallelogramEmitter::of_triangles(first, second, Orientation::default());
    for turn in 0..3 {
        let turned = |[p, q, r]: [Vec3; 3]| [[p, q, r], [q, r, p], [r, p, q]][turn];
        let piece = emitter(turned([a, b, c]), [a, c, d]).unwrap();
        assert!(emitter([a, b, c], turned([a, c, d])).is_some());
        let triangles = [flat([a, b, c]), flat([a, c, d])];
        let area = |t: &Triangle| 0.5 * (t.p[1] - t.p[0]).cross(t.p[2] - t.p[0]).length();
        // Corners are off by a rounding of 100, four millionths of the sides.
        assert!((piece.area / triangles.iter().map(area).sum::<f64>() - 1.0).abs() < 1e-5);
        let center = piece
            .point(Vec2::splat(0.5))
            .seen_from(&reference(Vec3::ZERO))
            .unwrap();
        assert!((center.p - (a + c) * 0.5).length() < 1e-4);
        assert!(
            center
                .n
                .as_dvec3()
                .dot(triangles[0].local_point([1.0, 0.0, 0.0]).n)
                > 0.999
        );
    }
    // Turned against each other, not closed, not flat, without area, the same twice, apart.
    assert!(emitter([a, b, c], [a, d, c]).is_none());
    assert!(emitter([a, b, c], [a, c, d + 0.001 * Vec3::X]).is_none());
    assert!(emitter([a, b, c], [a, c, d + 0.01 * Vec3::Y]).is_none());
    assert!(emitter([a, a, c], [a, c, c]).is_none());
    assert!(emitter([a, b, c], [a, b, c]).is_none());
    assert!(emitter([a, b, c], [a, b, c].map(|p| p + Vec3::X)).is_none());
}
