//! `Shape "objmesh"`: a mesh in a OBJ file (our extension to the scene language).
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | `string filename` | required | the file, loaded when the scene is built |
//! | `texture/float alpha`, `shadowalpha` | 1 | cut-outs: no surface where exactly 0 |
//!
//! See [`crate::assets::obj`] for what is read.

use super::ShapeError;
use crate::assets::mesh::MeshData;
use crate::assets::obj;
use crate::budget::Budget;
use crate::params::{FloatInput, ParamReader};
use std::path::PathBuf;

/// See the module.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjMeshSpec {
    /// The file.
    pub path: PathBuf,
    /// Cut-outs.
    pub alpha: Option<FloatInput>,
    /// Cut-outs for shadow rays only.
    pub shadow_alpha: Option<FloatInput>,
}

impl ObjMeshSpec {
    /// Reads the parameters; `None` where there is no such file (reported).
    pub fn from_params(reader: &ParamReader) -> Option<ObjMeshSpec> {
        let alpha = reader.find_float_input("alpha");
        let shadow_alpha = reader.find_float_input("shadowalpha");
        if !reader.has("filename") {
            reader.error("filename", "a objmesh needs a \"string filename\"");
            return None;
        }
        Some(ObjMeshSpec {
            path: reader.file("filename")?,
            alpha,
            shadow_alpha,
        })
    }

    /// Loads the file.
    pub fn load(&self, budget: &Budget) -> Result<MeshData, ShapeError> {
        obj::load(&self.path, budget).map_err(|e| ShapeError::File {
            path: e.path,
            message: e.message,
        })
    }
}
