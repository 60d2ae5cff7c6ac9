//! The tables of Optical Bench (photonstophotos.net).
//!
//! Cells between tabs, in sections: `[constants]`, `[variable distances]` (a name and its values, one for each position), `[lens data]` (number, radius,
//! thickness, n_d, diameter, V_d and perhaps the names of glass and catalogue), `[aspherical data]` (number, radius, conic constant, coefficients). A radius is a
//! number, `Infinity`, `AS` (the aperture stop), `FS` (a field stop) or `CG` (cover glass); a thickness a number or a distance's name. Coefficients begin at r⁴, or
//! at r² (`AsphericalA2`); with `AsphericalOddCount` n the first n of r³, r⁵, … stand between the even ones.
//!
//! Positions at infinity are the zoom of [`super::positions`], by the focal length; a lens with one of them and some near ones focuses by its groups, at the
//! distance from the film that `d0` says. Others are left out, with a warning.

use super::cells::lines;
use super::design::light::{Beam, Field, FieldKind};
use super::design::{Aperture, Design, DesignSurface, Medium, asphere_term};
use super::glass::Glasses;
use super::positions::{GapTable, PositionTable};
use super::{Prescription, PrescriptionError, RowNote};
use std::collections::HashMap;

/// Returns `true` if this is such a table.
pub(super) fn is_file(text: &str) -> bool {
    text.lines()
        .any(|line| line.trim().eq_ignore_ascii_case("[lens data]"))
}

/// Reads the text of a file, with the glasses that it may name.
pub fn parse(text: &str, glasses: &Glasses) -> Result<Prescription, PrescriptionError> {
    let mut reader = Reader {
        design: Design {
            unit: 1.0,
            ..Design::default()
        },
        glasses,
        constants: HashMap::new(),
        distances: HashMap::new(),
        gaps: Vec::new(),
        rows: HashMap::new(),
    };
    let mut section = String::new();
    for (line, content) in lines(text) {
        if content.trim_start().starts_with('[') {
            section = content.trim().to_ascii_lowercase();
            continue;
        }
        let cells: Vec<&str> = content.split('\t').map(str::trim).collect();
        if cells.iter().all(|c| c.is_empty()) {
            continue;
        }
        if let Err(message) = reader.row(line, &section, &cells) {
            let row = reader.design.surfaces.len();
            reader.design.notes.errors.push(RowNote {
                line,
                column: 1,
                row,
                message,
            });
        }
    }
    reader.finish()
}

/// The most positions of a zoom that are read.
const MAX_NUMBERS: usize = 100;

struct Reader<'a> {
    design: Design,
    glasses: &'a Glasses,
    constants: HashMap<String, String>,
    /// Distances by name, at each position.
    distances: HashMap<String, Vec<f64>>,
    /// Names of thicknesses by surface.
    gaps: Vec<Option<String>>,
    /// Of surfaces by the number in their row.
    rows: HashMap<String, usize>,
}

/// A number; what is infinite has a word.
fn number(text: &str) -> Option<f64> {
    let infinite = ["infinity", "inf", "∞"]
        .iter()
        .any(|w| text.eq_ignore_ascii_case(w));
    let number = if infinite {
        Some(f64::INFINITY)
    } else {
        text.parse().ok()
    };
    number.filter(|x: &f64| !x.is_nan())
}

