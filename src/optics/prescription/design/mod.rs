//! What the files of optical design programs have in common: surfaces between an object and a film, glasses by name, and the light that
//! the lens is made for, which says what the file leaves open of its clear diameters.
//!
//! Each reader makes a [`Design`] of its file; this folder makes a lens of that. Surfaces between equal media that are not the
//! stop are auxiliary planes of the design and left out, but for those with an aperture of their own.

pub(super) mod light;
#[cfg(test)]
mod tests;

use self::light::Light;
use super::cells::number;
use super::glass::{self, Glass, Glasses};
use super::positions::{GapTable, PositionTable};
use super::{INDICES, Notes, Prescription, PrescriptionError, RowNote};
use crate::optics::asphere::{Asphere, TERMS};
use crate::optics::coating::Coating;
use crate::optics::dispersion::LINE_D;
use crate::optics::surface::{GlassName, Surface};

/// The most surfaces of a lens: more than any has.
const MAX_SURFACES: usize = 1000;

/// The text of a file: Zemax writes UTF-16 with a byte order mark, other programs one byte per character.
pub fn decode(bytes: &[u8]) -> String {
    let wide = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes
            .chunks_exact(2)
            .map(|pair| unit([pair[0], pair[1]]))
            .collect();
        String::from_utf16_lossy(&units)
    };
    match bytes {
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes),
        // Without the mark: a text in Latin letters has a zero in every second byte.
        [first, 0, _, 0, ..] if *first != 0 => wide(bytes, u16::from_le_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8_lossy(rest).into_owned(),
        _ => String::from_utf8_lossy(bytes).into_owned(),
    }
}

/// What is behind a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Medium {
    pub name: String,
    pub glass: Glass,
}

impl Medium {
    /// What programs call a mirror.
    pub(super) fn is_mirror(name: &str) -> bool {
        let names = ["MIRROR", "REFL", "REFLECT", "RFL"];
        names.iter().any(|mirror| name.eq_ignore_ascii_case(mirror))
    }

    /// The glass of this name; air for an empty one.
    pub(super) fn named(name: &str, glasses: &Glasses) -> Result<Medium, String> {
        if Medium::is_mirror(name) {
            return Err("mirrors cannot be traced".to_string());
        }
        let found = glasses.named(name).ok_or_else(|| {
            format!(
                "unknown glass {name}; known are {} of the makers' and other common ones, those of catalogues (.agf) beside the lens or in {}, and codes of six digits",
                glass::count(),
                glass::PATH_VARIABLE
            )
        })?;
        Ok(Medium {
            name: name.to_string(),
            glass: found,
        })
    }

    /// A glass of these two numbers; without dispersion where the Abbe number is not positive.
    pub(super) fn model(name: &str, index: f64, abbe: f64) -> Result<Medium, String> {
        if !INDICES.contains(&index) {
            return Err(format!(
                "a refractive index of {index}; expected 1 to about 4"
            ));
        }
        let glass = Glass {
            index,
            abbe: (abbe > 0.0).then_some(abbe),
            formula: None,
        };
        Ok(Medium {
            name: name.to_string(),
            glass,
        })
    }
}

/// The circle that a surface stops rays outside of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Aperture {
    /// None but the surface's own edge.
    #[default]
    Edge,
    /// Of this radius.
    Radius(f64),
    /// Of half the clear diameter, whatever that is.
    Floating,
}

/// One surface as the file has it, lengths in the file's unit.
#[derive(Clone, Debug, Default)]
pub(super) struct DesignSurface {
    /// Where it begins in the file.
    pub line: usize,
    /// Its number there.
    pub row: usize,
    pub curvature: f64,
    pub asphere: Asphere,
    pub thickness: f64,
    pub medium: Medium,
    /// Half the clear diameter; 0 where the file leaves it to the rays.
    pub semi_diameter: f64,
    /// `true` if that was given by hand, not by the rays of the design.
    pub fixed_diameter: bool,
    pub aperture: Aperture,
    pub is_stop: bool,
    /// It has a layer of magnesium fluoride, a quarter of the primary wavelength thick.
    pub is_coated: bool,
}

impl DesignSurface {
    pub(super) fn note(&self, message: impl Into<String>) -> RowNote {
        RowNote {
            line: self.line,
            column: 1,
            row: self.row,
            message: message.into(),
        }
    }

