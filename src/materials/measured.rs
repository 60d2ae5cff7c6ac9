//! The `measured` material.

use super::prepare::Tables;
use super::{Place, Scattering};
use crate::bsdf::measured::{MeasuredLobe, MeasuredTable};
use crate::bsdf::{Bsdf, Lobe};
use crate::params::{NamedFile, ParamReader};
use std::sync::Arc;

/// pbrt-v2's measured BRDF; pbrt-v3 has none. Parameter: constant string `filename`, a list of samples
/// ([`crate::assets::brdf_file`]) if it ends in `.brdf`, otherwise a MERL table ([`crate::assets::merl_file`]). Without
/// one, or with one that cannot be read (an error), the surface is black.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The file.
    pub file: Option<NamedFile>,
    /// Its table, once it has been read.
    table: Option<Arc<MeasuredTable>>,
}

impl Measured {
    /// Reads the parameter.
    pub fn from_params(reader: &ParamReader) -> Measured {
        let file = reader.named_file("filename");
        if file.is_none() && !reader.has("filename") {
            reader.error("filename", "`measured` needs a `string filename`");
        }
        Measured { file, table: None }
    }
}

impl Scattering for Measured {
    fn add_lobes<'a>(&'a self, _: &Place, bsdf: &mut Bsdf<'a>) {
        if let Some(table) = self.table.as_deref().filter(|table| !table.is_black()) {
            bsdf.add(Lobe::Measured(MeasuredLobe::new(table)));
        }
    }

    fn file(&self) -> Option<&NamedFile> {
        self.file.as_ref()
    }

    fn prepare(&mut self, tables: &mut Tables) {
        self.table = self.file.as_ref().and_then(|file| tables.measured(file));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::testing::read;

    #[test]
    fn a_file_is_needed() {
        for params in ["", "\"string filename\" \"no such.brdf\""] {
            let outcome = read("measured", params, Measured::from_params);
            let found = (outcome.errors, outcome.value.file);
            assert_eq!(found, (1, None), "{}", outcome.text);
        }
    }
}
