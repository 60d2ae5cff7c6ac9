//! Aspheric and dispersion terms, names and coatings behind the columns of a lens table.

use super::INDICES;
use crate::optics::asphere::{Asphere, TERMS};
use crate::optics::catalogue_formula::CatalogueFormula;
use crate::optics::coating::Coating;
use crate::optics::dispersion::Dispersion;
use crate::optics::surface::GlassName;

/// What the words `name=value` of one row say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Extras {
    pub asphere: Option<Asphere>,
    pub dispersion: Option<Dispersion>,
    pub glass: Option<GlassName>,
    pub coating: Option<Coating>,
}

impl Extras {
    /// Reads one word.
    pub(super) fn read(&mut self, word: &str) -> Result<(), String> {
        let (name, value) = word
            .split_once('=')
            .filter(|(name, value)| !name.is_empty() && !value.is_empty())
            .ok_or_else(|| format!("expected name=value without blanks, found {word}"))?;
        match name.to_ascii_lowercase().as_str() {
            "k" | "conic" => {
                let [k] = numbers(value)?;
                self.asphere.get_or_insert_default().conic = k;
            }
            "cauchy" => self.dispersion = Some(Dispersion::Cauchy(numbers(value)?)),
            "sellmeier" => self.dispersion = Some(Dispersion::Sellmeier(numbers(value)?)),
            "agf" => self.dispersion = Some(catalogue(value)?),
            "coating" => self.coating = Some(value.parse()?),
            "glass" => {
                let name = GlassName::new(value);
                self.glass = Some(name.ok_or("expected a glass name of at most 24 letters")?);
            }
            term => {
                let i = term_index(term).ok_or_else(|| {
                    format!(
                        "unknown term {name}; expected k, A2, A4 … A{}, cauchy, sellmeier, agf, glass or coating",
                        2 * TERMS
                    )
                })?;
                let [a] = numbers(value)?;
                self.asphere.get_or_insert_default().terms[i] = a;
            }
        }
        self.check()
    }

    /// A dispersion formula must give a refractive index where light is seen.
    fn check(&self) -> Result<(), String> {
        let Some(formula) = self.dispersion else {
            return Ok(());
        };
        formula.check()
    }
}

impl Dispersion {
    /// Returns `true` if it gives a refractive index where light is seen.
    pub(super) fn check(&self) -> Result<(), String> {
        for wavelength in [0.38, 0.5875618, 0.78] {
            let n = self.index(wavelength);
            if !INDICES.contains(&n) {
                return Err(format!(
                    "the dispersion formula gives an index of {n} at {wavelength} µm; expected 1 to about 4"
                ));
            }
        }
        Ok(())
    }
}

/// Of `a4`: 1, the place of the coefficient of r⁴.
fn term_index(name: &str) -> Option<usize> {
    let power: usize = name.strip_prefix('a')?.parse().ok()?;
    (power.is_multiple_of(2) && (2..=2 * TERMS).contains(&power)).then(|| power / 2 - 1)
}

/// A formula of glass catalogues: its number, then its coefficients.
fn catalogue(text: &str) -> Result<Dispersion, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(finite).collect();
    let formula = numbers.and_then(|numbers| {
        let (number, coefficients) = numbers.split_first()?;
        let number = Some(*number).filter(|n| n.fract() == 0.0 && (1.0..=13.0).contains(n))?;
        CatalogueFormula::new(number as u8, coefficients)
    });
    let formula = formula.ok_or_else(|| {
        format!("expected the number of a formula, 1 to 13, and up to 10 coefficients, separated by commas, found {text}")
    })?;
    Ok(Dispersion::of_catalogue(formula))
}

fn finite(text: &str) -> Option<f64> {
    text.parse().ok().filter(|x: &f64| x.is_finite())
}

/// Exactly `N` finite numbers separated by commas.
fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(finite).collect();
    numbers
        .and_then(|n| n.try_into().ok())
        .ok_or_else(|| format!("expected {N} number(s) separated by commas, found {text}"))
}
