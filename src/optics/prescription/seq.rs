//! CODE V's sequential files (`.seq`).
//!
//! Commands of up to three letters and values, several in a line behind `;`, a line continuing behind `&`; `!` starts a
//! comment. `SO`, `S` and `SI` begin object, surfaces and film: radius (`RDM`) or curvature (without it, or `RDM N`), thickness, glass, also as commands of their own
//! (`RDY`, `CUY`, `THI`, `GLA`). Read are the
//! units (`DIM M`, `C`, `I`), the beam (`EPD`, `FNO`, `NA`, `NAO`), fields (`XAN`/`YAN`, `XOB`/`YOB`, `XIM`/`YIM`, `XRI`/`YRI`) with vignetting
//! (`VUY`, `VLY`), wavelengths in nm (`WL`, `REF`), private glasses (`PRV` … `END`), the stop (`STO`), clear apertures (`CIR`), and of
//! aspheres the conic constant `K` and the coefficients `A` of r⁴ to `G` of r¹⁶; each may name its surface (`STO S5`). Glasses are names
//! (`NBK7_SCHOTT`), codes (`517.642`, `517642`) or `n:V`. What the tracer cannot do is an error that names its surface.
//!
//! Files of optiland, which say so in their first line, have `A` for r², `B` for r⁴ and so on, and are read that way.

use super::cells::lines;
use super::design::light::{Beam, Field, FieldKind};
use super::design::{Aperture, Design, DesignSurface, Medium, asphere_term, value};
use super::glass::{self, Glasses};
use super::{Prescription, PrescriptionError, RowNote};
use crate::optics::dispersion::LINE_D;
use std::collections::HashMap;

/// Reads the text of a file, with the glasses that it may name.
pub fn parse(text: &str, glasses: &Glasses) -> Result<Prescription, PrescriptionError> {
    let mut reader = Reader::new(text, glasses);
    for (line, command) in commands(text) {
        let words = words(&command);
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let Some((keyword, words)) = words.split_first() else {
            continue;
        };
        if let Err(message) = reader.command(line, &keyword.to_ascii_uppercase(), words) {
            reader.error(line, message);
        }
    }
    reader.finish()
}

/// The commands with the lines that they begin in.
fn commands(text: &str) -> Vec<(usize, String)> {
    let mut found: Vec<(usize, String)> = Vec::new();
    let mut goes_on = false;
    for (number, line) in lines(text) {
        let mut line = before_comment(line).trim();
        let continued = line.ends_with('&');
        line = line.trim_end_matches('&');
        for (i, part) in split_outside_quotes(line, ';').into_iter().enumerate() {
            match found.last_mut() {
                Some((_, last)) if i == 0 && goes_on => {
                    last.push(' ');
                    last.push_str(part);
                }
                _ => found.push((number, part.to_string())),
            }
        }
        goes_on = continued;
    }
    found
}

/// The line up to a `!` that is not in quotes.
fn before_comment(line: &str) -> &str {
    split_outside_quotes(line, '!')
        .first()
        .copied()
        .unwrap_or("")
}

/// Parts of a line between characters `at` that stand outside of quotes.
fn split_outside_quotes(line: &str, at: char) -> Vec<&str> {
    let mut quote = None;
    let outside = |c: char| match quote {
        Some(q) => {
            if c == q {
                quote = None;
            }
            false
        }
        None => {
            if c == '"' || c == '\'' {
                quote = Some(c);
            }
            c == at
        }
    };
    line.split(outside).collect()
}

/// The words of a command, those in quotes without them.
fn words(command: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), String::new(), None);
    for c in command.chars() {
        match (quote, c) {
            (Some(q), _) if c == q => quote = None,
            (None, '"' | '\'') => quote = Some(c),
            (None, _) if c.is_whitespace() => {
                if !word.is_empty() {
                    words.push(std::mem::take(&mut word));
                }
            }
            _ => word.push(c),
        }
    }
    if !word.is_empty() {
        words.push(word);
    }
    words
}

