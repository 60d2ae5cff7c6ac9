//! Degenerate input.

use super::*;

fn down(x: f32, y: f32) -> Ray {
    Ray::new(Vec3::new(x, y, 5.0), Vec3::NEG_Z, 0.0)
}

#[test]
fn an_empty_scene_is_empty() {
    let geometry = scene(vec![]);
    assert!(geometry.intersect(&down(0.0, 0.0), &opaque).is_none());
    assert!(!geometry.occluded(&down(0.0, 0.0), &opaque));
    assert!(geometry.bounds().is_empty());
    assert_eq!(geometry.bounds().bounding_sphere(), (Vec3::ZERO, 0.0));
    // Instances of nothing, of an unknown object, and flattened ones.
    let mut builder = GeometryBuilder::default();
    builder.add_instance(ObjectId(0), &Transform::IDENTITY);
    builder.add_instance(ObjectId(7), &Transform::IDENTITY);
    builder.add_instance(ObjectId(0), &Transform::scale(DVec3::new(1.0, 1.0, 0.0)));
    let geometry = builder.build(vec![GeometryBuilder::of_object()]).unwrap();
    assert!(geometry.intersect(&down(0.0, 0.0), &opaque).is_none());
}

#[test]
fn one_triangle_is_hit_from_both_sides() {
    let data = mesh(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]]);
    let geometry = scene(vec![compiled(&data, &Transform::IDENTITY)]);
    let hit = geometry.intersect(&down(0.25, 0.25), &opaque).unwrap();
    assert_eq!(
        (hit.t, hit.surface.p, hit.surface.n),
        (5.0, Vec3::new(0.25, 0.25, 0.0), Vec3::Z)
    );
    let up = Ray::new(Vec3::new(0.25, 0.25, -1.0), Vec3::Z, 0.0);
    assert_eq!(geometry.intersect(&up, &opaque).unwrap().t, 1.0);
    // Not at or beyond t_max, not behind.
    assert!(
        geometry
            .intersect(&Ray { t_max: 1.0, ..up }, &opaque)
            .is_none()
    );
    assert!(
        geometry
            .intersect(
                &Ray {
                    d: Vec3::NEG_Z,
                    ..up
                },
                &opaque
            )
            .is_none()
    );
    assert_eq!(geometry.statistics().triangles, 1);
}

#[test]
fn triangles_without_area_or_with_wild_corners_are_left_out_and_counted() {
    let bad = [f64::NAN, f64::INFINITY, 1e300];
    let mut positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X * 2.0];
    positions.extend(bad.map(DVec3::splat));
    let data = mesh(
        positions,
        vec![
            [0, 1, 4],
            [0, 1, 2],
            [5, 1, 2],
            [0, 6, 2],
            [0, 1, 1],
            [0, 1, 3],
        ],
    );
    let geometry = scene(vec![compiled(&data, &Transform::IDENTITY)]);
    assert_eq!(geometry.statistics().skipped, 5);
    assert!(geometry.intersect(&down(0.25, 0.25), &opaque).is_some());
    // A mesh that its transformation flattens is still visible from above.
    let flat = Transform::scale(DVec3::new(1.0, 1.0, 0.0));
    assert!(
        scene(vec![compiled(&data, &flat)])
            .intersect(&down(0.25, 0.25), &opaque)
            .is_some()
    );
}

/// Each coordinate may be NaN, whatever the others are.
#[test]
fn corners_and_boxes_that_are_no_place_are_left_out() {
    for axis in 0..3 {
        let mut corner = DVec3::ONE;
        corner[axis] = f64::NAN;
        let data = mesh(vec![DVec3::ZERO, DVec3::X, corner], vec![[0, 1, 2]]);
        let geometry = scene(vec![compiled(&data, &Transform::IDENTITY)]);
        assert_eq!(geometry.statistics().skipped, 1);
        let mut away = DVec3::new(3.0, 2.0, 1.0);
        away[axis] = 1e300;
        let ball = |place| full_sphere(Transform::translate(place));
        let geometry = scene(vec![ball(away), ball(DVec3::ZERO), ball(away * f64::NAN)]);
        assert!(geometry.intersect(&down(0.0, 0.0), &opaque).is_some());
    }
}

