//! Lens tables (`lenses/*.dat`).
//!
//! One row per surface, from the scene to the film, lengths in millimeters:
//!
//! ```text
//! radius thickness index aperture         # four columns, as pbrt
//! radius thickness n_d   V aperture       # five columns, with the Abbe number, as the lecture
//! ```
//!
//! * `radius` > 0: the center of curvature lies on the film side. 0 is an aperture stop (so is the
//!   word `stop`), `inf` a plane; a row with radius 0 whose index differs from the medium in front of it
//!   can be no stop and is read as a plane glass surface, with a warning.
//! * `thickness`: to the next surface; in the last row to the film.
//! * `index`: of the space behind the surface; 0 or blank is air (at a stop: unchanged).
//! * `aperture`: full clear diameter.
//!
//! Behind the columns may follow, in any order, what they have no room for:
//!
//! ```text
//! k=-0.8 A4=1.2e-6 A6=-3e-9                            # conic constant, coefficients of r², r⁴ … r¹⁶ (A2 … A16)
//! cauchy=1.5046,0.0042,0                               # n = a + b/λ² + c/λ⁴, λ in µm, of the space behind
//! sellmeier=1.0396,0.2318,1.0105,0.0060,0.0200,103.56  # b1,b2,b3,c1,c2,c3 of n² = 1 + Σ b λ²/(λ²−c)
//! agf=5,1.4928,0.0114,0.00039                          # a formula of glass catalogues by its number, and its coefficients
//! glass=N-BK7                                          # a name, for the reader
//! coating=1.38@550                                     # index of a layer on the surface, a quarter of that wavelength (nm) thick
//! ```
//!
//! Lines that begin with `zoom`, `focus` or `gap` say how groups move; see [`super::positions`].
//!
//! A first row of one number, which ISET's tables have, is the focal length, and passed over.
//!
//! `#` starts a comment anywhere; columns are separated by blanks or tabs; lines end in LF or
//! CRLF, the last one in nothing if it likes. A blank index is recognized by the number of
//! columns, or by an empty cell where single tabs separate all columns.
//!
//! ```
//! let lens = fstop::optics::Prescription::parse("50 5 1.5168 64.2 20\n-50 95.2 20 # air\n")?;
//! assert_eq!(lens.surfaces.len(), 2);
//! assert_eq!(lens.film_distance, 95.2);
//! # Ok::<(), fstop::optics::PrescriptionError>(())
//! ```

use super::cells::{Cell, Row, lines, number, split};
use super::extras::Extras;
use super::positions::Positions;
use super::{INDICES, Notes, Prescription, PrescriptionError, RowNote};
use crate::optics::dispersion::{Dispersion, LINE_D};
use crate::optics::surface::Surface;
use std::collections::BTreeSet;

/// Reads a table.
pub fn parse(text: &str) -> Result<Prescription, PrescriptionError> {
    let (mut rows, mut notes) = (Vec::new(), Notes::default());
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    // A lone CR ended lines once; CRLF gives an empty line between, which is skipped.
    for (line, content) in lines(text) {
        let (cells, extras) = split(content.split('#').next().unwrap_or(""));
        if Positions::is_line(&cells) {
            notes.positions.read(line, &cells, &mut notes.errors);
            continue;
        }
        // ISET's tables begin by the focal length in a row of its own, which follows from the others.
        if rows.is_empty() && is_focal_length(&cells) && extras.is_empty() {
            continue;
        }
        if !cells.is_empty() || !extras.is_empty() {
            rows.push(Row {
                line,
                row: rows.len() + 1,
                cells,
                extras,
            });
        }
    }
    let Some(last) = rows.last() else {
        return Err(PrescriptionError::Empty);
    };
    let mut reader = Reader {
        five_columns: rows.iter().any(|r| r.cells.len() == 5),
        medium: 1.0,
        notes,
    };
    let surfaces: Vec<Surface> = rows.iter().filter_map(|row| reader.surface(row)).collect();
    if let Some(first) = reader.notes.errors.first()
        && surfaces.is_empty()
        && rows.len() > 1
    {
        return Err(PrescriptionError::NoLens {
            rows: rows.len(),
            line: first.line,
            column: first.column,
        });
    }
    if reader.medium != 1.0 {
        let medium = reader.medium;
        reader.warn(
            last,
            format!("the last space has index {medium}: the film lies in glass"),
        );
    }
    reader.notes.prescription(surfaces)
}

/// One number alone.
fn is_focal_length(cells: &[Cell]) -> bool {
    matches!(cells, [only] if only.text.parse::<f64>().is_ok_and(f64::is_finite))
}

/// Turns rows into surfaces, collecting what is wrong.
struct Reader {
    /// `true` if any row has five columns.
    five_columns: bool,
    /// Index of the space in front of the next row.
    medium: f64,
    notes: Notes,
}

