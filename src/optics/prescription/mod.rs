//! Lens prescriptions: what a lens is made of, and the files that say so.
//!
//! * [`dat`]: the table of the course and of pbrt, with aspheric and dispersion terms added;
//! * [`zmx`]: Zemax' sequential files, with the [`glass`] names they use and the catalogues ([`agf`]) that have them;
//! * [`json`]: ISET's lenses in JSON, and what they have no fields for; [`optiland`]: those of optiland;
//! * [`seq`]: CODE V; [`oslo`]: OSLO; [`optbench`]: Optical Bench;
//! * [`mod@write`]: files written.

pub mod agf;
mod cells;
pub mod dat;
mod design;
mod extras;
pub mod glass;
pub mod json;
pub mod optbench;
pub mod optiland;
pub mod oslo;
pub mod positions;
pub mod seq;
#[cfg(test)]
mod tests;
pub mod write;
pub mod zmx;

pub use self::design::decode;
pub use self::glass::Glasses;

use super::report::length_text;
use super::surface::Surface;
use crate::files::{self, FileProblem};
use positions::Positions;
use std::fmt;
use std::path::Path;

/// The largest file taken for a lens, in bytes; those of zooms with all their notes have 100 kB.
const LARGEST: u64 = 16 << 20;

/// Messages about rows that are shown where they make one line; who mends a file sees the pattern
/// by then.
const ROWS_SHOWN: usize = 5;

/// Refractive indices that a medium may have.
const INDICES: std::ops::RangeInclusive<f64> = 1.0..=6.0;

/// A lens: its surfaces from the scene to the film.
#[derive(Clone, Debug, PartialEq)]
pub struct Prescription {
    /// At least one. The last one's thickness is 0; see `film_distance`.
    pub surfaces: Vec<Surface>,
    /// From the last vertex to the film in mm: the last row's thickness; 0 where the file leaves
    /// it open.
    pub film_distance: f64,
    /// How its groups move; `None` for a lens in one piece.
    pub positions: Option<Box<Positions>>,
    /// What is odd about the file although it can be read.
    pub warnings: Vec<RowNote>,
}

/// Something to say about one place of a lens file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RowNote {
    /// Line in the file, from 1.
    pub line: usize,
    /// Column in that line, in characters from 1.
    pub column: usize,
    /// Row of the table, from 1; 0 of a line that is none.
    pub row: usize,
    /// What is wrong and what was expected, or done.
    pub message: String,
}

impl fmt::Display for RowNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, column {}", self.line, self.column)?;
        if self.row > 0 {
            write!(f, " (row {})", self.row)?;
        }
        write!(f, ": {}", self.message)
    }
}

/// Why a lens file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum PrescriptionError {
    /// The file itself.
    #[error("{0}")]
    Unreadable(#[from] FileProblem),
    /// No rows.
    #[error("the lens file has no surfaces")]
    Empty,
    /// Not one row can be read: whatever it is, its text is not repeated.
    #[error(
        "this is not a lens file: none of its {rows} rows reads as radius, thickness, index, aperture; the first fails at line {line}, column {column}"
    )]
    NoLens {
        /// Lines with something in them.
        rows: usize,
        /// Of the first mistake, from 1.
        line: usize,
        /// Of the first mistake, from 1.
        column: usize,
    },
    /// Every row that cannot be read.
    #[error("{}", in_one_line(.0))]
    Rows(Vec<RowNote>),
}

impl PrescriptionError {
    /// Returns `true` if the file might be read elsewhere or later.
    pub fn is_failure(&self) -> bool {
        matches!(self, PrescriptionError::Unreadable(problem) if problem.is_failure())
    }
}

/// What there is to say about a file by the time it is read.
#[derive(Default)]
struct Notes {
    warnings: Vec<RowNote>,
    errors: Vec<RowNote>,
    positions: Positions,
}

