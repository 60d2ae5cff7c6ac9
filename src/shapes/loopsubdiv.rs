//! `Shape "loopsubdiv"`: the smooth limit of a triangle mesh under Loop's subdivision.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | `integer levels`, else `nlevels` | 3 | how often every triangle is cut into four |
//! | `integer indices` | required | three vertex numbers a triangle; one or two left over are dropped |
//! | `point3 P` | required | vertices of the control mesh |
//! | `string scheme` | "loop" | read and ignored, as in pbrt-v3 |
//!
//! After the last level vertices are moved onto the limit surface and get its normals, as in
//! pbrt-v3: the rules of Loop ("Smooth Subdivision Surfaces Based on Triangles", 1987) inside, those
//! of Hoppe et al. ("Piecewise Smooth Surface Reconstruction", 1994) along boundaries; Pharr, Jakob
//! and Humphreys 2016, §3.8 (docs/scene-language.md §3.7). There are no texture coordinates. Two of pbrt-v3's
//! choices show: boundaries end in 3/5 of a vertex and 1/5 of its neighbors (the limit of the rule
//! that got there is 2/3 and 1/6), and normals point to the side from which the triangles' corners
//! turn clockwise, the other side than that of a `trianglemesh` without normals.
//!
//! Non-manifold input: triangles with a corner twice are left out, and where an edge has more
//! than two triangles, or two that turn the same way, those without a partner end there as at a
//! boundary. Both are counted and said.

mod limit;
mod topology;

use super::site::{ShapeType, Site};
use super::trianglemesh::vertices_and_triangles;
use super::{CompiledShape, ShapeError};
use crate::assets::mesh::MeshData;
use crate::math::DVec3;
use crate::params::ParamReader;
use limit::{limit_normals, limit_positions};
use topology::ControlMesh;

/// Most triangles of the finished mesh. With its tree a triangle takes about 150 bytes, so that
/// these are 5 GB.
const MAX_TRIANGLES: usize = 1 << 25;

/// See the module.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopSubdivSpec {
    /// How often triangles are cut into four.
    pub levels: u32,
    /// Corners of the control mesh's triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Vertices of the control mesh, object space.
    pub positions: Vec<DVec3>,
}

impl LoopSubdivSpec {
    /// Reads the parameters; `None` where vertices or indices are missing or wrong, or where there are
    /// too many levels (reported).
    pub fn from_params(reader: &ParamReader) -> Option<LoopSubdivSpec> {
        reader.string("scheme", "loop");
        let name = if reader.has("levels") {
            "levels"
        } else {
            "nlevels"
        };
        reader.accept("nlevels");
        let asked = reader.integer_within(name, 3, 0..=i64::from(u32::MAX)) as u32;
        let (positions, triangles) = vertices_and_triangles(reader)?;
        let levels = affordable(asked, triangles.len());
        if levels < asked {
            reader.error(
                name,
                format!(
                    "`{name}` is {asked}, which would make more than {MAX_TRIANGLES} triangles \
                     (5 GB with their tree): {levels} is the most for this mesh"
                ),
            );
            return None;
        }
        Some(LoopSubdivSpec {
            levels,
            triangles,
            positions,
        })
    }

    /// How many triangles [`LoopSubdivSpec::subdivide`] makes, at most.
    pub fn triangles_made(&self) -> usize {
        triangles_made(self.levels, self.triangles.len())
    }

    /// Subdivides. Time and memory are proportional to the triangles made.
    pub fn subdivide(&self) -> MeshData {
        let ControlMesh {
            mut topology,
            mut positions,
            warnings,
        } = ControlMesh::new(&self.triangles, &self.positions);
        for _ in 0..self.levels {
            let finer = topology.refine();
            positions = topology.refined_positions(&finer, &positions);
            topology = finer;
        }
        let positions = limit_positions(&topology, &positions);
        MeshData {
            normals: limit_normals(&topology, &positions),
            positions,
            indices: topology.triangles,
            warnings,
            ..MeshData::default()
        }
    }
}

impl ShapeType for LoopSubdivSpec {
    fn compile(&self, site: &Site) -> Result<CompiledShape, ShapeError> {
        site.charge(self.triangles_made())?;
        Ok(site.mesh(self.subdivide()))
    }
}

fn triangles_made(levels: u32, triangles: usize) -> usize {
    4usize.saturating_pow(levels).saturating_mul(triangles)
}

/// The most levels up to `asked` that [`MAX_TRIANGLES`] allows.
fn affordable(asked: u32, triangles: usize) -> u32 {
    let fits = |&levels: &u32| triangles_made(levels, triangles) <= MAX_TRIANGLES;
    // Nothing at all can be cut for ever.
    (0..=asked.min(32)).take_while(fits).last().unwrap_or(0)
}

#[cfg(test)]
mod tests;
