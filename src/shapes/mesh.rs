//! A triangle mesh in place.

use super::triangle::Orientation;
use crate::assets::mesh::MeshData;
use crate::math::DVec3;
use crate::math::transform::{Transform, box_around};

/// A triangle mesh whose vertices are in the space of the tree that will hold it, still in double
/// precision: the tree rounds them once, relative to its own anchor, so that meshes which share
/// vertices share them after rounding too.
#[derive(Clone, Debug, Default)]
pub struct TriangleMesh {
    /// The mesh in level space. Attributes are one for each vertex or triangle, or none at all; normals are of unit
    /// length, but a zero normal stays zero.
    pub data: MeshData,
    /// Which way the normals point.
    pub orientation: Orientation,
}

impl TriangleMesh {
    /// Places `data`, in the memory that it has. Indices out of range must have been refused before.
    pub fn new(
        mut data: MeshData,
        level_from_object: &Transform,
        reverse_orientation: bool,
    ) -> TriangleMesh {
        let count = data.positions.len();
        for p in &mut data.positions {
            *p = level_from_object.point(*p);
        }
        // A singular transformation (a mesh pressed flat) still places vertices, but no normals.
        if !level_from_object.is_invertible() {
            data.normals = Vec::new();
        }
        keep_if_each(&mut data.normals, count);
        for n in &mut data.normals {
            let normal = level_from_object.normal(n.as_dvec3());
            *n = normal.normalize_or_zero().as_vec3();
        }
        keep_if_each(&mut data.tangents, count);
        for s in &mut data.tangents {
            *s = level_from_object.vector(s.as_dvec3()).as_vec3();
        }
        keep_if_each(&mut data.uv, count);
        keep_if_each(&mut data.face_ids, data.indices.len());
        TriangleMesh {
            data,
            orientation: Orientation {
                flip_geometric: reverse_orientation ^ level_from_object.swaps_handedness(),
                flip_shading: reverse_orientation,
            },
        }
    }

    /// Corners of the box around the finite vertices; `min > max` without any.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let finite = self.data.positions.iter().filter(|p| p.is_finite());
        box_around(finite.copied())
    }
}

/// Frees attributes that are not one for each.
fn keep_if_each<T>(attributes: &mut Vec<T>, count: usize) {
    if attributes.len() != count {
        *attributes = Vec::new();
    }
}