    /// Sets the curvature to that of a radius, 0 or infinite for a plane.
    pub(super) fn set_radius(&mut self, radius: f64) {
        self.curvature = match radius {
            0.0 => 0.0,
            r => 1.0 / r,
        };
    }

    /// Distance from the axis at which it stops rays; infinite where that is left to the rays.
    fn rim(&self) -> f64 {
        let radius = match self.aperture {
            Aperture::Radius(radius) => radius,
            Aperture::Edge | Aperture::Floating => self.semi_diameter,
        };
        match radius > 0.0 {
            true => radius,
            false => f64::INFINITY,
        }
    }

    /// Its shape departs from a sphere.
    pub(super) fn asphere(&self) -> Option<Asphere> {
        let mut a = self.asphere;
        // A plane has no conic.
        if self.curvature == 0.0 {
            a.conic = 0.0;
        }
        (a != Asphere::default()).then_some(a)
    }

    /// As the tracer wants it, with `unit` mm for a unit of the file and the primary wavelength in µm.
    fn surface(&self, unit: f64, wavelength: f64) -> Result<Surface, &'static str> {
        let surface = Surface {
            radius: match self.curvature {
                0.0 => f64::INFINITY,
                curvature => 1.0 / curvature * unit,
            },
            thickness: self.thickness * unit,
            index: self.medium.glass.index,
            abbe: self.medium.glass.abbe,
            dispersion: self.medium.glass.formula.map(|f| f.dispersion),
            // Programs begin the names that they make up with underscores.
            glass: GlassName::new(&self.medium.name)
                .filter(|name| !name.as_str().starts_with('_') && self.medium.glass != glass::AIR),
            aperture: 2.0 * self.rim() * unit,
            is_stop: self.is_stop,
            asphere: self.asphere().map(|a| a.scaled(unit)),
            coating: (self.is_coated).then(|| Coating::magnesium_fluoride(1000.0 * wavelength)),
        };
        let lengths = [surface.curvature(), surface.thickness];
        let terms = surface.asphere.iter().flat_map(|a| &a.terms);
        let finite = lengths.iter().chain(terms).all(|x| x.is_finite());
        if !finite || surface.radius.abs() < 1e-6 || surface.aperture == 0.0 {
            return Err("a surface of infinite size or curvature");
        }
        Ok(surface)
    }
}

/// A file, read.
#[derive(Default)]
pub(super) struct Design {
    /// Between object and film.
    pub surfaces: Vec<DesignSurface>,
    /// Millimeters per unit of the file.
    pub unit: f64,
    /// The wavelength that the lens is made for, µm, with its line; `None` where that is not said.
    pub wavelength: Option<(usize, f64)>,
    /// In units of the file.
    pub light: Light,
    /// In front of the first surface.
    pub object_medium: Medium,
    /// Of the film.
    pub film_curvature: f64,
    /// Positions of groups, in mm, the surfaces counted from 0 as they are here.
    pub gaps: Option<PositionTable>,
    pub notes: Notes,
}

impl Design {
    /// The lens, if nothing is wrong with it.
    pub(super) fn prescription(mut self) -> Result<Prescription, PrescriptionError> {
        if self.surfaces.len() > MAX_SURFACES {
            let first = &self.surfaces[MAX_SURFACES];
            let note = first.note(format!("more than {MAX_SURFACES} surfaces"));
            return Err(PrescriptionError::Rows(vec![note]));
        }
        let wavelength = self.primary_wavelength();
        self.check_ends();
        let mut surfaces: Vec<Surface> = Vec::new();
        // Those of the file that they are.
        let mut rows = Vec::new();
        // For each of the file's: the one that its thickness is part of, and that thickness in mm.
        let mut spaces = Vec::new();
        let mut before = glass::AIR;
        for row in std::mem::take(&mut self.surfaces) {
            let bends = row.medium.glass != before;
            let left_out = !bends && !row.is_stop && row.aperture == Aperture::Edge;
            let owner = (surfaces.len() + usize::from(!left_out)).checked_sub(1);
            spaces.push((owner, row.thickness * self.unit));
            if left_out {
                self.warn_left_out(&row);
                // The vertex of what follows moves on; in front of the first surface only the object is measured from.
                match surfaces.last_mut() {
                    Some(last) => last.thickness += row.thickness * self.unit,
                    None => self.light.object_distance += row.thickness,
                }
                continue;
            }
            before = row.medium.glass;
            match row.surface(self.unit, wavelength.unwrap_or(LINE_D)) {
                Ok(surface) => {
                    surfaces.push(self.at_wavelength(surface, &row, wavelength));
                    rows.push(row);
                }
                Err(message) => self.notes.errors.push(row.note(message)),
            }
        }
        if self.notes.errors.is_empty() {
            self.open_diameters(&mut surfaces, &rows);
            self.place_gaps(&rows, &spaces);
        }
        self.notes.prescription(surfaces)
    }

