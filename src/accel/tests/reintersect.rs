//! Rays that start on a surface do not intersect it again at their origin.

use super::*;
use crate::shapes::curve::{Bezier, CurveKind, CurveSpec};
use crate::shapes::cylinder::Cylinder;
use crate::shapes::disk::Disk;
use crate::shapes::hyperboloid::Hyperboloid;
use crate::shapes::paraboloid::Paraboloid;

/// Spawns rays to both sides of hits on a convex closed surface: outward ones hit nothing, inward ones the other side.
fn check_convex(geometry: &mut Geometry, center: Vec3, size: f32, random: &mut Random) {
    let mut inside = 0;
    for i in 0..2000 {
        geometry.set_bare(i % 2 == 0);
        let o = center + random.direction() * size * 3.0;
        let target = center + random.cube() * 0.5 * size;
        let ray = Ray::new(o, (target - o).normalize(), 0.0);
        let Some(hit) = geometry.intersect(&ray, &opaque) else {
            continue;
        };
        let s = &hit.surface;
        for _ in 0..4 {
            let mut d = random.direction();
            if random.next() < 0.5 {
                // Almost along the surface.
                d = (d - s.n * s.n.dot(d) * 0.9999).normalize();
            }
            let spawned = s.spawn_ray(d);
            let again = geometry.intersect(&spawned, &opaque);
            if d.dot(s.n) > 0.0 {
                assert!(again.is_none(), "{s:?} {d} {again:?}");
            } else if d.dot(s.n) < -0.01 {
                inside += 1;
                let again = again.expect("the far side");
                // Another face may be as near as the edge.
                let same_face = again.surface.n.dot(s.n) > 0.9;
                assert!(again.t > 1e-3 * size || !same_face, "{} at {size}", again.t);
            }
        }
        // The light's end of a shadow ray.
        let from = crate::surface::ReferencePoint {
            p: o,
            ..Default::default()
        };
        assert!(!geometry.occluded(&from.shadow_ray_to(s.p, s.p_error, s.n), &opaque));
    }
    assert!(inside > 1000);
}

fn placements() -> Vec<(Transform, f64)> {
    let mut placements = Vec::new();
    let turned = Transform::rotate(77.0, DVec3::new(-1.0, 2.0, 0.3));
    for scale in [1e-4, 1e-2, 1.0, 1e3, 1e6] {
        for away in [0.0, 10.0, 1000.0] {
            let moved = Transform::translate(DVec3::new(1.0, -0.6, 0.8) * away * scale);
            placements.push((
                moved * turned * Transform::scale(DVec3::splat(scale)),
                scale,
            ));
        }
    }
    placements
}

/// A cube, convex and with large triangles.
fn cube() -> MeshData {
    let positions = (0..8)
        .map(|i| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64) * 1.2 - 0.6)
        .collect();
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [d, a, c]];
    mesh(positions, quads.into_iter().flat_map(halves).collect())
}

#[test]
fn triangles_at_every_scale() {
    let mut random = Random(11);
    for (transform, scale) in placements() {
        let center = transform.point(DVec3::ZERO).as_vec3();
        check_convex(
            &mut scene(vec![compiled(&cube(), &transform)]),
            center,
            scale as f32,
            &mut random,
        );
    }
}

#[test]
fn spheres_at_every_scale() {
    let mut random = Random(12);
    for (transform, scale) in placements() {
        let center = transform.point(DVec3::ZERO).as_vec3();
        check_convex(
            &mut scene(vec![full_sphere(transform)]),
            center,
            scale as f32,
            &mut random,
        );
        // An ellipsoid.
        let uneven = transform * Transform::scale(DVec3::new(1.0, 0.7, 1.3));
        check_convex(
            &mut scene(vec![full_sphere(uneven)]),
            center,
            scale as f32,
            &mut random,
        );
    }
}

fn quadric(form: Form, transform: Transform) -> CompiledShape {
    CompiledShape::Quadric(Box::new(Quadric::new(form, transform, false)))
}

