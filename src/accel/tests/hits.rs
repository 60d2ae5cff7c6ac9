//! What a hit reports: orientation, attributes, cut-outs, instances.

use super::*;
use crate::handles::FloatTextureId;

fn triangle(normals: Vec<Vec3>) -> MeshData {
    MeshData {
        normals,
        ..mesh(
            vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0)],
            vec![[0, 1, 2]],
        )
    }
}

/// The normals of a hit on the triangle, viewed along its z axis.
fn normals(
    data: &MeshData,
    transform: &Transform,
    reverse: bool,
    instance: Option<Transform>,
) -> (Vec3, Vec3) {
    let shape = CompiledShape::Mesh(Box::new(TriangleMesh::new(
        data.clone(),
        transform,
        reverse,
    )));
    let (geometry, place) = match instance {
        None => (scene(vec![shape]), *transform),
        Some(instance) => (instanced(vec![shape], &instance), instance * *transform),
    };
    let target = place.point(DVec3::new(0.6, 0.3, 0.0)).as_vec3();
    let o = place.point(DVec3::new(0.6, 0.3, 2.0)).as_vec3();
    let hit = geometry
        .intersect(&Ray::new(o, (target - o).normalize(), 0.0), &opaque)
        .unwrap();
    assert!((hit.surface.p - target).length() < 1e-6);
    (hit.surface.n, hit.surface.shading.n)
}

#[test]
fn orientation_follows_the_table() {
    // docs/scene-language.md §4.4.
    let mirror = Transform::scale(DVec3::new(-1.0, 1.0, 1.0));
    let same = Transform::IDENTITY;
    let (up, down) = (Vec3::Z, Vec3::NEG_Z);
    // Without N: the corners' order in world space, negated by ReverseOrientation XOR mirror, so
    // that a mirror alone changes nothing.
    for (transform, reverse, n) in [
        (same, false, up),
        (same, true, down),
        (mirror, false, up),
        (mirror, true, down),
    ] {
        assert_eq!(
            normals(&triangle(vec![]), &transform, reverse, None),
            (n, n)
        );
    }
    // With N: the shading normal, negated by ReverseOrientation alone; the geometric one follows.
    for (transform, reverse, n) in [
        (same, false, down),
        (same, true, up),
        (mirror, false, down),
        (mirror, true, up),
    ] {
        assert_eq!(
            normals(&triangle(vec![down; 3]), &transform, reverse, None),
            (n, n)
        );
    }
    // A mirrored instance: the normal is moved as it is, the shading normal to its side.
    let flip_z = Transform::scale(DVec3::new(1.0, 1.0, -1.0));
    assert_eq!(
        normals(&triangle(vec![]), &same, false, Some(mirror)),
        (up, up)
    );
    assert_eq!(
        normals(&triangle(vec![]), &same, false, Some(flip_z)),
        (down, down)
    );
    assert_eq!(
        normals(&triangle(vec![down; 3]), &same, false, Some(flip_z)),
        (up, up)
    );
}

