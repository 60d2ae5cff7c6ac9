//! How the refractive index changes with the wavelength.
//!
//! A lens file gives at best two numbers for a glass, n_d and the Abbe number V_d = (n_d − 1)/(n_F − n_C). Two ways to
//! make a curve of them:
//!
//! * [`AbbeModel::TwoTerm`]: n = A + B/λ², which both numbers decide. Off by 3e-4 (rms) at C and F for real glasses.
//! * [`AbbeModel::NormalLine`]: n = A + B/λ² + C/λ⁴, the third condition being that partial dispersions of normal
//!   glasses lie on a line, P_gF = 0.6438 − 0.001682 V_d (Schott, technical information TIE-29, 2016): off by 6e-5.
//!   At the same cost for tracing, so it is what rendering uses.
//!
//! Wavelengths are micrometers in air. Lines: g 0.4358343, F 0.4861327, d 0.5875618, C 0.6562725.

use super::catalogue_formula::CatalogueFormula;
use super::prescription::Prescription;
use super::surface::Surface;

/// Wavelength of the blue mercury line g, µm.
pub const LINE_G: f64 = 0.4358343;
/// Wavelength of the blue hydrogen line F, µm.
pub const LINE_F: f64 = 0.4861327;
/// Wavelength of the yellow helium line d, µm.
pub const LINE_D: f64 = 0.5875618;
/// Wavelength of the red hydrogen line C, µm.
pub const LINE_C: f64 = 0.6562725;

/// A dispersion formula. λ in micrometers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dispersion {
    /// n = a + b/λ² + c/λ⁴ (Cauchy).
    Cauchy([f64; 3]),
    /// n² = 1 + Σ b λ²/(λ² − c) (Sellmeier): b of the three terms, then c in µm².
    Sellmeier([f64; 6]),
    /// Another one of glass catalogues.
    Catalogue(CatalogueFormula),
}

impl Dispersion {
    /// The index at `wavelength`.
    pub fn index(&self, wavelength: f64) -> f64 {
        let l2 = wavelength * wavelength;
        match self {
            Dispersion::Cauchy([a, b, c]) => a + (b + c / l2) / l2,
            Dispersion::Sellmeier(k) => {
                let sum: f64 = (0..3).map(|i| k[i] * l2 / (l2 - k[i + 3])).sum();
                (1.0 + sum).sqrt()
            }
            Dispersion::Catalogue(formula) => formula.index(wavelength),
        }
    }

    /// The formula of a glass catalogue; that of three Sellmeier terms as [`Dispersion::Sellmeier`].
    pub fn of_catalogue(formula: CatalogueFormula) -> Dispersion {
        match (formula.number(), formula.coefficients()) {
            (2, c) => Dispersion::Sellmeier([c[0], c[2], c[4], c[1], c[3], c[5]]),
            _ => Dispersion::Catalogue(formula),
        }
    }

    /// As catalogues in the AGF form have it; `None` for Cauchy's, which they lack.
    pub fn to_catalogue(&self) -> Option<CatalogueFormula> {
        match self {
            Dispersion::Cauchy(_) => None,
            Dispersion::Sellmeier([b1, b2, b3, c1, c2, c3]) => {
                CatalogueFormula::new(2, &[*b1, *c1, *b2, *c2, *b3, *c3])
            }
            Dispersion::Catalogue(formula) => Some(*formula),
        }
    }

    /// Through `n_d` and the Abbe number `abbe`.
    pub fn from_abbe(n_d: f64, abbe: f64, model: AbbeModel) -> Dispersion {
        let a = |line: f64| 1.0 / (line * line);
        // n_F − n_C.
        let mean = (n_d - 1.0) / abbe;
        let (b, c) = match model {
            AbbeModel::TwoTerm => (mean / (a(LINE_F) - a(LINE_C)), 0.0),
            AbbeModel::NormalLine => {
                // b(aF − aC) + c(aF² − aC²) = n_F − n_C, and the same for g and F times the partial dispersion.
                let partial = (0.6438 - 0.001682 * abbe) * mean;
                let (p, q) = (a(LINE_F) - a(LINE_C), a(LINE_G) - a(LINE_F));
                let (p2, q2) = (p * (a(LINE_F) + a(LINE_C)), q * (a(LINE_G) + a(LINE_F)));
                let determinant = p * q2 - q * p2;
                (
                    (mean * q2 - partial * p2) / determinant,
                    (p * partial - q * mean) / determinant,
                )
            }
        };
        let ad = a(LINE_D);
        Dispersion::Cauchy([n_d - (b + c * ad) * ad, b, c])
    }
}

