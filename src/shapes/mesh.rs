//! A triangle mesh in place.

use super::triangle::Orientation;
use crate::assets::mesh::MeshData;
use crate::math::transform::Transform;
use crate::math::{DVec3, Vec2, Vec3};

/// A triangle mesh whose vertices are in the space of the tree that will hold it, still in double
/// precision: the tree rounds them once, relative to its own anchor, so that meshes which share
/// vertices share them after rounding too.
#[derive(Clone, Debug, Default)]
pub struct TriangleMesh {
    /// Three vertex numbers a triangle.
    pub indices: Vec<[u32; 3]>,
    /// Vertex positions, level space.
    pub positions: Vec<DVec3>,
    /// Unit vertex normals, or none. A zero normal stays zero.
    pub normals: Vec<Vec3>,
    /// Vertex tangents, or none.
    pub tangents: Vec<Vec3>,
    /// Texture coordinates, or none.
    pub uv: Vec<Vec2>,
    /// Which way the normals point.
    pub orientation: Orientation,
    /// What was odd about the mesh's file.
    pub warnings: Vec<String>,
}

impl TriangleMesh {
    /// Places `data`. Indices out of range must have been refused before.
    pub fn new(
        data: &MeshData,
        level_from_object: &Transform,
        reverse_orientation: bool,
    ) -> TriangleMesh {
        let complete = |len: usize| len == data.positions.len();
        let normal = |n: &Vec3| {
            let n = level_from_object.normal(n.as_dvec3());
            n.normalize_or_zero().as_vec3()
        };
        // A singular transformation (a mesh pressed flat) still places vertices, but no normals.
        let with_normals = complete(data.normals.len()) && level_from_object.is_invertible();
        TriangleMesh {
            indices: data.indices.clone(),
            positions: data
                .positions
                .iter()
                .map(|&p| level_from_object.point(p))
                .collect(),
            normals: if with_normals {
                data.normals.iter().map(normal).collect()
            } else {
                Vec::new()
            },
            tangents: if complete(data.tangents.len()) {
                let place = |s: &Vec3| level_from_object.vector(s.as_dvec3()).as_vec3();
                data.tangents.iter().map(place).collect()
            } else {
                Vec::new()
            },
            uv: if complete(data.uv.len()) {
                data.uv.clone()
            } else {
                Vec::new()
            },
            orientation: Orientation {
                flip_geometric: reverse_orientation ^ level_from_object.swaps_handedness(),
                flip_shading: reverse_orientation,
            },
            warnings: data.warnings.clone(),
        }
    }

    /// Corners of the box around the finite vertices; `min > max` without any.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.positions
            .iter()
            .filter(|p| p.is_finite())
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), &p| {
                (min.min(p), max.max(p))
            })
    }
}
