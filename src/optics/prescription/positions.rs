//! Lenses whose groups move: zooms, and lenses that focus by more than moving as a whole.
//!
//! A lens table names the thicknesses that change, and says what they are at each of some positions:
//!
//! ```text
//! zoom   80    80   200   200      # what is engraved on the ring; positions of a lens that zooms
//! focus  inf   2    inf   2        # meters from the film; positions of a lens that moves its groups to focus
//! gap D5 2.1   2.4  30.6  31.9     # mm, a thickness named D5, at each position
//! gap D9 41.0  40.7 3.2   1.9
//! ```
//!
//! The lines may stand anywhere in the file; either of `zoom` and `focus` may be missing, and where both are given each zoom has each
//! focus. Between positions thicknesses change linearly with the zoom and with the reciprocal of the distance: by then the film is a
//! little off, and is put where the image is sharp as with any other lens ([`crate::optics::focus`]).

use super::cells::{Cell, number};
use super::{Prescription, RowNote};
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// Positions and gaps are few; a file with more is none of a lens.
const MAX_POSITIONS: usize = 1000;

/// What the file says of moving groups.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Positions {
    zooms: Vec<f64>,
    /// 1/distance, 1/m.
    vergences: Vec<f64>,
    gaps: Vec<Gap>,
    /// Where in the file each line of them stands.
    lines: Vec<(&'static str, usize)>,
    /// Values of the lines `zoom` and `focus`, by position.
    columns: [Option<Vec<f64>>; 2],
}

/// One thickness that changes.
#[derive(Clone, Debug, PartialEq)]
struct Gap {
    name: String,
    line: usize,
    /// Surfaces that it lies behind.
    behind: Vec<usize>,
    /// As given by position; once checked, by zoom and within it by vergence.
    values: Vec<f64>,
}

/// Positions and gaps as files of fields have them.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct PositionTable {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zoom: Option<Vec<f64>>,
    /// Meters; `None` is infinity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub focus: Option<Vec<Option<f64>>>,
    pub gaps: Vec<GapTable>,
}

/// A gap's values by position.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct GapTable {
    pub name: String,
    /// Surfaces that it lies behind, from 0.
    pub behind: Vec<usize>,
    /// mm.
    pub values: Vec<f64>,
}

impl PositionTable {
    /// Positions of a lens of so many surfaces, not yet checked to be a grid.
    pub(super) fn positions(self, surfaces: usize) -> Result<Positions, String> {
        let longest = [
            self.zoom.as_ref().map_or(0, Vec::len),
            self.focus.as_ref().map_or(0, Vec::len),
            self.gaps.len(),
        ];
        if longest.iter().any(|n| *n > MAX_POSITIONS) {
            return Err(format!("more than {MAX_POSITIONS} positions or gaps"));
        }
        let zoom = self
            .zoom
            .map(|z| z.into_iter().map(positive).collect::<Result<_, _>>());
        let vergence = |distance: Option<f64>| match distance {
            None => Ok(0.0),
            Some(meters) => positive(meters).and_then(reciprocal),
        };
        let focus = self
            .focus
            .map(|f| f.into_iter().map(vergence).collect::<Result<_, _>>());
        let mut positions = Positions {
            columns: [zoom.transpose()?, focus.transpose()?],
            ..Positions::default()
        };
        for gap in self.gaps {
            let named = gap.name.parse::<f64>().is_err() && positions.gap(&gap.name).is_none();
            let plain = gap
                .name
                .chars()
                .all(|c| c.is_ascii_graphic() && !matches!(c, '#' | '='));
            let placed = gap.behind.iter().all(|i| *i < surfaces)
                && gap.values.iter().all(|x| x.is_finite());
            if gap.name.is_empty() || !named || !plain || !placed || gap.behind.len() > surfaces {
                let name = &gap.name;
                return Err(format!(
                    "gap {name:.40}: expected a name that no other gap has, surfaces of the lens, and finite numbers"
                ));
            }
            positions.gaps.push(Gap {
                name: gap.name,
                line: 1,
                behind: gap.behind,
                values: gap.values,
            });
        }
        Ok(positions)
    }
}

