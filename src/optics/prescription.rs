//! Lens prescriptions as text (`lenses/*.dat`).
//!
//! One row per surface, from the scene to the film, lengths in millimetres:
//!
//! ```text
//! radius thickness index aperture         # four columns, as pbrt
//! radius thickness n_d   V aperture       # five columns, with the Abbe number, as the lecture
//! ```
//!
//! * `radius` > 0: the centre of curvature lies on the film side. 0 is an aperture stop (so is the
//!   word `stop`), `inf` a plane; a row with radius 0 whose index differs from the medium in front of it
//!   can be no stop and is read as a plane glass surface, with a warning.
//! * `thickness`: to the next surface; in the last row to the film.
//! * `index`: of the space behind the surface; 0 or blank is air (at a stop: unchanged).
//! * `aperture`: full clear diameter.
//!
//! `#` starts a comment anywhere; columns are separated by blanks or tabs; lines end in LF or
//! CRLF, the last one in nothing if it likes. A blank index is recognised by the number of
//! columns, or by an empty cell where single tabs separate all columns.
//!
//! ```
//! let lens = fstop::optics::Prescription::parse("50 5 1.5168 64.2 20\n-50 95.2 20 # air\n")?;
//! assert_eq!(lens.surfaces.len(), 2);
//! assert_eq!(lens.film_distance, 95.2);
//! # Ok::<(), fstop::optics::PrescriptionError>(())
//! ```

use super::surface::Surface;
use std::fmt;
use std::path::Path;

/// A lens: its surfaces from the scene to the film.
#[derive(Clone, Debug, PartialEq)]
pub struct Prescription {
    /// At least one. The last one's thickness is 0; see `film_distance`.
    pub surfaces: Vec<Surface>,
    /// From the last vertex to the film in mm: the last row's thickness; 0 where the file leaves
    /// it open.
    pub film_distance: f64,
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
    /// Row of the table, from 1.
    pub row: usize,
    /// What is wrong and what was expected, or done.
    pub message: String,
}

impl fmt::Display for RowNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "line {}, column {} (row {}): {}",
            self.line, self.column, self.row, self.message
        )
    }
}

/// Why a lens file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum PrescriptionError {
    /// The file itself.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// No rows.
    #[error("the lens file has no surfaces")]
    Empty,
    /// Every row that cannot be read.
    #[error("{}", .0.iter().map(RowNote::to_string).collect::<Vec<_>>().join("; "))]
    Rows(Vec<RowNote>),
}

impl Prescription {
    /// Reads the file at `path`.
    pub fn read(path: &Path) -> Result<Prescription, PrescriptionError> {
        // Old lens files have Latin-1 comments: replaced characters there harm nobody.
        Prescription::parse(&String::from_utf8_lossy(&std::fs::read(path)?))
    }

    /// Reads a prescription from text.
    pub fn parse(text: &str) -> Result<Prescription, PrescriptionError> {
        let mut rows = Vec::new();
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        // A lone CR ended lines once; CRLF gives an empty line between, which is skipped.
        for (line, content) in lines(text) {
            let cells = cells(content.split('#').next().unwrap_or(""));
            if !cells.is_empty() {
                rows.push(Row {
                    line,
                    row: rows.len() + 1,
                    cells,
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
        if !reader.errors.is_empty() {
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

    /// Distance from the first vertex to the last, mm.
    pub fn length(&self) -> f64 {
        self.surfaces.iter().map(|s| s.thickness).sum()
    }

    /// Has it an aperture stop?
    pub fn has_stop(&self) -> bool {
        self.surfaces.iter().any(|s| s.is_stop)
    }

    /// All lengths times `factor`, as prescriptions are scaled to another focal length.
    pub fn scaled(mut self, factor: f64) -> Prescription {
        for s in &mut self.surfaces {
            s.radius *= factor;
            s.thickness *= factor;
            s.aperture *= factor;
        }
        self.film_distance *= factor;
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
                    "aperture diameter {diameter} mm is larger than the {} mm of the stop in row {}, which is kept",
                    s.aperture,
                    i + 1
                ));
            } else {
                s.aperture = diameter;
            }
        }
        notes
    }
}

/// The lines of a text with their numbers, whatever ends them.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.split('\n').enumerate().flat_map(|(i, line)| {
        line.split('\r')
            .filter(|part| !part.is_empty())
            .map(move |part| (i + 1, part))
    })
}

