//! What every type of shape implements in its own file, and where shapes are placed.

use super::mesh::TriangleMesh;
use super::quadric::Quadric;
use super::{CompiledShape, Form, ShapeError};
use crate::assets::mesh::MeshData;
use crate::budget::{Budget, OverBudget};
use crate::math::transform::Transform;

/// Memory of a triangle with its vertices, its tree, and what building that takes
/// (`tests/memory.rs` counts them).
const TRIANGLE_BYTES: u64 = 150;

/// A type of shape, as the scene file describes it.
pub(super) trait ShapeType {
    /// Loads and places the shape.
    fn compile(&self, site: &Site) -> Result<CompiledShape, ShapeError>;
}

/// Where a shape is placed, and what memory there is.
pub struct Site<'a> {
    /// Object-to-render for the top level, object-to-world for shapes of a named object.
    pub level_from_object: &'a Transform,
    /// `ReverseOrientation` is on.
    pub reverse_orientation: bool,
    /// Meshes are charged to it, with their trees.
    pub budget: &'a Budget,
}

impl Site<'_> {
    /// Takes the memory of so many triangles with their tree.
    pub(super) fn charge(&self, triangles: usize) -> Result<(), OverBudget> {
        let bytes = (triangles as u64).saturating_mul(TRIANGLE_BYTES);
        self.budget.take(bytes)
    }

    /// Shapes other than meshes are nothing where they are pressed flat.
    pub(super) fn needs_inverse(&self) -> Result<(), ShapeError> {
        match self.level_from_object.is_invertible() {
            true => Ok(()),
            false => Err(ShapeError::Singular),
        }
    }

    pub(super) fn quadric(&self, form: Form) -> Result<CompiledShape, ShapeError> {
        self.needs_inverse()?;
        let quadric = Quadric::new(form, *self.level_from_object, self.reverse_orientation);
        Ok(CompiledShape::Quadric(Box::new(quadric)))
    }

    /// A mesh that has been charged.
    pub(super) fn mesh(&self, data: MeshData) -> CompiledShape {
        let mesh = TriangleMesh::new(data, self.level_from_object, self.reverse_orientation);
        CompiledShape::Mesh(Box::new(mesh))
    }

    /// A mesh whose size is known only now.
    pub(super) fn charged_mesh(&self, data: MeshData) -> Result<CompiledShape, ShapeError> {
        self.charge(data.indices.len())?;
        Ok(self.mesh(data))
    }
}
