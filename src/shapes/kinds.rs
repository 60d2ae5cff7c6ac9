//! The types of shapes: one table for names, the reader and the dispatch.

use super::quadric::{ObjectPoint, ObjectSurface, ShadingFrame};
use super::site::{ShapeType, Site};
use super::*;
use crate::math::{DVec2, Vec2};
use std::path::Path;

macro_rules! shape_types {
    (
        quadrics { $($quadric:literal => $Quadric:ident,)* }
        others { $($name:literal => $Kind:ident($Type:ty),)* }
    ) => {
        /// The quadrics.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Form {
            $(#[doc = concat!("`", $quadric, "`")] $Quadric($Quadric),)*
        }

        /// The types of shapes.
        #[derive(Clone, Debug, PartialEq)]
        pub enum ShapeKind {
            /// Any of the quadrics.
            Quadric(Form),
            $(#[doc = concat!("`", $name, "`")] $Kind($Type),)*
        }

        impl ShapeSpec {
            /// The types that a scene may name.
            pub const KINDS: &'static [&'static str] = &[$($quadric,)* $($name,)*];
        }

        impl ShapeKind {
            /// Reads the shape `reader.kind()`. `None` where it cannot be made (reported).
            pub(super) fn from_params(reader: &ParamReader) -> Option<ShapeKind> {
                Some(match reader.kind() {
                    $($quadric => {
                        ShapeKind::Quadric(Form::$Quadric($Quadric::from_params(reader)?))
                    })*
                    $($name => ShapeKind::$Kind(<$Type>::from_params(reader)?),)*
                    _ => {
                        reader.unknown_kind_replaced(ShapeSpec::KINDS, "the shape is left out");
                        return None;
                    }
                })
            }

            /// As the scene file calls it.
            pub fn name(&self) -> &'static str {
                match self {
                    $(ShapeKind::Quadric(Form::$Quadric(_)) => $quadric,)*
                    $(ShapeKind::$Kind(_) => $name,)*
                }
            }

            pub(super) fn compile(&self, site: &Site) -> Result<CompiledShape, ShapeError> {
                match self {
                    ShapeKind::Quadric(form) => site.quadric(*form),
                    $(ShapeKind::$Kind(shape) => shape.compile(site),)*
                }
            }
        }

        impl ObjectSurface for Form {
            fn intersect(&self, o: DVec3, d: DVec3) -> Option<(f64, DVec3)> {
                match self { $(Form::$Quadric(shape) => shape.intersect(o, d),)* }
            }

            fn distance(&self, o: DVec3, d: DVec3) -> Option<f64> {
                match self { $(Form::$Quadric(shape) => shape.distance(o, d),)* }
            }

            fn at(&self, p: DVec3) -> ObjectPoint {
                match self { $(Form::$Quadric(shape) => shape.at(p),)* }
            }

            fn normal(&self, p: DVec3) -> DVec3 {
                match self { $(Form::$Quadric(shape) => shape.normal(p),)* }
            }

            fn approximate_uv(&self, p: DVec3) -> Vec2 {
                match self { $(Form::$Quadric(shape) => shape.approximate_uv(p),)* }
            }

            fn bounds(&self) -> (DVec3, DVec3) {
                match self { $(Form::$Quadric(shape) => shape.bounds(),)* }
            }

            fn sample(&self, u: DVec2) -> DVec3 {
                match self { $(Form::$Quadric(shape) => shape.sample(u),)* }
            }

            fn area(&self) -> f64 {
                match self { $(Form::$Quadric(shape) => shape.area(),)* }
            }

            fn shading(&self, p: DVec3) -> Option<ShadingFrame> {
                match self { $(Form::$Quadric(shape) => shape.shading(p),)* }
            }
        }
    };
}

impl ShapeKind {
    /// The file of a mesh that is in one.
    pub fn file(&self) -> Option<&Path> {
        match self {
            ShapeKind::PlyMesh(mesh) | ShapeKind::ObjMesh(mesh) => Some(mesh.path()),
            _ => None,
        }
    }
}

// A new type: its file, which implements `from_params` and `ShapeType` (a quadric: `ObjectSurface`), and a
// line here.
shape_types! {
    quadrics {
        "sphere" => Sphere,
        "disk" => Disk,
        "cone" => Cone,
        "cylinder" => Cylinder,
        "paraboloid" => Paraboloid,
        "hyperboloid" => Hyperboloid,
    }
    others {
        "trianglemesh" => TriangleMesh(trianglemesh::TriangleMeshSpec),
        "plymesh" => PlyMesh(meshfile::MeshFileSpec),
        "objmesh" => ObjMesh(meshfile::MeshFileSpec),
        "loopsubdiv" => LoopSubdiv(loopsubdiv::LoopSubdivSpec),
        "heightfield" => Heightfield(heightfield::HeightfieldSpec),
        "nurbs" => Nurbs(nurbs::NurbsSpec),
        "curve" => Curve(curve::CurveSpec),
    }
}
