//! One surface as the file has it, line by line.

use crate::optics::asphere::TERMS;
use crate::optics::prescription::design::{Aperture, DesignSurface, Medium, value};
use crate::optics::prescription::glass::Glasses;

/// What `PARM` lines of a surface mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Kind {
    #[default]
    Standard,
    /// Coefficients of r², r⁴, …
    Even,
    /// Coefficients of r, r², r³, …
    Odd,
    /// A tilt and a decenter, which a centered lens has none of.
    CoordinateBreak,
}

/// One surface as the file has it.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    pub surface: DesignSurface,
    kind: Kind,
    /// Values of `PARM` lines that a centered asphere of even powers has no place for, with what they are.
    unfit: Option<String>,
    parameters: Vec<(usize, f64)>,
    /// Its thickness follows from where the image is.
    pub solved: bool,
    /// What is odd about its glass.
    pub warning: Option<String>,
}

/// Types that bend rays in ways that are not traced, and in more than one place of the field.
const TYPES: &str =
    "STANDARD, EVENASPH, or ODDASPHE and COORDBRK without odd terms, tilts and decenters";

impl Block {
    /// Number `row`, which begins in `line`.
    pub(super) fn new(line: usize, row: usize) -> Block {
        let surface = DesignSurface {
            line,
            row,
            ..DesignSurface::default()
        };
        Block {
            surface,
            ..Block::default()
        }
    }

    /// Reads a line within the surface, which follows those `before` it.
    pub(super) fn set(
        &mut self,
        keyword: &str,
        words: &[&str],
        before: &[Block],
        glasses: &Glasses,
    ) -> Result<(), String> {
        let object = before.is_empty();
        let surface = &mut self.surface;
        match keyword {
            "STOP" => surface.is_stop = true,
            "TYPE" => match words.first().copied().unwrap_or("STANDARD") {
                "STANDARD" => self.kind = Kind::Standard,
                "EVENASPH" => self.kind = Kind::Even,
                "ODDASPHE" => self.kind = Kind::Odd,
                "COORDBRK" => self.kind = Kind::CoordinateBreak,
                // The object's own shape does not matter.
                _ if object => {}
                other => {
                    let row = surface.row;
                    return Err(format!(
                        "surface type {other} of surface {row} cannot be traced; expected {TYPES}"
                    ));
                }
            },
            "CURV" => surface.curvature = value(words, 0, "a curvature")?,
            "CONI" => surface.asphere.conic = value(words, 0, "a conic constant")?,
            "PARM" => self.parameter(words)?,
            // The object may be anywhere.
            "DISZ" if object => {
                surface.thickness = value(words, 0, "").unwrap_or(f64::INFINITY);
            }
            "DISZ" => surface.thickness = value(words, 0, "a distance")?,
            "MAZH" => self.solved = true,
            "DIAM" => {
                surface.semi_diameter = value(words, 0, "half a diameter")?;
                surface.fixed_diameter = words.get(1) == Some(&"1");
            }
            "FLAP" => surface.aperture = Aperture::Floating,
            // Zemax' own name for a quarter-wave layer of MgF2. Others are in catalogues of coatings.
            "COAT" => surface.is_coated = words.first() == Some(&"AR"),
            // A circular aperture from an inner to an outer radius.
            "CLAP" => {
                if value(words, 0, "an inner radius")? > 0.0 {
                    return Err("ring-shaped apertures cannot be traced".to_string());
                }
                surface.aperture = Aperture::Radius(value(words, 1, "an outer radius")?);
            }
            "GLAS" => {
                let found = medium(words, before, glasses);
                surface.medium = found.or_else(|unknown| {
                    let (medium, numbers) = match by_its_numbers(words) {
                        Some(medium) => (medium, "n_d and V_d are those in its line, which may be of another glass"),
                        None => (
                            unpressed(words, glasses).ok_or(unknown)?,
                            "its indices are those before it is pressed, which changes them by some thousandths",
                        ),
                    };
                    self.warning = Some(format!("unknown glass {}: {numbers}", medium.name));
                    Ok::<_, String>(medium)
                })?;
            }
            _ => {}
        }
        Ok(())
    }

    /// `PARM number value`; what it means is clear when the type is, at the end.
    fn parameter(&mut self, words: &[&str]) -> Result<(), String> {
        let i = value(words, 0, "the number of a parameter")?;
        let value = value(words, 1, "a parameter")?;
        if (1.0..=99.0).contains(&i) && i.fract() == 0.0 && self.parameters.len() < 100 {
            self.parameters.push((i as usize, value));
        }
        Ok(())
    }

    /// The surface with what its parameters say, and what it cannot be traced for.
    pub(super) fn finish(mut self) -> (DesignSurface, Option<String>) {
        for (i, value) in std::mem::take(&mut self.parameters) {
            let term = match self.kind {
                // They mean nothing there.
                Kind::Standard => continue,
                Kind::Even => Some(i - 1).filter(|i| *i < TERMS),
                Kind::Odd => (i.is_multiple_of(2) && i <= 2 * TERMS).then(|| i / 2 - 1),
                // The last one is the order of tilt and decenter.
                Kind::CoordinateBreak if i > 5 => continue,
                Kind::CoordinateBreak => None,
            };
            match term {
                Some(term) => self.surface.asphere.terms[term] = value,
                None if value != 0.0 => {
                    let row = self.surface.row;
                    let what = match self.kind {
                        Kind::CoordinateBreak => "tilts or decenters the lens",
                        _ => "has a term that is no even power up to r¹⁶",
                    };
                    self.unfit = Some(format!("surface {row} {what} (PARM {i} {value})"));
                }
                None => {}
            }
        }
        (self.surface, self.unfit)
    }
}

/// `GLAS name kind surface n_d V_d …`: by its index where it is a model glass (kind 1), that of another surface where it is picked
/// up (2), else by its name.
fn medium(words: &[&str], before: &[Block], glasses: &Glasses) -> Result<Medium, String> {
    let name = words.first().copied().unwrap_or("");
    match words.get(1) {
        Some(&"1") => {
            let index = value(words, 3, "the refractive index of a model glass")?;
            let abbe = value(words, 4, "the Abbe number of a model glass")?;
            Medium::model(name, index, abbe)
        }
        Some(&"2") => {
            let from = value(
                words,
                2,
                "the number of the surface whose glass is picked up",
            )?;
            let picked = before.iter().find(|b| b.surface.row as f64 == from);
            let picked = picked.map(|block| block.surface.medium.clone());
            picked.ok_or_else(|| {
                format!("picks up the glass of surface {from}; expected one in front of this one")
            })
        }
        _ => Medium::named(name, glasses),
    }
}

/// The glass of a name unknown whose line has the numbers of a glass, as newer programs write them; older ones put 1.5 and 40 there.
fn by_its_numbers(words: &[&str]) -> Option<Medium> {
    let (index, abbe) = (value(words, 3, "").ok()?, value(words, 4, "").ok()?);
    if Medium::is_mirror(words.first()?) {
        return None;
    }
    let likely = words.get(1) == Some(&"0") && index > 1.3 && (15.0..=100.0).contains(&abbe);
    let medium = Medium::model(words.first()?, index, abbe).ok()?;
    (likely && (index, abbe) != (1.5, 40.0)).then_some(medium)
}

/// The glass that one of a name unknown is pressed from.
fn unpressed(words: &[&str], glasses: &Glasses) -> Option<Medium> {
    let name = words.first()?;
    let glass = glasses.unpressed(name)?;
    let name = name.to_string();
    Some(Medium { name, glass })
}
