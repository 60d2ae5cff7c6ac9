//! One surface as the file has it, line by line, and as the tracer wants it.

use crate::optics::asphere::{Asphere, TERMS};
use crate::optics::prescription::cells::number;
use crate::optics::prescription::glass::{self, Glass};
use crate::optics::prescription::{INDICES, RowNote};
use crate::optics::surface::Surface;

/// One surface as the file has it.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    /// Where it begins.
    pub line: usize,
    /// Its number, the object's being 0.
    pub row: usize,
    pub curvature: f64,
    /// Is it an even asphere, whose `PARM` are coefficients?
    pub even: bool,
    pub asphere: Asphere,
    pub thickness: f64,
    pub medium: Medium,
    pub semi_diameter: f64,
    /// Was that given by hand, not by the rays of the design?
    pub fixed_diameter: bool,
    pub aperture: Aperture,
    pub is_stop: bool,
}

/// What is behind a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Medium {
    pub name: String,
    pub glass: Glass,
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

impl Block {
    pub(super) fn note(&self, message: impl Into<String>) -> RowNote {
        RowNote {
            line: self.line,
            column: 1,
            row: self.row,
            message: message.into(),
        }
    }

    /// Reads a line within the surface, which follows those `before` it.
    pub(super) fn set(
        &mut self,
        keyword: &str,
        words: &[&str],
        before: &[Block],
    ) -> Result<(), String> {
        let object = before.is_empty();
        match keyword {
            "STOP" => self.is_stop = true,
            "TYPE" => match words.first().copied().unwrap_or("STANDARD") {
                "STANDARD" => self.even = false,
                "EVENASPH" => self.even = true,
                // The object's own shape does not matter.
                _ if object => {}
                other => {
                    return Err(format!(
                        "surface type {other} cannot be traced; expected STANDARD or EVENASPH"
                    ));
                }
            },
            "CURV" => self.curvature = value(words, 0, "a curvature")?,
            "CONI" => self.asphere.conic = value(words, 0, "a conic constant")?,
            "PARM" => {
                let i = value(words, 0, "the number of a parameter")?;
                let value = value(words, 1, "a parameter")?;
                // Other types, whose parameters mean other things, have been refused.
                if (1.0..=TERMS as f64).contains(&i) && i.fract() == 0.0 {
                    self.asphere.terms[i as usize - 1] = value;
                }
            }
            // The object may be anywhere.
            "DISZ" if object => {}
            "DISZ" => self.thickness = value(words, 0, "a distance")?,
            "DIAM" => {
                self.semi_diameter = value(words, 0, "half a diameter")?;
                self.fixed_diameter = words.get(1) == Some(&"1");
            }
            "FLAP" => self.aperture = Aperture::Floating,
            // A circular aperture from an inner to an outer radius.
            "CLAP" => {
                if value(words, 0, "an inner radius")? > 0.0 {
                    return Err("ring-shaped apertures cannot be traced".to_string());
                }
                self.aperture = Aperture::Radius(value(words, 1, "an outer radius")?);
            }
            "GLAS" => self.medium = medium(words, before)?,
            _ => {}
        }
        Ok(())
    }

    /// Distance from the axis at which it stops rays.
    fn rim(&self) -> f64 {
        match self.aperture {
            Aperture::Radius(radius) => radius,
            Aperture::Edge | Aperture::Floating => self.semi_diameter,
        }
    }

    /// Its shape departs from a sphere.
    pub(super) fn asphere(&self) -> Option<Asphere> {
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

    /// As the tracer wants it, with `unit` mm for a unit of the file.
    pub(super) fn surface(&self, unit: f64) -> Result<Surface, &'static str> {
        if self.rim() <= 0.0 {
            return Err("no clear diameter (DIAM); let Zemax compute or give one");
        }
        let surface = Surface {
            radius: match self.curvature {
                0.0 => f64::INFINITY,
                curvature => 1.0 / curvature * unit,
            },
            thickness: self.thickness * unit,
            index: self.medium.glass.index,
            abbe: self.medium.glass.abbe,
            dispersion: None,
            aperture: 2.0 * self.rim() * unit,
            is_stop: self.is_stop,
            asphere: self.asphere().map(|a| a.scaled(unit)),
        };
        let lengths = [surface.curvature(), surface.thickness, surface.aperture];
        if !lengths.iter().all(|x| x.is_finite()) || surface.radius.abs() < 1e-6 {
            return Err("a surface of infinite size or curvature");
        }
        Ok(surface)
    }
}

/// The finite number at `i`.
pub(super) fn value(words: &[&str], i: usize, what: &str) -> Result<f64, String> {
    number(words.get(i).copied().unwrap_or("nothing"), what)
}

/// `GLAS name kind surface n_d V_d …`: by its index where it is a model glass (kind 1), that of another surface where it is picked
/// up (2), else by its name.
fn medium(words: &[&str], before: &[Block]) -> Result<Medium, String> {
    let name = words.first().copied().unwrap_or("");
    if words.get(1) == Some(&"2") {
        let from = value(
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
        let index = value(words, 3, "the refractive index of a model glass")?;
        if !INDICES.contains(&index) {
            return Err(format!(
                "a refractive index of {index}; expected 1 to about 4"
            ));
        }
        let abbe = value(words, 4, "the Abbe number of a model glass")?;
        return Ok(Glass {
            index,
            abbe: (abbe > 0.0).then_some(abbe),
            formula: None,
        });
    }
    glass::named(name).ok_or_else(|| {
        format!(
            "unknown glass {name}; known are {} of the common ones, and model glasses (`GLAS ___BLANK 1 0 n_d V_d`)",
            glass::count()
        )
    })
}
