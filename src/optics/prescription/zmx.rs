//! Zemax' sequential lens files (`.zmx`).
//!
//! Lines of a keyword and values; `SURF n` begins surface n. What is read of a surface: `TYPE` (STANDARD and EVENASPH),
//! `CURV` curvature, `CONI` conic constant, `PARM i` coefficient of r^2i, `DISZ` distance to the next, `GLAS` medium behind, `DIAM` half
//! the clear diameter (`CLAP` goes before it), `STOP`; of the whole: `MODE`, `UNIT`, and the primary wavelength of `WAVM` or
//! `WAVL` by `PWAV`, which indices are those of. The first surface is the object, the last one the film. What
//! the tracer cannot do (mirrors, tilts, other types) is an error that names its line; what changes no ray on its way is
//! passed over. Surfaces between equal media that are not the stop are auxiliary planes of the design and left out, but
//! for baffles and field stops: those with an aperture of their own (`CLAP`, `FLAP`). As in Zemax the semi-diameter of
//! a surface without power blocks nothing.
//!
//! ```
//! use fstop::optics::prescription::zmx;
//! let lens = zmx::parse(
//!     "MODE SEQ\nUNIT MM\nSURF 0\n DISZ INFINITY\nSURF 1\n STOP\n CURV 0.02\n DISZ 5\n GLAS N-BK7\n DIAM 10\n\
//!      SURF 2\n CURV 0\n DISZ 95\n DIAM 10\nSURF 3\n",
//! )?;
//! assert_eq!(lens.surfaces.len(), 2);
//! assert_eq!(lens.film_distance, 95.0);
//! # Ok::<(), fstop::optics::PrescriptionError>(())
//! ```

use super::cells::lines;
use super::glass::{self, Glass};
use super::{Prescription, PrescriptionError, RowNote};
use crate::optics::asphere::{Asphere, TERMS};
use crate::optics::dispersion::LINE_D;
use crate::optics::surface::Surface;

/// The file's text: Zemax writes UTF-16 with a byte order mark, other programs one byte per character.
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
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8_lossy(rest).into_owned(),
        _ => String::from_utf8_lossy(bytes).into_owned(),
    }
}

/// Reads the text of a file.
pub fn parse(text: &str) -> Result<Prescription, PrescriptionError> {
    let mut reader = Reader::new();
    for (line, content) in lines(text) {
        reader.line(line, content);
    }
    reader.finish()
}

/// One surface as the file has it.
#[derive(Clone, Debug)]
struct Block {
    /// Where it begins.
    line: usize,
    /// Its number, the object's being 0.
    row: usize,
    curvature: f64,
    /// Is it an even asphere, whose `PARM` are coefficients?
    even: bool,
    asphere: Asphere,
    thickness: f64,
    medium: Medium,
    semi_diameter: f64,
    /// Was that given by hand, not by the rays of the design?
    fixed_diameter: bool,
    aperture: Aperture,
    is_stop: bool,
}

/// What is behind a surface.
#[derive(Clone, Debug, PartialEq)]
struct Medium {
    name: String,
    glass: Glass,
}

/// The circle that a surface stops rays outside of.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Aperture {
    /// None but the surface's own edge.
    Edge,
    /// Of this radius.
    Radius(f64),
    /// Of half the clear diameter, whatever that is.
    Floating,
}

impl Block {
    fn new(line: usize, row: usize) -> Block {
        Block {
            line,
            row,
            curvature: 0.0,
            even: false,
            asphere: Asphere::default(),
            thickness: 0.0,
            medium: Medium {
                name: String::new(),
                glass: glass::AIR,
            },
            semi_diameter: 0.0,
            fixed_diameter: false,
            aperture: Aperture::Edge,
            is_stop: false,
        }
    }

    fn note(&self, message: String) -> RowNote {
        RowNote {
            line: self.line,
            column: 1,
            row: self.row,
            message,
        }
    }