/// Absolute radii this side of which curvature and its square are ordinary numbers.
const RADIUS_RANGE: std::ops::RangeInclusive<f64> = 1e-6..=1e30;

/// How far an index of three digits is off.
const ROUNDED_INDEX: f64 = 1e-3;

impl Row<'_> {
    fn note(&self, cell: Option<&Cell>, message: impl Into<String>) -> RowNote {
        RowNote {
            line: self.line,
            column: cell.map_or(1, |c| c.column),
            row: self.row,
            message: message.into(),
        }
    }
}

impl Reader {
    fn warn(&mut self, row: &Row, message: impl Into<String>) {
        let note = row.note(row.cells.first(), message);
        self.notes.warnings.push(note);
    }

    fn error(&mut self, row: &Row, cell: Option<&Cell>, message: impl Into<String>) {
        self.notes.errors.push(row.note(cell, message));
    }

    /// What `read` makes of a cell; `None` where there is no cell or it has an error.
    fn value<T>(
        &mut self,
        row: &Row,
        cell: Option<Cell>,
        read: impl FnOnce(&str) -> Result<T, String>,
    ) -> Option<T> {
        let cell = cell?;
        let value = read(cell.text);
        value
            .map_err(|message| self.error(row, Some(&cell), message))
            .ok()
    }

    /// Reads one row; `None` where it has an error.
    fn surface(&mut self, row: &Row) -> Option<Surface> {
        let columns = self.columns(row)?;
        let before = self.notes.errors.len();
        let radius = self.value(row, columns[0], radius).flatten();
        let thickness = self.thickness(row, columns[1]);
        let index = self.value(row, columns[2], index).flatten();
        let abbe = self.value(row, columns[3], abbe).flatten();
        let aperture = self.value(row, columns[4], aperture);
        let mut extras = Extras::default();
        let mut names = BTreeSet::new();
        for cell in &row.extras {
            self.value(row, Some(*cell), |word| {
                let name = word.split('=').next().unwrap_or_default();
                match names.insert(name.to_ascii_lowercase()) {
                    true => extras.read(word),
                    false => Err(format!("{name} is given twice")),
                }
            });
        }
        if self.notes.errors.len() > before {
            return None;
        }
        let (thickness, aperture) = (thickness?, aperture?);
        if thickness < 0.0 {
            let message = format!(
                "thickness {thickness} mm is negative: the next surface lies in front of this one"
            );
            let note = row.note(columns[1].as_ref(), message);
            self.notes.warnings.push(note);
        }
        // A stop changes no medium. Radius 0 with a new medium behind is a plane glass surface.
        let is_stop = radius.is_none_or(|r| r == 0.0 && index.is_none_or(|n| n == self.medium));
        let radius = radius.unwrap_or(0.0);
        let given = index;
        let index = match is_stop {
            true => self.medium,
            false => index.unwrap_or(1.0),
        };
        if is_stop && index != 1.0 && given != Some(index) {
            self.warn(
                row,
                format!(
                    "a stop within glass of index {index}: light stays in it behind the stop (pbrt would continue in air)"
                ),
            );
        }
        if radius == 0.0 && !is_stop {
            let before = self.medium;
            self.warn(
                row,
                format!(
                    "radius 0 between indices {before} and {index} is read as a plane glass surface; write `inf` (pbrt would read a stop)"
                ),
            );
        }
        let index = match extras.dispersion.filter(|_| !is_stop) {
            Some(formula) => self.agreed(row, columns[2].as_ref(), index, &formula),
            None => index,
        };
        self.medium = index;
        if is_stop && extras.asphere.is_some() {
            let message =
                "a stop with aspheric terms; write `inf` for the radius of an aspheric plate";
            self.error(row, row.cells.first(), message);
            return None;
        }
        let surface = Surface {
            radius: if radius == 0.0 { f64::INFINITY } else { radius },
            thickness,
            index,
            abbe: abbe.filter(|_| index != 1.0),
            dispersion: extras.dispersion,
            glass: extras.glass,
            aperture,
            is_stop,
            asphere: extras.asphere,
            coating: extras.coating,
        };
        if surface.clear_radius() < 0.5 * aperture {
            self.warn(
                row,
                format!("aperture {aperture} mm reaches beyond the equator of a surface of radius {radius} mm"),
            );
        }
        Some(surface)
    }

    /// The index where a dispersion formula tells it as well as the column, which counts: it may be for another line than d. A formula alone, or
    /// behind an index of air, is that of the glass.
    fn agreed(&mut self, row: &Row, cell: Option<&Cell>, column: f64, formula: &Dispersion) -> f64 {
        let index = formula.index(LINE_D);
        if (index - column).abs() <= ROUNDED_INDEX {
            return column;
        }
        let is_blank = column == 1.0 && cell.is_none_or(|cell| self::index(cell.text) == Ok(None));
        let (counts, what) = match column == 1.0 {
            true => (index, "the formula counts"),
            false => (
                column,
                "the column counts, but with \"dispersion\" the formula does",
            ),
        };
        if !is_blank {
            let message = format!(
                "the dispersion formula gives an index of {index:.5} at the d line, the column {column}: {what}"
            );
            self.notes.warnings.push(row.note(cell, message));
        }
        counts
    }