    /// What object and film must be: in air, and flat.
    fn check_ends(&mut self) {
        let note = |message: String| RowNote {
            line: self.surfaces.first().map_or(1, |first| first.line),
            column: 1,
            row: 0,
            message,
        };
        let Medium { name, glass } = &self.object_medium;
        if glass.index != 1.0 {
            let name = if name.is_empty() { "a medium" } else { name };
            self.notes.errors.push(note(format!(
                "the object lies in {name} of index {:.4}: lenses are traced with air in front of them",
                glass.index
            )));
        }
        if self.film_curvature != 0.0 {
            self.notes.warnings.push(note(format!(
                "the file's film is curved, with a radius of {:.4} mm: it is flat here",
                self.unit / self.film_curvature
            )));
        }
    }

    /// Hands on the positions of groups, of the surfaces that are left; `spaces` are owner and thickness of all.
    fn place_gaps(&mut self, rows: &[DesignSurface], spaces: &[(Option<usize>, f64)]) {
        let Some(table) = self.gaps.take() else {
            return;
        };
        match merged(table, spaces).positions(rows.len()) {
            Ok(positions) => self.notes.positions = positions,
            Err(message) => {
                let note = rows
                    .first()
                    .map(|row| row.note(format!("{message}; it is read at its first position")));
                self.notes.warnings.extend(note);
            }
        }
    }

    /// The primary wavelength, µm, where it is not the d line.
    fn primary_wavelength(&mut self) -> Option<f64> {
        let (line, wavelength) = self.wavelength?;
        if !(0.1..=20.0).contains(&wavelength) {
            self.notes.warnings.push(RowNote {
                line,
                column: 1,
                row: 0,
                message: format!(
                    "a primary wavelength of {wavelength} µm; expected 0.1 to 20: indices are those of the d line"
                ),
            });
            return None;
        }
        // Files round it to three digits.
        ((wavelength - LINE_D).abs() > 1e-3).then_some(wavelength)
    }

    /// What a surface between equal media might have been meant for.
    fn warn_left_out(&mut self, row: &DesignSurface) {
        if row.curvature != 0.0 || row.asphere().is_some() {
            self.notes.warnings.push(
                row.note("a curved surface between equal media bends no ray and is left out"),
            );
        } else if row.fixed_diameter {
            self.notes.warnings.push(row.note(format!(
                "the semi-diameter {} of a surface without power blocks nothing; for a baffle give it an aperture (FLAP or CLAP)",
                row.semi_diameter
            )));
        }
    }

    /// `surface`, which is that of `row`, with its index for this wavelength.
    fn at_wavelength(
        &mut self,
        surface: Surface,
        row: &DesignSurface,
        wavelength: Option<f64>,
    ) -> Surface {
        let (Some(wavelength), Some(formula)) = (wavelength, row.medium.glass.dispersion()) else {
            return surface;
        };
        let index = formula.dispersion.index(wavelength);
        let [shortest, longest] = formula.range;
        if !(shortest..=longest).contains(&wavelength) {
            self.notes.warnings.push(row.note(format!(
                "the dispersion of {} is known from {shortest} to {longest} µm; its index of {index:.5} at the primary wavelength {wavelength} µm is a guess",
                row.medium.name
            )));
        }
        // Not a number, or none that light can have.
        if !INDICES.contains(&index) {
            self.notes.errors.push(row.note(format!(
                "the dispersion of {} gives no index at {wavelength} µm; give a model glass (`GLAS ___BLANK 1 0 n_d V_d`)",
                row.medium.name
            )));
            return surface;
        }
        Surface {
            index,
            dispersion: Some(formula.dispersion),
            ..surface
        }
    }