/// Commands of a surface that take it off the axis, where a value is not 0.
const OFF_AXIS: [&str; 6] = ["XDE", "YDE", "ZDE", "ADE", "BDE", "CDE"];
/// Commands of shapes and apertures that cannot be traced, with what they are.
const UNKNOWN_OPTICS: [(&str, &str); 15] = [
    ("CYL", "a cylinder"),
    ("XTO", "a toroid"),
    ("YTO", "a toroid"),
    ("AAS", "an anamorphic asphere"),
    ("SPS", "a special surface"),
    ("UDS", "a surface defined by a program"),
    ("DIF", "a diffracting surface"),
    ("GRT", "a grating"),
    ("HOE", "a hologram"),
    ("REX", "a rectangular aperture"),
    ("REY", "a rectangular aperture"),
    ("ELX", "an elliptical aperture"),
    ("ELY", "an elliptical aperture"),
    ("MFL", "an ideal lens"),
    ("MOD", "an ideal lens"),
];
/// The most fields or wavelengths that are read.
const MAX_NUMBERS: usize = 100;

/// What a command is of.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Target {
    Object,
    /// Between object and film, from 0.
    Surface(usize),
    Film,
}

struct Reader<'a> {
    design: Design,
    glasses: &'a Glasses,
    /// Of private glasses, by name.
    private: HashMap<String, glass::Glass>,
    /// Within `PRV`: its wavelengths, µm.
    in_private: Option<Vec<f64>>,
    curvatures: bool,
    /// The power of r that `A` is the coefficient of.
    first_power: usize,
    film: Option<DesignSurface>,
    started: bool,
    wavelengths: Vec<f64>,
    /// The number of the one that the lens is made for; without it the middle one.
    reference: Option<usize>,
    fields: [Vec<f64>; 2],
    vignetting: [Vec<f64>; 2],
}

