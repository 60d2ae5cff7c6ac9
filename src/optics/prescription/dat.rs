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
//! ```
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

use super::cells::{Row, lines, split};
use super::extras::Extras;
use super::{Prescription, PrescriptionError, RowNote};
use crate::optics::surface::Surface;

/// Reads a table.
pub fn parse(text: &str) -> Result<Prescription, PrescriptionError> {
    let mut rows = Vec::new();
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    // A lone CR ended lines once; CRLF gives an empty line between, which is skipped.
    for (line, content) in lines(text) {
        let (cells, extras) = split(content.split('#').next().unwrap_or(""));
        if !cells.is_empty() || !extras.is_empty() {
            rows.push(Row {
                line,
                row: rows.len() + 1,
                cells,
                extras,
            });
        }
    }
    if rows.is_empty() {
        return Err(PrescriptionError::Empty);
    }
    let five_columns = rows.iter().any(|r| r.cells.len() == 5);
    let mut reader = Reader {
        medium: 1.0,
        warnings: Vec::new(),
        errors: Vec::new(),
    };
    let mut surfaces: Vec<Surface> = rows
        .iter()
        .filter_map(|row| reader.surface(row, five_columns))
        .collect();
    if let Some(first) = reader.errors.first() {
        if surfaces.is_empty() && rows.len() > 1 {
            return Err(PrescriptionError::NoLens {
                rows: rows.len(),
                line: first.line,
                column: first.column,
            });
        }
        return Err(PrescriptionError::Rows(reader.errors));
    }
    let film_distance = surfaces
        .last_mut()
        .map_or(0.0, |s| std::mem::take(&mut s.thickness));
    if reader.medium != 1.0
        && let Some(row) = rows.last()
    {
        reader.warn(
            row,
            0,
            format!(
                "the last space has index {}: the film lies in glass",
                reader.medium
            ),
        );
    }
    Ok(Prescription {
        surfaces,
        film_distance,
        warnings: reader.warnings,
    })
}

/// Turns rows into surfaces, collecting what is wrong.
struct Reader {
    /// Index of the space in front of the next row.
    medium: f64,
    warnings: Vec<RowNote>,
    errors: Vec<RowNote>,
}

/// Absolute radii this side of which curvature and its square are ordinary numbers.
const RADIUS_RANGE: std::ops::RangeInclusive<f64> = 1e-6..=1e30;

impl Reader {
    fn note(row: &Row, cell: usize, message: String) -> RowNote {
        RowNote {
            line: row.line,
            column: row.cells.get(cell).map_or(1, |c| c.column),
            row: row.row,
            message,
        }
    }

    fn warn(&mut self, row: &Row, cell: usize, message: String) {
        self.warnings.push(Reader::note(row, cell, message));
    }

    fn error(&mut self, row: &Row, cell: usize, message: String) {
        self.errors.push(Reader::note(row, cell, message));
    }

    /// Reads one row; `None` where it has an error.
    fn surface(&mut self, row: &Row, five_columns: bool) -> Option<Surface> {
        let columns = self.columns(row, five_columns)?;
        let before = self.errors.len();
        let (radius, stop_word) = self.radius(row, columns.radius);
        let thickness = self
            .number(row, columns.thickness, "the thickness in mm")
            .unwrap_or(0.0);
        let index = self.index(row, columns.index);
        let abbe = self.abbe(row, columns.abbe);
        let aperture = self.aperture(row, columns.aperture);
        let extras = Extras::read(row, |cell, message| {
            self.errors.push(RowNote {
                line: row.line,
                column: cell.column,
                row: row.row,
                message,
            });
        });
        if self.errors.len() > before {
            return None;
        }
        if thickness < 0.0 {
            self.warn(row, 1, format!("thickness {thickness} mm is negative: the next surface lies in front of this one"));
        }
        // A stop changes no medium. Radius 0 with a new medium behind is a plane glass surface.
        let is_stop = stop_word || (radius == 0.0 && index.is_none_or(|n| n == self.medium));
        if radius == 0.0 && !is_stop {
            self.warn(
                row,
                0,
                format!(
                    "radius 0 between indices {} and {} is read as a plane glass surface; write `inf` (pbrt would read a stop)",
                    self.medium,
                    index.unwrap_or(1.0)
                ),
            );
        }
        let index = if is_stop {
            self.medium
        } else {
            index.unwrap_or(1.0)
        };
        self.medium = index;
        if is_stop && extras.asphere.is_some() {
            self.error(
                row,
                0,
                "a stop with aspheric terms; write `inf` for the radius of an aspheric plate"
                    .to_string(),
            );
            return None;
        }
        let surface = Surface {
            radius: if radius == 0.0 { f64::INFINITY } else { radius },
            thickness,
            index,
            abbe: if index == 1.0 { None } else { abbe },
            dispersion: extras.dispersion,
            aperture,
            is_stop,
            asphere: extras.asphere,
        };
        if surface.clear_radius() < 0.5 * aperture {
            self.warn(
                row,
                0,
                format!("aperture {aperture} mm reaches beyond the equator of a surface of radius {radius} mm"),
            );
        }
        Some(surface)
    }

