//! Ten million rays at edges and vertices of closed meshes: none may slip through.
//!
//! A ray from inside must hit; so must one from far outside that ends inside, wherever it is aimed.
//! Both hold for any closed surface, and need no tolerance. The points aimed at are on edges and
//! vertices to double precision, the rays are rounded to single: they pass within a rounding error
//! on either side, which is where a test that is not watertight loses some.

use fstop::accel::{Geometry, GeometryBuilder, PrimitiveAttributes};
use fstop::assets::mesh::MeshData;
use fstop::handles::ObjectId;
use fstop::inputs::FloatInput;
use fstop::math::hash::{mix2, unit_float};
use fstop::math::ray::Ray;
use fstop::math::transform::Transform;
use fstop::math::{DVec3, Vec3};
use fstop::shapes::CompiledShape;
use fstop::shapes::mesh::TriangleMesh;
use fstop::surface::TexturePoint;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Rays for every mesh in every place; with the ten places below, ten million for two meshes.
const RAYS: usize = 500_000;

fn opaque(_: &FloatInput, _: &TexturePoint) -> f32 {
    1.0
}

/// A closed surface about the origin over a grid of directions, as far in each as `radius` says. Its
/// poles are fans of long thin triangles. Everything within 0.5 of the origin is inside.
fn closed(rings: usize, radius: impl Fn(f64, f64) -> f64) -> MeshData {
    let around = 2 * rings;
    let mut data = MeshData::default();
    let mut add = |theta: f64, phi: f64| {
        let across = DVec3::new(phi.cos(), phi.sin(), 0.0) * theta.sin();
        data.positions
            .push((across - DVec3::Z * theta.cos()) * radius(theta, phi));
    };
    add(0.0, 0.0);
    for i in 1..rings {
        for j in 0..around {
            add(PI * i as f64 / rings as f64, TAU * j as f64 / around as f64);
        }
    }
    add(PI, 0.0);
    let top = data.positions.len() as u32 - 1;
    let at = |i: usize, j: usize| (1 + (i - 1) * around + j % around) as u32;
    for j in 0..around {
        data.indices.push([0, at(1, j + 1), at(1, j)]);
        for i in 1..rings - 1 {
            data.indices
                .push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
            data.indices
                .push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
        }
        data.indices
            .push([top, at(rings - 1, j), at(rings - 1, j + 1)]);
    }
    data
}

fn compiled(data: &MeshData, place: &Transform) -> CompiledShape {
    CompiledShape::Mesh(Box::new(TriangleMesh::new(data.clone(), place, false)))
}

/// The mesh itself in render space.
fn placed(data: &MeshData, place: &Transform) -> Geometry {
    let mut builder = GeometryBuilder::default();
    builder.add(compiled(data, place), PrimitiveAttributes::default());
    builder.build(vec![]).expect("not too many triangles")
}

/// The mesh at `object` in an object, seen through an instance at `place`.
fn instanced(data: &MeshData, object: &Transform, place: &Transform) -> Geometry {
    let mut inner = GeometryBuilder::of_object();
    inner.add(compiled(data, object), PrimitiveAttributes::default());
    let mut builder = GeometryBuilder::default();
    builder.add_instance(ObjectId(0), place);
    builder.build(vec![inner]).expect("not too many triangles")
}

/// Where something is on the mesh: half the rays are aimed at vertices, half at edges.
fn target(data: &MeshData, i: u64) -> DVec3 {
    let draw = |k: u64| mix2(i, k);
    let triangle = data.indices[draw(10) as usize % data.indices.len()];
    let side = draw(11) as usize % 3;
    let corner = |k: usize| data.positions[triangle[(side + k) % 3] as usize];
    if i.is_multiple_of(2) {
        corner(0)
    } else {
        corner(0).lerp(corner(1), f64::from(unit_float(draw(12))))
    }
}

/// How many of the rays get through.
fn leaks(geometry: &Geometry, data: &MeshData, render_from_mesh: &Transform, seed: u64) -> usize {
    let leaks = |i: u64| {
        let i = mix2(seed, i);
        let draw = |k: u64| f64::from(2.0 * unit_float(mix2(i, k)) - 1.0);
        // Well inside, also after rounding.
        let inside = DVec3::new(draw(0), draw(1), draw(2)) * 0.25;
        let through = target(data, i) - inside;
        let place = |p: DVec3| render_from_mesh.point(p).as_vec3();
        let (from_inside, any) = (mix2(i, 3) & 1 == 0, mix2(i, 4) & 1 == 0);
        let (o, end) = if from_inside {
            (place(inside), place(inside + through))
        } else {
            // Beyond every mesh below.
            (place(inside + through.normalize() * 4.0), place(inside))
        };
        let d: Vec3 = (end - o).normalize();
        let mut ray = Ray::new(o, d, 0.0);
        if !from_inside {
            ray.t_max = (end - o).length();
        }
        if any {
            !geometry.occluded(&ray, &opaque)
        } else {
            geometry.distance(&ray, &opaque).is_none()
        }
    };
    (0..RAYS as u64)
        .into_par_iter()
        .filter(|&i| leaks(i))
        .count()
}

#[test]
fn ten_million_rays_at_edges_and_vertices_stay_on_their_side() {
    let meshes = [
        // Bumps, and a smooth one with triangles a hundred times finer at the poles.
        closed(72, |theta, phi| {
            1.0 + 0.1 * (5.0 * phi).sin() * (7.0 * theta).sin() * theta.sin()
        }),
        closed(150, |theta, _| 0.8 + 0.2 * theta.cos()),
    ];
    let turned = Transform::rotate(33.0, DVec3::new(1.0, 2.0, 3.0));
    let moved = |d: f64| Transform::translate(DVec3::new(d, -0.7 * d, 0.4 * d));
    let scaled = |s: f64| Transform::scale(DVec3::splat(s));
    let uneven = Transform::scale(DVec3::new(-1.0, 0.05, 30.0));
    let mut job = 0;
    for (m, data) in meshes.iter().enumerate() {
        let seed = |place: u64| 100 * m as u64 + place;
        let in_render_space = [
            Transform::IDENTITY,
            turned * scaled(1e-6),
            turned * scaled(1e6),
            moved(100.0) * turned,
            // A million units away, where single precision has steps of 1/16: a mesh that shows there.
            moved(1e6) * scaled(1e4),
            turned * uneven,
        ];
        for (number, place) in in_render_space.iter().enumerate() {
            let geometry = placed(data, place);
            let leaks = leaks(&geometry, data, place, seed(number as u64));
            assert_eq!(leaks, 0, "mesh {m}, place {number}");
            job += RAYS;
        }
        let instances = [
            (Transform::IDENTITY, moved(1e6) * turned * scaled(10.0)),
            (moved(1e6), turned * moved(-1e6)),
            (scaled(1e-6), moved(10.0) * turned * uneven * scaled(1e6)),
            (turned, moved(1e-5) * uneven * scaled(1e-6)),
        ];
        for (number, (object, place)) in instances.iter().enumerate() {
            let geometry = instanced(data, object, place);
            let whole = *place * *object;
            let leaks = leaks(&geometry, data, &whole, seed(50 + number as u64));
            assert_eq!(leaks, 0, "mesh {m}, instance {number}");
            job += RAYS;
        }
    }
    assert!(job >= 10_000_000, "{job}");
}
