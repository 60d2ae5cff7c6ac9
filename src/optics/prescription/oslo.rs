//! OSLO's lens files (`.len`).
//!
//! Commands and values, one a line or several behind `;`; `//` starts a comment. `LEN NEW` begins the lens, `NXT` the next surface, the first being the
//! object and the last, before `END`, the film. Read are of the lens `UNI` (mm per unit), `EBR` (half the entrance pupil), `NAO`, `FNO`, `ANG`
//! (degrees), `OBH`, `GIH`, and the first wavelength of `WV`; of a surface `RD` or `CV`, `TH`, `AIR` or `GLA` (a name, or indices by wavelength, `MOD` in
//! front of a name and indices), `AP` (half the clear diameter; `CHK` that it blocks), `AST` (the stop, as wide as the beam
//! says), `CC` (conic constant) and `AD` … `AG` (of r⁴ … r¹⁰). What the
//! tracer cannot do is an error that names its surface.

use super::cells::lines;
use super::design::light::{Beam, Field, FieldKind};
use super::design::{Aperture, Design, DesignSurface, Medium, asphere_term, value};
use super::glass::{self, Glasses};
use super::{Prescription, PrescriptionError, RowNote};

/// Reads the text of a file, with the glasses that it may name.
pub fn parse(text: &str, glasses: &Glasses) -> Result<Prescription, PrescriptionError> {
    let mut reader = Reader::new(glasses);
    for (line, content) in lines(text) {
        let content = content.split("//").next().unwrap_or("");
        for command in content.split(';') {
            let words: Vec<&str> = command.split_whitespace().collect();
            let Some((keyword, words)) = words.split_first() else {
                continue;
            };
            if reader.ended {
                break;
            }
            if let Err(message) = reader.command(line, &keyword.to_ascii_uppercase(), words) {
                reader.design.notes.errors.push(RowNote {
                    line,
                    column: 1,
                    row: reader.surfaces.len().saturating_sub(1),
                    message,
                });
            }
        }
    }
    reader.finish()
}

/// Commands that take a surface off the axis, where a value is not 0.
const OFF_AXIS: [&str; 7] = ["DCX", "DCY", "DCZ", "TLA", "TLB", "TLC", "CVX"];
/// Commands of shapes that cannot be traced, with what they are.
const UNKNOWN_OPTICS: [(&str, &str); 8] = [
    ("RFL", "a mirror"),
    ("RFH", "a mirror"),
    ("PFL", "an ideal lens"),
    ("GSP", "a grating"),
    ("DOE", "a diffracting surface"),
    ("ASP", "an asphere of another kind than CC and AD to AG"),
    ("RDX", "a toroid"),
    ("GRD", "a medium of varying index"),
];
/// Objects as far as this are at infinity (OSLO Optics Reference, "Telecentric ray-aiming").
const FAR: f64 = 1e8;
/// The most fields or wavelengths that are read.
const MAX_NUMBERS: usize = 100;

struct Reader<'a> {
    design: Design,
    glasses: &'a Glasses,
    /// With object and film.
    surfaces: Vec<DesignSurface>,
    /// Indices by wavelength of the glass behind a surface, until wavelengths are known.
    indices: Vec<(usize, Vec<f64>)>,
    /// µm.
    wavelengths: Vec<f64>,
    ended: bool,
}