    /// A number, or the name of a gap.
    fn thickness(&mut self, row: &Row, cell: Option<Cell>) -> Option<f64> {
        let positions = &mut self.notes.positions;
        if let Some(gap) = cell.and_then(|cell| positions.gap(cell.text)) {
            return Some(positions.place(gap, row.row - 1));
        }
        self.value(row, cell, |t| number(t, "the thickness in mm"))
    }

    /// The cells of radius, thickness, index, Abbe number and aperture, as far as the row has them.
    fn columns<'a>(&mut self, row: &Row<'a>) -> Option<[Option<Cell<'a>>; 5]> {
        match row.cells[..] {
            [radius, thickness, index, abbe, aperture] => {
                Some([radius, thickness, index, abbe, aperture].map(Some))
            }
            [radius, thickness, index, aperture] => Some([
                Some(radius),
                Some(thickness),
                Some(index),
                None,
                Some(aperture),
            ]),
            [_, _, last] if plausible_index(last.text) => {
                let message = format!(
                    "three columns, the last of which, {}, may be an index or an aperture; expected radius, thickness, index, aperture (write index 1 for air)",
                    last.text
                );
                self.error(row, Some(&last), message);
                None
            }
            [radius, thickness, aperture] => {
                Some([Some(radius), Some(thickness), None, None, Some(aperture)])
            }
            [thickness, aperture] if self.five_columns => {
                self.warn(
                    row,
                    "two columns are read as thickness and aperture of a stop",
                );
                Some([None, Some(thickness), None, None, Some(aperture)])
            }
            ref cells => {
                let n = cells.len();
                let what = if n > 5 {
                    "; write conic and aspheric coefficients as k=-1 A4=1e-6 behind the columns"
                } else {
                    ""
                };
                let message = format!(
                    "{n} columns; expected radius, thickness, index, aperture or radius, thickness, n_d, V, aperture{what}"
                );
                self.error(row, cells.get(5), message);
                None
            }
        }
    }
}

/// The radius in mm; infinite for a plane, `None` for the word `stop` or a blank.
fn radius(text: &str) -> Result<Option<f64>, String> {
    let stop = ["", "stop", "sto", "aperture"];
    if stop.iter().any(|word| text.eq_ignore_ascii_case(word)) {
        return Ok(None);
    }
    // Not for a number too large to be one.
    let infinite = text.parse::<f64>().is_ok_and(f64::is_infinite);
    if infinite && !text.contains(|c: char| c.is_ascii_digit()) {
        return Ok(Some(f64::INFINITY));
    }
    let radius = number(text, "the radius in mm")?;
    if radius != 0.0 && !RADIUS_RANGE.contains(&radius.abs()) {
        return Err(format!(
            "a radius of {radius} mm; expected between 1e-6 and 1e30, `inf` for a plane or 0 for a stop"
        ));
    }
    Ok(Some(radius))
}

/// The refractive index; `None` where it is blank or 0.
fn index(text: &str) -> Result<Option<f64>, String> {
    if text.eq_ignore_ascii_case("air") {
        return Ok(Some(1.0));
    }
    if text.starts_with(|c: char| c.is_ascii_alphabetic()) {
        return Err(format!(
            "glass names such as {text} cannot be read; expected the refractive index n_d"
        ));
    }
    match text {
        "" => Ok(None),
        _ => match number(text, "the refractive index")? {
            0.0 => Ok(None),
            n if INDICES.contains(&n) => Ok(Some(n)),
            n => Err(format!(
                "a refractive index of {n}; expected 1 to about 4, or 0 for air"
            )),
        },
    }
}

/// The Abbe number; `None` for air, and where it is not given.
fn abbe(text: &str) -> Result<Option<f64>, String> {
    if matches!(text, "" | "-" | "inf") {
        return Ok(None);
    }
    let v = number(text, "the Abbe number V")?;
    if v < 0.0 {
        return Err(format!(
            "an Abbe number of {v}; expected a positive number, or 0 for air"
        ));
    }
    Ok(Some(v).filter(|v| *v > 0.0))
}

fn aperture(text: &str) -> Result<f64, String> {
    let d = number(text, "the aperture diameter in mm")?;
    if d <= 0.0 {
        return Err(format!(
            "an aperture diameter of {d} mm; expected a positive length"
        ));
    }
    Ok(d)
}

/// Returns `true` if this could be the refractive index of a glass, of which lenses have 1.3 to 2.2.
fn plausible_index(text: &str) -> bool {
    text.parse::<f64>().is_ok_and(|n| (1.0..=2.5).contains(&n))
}