    /// Distance from the axis at which it stops rays.
    fn rim(&self) -> f64 {
        match self.aperture {
            Aperture::Radius(radius) => radius,
            Aperture::Edge | Aperture::Floating => self.semi_diameter,
        }
    }

    /// Its shape departs from a sphere.
    fn asphere(&self) -> Option<Asphere> {
        let mut a = self.asphere;
        if !self.even {
            a.terms = [0.0; TERMS];
        }
        // A plane has no conic.
        if self.curvature == 0.0 {
            a.conic = 0.0;
        }
        (a != Asphere::default()).then_some(a)
    }
}

/// Collects surfaces and what is wrong.
struct Reader {
    blocks: Vec<Block>,
    /// Millimeters per unit of the file.
    unit: f64,
    /// By number from 1, µm; with the line of each.
    wavelengths: Vec<(usize, f64)>,
    /// The number of the one that the lens is made for.
    primary: usize,
    warnings: Vec<RowNote>,
    errors: Vec<RowNote>,
}

/// Keywords of a surface that stop rays in ways the tracer does not know, with what they are.
const UNKNOWN_OPTICS: [(&str, &str); 7] = [
    ("OBDC", "decentered apertures"),
    ("OBSC", "central obscurations"),
    ("SQAP", "rectangular apertures"),
    ("SQOB", "rectangular obscurations"),
    ("ELAP", "elliptical apertures"),
    ("ELOB", "elliptical obscurations"),
    ("SPID", "spiders"),
];

impl Reader {
    fn new() -> Reader {
        Reader {
            blocks: Vec::new(),
            unit: 1.0,
            wavelengths: Vec::new(),
            primary: 1,
            warnings: Vec::new(),
            errors: Vec::new(),
        }
    }

    /// Something wrong with a line of the surface being read.
    fn error(&mut self, line: usize, column: usize, message: String) {
        self.errors.push(RowNote {
            line,
            column,
            // Surfaces count from the object, 0.
            row: self.blocks.len().saturating_sub(1),
            message,
        });
    }

    fn line(&mut self, line: usize, content: &str) {
        let mut words = content.split_whitespace();
        let Some(keyword) = words.next() else { return };
        let words: Vec<&str> = words.collect();
        let column = content.len() - content.trim_start().len() + 1;
        match keyword {
            "SURF" => self.blocks.push(Block::new(line, self.blocks.len())),
            "WAVM" | "WAVL" | "PWAV" if self.blocks.is_empty() => {
                if let Err(message) = self.wavelength(line, keyword, &words) {
                    self.error(line, column, message);
                }
            }
            "MODE" if words.first().is_some_and(|m| *m != "SEQ") => {
                let message = format!("mode {}; only sequential files (SEQ) can be read", words[0]);
                self.error(line, column, message);
            }
            "UNIT" => match words.first().copied() {
                Some("MM") | None => {}
                Some("CM") => self.unit = 10.0,
                Some("IN") => self.unit = 25.4,
                Some("METER") => self.unit = 1000.0,
                Some(other) => {
                    self.error(
                        line,
                        column,
                        format!("unit {other}; expected MM, CM, IN or METER"),
                    );
                }
            },
            _ => {
                if let Some((_, what)) = UNKNOWN_OPTICS.iter().find(|(k, _)| *k == keyword)
                    && self.blocks.len() > 1
                {
                    self.error(line, column, format!("{keyword}: {what} cannot be traced"));
                } else if let Err(message) = self.property(keyword, &words) {
                    self.error(line, column, message);
                }
            }
        }
    }

