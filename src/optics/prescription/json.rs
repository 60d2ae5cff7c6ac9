//! Lenses in JSON: ISET's format, and what it has no fields for.
//!
//! ```json
//! {"name": "biconvex", "units": "mm", "surfaces": [
//!   {"radius": 50, "thickness": 5, "ior": 1.5168, "semi_aperture": 10, "abbe": 64.2, "glass": "N-BK7"},
//!   {"radius": -50, "thickness": 2, "ior": 1, "semi_aperture": 10, "conic_constant": -1, "aspheric_terms": [0, 1e-6]},
//!   {"radius": 0, "thickness": 0, "ior": 0, "semi_aperture": 4}
//! ], "film_distance": 40}
//! ```
//!
//! Of ISET (isetlens and the lenses of isetcam): `surfaces` from the scene to the film with `radius`, 0 for a plane, which is a stop
//! where `ior`, the index behind, is 0 too; `thickness` to the next; `semi_aperture`; `conic_constant`; all in `units` (mm where it is missing).
//! A pair of numbers represents a biconic surface, which is read where both are the same. More is fstop's own: `stop` (true for a stop
//! that does not look like one), `abbe`, `glass`, `coating` (`INDEX@NM`), `dispersion` (a `formula`, "cauchy", "sellmeier" or the number of one of glass catalogues, and its
//! `coefficients`), `aspheric_terms` (of r², r⁴, …), `film_distance` behind the last surface, and `positions` of groups
//! ([`super::positions`]): `zoom`, `focus` in meters (null for infinity), and `gaps` with their `name`, the surfaces they lie `behind`, from 0, and
//! their `values`.

use super::positions::PositionTable;
use super::write::WriteError;
use super::{INDICES, Notes, Prescription, PrescriptionError, RowNote};
use crate::optics::asphere::{Asphere, TERMS};
use crate::optics::catalogue_formula::CatalogueFormula;
use crate::optics::dispersion::Dispersion;
use crate::optics::surface::{GlassName, Surface};
use serde::{Deserialize, Serialize};

/// The file.
#[derive(Serialize, Deserialize)]
struct LensFile {
    #[serde(default)]
    name: String,
    #[serde(default = "millimeters")]
    units: String,
    surfaces: Vec<SurfaceEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    film_distance: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    positions: Option<PositionTable>,
}

fn millimeters() -> String {
    "mm".to_string()
}

/// A number, or one for each meridian.
#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(untagged)]
enum Meridians {
    Same(f64),
    Two([f64; 2]),
}

impl Meridians {
    fn number(self, what: &str) -> Result<f64, String> {
        match self {
            Meridians::Same(x) => Ok(x),
            Meridians::Two([x, y]) if x == y => Ok(x),
            Meridians::Two(_) => Err(format!(
                "{what} of two meridians: surfaces that are not rotationally symmetric cannot be traced"
            )),
        }
    }
}

#[derive(Serialize, Deserialize)]
struct SurfaceEntry {
    radius: Meridians,
    thickness: f64,
    /// An index at several wavelengths is not told apart from other pairs.
    ior: f64,
    semi_aperture: Meridians,
    #[serde(default, alias = "conic", skip_serializing_if = "Option::is_none")]
    conic_constant: Option<Meridians>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    aspheric_terms: Vec<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    abbe: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    dispersion: Option<Formula>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    glass: Option<String>,
    /// `INDEX@NM`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    coating: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    stop: Option<bool>,
}

/// A dispersion formula.
#[derive(Serialize, Deserialize)]
struct Formula {
    formula: FormulaName,
    coefficients: Vec<f64>,
}

#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum FormulaName {
    Word(String),
    Number(u8),
}

/// The text of a lens called `name`.
pub(super) fn text(lens: &Prescription, name: &str) -> Result<String, WriteError> {
    let mut medium = 1.0;
    let mut surfaces = Vec::new();
    for (i, s) in lens.surfaces.iter().enumerate() {
        if !(s.aperture > 0.0 && s.aperture.is_finite()) {
            return Err(WriteError::NoDiameter(i + 1));
        }
        surfaces.push(entry(s, medium));
        medium = s.index;
    }
    let file = LensFile {
        name: name.to_string(),
        units: millimeters(),
        surfaces,
        film_distance: Some(lens.film_distance),
        positions: lens.positions.as_ref().map(|p| p.to_table()),
    };
    // Numbers and names have no text that fails.
    Ok(serde_json::to_string_pretty(&file).unwrap_or_default() + "\n")
}

fn entry(s: &Surface, before: f64) -> SurfaceEntry {
    let plain = s.radius.is_infinite() && s.asphere.is_none() && s.index == before;
    let radius = if s.radius.is_infinite() {
        0.0
    } else {
        s.radius
    };
    let asphere = s.asphere.as_ref();
    let formula = |d: &Dispersion| {
        let (formula, coefficients) = match d {
            Dispersion::Cauchy(c) => (FormulaName::Word("cauchy".into()), c.to_vec()),
            Dispersion::Sellmeier(c) => (FormulaName::Word("sellmeier".into()), c.to_vec()),
            Dispersion::Catalogue(c) => {
                (FormulaName::Number(c.number()), c.coefficients().to_vec())
            }
        };
        Formula {
            formula,
            coefficients,
        }
    };
    SurfaceEntry {
        radius: Meridians::Same(radius),
        thickness: s.thickness,
        // ISET's stop has no index.
        ior: if s.is_stop && plain { 0.0 } else { s.index },
        semi_aperture: Meridians::Same(0.5 * s.aperture),
        conic_constant: asphere.map(|a| Meridians::Same(a.conic)),
        aspheric_terms: asphere.map_or(Vec::new(), |a| a.terms.to_vec()),
        abbe: s.abbe,
        dispersion: s.dispersion.as_ref().map(formula),
        glass: s.glass.map(|name| name.to_string()),
        coating: s.coating.map(|coating| coating.to_string()),
        // Only where the numbers say otherwise.
        stop: (s.is_stop != plain).then_some(s.is_stop),
    }
}

