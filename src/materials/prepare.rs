//! What materials need before rays meet them, beyond textures: tables, each made once for all
//! materials alike.

use super::Material;
use crate::assets::bsdf_file::BsdfFile;
use crate::bsdf::fourier::FourierTable;
use crate::bssrdf::ProfileTable;
use crate::params::NamedFile;
use crate::syntax::{Diagnostic, Diagnostics};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// The `.bsdf` files of a scene; `None` for those that cannot be read.
pub struct BsdfFiles(BTreeMap<PathBuf, Option<Arc<FourierTable>>>);

impl BsdfFiles {
    /// Reads the files that materials name. Those that are broken are errors, at the first name.
    pub fn load(materials: &[Material], diagnostics: &Diagnostics) -> BsdfFiles {
        let mut files = BTreeMap::new();
        let named = materials.iter().filter_map(|material| material.kind.file());
        for NamedFile { path, span } in named {
            files.entry(path.clone()).or_insert_with(|| {
                let read = BsdfFile::read(path).map(|file| Arc::new(FourierTable::new(file)));
                read.map_err(|error| {
                    let message = format!("cannot use the BSDF file '{}': {error}", path.display());
                    diagnostics.push(Diagnostic::error(message).at(*span).passable());
                })
                .ok()
            });
        }
        BsdfFiles(files)
    }
}

/// Tables that materials take.
pub(super) struct Tables<'a> {
    /// By the bits of `g` and `eta`.
    profiles: BTreeMap<[u32; 2], Arc<ProfileTable>>,
    files: &'a BsdfFiles,
}

impl Tables<'_> {
    /// Scattering profiles; materials alike in `g` and `eta` share them.
    pub fn profiles(&mut self, g: f32, eta: f32) -> Arc<ProfileTable> {
        let table = self.profiles.entry([g, eta].map(f32::to_bits));
        Arc::clone(table.or_insert_with(|| Arc::new(ProfileTable::new(g, eta))))
    }

    /// The BSDF of a file; `None` where it cannot be read.
    pub fn bsdf(&self, file: &NamedFile) -> Option<Arc<FourierTable>> {
        self.files.0.get(&file.path).cloned().flatten()
    }
}

/// Gives all materials the tables that they need.
pub fn prepare(materials: &mut [Material], files: &BsdfFiles) {
    let mut tables = Tables {
        profiles: BTreeMap::new(),
        files,
    };
    for material in materials {
        material.kind.prepare(&mut tables);
    }
}