/// How to make a curve of n_d and V_d; see the module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AbbeModel {
    /// For comparison with programs and data that use it.
    TwoTerm,
    /// For rendering.
    NormalLine,
}

/// The index of the space behind `surface` at `wavelength`; the d line's where the file says nothing about dispersion.
pub fn index_at(surface: &Surface, wavelength: f64, model: AbbeModel) -> f64 {
    match (surface.dispersion, surface.abbe) {
        (Some(formula), _) => formula.index(wavelength),
        (None, Some(abbe)) => Dispersion::from_abbe(surface.index, abbe, model).index(wavelength),
        (None, None) => surface.index,
    }
}

impl Prescription {
    /// Returns `true` if it says anything about dispersion.
    pub fn disperses(&self) -> bool {
        self.surfaces
            .iter()
            .any(|s| s.abbe.is_some() || s.dispersion.is_some())
    }

    /// The same lens for light of `wavelength` µm: its indices are those of that light.
    pub fn at_wavelength(&self, wavelength: f64, model: AbbeModel) -> Prescription {
        let mut lens = self.clone();
        for s in &mut lens.surfaces {
            s.index = index_at(s, wavelength, model);
        }
        lens
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_models_keep_the_numbers_they_are_made_from() {
        for (n, v) in [(1.5168, 64.17), (1.80518, 25.4), (1.48749, 70.4)] {
            for model in [AbbeModel::TwoTerm, AbbeModel::NormalLine] {
                let d = Dispersion::from_abbe(n, v, model);
                assert!((d.index(LINE_D) - n).abs() < 1e-14);
                let abbe = (n - 1.0) / (d.index(LINE_F) - d.index(LINE_C));
                assert!((abbe / v - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_normal_line_is_closer_to_a_real_glass() {
        // N-BK7, Sellmeier coefficients of its data sheet (Schott).
        let glass = Dispersion::Sellmeier([
            1.03961212,
            0.231792344,
            1.01046945,
            0.00600069867,
            0.0200179144,
            103.560653,
        ]);
        // n_d and n_g of the same sheet.
        assert!((glass.index(LINE_D) - 1.5168).abs() < 1e-5);
        assert!((glass.index(LINE_G) - 1.52668).abs() < 1e-5);
        let error = |model| {
            let d = Dispersion::from_abbe(1.5168, 64.17, model);
            [LINE_G, LINE_F, LINE_C]
                .map(|l| (d.index(l) - glass.index(l)).abs())
                .into_iter()
                .fold(0.0, f64::max)
        };
        assert!(
            error(AbbeModel::NormalLine) < 1e-4,
            "{}",
            error(AbbeModel::NormalLine)
        );
        assert!(error(AbbeModel::TwoTerm) > error(AbbeModel::NormalLine));
    }

    #[test]
    fn air_and_glass_without_an_abbe_number_stay_as_they_are() {
        let p = Prescription::parse("50 5 1.5168 64.17 20\n-50 0 1 0 20\n").unwrap();
        let blue = p.at_wavelength(LINE_F, AbbeModel::NormalLine);
        assert!(blue.surfaces[0].index > 1.52 && blue.surfaces[1].index == 1.0);
        assert!(p.disperses());
        let plain = Prescription::parse("50 5 1.5168 20\n-50 0 1 20\n").unwrap();
        assert!(!plain.disperses());
        assert_eq!(plain.at_wavelength(LINE_F, AbbeModel::NormalLine), plain);
    }
}
