//! Rays per second through one mesh of a million triangles: our 8-wide tree beside obvhs's own
//! traversal of its binary tree (which is not watertight).
//!
//! `cargo bench --bench traversal`; items are rays.

use divan::Bencher;
use divan::counter::ItemsCount;
use fstop::accel::{Geometry, GeometryBuilder, PrimitiveAttributes};
use fstop::assets::mesh::MeshData;
use fstop::math::hash::{mix2, unit_float};
use fstop::math::ray::Ray;
use fstop::math::sampling::uniform_sphere;
use fstop::math::transform::Transform;
use fstop::math::{DVec3, Vec2, Vec3};
use fstop::params::FloatInput;
use fstop::shapes::CompiledShape;
use fstop::shapes::mesh::TriangleMesh;
use fstop::surface::TexturePoint;
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::ray::RayHit;
use obvhs::triangle::Triangle;
use std::sync::LazyLock;

fn main() {
    let statistics = OURS.statistics();
    println!(
        "{statistics:?}: {} bytes a triangle",
        statistics.bytes / statistics.triangles
    );
    divan::main();
}

/// Rings of the ball; twice as many quads around: 4 n² triangles.
const RINGS: usize = 500;

/// Rays of one set.
const RAYS: usize = 1 << 16;

/// A bumpy ball of a million triangles and radius about 1.
static MESH: LazyLock<MeshData> = LazyLock::new(|| {
    let around = 2 * RINGS;
    let mut mesh = MeshData::default();
    for i in 0..=RINGS {
        for j in 0..around {
            let theta = std::f64::consts::PI * i as f64 / RINGS as f64;
            let phi = std::f64::consts::TAU * j as f64 / around as f64;
            let bumps = (40.0 * phi).sin() * (35.0 * theta).sin()
                + 0.3 * (170.0 * phi).sin() * (140.0 * theta).cos();
            let r = 1.0 + 0.05 * bumps * theta.sin();
            let across = DVec3::new(phi.cos(), phi.sin(), 0.0) * theta.sin();
            mesh.positions.push((across - DVec3::Z * theta.cos()) * r);
        }
    }
    let at = |i: usize, j: usize| (i * around + j % around) as u32;
    for i in 0..RINGS {
        for j in 0..around {
            mesh.indices
                .push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
            mesh.indices
                .push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    mesh
});

fn build() -> Geometry {
    let mut builder = GeometryBuilder::default();
    let mesh = TriangleMesh::new(&MESH, &Transform::IDENTITY, false);
    builder.add(
        CompiledShape::Mesh(Box::new(mesh)),
        PrimitiveAttributes::default(),
    );
    builder
        .build(vec![])
        .expect("a million triangles are not too many")
}

static OURS: LazyLock<Geometry> = LazyLock::new(build);

static THEIRS: LazyLock<(Bvh2, Vec<Triangle>)> = LazyLock::new(|| {
    let triangles: Vec<Triangle> = MESH
        .indices
        .iter()
        .map(|t| {
            let [v0, v1, v2] = t.map(|i| MESH.positions[i as usize].as_vec3().into());
            Triangle { v0, v1, v2 }
        })
        .collect();
    let bvh = build_bvh2_from_tris(
        &triangles,
        BvhBuildParams::medium_build(),
        &mut Default::default(),
    );
    let ordered = bvh
        .primitive_indices
        .iter()
        .map(|&i| triangles[i as usize])
        .collect();
    (bvh, ordered)
});

/// What rays are like.
#[derive(Clone, Copy, Debug)]
enum Set {
    /// From an eye, neighbours one after the other.
    Primary,
    /// From anywhere around to anywhere inside.
    Random,
    /// From the surface to a light, ending there.
    Shadow,
}

fn random(i: usize, dimension: u64) -> Vec2 {
    let draw = |k| unit_float(mix2(i as u64, 2 * dimension + k));
    Vec2::new(draw(0), draw(1))
}

fn rays(set: Set) -> Vec<Ray> {
    let eye = Vec3::new(0.0, -3.0, 0.5);
    let ray = |i: usize| match set {
        Set::Primary => {
            let (x, y) = (
                (i % 256) as f32 / 256.0 - 0.5,
                (i / 256) as f32 / 256.0 - 0.5,
            );
            Ray::new(
                eye,
                Vec3::new(0.7 * x, 1.0, 0.7 * y - 0.17).normalize(),
                0.0,
            )
        }
        Set::Random | Set::Shadow => {
            let o = uniform_sphere(random(i, 0)) * 2.0;
            let target = uniform_sphere(random(i, 1)) * random(i, 2).x;
            Ray::new(o, (target - o).normalize(), 0.0)
        }
    };
    let rays = (0..RAYS).map(ray);
    if !matches!(set, Set::Shadow) {
        return rays.collect();
    }
    let light = Vec3::new(2.0, -2.0, 3.0);
    rays.filter_map(|ray| OURS.intersect(&ray, &opaque))
        .map(|hit| {
            hit.surface
                .reference_point()
                .shadow_ray_to(light, Vec3::ZERO, Vec3::ZERO)
        })
        .collect()
}

fn opaque(_: &FloatInput, _: &TexturePoint) -> f32 {
    1.0
}

#[divan::bench(args = [Set::Primary, Set::Random, Set::Shadow])]
fn fstop(bencher: Bencher, set: Set) {
    let rays = rays(set);
    bencher
        .counter(ItemsCount::new(rays.len()))
        .bench_local(|| match set {
            Set::Shadow => rays
                .iter()
                .filter(|ray| OURS.occluded(ray, &opaque))
                .count(),
            _ => rays
                .iter()
                .filter(|ray| OURS.intersect(ray, &opaque).is_some())
                .count(),
        });
}

#[divan::bench(args = [Set::Primary, Set::Random, Set::Shadow])]
fn obvhs(bencher: Bencher, set: Set) {
    let rays = rays(set);
    let (bvh, triangles) = &*THEIRS;
    let convert = |ray: &Ray| obvhs::ray::Ray::new(ray.o.into(), ray.d.into(), 0.0, ray.t_max);
    bencher
        .counter(ItemsCount::new(rays.len()))
        .bench_local(|| match set {
            Set::Shadow => {
                let blocked = |ray: &&Ray| {
                    !bvh.ray_traverse_miss(convert(ray), |ray, i| triangles[i].intersect(ray))
                };
                rays.iter().filter(blocked).count()
            }
            _ => {
                let meets = |ray: &&Ray| {
                    let mut hit = RayHit::none();
                    bvh.ray_traverse(convert(ray), &mut hit, |ray, i| triangles[i].intersect(ray))
                };
                rays.iter().filter(meets).count()
            }
        });
}

#[divan::bench(sample_count = 5)]
fn build_of_a_million(bencher: Bencher) {
    LazyLock::force(&MESH);
    bencher.bench_local(build);
}