#[test]
fn paraboloids_at_every_scale() {
    let mut random = Random(17);
    for (transform, scale) in placements() {
        // A bowl with a lid, about the point that is halfway up.
        let place = transform * Transform::translate(DVec3::new(0.0, 0.0, -0.6));
        let bowl = Form::Paraboloid(Paraboloid::new(0.9, 0.0, 1.2, 360.0));
        let lid = Form::Disk(Disk::new(1.2, 0.9, 0.0, 360.0));
        let mut geometry = scene(vec![quadric(bowl, place), quadric(lid, place)]);
        let center = transform.point(DVec3::ZERO).as_vec3();
        check_convex(&mut geometry, center, scale as f32, &mut random);
        // Nothing leaks out, neither at the rim nor at the apex.
        for _ in 0..500 {
            let ray = Ray::new(center, random.direction(), 0.0);
            assert!(geometry.occluded(&ray, &opaque));
        }
    }
}

#[test]
fn sizes_of_a_scene_files_own_numbers_are_like_scaled_ones() {
    // Radii from 1e-6 to 1e7 in the parameters rather than in the transformation.
    let mut random = Random(18);
    for r in [1e-6, 1e-3, 1.0, 1e4, 1e7] {
        let away = DVec3::new(1.0, -0.6, 0.8) * 20.0 * r;
        let place = Transform::translate(away);
        let lowered = Transform::translate(away - DVec3::new(0.0, 0.0, 0.6 * r));
        let closed = [
            vec![quadric(Form::Sphere(Sphere::new(r, -r, r, 360.0)), place)],
            vec![
                quadric(
                    Form::Cylinder(Cylinder::new(0.7 * r, -0.7 * r, 0.7 * r, 360.0)),
                    place,
                ),
                quadric(Form::Disk(Disk::new(0.7 * r, 0.7 * r, 0.0, 360.0)), place),
                CompiledShape::Quadric(Box::new(Quadric::new(
                    // Its own normal points up, into the body.
                    Form::Disk(Disk::new(-0.7 * r, 0.7 * r, 0.0, 360.0)),
                    place,
                    true,
                ))),
            ],
            vec![
                quadric(
                    Form::Paraboloid(Paraboloid::new(0.9 * r, 0.0, 1.2 * r, 360.0)),
                    lowered,
                ),
                quadric(Form::Disk(Disk::new(1.2 * r, 0.9 * r, 0.0, 360.0)), lowered),
            ],
        ];
        for shapes in closed {
            check_convex(&mut scene(shapes), away.as_vec3(), r as f32, &mut random);
        }
    }
}

#[test]
fn hyperboloids_at_every_scale() {
    let mut random = Random(19);
    let ends = [DVec3::new(0.5, -0.6, -0.7), DVec3::new(0.5, 0.6, 0.7)];
    let form = Form::Hyperboloid(Hyperboloid::new(ends[0], ends[1], 360.0).unwrap());
    let mut met = 0;
    for (transform, scale) in placements() {
        let geometry = scene(vec![quadric(form, transform)]);
        let axis = transform.vector(DVec3::Z).normalize().as_vec3();
        for _ in 0..500 {
            let o = transform
                .point((random.direction() * 3.0).as_dvec3())
                .as_vec3();
            let target = transform.point((random.cube() * 0.5).as_dvec3()).as_vec3();
            let ray = Ray::new(o, (target - o).normalize(), 0.0);
            let Some(hit) = geometry.intersect(&ray, &opaque) else {
                continue;
            };
            met += 1;
            // A horizontal section is a circle: outward in that plane there is nothing, however nearly tangential, and
            // inward there is the other side.
            let s = &hit.surface;
            let outward = (s.n - axis * s.n.dot(axis)).normalize();
            let along = axis.cross(outward);
            let lean = random.next() * 2.0 - 1.0;
            let d = (along * lean + outward * (1.0 - lean.abs()).max(1e-3)).normalize();
            assert!(
                !geometry.occluded(&s.spawn_ray(d), &opaque),
                "{s:?} {d} {scale}"
            );
            let across = geometry.intersect(&s.spawn_ray(-outward), &opaque);
            let across = across.expect("the other side");
            assert!(f64::from(across.t) > 0.5 * scale);
        }
    }
    assert!(met > 2000, "{met}");
}

