//! Aspheric and dispersion terms behind the columns of a lens table.

use super::INDICES;
use crate::optics::asphere::{Asphere, TERMS};
use crate::optics::dispersion::Dispersion;

/// What the words `name=value` of one row say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Extras {
    pub asphere: Option<Asphere>,
    pub dispersion: Option<Dispersion>,
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
            term => {
                let i = term_index(term).ok_or_else(|| {
                    format!(
                        "unknown term {name}; expected k, A2, A4 … A{}, cauchy or sellmeier",
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
        for wavelength in [0.38, 0.5875618, 0.78] {
            let n = formula.index(wavelength);
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

/// Exactly `N` finite numbers separated by commas.
fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let numbers: Option<Vec<f64>> = text
        .split(',')
        .map(|part| part.parse().ok().filter(|x: &f64| x.is_finite()))
        .collect();
    numbers
        .and_then(|n| n.try_into().ok())
        .ok_or_else(|| format!("expected {N} number(s) separated by commas, found {text}"))
}