    /// Says where the stop's own diameter and the file's aperture are of different f-numbers.
    fn warn_of_stop(&mut self, light: &Light, surfaces: &[Surface], rows: &[DesignSurface]) {
        /// Over the beam's: files round diameters.
        const ALIKE: f64 = 0.05;
        let stop = surfaces.iter().position(|s| s.is_stop);
        let known = stop.filter(|i| surfaces[*i].aperture.is_finite());
        let beam = known.and_then(|i| Some((i, 2.0 * light.stop_radius(surfaces)?)));
        let Some((i, beam)) = beam else { return };
        let own = surfaces[i].aperture;
        if (own - beam).abs() > ALIKE * beam {
            self.notes.warnings.push(rows[i].note(format!(
                "the file's aperture fills {beam:.4} mm of the stop, whose own diameter is {own:.4} mm: the stop's diameter counts; to use the other, give it as the aperture diameter"
            )));
        }
    }

    /// Gives the surfaces without a clear diameter that of the rays of the design.
    fn open_diameters(&mut self, surfaces: &mut [Surface], rows: &[DesignSurface]) {
        let open: Vec<usize> = (0..surfaces.len())
            .filter(|i| surfaces[*i].aperture.is_infinite())
            .collect();
        let light = std::mem::take(&mut self.light).scaled(self.unit);
        self.warn_of_stop(&light, surfaces, rows);
        let Some(first) = open.first() else { return };
        let lit = light.clear_radii(surfaces);
        for i in &open {
            let radius = lit.radii.get(*i).copied().unwrap_or(0.0);
            if radius > 0.0 && radius.is_finite() {
                surfaces[*i].aperture = 2.0 * radius;
            } else {
                let message = "no clear diameter, and none follows from the file's aperture and fields; let the program compute or give one (DIAM)";
                self.notes.errors.push(rows[*i].note(message));
            }
        }
        let count = open.len();
        self.notes.warnings.push(rows[*first].note(format!(
            "{count} clear diameter(s) that the file leaves open are those of its rays{}",
            lit.remark
        )));
    }
}

/// The table for the surfaces that are left: a plane left out has its thickness added to that in front of it, changing or not; in
/// front of the first surface only the object is measured from.
fn merged(mut table: PositionTable, spaces: &[(Option<usize>, f64)]) -> PositionTable {
    let owner = |i: usize| spaces.get(i).and_then(|space| space.0);
    let places = table.gaps.iter().flat_map(|gap| &gap.behind);
    let alone = |i: usize| spaces.iter().filter(|s| s.0 == owner(i)).count() == 1;
    if places.clone().all(|i| owner(*i).is_some() && alone(*i)) {
        for place in table.gaps.iter_mut().flat_map(|gap| &mut gap.behind) {
            *place = owner(*place).unwrap_or(*place);
        }
        return table;
    }
    let mut owners: Vec<usize> = places.filter_map(|i| owner(*i)).collect();
    owners.sort_unstable();
    owners.dedup();
    let count = table
        .zoom
        .as_ref()
        .map_or_else(|| table.focus.as_ref().map_or(0, Vec::len), Vec::len);
    let thickness = |i: usize, position: usize| {
        let gap = table.gaps.iter().find(|gap| gap.behind.contains(&i));
        gap.and_then(|gap| gap.values.get(position))
            .copied()
            .unwrap_or(spaces[i].1)
    };
    let gap = |k: usize| GapTable {
        name: format!("D{}", k + 1),
        behind: vec![k],
        values: (0..count)
            .map(|position| {
                (0..spaces.len())
                    .filter(|i| spaces[*i].0 == Some(k))
                    .map(|i| thickness(i, position))
                    .sum()
            })
            .collect(),
    };
    let gaps = owners.into_iter().map(gap).collect();
    PositionTable { gaps, ..table }
}

/// The finite number at `i`.
pub(super) fn value(words: &[&str], i: usize, what: &str) -> Result<f64, String> {
    number(words.get(i).copied().unwrap_or("nothing"), what)
}

/// Sets the coefficient of r^`power` of a surface.
pub(super) fn asphere_term(
    surface: &mut DesignSurface,
    power: usize,
    value: f64,
) -> Result<(), String> {
    let row = surface.row;
    match power.is_multiple_of(2) && (2..=2 * TERMS).contains(&power) {
        true => surface.asphere.terms[power / 2 - 1] = value,
        false if value == 0.0 => {}
        false => {
            return Err(format!(
                "surface {row} has a term of r^{power}; those of even powers up to r¹⁶ can be traced"
            ));
        }
    }
    Ok(())
}