impl<'a> Reader<'a> {
    fn new(text: &str, glasses: &'a Glasses) -> Reader<'a> {
        let first = text.lines().next().unwrap_or("");
        let of_optiland = first.starts_with('!') && first.contains("Optiland");
        Reader {
            design: Design {
                unit: 1.0,
                ..Design::default()
            },
            glasses,
            private: HashMap::new(),
            in_private: None,
            curvatures: true,
            first_power: if of_optiland { 2 } else { 4 },
            film: None,
            started: false,
            wavelengths: Vec::new(),
            reference: None,
            fields: [Vec::new(), Vec::new()],
            vignetting: [Vec::new(), Vec::new()],
        }
    }

    fn error(&mut self, line: usize, message: String) {
        // The object is row 0.
        let row = self.design.surfaces.len();
        self.design.notes.errors.push(RowNote {
            line,
            column: 1,
            row,
            message,
        });
    }

    fn command(&mut self, line: usize, keyword: &str, words: &[&str]) -> Result<(), String> {
        if self.in_private.is_some() {
            return self.private_glass(keyword, words);
        }
        let numbers = || {
            let numbers = words.iter().map_while(|w| w.parse::<f64>().ok());
            let numbers = numbers.filter(|x| x.is_finite()).take(MAX_NUMBERS);
            numbers.collect::<Vec<f64>>()
        };
        let is_number = |i: usize| words.get(i).is_some_and(|w| w.parse::<f64>().is_ok());
        let numbered = |name: &str| {
            let digits = name.strip_prefix('S').unwrap_or("x");
            digits.bytes().all(|b| b.is_ascii_digit())
        };
        match keyword {
            "S0" => self.begin(line, "SO", words)?,
            "SO" | "SI" => self.begin(line, keyword, words)?,
            "SCA" | "DEL" | "INS" | "COP" | "FLY" => {
                return Err(format!(
                    "{keyword} changes the lens that was described before: let CODE V save it as it is then"
                ));
            }
            // `S` alone, or the number of a surface, in front of a radius and a thickness.
            name if name == "S" || (numbered(name) && is_number(0)) => {
                self.begin(line, "S", words)?;
            }
            "RDM" => self.curvatures = words.first().is_some_and(|w| w.eq_ignore_ascii_case("N")),
            "DIM" => {
                self.design.unit = match words.first().map(|w| w.to_ascii_uppercase()).as_deref() {
                    Some("M" | "MM") | None => 1.0,
                    Some("C" | "CM") => 10.0,
                    Some("I" | "IN") => 25.4,
                    Some(other) => return Err(format!("unit {other:.20}; expected M, C or I")),
                }
            }
            "EPD" => self.design.light.beam = Beam::EntrancePupil(value(words, 0, "a diameter")?),
            "FNO" => self.design.light.beam = Beam::FNumber(value(words, 0, "an f-number")?),
            "NAO" => {
                self.design.light.beam = Beam::ObjectAperture(value(words, 0, "an aperture")?);
            }
            "NA" => {
                self.design.light.beam = Beam::FNumber(0.5 / value(words, 0, "an aperture")?);
            }
            "WL" => self.wavelengths = numbers(),
            "REF" => self.reference = Some(value(words, 0, "the number of a wavelength")? as usize),
            "VUY" => self.vignetting[1] = numbers(),
            "VLY" => self.vignetting[0] = numbers(),
            "PRV" => self.in_private = Some(Vec::new()),
            _ => {
                let kind = match keyword.get(1..) {
                    Some("AN") => FieldKind::Angle,
                    Some("OB") => FieldKind::ObjectHeight,
                    Some("IM" | "RI") => FieldKind::ImageHeight,
                    _ => return self.of_surface(keyword, words),
                };
                let axis = usize::from(keyword.starts_with('Y'));
                if keyword.starts_with(['X', 'Y']) {
                    (self.design.light.kind, self.fields[axis]) = (kind, numbers());
                }
            }
        }
        Ok(())
    }

    /// `S radius thickness glass`.
    fn begin(&mut self, line: usize, keyword: &str, words: &[&str]) -> Result<(), String> {
        let mut surface = DesignSurface {
            line,
            row: self.design.surfaces.len() + 1,
            ..DesignSurface::default()
        };
        let shape = match words.first() {
            None => 0.0,
            Some(_) if keyword == "SO" => value(words, 0, "").unwrap_or(0.0),
            Some(_) => value(words, 0, "a radius or curvature")?,
        };
        match self.curvatures {
            true => surface.curvature = shape,
            false => surface.set_radius(shape),
        }
        match (keyword, words.get(1)) {
            ("SO", thickness) => {
                let far = thickness
                    .and_then(|t| t.parse().ok())
                    .unwrap_or(f64::INFINITY);
                self.design.light.object_distance = far;
                self.started = true;
                if let Some(name) = words.get(2) {
                    let medium = self.medium(name);
                    self.design.object_medium = medium.map_err(|e| format!("the object: {e}"))?;
                }
                return Ok(());
            }
            (_, None) => {}
            _ => surface.thickness = value(words, 1, "a thickness")?,
        }
        if let Some(name) = words.get(2) {
            let medium = self.medium(name);
            // Its messages belong to this surface.
            surface.medium = medium.map_err(|e| format!("surface {}: {e}", surface.row))?;
        }
        match keyword {
            "SI" => self.film = Some(surface),
            _ => self.design.surfaces.push(surface),
        }
        Ok(())
    }

    fn medium(&self, name: &str) -> Result<Medium, String> {
        if let Some(glass) = self.private.get(&name.to_ascii_uppercase()) {
            return Ok(Medium {
                name: name.to_string(),
                glass: *glass,
            });
        }
        if let Some((n, v)) = name.split_once(':')
            && let (Ok(n), Ok(v)) = (n.parse(), v.parse())
        {
            return Medium::model("", n, v);
        }
        // Catalogues have hyphens that CODE V leaves out, and their own name behind it.
        let name = name.to_ascii_uppercase();
        let plain = name.split('_').next().unwrap_or(&name);
        let hyphened = |prefix: &str| {
            let rest = plain.strip_prefix(prefix)?;
            self.glasses.named(&format!("{prefix}-{rest}"))?;
            Some(format!("{prefix}-{rest}"))
        };
        let known = self.glasses.named(plain).map(|_| plain.to_string());
        let prefixes = ["N", "P", "S", "H", "J", "E", "K", "D", "L"];
        let known = known.or_else(|| prefixes.into_iter().find_map(hyphened));
        Medium::named(&known.unwrap_or(plain.to_string()), self.glasses)
    }

    /// Lines between `PRV` and `END`: wavelengths, then glasses with their indices.
    fn private_glass(&mut self, keyword: &str, words: &[&str]) -> Result<(), String> {
        let numbers = words.iter().map_while(|w| w.parse::<f64>().ok());
        let numbers: Vec<f64> = numbers.take(MAX_NUMBERS).collect();
        match keyword {
            "END" => self.in_private = None,
            "PWL" => self.in_private = Some(numbers.iter().map(|nm| nm * 1e-3).collect()),
            name => {
                let wavelengths = self.in_private.iter().flatten().copied();
                let samples: Vec<[f64; 2]> =
                    wavelengths.zip(numbers).map(|(w, n)| [w, n]).collect();
                if let Some(glass) = glass::of_samples(&samples)
                    && self.private.len() < 10 * MAX_NUMBERS
                {
                    self.private.insert(name.to_string(), glass);
                }
            }
        }
        Ok(())
    }

    /// A command of the surface at hand, or of one that it names.
    fn of_surface(&mut self, keyword: &str, words: &[&str]) -> Result<(), String> {
        let (target, words) = self.target(words);
        let surface = match target {
            None => return Ok(()),
            Some(Target::Object) => return self.of_object(keyword, words),
            Some(Target::Film) => self.film.as_mut(),
            Some(Target::Surface(i)) => self.design.surfaces.get_mut(i),
        };
        let Some(surface) = surface else {
            return Ok(());
        };
        match keyword {
            "THI" => surface.thickness = value(words, 0, "a thickness")?,
            "RDY" => surface.set_radius(value(words, 0, "a radius")?),
            "CUY" => surface.curvature = value(words, 0, "a curvature")?,
            // Of the film nothing else is known.
            _ if target == Some(Target::Film) => {}
            "GLA" => {
                let row = surface.row;
                let medium = self.medium(words.first().copied().unwrap_or_default());
                let medium = medium.map_err(|e| format!("surface {row}: {e}"))?;
                if let Some(surface) = self.design.surfaces.get_mut(row - 1) {
                    surface.medium = medium;
                }
            }
            _ => return changed(surface, self.first_power, keyword, words),
        }
        Ok(())
    }

    /// A command of the object.
    fn of_object(&mut self, keyword: &str, words: &[&str]) -> Result<(), String> {
        match keyword {
            "THI" => self.design.light.object_distance = value(words, 0, "a distance")?,
            "GLA" => {
                let medium = self.medium(words.first().copied().unwrap_or_default());
                self.design.object_medium = medium.map_err(|e| format!("the object: {e}"))?;
            }
            _ => {}
        }
        Ok(())
    }

    /// What a command is of, which it may name first, and its other words; else of what was begun last.
    fn target<'w, 'b>(&self, words: &'b [&'w str]) -> (Option<Target>, &'b [&'w str]) {
        let count = self.design.surfaces.len();
        let name = words.first().map(|word| word.to_ascii_uppercase());
        let named = match name.as_deref() {
            Some("SO" | "S0") => Some(Target::Object),
            Some("SI") => Some(Target::Film),
            name => name.and_then(|name| {
                let number = name.strip_prefix('S')?.parse::<usize>().ok()?;
                Some(Target::Surface(number.checked_sub(1)?))
            }),
        };
        match named {
            Some(_) => (named, &words[1..]),
            None if self.film.is_some() => (Some(Target::Film), words),
            None => {
                let last = count.checked_sub(1).map(Target::Surface);
                let object = self.started.then_some(Target::Object);
                (last.or(object), words)
            }
        }
    }

    fn finish(mut self) -> Result<Prescription, PrescriptionError> {
        if !self.started && self.design.notes.errors.is_empty() {
            return Err(PrescriptionError::Empty);
        }
        if let (Some(film), Some(last)) = (&self.film, self.design.surfaces.last_mut()) {
            // What stands there is the defocus.
            last.thickness += film.thickness;
            self.design.film_curvature = film.curvature;
        }
        let reference = self.reference.unwrap_or(self.wavelengths.len().div_ceil(2));
        let wavelength = self.wavelengths.get(reference.saturating_sub(1));
        self.design.wavelength = Some((1, wavelength.map_or(LINE_D, |nm| nm * 1e-3)));
        let count = self.fields.iter().map(Vec::len).max().unwrap_or(0);
        let at = |values: &[f64], i: usize| values.get(i).copied().unwrap_or(0.0);
        let field = |i: usize| {
            let [x, y] = [0, 1].map(|axis| at(&self.fields[axis], i));
            Field {
                height: x.hypot(y).copysign(y),
                through: [
                    at(&self.vignetting[0], i) - 1.0,
                    1.0 - at(&self.vignetting[1], i),
                ],
            }
        };
        self.design.light.fields = (0..count).map(field).collect();
        if self.first_power == 2
            && self
                .design
                .surfaces
                .iter()
                .any(|s| s.asphere.terms != [0.0; 8])
        {
            let first = &self.design.surfaces[0];
            let note = first.note("written by optiland, whose coefficients A, B, … are of r², r⁴, … and not CODE V's of r⁴, r⁶, …");
            self.design.notes.warnings.push(note);
        }
        self.design.prescription()
    }
}