    /// Which cell holds what.
    fn columns(&mut self, row: &Row, five_columns: bool) -> Option<Columns> {
        let some = |radius, thickness, index, abbe, aperture| {
            Some(Columns {
                radius,
                thickness,
                index,
                abbe,
                aperture,
            })
        };
        match row.cells.len() {
            5 => some(Some(0), 1, Some(2), Some(3), 4),
            4 => some(Some(0), 1, Some(2), None, 3),
            3 if plausible_index(row.cells[2].text) => {
                self.error(
                    row,
                    2,
                    format!(
                        "three columns, the last of which, {}, may be an index or an aperture; expected radius, thickness, index, aperture (write index 1 for air)",
                        row.cells[2].text
                    ),
                );
                None
            }
            3 => some(Some(0), 1, None, None, 2),
            2 if five_columns => {
                self.warn(
                    row,
                    0,
                    "two columns are read as thickness and aperture of a stop".to_string(),
                );
                some(None, 0, None, None, 1)
            }
            n => {
                let what = if n > 5 {
                    "; write conic and aspheric coefficients as k=-1 A4=1e-6 behind the columns"
                } else {
                    ""
                };
                self.error(
                    row,
                    n.min(5),
                    format!("{n} columns; expected radius, thickness, index, aperture or radius, thickness, n_d, V, aperture{what}"),
                );
                None
            }
        }
    }

    /// The radius, 0 for a stop or plane of radius 0; and was it called a stop by name?
    fn radius(&mut self, row: &Row, cell: Option<usize>) -> (f64, bool) {
        let Some(cell) = cell else { return (0.0, true) };
        let text = row.cells[cell].text;
        if text.is_empty()
            || ["stop", "sto", "aperture"]
                .iter()
                .any(|w| text.eq_ignore_ascii_case(w))
        {
            return (0.0, true);
        }
        let radius = match text.parse::<f64>() {
            Ok(r) if r.is_infinite() && !text.contains(|c: char| c.is_ascii_digit()) => {
                return (f64::INFINITY, false);
            }
            _ => self.number(row, cell, "the radius in mm").unwrap_or(0.0),
        };
        if radius != 0.0 && !RADIUS_RANGE.contains(&radius.abs()) {
            self.error(
                row,
                cell,
                format!("a radius of {radius} mm; expected between 1e-6 and 1e30, `inf` for a plane or 0 for a stop"),
            );
        }
        (radius, false)
    }

    /// The index behind the surface; `None` for 0 and blank.
    fn index(&mut self, row: &Row, cell: Option<usize>) -> Option<f64> {
        let cell = cell.filter(|c| !row.cells[*c].text.is_empty())?;
        let text = row.cells[cell].text;
        if text.eq_ignore_ascii_case("air") {
            return Some(1.0);
        }
        if text.starts_with(|c: char| c.is_ascii_alphabetic()) {
            self.error(
                row,
                cell,
                format!(
                    "glass names such as {text} cannot be read; expected the refractive index n_d"
                ),
            );
            return None;
        }
        let n = self.number(row, cell, "the refractive index")?;
        if n == 0.0 {
            return None;
        }
        // No lens material leaves this range; a column mix-up does.
        if !(1.0..=6.0).contains(&n) {
            self.error(
                row,
                cell,
                format!("a refractive index of {n}; expected 1 to about 4, or 0 for air"),
            );
        }
        Some(n)
    }

    fn abbe(&mut self, row: &Row, cell: Option<usize>) -> Option<f64> {
        let cell = cell.filter(|c| !row.cells[*c].text.is_empty())?;
        if matches!(row.cells[cell].text, "-" | "inf") {
            return None;
        }
        let v = self.number(row, cell, "the Abbe number V")?;
        if v < 0.0 {
            self.error(
                row,
                cell,
                format!("an Abbe number of {v}; expected a positive number, or 0 for air"),
            );
        }
        (v > 0.0).then_some(v)
    }

    fn aperture(&mut self, row: &Row, cell: usize) -> f64 {
        let d = self
            .number(row, cell, "the aperture diameter in mm")
            .unwrap_or(1.0);
        if d <= 0.0 {
            self.error(
                row,
                cell,
                format!("an aperture diameter of {d} mm; expected a positive length"),
            );
        }
        d
    }

    /// A finite number.
    fn number(&mut self, row: &Row, cell: usize, what: &str) -> Option<f64> {
        let text = row.cells[cell].text;
        match text.parse::<f64>() {
            Ok(x) if x.is_finite() => Some(x),
            _ => {
                let found = if text.is_empty() { "a blank" } else { text };
                self.error(row, cell, format!("expected {what}, found {found}"));
                None
            }
        }
    }
}

/// Where in a row the columns are.
struct Columns {
    radius: Option<usize>,
    thickness: usize,
    index: Option<usize>,
    abbe: Option<usize>,
    aperture: usize,
}

/// Could this be the refractive index of a glass, of which lenses have 1.3 to 2.2?
fn plausible_index(text: &str) -> bool {
    text.parse::<f64>().is_ok_and(|n| (1.0..=2.5).contains(&n))
}
