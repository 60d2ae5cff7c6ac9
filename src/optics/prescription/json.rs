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
//! Of ISET (isetlens and the lenses of isetcam; read as `omni` of pbrt-v3-spectral does, `src/cameras/omni.cpp`): `surfaces` from the scene to the film
//! with `radius`, 0 for a plane, which is a stop where `ior`, the index behind, is 0 too; `thickness` to the next; `semi_aperture`; `conic_constant`;
//! `aspheric_coefficients` (of r⁴, r⁶, …); all in `units` (mm where it is missing). A pair of numbers represents a biconic surface, which is read where
//! both are the same; a pair of lists for `ior` gives wavelengths in nm and the indices there. A `transform` other than the identity is an error, and a
//! `microlens` array is left out. More is fstop's own: `stop` (true for a stop
//! that does not look like one), `abbe`, `glass`, `coating` (`INDEX@NM`), `dispersion` (a `formula`, "cauchy", "sellmeier" or the number of one of glass catalogues, and its
//! `coefficients`), `aspheric_terms` (of r², r⁴, …), `film_distance` behind the last surface, and `positions` of groups
//! ([`super::positions`]): `zoom`, `focus` in meters (null for infinity), and `gaps` with their `name`, the surfaces they lie `behind`, from 0, and
//! their `values`. Other fields are warned of.

use super::positions::PositionTable;
use super::write::WriteError;
use super::{INDICES, Notes, Prescription, PrescriptionError, RowNote};
use crate::optics::asphere::Asphere;
use crate::optics::catalogue_formula::CatalogueFormula;
use crate::optics::dispersion::{Dispersion, LINE_C, LINE_D, LINE_F};
use crate::optics::surface::{GlassName, Surface};
use crate::syntax::suggest;
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt;

/// Fields that are not read.
type Rest = BTreeMap<String, Value>;

/// Fields of the file, and of a surface: what an unknown one may have been meant to be.
const FILE_FIELDS: [&str; 6] = [
    "name",
    "units",
    "surfaces",
    "film_distance",
    "positions",
    "microlens",
];
const SURFACE_FIELDS: [&str; 13] = [
    "radius",
    "thickness",
    "ior",
    "semi_aperture",
    "conic_constant",
    "aspheric_coefficients",
    "aspheric_terms",
    "transform",
    "abbe",
    "dispersion",
    "glass",
    "coating",
    "stop",
];

/// Fields of ISET's files, and of their surfaces, that do not change the lens.
const FILE_REMARKS: [&str; 4] = ["description", "type", "metadata", "comment"];
const SURFACE_REMARKS: [&str; 3] = ["description", "name", "comment"];

/// The file.
#[derive(Serialize, Deserialize)]
struct LensFile {
    #[serde(default)]
    name: String,
    #[serde(default = "millimeters")]
    units: String,
    surfaces: Option<Vec<SurfaceEntry>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    film_distance: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    positions: Option<PositionTable>,
    #[serde(flatten)]
    rest: Rest,
}

fn millimeters() -> String {
    "mm".to_string()
}

/// A number, or a list of numbers or lists; `[]` and null, which MATLAB writes for what is not given, are the empty list. MATLAB writes a list of one
/// as a number.
#[derive(Clone, Serialize)]
#[serde(untagged)]
enum Numbers {
    One(f64),
    List(Vec<Numbers>),
}

impl Default for Numbers {
    fn default() -> Numbers {
        Numbers::List(Vec::new())
    }
}

impl<'de> Deserialize<'de> for Numbers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Numbers, D::Error> {
        deserializer.deserialize_any(NumbersVisitor)
    }
}

struct NumbersVisitor;

impl<'de> Visitor<'de> for NumbersVisitor {
    type Value = Numbers;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or a list of numbers")
    }

    fn visit_f64<E: Error>(self, x: f64) -> Result<Numbers, E> {
        Ok(Numbers::One(x))
    }

    fn visit_u64<E: Error>(self, x: u64) -> Result<Numbers, E> {
        Ok(Numbers::One(x as f64))
    }

    fn visit_i64<E: Error>(self, x: i64) -> Result<Numbers, E> {
        Ok(Numbers::One(x as f64))
    }

    fn visit_unit<E: Error>(self) -> Result<Numbers, E> {
        Ok(Numbers::default())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Numbers, A::Error> {
        let mut list = Vec::new();
        while let Some(item) = items.next_element()? {
            list.push(item);
        }
        Ok(Numbers::List(list))
    }
}

