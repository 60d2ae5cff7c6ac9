//! Precomputed tables of materials, each made once and shared by all materials that use it.

use super::{Material, MaterialKind};
use crate::assets::bsdf_file::BsdfFile;
use crate::bsdf::fourier::FourierTable;
use crate::bsdf::measured::MeasuredTable;
use crate::bssrdf::ProfileTable;
use crate::files::FileError;
use crate::params::NamedFile;
use crate::syntax::{Diagnostic, Diagnostics};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The tables of a scene's files, by path; `None` for those that cannot be read.
type ByPath<Table> = BTreeMap<PathBuf, Option<Arc<Table>>>;

/// The tabulated BSDFs that materials refer to.
#[derive(Default)]
pub struct BsdfFiles {
    fourier: ByPath<FourierTable>,
    measured: ByPath<MeasuredTable>,
}

impl BsdfFiles {
    /// Reads the files that materials name. Invalid ones are errors, at the first name.
    pub fn load(materials: &[Material], diagnostics: &Diagnostics) -> BsdfFiles {
        let mut files = BsdfFiles::default();
        for material in materials {
            let Some(file) = material.kind.scattering().file() else {
                continue;
            };
            match &material.kind {
                MaterialKind::Measured(_) => {
                    load(&mut files.measured, file, diagnostics, MeasuredTable::read)
                }
                _ => load(&mut files.fourier, file, diagnostics, |path| {
                    BsdfFile::read(path).map(FourierTable::new)
                }),
            }
        }
        files
    }
}

/// Reads a file unless it has been read before.
fn load<Table>(
    tables: &mut ByPath<Table>,
    NamedFile { path, span }: &NamedFile,
    diagnostics: &Diagnostics,
    read: impl FnOnce(&Path) -> Result<Table, FileError>,
) {
    tables.entry(path.clone()).or_insert_with(|| {
        let table = read(path).map_err(|error| {
            let message = format!("cannot use the BSDF file '{}': {error}", path.display());
            let diagnostic = Diagnostic::error(message).at(*span).recoverable();
            diagnostics.push(diagnostic.failed_if(error.is_failure));
        });
        table.ok().map(Arc::new)
    });
}

/// Tables for materials.
pub(super) struct Tables<'a> {
    /// By the bits of `g` and `eta`.
    profiles: BTreeMap<[u32; 2], Arc<ProfileTable>>,
    files: &'a BsdfFiles,
}

impl Tables<'_> {
    /// Scattering profiles; materials with the same `g` and `eta` share them.
    pub(super) fn profiles(&mut self, g: f32, eta: f32) -> Arc<ProfileTable> {
        let table = self.profiles.entry([g, eta].map(f32::to_bits));
        Arc::clone(table.or_insert_with(|| Arc::new(ProfileTable::new(g, eta))))
    }

    /// The BSDF of a file; `None` if it cannot be read.
    pub(super) fn bsdf(&self, file: &NamedFile) -> Option<Arc<FourierTable>> {
        self.files.fourier.get(&file.path).cloned().flatten()
    }

    /// The measured BRDF of a file; `None` if it cannot be read.
    pub(super) fn measured(&self, file: &NamedFile) -> Option<Arc<MeasuredTable>> {
        self.files.measured.get(&file.path).cloned().flatten()
    }
}

/// Provides all materials with the tables that they need.
pub fn prepare(materials: &mut [Material], files: &BsdfFiles) {
    let mut tables = Tables {
        profiles: BTreeMap::new(),
        files,
    };
    for material in materials {
        material.kind.prepare(&mut tables);
    }
}
