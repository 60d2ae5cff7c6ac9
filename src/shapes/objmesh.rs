//! `Shape "objmesh"`: a mesh in a OBJ file (our extension to the scene language).
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | `string filename` | required | the file, loaded when the scene is built |
//! | `texture/float alpha`, `shadowalpha` | 1 | cut-outs: no surface where exactly 0 |
//!
//! See [`crate::assets::obj`] for what is read.

use super::site::{ShapeType, Site};
use super::{CompiledShape, ShapeError, mesh_file};
use crate::assets::obj;
use crate::params::ParamReader;
use std::path::PathBuf;

/// See the module.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjMeshSpec {
    /// The file.
    pub path: PathBuf,
}

impl ObjMeshSpec {
    /// Reads the parameters; `None` where there is no such file (reported).
    pub fn from_params(reader: &ParamReader) -> Option<ObjMeshSpec> {
        let path = mesh_file(reader)?;
        Some(ObjMeshSpec { path })
    }
}

impl ShapeType for ObjMeshSpec {
    const CUTOUTS: bool = true;

    fn compile(&self, site: &Site) -> Result<CompiledShape, ShapeError> {
        site.charged_mesh(obj::load(&self.path, site.budget).map_err(ShapeError::File)?)
    }
}
