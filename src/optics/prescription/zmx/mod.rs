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

mod block;
#[cfg(test)]
mod tests;

use self::block::{Aperture, Block, value};
use super::cells::lines;
use super::glass;
use super::{INDICES, Notes, Prescription, PrescriptionError, RowNote};
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
    let mut reader = Reader {
        unit: 1.0,
        primary: 1,
        ..Reader::default()
    };
    for (line, content) in lines(text) {
        let mut words = content.split_whitespace();
        let Some(keyword) = words.next() else {
            continue;
        };
        if let Err(message) = reader.line(line, keyword, &words.collect::<Vec<_>>()) {
            reader.notes.errors.push(RowNote {
                line,
                column: content.len() - content.trim_start().len() + 1,
                // Surfaces count from the object, 0.
                row: reader.blocks.len().saturating_sub(1),
                message,
            });
        }
    }
    reader.finish()
}

/// Collects surfaces and what is wrong.
#[derive(Default)]
struct Reader {
    blocks: Vec<Block>,
    /// Millimeters per unit of the file.
    unit: f64,
    /// By number from 1, µm; with the line of each.
    wavelengths: Vec<(usize, f64)>,
    /// The number of the one that the lens is made for.
    primary: usize,
    notes: Notes,
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
    /// Reads a line.
    fn line(&mut self, line: usize, keyword: &str, words: &[&str]) -> Result<(), String> {
        let first = words.first().copied();
        match keyword {
            "SURF" => self.blocks.push(Block {
                line,
                row: self.blocks.len(),
                ..Block::default()
            }),
            "WAVM" | "WAVL" | "PWAV" if self.blocks.is_empty() => {
                self.wavelength(line, keyword, words)?;
            }
            "MODE" if first.is_some_and(|mode| mode != "SEQ") => {
                let mode = words[0];
                return Err(format!(
                    "mode {mode}; only sequential files (SEQ) can be read"
                ));
            }
            "UNIT" => match first {
                Some("MM") | None => {}
                Some("CM") => self.unit = 10.0,
                Some("IN") => self.unit = 25.4,
                Some("METER") => self.unit = 1000.0,
                Some(other) => {
                    return Err(format!("unit {other}; expected MM, CM, IN or METER"));
                }
            },
            _ => {
                if let Some((_, what)) = UNKNOWN_OPTICS.iter().find(|(k, _)| *k == keyword)
                    && self.blocks.len() > 1
                {
                    return Err(format!("{keyword}: {what} cannot be traced"));
                }
                // Other lines of the file's head are of no interest.
                if let Some((block, before)) = self.blocks.split_last_mut() {
                    block.set(keyword, words, before)?;
                }
            }
        }
        Ok(())
    }

    /// `WAVM number µm weight`, `WAVL µm µm …`, `PWAV number`.
    fn wavelength(&mut self, line: usize, keyword: &str, words: &[&str]) -> Result<(), String> {
        let whole = |x: f64| (1.0..=99.0).contains(&x).then_some(x as usize);
        match keyword {
            "PWAV" => {
                let primary = value(words, 0, "the number of the primary wavelength")?;
                self.primary = whole(primary).unwrap_or(1);
            }
            "WAVM" => {
                let i = value(words, 0, "the number of a wavelength")?;
                let wavelength = value(words, 1, "a wavelength in µm")?;
                let Some(i) = whole(i) else { return Ok(()) };
                if self.wavelengths.len() < i {
                    self.wavelengths.resize(i, (line, LINE_D));
                }
                self.wavelengths[i - 1] = (line, wavelength);
            }
            _ => {
                let all = (0..words.len()).map(|i| value(words, i, "a wavelength in µm"));
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

    fn finish(mut self) -> Result<Prescription, PrescriptionError> {
        if self.notes.errors.is_empty() && self.blocks.len() < 3 {
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
            match block.surface(self.unit) {
                Ok(surface) => surfaces.push(self.at_wavelength(surface, block, wavelength)),
                Err(message) => self.notes.errors.push(block.note(message)),
            }
        }
        self.notes.prescription(surfaces)
    }

    /// What a surface between equal media might have been meant for.
    fn warn_left_out(&mut self, block: &Block) {
        if block.curvature != 0.0 || block.asphere().is_some() {
            self.notes.warnings.push(
                block.note("a curved surface between equal media bends no ray and is left out"),
            );
        } else if block.fixed_diameter {
            self.notes.warnings.push(block.note(format!(
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
            self.notes.warnings.push(block.note(format!(
                "the dispersion of {} is known from {shortest} to {longest} µm; its index of {index:.5} at the primary wavelength {wavelength} µm is a guess",
                block.medium.name
            )));
        }
        // Not a number, or none that light can have.
        if !INDICES.contains(&index) {
            self.notes.errors.push(block.note(format!(
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
}
