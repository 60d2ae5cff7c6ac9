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
pub mod local;
pub mod loopsubdiv;
pub mod mesh;
pub mod nurbs;
pub mod objmesh;
pub mod paraboloid;
pub mod plymesh;
pub mod quadric;
pub mod sphere;
pub mod triangle;
pub mod trianglemesh;

use crate::assets::mesh::MeshData;
use crate::budget::{Budget, OverBudget};
use crate::math::transform::Transform;
use crate::params::{FloatInput, ParamReader};
use cone::Cone;
use curve::{CurveSpec, Curves};
use cylinder::Cylinder;
use disk::Disk;
use emitter::Emitter;
use heightfield::HeightfieldSpec;
use hyperboloid::Hyperboloid;
use loopsubdiv::LoopSubdivSpec;
use mesh::TriangleMesh;
use nurbs::NurbsSpec;
use objmesh::ObjMeshSpec;
use paraboloid::Paraboloid;
use plymesh::PlyMeshSpec;
use quadric::{Form, Quadric};
use sphere::Sphere;
use std::path::PathBuf;
use trianglemesh::TriangleMeshSpec;

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
    #[error("{}: {message}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
}

/// Memory of a triangle with its vertices, its tree, and what building that takes
/// (`tests/memory.rs` counts them).
const TRIANGLE_BYTES: u64 = 150;

/// A shape as the scene file describes it.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeSpec {
    /// Sphere, disk, cone, cylinder, paraboloid or hyperboloid.
    Quadric(Form),
    /// Triangles in the scene file.
    TriangleMesh(TriangleMeshSpec),
    /// A PLY file.
    PlyMesh(PlyMeshSpec),
    /// An OBJ file.
    ObjMesh(ObjMeshSpec),
    /// A subdivision surface.
    LoopSubdiv(LoopSubdivSpec),
    /// Heights over a grid.
    Heightfield(HeightfieldSpec),
    /// A spline surface.
    Nurbs(NurbsSpec),
    /// Strips along splines.
    Curve(CurveSpec),
}

impl ShapeSpec {
    /// The kinds that can be rendered.
    pub const KINDS: [&'static str; 13] = [
        "sphere",
        "disk",
        "cone",
        "cylinder",
        "paraboloid",
        "hyperboloid",
        "trianglemesh",
        "plymesh",
        "objmesh",
        "loopsubdiv",
        "heightfield",
        "nurbs",
        "curve",
    ];

    /// Reads the shape `reader.kind()`. `None` where it cannot be made (reported) or the kind is
    /// not in [`ShapeSpec::KINDS`] (not reported: the caller knows what else it might mean).
    pub fn from_params(reader: &ParamReader) -> Option<ShapeSpec> {
        Some(match reader.kind() {
            "sphere" => ShapeSpec::Quadric(Form::Sphere(Sphere::from_params(reader)?)),
            "disk" => ShapeSpec::Quadric(Form::Disk(Disk::from_params(reader)?)),
            "cone" => ShapeSpec::Quadric(Form::Cone(Cone::from_params(reader)?)),
            "cylinder" => ShapeSpec::Quadric(Form::Cylinder(Cylinder::from_params(reader)?)),
            "paraboloid" => ShapeSpec::Quadric(Form::Paraboloid(Paraboloid::from_params(reader)?)),
            "hyperboloid" => {
                ShapeSpec::Quadric(Form::Hyperboloid(Hyperboloid::from_params(reader)?))
            }
            "trianglemesh" => ShapeSpec::TriangleMesh(TriangleMeshSpec::from_params(reader)?),
            "plymesh" => ShapeSpec::PlyMesh(PlyMeshSpec::from_params(reader)?),
            "objmesh" => ShapeSpec::ObjMesh(ObjMeshSpec::from_params(reader)?),
            "loopsubdiv" => ShapeSpec::LoopSubdiv(LoopSubdivSpec::from_params(reader)?),
            "heightfield" => ShapeSpec::Heightfield(HeightfieldSpec::from_params(reader)?),
            "nurbs" => ShapeSpec::Nurbs(NurbsSpec::from_params(reader)?),
            "curve" => ShapeSpec::Curve(CurveSpec::from_params(reader)?),
            _ => return None,
        })
    }

    /// The cut-out texture of a mesh.
    pub fn alpha(&self) -> Option<FloatInput> {
        match self {
            ShapeSpec::TriangleMesh(mesh) => mesh.alpha,
            ShapeSpec::PlyMesh(mesh) => mesh.alpha,
            ShapeSpec::ObjMesh(mesh) => mesh.alpha,
            _ => None,
        }
    }

    /// The cut-out texture of a mesh for shadow rays.
    pub fn shadow_alpha(&self) -> Option<FloatInput> {
        match self {
            ShapeSpec::TriangleMesh(mesh) => mesh.shadow_alpha,
            ShapeSpec::PlyMesh(mesh) => mesh.shadow_alpha,
            ShapeSpec::ObjMesh(mesh) => mesh.shadow_alpha,
            _ => None,
        }
    }

    /// Loads and places the shape. `level_from_object` is object-to-render for the top level,
    /// object-to-world for shapes of a named object. Meshes are charged to `budget` with their trees.
    pub fn compile(
        &self,
        level_from_object: &Transform,
        reverse_orientation: bool,
        budget: &Budget,
    ) -> Result<CompiledShape, ShapeError> {
        let charge =
            |triangles: usize| budget.take((triangles as u64).saturating_mul(TRIANGLE_BYTES));
        let loaded = |data: MeshData| charge(data.indices.len()).map(|()| data);
        let invertible = || {
            let good = level_from_object.is_invertible();
            good.then_some(()).ok_or(ShapeError::Singular)
        };
        let mesh = |data| {
            CompiledShape::Mesh(Box::new(TriangleMesh::placed(
                data,
                level_from_object,
                reverse_orientation,
            )))
        };
        Ok(match self {
            ShapeSpec::Quadric(form) => {
                let quadric = Quadric::new(*form, *level_from_object, reverse_orientation);
                invertible()?;
                CompiledShape::Quadric(Box::new(quadric))
            }
            ShapeSpec::TriangleMesh(spec) => {
                charge(spec.data.indices.len())?;
                mesh(spec.data.clone())
            }
            ShapeSpec::PlyMesh(spec) => mesh(loaded(spec.load(budget)?)?),
            ShapeSpec::ObjMesh(spec) => mesh(loaded(spec.load(budget)?)?),
            ShapeSpec::LoopSubdiv(spec) => {
                charge(spec.triangles_made())?;
                mesh(spec.subdivide())
            }
            ShapeSpec::Heightfield(spec) => {
                charge(2 * spec.heights.len())?;
                mesh(spec.mesh())
            }
            ShapeSpec::Nurbs(spec) => mesh(loaded(spec.mesh())?),
            ShapeSpec::Curve(spec) => {
                invertible()?;
                let curves = spec.place(level_from_object, reverse_orientation);
                CompiledShape::Curves(Box::new(curves))
            }
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
