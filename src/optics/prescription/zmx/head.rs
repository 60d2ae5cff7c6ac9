//! What stands in front of the surfaces: units, wavelengths, aperture and fields.

use crate::optics::dispersion::LINE_D;
use crate::optics::prescription::design::light::{Beam, Field, FieldKind, Light};
use crate::optics::prescription::design::value;

/// Values of one line, by field.
type ByField = Vec<f64>;

/// The head as far as it has been read.
#[derive(Default)]
pub(super) struct Head {
    unit: Option<f64>,
    /// By number from 1, µm; with the line of each.
    wavelengths: Vec<(usize, f64)>,
    /// The number of the one that the lens is made for.
    primary: Option<usize>,
    beam: Beam,
    kind: FieldKind,
    /// Fields in use, where the file says so.
    count: Option<usize>,
    x: ByField,
    y: ByField,
    decenter: ByField,
    compression: ByField,
}

/// A count of something, 1 to 99.
fn whole(x: f64) -> Option<usize> {
    (1.0..=99.0).contains(&x).then_some(x as usize)
}

/// Numbers up to the first word that is none.
fn numbers(words: &[&str]) -> Vec<f64> {
    let numbers = words.iter().map_while(|word| word.parse::<f64>().ok());
    numbers.filter(|x| x.is_finite()).take(99).collect()
}

/// Returns `true` if the second word is 1.
fn is_flagged(words: &[&str]) -> bool {
    words.get(1).is_some_and(|flag| *flag == "1")
}

impl Head {
    /// Returns `true` if a line with this keyword may come after surfaces, too.
    pub(super) fn says_units(keyword: &str) -> bool {
        matches!(keyword, "MODE" | "UNIT")
    }

    /// Reads a line.
    pub(super) fn set(&mut self, line: usize, keyword: &str, words: &[&str]) -> Result<(), String> {
        let first = words.first().copied();
        match keyword {
            "MODE" if first.is_some_and(|mode| mode != "SEQ") => {
                let mode = words[0];
                return Err(format!(
                    "mode {mode}; only sequential files (SEQ) can be read"
                ));
            }
            "UNIT" => {
                self.unit = Some(match first {
                    Some("MM") | None => 1.0,
                    Some("CM") => 10.0,
                    Some("IN") => 25.4,
                    Some("METER") => 1000.0,
                    Some(other) => {
                        return Err(format!("unit {other}; expected MM, CM, IN or METER"));
                    }
                });
            }
            "WAVM" | "WAVL" | "PWAV" => self.wavelength(line, keyword, words)?,
            "ENPD" => self.beam = Beam::EntrancePupil(value(words, 0, "a diameter")?),
            "FNUM" => {
                let f = value(words, 0, "an f-number")?;
                self.beam = match is_flagged(words) {
                    true => Beam::WorkingFNumber(f),
                    false => Beam::FNumber(f),
                };
            }
            // Or half the angle of the cone, in degrees.
            "OBNA" => {
                let aperture = value(words, 0, "an aperture")?;
                self.beam = Beam::ObjectAperture(match is_flagged(words) {
                    true => aperture.to_radians().sin(),
                    false => aperture,
                });
            }
            "FLOA" => self.beam = Beam::Stop,
            "FTYP" => self.field_type(words),
            "XFLN" | "XFLD" => self.x = numbers(words),
            "YFLN" | "YFLD" => self.y = numbers(words),
            "VDYN" => self.decenter = numbers(words),
            "VCYN" => self.compression = numbers(words),
            // Other lines of the file's head are of no interest.
            _ => {}
        }
        Ok(())
    }

    /// `FTYP kind normalization fields …`.
    fn field_type(&mut self, words: &[&str]) {
        let numbers = numbers(words);
        self.kind = match numbers.first() {
            Some(1.0) => FieldKind::ObjectHeight,
            // Paraxial and real: the same for the fields that diameters follow from.
            Some(2.0 | 3.0) => FieldKind::ImageHeight,
            _ => FieldKind::Angle,
        };
        self.count = numbers.get(2).copied().and_then(whole);
    }

    /// `WAVM number µm weight`, `WAVL µm µm …`, `PWAV number`.
    fn wavelength(&mut self, line: usize, keyword: &str, words: &[&str]) -> Result<(), String> {
        match keyword {
            "PWAV" => {
                let primary = value(words, 0, "the number of the primary wavelength")?;
                self.primary = whole(primary);
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

    /// The primary wavelength, µm, with its line.
    pub(super) fn primary_wavelength(&self) -> Option<(usize, f64)> {
        let i = self.primary.unwrap_or(1) - 1;
        self.wavelengths.get(i).copied()
    }

    /// Millimeters per unit of the file.
    pub(super) fn unit(&self) -> f64 {
        self.unit.unwrap_or(1.0)
    }

    /// Beam and fields.
    pub(super) fn light(&self) -> Light {
        let count = self.count.unwrap_or(self.x.len().max(self.y.len()));
        let at = |values: &ByField, i: usize| values.get(i).copied().unwrap_or(0.0);
        let field = |i: usize| {
            let (middle, half) = (at(&self.decenter, i), 1.0 - at(&self.compression, i));
            // A field beside the meridional plane is turned into it.
            let y = at(&self.y, i);
            Field {
                height: at(&self.x, i).hypot(y).copysign(y),
                through: [middle - half, middle + half],
            }
        };
        Light {
            beam: self.beam,
            kind: self.kind,
            fields: (0..count).map(field).collect(),
            ..Light::default()
        }
    }
}
