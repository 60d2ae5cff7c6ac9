//! Shapes, one file each, named as in the scene file.
//!
//! A [`ShapeSpec`] is what the scene file says, in object space and double precision;
//! [`ShapeSpec::compile`] loads what it names and places it; [`emitter::Emitter`] is a shape that
//! light is sampled from.

pub mod emitter;

use crate::math::transform::Transform;
use crate::params::{FloatInput, ParamReader};
use emitter::Emitter;
use std::path::PathBuf;

/// Why a shape cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum ShapeError {
    /// The object-to-world matrix has no inverse.
    #[error("the transformation of this shape is singular")]
    Singular,
    /// A mesh file cannot be used.
    #[error("{}: {message}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
}

/// A shape as the scene file describes it.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeSpec {}

impl ShapeSpec {
    /// Reads the shape `reader.kind()`. `None` where it cannot be made (reported) or the kind is
    /// none of [`ShapeSpec::KINDS`] (not reported: the caller knows what else it might mean).
    pub fn from_params(_reader: &ParamReader) -> Option<ShapeSpec> {
        todo!()
    }

    /// The kinds that can be rendered.
    pub const KINDS: [&'static str; 7] = [
        "sphere",
        "disk",
        "cone",
        "cylinder",
        "trianglemesh",
        "plymesh",
        "objmesh",
    ];

    /// The cut-out texture of a mesh.
    pub fn alpha(&self) -> Option<FloatInput> {
        todo!()
    }

    /// The cut-out texture of a mesh for shadow rays.
    pub fn shadow_alpha(&self) -> Option<FloatInput> {
        todo!()
    }

    /// Loads and places the shape. `level_from_object` is object-to-render for the top level,
    /// object-to-world for shapes of a named object.
    pub fn compile(
        &self,
        _level_from_object: &Transform,
        _reverse_orientation: bool,
    ) -> Result<CompiledShape, ShapeError> {
        todo!()
    }
}

/// A shape in place, in double precision.
pub enum CompiledShape {}

impl CompiledShape {
    /// How many lights the shape makes: one, or one per triangle (those of zero area too).
    pub fn emitter_count(&self) -> usize {
        todo!()
    }

    /// The shape as lights, in the order that [`crate::accel::PrimitiveAttributes::light`] counts.
    pub fn emitters(&self) -> Vec<Emitter> {
        todo!()
    }

    /// What was odd in the shape's file, in words.
    pub fn warnings(&self) -> &[String] {
        todo!()
    }
}