impl<'a> Reader<'a> {
    fn new(glasses: &'a Glasses) -> Reader<'a> {
        Reader {
            design: Design {
                unit: 1.0,
                ..Design::default()
            },
            glasses,
            surfaces: Vec::new(),
            indices: Vec::new(),
            wavelengths: Vec::new(),
            ended: false,
        }
    }

    fn begin(&mut self, line: usize) {
        self.surfaces.push(DesignSurface {
            line,
            row: self.surfaces.len(),
            ..DesignSurface::default()
        });
    }

    fn command(&mut self, line: usize, keyword: &str, words: &[&str]) -> Result<(), String> {
        let light = &mut self.design.light;
        match keyword {
            "LEN" => self.begin(line),
            "NXT" => self.begin(line),
            "END" => self.ended = true,
            "UNI" => {
                let unit = value(words, 0, "millimeters per unit")?;
                if !(1e-6..=1e6).contains(&unit) {
                    return Err(format!("a unit of {unit} mm"));
                }
                self.design.unit = unit;
            }
            "EBR" => light.beam = Beam::EntrancePupil(2.0 * value(words, 0, "a radius")?),
            "FNO" => light.beam = Beam::FNumber(value(words, 0, "an f-number")?),
            "NAO" => light.beam = Beam::ObjectAperture(value(words, 0, "an aperture")?),
            "ANG" | "OBH" | "GIH" => {
                light.kind = match keyword {
                    "ANG" => FieldKind::Angle,
                    "OBH" => FieldKind::ObjectHeight,
                    _ => FieldKind::ImageHeight,
                };
                let most = value(words, 0, "a field")?;
                // The file has the largest; what is widest may lie between.
                light.fields = [0.5, 0.7, 1.0].map(|part| Field::at(part * most)).to_vec();
            }
            "WV" => {
                let numbers = words.iter().map_while(|w| w.parse().ok());
                self.wavelengths = numbers.take(MAX_NUMBERS).collect();
            }
            _ => return self.of_surface(keyword, words),
        }
        Ok(())
    }

    fn of_surface(&mut self, keyword: &str, words: &[&str]) -> Result<(), String> {
        let Some(surface) = self.surfaces.last_mut() else {
            return Ok(());
        };
        let row = surface.row;
        match keyword {
            "RD" | "RDF" => surface.set_radius(value(words, 0, "a radius")?),
            "CV" | "CVF" => surface.curvature = value(words, 0, "a curvature")?,
            "TH" | "THF" => surface.thickness = value(words, 0, "a thickness")?,
            "AST" => surface.is_stop = true,
            "AIR" => surface.medium = Medium::default(),
            "AP" | "APF" => {
                let number = words.iter().position(|w| w.parse::<f64>().is_ok());
                let radius = value(words, number.unwrap_or(0), "half a clear diameter")?;
                surface.semi_diameter = radius;
                if words[0].eq_ignore_ascii_case("CHK") && radius > 0.0 {
                    surface.aperture = Aperture::Radius(radius);
                }
            }
            "CC" => surface.asphere.conic = value(words, 0, "a conic constant")?,
            "AD" | "AE" | "AF" | "AG" => {
                let power = 4 + 2 * "DEFG".find(&keyword[1..]).unwrap_or(0);
                asphere_term(surface, power, value(words, 0, "a coefficient")?)?;
            }
            "GLA" | "GLF" => self.glass(words)?,
            "APN" if words.first().is_some_and(|count| *count != "0") => {
                return Err(format!(
                    "surface {row}: special apertures (APN) cannot be traced"
                ));
            }
            "PK" => {
                return Err(format!(
                    "surface {row}: pickups cannot be read; let OSLO write numbers"
                ));
            }
            _ if OFF_AXIS.contains(&keyword) => {
                if value(words, 0, "a tilt or decenter")? != 0.0 {
                    return Err(format!(
                        "surface {row} is tilted, decentered or toric ({keyword})"
                    ));
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

    /// `GLA name`, `GLA index …`, `GLA MOD name index …`.
    fn glass(&mut self, words: &[&str]) -> Result<(), String> {
        let place = self.surfaces.len() - 1;
        let surface = &mut self.surfaces[place];
        let words = match words {
            [kind, _, rest @ ..] if kind.eq_ignore_ascii_case("MOD") => rest,
            words => words,
        };
        let first = words.first().copied().unwrap_or("");
        if first.parse::<f64>().is_ok_and(|n| n < 10.0) {
            let indices = words.iter().map_while(|w| w.parse().ok()).take(MAX_NUMBERS);
            self.indices.push((place, indices.collect()));
            // Told apart from air until the wavelengths are known.
            surface.medium = Medium::model("", value(words, 0, "an index")?, 0.0)?;
            return Ok(());
        }
        let row = surface.row;
        surface.medium =
            Medium::named(first, self.glasses).map_err(|e| format!("surface {row}: {e}"))?;
        Ok(())
    }

    fn finish(mut self) -> Result<Prescription, PrescriptionError> {
        if self.design.notes.errors.is_empty() && self.surfaces.len() < 3 {
            return Err(PrescriptionError::Empty);
        }
        for (place, indices) in std::mem::take(&mut self.indices) {
            let samples: Vec<[f64; 2]> = self
                .wavelengths
                .iter()
                .zip(&indices)
                .map(|(w, n)| [*w, *n])
                .collect();
            if let Some(glass) = glass::of_samples(&samples) {
                self.surfaces[place].medium.glass = glass;
            }
        }
        self.design.wavelength = self.wavelengths.first().map(|w| (1, *w));
        let film = self.surfaces.pop();
        self.design.film_curvature = film.map_or(0.0, |film| film.curvature);
        if !self.surfaces.is_empty() {
            let object = self.surfaces.remove(0);
            let distance = object.thickness;
            self.design.object_medium = object.medium;
            let far = distance.abs() >= FAR;
            self.design.light.object_distance = if far { f64::INFINITY } else { distance };
        }
        // The beam says how wide the stop is; an aperture there that is not checked is for drawing.
        let drawn = |s: &&mut DesignSurface| s.is_stop && s.aperture == Aperture::Edge;
        if self.design.light.beam != Beam::Stop {
            self.surfaces
                .iter_mut()
                .filter(drawn)
                .for_each(|s| s.semi_diameter = 0.0);
        }
        self.design.surfaces = self.surfaces;
        self.design.prescription()
    }
}
