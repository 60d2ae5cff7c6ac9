//! Milliseconds to build the tree over a million triangles, with one thread and with two.
//!
//! `cargo bench --bench build`. What is timed is all from a placed mesh to a geometry ready for rays:
//! rounding the vertices, the binary tree, the wide one. Wall time, and the process's processor
//! time where Linux tells it: on a machine that others use, half the processor time of two threads is
//! nearer to what an idle one would show.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]
#![allow(clippy::print_stdout)]

use fstop::accel::{Geometry, GeometryBuilder, PrimitiveAttributes};
use fstop::assets::mesh::MeshData;
use fstop::math::DVec3;
use fstop::math::transform::Transform;
use fstop::shapes::CompiledShape;
use fstop::shapes::mesh::TriangleMesh;
use rayon::ThreadPoolBuilder;
use std::time::Instant;

/// Rings of the ball; twice as many quads around: 4 n² triangles.
const RINGS: usize = 500;

/// Of each number of threads, in turns; the best of each counts.
const ROUNDS: usize = 5;

fn main() {
    let mesh = TriangleMesh::new(ball(), &Transform::IDENTITY, false);
    let pools = [1, 2].map(|threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        (threads, pool.expect("threads"))
    });
    let mut best = [(f64::INFINITY, f64::INFINITY); 2];
    let mut statistics = None;
    for _ in 0..ROUNDS {
        for ((_, pool), best) in pools.iter().zip(&mut best) {
            let mesh = mesh.clone();
            let (wall, processor) = (Instant::now(), processor_ms());
            let geometry = pool.install(|| build(mesh));
            best.0 = best.0.min(wall.elapsed().as_secs_f64() * 1e3);
            best.1 = best.1.min(processor_ms() - processor);
            statistics = Some(geometry.statistics());
        }
    }
    println!("{:>8} {:>10} {:>14}", "threads", "wall ms", "processor ms");
    for ((threads, _), (wall, processor)) in pools.iter().zip(best) {
        println!("{threads:>8} {wall:>10.0} {processor:>14.0}");
    }
    if let Some(s) = statistics {
        let each = s.bytes as f64 / s.triangles as f64;
        println!("{} triangles, {each:.1} bytes each", s.triangles);
    }
}

fn build(mesh: TriangleMesh) -> Geometry {
    let mut builder = GeometryBuilder::default();
    let shape = CompiledShape::Mesh(Box::new(mesh));
    builder.add(shape, PrimitiveAttributes::default());
    builder.build(vec![]).expect("not too many triangles")
}

/// Of all threads of the process; 0 where there is no such file.
fn processor_ms() -> f64 {
    let Ok(threads) = std::fs::read_dir("/proc/self/task") else {
        return 0.0;
    };
    let of = |thread: std::io::Result<std::fs::DirEntry>| -> Option<f64> {
        let file = thread.ok()?.path().join("schedstat");
        let line = std::fs::read_to_string(file).ok()?;
        line.split(' ').next()?.parse().ok()
    };
    threads.filter_map(of).sum::<f64>() / 1e6
}

/// A bumpy ball of radius about 1.
fn ball() -> MeshData {
    let around = 2 * RINGS;
    let mut mesh = MeshData::default();
    for i in 0..=RINGS {
        for j in 0..around {
            let theta = std::f64::consts::PI * i as f64 / RINGS as f64;
            let phi = std::f64::consts::TAU * j as f64 / around as f64;
            let r = 1.0 + 0.05 * (40.0 * phi).sin() * (35.0 * theta).sin() * theta.sin();
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
}
