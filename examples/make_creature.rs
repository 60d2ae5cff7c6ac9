//! Writes `scenes/creature/creature.ply`: a smooth, knobbly animal of 30,000 triangles, the mesh of
//! the speed scene. A cube's faces are blown up to a sphere and pushed out along smooth lobes.
//!
//! `cargo run --release --features studies --example make_creature`

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

use fstop::math::{DVec3, Vec3};
use std::io::Write;

/// Quads along each cube edge: 6 · 50² · 2 triangles.
const CELLS: usize = 50;

/// Direction, height and sharpness of a lobe.
struct Lobe(DVec3, f64, f64);

fn lobes() -> Vec<Lobe> {
    let lobe =
        |x, y, z, height, sharpness| Lobe(DVec3::new(x, y, z).normalize(), height, sharpness);
    vec![
        lobe(0.0, 0.55, -1.0, 1.1, 14.0),  // head
        lobe(0.12, 0.85, -1.0, 0.5, 90.0), // ears
        lobe(-0.12, 0.85, -1.0, 0.5, 90.0),
        lobe(0.0, -0.1, 1.0, 1.6, 30.0),    // tail
        lobe(0.45, -1.0, -0.5, 0.75, 22.0), // legs
        lobe(-0.45, -1.0, -0.5, 0.75, 22.0),
        lobe(0.5, -1.0, 0.5, 0.85, 16.0),
        lobe(-0.5, -1.0, 0.5, 0.85, 16.0),
        lobe(0.0, 1.0, 0.2, 0.25, 5.0), // back
    ]
}

fn surface(direction: DVec3, lobes: &[Lobe]) -> DVec3 {
    let bulge: f64 = lobes
        .iter()
        .map(|Lobe(d, h, s)| h * (s * (direction.dot(*d) - 1.0)).exp())
        .sum();
    let knobs =
        0.02 * (17.0 * direction.x).sin() * (19.0 * direction.y).sin() * (18.0 * direction.z).sin();
    direction * DVec3::new(0.75, 0.75, 1.1) * (0.8 + bulge + knobs)
}

fn main() -> std::io::Result<()> {
    let lobes = lobes();
    let mut index = std::collections::BTreeMap::new();
    let mut vertices: Vec<Vec3> = Vec::new();
    let mut faces: Vec<[u32; 3]> = Vec::new();
    for face in 0..6 {
        let mut vertex = |i: usize, j: usize| {
            let n = CELLS as i64;
            let (a, b) = (2 * i as i64 - n, 2 * j as i64 - n);
            let cube = match face {
                0 => [n, a, b],
                1 => [-n, b, a],
                2 => [b, n, a],
                3 => [a, -n, b],
                4 => [a, b, n],
                _ => [b, a, -n],
            };
            *index.entry(cube).or_insert_with(|| {
                let p = DVec3::new(cube[0] as f64, cube[1] as f64, cube[2] as f64) / n as f64;
                vertices.push(surface(p.normalize(), &lobes).as_vec3());
                vertices.len() as u32 - 1
            })
        };
        for i in 0..CELLS {
            for j in 0..CELLS {
                let q = [
                    vertex(i, j),
                    vertex(i + 1, j),
                    vertex(i + 1, j + 1),
                    vertex(i, j + 1),
                ];
                faces.push([q[0], q[1], q[2]]);
                faces.push([q[0], q[2], q[3]]);
            }
        }
    }
    let mut normals = vec![Vec3::ZERO; vertices.len()];
    for f in &faces {
        let [a, b, c] = f.map(|i| vertices[i as usize]);
        for &i in f {
            normals[i as usize] += (b - a).cross(c - a);
        }
    }
    let path =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/creature/creature.ply");
    let mut out = std::io::BufWriter::new(std::fs::File::create(path)?);
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n",
        vertices.len()
    )?;
    for property in ["x", "y", "z", "nx", "ny", "nz"] {
        writeln!(out, "property float {property}")?;
    }
    write!(
        out,
        "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        faces.len()
    )?;
    for (p, n) in vertices.iter().zip(&normals) {
        for v in p
            .to_array()
            .into_iter()
            .chain(n.normalize_or_zero().to_array())
        {
            out.write_all(&v.to_le_bytes())?;
        }
    }
    for f in &faces {
        out.write_all(&[3])?;
        for i in f {
            out.write_all(&i.to_le_bytes())?;
        }
    }
    out.flush()
}
