//! Whole geometries against closed forms, brute force and obvhs's own traversal.

use super::instance::Inner;
use super::*;
use crate::assets::mesh::MeshData;
use crate::handles::ObjectId;
use crate::math::hash::{mix2, unit_float};
use crate::math::sampling::uniform_sphere;
use crate::math::transform::Transform;
use crate::math::{DVec3, Vec2, Vec3};
use crate::shapes::CompiledShape;
use crate::shapes::mesh::TriangleMesh;
use crate::shapes::sphere::Sphere;
use crate::shapes::{Form, quadric::Quadric};

mod bounds;
mod degenerate;
mod few;
mod hair;
mod hits;
mod motion;
mod oracle;
mod reintersect;
mod watertight;

/// Alpha 1 everywhere.
fn opaque(_: &FloatInput, _: &TexturePoint) -> f32 {
    1.0
}

/// Deterministic pseudo-random numbers in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 += 1;
        unit_float(mix2(0x5eed, self.0))
    }

    fn pair(&mut self) -> Vec2 {
        Vec2::new(self.next(), self.next())
    }

    /// A point in the cube from −1 to 1.
    fn cube(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
    }

    fn direction(&mut self) -> Vec3 {
        uniform_sphere(self.pair())
    }
}

impl Geometry {
    /// Sets [`PrimitiveAttributes::bare`] everywhere.
    fn set_bare(&mut self, bare: bool) {
        let levels = self.objects.iter_mut().chain([&mut self.top]);
        levels.for_each(|level| set_bare(level, bare));
    }
}

fn set_bare(level: &mut Level, bare: bool) {
    level
        .meshes
        .iter_mut()
        .for_each(|mesh| mesh.attributes.bare = bare);
    level
        .quadrics
        .iter_mut()
        .for_each(|quadric| quadric.attributes.bare = bare);
    for instance in &mut level.instances {
        if let Inner::Shape(level) = &mut instance.inner {
            set_bare(level, bare);
        }
    }
}

fn compiled(data: &MeshData, transform: &Transform) -> CompiledShape {
    CompiledShape::Mesh(Box::new(TriangleMesh::new(data.clone(), transform, false)))
}

fn scene(shapes: Vec<CompiledShape>) -> Geometry {
    let mut builder = GeometryBuilder::of_world(true);
    for shape in shapes {
        builder.add(shape, PrimitiveAttributes::default());
    }
    builder.build(vec![]).unwrap()
}

/// The same shapes as an object, seen through one instance.
fn instanced(shapes: Vec<CompiledShape>, transform: &Transform) -> Geometry {
    let mut object = GeometryBuilder::of_object();
    for shape in shapes {
        object.add(shape, PrimitiveAttributes::default());
    }
    let mut builder = GeometryBuilder::default();
    builder.add_instance(ObjectId(0), transform);
    builder.build(vec![object]).unwrap()
}

/// A mesh from its triangles.
fn mesh(positions: Vec<DVec3>, indices: Vec<[u32; 3]>) -> MeshData {
    MeshData {
        indices,
        positions,
        ..MeshData::default()
    }
}

/// A closed bumpy ball about the origin: `n` rings of `2 n` quads.
fn ball(n: usize) -> MeshData {
    let around = 2 * n;
    let mut positions = vec![DVec3::NEG_Z];
    for i in 1..n {
        for j in 0..around {
            let theta = std::f64::consts::PI * i as f64 / n as f64;
            let phi = std::f64::consts::TAU * j as f64 / around as f64;
            let r = 1.0 + 0.1 * (5.0 * phi).sin() * (7.0 * theta).sin() * theta.sin();
            let across = DVec3::new(phi.cos(), phi.sin(), 0.0) * theta.sin();
            positions.push((across - DVec3::Z * theta.cos()) * r);
        }
    }
    positions.push(DVec3::Z);
    let top = positions.len() as u32 - 1;
    let at = |i: usize, j: usize| (1 + (i - 1) * around + j % around) as u32;
    let mut indices = Vec::new();
    for j in 0..around {
        indices.push([0, at(1, j + 1), at(1, j)]);
        for i in 1..n - 1 {
            indices.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
            indices.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
        }
        indices.push([top, at(n - 1, j), at(n - 1, j + 1)]);
    }
    mesh(positions, indices)
}

/// Random triangles in the unit cube.
fn soup(n: usize, size: f32, seed: u64) -> MeshData {
    let mut random = Random(seed);
    let mut positions = Vec::new();
    for _ in 0..n {
        let center = random.cube();
        positions.extend([0; 3].map(|_| (center + random.cube() * size).as_dvec3()));
    }
    mesh(
        positions,
        (0..n as u32)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect(),
    )
}

fn full_sphere(transform: Transform) -> CompiledShape {
    let form = Form::Sphere(Sphere::new(1.0, -1.0, 1.0, 360.0));
    CompiledShape::Quadric(Box::new(Quadric::new(form, transform, false)))
}
