//! `Shape "plymesh"`: a mesh in a PLY file.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | `string filename` | required | the file, loaded when the scene is built |
//! | `texture/float alpha`, `shadowalpha` | 1 | cut-outs: no surface where exactly 0 |
//!
//! See [`crate::assets::ply`] for what is read; the number `face_indices` of a face tells its face in
//! `ptex` textures.

use super::site::{ShapeType, Site};
use super::{CompiledShape, ShapeError, mesh_file};
use crate::assets::ply;
use crate::params::ParamReader;
use std::path::PathBuf;

/// See the module.
#[derive(Clone, Debug, PartialEq)]
pub struct PlyMeshSpec {
    /// The file.
    pub path: PathBuf,
}

impl PlyMeshSpec {
    /// Reads the parameters; `None` where there is no such file (reported).
    pub fn from_params(reader: &ParamReader) -> Option<PlyMeshSpec> {
        let path = mesh_file(reader)?;
        Some(PlyMeshSpec { path })
    }
}

impl ShapeType for PlyMeshSpec {
    const CUTOUTS: bool = true;

    fn compile(&self, site: &Site) -> Result<CompiledShape, ShapeError> {
        site.charged_mesh(ply::load(&self.path, site.budget).map_err(ShapeError::File)?)
    }
}