impl Numbers {
    fn is_empty(&self) -> bool {
        matches!(self, Numbers::List(list) if list.is_empty())
    }

    /// As a list without lists.
    fn list(&self) -> Option<Vec<f64>> {
        match self {
            Numbers::One(x) => Some(vec![*x]),
            Numbers::List(list) => list.iter().map(Numbers::one).collect(),
        }
    }

    fn one(&self) -> Option<f64> {
        match self {
            Numbers::One(x) => Some(*x),
            Numbers::List(_) => None,
        }
    }

    /// One number, or one for each meridian.
    fn number(&self, what: &str) -> Result<f64, String> {
        match self.list().as_deref() {
            Some([x]) => Ok(*x),
            Some([x, y]) if x == y => Ok(*x),
            Some([_, _]) => Err(format!(
                "{what} of two meridians: surfaces that are not rotationally symmetric cannot be traced"
            )),
            _ => Err(format!(
                "{what}: expected a number, or one for each of two meridians"
            )),
        }
    }

    /// Returns `true` for a unit matrix of 3 or 4 rows and columns; ISET has 4 columns of 3.
    fn is_identity(&self) -> bool {
        let Numbers::List(lists) = self else {
            return false;
        };
        let unit = |(i, list): (usize, &Numbers)| {
            list.list().is_some_and(|list| {
                let near = |(j, x): (usize, &f64)| (x - f64::from(u8::from(i == j))).abs() < 1e-9;
                (3..=4).contains(&list.len()) && list.iter().enumerate().all(near)
            })
        };
        (3..=4).contains(&lists.len()) && lists.iter().enumerate().all(unit)
    }
}

/// Refractive index and Abbe number of a medium.
struct Medium {
    index: f64,
    abbe: Option<f64>,
    warning: Option<String>,
}

impl Medium {
    /// Of an index, or of a list of wavelengths in nm and one of the indices there: between them n is linear in 1/λ², as Cauchy's formula says to first
    /// order.
    fn read(ior: &Numbers) -> Result<Medium, String> {
        let constant = |index| Medium {
            index,
            abbe: None,
            warning: None,
        };
        let lists = match ior {
            Numbers::One(index) => return Ok(constant(*index)),
            Numbers::List(lists) => lists,
        };
        let lists = lists
            .iter()
            .map(|list| list.list().filter(|_| list.one().is_none()));
        let lists: Option<Vec<_>> = lists.collect();
        let Some([wavelengths, indices]) = lists.as_deref() else {
            return Err("ior: expected an index, or [[wavelengths in nm], [indices there]]".into());
        };
        let positive = wavelengths.iter().all(|nm| *nm > 0.0);
        if wavelengths.is_empty() || wavelengths.len() != indices.len() || !positive {
            return Err(format!(
                "ior: expected as many indices as wavelengths in nm, found {} and {}",
                indices.len(),
                wavelengths.len()
            ));
        }
        if indices.iter().all(|n| *n == indices[0]) {
            return Ok(constant(indices[0]));
        }
        let pairs = wavelengths.iter().zip(indices);
        let mut table: Vec<(f64, f64)> = pairs.map(|(nm, n)| ((1e3 / nm).powi(2), *n)).collect();
        table.sort_by(|a, b| a.0.total_cmp(&b.0));
        let at = |line: f64| {
            let x = line.powi(-2);
            let between = |pair: &&[(f64, f64)]| pair[0].0 <= x && x <= pair[1].0;
            let pair = table.windows(2).find(between)?;
            let part = (x - pair[0].0) / (pair[1].0 - pair[0].0);
            let n = pair[0].1 + part * (pair[1].1 - pair[0].1);
            n.is_finite().then_some(n)
        };
        let least = wavelengths.iter().copied().fold(f64::INFINITY, f64::min);
        let most = wavelengths.iter().copied().fold(0.0, f64::max);
        let index = at(LINE_D).ok_or_else(|| {
            format!(
                "ior: the table from {least} to {most} nm tells no index at 587.6 nm, the d line; expected wavelengths in nm, each once"
            )
        })?;
        let spread = at(LINE_F).zip(at(LINE_C)).map(|(f, c)| f - c);
        let abbe = spread.map(|spread| (index - 1.0) / spread);
        let abbe = abbe.filter(|abbe| *abbe > 0.0 && abbe.is_finite());
        let warning = abbe.is_none().then(|| {
            format!("the ior table from {least} to {most} nm tells no Abbe number: expected indices that fall from 486.1 to 656.3 nm; all colors see {index:.5}")
        });
        Ok(Medium {
            index,
            abbe,
            warning,
        })
    }
}