impl Notes {
    /// The lens of these surfaces, the last of which has its distance from the film as thickness; if nothing is wrong.
    fn prescription(
        mut self,
        mut surfaces: Vec<Surface>,
    ) -> Result<Prescription, PrescriptionError> {
        let mut positions = None;
        if self.errors.is_empty() && !self.positions.is_empty() {
            match self.positions.checked() {
                Ok(checked) => positions = Some(Box::new(checked)),
                Err(note) => self.errors.push(note),
            }
        }
        if !self.errors.is_empty() {
            return Err(PrescriptionError::Rows(self.errors));
        }
        let last = surfaces.last_mut().ok_or(PrescriptionError::Empty)?;
        Ok(Prescription {
            film_distance: std::mem::take(&mut last.thickness),
            surfaces,
            positions,
            warnings: self.warnings,
        })
    }
}

fn in_one_line(notes: &[RowNote]) -> String {
    let shown = notes.iter().take(ROWS_SHOWN);
    let text = shown.map(RowNote::to_string).collect::<Vec<_>>().join("; ");
    match notes.len().saturating_sub(ROWS_SHOWN) {
        0 => text,
        more => format!("{text}; … and {more} more"),
    }
}

impl Prescription {
    /// Reads the file at `path`: by its ending Zemax (`.zmx`), CODE V (`.seq`), OSLO (`.len`) or JSON (`.json`), by its content JSON or Optical Bench, else
    /// the table. Glasses are looked up as [`Glasses::beside`] says.
    pub fn read(path: &Path) -> Result<Prescription, PrescriptionError> {
        let bytes = files::read(path, LARGEST)?;
        let text = design::decode(&bytes);
        let glasses = || Glasses::beside(path);
        let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
        match ending.to_str().unwrap_or_default() {
            "zmx" => zmx::parse(&text, &glasses()),
            "seq" => seq::parse(&text, &glasses()),
            "len" => oslo::parse(&text, &glasses()),
            _ if text.trim_start().starts_with('{') => match optiland::is_file(&text) {
                true => optiland::parse(&text, &glasses()),
                false => json::parse(&text),
            },
            "json" => json::parse(&text),
            _ if optbench::is_file(&text) => optbench::parse(&text, &glasses()),
            // Old lens files have Latin-1 comments: replaced characters there harm nobody.
            _ => Prescription::parse(&text),
        }
    }

    /// Reads a table; see [`dat`].
    pub fn parse(text: &str) -> Result<Prescription, PrescriptionError> {
        dat::parse(text)
    }

    /// Distance from the first vertex to the last, mm.
    pub fn length(&self) -> f64 {
        self.surfaces.iter().map(|s| s.thickness).sum()
    }

    /// Returns `true` if it has an aperture stop.
    pub fn has_stop(&self) -> bool {
        self.surfaces.iter().any(|s| s.is_stop)
    }

    /// All lengths times `factor`, as prescriptions are scaled to another focal length.
    pub fn scaled(mut self, factor: f64) -> Prescription {
        for s in &mut self.surfaces {
            s.radius *= factor;
            s.thickness *= factor;
            s.aperture *= factor;
            s.asphere = s.asphere.map(|a| a.scaled(factor));
        }
        self.film_distance *= factor;
        if let Some(positions) = &mut self.positions {
            positions.scale(factor);
        }
        self
    }

    /// Sets every stop to `diameter` mm, as pbrt does. A stop cannot open wider than its own row
    /// says: there the row's value stays, and the returned lines say so.
    pub fn set_stops(&mut self, diameter: f64) -> Vec<String> {
        let mut notes = Vec::new();
        for (i, s) in self
            .surfaces
            .iter_mut()
            .enumerate()
            .filter(|(_, s)| s.is_stop)
        {
            if diameter > s.aperture {
                notes.push(format!(
                    "aperture diameter {} mm is larger than the {} mm of the stop in row {}, which is kept",
                    length_text(diameter),
                    length_text(s.aperture),
                    i + 1
                ));
            } else {
                s.aperture = diameter;
            }
        }
        notes
    }
}
