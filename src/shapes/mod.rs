//! Shapes, one file each, named as in the scene file (`plymesh` and `objmesh` are in `meshfile`).
//!
//! A [`ShapeSpec`] is what the scene file says, in object space and double precision;
//! [`ShapeSpec::compile`] loads what it names and places it; [`emitter::Emitter`] is a shape that
//! light is sampled from.

pub mod ball;
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
pub mod meshfile;
pub mod nurbs;
pub mod paraboloid;
pub mod quadric;
mod site;
pub mod sphere;
pub mod triangle;
pub mod trianglemesh;

pub use crate::assets::mesh::MeshExtent;
pub use kinds::{Form, ShapeKind};
pub use site::Site;

use crate::budget::OverBudget;
use crate::files::FileError;
use crate::inputs::FloatInput;
use crate::math::DVec3;
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
use sphere::Sphere;
use std::fmt::Display;

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
    #[error(transparent)]
    File(#[from] FileError),
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
    /// Reads the shape `reader.kind()`. `None` where it cannot be made (reported).
    pub fn from_params(reader: &ParamReader) -> Option<ShapeSpec> {
        let has_cutouts = matches!(reader.kind(), "trianglemesh" | "plymesh" | "objmesh");
        let cutout = |name| has_cutouts.then(|| reader.find_float_input(name)).flatten();
        Some(ShapeSpec {
            alpha: cutout("alpha"),
            shadow_alpha: cutout("shadowalpha"),
            kind: ShapeKind::from_params(reader)?,
        })
    }

    /// Returns `true` if it can be an area light.
    pub fn can_emit(&self) -> bool {
        !matches!(self.kind, ShapeKind::Curve(_))
    }

    /// Loads and places the shape.
    pub fn compile(&self, site: &Site) -> Result<CompiledShape, ShapeError> {
        self.kind.compile(site)
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
    pub fn emitters(&self) -> Box<dyn Iterator<Item = Emitter> + '_> {
        match self {
            CompiledShape::Mesh(mesh) => Emitter::of_mesh(mesh),
            CompiledShape::Quadric(quadric) => {
                Box::new(std::iter::once(Emitter::of_quadric(quadric)))
            }
            // The scene has refused those that emit.
            CompiledShape::Curves(_) => Box::new(std::iter::empty()),
        }
    }

    /// What was odd in the shape's file, in words.
    pub fn warnings(&self) -> &[String] {
        match self {
            CompiledShape::Mesh(mesh) => &mesh.data.warnings,
            CompiledShape::Quadric(_) | CompiledShape::Curves(_) => &[],
        }
    }
}

/// What a parameter gives, without which there is no shape (reported).
fn needed<T>(
    reader: &ParamReader,
    name: &str,
    given: Option<T>,
    message: impl Into<String>,
) -> Option<T> {
    if given.is_none() {
        reader.error(name, message);
    }
    given
}

/// Reports why there is no shape.
fn left_out<T>(reader: &ParamReader, name: &str, why: impl Display) -> Option<T> {
    reader.error(name, format!("{why}: the shape is left out"));
    None
}

/// Reports a length that is not positive.
fn positive(reader: &ParamReader, name: &str, value: f64) -> Option<()> {
    if value > 0.0 && value.is_finite() {
        return Some(());
    }
    left_out(
        reader,
        name,
        format_args!("{name} must be positive, not {value}"),
    )
}

/// The points or vectors of a parameter's numbers.
fn triples(values: &[f64]) -> impl Iterator<Item = DVec3> {
    values.as_chunks::<3>().0.iter().copied().map(DVec3::from)
}
