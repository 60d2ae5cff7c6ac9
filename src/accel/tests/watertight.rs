//! Watertightness: no ray from inside a closed surface may leave it, wherever it is aimed.

use super::*;

/// Aims rays from points inside at every vertex, at points on every edge, and at the centers of triangles.
fn leaks(
    geometry: &Geometry,
    data: &MeshData,
    render_from_object: &Transform,
    random: &mut Random,
) -> usize {
    let place = |p: DVec3| render_from_object.point(p).as_vec3();
    let mut leaks = 0;
    for t in &data.indices {
        let corners = t.map(|i| data.positions[i as usize]);
        let origin = place((random.cube() * 0.4).as_dvec3());
        let s = f64::from(random.next());
        let targets = [
            corners[0],
            corners[0].lerp(corners[1], s),
            corners[1].lerp(corners[2], s),
            (corners[0] + corners[1] + corners[2]) / 3.0,
        ];
        for target in targets {
            let ray = Ray::new(origin, (place(target) - origin).normalize(), 0.0);
            let hit = geometry.intersect(&ray, &opaque);
            leaks += usize::from(hit.is_none());
            // The two searches agree.
            assert_eq!(hit.is_some(), geometry.occluded(&ray, &opaque));
        }
    }
    leaks
}

#[test]
fn closed_meshes_do_not_leak() {
    // 8 placements × 20,000 triangles × 4 rays.
    let data = ball(72);
    let mut random = Random(1);
    let turned = Transform::rotate(33.0, DVec3::new(1.0, 2.0, 3.0));
    let moved = |d: f64| Transform::translate(DVec3::new(d, -0.7 * d, 0.4 * d));
    for scale in [1e-6, 1.0, 1e6] {
        let transform = turned * Transform::scale(DVec3::splat(scale));
        let geometry = scene(vec![compiled(&data, &transform)]);
        assert_eq!(leaks(&geometry, &data, &transform, &mut random), 0);
    }
    for transform in [Transform::IDENTITY, moved(100.0), moved(1000.0) * turned] {
        let geometry = scene(vec![compiled(&data, &transform)]);
        assert_eq!(leaks(&geometry, &data, &transform, &mut random), 0);
    }
    // An object far from its own origin, squeezed, mirrored and turned into place.
    let far = moved(1e4);
    let squeezed = Transform::scale(DVec3::new(-1.0, 0.01, 30.0));
    let place = moved(10.0) * turned * squeezed * far.inverted();
    let geometry = instanced(vec![compiled(&data, &far)], &place);
    assert_eq!(leaks(&geometry, &data, &(place * far), &mut random), 0);
}

#[test]
fn rays_along_the_axes_and_in_the_planes_of_boxes_do_not_leak() {
    // A box cut into a grid, so that axis-parallel rays run exactly along edges, through vertices
    // and in the planes of bounding boxes.
    let n = 8;
    let mut data = MeshData::default();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            for i in 0..n * n {
                let at = |di: usize, dj: usize| {
                    let u = 2.0 * (i % n + di) as f64 / n as f64 - 1.0;
                    let v = 2.0 * (i / n + dj) as f64 / n as f64 - 1.0;
                    let mut p = DVec3::splat(side);
                    p[(axis + 1) % 3] = u;
                    p[(axis + 2) % 3] = v;
                    p
                };
                let first = data.positions.len() as u32;
                data.positions
                    .extend([at(0, 0), at(1, 0), at(1, 1), at(0, 1)]);
                data.indices
                    .extend([[first, first + 1, first + 2], [first + 3, first, first + 2]]);
            }
        }
    }
    let geometry = scene(vec![compiled(&data, &Transform::IDENTITY)]);
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            // Other components: +0, −0, too small to matter, and small enough to nearly.
            for zero in [0.0f32, -0.0, 1e-40, -1e-33, 1e-20, -1e-12] {
                let mut d = Vec3::splat(zero);
                d[axis] = sign;
                for i in 0..=n {
                    for j in 0..=n {
                        let mut o = Vec3::ZERO;
                        // At the very ends the ray runs in the plane of two sides of the box; stay inside.
                        o[(axis + 1) % 3] = (2.0 * i as f32 / n as f32 - 1.0) * 0.999_999;
                        o[(axis + 2) % 3] = 2.0 * j as f32 / n as f32 - 1.0;
                        if i % n != 0 {
                            o[(axis + 1) % 3] = 2.0 * i as f32 / n as f32 - 1.0;
                        }
                        if j % n == 0 {
                            o[(axis + 2) % 3] *= 0.999_999;
                        }
                        let hit = geometry.intersect(&Ray::new(o, d, 0.0), &opaque).unwrap();
                        assert!((hit.t - 1.0).abs() < 1e-5);
                    }
                }
            }
        }
    }
}
