//! The `fourier` material.

use super::prepare::Tables;
use super::{Place, Scattering};
use crate::bsdf::fourier::{FourierLobe, FourierTable};
use crate::bsdf::{Bsdf, Lobe};
use crate::params::{NamedFile, ParamReader};
use std::sync::Arc;

/// A tabulated BSDF (docs/scene-language.md §3.8). Parameter: constant string `bsdffile`, a file read by
/// [`crate::assets::bsdf_file`]. Without one, or with one that cannot be read (an error), the surface is black.
#[derive(Clone, Debug, PartialEq)]
pub struct Fourier {
    /// The file.
    pub file: Option<NamedFile>,
    /// Its table, once it has been read.
    table: Option<Arc<FourierTable>>,
}

impl Fourier {
    /// Reads the parameter.
    pub fn from_params(reader: &ParamReader) -> Fourier {
        let file = reader.named_file("bsdffile");
        if file.is_none() && !reader.has("bsdffile") {
            reader.error("bsdffile", "`fourier` needs a `string bsdffile`");
        }
        Fourier { file, table: None }
    }
}

impl Scattering for Fourier {
    fn add_lobes<'a>(&'a self, _: &Place, bsdf: &mut Bsdf<'a>) {
        if let Some(table) = self.table.as_deref().filter(|table| !table.is_black()) {
            bsdf.add(Lobe::Fourier(FourierLobe::new(table)));
        }
    }

    fn file(&self) -> Option<&NamedFile> {
        self.file.as_ref()
    }

    fn prepare(&mut self, tables: &mut Tables) {
        self.table = self.file.as_ref().and_then(|file| tables.bsdf(file));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::testing::read;

    #[test]
    fn a_file_is_needed() {
        for params in ["", "\"string bsdffile\" \"no such.bsdf\""] {
            let outcome = read("fourier", params, Fourier::from_params);
            assert_eq!(
                (outcome.errors, outcome.value.file),
                (1, None),
                "{}",
                outcome.text
            );
        }
    }
}