/// Why a lens has no such position.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PositionError {
    /// Its groups stay where they are.
    #[error("the lens does not zoom: its file has no `zoom` line")]
    NoZoom,
    /// Beyond the positions of the file.
    #[error("the lens zooms from {low} to {high}, not to {asked}")]
    OutOfRange {
        /// What was asked for.
        asked: f64,
        /// The least.
        low: f64,
        /// The greatest.
        high: f64,
    },
}

impl Positions {
    /// Returns `true` if this is a line of them.
    pub(super) fn is_line(cells: &[Cell]) -> bool {
        let first = cells.first().map(|c| c.text);
        matches!(first, Some("zoom" | "focus" | "gap"))
    }

    /// Reads a line; what is wrong with it goes to `errors`.
    pub(super) fn read(&mut self, line: usize, cells: &[Cell], errors: &mut Vec<RowNote>) {
        let note = |cell: &Cell, message: String| RowNote {
            line,
            column: cell.column,
            row: 0,
            message,
        };
        let [word, rest @ ..] = cells else { return };
        let (name, values) = match (word.text, rest) {
            ("gap", [name, values @ ..]) => (Some(name), values),
            ("gap", []) => return errors.push(note(word, "expected the name of a gap".into())),
            (_, values) => (None, values),
        };
        let read = |cell: &Cell| match word.text {
            "gap" => number(cell.text, "a thickness in mm"),
            "zoom" => number(cell.text, "a positive zoom").and_then(positive),
            _ => vergence(cell.text),
        };
        let mut numbers = Vec::new();
        for cell in values {
            match read(cell) {
                Ok(x) => numbers.push(x),
                Err(message) => return errors.push(note(cell, message)),
            }
        }
        if numbers.is_empty() || numbers.len() > MAX_POSITIONS || self.gaps.len() >= MAX_POSITIONS {
            let message = format!("expected 1 to {MAX_POSITIONS} numbers, one for each position");
            return errors.push(note(word, message));
        }
        match name {
            Some(name) if name.text.parse::<f64>().is_ok() || self.gap(name.text).is_some() => {
                let message = format!("{}: expected a name that no other gap has", name.text);
                errors.push(note(name, message));
            }
            Some(name) => self.gaps.push(Gap {
                name: name.text.to_string(),
                line,
                behind: Vec::new(),
                values: numbers,
            }),
            None => {
                let which = usize::from(word.text == "focus");
                if self.columns[which].replace(numbers).is_some() {
                    errors.push(note(word, format!("a second `{}` line", word.text)));
                }
                self.lines.push((["zoom", "focus"][which], line));
            }
        }
    }

    /// The number of the gap of this name.
    pub(super) fn gap(&self, name: &str) -> Option<usize> {
        self.gaps.iter().position(|gap| gap.name == name)
    }

    /// Its thickness at the first position, with the surface noted that it lies behind.
    pub(super) fn place(&mut self, gap: usize, behind: usize) -> f64 {
        let gap = &mut self.gaps[gap];
        gap.behind.push(behind);
        gap.values[0]
    }

    /// Returns `true` if the file has none of these lines.
    pub(super) fn is_empty(&self) -> bool {
        self.gaps.is_empty() && self.columns == [None, None]
    }

