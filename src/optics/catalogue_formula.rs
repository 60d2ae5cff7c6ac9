//! The dispersion formulas of glass catalogues.
//!
//! Catalogues in the AGF form number their formulas from 1 to 13 (OpticStudio's help, "Using Glass Catalogs"; the same
//! numbers in the open catalogues of the makers). λ in micrometers, c the coefficients in the file's order, c₀ first:
//!
//! | number | name | formula |
//! |---|---|---|
//! | 1 | Schott | n² = c₀ + c₁λ² + c₂λ⁻² + c₃λ⁻⁴ + c₄λ⁻⁶ + c₅λ⁻⁸ |
//! | 2, 6, 11 | Sellmeier 1, 3, 5 | n² = 1 + Σ c₂ᵢ λ²/(λ² − c₂ᵢ₊₁), of 3, 4 and 5 terms |
//! | 3 | Herzberger | n = c₀ + c₁L + c₂L² + c₃λ² + c₄λ⁴ + c₅λ⁶, L = 1/(λ² − 0.028) |
//! | 4 | Sellmeier 2 | n² = 1 + c₀ + c₁λ²/(λ² − c₂²) + c₃/(λ² − c₄²) |
//! | 5 | Conrady | n = c₀ + c₁/λ + c₂/λ^3.5 |
//! | 7 | Handbook of Optics 1 | n² = c₀ + c₁/(λ² − c₂) − c₃λ² |
//! | 8 | Handbook of Optics 2 | n² = c₀ + c₁λ²/(λ² − c₂) − c₃λ² |
//! | 9 | Sellmeier 4 | n² = c₀ + c₁λ²/(λ² − c₂) + c₃λ²/(λ² − c₄) |
//! | 10 | Extended | Schott's + c₆λ⁻¹⁰ + c₇λ⁻¹² |
//! | 12 | Extended 2 | Schott's + c₆λ⁴ + c₇λ⁶ |
//! | 13 | Extended 3 | n² = c₀ + c₁λ² + c₂λ⁴ + c₃λ⁻² + c₄λ⁻⁴ + c₅λ⁻⁶ + c₆λ⁻⁸ + c₇λ⁻¹⁰ + c₈λ⁻¹² |

/// Most coefficients that a formula has.
pub const COEFFICIENTS: usize = 10;

/// One of the formulas with its coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CatalogueFormula {
    number: u8,
    coefficients: [f64; COEFFICIENTS],
}

impl CatalogueFormula {
    /// The formula of this number with these coefficients, the missing ones 0; `None` where there is no such number or they are too
    /// many.
    pub fn new(number: u8, coefficients: &[f64]) -> Option<CatalogueFormula> {
        if !(1..=13).contains(&number) || coefficients.len() > COEFFICIENTS {
            return None;
        }
        let mut all = [0.0; COEFFICIENTS];
        all[..coefficients.len()].copy_from_slice(coefficients);
        Some(CatalogueFormula {
            number,
            coefficients: all,
        })
    }

    /// Its number in the AGF form, 1 to 13.
    pub fn number(&self) -> u8 {
        self.number
    }

    /// Its coefficients, in the AGF form's order.
    pub fn coefficients(&self) -> &[f64; COEFFICIENTS] {
        &self.coefficients
    }

