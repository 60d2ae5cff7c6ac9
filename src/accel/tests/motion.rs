//! Moving objects against static ones placed where they are at the ray's time.

use super::*;
use crate::math::motion::Motion;

/// Various motions: translation, rotation, scaling, all of it far away.
fn motions() -> Vec<(Transform, Transform)> {
    let there = Transform::translate(DVec3::new(2.0, -1.0, 0.5));
    let turn = Transform::rotate(160.0, DVec3::new(1.0, 2.0, -0.5));
    let uneven = Transform::scale(DVec3::new(1.5, 0.7, 1.1));
    let far = Transform::translate(DVec3::new(3e4, -2e4, 1e4));
    vec![
        (Transform::IDENTITY, there),
        (turn, there),
        (uneven, there * turn * uneven),
        (far, far * there * turn),
    ]
}

/// A bumpy ball and a sphere beside it.
fn shapes(transform: &Transform) -> Vec<CompiledShape> {
    let aside =
        Transform::translate(DVec3::new(2.5, 0.0, 0.0)) * Transform::scale(DVec3::splat(0.6));
    vec![
        compiled(&ball(8), transform),
        full_sphere(*transform * aside),
    ]
}

/// Geometries with the shapes moving by themselves, with a moving object that holds them, and with moving shapes within
/// a static object.
fn moving(motion: Motion) -> [Geometry; 3] {
    let attributes = PrimitiveAttributes::default();
    let mut alone = GeometryBuilder::default();
    let mut nested = GeometryBuilder::of_object();
    let mut object = GeometryBuilder::of_object();
    for shape in shapes(&Transform::IDENTITY) {
        alone.add_moving(shape.clone(), attributes, motion);
        nested.add_moving(shape.clone(), attributes, motion);
        object.add(shape, attributes);
    }
    let mut whole = GeometryBuilder::default();
    whole.add_moving_instance(ObjectId(0), motion);
    let mut outer = GeometryBuilder::default();
    outer.add_instance(ObjectId(0), &Transform::IDENTITY);
    [
        alone.build(vec![]).unwrap(),
        whole.build(vec![object]).unwrap(),
        outer.build(vec![nested]).unwrap(),
    ]
}

#[test]
fn moving_things_are_where_they_are_at_the_rays_time() {
    let mut random = Random(11);
    for (start, end) in motions() {
        let motion = Motion::new(&start, &end, [1.0, 2.0]).unwrap();
        let moving = moving(motion);
        assert_eq!(moving[0].statistics().moving, 2);
        assert!(
            moving
                .iter()
                .all(|g| g.statistics().triangles == moving[0].statistics().triangles)
        );
        for time in [0.5, 1.0, 1.2, 1.5, 1.9, 2.0, 3.0f32] {
            let now = Transform::from_matrix(motion.at(f64::from(time)).into());
            let still = scene(shapes(&now));
            let (mut met, mut differ) = (0, 0);
            for _ in 0..300 {
                let from = now.point((random.direction() * 5.0).as_dvec3());
                let to = now.point((random.cube() * 2.0).as_dvec3());
                let (o, to) = (from.as_vec3(), to.as_vec3());
                let ray = Ray::new(o, (to - o).normalize(), time);
                let expected = still.intersect(&ray, &opaque);
                for geometry in &moving {
                    let found = geometry.intersect(&ray, &opaque);
                    assert_eq!(geometry.occluded(&ray, &opaque), found.is_some());
                    match (&found, &expected) {
                        (Some(a), Some(b)) => {
                            met += 1;
                            // Vertices are rounded elsewhere.
                            let scale = 1e-6 * (f64::from(o.length()) + 1.0);
                            let apart = (a.surface.p.as_dvec3() - b.surface.p.as_dvec3()).length();
                            differ += usize::from(apart > 30.0 * scale);
                            assert!(a.surface.time == time);
                        }
                        (None, None) => {}
                        _ => differ += 1,
                    }
                }
            }
            // Few rays in a thousand hit silhouettes and edges.
            assert!(met > 150 && differ < 5, "{met} {differ}");
        }
    }
}

#[test]
fn rays_leave_moving_surfaces_at_their_own_time() {
    // From points of the rotating ball outward along the normal, a convex body is not hit again.
    let mut random = Random(12);
    for (start, end) in motions() {
        let motion = Motion::new(&start, &end, [0.0, 1.0]).unwrap();
        let mut builder = GeometryBuilder::default();
        let sphere = full_sphere(Transform::IDENTITY);
        builder.add_moving(sphere, PrimitiveAttributes::default(), motion);
        let geometry = builder.build(vec![]).unwrap();
        for _ in 0..500 {
            let time = random.next();
            let center = motion.at(f64::from(time)).translation.as_vec3();
            let o = center + random.direction() * 3.0;
            let ray = Ray::new(o, (center - o).normalize(), time);
            let hit = geometry
                .intersect(&ray, &opaque)
                .expect("the sphere")
                .surface;
            let mut d = random.direction();
            if d.dot(hit.n) < 0.0 {
                d = -d;
            }
            assert!(!geometry.occluded(&hit.spawn_ray(d), &opaque));
            // Inward, the other side is.
            assert!(geometry.occluded(&hit.spawn_ray(-hit.n), &opaque));
        }
    }
}