    /// `WAVM number µm weight`, `WAVL µm µm …`, `PWAV number`.
    fn wavelength(&mut self, line: usize, keyword: &str, words: &[&str]) -> Result<(), String> {
        let whole = |x: f64| (1.0..=99.0).contains(&x).then_some(x as usize);
        match keyword {
            "PWAV" => {
                let primary = number(words, 0, "the number of the primary wavelength")?;
                self.primary = whole(primary).unwrap_or(1);
            }
            "WAVM" => {
                let i = number(words, 0, "the number of a wavelength")?;
                let wavelength = number(words, 1, "a wavelength in µm")?;
                let Some(i) = whole(i) else { return Ok(()) };
                if self.wavelengths.len() < i {
                    self.wavelengths.resize(i, (line, LINE_D));
                }
                self.wavelengths[i - 1] = (line, wavelength);
            }
            _ => {
                let all = (0..words.len()).map(|i| number(words, i, "a wavelength in µm"));
                let all = all.map(|w| Ok::<_, String>((line, w?)));
                self.wavelengths = all.collect::<Result<_, _>>()?;
            }
        }
        Ok(())
    }

    /// The primary wavelength, µm, where it is not the d line.
    fn primary_wavelength(&mut self) -> Option<f64> {
        let (line, wavelength) = *self.wavelengths.get(self.primary - 1)?;
        if !(0.1..=20.0).contains(&wavelength) {
            let message = format!(
                "a primary wavelength of {wavelength} µm; expected 0.1 to 20: indices are those of the d line"
            );
            self.warnings.push(RowNote {
                line,
                column: 1,
                row: 0,
                message,
            });
            return None;
        }
        // Files round it to three digits.
        ((wavelength - LINE_D).abs() > 1e-3).then_some(wavelength)
    }