    /// The index at `wavelength` µm; not a number where the formula has none.
    pub fn index(&self, wavelength: f64) -> f64 {
        let c = &self.coefficients;
        let l2 = wavelength * wavelength;
        let sellmeier = |terms: usize| {
            let term = |i: usize| c[2 * i] * l2 / (l2 - c[2 * i + 1]);
            1.0 + (0..terms).map(term).sum::<f64>()
        };
        // Polynomials in λ²: of `c` from the first, by powers.
        let powers = |powers: &[i32]| {
            let terms = powers.iter().zip(c);
            terms.map(|(p, c)| c * l2.powi(*p)).sum::<f64>()
        };
        let square = match self.number {
            1 => powers(&[0, 1, -1, -2, -3, -4]),
            2 => sellmeier(3),
            3 => {
                let l = 1.0 / (l2 - 0.028);
                return c[0] + (c[1] + c[2] * l) * l + (c[3] + (c[4] + c[5] * l2) * l2) * l2;
            }
            4 => 1.0 + c[0] + c[1] * l2 / (l2 - c[2] * c[2]) + c[3] / (l2 - c[4] * c[4]),
            5 => return c[0] + c[1] / wavelength + c[2] / wavelength.powf(3.5),
            6 => sellmeier(4),
            7 => c[0] + c[1] / (l2 - c[2]) - c[3] * l2,
            8 => c[0] + c[1] * l2 / (l2 - c[2]) - c[3] * l2,
            9 => c[0] + c[1] * l2 / (l2 - c[2]) + c[3] * l2 / (l2 - c[4]),
            10 => powers(&[0, 1, -1, -2, -3, -4, -5, -6]),
            11 => sellmeier(5),
            12 => powers(&[0, 1, -1, -2, -3, -4, 2, 3]),
            _ => powers(&[0, 1, 2, -1, -2, -3, -4, -5, -6]),
        };
        square.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn index(number: u8, coefficients: &[f64], wavelength: f64) -> f64 {
        let formula = CatalogueFormula::new(number, coefficients).unwrap();
        formula.index(wavelength)
    }

    /// Schott's data sheet of N-BK7 and its older one of BK7 by the Schott formula: both give n_d = 1.51680 and n_F = 1.52238.
    #[test]
    fn two_formulas_of_one_glass_agree() {
        let sellmeier = [
            1.03961212,
            0.00600069867,
            0.231792344,
            0.0200179144,
            1.01046945,
            103.560653,
        ];
        let schott = [
            2.2718929,
            -1.0108077e-2,
            1.0592509e-2,
            2.0816965e-4,
            -7.6472538e-6,
            4.9240991e-7,
        ];
        for (wavelength, expected) in [(0.5875618, 1.51680), (0.4861327, 1.52238)] {
            for (number, c) in [(2, sellmeier), (1, schott)] {
                let n = index(number, &c, wavelength);
                // Data sheets have five digits, the formulas differ by one in the sixth.
                assert!(
                    (n - expected).abs() < 8e-6,
                    "formula {number} at {wavelength}: {n}"
                );
            }
        }
    }

    /// Each formula with numbers that make its terms easy: at 0.5 µm λ² = 1/4, λ⁻² = 4.
    #[test]
    fn every_term_stands_where_it_should() {
        let square = |number, c: &[f64]| index(number, c, 0.5).powi(2);
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * b.abs(), "{a} {b}");
        let one = |i: usize| {
            let mut c = [0.0; 10];
            c[i] = 1.0;
            c
        };
        for (number, powers) in [
            (1, &[0, 1, -1, -2, -3, -4][..]),
            (10, &[0, 1, -1, -2, -3, -4, -5, -6]),
            (12, &[0, 1, -1, -2, -3, -4, 2, 3]),
            (13, &[0, 1, 2, -1, -2, -3, -4, -5, -6]),
        ] {
            for (i, power) in powers.iter().enumerate() {
                close(square(number, &one(i)), 0.25f64.powi(*power));
            }
        }
        // Poles at λ² = 1/8: each term is 2, or 8 where λ² is not in front.
        close(square(2, &[1.0, 0.125, 2.0, 0.125, 3.0, 0.125]), 13.0);
        close(
            square(6, &[1.0, 0.125, 1.0, 0.125, 1.0, 0.125, 1.0, 0.125]),
            9.0,
        );
        close(
            square(
                11,
                &[1.0, 0.125, 1.0, 0.125, 1.0, 0.125, 1.0, 0.125, 1.0, 0.125],
            ),
            11.0,
        );
        let pole = 0.125f64.sqrt();
        close(square(4, &[1.0, 1.0, pole, 1.0, pole]), 12.0);
        close(square(7, &[3.0, 1.0, 0.125, 4.0]), 10.0);
        close(square(8, &[3.0, 1.0, 0.125, 4.0]), 4.0);
        close(square(9, &[3.0, 1.0, 0.125, 1.0, 0.125]), 7.0);
        // L = 1/0.222.
        let l: f64 = 1.0 / 0.222;
        close(
            index(3, &[1.0, 1.0, 1.0, 4.0, 16.0, 64.0], 0.5),
            4.0 + l + l * l,
        );
        close(index(5, &[1.0, 1.0, 1.0], 0.5), 3.0 + 2f64.powf(3.5));
    }

    #[test]
    fn no_other_numbers() {
        assert!(
            CatalogueFormula::new(0, &[]).is_none() && CatalogueFormula::new(14, &[]).is_none()
        );
        assert!(CatalogueFormula::new(1, &[0.0; 11]).is_none());
    }
}