impl Reader<'_> {
    fn row(&mut self, line: usize, section: &str, cells: &[&str]) -> Result<(), String> {
        let [name, values @ ..] = cells else {
            return Ok(());
        };
        match section {
            "[constants]" => {
                let value = values.first().unwrap_or(&"").to_string();
                self.constants.insert(name.to_ascii_lowercase(), value);
            }
            "[variable distances]" => {
                let numbers = values.iter().filter(|v| !v.is_empty()).take(MAX_NUMBERS);
                // Rows without numbers say nothing about distances.
                let numbers: Option<Vec<f64>> = numbers.map(|v| number(v)).collect();
                if let Some(numbers) = numbers.filter(|n| !n.is_empty()) {
                    self.distances.insert(name.to_ascii_lowercase(), numbers);
                }
            }
            "[lens data]" => self.surface(line, cells)?,
            "[aspherical data]" => self.asphere(cells)?,
            _ => {}
        }
        Ok(())
    }

    fn surface(&mut self, line: usize, cells: &[&str]) -> Result<(), String> {
        let cell = |i: usize| cells.get(i).copied().unwrap_or("");
        let mut surface = DesignSurface {
            line,
            row: self.design.surfaces.len() + 1,
            ..DesignSurface::default()
        };
        match cell(1).to_ascii_uppercase().as_str() {
            "AS" => surface.is_stop = true,
            "FS" => surface.aperture = Aperture::Floating,
            "CG" => {}
            text => {
                let radius = number(text)
                    .ok_or_else(|| format!("expected a radius, AS, FS or CG, found {text:.40}"))?;
                surface.set_radius(radius);
            }
        }
        let name = cell(2).to_ascii_lowercase();
        let (thickness, gap) = match self.distances.get(&name) {
            Some(values) => (values.first().copied(), Some(name)),
            None if name.is_empty() => (Some(0.0), None),
            None => (number(&name), None),
        };
        let found = cell(2);
        surface.thickness = thickness.filter(|t| t.is_finite()).ok_or_else(|| {
            format!("expected a thickness or the name of a distance, found {found:.40}")
        })?;
        surface.medium = self.medium(cell(3), cell(5), cell(6))?;
        surface.semi_diameter = number(cell(4))
            .filter(|d| d.is_finite())
            .map_or(0.0, |d| 0.5 * d);
        self.rows
            .insert(cell(0).to_string(), self.design.surfaces.len());
        self.gaps.push(gap);
        self.design.surfaces.push(surface);
        Ok(())
    }

    /// By its name where that is known, else by its numbers, which rows have anyway.
    fn medium(&self, index: &str, abbe: &str, name: &str) -> Result<Medium, String> {
        let Some(index) = number(index).filter(|n| *n != 1.0 && *n != 0.0) else {
            return Ok(Medium::default());
        };
        let abbe = number(abbe).unwrap_or(0.0);
        let model = Medium::model(name, index, abbe)?;
        let named = Medium::named(name, self.glasses).ok();
        // Of the same glass, its formula says more.
        let same =
            named.filter(|m| (m.glass.index - index).abs() < 2e-4 && m.glass.formula.is_some());
        Ok(same.unwrap_or(model))
    }

    fn asphere(&mut self, cells: &[&str]) -> Result<(), String> {
        let [row, _, conic, coefficients @ ..] = cells else {
            return Ok(());
        };
        let place = self.rows.get(*row).copied();
        let surface = place.and_then(|i| self.design.surfaces.get_mut(i));
        let surface =
            surface.ok_or_else(|| format!("no row of [lens data] has the number {row:.40}"))?;
        surface.asphere.conic = number(conic).filter(|k| k.is_finite()).unwrap_or(0.0);
        let odd = self
            .constants
            .get("asphericaloddcount")
            .map(|n| n.parse().unwrap_or(1));
        let first = if self.constants.contains_key("asphericala2") {
            2
        } else {
            4
        };
        let powers = match odd {
            Some(count) => odd_powers(count),
            None => (0..MAX_NUMBERS).map(|i| first + 2 * i).collect(),
        };
        let coefficients = coefficients.iter().filter(|c| !c.is_empty());
        for (power, text) in powers.into_iter().zip(coefficients) {
            let value = number(text).filter(|c| c.is_finite());
            let value = value.ok_or_else(|| format!("expected a coefficient, found {text:.40}"))?;
            asphere_term(surface, power, value)?;
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Prescription, PrescriptionError> {
        if self.design.surfaces.is_empty() && self.design.notes.errors.is_empty() {
            return Err(PrescriptionError::Empty);
        }
        let first = |name: &str| self.distances.get(name).and_then(|v| v.first()).copied();
        let light = &mut self.design.light;
        if let Some(f) = first("f-number").filter(|f| *f > 0.0) {
            light.beam = Beam::FNumber(f);
        }
        if let Some(angle) = first("angle of view") {
            light.fields = [0.35, 0.5].map(|part| Field::at(part * angle)).to_vec();
        } else if let Some(diameter) = first("image height") {
            light.kind = FieldKind::ImageHeight;
            light.fields = [0.35, 0.5].map(|part| Field::at(part * diameter)).to_vec();
        }
        if let Some(distance) = first("d0") {
            light.object_distance = distance;
        }
        let Positioned { table, warning } = self.positions();
        if let (Some(warning), Some(s)) = (warning, self.design.surfaces.first()) {
            let note = s.note(warning);
            self.design.notes.warnings.push(note);
        }
        self.design.gaps = table;
        self.design.prescription()
    }

    /// The positions of its groups, the surfaces counted as the file does.
    fn positions(&self) -> Positioned {
        let count = self
            .gaps
            .iter()
            .flatten()
            .filter_map(|name| Some(self.distances.get(name)?.len()));
        let count = count.max().unwrap_or(0);
        let at = |name: &str, i: usize| {
            self.distances
                .get(name)
                .and_then(|v| v.get(i).or(v.first()))
                .copied()
        };
        let far = |i: &usize| at("d0", *i).is_none_or(f64::is_infinite);
        let zooms: Vec<usize> = (0..count).filter(far).collect();
        let moves = self.gaps.iter().flatten().any(|name| {
            self.distances
                .get(name)
                .is_some_and(|v| v.iter().any(|x| *x != v[0]))
        });
        if count < 2 || !moves {
            return Positioned::default();
        }
        let length = |i: usize| -> f64 {
            let all = self.design.surfaces.iter().zip(&self.gaps);
            all.map(|(s, gap)| {
                gap.as_ref()
                    .and_then(|name| at(name, i))
                    .unwrap_or(s.thickness)
            })
            .sum()
        };
        let focusing = zooms.len() == 1;
        let chosen: Vec<usize> = if focusing {
            (0..count).collect()
        } else {
            zooms
        };
        let zoom = chosen.iter().map(|i| at("focal length", *i));
        let zoom = zoom.collect::<Option<Vec<f64>>>().filter(|_| !focusing);
        let focus = |i: &usize| {
            at("d0", *i)
                .filter(|d| d.is_finite())
                .map(|d| 1e-3 * (d + length(*i)))
        };
        let table = PositionTable {
            zoom,
            focus: focusing.then(|| chosen.iter().map(focus).collect()),
            gaps: self.gap_tables(&chosen),
        };
        let left_out = count - chosen.len();
        let warning = (left_out > 0).then(|| {
            format!("{left_out} of its {count} positions, at near distances, are left out")
        });
        let usable = !chosen.is_empty() && (table.zoom.is_some() || table.focus.is_some());
        Positioned {
            table: usable.then_some(table),
            warning,
        }
    }

    fn gap_tables(&self, positions: &[usize]) -> Vec<GapTable> {
        let mut names: Vec<&String> = self.gaps.iter().flatten().collect();
        names.sort();
        names.dedup();
        let table = |name: &String| {
            let values = &self.distances[name];
            let at = |i: &usize| values.get(*i).or(values.first()).copied().unwrap_or(0.0);
            let behind = self
                .gaps
                .iter()
                .enumerate()
                .filter(|(_, gap)| gap.as_ref() == Some(name));
            GapTable {
                name: name.clone(),
                behind: behind.map(|(i, _)| i).collect(),
                values: positions.iter().map(at).collect(),
            }
        };
        names.into_iter().map(table).collect()
    }
}

/// What a file's columns are.
#[derive(Default)]
struct Positioned {
    table: Option<PositionTable>,
    warning: Option<String>,
}

/// The powers of coefficients with `count` odd ones, r³ and up, between the even ones from r⁴.
fn odd_powers(count: usize) -> Vec<usize> {
    let odd = (0..count.min(MAX_NUMBERS)).map(|i| 3 + 2 * i);
    let even = (0..MAX_NUMBERS).map(|i| 4 + 2 * i);
    let mut powers: Vec<usize> = odd.chain(even).collect();
    powers.sort_unstable();
    powers
}