    /// The positions as a grid; or what keeps them from being one.
    pub(super) fn checked(mut self) -> Result<Positions, RowNote> {
        let at = |line: usize, message: String| RowNote {
            line,
            column: 1,
            row: 0,
            message,
        };
        let first = self.lines.first().map(|(_, line)| *line);
        let first = first
            .or_else(|| self.gaps.first().map(|g| g.line))
            .unwrap_or(1);
        let [zoom, focus] = std::mem::take(&mut self.columns);
        let Some(count) = zoom.as_ref().or(focus.as_ref()).map(Vec::len) else {
            let message = "a gap without positions: expected a line `zoom` or `focus`, too";
            return Err(at(first, message.to_string()));
        };
        let zoom = zoom.unwrap_or_else(|| vec![0.0; count]);
        let focus = focus.unwrap_or_else(|| vec![0.0; count]);
        let uneven = self.gaps.iter().find(|gap| gap.values.len() != count);
        if focus.len() != count {
            let message = format!("{count} zooms and {} distances", focus.len());
            return Err(at(first, message));
        }
        if let Some(gap) = uneven {
            let message = format!("{} numbers for {count} positions", gap.values.len());
            return Err(at(gap.line, message));
        }
        if let Some(gap) = self.gaps.iter().find(|gap| gap.behind.is_empty()) {
            let message = format!("no row has the thickness {}", gap.name);
            return Err(at(gap.line, message));
        }
        (self.zooms, self.vergences) = (distinct(&zoom), distinct(&focus));
        let grid = |z: &f64| {
            let of_zoom = |v: &f64| (0..count).find(|i| (zoom[*i], focus[*i]) == (*z, *v));
            self.vergences.iter().map(of_zoom).collect::<Vec<_>>()
        };
        let grid: Option<Vec<usize>> = self.zooms.iter().flat_map(grid).collect();
        let grid = grid.filter(|grid| grid.len() == count).ok_or_else(|| {
            let message = "expected each pair of a zoom and a distance once";
            at(first, message.to_string())
        })?;
        for gap in &mut self.gaps {
            gap.values = grid.iter().map(|i| gap.values[*i]).collect();
        }
        Ok(self)
    }

    /// The least and the greatest zoom; `None` of a lens that does not zoom.
    pub fn zoom_range(&self) -> Option<[f64; 2]> {
        let (low, high) = (*self.zooms.first()?, *self.zooms.last()?);
        (low > 0.0).then_some([low, high])
    }

    /// The zooms of the file's positions, ascending; empty of a lens that does not zoom.
    pub fn zooms(&self) -> &[f64] {
        self.zoom_range().map_or(&[], |_| &self.zooms)
    }

    /// Returns `true` if groups move against each other to focus.
    pub fn focuses(&self) -> bool {
        self.vergences.len() > 1
    }

    /// The name of the gap behind a surface.
    pub(super) fn name_behind(&self, surface: usize) -> Option<&str> {
        let gap = self.gaps.iter().find(|gap| gap.behind.contains(&surface));
        gap.map(|gap| gap.name.as_str())
    }

    /// The lines that say these positions.
    pub(super) fn to_lines(&self) -> String {
        let line = |word: &str, numbers: &[f64]| {
            let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
            format!("{word} {}\n", numbers.join(" "))
        };
        let mut text = String::new();
        let (zooms, vergences) = (&self.zooms, &self.vergences);
        if self.zoom_range().is_some() {
            let each = zooms.iter().flat_map(|z| vergences.iter().map(|_| *z));
            text += &line("zoom", &each.collect::<Vec<_>>());
        }
        if self.focuses() || text.is_empty() {
            let distances = vergences.iter().map(|v| 1.0 / v);
            let each = zooms.iter().flat_map(|_| distances.clone());
            text += &line("focus", &each.collect::<Vec<_>>());
        }
        for gap in &self.gaps {
            text += &line(&format!("gap {}", gap.name), &gap.values);
        }
        text
    }

    /// The same as columns of numbers.
    pub(super) fn to_table(&self) -> PositionTable {
        let (zooms, vergences) = (&self.zooms, &self.vergences);
        let distance = |v: &f64| Some(1.0 / v).filter(|d| d.is_finite());
        let zoom = zooms.iter().flat_map(|z| vergences.iter().map(|_| *z));
        let focus = zooms.iter().flat_map(|_| vergences.iter().map(distance));
        let zooming = self.zoom_range().is_some();
        PositionTable {
            zoom: zooming.then(|| zoom.collect()),
            focus: (self.focuses() || !zooming).then(|| focus.collect()),
            gaps: self
                .gaps
                .iter()
                .map(|gap| GapTable {
                    name: gap.name.clone(),
                    behind: gap.behind.clone(),
                    values: gap.values.clone(),
                })
                .collect(),
        }
    }