#[test]
fn curves_at_every_scale() {
    let mut random = Random(20);
    let mut met = 0;
    for (transform, scale) in placements() {
        let straight = [-3.0, -1.0, 1.0, 3.0].map(|y| DVec3::new(0.0, y / 3.0, 0.0));
        let spec = CurveSpec {
            kind: CurveKind::Flat,
            segments: vec![Bezier(straight)],
            normals: vec![],
            width: [0.02; 2],
            split_depth: 3,
        };
        let curve = CompiledShape::Curves(Box::new(spec.place(&transform, false)));
        let geometry = scene(vec![curve]);
        for _ in 0..500 {
            let o = transform
                .point((random.direction() * 3.0).as_dvec3())
                .as_vec3();
            let on = DVec3::new(0.0, f64::from(random.next()) * 1.8 - 0.9, 0.0);
            let near = on + (random.cube() * 0.004).as_dvec3();
            let target = transform.point(near).as_vec3();
            let ray = Ray::new(o, (target - o).normalize(), 0.0);
            // Far away, single precision cannot resolve the width.
            if scale * 0.004 < f64::from(target.length()) * 4.0 * f64::from(f32::EPSILON) {
                continue;
            }
            let hit = geometry.intersect(&ray, &opaque).expect("the curve");
            met += 1;
            let mut d = random.direction();
            if d.dot(hit.surface.n) > 0.0 {
                d = -d;
            }
            // The ribbon's normal points along the ray that hit it: backward is the other side.
            assert!(!geometry.occluded(&hit.surface.spawn_ray(d), &opaque));
        }
    }
    assert!(met > 3000, "{met}");
}

#[test]
fn instances_at_every_scale() {
    let mut random = Random(13);
    for (transform, scale) in placements() {
        let center = transform.point(DVec3::ZERO).as_vec3();
        // The object itself is large and far from its origin.
        let far = Transform::translate(DVec3::new(5e4, 1e4, -3e4))
            * Transform::scale(DVec3::splat(100.0));
        let place = transform * far.inverted();
        let mut geometry = instanced(vec![compiled(&cube(), &far)], &place);
        check_convex(&mut geometry, center, scale as f32, &mut random);
        let mut geometry = instanced(vec![full_sphere(far)], &place);
        check_convex(&mut geometry, center, scale as f32, &mut random);
    }
}

#[test]
fn a_ground_of_a_million_units_is_there_a_hundredth_below() {
    let s = 1e6;
    let plane = mesh(
        vec![
            DVec3::new(-s, -s, 0.0),
            DVec3::new(s, -s, 0.0),
            DVec3::new(0.3 * s, s, 0.0),
        ],
        vec![[0, 1, 2]],
    );
    let disk = CompiledShape::Quadric(Box::new(Quadric::new(
        Form::Disk(Disk::new(0.0, s, 0.0, 360.0)),
        Transform::IDENTITY,
        false,
    )));
    let mut random = Random(14);
    for ground in [compiled(&plane, &Transform::IDENTITY), disk] {
        // Marbles of a hundredth, a hundredth above the ground.
        let marble = |x: f64| {
            full_sphere(
                Transform::translate(DVec3::new(x, 0.0, 0.02))
                    * Transform::scale(DVec3::splat(0.01)),
            )
        };
        let geometry = scene(vec![ground, marble(0.0), marble(1.0)]);
        for _ in 0..2000 {
            let x = random.next() * 100.0 + 2.0;
            let o = Vec3::new(x, random.next(), 0.01);
            let d = (random.direction() * Vec3::new(1.0, 1.0, 0.5) - Vec3::Z * 0.6).normalize();
            let Some(hit) = geometry.intersect(&Ray::new(o, d, 0.0), &opaque) else {
                assert!(d.z >= 0.0);
                continue;
            };
            assert_eq!(hit.surface.p.z, 0.0);
            // The point is on the ray, not merely somewhere on the plane.
            let expected = o.as_dvec3() - d.as_dvec3() * (f64::from(o.z) / f64::from(d.z));
            assert!((hit.surface.p.as_dvec3() - expected).length() < 1e-7 * expected.length());
            assert!(
                geometry
                    .intersect(&hit.surface.spawn_ray(Vec3::Z), &opaque)
                    .is_none()
            );
        }
        // The marble hides the ground below it, and the ground is seen beside it.
        let from_above = |x: f32| {
            geometry.intersect(&Ray::new(Vec3::new(x, 0.0, 5.0), Vec3::NEG_Z, 0.0), &opaque)
        };
        assert!((from_above(0.001).unwrap().surface.p.z - 0.03).abs() < 1e-3);
        assert_eq!(from_above(0.02).unwrap().surface.p.z, 0.0);
        // From under the marble up, and down to the ground's contact shadow.
        let under = Ray::new(Vec3::new(0.0, 0.0, 0.005), Vec3::Z, 0.0);
        assert!((geometry.intersect(&under, &opaque).unwrap().t - 0.005).abs() < 1e-6);
    }
}