    /// A line within a surface; those of the file's head are of no interest.
    fn property(&mut self, keyword: &str, words: &[&str]) -> Result<(), String> {
        let first = self.blocks.len() == 1;
        let Some((block, before)) = self.blocks.split_last_mut() else {
            return Ok(());
        };
        match keyword {
            "STOP" => block.is_stop = true,
            "TYPE" => match words.first().copied().unwrap_or("STANDARD") {
                "STANDARD" => block.even = false,
                "EVENASPH" => block.even = true,
                // The object's own shape does not matter.
                _ if first => {}
                other => {
                    return Err(format!(
                        "surface type {other} cannot be traced; expected STANDARD or EVENASPH"
                    ));
                }
            },
            "CURV" => block.curvature = number(words, 0, "a curvature")?,
            "CONI" => block.asphere.conic = number(words, 0, "a conic constant")?,
            "PARM" => {
                let i = number(words, 0, "the number of a parameter")?;
                let value = number(words, 1, "a parameter")?;
                // Other types, whose parameters mean other things, have been refused.
                if (1.0..=TERMS as f64).contains(&i) && i.fract() == 0.0 {
                    block.asphere.terms[i as usize - 1] = value;
                }
            }
            "DISZ" => {
                block.thickness = if first {
                    0.0
                } else {
                    number(words, 0, "a distance")?
                };
            }
            "DIAM" => {
                block.semi_diameter = number(words, 0, "half a diameter")?;
                block.fixed_diameter = words.get(1) == Some(&"1");
            }
            "FLAP" => block.aperture = Aperture::Floating,
            // A circular aperture from an inner to an outer radius.
            "CLAP" => {
                if number(words, 0, "an inner radius")? > 0.0 {
                    return Err("ring-shaped apertures cannot be traced".to_string());
                }
                block.aperture = Aperture::Radius(number(words, 1, "an outer radius")?);
            }
            "GLAS" => block.medium = medium(words, before)?,
            _ => {}
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Prescription, PrescriptionError> {
        if self.errors.is_empty() && self.blocks.len() < 3 {
            return Err(PrescriptionError::Empty);
        }
        let mut blocks = std::mem::take(&mut self.blocks);
        let wavelength = self.primary_wavelength();
        // Neither the object nor the film.
        blocks.pop();
        let mut surfaces: Vec<Surface> = Vec::new();
        let mut before = glass::AIR;
        for block in blocks.iter().skip(1) {
            let bends = block.medium.glass != before;
            if !bends && !block.is_stop && block.aperture == Aperture::Edge {
                self.warn_left_out(block);
                // The vertex of what follows moves on; in front of the first surface nothing is measured.
                if let Some(last) = surfaces.last_mut() {
                    last.thickness += block.thickness * self.unit;
                }
                continue;
            }
            before = block.medium.glass;
            let surface = self.surface(block);
            surfaces.extend(surface.map(|s| self.at_wavelength(s, block, wavelength)));
        }
        if !self.errors.is_empty() {
            return Err(PrescriptionError::Rows(self.errors));
        }
        let Some(last) = surfaces.last_mut() else {
            return Err(PrescriptionError::Empty);
        };
        let film_distance = std::mem::take(&mut last.thickness);
        Ok(Prescription {
            film_distance,
            surfaces,
            warnings: self.warnings,
        })
    }

    /// What a surface between equal media might have been meant for.
    fn warn_left_out(&mut self, block: &Block) {
        if block.curvature != 0.0 || block.asphere().is_some() {
            self.warnings.push(block.note(
                "a curved surface between equal media bends no ray and is left out".to_string(),
            ));
        } else if block.fixed_diameter {
            self.warnings.push(block.note(format!(
                "the semi-diameter {} of a surface without power blocks nothing; for a baffle give it an aperture (FLAP or CLAP)",
                block.semi_diameter
            )));
        }
    }

    /// `surface`, which is that of `block`, with its index for this wavelength.
    fn at_wavelength(
        &mut self,
        surface: Surface,
        block: &Block,
        wavelength: Option<f64>,
    ) -> Surface {
        let (Some(wavelength), Some(formula)) = (wavelength, block.medium.glass.dispersion())
        else {
            return surface;
        };
        let index = formula.dispersion.index(wavelength);
        let [shortest, longest] = formula.range;
        if !(shortest..=longest).contains(&wavelength) {
            self.warnings.push(block.note(format!(
                "the dispersion of {} is known from {shortest} to {longest} µm; its index of {index:.5} at the primary wavelength {wavelength} µm is a guess",
                block.medium.name
            )));
        }
        // Not a number, or none that light can have.
        if !(1.0..=6.0).contains(&index) {
            self.errors.push(block.note(format!(
                "the dispersion of {} gives no index at {wavelength} µm; give a model glass (`GLAS ___BLANK 1 0 n_d V_d`)",
                block.medium.name
            )));
            return surface;
        }
        Surface {
            index,
            dispersion: Some(formula.dispersion),
            ..surface
        }
    }

    /// As the tracer wants it; `None` with an error.
    fn surface(&mut self, block: &Block) -> Option<Surface> {
        if block.rim() <= 0.0 {
            let message = "no clear diameter (DIAM); let Zemax compute or give one";
            self.errors.push(block.note(message.to_string()));
            return None;
        }
        let radius = 1.0 / block.curvature;
        let surface = Surface {
            radius: if block.curvature == 0.0 {
                f64::INFINITY
            } else {
                radius * self.unit
            },
            thickness: block.thickness * self.unit,
            index: block.medium.glass.index,
            abbe: block.medium.glass.abbe,
            dispersion: None,
            aperture: 2.0 * block.rim() * self.unit,
            is_stop: block.is_stop,
            asphere: block.asphere().map(|a| a.scaled(self.unit)),
        };
        let ordinary = surface.curvature().is_finite()
            && [surface.thickness, surface.aperture]
                .iter()
                .all(|x| x.is_finite());
        if !ordinary || (surface.radius.abs() < 1e-6) {
            let message = "a surface of infinite size or curvature";
            self.errors.push(block.note(message.to_string()));
            return None;
        }
        Some(surface)
    }
}

/// The value at `i`, finite.
fn number(words: &[&str], i: usize, what: &str) -> Result<f64, String> {
    let text = words.get(i).copied().unwrap_or("nothing");
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err(format!("expected {what}, found {text}")),
    }
}

/// `GLAS name kind surface n_d V_d …`: by its index where it is a model glass (kind 1), that of another surface where it is picked
/// up (2), else by its name.
fn medium(words: &[&str], before: &[Block]) -> Result<Medium, String> {
    let name = words.first().copied().unwrap_or("");
    if words.get(1) == Some(&"2") {
        let from = number(
            words,
            2,
            "the number of the surface whose glass is picked up",
        )?;
        let picked = before.iter().find(|block| block.row as f64 == from);
        let picked = picked.map(|block| block.medium.clone());
        return picked.ok_or_else(|| {
            format!("picks up the glass of surface {from}; expected one in front of this one")
        });
    }
    Ok(Medium {
        name: name.to_string(),
        glass: glass(name, words)?,
    })
}

fn glass(name: &str, words: &[&str]) -> Result<Glass, String> {
    if name.eq_ignore_ascii_case("MIRROR") {
        return Err("mirrors cannot be traced".to_string());
    }
    if words.get(1) == Some(&"1") {
        let index = number(words, 3, "the refractive index of a model glass")?;
        if !(1.0..=6.0).contains(&index) {
            return Err(format!(
                "a refractive index of {index}; expected 1 to about 4"
            ));
        }
        let abbe = number(words, 4, "the Abbe number of a model glass")?;
        return Ok(Glass {
            index,
            abbe: (abbe > 0.0).then_some(abbe),
            formula: None,
        });
    }
    glass::named(name).ok_or_else(|| {
        format!(
            "unknown glass {name}; known are {} of the common ones, and model glasses (`GLAS ___BLANK 1 0 n_d V_d`)",
            glass::COUNT
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Paraxial;
    use crate::optics::dispersion::AbbeModel;
    use proptest::prelude::*;

    /// The Cooke triplet of Smith's book as Zemax writes it, semi-diameters chosen here, with every kind of line that
    /// files have; the stop stands on its own.
    const TRIPLET: &str = "VERS 140124 258 36214\r\nMODE SEQ\r\nNAME Cooke triplet\r\nUNIT MM X W X CM MR CPMM\r\nENPD 1.0E+1\r\n\
        GCAT SCHOTT\r\nWAVM 1 5.87E-1 1\r\nSURF 0\r\n  TYPE STANDARD\r\n  CURV 0.0 0 0 0 0 \"\"\r\n  DISZ INFINITY\r\n\
        SURF 1\r\n  TYPE STANDARD\r\n  CURV 4.5435E-2 0 0 0 0 \"\"\r\n  MIRR 2 0\r\n  DISZ 3.259\r\n  GLAS SK16 0 0 1.62 60.3 0 0 0\r\n  DIAM 9.5 1 0 0 1 \"\"\r\n\
        SURF 2\r\n  TYPE STANDARD\r\n  CURV -2.2948E-3 0 0 0 0 \"\"\r\n  DISZ 6.008\r\n  DIAM 9.5 1 0 0 1 \"\"\r\n\
        SURF 3\r\n  TYPE STANDARD\r\n  CURV -4.5018E-2 0 0 0 0 \"\"\r\n  DISZ 1.0\r\n  GLAS ___BLANK 1 0 1.62004 36.37 0 0 0\r\n  DIAM 5 1 0 0 1 \"\"\r\n\
        SURF 4\r\n  STOP\r\n  TYPE STANDARD\r\n  CURV 4.9280E-2 0 0 0 0 \"\"\r\n  DISZ 4.75\r\n  DIAM 5 1 0 0 1 \"\"\r\n\
        SURF 5\r\n  TYPE EVENASPH\r\n  CURV 1.2556E-2 0 0 0 0 \"\"\r\n  CONI -0.5\r\n  PARM 1 0\r\n  PARM 2 1e-7\r\n  DISZ 2.952\r\n  GLAS SK16 0 0 1.62 60.3\r\n  DIAM 7.5 1 0 0 1 \"\"\r\n\
        SURF 6\r\n  TYPE STANDARD\r\n  CURV -5.4328E-2 0 0 0 0 \"\"\r\n  DISZ 2\r\n  DIAM 7.5 1 0 0 1 \"\"\r\n\
        SURF 7\r\n  TYPE STANDARD\r\n  CURV 0.0\r\n  DISZ 40.208\r\n  DIAM 10\r\n\
        SURF 8\r\n  TYPE STANDARD\r\n  CURV 0.0\r\n  DISZ 0\r\n  DIAM 18\r\nTOL TOFF 0 0\r\n";

    fn errors(text: &str) -> Vec<RowNote> {
        match parse(text) {
            Err(PrescriptionError::Rows(notes)) => notes,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_file_as_zemax_writes_it_is_read() {
        let utf16: Vec<u8> = std::iter::once(0xfeff)
            .chain(TRIPLET.encode_utf16())
            .flat_map(u16::to_le_bytes)
            .collect();
        let p = parse(&decode(&utf16)).unwrap();
        assert_eq!(p, parse(TRIPLET).unwrap());
        assert_eq!(p.surfaces.len(), 6);
        assert!(p.warnings.is_empty());
        // The auxiliary plane behind the lens is part of the film distance.
        assert!((p.film_distance - 42.208).abs() < 1e-12);
        assert!(p.surfaces[3].is_stop && p.surfaces[3].aperture == 10.0);
        assert_eq!(p.surfaces[2].abbe, Some(36.37));
        let a = p.surfaces[4].asphere.unwrap();
        assert_eq!((a.conic, a.terms[1]), (-0.5, 1e-7));
        // Radii 22.01, -435.76, -22.21, 20.29, 79.64, -18.41: the triplet of f = 50 mm.
        let f = Paraxial::new(&p.surfaces).cardinals.unwrap().focal_length;
        assert!((f - 50.0).abs() < 0.1, "{f}");
    }

    #[test]
    fn inches_are_converted_everywhere() {
        let inches = parse(&TRIPLET.replace("UNIT MM", "UNIT IN")).unwrap();
        let scaled = parse(TRIPLET).unwrap().scaled(25.4);
        for (a, b) in inches.surfaces.iter().zip(&scaled.surfaces) {
            assert!((a.radius / b.radius - 1.0).abs() < 1e-14);
            assert!((a.aperture / b.aperture - 1.0).abs() < 1e-14);
            assert!((a.sag(100.0) / b.sag(100.0) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn what_cannot_be_modeled_is_named_with_its_line() {
        let with = |from: &str, to: &str| errors(&TRIPLET.replace(from, to));
        for (from, to, expected) in [
            ("TYPE EVENASPH", "TYPE TOROIDAL", "surface type TOROIDAL"),
            (
                "GLAS SK16 0 0 1.62 60.3\r",
                "GLAS UNOBTAINIUM\r",
                "unknown glass UNOBTAINIUM",
            ),
            (
                "GLAS ___BLANK 1 0 1.62004",
                "GLAS MIRROR 0 0 1.62004",
                "mirrors",
            ),
            ("MODE SEQ", "MODE NSC", "mode NSC"),
            ("UNIT MM", "UNIT FURLONG", "unit FURLONG"),
            (
                "DISZ 6.008",
                "DISZ INFINITY",
                "expected a distance, found INFINITY",
            ),
            ("CONI -0.5", "CONI x", "expected a conic constant"),
            (
                "DIAM 10\r",
                "DIAM 10\r\n  OBSC 0 3\r",
                "central obscurations",
            ),
        ] {
            let notes = with(from, to);
            assert_eq!(notes.len(), 1, "{to}: {notes:?}");
            assert!(notes[0].message.contains(expected), "{to}: {}", notes[0]);
            let before = &TRIPLET[..TRIPLET.find(from).unwrap()];
            // The obscuration stands on a line of its own.
            let line = 1 + before.matches('\n').count() + usize::from(to.contains("OBSC"));
            assert_eq!(notes[0].line, line, "{to}: {}", notes[0]);
        }
        let ring = with("DIAM 10\r", "DIAM 10\r\n  CLAP 2 5\r");
        assert!(ring[0].message.contains("ring-shaped"), "{}", ring[0]);
        // Of the last step too the row is named: the fourth surface has lost its diameter.
        let notes = with("DIAM 7.5 1 0 0 1 \"\"", "DIAM 0 0");
        assert_eq!(notes.iter().map(|n| n.row).collect::<Vec<_>>(), [5, 6]);
        let narrow = parse(&TRIPLET.replacen("DIAM 9.5", "CLAP 0 8\r\n  DIAM 9.5", 1)).unwrap();
        assert_eq!(narrow.surfaces[0].aperture, 16.0);
        let notes = with("DIAM 7.5 1 0 0 1 \"\"", "DIAM 0 0");
        assert!(
            notes[0].message.contains("no clear diameter"),
            "{}",
            notes[0]
        );
        assert!(matches!(
            parse("MODE SEQ\nSURF 0\n"),
            Err(PrescriptionError::Empty)
        ));
    }

    /// A field stop between air and air, a baffle within glass, and a dummy in front, all of them rims.
    #[test]
    fn rims_between_equal_media_block() {
        let with = |line: &str, to: &str| parse(&TRIPLET.replacen(line, to, 1)).unwrap();
        // The auxiliary plane behind the lens, 2 mm behind its last surface.
        let plane = "DISZ 40.208\r\n  DIAM 10\r";
        for (lines, diameter) in [
            ("CLAP 0 6 0\r\n  DISZ 40.208\r\n  DIAM 10\r", 12.0),
            ("DISZ 40.208\r\n  FLAP 0 6 0\r\n  DIAM 7 1\r", 14.0),
        ] {
            let p = with(plane, lines);
            assert!(p.warnings.is_empty(), "{:?}", p.warnings);
            assert_eq!(p.surfaces.len(), 7);
            let rim = p.surfaces[6];
            assert_eq!(
                (rim.aperture, rim.is_stop, rim.index),
                (diameter, false, 1.0)
            );
            assert!((p.film_distance - 40.208).abs() < 1e-12 && p.surfaces[5].thickness == 2.0);
        }
        // In front of the lens too, where other dummies are left out.
        let front = "SURF 1\r\n  DISZ 30\r\n  CLAP 0 9 0\r\nSURF 1\r\n";
        let p = with("SURF 1\r\n", front);
        assert_eq!(
            (
                p.surfaces.len(),
                p.surfaces[0].thickness,
                p.surfaces[0].aperture
            ),
            (7, 30.0, 18.0)
        );
        // Without an aperture nothing is blocked, and a semi-diameter by hand is worth a word.
        let p = with(plane, "DISZ 40.208\r\n  DIAM 3 1 0 0 1 \"\"\r");
        assert_eq!(p.surfaces.len(), 6);
        let note = &p.warnings[0];
        assert!(
            note.row == 7 && note.message.contains("blocks nothing"),
            "{note}"
        );
    }

    /// A biconvex lens of radii 200 mm, 1e-6 mm thick: its focal length is 100 mm / (n − 1).
    fn index_of(head: &str, glass: &str) -> (f64, Prescription) {
        let p = parse(&format!(
            "MODE SEQ\nUNIT MM\n{head}\nSURF 0\n DISZ INFINITY\nSURF 1\n STOP\n CURV 5e-3\n DISZ 1e-6\n GLAS {glass}\n DIAM 10\n\
             SURF 2\n CURV -5e-3\n DISZ 95\n DIAM 10\nSURF 3\n"
        ))
        .unwrap();
        let f = Paraxial::new(&p.surfaces).cardinals.unwrap().focal_length;
        (1.0 + 100.0 / f, p)
    }

    #[test]
    fn indices_are_those_of_the_primary_wavelength() {
        // Malitson's tables.
        for head in [
            "WAVM 1 0.248272 1\nWAVM 2 0.6 1",
            "WAVM 1 0.5 1\nWAVM 2 0.248272 1\nPWAV 2",
            "PWAV 3\nWAVL 0.4 0.5 0.248272\nWWGT 1 1 1",
        ] {
            for (glass, expected) in [("F_SILICA 0 0 1.5 40", 1.50841), ("CAF2", 1.46793)] {
                let (n, p) = index_of(head, glass);
                assert!((n - expected).abs() < 5e-5, "{head} {glass}: {n}");
                assert!(p.warnings.is_empty(), "{:?}", p.warnings);
                // At the d line it is what the catalog says.
                let d = p.at_wavelength(LINE_D, AbbeModel::NormalLine).surfaces[0].index;
                assert!(
                    (d - glass::named(glass.split(' ').next().unwrap())
                        .unwrap()
                        .index)
                        .abs()
                        < 3e-5
                );
            }
        }
        // A glass known by two numbers: in the visible to 1e-4 (Schott's n_F of N-SF6: 1.82783), beyond with a warning.
        let (n, p) = index_of("WAVM 1 0.4861327 1", "N-SF6");
        assert!((n - 1.82783).abs() < 2e-4 && p.warnings.is_empty(), "{n}");
        let (_, p) = index_of("WAVM 1 0.35 1", "___BLANK 1 0 1.6 60");
        assert!(
            p.warnings[0].row == 1 && p.warnings[0].message.contains("0.35 µm is a guess"),
            "{:?}",
            p.warnings
        );
        // The d line as files round it, and none; the thickness makes 1e-9.
        for head in ["WAVM 1 5.876E-1 1", "WAVM 1 0.587 1", "", "PWAV 9"] {
            assert!((index_of(head, "N-BK7").0 - 1.5168).abs() < 1e-8, "{head}");
        }
        let (n, p) = index_of("WAVM 1 0 1", "N-BK7");
        assert!(
            (n - 1.5168).abs() < 1e-8 && p.warnings[0].line == 3,
            "{:?}",
            p.warnings
        );
    }

    #[test]
    fn a_glass_is_picked_up_from_another_surface() {
        let p =
            parse(&TRIPLET.replacen("GLAS ___BLANK 1 0 1.62004", "GLAS ___BLANK 2 1 1.62004", 1))
                .unwrap();
        assert_eq!(
            (p.surfaces[2].index, p.surfaces[2].abbe),
            (p.surfaces[0].index, p.surfaces[0].abbe)
        );
        for wrong in ["5", "-1", "0.5", "x"] {
            let notes = errors(&TRIPLET.replacen(
                "GLAS ___BLANK 1 0",
                &format!("GLAS ___BLANK 2 {wrong}"),
                1,
            ));
            assert!(notes.len() == 1 && notes[0].row == 3, "{notes:?}");
        }
    }

    proptest! {
        /// Whatever the text, reading ends.
        #[test]
        fn reading_never_panics(words in prop::collection::vec(
            "SURF|TYPE|EVENASPH|WAVM|WAVL|PWAV|CLAP|FLAP|CURV|CONI|PARM|DISZ|GLAS|DIAM|STOP|MODE|SEQ|\n|\n|\n|-?[0-9]{1,3}|1e-?[0-9]{3}|INFINITY|nan|BK7|é", 0..80,
        )) {
            if let Ok(p) = parse(&words.join(" ")) {
                for s in &p.surfaces {
                    prop_assert!(s.curvature().is_finite() && s.thickness.is_finite());
                    prop_assert!(s.index > 0.0 && s.aperture > 0.0);
                }
            }
        }

        /// Whatever the bytes, they become text.
        #[test]
        fn decoding_never_panics(bytes in prop::collection::vec(any::<u8>(), 0..40)) {
            decode(&bytes);
        }
    }
}