#[test]
fn a_hundred_thousand_triangles_in_one_place_are_found() {
    // All boxes are equal, so a tree has no structure to follow.
    let data = mesh(
        vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        vec![[0, 1, 2]; 100_000],
    );
    let geometry = scene(vec![compiled(&data, &Transform::IDENTITY)]);
    assert_eq!(
        geometry.intersect(&down(0.25, 0.25), &opaque).unwrap().t,
        5.0
    );
    assert!(geometry.intersect(&down(0.75, 0.75), &opaque).is_none());
    assert!(geometry.occluded(&down(0.1, 0.1), &opaque));
}

/// Rows in which every box is nearest to the one before: the binary builder once took a pass for each (minutes for
/// these).
#[test]
fn long_rows_are_built_in_passing() {
    let count = 100_000;
    let row = |place: &dyn Fn(f64) -> (f64, f64)| {
        let corners = (0..count).flat_map(|i| {
            let (x, size) = place(f64::from(i));
            [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]
                .map(|(dx, dy)| DVec3::new(x + size * dx, size * dy, -size))
        });
        let indices = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        scene(vec![compiled(
            &mesh(corners.collect(), indices.collect()),
            &Transform::IDENTITY,
        )])
    };
    let equal = row(&|i| (2.0 * i, 1.0));
    let hit = equal.intersect(&down(2.0 * 77_777.0 + 0.25, 0.25), &opaque);
    assert_eq!(hit.expect("the row").t, 6.0);
    assert!(equal.intersect(&down(1.5, 0.25), &opaque).is_none());
    let growing = row(&|i| (i * i * 1e-3, 1e-3 * (i + 1.0)));
    assert!(growing.intersect(&down(40.0, 0.01), &opaque).is_some());
    // Nested, all with the right angle in the same place.
    let nested = row(&|i| (0.0, 1.0 + 1e-5 * i));
    let hit = nested.intersect(&down(0.25, 0.25), &opaque);
    assert_eq!(hit.expect("the smallest").t, 6.0);
}

#[test]
fn sizes_that_shrink_for_ever_do_not_overflow_the_stack() {
    // Nested triangles, each a little smaller than the last, around one point: the deepest trees.
    let mut positions = Vec::new();
    for i in 0..3000 {
        let s = 0.97f64.powi(i);
        positions.extend([
            DVec3::new(-s, -s, -s),
            DVec3::new(s, -s, s),
            DVec3::new(0.0, s, 0.3 * s),
        ]);
    }
    let indices = (0..3000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let data = mesh(positions, indices);
    let geometry = scene(vec![compiled(&data, &Transform::IDENTITY)]);
    let mut random = Random(3);
    for _ in 0..1000 {
        let o = random.cube() * 2.0;
        let ray = Ray::new(o, (random.cube() * 0.01 - o).normalize(), 0.0);
        assert_eq!(
            geometry.intersect(&ray, &opaque).is_some(),
            geometry.occluded(&ray, &opaque)
        );
    }
}

#[test]
fn coordinates_over_the_whole_range_neither_panic_nor_hang() {
    for scale in [1e-30, 1e-18, 1e15, 1e30] {
        let data = ball(8);
        let transform = Transform::scale(DVec3::splat(scale));
        let geometry = scene(vec![compiled(&data, &transform), full_sphere(transform)]);
        let mut random = Random(4);
        for _ in 0..100 {
            let ray = Ray::new(random.cube() * scale as f32, random.direction(), 0.0);
            if let Some(hit) = geometry.intersect(&ray, &opaque) {
                assert!(hit.t >= 0.0);
            }
        }
    }
    // Invalid rays.
    let geometry = scene(vec![
        compiled(&ball(8), &Transform::IDENTITY),
        full_sphere(Transform::IDENTITY),
    ]);
    for bad in [f32::NAN, f32::INFINITY, 0.0] {
        let _ = geometry.intersect(&Ray::new(Vec3::ZERO, Vec3::splat(bad), 0.0), &opaque);
        let _ = geometry.intersect(&Ray::new(Vec3::splat(bad), Vec3::X, 0.0), &opaque);
        let _ = geometry.occluded(
            &Ray {
                t_max: bad,
                ..Ray::new(Vec3::ZERO, Vec3::X, 0.0)
            },
            &opaque,
        );
    }
}
