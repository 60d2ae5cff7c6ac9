//! Random triangles against brute force in double precision, and against obvhs's traversal.

use super::*;
use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::ray::RayHit;
use obvhs::triangle::Triangle as ObvhsTriangle;

/// The closest hit by testing every triangle: its distance, and how near an edge it is.
fn brute_force(data: &MeshData, ray: &Ray) -> Option<(f64, f64)> {
    let (o, d) = (ray.o.as_dvec3(), ray.d.as_dvec3());
    let mut best: Option<(f64, f64)> = None;
    for t in &data.indices {
        // As rounded for the tree.
        let [a, b, c] = t.map(|i| data.positions[i as usize].as_vec3().as_dvec3());
        let (e1, e2) = (b - a, c - a);
        let across = d.cross(e2);
        let determinant = e1.dot(across);
        let b1 = (o - a).dot(across) / determinant;
        let b2 = d.dot((o - a).cross(e1)) / determinant;
        let distance = e2.dot((o - a).cross(e1)) / determinant;
        let margin = b1.min(b2).min(1.0 - b1 - b2);
        if margin > -1e-5 && distance > 0.0 && best.is_none_or(|(t, _)| distance < t) {
            best = Some((distance, margin));
        }
    }
    best
}

#[test]
fn random_soups_agree_with_brute_force() {
    for (n, size, seed) in [
        (1, 0.5, 1),
        (2, 0.5, 2),
        (9, 0.5, 3),
        (300, 0.3, 4),
        (2000, 0.05, 5),
    ] {
        let data = soup(n, size, seed);
        let geometry = scene(vec![compiled(&data, &Transform::IDENTITY)]);
        let mut random = Random(seed + 100);
        let (mut hits, mut unclear) = (0, 0);
        for _ in 0..2000 {
            let mut ray = Ray::new(random.cube() * 2.0, random.direction(), 0.0);
            if random.next() < 0.3 {
                ray.t_max = random.next() * 3.0;
            }
            let expected = brute_force(&data, &ray).filter(|(t, _)| *t < f64::from(ray.t_max));
            if expected.is_some_and(|(_, margin)| margin < 1e-5) {
                // On an edge, to single precision: either answer is right.
                unclear += 1;
                continue;
            }
            let hit = geometry.intersect(&ray, &opaque);
            assert_eq!(hit.is_some(), expected.is_some());
            assert_eq!(geometry.occluded(&ray, &opaque), expected.is_some());
            if let (Some(hit), Some((t, _))) = (hit, expected) {
                hits += 1;
                // Distances are computed in double precision and rounded once.
                assert!((f64::from(hit.t) - t).abs() <= 1e-6 * t, "{} {t}", hit.t);
                let p = ray.o.as_dvec3() + ray.d.as_dvec3() * t;
                assert!(
                    (hit.surface.p.as_dvec3() - p)
                        .abs()
                        .cmple(DVec3::splat(1e-6))
                        .all()
                );
                assert_eq!(hit.surface.wo, -ray.d);
            }
        }
        assert!(
            unclear < 20 && (hits > 100 || n < 10),
            "{unclear} unclear, {hits} hits"
        );
    }
}

/// The number of 20,000 rays that hit, and of those where obvhs's own traversal disagrees.
fn beside_obvhs(data: &MeshData) -> (usize, usize) {
    let geometry = scene(vec![compiled(data, &Transform::IDENTITY)]);
    let triangles: Vec<ObvhsTriangle> = data
        .indices
        .iter()
        .map(|t| {
            let [v0, v1, v2] = t.map(|i| data.positions[i as usize].as_vec3().into());
            ObvhsTriangle { v0, v1, v2 }
        })
        .collect();
    let bvh = build_bvh2_from_tris(
        &triangles,
        BvhBuildParams::fast_build(),
        &mut Default::default(),
    );
    let mut random = Random(8);
    let (mut hits, mut different) = (0, 0);
    for _ in 0..20_000 {
        let ray = Ray::new(random.cube() * 1.5, random.direction(), 0.0);
        let theirs = obvhs::ray::Ray::new(ray.o.into(), ray.d.into(), 0.0, f32::INFINITY);
        let mut found = RayHit::none();
        bvh.ray_traverse(theirs, &mut found, |ray, i| {
            triangles[bvh.primitive_indices[i] as usize].intersect(ray)
        });
        let hit = geometry.intersect(&ray, &opaque);
        assert_eq!(geometry.distance(&ray, &opaque), hit.map(|hit| hit.t));
        let ours = hit.map_or(f32::INFINITY, |hit| hit.t);
        let theirs = if found.t.is_finite() && found.t < 1e30 {
            found.t
        } else {
            f32::INFINITY
        };
        hits += usize::from(ours.is_finite());
        // Their distances have single-precision errors.
        different += usize::from(!(ours == theirs || (ours - theirs).abs() < 1e-3));
    }
    (hits, different)
}

#[test]
fn large_meshes_agree_with_obvhs() {
    for data in [soup(50_000, 0.03, 7), ball(150)] {
        let (hits, different) = beside_obvhs(&data);
        // obvhs loses some rays at edges: about one in 1e5 here.
        assert!(
            hits > 5000 && different <= 3,
            "{hits} hits, {different} different"
        );
    }
}

#[test]
fn nearer_triangles_hide_farther_ones_whatever_the_order() {
    let square = |z: f64| {
        mesh(
            vec![
                DVec3::new(-1.0, -1.0, z),
                DVec3::new(1.0, -1.0, z),
                DVec3::new(0.0, 1.0, z),
            ],
            vec![[0, 1, 2]],
        )
    };
    let heights = [3.0, 1.0, 2.0, 5.0, 4.0];
    let shapes = heights
        .iter()
        .map(|&z| compiled(&square(z), &Transform::IDENTITY))
        .collect();
    let geometry = scene(shapes);
    for (z, expected) in [(0.0, 1.0), (1.5, 2.0), (4.5, 5.0)] {
        let hit = geometry.intersect(&Ray::new(Vec3::new(0.0, 0.0, z), Vec3::Z, 0.0), &opaque);
        assert_eq!(hit.unwrap().surface.p.z, expected);
    }
}
