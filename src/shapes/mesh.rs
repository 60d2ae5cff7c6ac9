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
    /// For each triangle the face of the original mesh that it is of, or none: face 0 then.
    pub face_ids: Vec<u32>,
    /// Which way the normals point.
    pub orientation: Orientation,
    /// What was odd about the mesh's file.
    pub warnings: Vec<String>,
}

impl TriangleMesh {
    /// Places a copy of `data`; see [`TriangleMesh::placed`].
    #[cfg(any(test, feature = "internals"))]
    pub fn new(
        data: &MeshData,
        level_from_object: &Transform,
        reverse_orientation: bool,
    ) -> TriangleMesh {
        TriangleMesh::placed(data.clone(), level_from_object, reverse_orientation)
    }

    /// Places `data`, in the memory that it has. Indices out of range must have been refused before.
    pub fn placed(
        mut data: MeshData,
        level_from_object: &Transform,
        reverse_orientation: bool,
    ) -> TriangleMesh {
        let count = data.positions.len();
        for p in &mut data.positions {
            *p = level_from_object.point(*p);
        }
        // A singular transformation (a mesh pressed flat) still places vertices, but no normals.
        if data.normals.len() != count || !level_from_object.is_invertible() {
            data.normals = Vec::new();
        }
        for n in &mut data.normals {
            let normal = level_from_object.normal(n.as_dvec3());
            *n = normal.normalize_or_zero().as_vec3();
        }
        if data.tangents.len() != count {
            data.tangents = Vec::new();
        }
        for s in &mut data.tangents {
            *s = level_from_object.vector(s.as_dvec3()).as_vec3();
        }
        if data.uv.len() != count {
            data.uv = Vec::new();
        }
        if data.face_ids.len() != data.indices.len() {
            data.face_ids = Vec::new();
        }
        TriangleMesh {
            indices: data.indices,
            positions: data.positions,
            normals: data.normals,
            tangents: data.tangents,
            uv: data.uv,
            face_ids: data.face_ids,
            orientation: Orientation {
                flip_geometric: reverse_orientation ^ level_from_object.swaps_handedness(),
                flip_shading: reverse_orientation,
            },
            warnings: data.warnings,
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