#[test]
fn lights_and_materials_come_back() {
    let data = mesh(
        vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0)],
        vec![[0, 1, 1], [0, 1, 2], [1, 3, 2]],
    );
    let mut builder = GeometryBuilder::default();
    let attributes = PrimitiveAttributes {
        light: Some(LightId(10)),
        material: Some(MaterialId(3)),
        ..Default::default()
    };
    builder.add(compiled(&data, &Transform::IDENTITY), attributes);
    let moved = Transform::translate(DVec3::new(5.0, 0.0, 0.0));
    builder.add(
        full_sphere(moved),
        PrimitiveAttributes {
            light: Some(LightId(20)),
            ..Default::default()
        },
    );
    builder.add(
        compiled(&data, &Transform::translate(DVec3::Y * 5.0)),
        PrimitiveAttributes::default(),
    );
    let mut object = GeometryBuilder::of_object();
    object.add(full_sphere(Transform::IDENTITY), attributes);
    let beside = Transform::translate(DVec3::X * 2.0);
    object.add(full_sphere(beside), PrimitiveAttributes::default());
    builder.add_instance(ObjectId(0), &Transform::translate(DVec3::Y * -5.0));
    let geometry = builder.build(vec![object]).unwrap();
    let at = |x: f32, y: f32| {
        let ray = Ray::new(Vec3::new(x, y, 3.0), Vec3::NEG_Z, 0.0);
        let hit = geometry.intersect(&ray, &opaque).unwrap();
        match geometry.intersect_emitter(&ray, &opaque) {
            EmitterHit::Emitter(seen) => assert_eq!((seen.light, seen.t), (hit.light, hit.t)),
            EmitterHit::NotEmissive => assert_eq!(hit.light, None),
            EmitterHit::Escaped => panic!("something is there"),
        }
        (hit.light, hit.material)
    };
    // The triangle without area keeps its index.
    assert_eq!(at(0.2, 0.2), (Some(LightId(11)), Some(MaterialId(3))));
    assert_eq!(at(0.8, 0.8), (Some(LightId(12)), Some(MaterialId(3))));
    assert_eq!(at(5.0, 0.0), (Some(LightId(20)), None));
    assert_eq!(at(0.2, 5.2), (None, None));
    assert_eq!(at(0.0, -5.0), (Some(LightId(10)), Some(MaterialId(3))));
    assert_eq!(at(2.0, -5.0), (None, None));
    let away = Ray::new(Vec3::new(0.2, 0.2, 3.0), Vec3::Z, 0.0);
    assert!(matches!(
        geometry.intersect_emitter(&away, &opaque),
        EmitterHit::Escaped
    ));
}

#[test]
fn cut_outs_let_rays_through_where_alpha_is_zero() {
    let sheet = mesh(
        vec![DVec3::ZERO, DVec3::X * 2.0, DVec3::new(2.0, 2.0, 0.0)],
        vec![[0, 1, 2]],
    );
    let below = Transform::translate(DVec3::new(0.0, 0.0, -1.0));
    let build = |alpha, shadow_alpha, as_instance: bool| {
        let attributes = PrimitiveAttributes {
            alpha,
            shadow_alpha,
            ..Default::default()
        };
        let mut builder = GeometryBuilder::default();
        builder.add(compiled(&sheet, &below), PrimitiveAttributes::default());
        let mut object = GeometryBuilder::of_object();
        if as_instance {
            object.add(compiled(&sheet, &Transform::IDENTITY), attributes);
            builder.add_instance(ObjectId(0), &Transform::IDENTITY);
        } else {
            builder.add(compiled(&sheet, &Transform::IDENTITY), attributes);
        }
        builder.build(vec![object]).unwrap()
    };
    // Holes where u > 0.75, small but not zero elsewhere.
    let alpha = |input: &FloatInput, p: &TexturePoint| match input {
        FloatInput::Constant(value) => *value,
        FloatInput::Texture(_) => {
            assert!((p.uv.x - p.p.x / 2.0).abs() < 1e-6 && p.p.z == 0.0);
            if p.uv.x > 0.75 { 0.0 } else { 1e-20 }
        }
    };
    let texture = Some(FloatInput::Texture(FloatTextureId(0)));
    let ray = |x: f32| Ray::new(Vec3::new(x, 0.1, 1.0), Vec3::NEG_Z, 0.0);
    let short = |x: f32| Ray {
        t_max: 1.5,
        ..ray(x)
    };
    for as_instance in [false, true] {
        let geometry = build(texture, None, as_instance);
        assert_eq!(geometry.intersect(&ray(1.0), &alpha).unwrap().t, 1.0);
        assert_eq!(geometry.intersect(&ray(1.8), &alpha).unwrap().t, 2.0);
        assert!(geometry.occluded(&short(1.0), &alpha) && !geometry.occluded(&short(1.8), &alpha));
        // Shadow alpha is for shadow rays only.
        let geometry = build(None, texture, as_instance);
        assert_eq!(geometry.intersect(&ray(1.8), &alpha).unwrap().t, 1.0);
        assert!(geometry.occluded(&short(1.0), &alpha) && !geometry.occluded(&short(1.8), &alpha));
        // Constants: 0 cuts everything, anything else nothing.
        let geometry = build(Some(FloatInput::Constant(0.0)), None, as_instance);
        assert_eq!(geometry.intersect(&ray(1.0), &alpha).unwrap().t, 2.0);
        let geometry = build(Some(FloatInput::Constant(0.3)), None, as_instance);
        assert_eq!(geometry.intersect(&ray(1.0), &alpha).unwrap().t, 1.0);
    }
}