    pub(super) fn scale(&mut self, factor: f64) {
        let gaps = self.gaps.iter_mut().flat_map(|gap| &mut gap.values);
        gaps.for_each(|x| *x *= factor);
        self.vergences.iter_mut().for_each(|v| *v /= factor);
    }
}

impl Prescription {
    /// The lens at this zoom, its groups where they focus at `distance` mm from the film (infinity is allowed); the nearest and the
    /// farthest of the file's distances are taken for those beyond. Without a zoom: at the first of the file's. A lens whose groups do not
    /// move is itself.
    ///
    /// # Errors
    /// See [`PositionError`].
    pub fn at_position(
        &self,
        zoom: Option<f64>,
        distance: f64,
    ) -> Result<Prescription, PositionError> {
        let range = self.positions.as_ref().and_then(|p| p.zoom_range());
        match (zoom, range) {
            (Some(_), None) => return Err(PositionError::NoZoom),
            (Some(asked), Some([low, high])) if !(low..=high).contains(&asked) => {
                return Err(PositionError::OutOfRange { asked, low, high });
            }
            _ => {}
        }
        let mut lens = self.clone();
        let Some(positions) = &self.positions else {
            return Ok(lens);
        };
        let zoom = zoom.or(positions.zooms.first().copied()).unwrap_or(0.0);
        let vergence = if distance > 0.0 { 1e3 / distance } else { 0.0 };
        let (z, v) = (
            between(&positions.zooms, zoom),
            between(&positions.vergences, vergence),
        );
        for gap in &positions.gaps {
            let at = |i: usize, j: usize| gap.values[i * positions.vergences.len() + j];
            let along = |i: usize| mix(at(i, v.0), at(i, v.1), v.2);
            let thickness = mix(along(z.0), along(z.1), z.2);
            for surface in &gap.behind {
                match lens.surfaces.get_mut(*surface) {
                    // The last one's is the distance of the film.
                    Some(_) if surface + 1 == self.surfaces.len() => lens.film_distance = thickness,
                    Some(s) => s.thickness = thickness,
                    None => {}
                }
            }
        }
        Ok(lens)
    }
}

fn positive(x: f64) -> Result<f64, String> {
    // Differences of larger ones would overflow.
    match x > 0.0 && x <= 1e30 {
        true => Ok(x),
        false => Err(format!(
            "expected a positive number of at most 1e30, found {x}"
        )),
    }
}

/// 1/m of a distance in meters.
fn vergence(text: &str) -> Result<f64, String> {
    if text == "inf" {
        return Ok(0.0);
    }
    let meters = number(text, "a distance in meters, or inf").and_then(positive)?;
    reciprocal(meters)
}

fn reciprocal(meters: f64) -> Result<f64, String> {
    match 1.0 / meters {
        v if v.is_finite() => Ok(v),
        _ => Err(format!("a distance of {meters} m")),
    }
}

/// Those that differ, ascending.
fn distinct(values: &[f64]) -> Vec<f64> {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// The two places of `sorted` that `x` lies between, and how far from the first to the second: the ends beyond them.
fn between(sorted: &[f64], x: f64) -> (usize, usize, f64) {
    let last = sorted.len().saturating_sub(1);
    let above = sorted.partition_point(|s| s.total_cmp(&x) == Ordering::Less);
    match above {
        0 => (0, 0, 0.0),
        i if i > last => (last, last, 0.0),
        i => {
            let (low, high) = (sorted[i - 1], sorted[i]);
            (i - 1, i, (x - low) / (high - low))
        }
    }
}

/// Exactly its ends at 0 and 1.
fn mix(a: f64, b: f64, t: f64) -> f64 {
    a * (1.0 - t) + b * t
}

#[cfg(test)]
mod tests;
