//! The two meshes that rays are job at.

use fstop::assets::mesh::MeshData;
use fstop::math::hash::{mix2, unit_float};
use fstop::math::{DVec3, Vec3};

/// A mesh with a name for the table. Its coordinates are single-precision numbers.
pub(crate) struct Mesh {
    pub name: &'static str,
    pub data: MeshData,
}

/// Rings of the ball; twice as many quads around: 4 n² triangles.
const RINGS: usize = 500;
/// Triangles of the soup.
const SOUP: usize = 100_000;
/// Corners of the soup's triangles are up to this far from their center in each axis; the soup
/// fills the cube from −1 to 1.
const SOUP_SIZE: f32 = 0.05;

/// A bumpy ball of a million triangles and radius about 1: the ordinary case, a scanned thing.
pub(crate) fn ball() -> Mesh {
    let around = 2 * RINGS;
    let mut data = MeshData::default();
    for i in 0..=RINGS {
        for j in 0..around {
            let theta = std::f64::consts::PI * i as f64 / RINGS as f64;
            let phi = std::f64::consts::TAU * j as f64 / around as f64;
            let bumps = (40.0 * phi).sin() * (35.0 * theta).sin()
                + 0.3 * (170.0 * phi).sin() * (140.0 * theta).cos();
            let r = 1.0 + 0.05 * bumps * theta.sin();
            let across = DVec3::new(phi.cos(), phi.sin(), 0.0) * theta.sin();
            let p = (across - DVec3::Z * theta.cos()) * r;
            data.positions.push(p.as_vec3().as_dvec3());
        }
    }
    let at = |i: usize, j: usize| (i * around + j % around) as u32;
    for i in 0..RINGS {
        for j in 0..around {
            data.indices
                .push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
            data.indices
                .push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    Mesh { name: "ball", data }
}

/// Triangles anywhere: boxes that overlap, the hard case.
pub(crate) fn soup() -> Mesh {
    let cube = |i: usize, k: u64| {
        let draw = |axis: u64| 2.0 * unit_float(mix2(i as u64, 3 * k + axis)) - 1.0;
        Vec3::new(draw(0), draw(1), draw(2))
    };
    let corner = |i: usize, k: u64| (cube(i, 0) + cube(i, 1 + k) * SOUP_SIZE).as_dvec3();
    let mut data = MeshData::default();
    for i in 0..SOUP {
        data.positions.extend((0..3).map(|k| corner(i, k)));
        let first = 3 * i as u32;
        data.indices.push([first, first + 1, first + 2]);
    }
    Mesh { name: "soup", data }
}