#[test]
fn an_open_cylinder_sees_its_inside() {
    let form = Form::Cylinder(Cylinder::new(1.0, -1.0, 1.0, 360.0));
    let transform = Transform::translate(DVec3::splat(300.0)) * Transform::scale(DVec3::splat(0.1));
    let geometry = scene(vec![CompiledShape::Quadric(Box::new(Quadric::new(
        form, transform, false,
    )))]);
    let center = Vec3::splat(300.0);
    let mut random = Random(15);
    for _ in 0..2000 {
        let across = (random.direction() * Vec3::new(1.0, 1.0, 0.0)).normalize();
        let hit = geometry
            .intersect(&Ray::new(center, across, 0.0), &opaque)
            .unwrap();
        // 300 has a spacing of 3e-5, and an offset is two or three of those.
        assert!((hit.t - 0.1).abs() < 2e-4);
        let back = geometry
            .intersect(&hit.surface.spawn_ray(-across), &opaque)
            .unwrap();
        assert!((back.t - 0.2).abs() < 2e-4);
        assert!(
            geometry
                .intersect(&hit.surface.spawn_ray(across), &opaque)
                .is_none()
        );
    }
}

/// A disk in the plane through the camera: its height is nearly 0 after translations that cancel, and rays must still
/// leave it (they once hit it again: `light_area_disk_sphere` rendered without reflected light).
#[test]
fn rays_leave_a_disk_at_the_cameras_own_height() {
    let mut random = Random(16);
    for away in [3.0, 1e6 + 0.1] {
        let place =
            Transform::translate(DVec3::new(-1.5, away, 0.0)) * Transform::rotate(90.0, DVec3::X);
        let disk = Form::Disk(Disk::new(0.0, 0.8, 0.0, 360.0));
        let camera = DVec3::new(0.0, away, -6.0);
        let seen = Transform::translate(-camera) * place;
        let alone = CompiledShape::Quadric(Box::new(Quadric::new(disk, seen, false)));
        let object = CompiledShape::Quadric(Box::new(Quadric::new(disk, place, false)));
        let copied = instanced(vec![object], &Transform::translate(-camera));
        for geometry in [scene(vec![alone]), copied] {
            let center = Vec3::new(-1.5, 0.0, 6.0);
            let o = center - Vec3::Y * 3.0;
            for _ in 0..2000 {
                let target = center + random.cube() * Vec3::new(0.5, 0.0, 0.5);
                let ray = Ray::new(o, (target - o).normalize(), 0.0);
                let hit = geometry.intersect(&ray, &opaque).expect("the disk");
                let spawned = hit.surface.spawn_ray(random.direction());
                assert!(geometry.intersect(&spawned, &opaque).is_none());
            }
        }
    }
}