/// A command that changes a surface; `A` is the coefficient of r to the power `first_power`.
fn changed(
    surface: &mut DesignSurface,
    first_power: usize,
    keyword: &str,
    words: &[&str],
) -> Result<(), String> {
    let row = surface.row;
    let first = words
        .first()
        .map(|w| w.to_ascii_uppercase())
        .unwrap_or_default();
    match keyword {
        "STO" => surface.is_stop = true,
        "K" => surface.asphere.conic = value(words, 0, "a conic constant")?,
        "CIR" if matches!(first.as_str(), "OBS" | "HOL") => {
            return Err(format!(
                "surface {row}: obscurations and holes cannot be traced"
            ));
        }
        // That of the glass, not of the light.
        "CIR" if first == "EDG" => {}
        "CIR" => {
            let radius = words
                .iter()
                .position(|w| w.parse::<f64>().is_ok())
                .unwrap_or(0);
            let radius = value(words, radius, "half a clear diameter")?;
            surface.aperture = Aperture::Radius(radius);
        }
        "A" | "B" | "C" | "D" | "E" | "F" | "G" | "H" | "J" => {
            let letter = "ABCDEFGHJ".find(keyword).unwrap_or(0);
            let power = first_power + 2 * letter;
            asphere_term(surface, power, value(words, 0, "a coefficient")?)?;
        }
        _ if OFF_AXIS.contains(&keyword) => {
            if value(words, 0, "a tilt or decenter")? != 0.0 {
                return Err(format!("surface {row} is tilted or decentered ({keyword})"));
            }
        }
        _ => {
            if let Some((_, what)) = UNKNOWN_OPTICS.iter().find(|(k, _)| *k == keyword) {
                return Err(format!(
                    "surface {row}: {what} ({keyword}) cannot be traced"
                ));
            }
        }
    }
    Ok(())
}
