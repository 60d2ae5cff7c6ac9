//! Lens files written: what is written is read back as the same lens.
//!
//! The table of the project ([`super::dat`]) and [JSON](super::json) say all that a lens here is, numbers to the bit. Zemax'
//! format says curvatures, which are rounded once, and calls gaps by their surface; glasses with a formula need a catalogue beside the file.

mod table;
mod zmx;

use super::zmx::MAX_POSITIONS;
use super::{Prescription, json};
use std::path::Path;

/// A file format that lenses are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LensFormat {
    /// The project's table, `.dat`.
    Table,
    /// Zemax, `.zmx`.
    Zemax,
    /// ISET's JSON with more fields, `.json`.
    Json,
}

impl LensFormat {
    /// By the ending of a file's name; `None` for another ending.
    pub fn of(path: &Path) -> Option<LensFormat> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        match ending.as_str() {
            "dat" => Some(LensFormat::Table),
            "zmx" => Some(LensFormat::Zemax),
            "json" => Some(LensFormat::Json),
            _ => None,
        }
    }
}

/// A lens as text.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// The file.
    pub text: String,
    /// A glass catalogue (AGF) that has to lie beside it, with the formulas of its glasses.
    pub catalogue: Option<String>,
}

/// What a format cannot say of a lens. Surfaces are numbered from 1 at the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WriteError {
    /// The stop is a plane there.
    #[error("surface {0} is a stop that is curved or refracts, which has no row in a lens table")]
    Stop(usize),
    /// It has no edge.
    #[error("surface {0} has no clear diameter, which lens files need")]
    NoDiameter(usize),
    /// Groups that move between more positions than are read.
    #[error(
        "the lens has more positions than the {MAX_POSITIONS} that are read of this format; write .dat or .json, or choose one (--zoom, --focus)"
    )]
    Positions,
    /// Zemax' stop is one surface.
    #[error("surface {0} is a second stop, and the format has only one; write .dat or .json")]
    Stops(usize),
    /// Catalogues lack the formula.
    #[error(
        "the dispersion of the glass behind surface {0} is by Cauchy's formula, which glass catalogues lack; write .dat or .json"
    )]
    Formula(usize),
    /// The index is not that of the formula at the d line.
    #[error(
        "the index behind surface {0} is not that of its dispersion formula at the d line, which the format takes it from; write .dat or .json"
    )]
    Index(usize),
    /// Zemax has catalogues of coatings, too.
    #[error(
        "the coating of surface {0} is not a quarter of the d line of index 1.38, the only one that is written for Zemax; write .dat or .json"
    )]
    Coating(usize),
}

impl Prescription {
    /// The lens, called `name`, in a file format.
    ///
    /// # Errors
    /// Fails for a lens that the format cannot say; see [`WriteError`].
    pub fn write_as(&self, format: LensFormat, name: &str) -> Result<Written, WriteError> {
        let alone = |text| Written {
            text,
            catalogue: None,
        };
        match format {
            LensFormat::Table => self.to_table().map(alone),
            LensFormat::Json => json::text(self, name).map(alone),
            LensFormat::Zemax => zmx::written(self, name),
        }
    }
}