#[derive(Serialize, Deserialize)]
struct SurfaceEntry {
    radius: Numbers,
    thickness: f64,
    ior: Numbers,
    semi_aperture: Numbers,
    #[serde(default, alias = "conic", skip_serializing_if = "Numbers::is_empty")]
    conic_constant: Numbers,
    /// Of r⁴, r⁶, …
    #[serde(default, skip_serializing_if = "Numbers::is_empty")]
    aspheric_coefficients: Numbers,
    /// Of r², r⁴, …
    #[serde(default, skip_serializing_if = "Numbers::is_empty")]
    aspheric_terms: Numbers,
    #[serde(default, skip_serializing_if = "Numbers::is_empty")]
    transform: Numbers,
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
    #[serde(flatten)]
    rest: Rest,
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
        surfaces: Some(surfaces),
        film_distance: Some(lens.film_distance),
        positions: lens.positions.as_ref().map(|p| p.to_table()),
        rest: Rest::new(),
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
        radius: Numbers::One(radius),
        thickness: s.thickness,
        // ISET's stop has no index.
        ior: Numbers::One(if s.is_stop && plain { 0.0 } else { s.index }),
        semi_aperture: Numbers::One(0.5 * s.aperture),
        conic_constant: asphere.map_or_else(Numbers::default, |a| Numbers::One(a.conic)),
        aspheric_coefficients: Numbers::default(),
        aspheric_terms: asphere.map_or_else(Numbers::default, |a| {
            Numbers::List(a.terms.map(Numbers::One).to_vec())
        }),
        transform: Numbers::default(),
        abbe: s.abbe,
        dispersion: s.dispersion.as_ref().map(formula),
        glass: s.glass.map(|name| name.to_string()),
        coating: s.coating.map(|coating| coating.to_string()),
        // Only where the numbers say otherwise.
        stop: (s.is_stop != plain).then_some(s.is_stop),
        rest: Rest::new(),
    }
}