/// Reads the text of a file.
pub fn parse(text: &str) -> Result<Prescription, PrescriptionError> {
    let file: LensFile = serde_json::from_str(text).map_err(|e| unreadable(&e))?;
    let mut notes = Notes::default();
    let unit = match file.units.as_str() {
        "mm" | "millimeter" | "millimeters" => 1.0,
        "m" | "meter" | "meters" => 1000.0,
        "cm" => 10.0,
        "um" | "µm" => 1e-3,
        "inch" | "in" => 25.4,
        other => {
            let message = format!("units {other}; expected mm, cm, m, um or inch");
            return Err(PrescriptionError::Rows(vec![note(0, message)]));
        }
    };
    let mut medium = 1.0;
    let mut surfaces = Vec::new();
    for (i, entry) in file.surfaces.iter().enumerate() {
        match entry.surface(medium) {
            Ok(surface) => {
                medium = surface.index;
                surfaces.push(surface);
            }
            Err(message) => notes.errors.push(note(i + 1, message)),
        }
    }
    if let (Some(distance), Some(last)) = (file.film_distance, surfaces.last_mut()) {
        last.thickness = distance;
    }
    match file.positions.map(|table| table.positions(surfaces.len())) {
        Some(Ok(positions)) => notes.positions = positions,
        Some(Err(message)) => notes.errors.push(note(0, message)),
        None => {}
    }
    let lens = notes.prescription(surfaces)?;
    Ok(if unit == 1.0 { lens } else { lens.scaled(unit) })
}

/// An error in the words of the reader, at its place.
pub(super) fn unreadable(error: &serde_json::Error) -> PrescriptionError {
    let text = error.to_string();
    // It ends by the place, which the note says.
    let message = text.split(" at line ").next().unwrap_or_default();
    PrescriptionError::Rows(vec![RowNote {
        line: error.line(),
        column: error.column(),
        row: 0,
        message: message.to_string(),
    }])
}

/// Of a surface, from 1; the lines of JSON say little.
pub(super) fn note(row: usize, message: String) -> RowNote {
    RowNote {
        line: 1,
        column: 1,
        row,
        message,
    }
}

impl SurfaceEntry {
    /// As the tracer wants it, behind a space of index `before`.
    fn surface(&self, before: f64) -> Result<Surface, String> {
        let radius = self.radius.number("the radius")?;
        let conic = self.conic_constant.map(|k| k.number("the conic constant"));
        let conic = conic.transpose()?;
        let semi_aperture = self.semi_aperture.number("semi_aperture")?;
        let asphere = self.asphere(conic)?;
        let plane = radius == 0.0;
        let bare = plane && asphere.is_none() && (self.ior == 0.0 || self.ior == before);
        let is_stop = self.stop.unwrap_or(bare);
        let index = match self.ior {
            0.0 if is_stop => before,
            0.0 => 1.0,
            n if INDICES.contains(&n) => n,
            n => {
                return Err(format!(
                    "an ior of {n}; expected 1 to about 4, or 0 of a stop"
                ));
            }
        };
        let sizes = [radius, self.thickness, semi_aperture];
        if !sizes.iter().all(|x| x.is_finite() && x.abs() <= 1e30)
            || (!plane && radius.abs() < 1e-6)
            || semi_aperture <= 0.0
        {
            return Err("expected a finite radius of at least 1e-6, thickness, and a positive semi_aperture".into());
        }
        let glass = self.glass.as_deref().map(|name| {
            GlassName::new(name).ok_or_else(|| format!("expected a glass name, found {name:.40}"))
        });
        Ok(Surface {
            radius: if plane { f64::INFINITY } else { radius },
            thickness: self.thickness,
            index,
            abbe: self.abbe.filter(|v| *v > 0.0),
            dispersion: self.dispersion.as_ref().map(Formula::read).transpose()?,
            glass: glass.transpose()?,
            aperture: 2.0 * semi_aperture,
            is_stop,
            asphere,
            coating: self.coating.as_deref().map(str::parse).transpose()?,
        })
    }

    fn asphere(&self, conic: Option<f64>) -> Result<Option<Asphere>, String> {
        if self.aspheric_terms.len() > TERMS {
            let message = "more than 8 aspheric_terms, those of r² to r¹⁶";
            return Err(message.to_string());
        }
        if self.aspheric_terms.is_empty() && conic.is_none_or(|k| k == 0.0) {
            return Ok(None);
        }
        let mut asphere = Asphere {
            conic: conic.unwrap_or(0.0),
            ..Asphere::default()
        };
        asphere.terms[..self.aspheric_terms.len()].copy_from_slice(&self.aspheric_terms);
        Ok(Some(asphere))
    }
}

impl Formula {
    fn read(&self) -> Result<Dispersion, String> {
        let c = &self.coefficients;
        let found = match &self.formula {
            FormulaName::Word(word) if word == "cauchy" => {
                c[..].try_into().ok().map(Dispersion::Cauchy)
            }
            FormulaName::Word(word) if word == "sellmeier" => {
                c[..].try_into().ok().map(Dispersion::Sellmeier)
            }
            FormulaName::Number(number) => {
                CatalogueFormula::new(*number, c).map(Dispersion::of_catalogue)
            }
            FormulaName::Word(_) => None,
        };
        let found = found.ok_or("expected a dispersion formula: cauchy of 3 coefficients, sellmeier of 6, or a number from 1 to 13 of up to 10")?;
        found.check()?;
        Ok(found)
    }
}
