//! `Shape "plymesh"` and `Shape "objmesh"`: a mesh in a PLY file, or in an OBJ file (our extension to the scene
//! language).
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | `string filename` | required | the file, loaded when the scene is built |
//! | `texture/float alpha`, `shadowalpha` | 1 | cut-outs: no surface where exactly 0 |
//!
//! See [`crate::assets::ply`] and [`crate::assets::obj`] for what is read; the number `face_indices` of a PLY file's face
//! tells its face in `ptex` textures.

use super::site::{ShapeType, Site};
use super::{CompiledShape, ShapeError, needed};
use crate::assets::mesh::MeshExtent;
use crate::assets::{obj, ply};
use crate::budget::Budget;
use crate::files::FileError;
use crate::params::ParamReader;
use std::path::{Path, PathBuf};

/// See the module.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFileSpec {
    format: Format,
    path: PathBuf,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Format {
    Ply,
    Obj,
}

impl MeshFileSpec {
    /// Reads the parameters; `None` where there is no such file (reported).
    pub fn from_params(reader: &ParamReader) -> Option<MeshFileSpec> {
        let kind = reader.kind();
        let given = reader.has("filename").then_some(());
        needed(
            reader,
            "filename",
            given,
            format!("a {kind} needs a \"string filename\""),
        );
        let format = match kind {
            "objmesh" => Format::Obj,
            _ => Format::Ply,
        };
        let path = reader.file("filename")?;
        Some(MeshFileSpec { format, path })
    }

    /// The file.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}

impl MeshFileSpec {
    /// How large the mesh is. That of an OBJ file is known only when it is read.
    ///
    /// # Errors
    /// A file that cannot be used.
    pub fn extent(&self) -> Result<MeshExtent, FileError> {
        match self.format {
            Format::Ply => ply::extent(&self.path),
            Format::Obj => {
                let mesh = obj::load(&self.path, &Budget::new(None))?;
                let file = self.path.metadata().map_or(0, |found| found.len());
                Ok(MeshExtent {
                    file,
                    ..MeshExtent::of(&mesh)
                })
            }
        }
    }
}

impl ShapeType for MeshFileSpec {
    fn compile(&self, site: &Site) -> Result<CompiledShape, ShapeError> {
        let loaded = match self.format {
            Format::Ply => ply::load(&self.path, site.budget),
            Format::Obj => obj::load(&self.path, site.budget),
        };
        site.charged_mesh(loaded?)
    }
}
