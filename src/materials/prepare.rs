//! What materials need before rays meet them, beyond textures: tables, each made once for all
//! materials alike.

use super::{Material, MaterialKind};
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
        let named = materials
            .iter()
            .filter_map(|material| match &material.kind {
                MaterialKind::Fourier(fourier) => fourier.file.as_ref(),
                _ => None,
            });
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

/// Makes the scattering profiles of all materials (those alike in `g` and `eta` share a table), and
/// gives them their files.
pub fn prepare(materials: &mut [Material], files: &BsdfFiles) {
    let mut tables: BTreeMap<[u32; 2], Arc<ProfileTable>> = BTreeMap::new();
    let mut make = |g: f32, eta: f32| {
        let table = tables.entry([g, eta].map(f32::to_bits));
        Arc::clone(table.or_insert_with(|| Arc::new(ProfileTable::new(g, eta))))
    };
    let mut read = |file: &NamedFile| files.0.get(&file.path).cloned().flatten();
    for material in materials {
        match &mut material.kind {
            MaterialKind::Subsurface(m) => m.interior.prepare(&mut make),
            MaterialKind::KdSubsurface(m) => m.interior.prepare(&mut make),
            MaterialKind::Fourier(m) => m.prepare(&mut read),
            _ => {}
        }
    }
}