#[test]
fn an_instance_is_what_it_would_be_in_place() {
    let object = Transform::rotate(20.0, DVec3::Y) * Transform::scale(DVec3::new(1.0, 0.6, 1.4));
    let place = Transform::translate(DVec3::new(3.0, -2.0, 5.0))
        * Transform::rotate(50.0, DVec3::new(1.0, 1.0, 0.0))
        * Transform::scale(DVec3::new(0.5, 2.0, 1.0));
    let mut data = ball(20);
    data.normals = data
        .positions
        .iter()
        .map(|p| p.as_vec3().normalize())
        .collect();
    data.uv = data
        .positions
        .iter()
        .map(|p| Vec2::new(p.x as f32, p.y as f32))
        .collect();
    for mesh_not_sphere in [true, false] {
        let shape = |t: &Transform| {
            if mesh_not_sphere {
                compiled(&data, t)
            } else {
                full_sphere(*t)
            }
        };
        let apart = instanced(vec![shape(&object)], &place);
        let in_place = scene(vec![shape(&(place * object))]);
        let mut random = Random(21);
        let mut hits = 0;
        for _ in 0..2000 {
            let o = random.direction() * 10.0 + Vec3::new(3.0, -2.0, 5.0);
            let ray = Ray::new(
                o,
                (Vec3::new(3.0, -2.0, 5.0) + random.cube() - o).normalize(),
                0.0,
            );
            let (a, b) = (
                apart.intersect(&ray, &opaque),
                in_place.intersect(&ray, &opaque),
            );
            let (Some(a), Some(b)) = (a, b) else { continue };
            // Silhouettes may go either way; shared edges change normals.
            if (a.t - b.t).abs() > 1e-5 || a.surface.n.dot(a.surface.wo).abs() < 0.02 {
                continue;
            }
            hits += 1;
            let (a, b) = (a.surface, b.surface);
            assert!((a.p - b.p).length() < 1e-4 && (a.uv - b.uv).length() < 1e-3);
            // Vertex normals are normalized either before or after the instance stretches them.
            assert!((a.shading.n - b.shading.n).length() < 0.05);
            if !mesh_not_sphere {
                assert!((a.n - b.n).length() < 1e-4);
                let near = |a: Vec3, b: Vec3| (a - b).length() < 1e-3 * (1.0 + a.length());
                assert!(near(a.dpdu, b.dpdu) && near(a.dpdv, b.dpdv));
                assert!(
                    near(a.shading.dndu, b.shading.dndu) && near(a.shading.dndv, b.shading.dndv)
                );
            }
        }
        assert!(hits > 1000, "{hits}");
    }
}

#[test]
fn a_small_object_is_sharp_from_far_away() {
    // A millimeter ball two kilometers from the ray's origin: the origin rounded to single
    // precision in the object's space would be a tenth of the ball off.
    let place = Transform::translate(DVec3::new(2000.0, 100.0, -30.0))
        * Transform::scale(DVec3::splat(1e-3));
    let geometry = instanced(vec![full_sphere(Transform::IDENTITY)], &place);
    let center = place.point(DVec3::ZERO);
    let d = center.normalize().as_vec3();
    let hit = geometry
        .intersect(&Ray::new(Vec3::ZERO, d, 0.0), &opaque)
        .unwrap();
    // Where the rounded direction passes the center, in radii.
    let pass = center.cross(d.as_dvec3().normalize()).length() / 1e-3;
    let sine = f64::from(hit.surface.n.cross(d).length());
    assert!((sine - pass).abs() < 1e-3, "{sine} {pass}");
}