/// Reads the text of a file.
pub fn parse(text: &str) -> Result<Prescription, PrescriptionError> {
    let file: LensFile = serde_json::from_str(text).map_err(|e| unreadable(&e))?;
    let Some(entries) = file.surfaces else {
        let is_rtf = ["polynomials", "poly"]
            .iter()
            .any(|name| file.rest.contains_key(*name));
        let message = match is_rtf {
            true => {
                "a ray transfer function, not surfaces: expected the file of the lens that it was made of"
            }
            false => "missing field `surfaces`",
        };
        return Err(PrescriptionError::Rows(vec![note(0, message.to_string())]));
    };
    let mut notes = Notes {
        warnings: not_read(&file.rest, &entries),
        ..Notes::default()
    };
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
    for (i, entry) in entries.iter().enumerate() {
        match entry.surface(medium) {
            Ok((surface, warning)) => {
                medium = surface.index;
                surfaces.push(surface);
                notes
                    .warnings
                    .extend(warning.map(|message| note(i + 1, message)));
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

/// Warnings of fields that are not read, each name once.
fn not_read(file: &Rest, surfaces: &[SurfaceEntry]) -> Vec<RowNote> {
    let unknown = |name: &str, known: &[&'static str]| {
        let meant = suggest::nearest(name, known.iter().copied());
        let meant = meant.map_or(String::new(), |meant| format!("; did you mean `{meant}`?"));
        format!("unknown field `{name:.40}` is not read{meant}")
    };
    let mut warnings = Vec::new();
    for (name, value) in file {
        let nothing = match value {
            Value::Null => true,
            Value::Array(list) => list.is_empty(),
            Value::Object(fields) => fields.is_empty(),
            _ => false,
        };
        match name.as_str() {
            "microlens" if nothing => {}
            "microlens" => warnings.push(note(0, "the microlens array is left out".to_string())),
            remark if FILE_REMARKS.contains(&remark) => {}
            name => warnings.push(note(0, unknown(name, &FILE_FIELDS))),
        }
    }
    let mut places = BTreeMap::<&str, Vec<usize>>::new();
    for (i, surface) in surfaces.iter().enumerate() {
        for name in surface.rest.keys().map(String::as_str) {
            if !SURFACE_REMARKS.contains(&name) {
                places.entry(name).or_default().push(i + 1);
            }
        }
    }
    for (name, rows) in places {
        let others = match rows.len() {
            1 => String::new(),
            n => format!(" (in {n} surfaces)"),
        };
        let message = unknown(name, &SURFACE_FIELDS) + &others;
        warnings.extend(rows.first().map(|row| note(*row, message)));
    }
    warnings
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
    /// As the tracer wants it, behind a space of index `before`; and what is odd about it.
    fn surface(&self, before: f64) -> Result<(Surface, Option<String>), String> {
        if !self.transform.is_empty() && !self.transform.is_identity() {
            return Err(
                "a transform that is not the identity: tilts and decenters cannot be traced".into(),
            );
        }
        let radius = self.radius.number("the radius")?;
        let semi_aperture = self.semi_aperture.number("semi_aperture")?;
        let asphere = self.asphere()?;
        let plane = radius == 0.0;
        let medium = Medium::read(&self.ior)?;
        let bare = plane && asphere.is_none() && (medium.index == 0.0 || medium.index == before);
        let is_stop = self.stop.unwrap_or(bare);
        let index = match medium.index {
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
        let surface = Surface {
            radius: if plane { f64::INFINITY } else { radius },
            thickness: self.thickness,
            index,
            abbe: self.abbe.or(medium.abbe).filter(|v| *v > 0.0),
            dispersion: self.dispersion.as_ref().map(Formula::read).transpose()?,
            glass: glass.transpose()?,
            aperture: 2.0 * semi_aperture,
            is_stop,
            asphere,
            coating: self.coating.as_deref().map(str::parse).transpose()?,
        };
        let silent = surface.abbe.is_none() && surface.dispersion.is_none();
        Ok((surface, medium.warning.filter(|_| silent)))
    }

    fn asphere(&self) -> Result<Option<Asphere>, String> {
        let conic = match self.conic_constant.is_empty() {
            true => 0.0,
            false => self.conic_constant.number("the conic constant")?,
        };
        let (own, iset) = (&self.aspheric_terms, &self.aspheric_coefficients);
        let (given, first, message) = match (own.is_empty(), iset.is_empty()) {
            (true, true) if conic == 0.0 => return Ok(None),
            (false, false) => {
                return Err("both aspheric_terms (of r², r⁴, …) and aspheric_coefficients (of r⁴, r⁶, …); expected one of them".into());
            }
            (_, true) => (own, 0, "more than 8 aspheric_terms, those of r² to r¹⁶"),
            (true, false) => (
                iset,
                1,
                "more than 7 aspheric_coefficients, those of r⁴ to r¹⁶",
            ),
        };
        let given = given
            .list()
            .ok_or("the aspheric terms: expected a list of numbers")?;
        let mut asphere = Asphere {
            conic,
            ..Asphere::default()
        };
        asphere
            .terms
            .get_mut(first..first + given.len())
            .ok_or(message)?
            .copy_from_slice(&given);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A lens of two surfaces: more fields of the file, and of the first surface.
    fn read(file: &str, first: &str) -> Result<Prescription, String> {
        let text = format!(
            r#"{{"name": "l", "description": "d", "type": "t", "metadata": {{}} {file}, "surfaces": [
            {{"radius": 50, "thickness": 5, "semi_aperture": 10 {first}}},
            {{"radius": -50, "thickness": 3, "ior": 1, "semi_aperture": 10, "conic_constant": [], "transform": []}}]}}"#
        );
        parse(&text).map_err(|e| e.to_string())
    }

    fn warnings(file: &str, first: &str) -> Vec<String> {
        let lens = read(file, first).expect(first);
        lens.warnings.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn fields_that_are_not_read_are_told() {
        let ior = r#", "ior": 1.5"#;
        assert!(warnings(r#", "microlens": []"#, ior).is_empty());
        for (file, first, expected) in [
            (
                "",
                r#", "semi_apertur": 3"#,
                "(row 1): unknown field `semi_apertur` is not read; did you mean `semi_aperture`?",
            ),
            (
                r#", "unit": "m""#,
                "",
                "unknown field `unit` is not read; did you mean `units`?",
            ),
            (
                r#", "microlens": {"dimensions": [8, 8]}"#,
                "",
                "the microlens array is left out",
            ),
        ] {
            let told = warnings(file, &(ior.to_owned() + first));
            assert!(told.len() == 1 && told[0].contains(expected), "{told:?}");
        }
    }

    #[test]
    fn isets_aspheric_coefficients_start_at_the_fourth_power() {
        let asphere = |more: &str| {
            read("", &format!(r#", "ior": 1.5 {more}"#)).map(|lens| lens.surfaces[0].asphere)
        };
        let terms = asphere(r#", "aspheric_terms": [0, 1e-4, 2e-6]"#);
        assert!(
            terms
                .as_ref()
                .is_ok_and(|a| a.is_some_and(|a| a.terms[1] == 1e-4))
        );
        assert_eq!(asphere(r#", "aspheric_coefficients": [1e-4, 2e-6]"#), terms);
        // MATLAB's list of one.
        let one = asphere(r#", "aspheric_coefficients": 1e-4"#);
        assert!(one.is_ok_and(|a| a.is_some_and(|a| a.terms[1] == 1e-4)));
        assert_eq!(
            asphere(r#", "aspheric_coefficients": [], "aspheric_terms": null"#),
            Ok(None)
        );
        for (more, expected) in [
            (
                r#", "aspheric_coefficients": [1], "aspheric_terms": [0, 1]"#,
                "expected one of them",
            ),
            (
                r#", "aspheric_coefficients": [0, 0, 0, 0, 0, 0, 0, 0]"#,
                "more than 7",
            ),
            (
                r#", "conic_constant": "x""#,
                "a number or a list of numbers",
            ),
            (
                r#", "conic_constant": [1, 2, 3]"#,
                "one for each of two meridians",
            ),
        ] {
            let error = asphere(more).expect_err(more);
            assert!(error.contains(expected), "{error}");
        }
        // Of null and the empty list as of 0.
        for conic in ["null", "[]", "0"] {
            assert_eq!(
                asphere(&format!(r#", "conic_constant": {conic}"#)),
                Ok(None)
            );
        }
    }

    #[test]
    fn a_surface_that_is_tilted_or_shifted_is_refused() {
        for unit in [
            "[[1,0,0],[0,1,0],[0,0,1],[0,0,0]]",
            "[[1,0,0,0],[0,1,0,0],[0,0,1,0]]",
            "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]",
            "null",
        ] {
            assert!(warnings("", &format!(r#", "ior": 1.5, "transform": {unit}"#)).is_empty());
        }
        for other in ["[[1,0,0],[0,0.9,0.2],[0,-0.2,0.9],[3,0,0]]", "[1,0,0]", "1"] {
            let error = read("", &format!(r#", "ior": 1.5, "transform": {other}"#)).unwrap_err();
            assert!(
                error.contains("(row 1)") && error.contains("tilts and decenters"),
                "{error}"
            );
        }
    }

    #[test]
    fn indices_at_several_wavelengths_tell_index_and_abbe_number() {
        // N-BK7 at 450, 550 and 700 nm: 1.5168 and 64.17 at the d line.
        let table = |ior: &str| {
            read("", &format!(r#", "ior": {ior}"#)).map(|lens| (lens.surfaces[0], lens.warnings))
        };
        let (surface, said) = table("[[450, 550, 700], [1.52532, 1.51852, 1.51306]]").unwrap();
        assert!(
            (surface.index - 1.5168).abs() < 2e-4 && said.is_empty(),
            "{}",
            surface.index
        );
        assert!(
            surface.abbe.is_some_and(|v| (v - 64.17).abs() < 2.0),
            "{:?}",
            surface.abbe
        );
        let (surface, said) = table("[[400, 700], [1.65, 1.65]]").unwrap();
        assert_eq!((surface.index, surface.abbe, said.len()), (1.65, None, 0));
        let (surface, said) = table("[[550, 600], [1.66, 1.65]]").unwrap();
        assert!(surface.abbe.is_none() && said[0].to_string().contains("tells no Abbe number"));
        for (ior, expected) in [
            (
                "[[600, 700], [1.66, 1.65]]",
                "from 600 to 700 nm tells no index at 587.6 nm",
            ),
            ("[[400, 700], [1.65]]", "found 1 and 2"),
            (
                "[1.66, 1.65]",
                "expected an index, or [[wavelengths in nm], [indices there]]",
            ),
            ("\"N-BK7\"", "a number or a list of numbers"),
        ] {
            let error = table(ior).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn a_ray_transfer_function_is_no_lens() {
        let error = parse(r#"{"name": "p", "polynomials": [{"poly": []}]}"#).unwrap_err();
        assert!(
            error
                .to_string()
                .contains("a ray transfer function, not surfaces")
        );
    }
}