/// One cell: its text (empty for a blank one) and its column, from 1.
#[derive(Clone, Copy, Debug)]
struct Cell<'a> {
    text: &'a str,
    column: usize,
}

/// One row that is not blank.
#[derive(Debug)]
struct Row<'a> {
    line: usize,
    row: usize,
    cells: Vec<Cell<'a>>,
}

/// Cuts a line into cells. Blank cells count only where the line is four or five cells separated
/// by single tabs; otherwise any run of blanks is one separator.
fn cells(line: &str) -> Vec<Cell<'_>> {
    let at = |part: &str| {
        let offset = part.as_ptr() as usize - line.as_ptr() as usize;
        line[..offset].chars().count() + 1
    };
    let cut = |part| Cell {
        text: part,
        column: at(part),
    };
    let tabbed: Vec<Cell> = line
        .trim_end()
        .split('\t')
        .map(str::trim)
        .map(cut)
        .collect();
    let blank = tabbed.iter().any(|c| c.text.is_empty());
    let single = tabbed.iter().all(|c| !c.text.contains(char::is_whitespace));
    if blank
        && single
        && matches!(tabbed.len(), 4 | 5)
        && tabbed[1..].iter().any(|c| !c.text.is_empty())
    {
        return tabbed;
    }
    line.split_whitespace().map(cut).collect()
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
        let surface = Surface {
            radius: if radius == 0.0 { f64::INFINITY } else { radius },
            thickness,
            index,
            abbe: if index == 1.0 { None } else { abbe },
            aperture,
            is_stop,
        };
        if 0.5 * aperture > surface.radius.abs() {
            self.warn(
                row,
                0,
                format!("aperture {aperture} mm reaches beyond the equator of a sphere of radius {radius} mm"),
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
                    "; conic and aspheric coefficients cannot be read"
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
        if !(0.5..=6.0).contains(&n) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn surfaces(text: &str) -> Vec<Surface> {
        Prescription::parse(text).unwrap().surfaces
    }

    fn errors(text: &str) -> Vec<RowNote> {
        match Prescription::parse(text) {
            Err(PrescriptionError::Rows(notes)) => notes,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn four_and_five_columns_say_the_same() {
        let four = surfaces("58.95 7.52 1.67 50.4\n169.66 0.24 1 50.4\n0 9 0 34.2\n-40 0 1 40\n");
        let five = surfaces(
            "58.95 7.52 1.67 47.1 50.4\n169.66 0.24 1 0 50.4\n0 9 0 0 34.2\n-40 0 1 0 40\n",
        );
        assert_eq!(five[0].abbe, Some(47.1));
        assert_eq!(four[1..], five[1..]);
        assert!(four[2].is_stop && !four[3].is_stop);
        assert_eq!(four[2].radius, f64::INFINITY);
    }

    #[test]
    fn every_way_of_writing_a_file_is_read() {
        let plain = surfaces("58.95 7.52 1.67 50.4\n169.66 0.24 1 50.4\n0 9 0 34.2\n");
        for text in [
            // CRLF, tabs, comments anywhere, no last newline, blank lines.
            "# title\r\n58.95\t7.52\t1.67\t50.4 # front\r\n\r\n169.66\t0.24\t1\t50.4#rim\r\n0\t9\t0\t34.2",
            // A byte order mark, upper-case exponents, signs, bare dots.
            "\u{feff}5.895E1 +7.52 1.67 50.4\n1.6966E+2 .24 1. 50.4\n0. 9 0 342e-1",
            // Blank index: three columns, or an empty cell between tabs.
            "58.95 7.52 1.67 50.4\n169.66 0.24 50.4\n0 9 34.2\n",
            "58.95\t7.52\t1.67\t50.4\n169.66\t0.24\t\t50.4\n0\t9\t\t34.2\n",
            // Lines that end in CR alone; words for the stop and for air.
            "58.95 7.52 1.67 50.4\r169.66 0.24 air 50.4\rSTOP 9 0 34.2\r",
        ] {
            assert_eq!(surfaces(text), plain, "{text:?}");
        }
    }

    #[test]
    fn the_lectures_table_is_read_with_its_blanks() {
        let p = Prescription::parse(
            "58.950 7.520 1.670 47.1 50.4\n169.660 0.240 50.4\n25.5 11.41 36.0\n9.000 34.2\n-79.460 72.228 40.0",
        )
        .unwrap();
        assert_eq!(p.surfaces.len(), 5);
        assert!(p.surfaces[3].is_stop);
        assert_eq!(
            (p.surfaces[3].thickness, p.surfaces[3].aperture),
            (9.0, 34.2)
        );
        assert_eq!(p.film_distance, 72.228);
        assert_eq!(p.surfaces[4].thickness, 0.0);
        // The two-column row is a guess, and said to be one.
        assert_eq!(p.warnings.len(), 1);
    }

    #[test]
    fn planes_and_stops_are_told_apart() {
        // A plane-parallel plate written both ways, and a stop inside glass.
        let plate = surfaces("inf 5 1.5 20\nInfinity 0 1 20\n");
        assert!(plate.iter().all(|s| !s.is_stop && s.curvature() == 0.0));
        let p = Prescription::parse("0 5 1.5 20\n0 3 0 10\n0 0 1 20\n").unwrap();
        assert_eq!(
            p.surfaces.iter().map(|s| s.is_stop).collect::<Vec<_>>(),
            [false, true, false]
        );
        assert_eq!(p.surfaces[1].index, 1.5);
        assert_eq!(p.warnings.len(), 2);
    }

    #[test]
    fn errors_name_row_line_and_column() {
        let notes = errors("# a lens\n50 5 1.5 20\n\n  -50 x 1 20\n30 2 SK16 20\n1 2 3\n");
        let places: Vec<_> = notes.iter().map(|n| (n.line, n.column, n.row)).collect();
        assert_eq!(places, [(4, 7, 2), (5, 6, 3)]);
        assert!(
            notes[0].message.contains("thickness in mm, found x"),
            "{}",
            notes[0]
        );
        assert!(
            notes[1].message.contains("glass names such as SK16"),
            "{}",
            notes[1]
        );
        let wrong = [
            ("50 5\n", "2 columns"),
            ("50 5 1.5\n", "may be an index or an aperture"),
            ("50 5 1.5 60 20 -1 0.001\n", "aspheric"),
            ("1e-9 5 1.5 20\n", "expected between 1e-6 and 1e30"),
            ("nan 5 1.5 20\n", "the radius in mm, found nan"),
            ("1e999 5 1.5 20\n", "the radius in mm"),
            ("50 inf 1.5 20\n", "the thickness in mm"),
            ("50 5 -1.5 20\n", "refractive index of -1.5"),
            ("50 5 1.5 0\n", "expected a positive length"),
            ("50 5 1.5 -60 20\n", "Abbe number of -60"),
            ("TYPE EVENASPH 1 2\n", "the radius in mm, found TYPE"),
        ];
        for (text, expected) in wrong {
            let notes = errors(text);
            assert!(
                notes[0].to_string().contains(expected),
                "{text:?}: {}",
                notes[0]
            );
        }
        assert!(matches!(
            Prescription::parse("# nothing\n"),
            Err(PrescriptionError::Empty)
        ));
    }

    #[test]
    fn stops_open_no_wider_than_their_row() {
        let mut p = Prescription::parse("50 5 1.5 20\n-50 2 1 20\n0 1 0 10\n0 0 0 6\n").unwrap();
        let notes = p.set_stops(8.0);
        assert_eq!(p.surfaces[2].aperture, 8.0);
        assert_eq!(p.surfaces[3].aperture, 6.0);
        assert_eq!(p.surfaces[0].aperture, 20.0);
        assert!(notes.len() == 1 && notes[0].contains("row 4"));
    }

    proptest! {
        /// Whatever the text, reading ends, and what it returns can be used.
        #[test]
        fn reading_never_panics(text in "([-+0-9.eE#\t\r\n a-z]|inf|nan|\u{feff}|é){0,120}") {
            if let Ok(p) = Prescription::parse(&text) {
                for s in &p.surfaces {
                    prop_assert!(s.curvature().is_finite() && s.thickness.is_finite());
                    prop_assert!(s.index > 0.0 && s.aperture > 0.0);
                }
                prop_assert_eq!(p.surfaces.last().map(|s| s.thickness), Some(0.0));
            }
        }
    }
}
