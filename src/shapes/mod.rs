//! Shapes, one file each, named as in the scene file.
//!
//! A [`ShapeSpec`] is what the scene file says, in object space and double precision;
//! [`ShapeSpec::compile`] loads what it names and places it; [`emitter::Emitter`] is a shape that
//! light is sampled from.

pub mod cone;
pub mod curve;
pub mod cylinder;
pub mod disk;
pub mod emitter;
mod grid;
pub mod heightfield;
pub mod hyperboloid;
mod kinds;
pub mod local;
pub mod loopsubdiv;
pub mod mesh;
pub mod nurbs;
pub mod objmesh;
pub mod paraboloid;
pub mod plymesh;
pub mod quadric;
mod site;
pub mod sphere;
pub mod triangle;
pub mod trianglemesh;

pub use kinds::{Form, ShapeKind};

use crate::budget::{Budget, OverBudget};
use crate::inputs::FloatInput;
use crate::math::transform::Transform;
use crate::params::ParamReader;
use cone::Cone;
use curve::Curves;
use cylinder::Cylinder;
use disk::Disk;
use emitter::Emitter;
use hyperboloid::Hyperboloid;
use mesh::TriangleMesh;
use paraboloid::Paraboloid;
use quadric::Quadric;
use site::Site;
use sphere::Sphere;
use std::path::PathBuf;

/// Why a shape cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum ShapeError {
    /// The object-to-world matrix has no inverse.
    #[error("the transformation of this shape is singular")]
    Singular,
    /// There is not enough memory for it.
    #[error("this shape {0}")]
    TooLarge(#[from] OverBudget),
    /// A mesh file cannot be used.
    #[error("{0}")]
    File(String),
}

/// A shape as the scene file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeSpec {
    /// The type with its parameters.
    pub kind: ShapeKind,
    /// Cut-outs of a mesh: no surface where exactly 0.
    pub alpha: Option<FloatInput>,
    /// Cut-outs for shadow rays only.
    pub shadow_alpha: Option<FloatInput>,
}

impl ShapeSpec {
    /// Returns `true` if it can be an area light.
    pub fn can_emit(&self) -> bool {
        !matches!(self.kind, ShapeKind::Curve(_))
    }

    /// Loads and places the shape. `level_from_object` is object-to-render for the top level,
    /// object-to-world for shapes of a named object. Meshes are charged to `budget` with their trees.
    pub fn compile(
        &self,
        level_from_object: &Transform,
        reverse_orientation: bool,
        budget: &Budget,
    ) -> Result<CompiledShape, ShapeError> {
        self.kind.compile(&Site {
            level_from_object,
            reverse_orientation,
            budget,
        })
    }
}

/// A shape in place, in double precision.
#[derive(Clone, Debug)]
pub enum CompiledShape {
    /// Triangles.
    Mesh(Box<TriangleMesh>),
    /// Sphere, disk, cone, cylinder, paraboloid or hyperboloid.
    Quadric(Box<Quadric>),
    /// Strips along splines.
    Curves(Box<Curves>),
}

impl CompiledShape {
    /// The shape as lights, in the order that [`crate::accel::PrimitiveAttributes::light`] counts.
    /// The shape must have been compiled for the top level: emitters are in render space.
    pub fn emitters(&self) -> Vec<Emitter> {
        match self {
            CompiledShape::Mesh(mesh) => Emitter::of_mesh(mesh),
            CompiledShape::Quadric(quadric) => vec![Emitter::of_quadric(quadric)],
            // The scene has refused those that emit.
            CompiledShape::Curves(_) => Vec::new(),
        }
    }

    /// What was odd in the shape's file, in words.
    pub fn warnings(&self) -> &[String] {
        match self {
            CompiledShape::Mesh(mesh) => &mesh.warnings,
            CompiledShape::Quadric(_) | CompiledShape::Curves(_) => &[],
        }
    }
}

/// `filename` of a mesh; `None` where there is no such file (reported).
fn mesh_file(reader: &ParamReader) -> Option<PathBuf> {
    if !reader.has("filename") {
        let kind = reader.kind();
        reader.error("filename", format!("a {kind} needs a \"string filename\""));
    }
    reader.file("filename")
}

/// Reports a length that is not positive.
fn positive(reader: &ParamReader, name: &str, value: f64) -> Option<()> {
    if value > 0.0 && value.is_finite() {
        return Some(());
    }
    reader.error(
        name,
        format!("{name} must be positive, not {value}: the shape is left out"),
    );
    None
}
