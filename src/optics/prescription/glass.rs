//! Common glasses by name.

use crate::optics::dispersion::{AbbeModel, Dispersion};
use std::sync::LazyLock;

/// A medium at the d line, and what is known of it at others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glass {
    /// Refractive index n_d.
    pub index: f64,
    /// Abbe number V_d; `None` for a medium without dispersion.
    pub abbe: Option<f64>,
    /// A dispersion formula better than what follows from those two.
    pub formula: Option<Formula>,
}

/// A dispersion formula, and where it was fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Formula {
    /// The formula.
    pub dispersion: Dispersion,
    /// Shortest and longest wavelength, µm.
    pub range: [f64; 2],
}

impl Glass {
    /// The formula for other wavelengths than the d line: the glass's own, or a curve through n_d and V_d, which is good from
    /// the violet mercury line to the red helium line. `None` for a medium without dispersion.
    pub fn dispersion(&self) -> Option<Formula> {
        let visible = |abbe| Formula {
            dispersion: Dispersion::from_abbe(self.index, abbe, AbbeModel::NormalLine),
            range: [0.4047, 0.7065],
        };
        self.formula.or(self.abbe.map(visible))
    }
}

/// What is between lenses.
pub const AIR: Glass = Glass {
    index: 1.0,
    abbe: None,
    formula: None,
};

/// The known glasses with their names; the file says where its numbers are from.
static GLASSES: LazyLock<Vec<(&str, Glass)>> = LazyLock::new(|| {
    include_str!("glasses.txt")
        .lines()
        .filter_map(row)
        .collect()
});

/// A line of the file: name, n_d, V_d, and for some the coefficients and the range of a formula.
fn row(line: &str) -> Option<(&str, Glass)> {
    let (name, numbers) = line.split_once(' ').filter(|(name, _)| *name != "#")?;
    let numbers: Option<Vec<f64>> = numbers.split_whitespace().map(|n| n.parse().ok()).collect();
    let (index, abbe, formula) = match numbers?[..] {
        [index, abbe] => (index, abbe, None),
        [index, abbe, b1, b2, b3, c1, c2, c3, shortest, longest] => {
            let dispersion = Dispersion::Sellmeier([b1, b2, b3, c1, c2, c3]);
            let range = [shortest, longest];
            (index, abbe, Some(Formula { dispersion, range }))
        }
        _ => return None,
    };
    let abbe = Some(abbe);
    Some((
        name,
        Glass {
            index,
            abbe,
            formula,
        },
    ))
}

impl Default for Glass {
    fn default() -> Glass {
        AIR
    }
}

/// How many glasses are known.
pub fn count() -> usize {
    GLASSES.len()
}

/// The glass of this name, whatever its case.
pub fn named(name: &str) -> Option<Glass> {
    if name.is_empty() || name.eq_ignore_ascii_case("AIR") {
        return Some(AIR);
    }
    let mut glasses = GLASSES.iter();
    let (_, glass) = glasses.find(|(known, _)| known.eq_ignore_ascii_case(name))?;
    Some(*glass)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::dispersion::{LINE_C, LINE_D, LINE_F};

    #[test]
    fn names_are_found_once_and_have_the_numbers_of_glasses() {
        let rows = include_str!("glasses.txt").lines();
        let rows = rows.filter(|line| !line.is_empty() && !line.starts_with('#'));
        assert_eq!((count(), rows.count()), (154, 154));
        for (i, (name, glass)) in GLASSES.iter().enumerate() {
            assert!(GLASSES[..i].iter().all(|(n, _)| n != name), "{name}");
            let abbe = glass.abbe.unwrap();
            assert!(
                (1.4..2.1).contains(&glass.index) && (17.0..100.0).contains(&abbe),
                "{name}"
            );
        }
        assert_eq!(named("n-bk7").map(|g| g.index), Some(1.5168));
        assert_eq!(named("air"), Some(AIR));
        assert_eq!(named("NO-SUCH"), None);
    }

    #[test]
    fn formulas_are_those_of_their_glasses() {
        for name in ["SILICA", "F_SILICA", "CAF2", "N-BK7", "BK7"] {
            let glass = named(name).unwrap();
            let formula = glass.formula.unwrap().dispersion;
            // Catalogues differ by a few 1e-5 from the papers.
            assert!((formula.index(LINE_D) - glass.index).abs() < 3e-5, "{name}");
            let abbe = (glass.index - 1.0) / (formula.index(LINE_F) - formula.index(LINE_C));
            assert!(
                (abbe / glass.abbe.unwrap() - 1.0).abs() < 5e-3,
                "{name} {abbe}"
            );
        }
        // Both papers' own tables at the mercury line 0.248272 µm and at 0.24827 µm.
        let at = |name| {
            named(name)
                .unwrap()
                .formula
                .unwrap()
                .dispersion
                .index(0.248272)
        };
        assert!((at("SILICA") - 1.50841).abs() < 5e-5, "{}", at("SILICA"));
        assert!((at("CAF2") - 1.46793).abs() < 5e-5, "{}", at("CAF2"));
    }

    #[test]
    fn a_name_of_six_digits_agrees_with_its_numbers() {
        // The international code of F2 is 620364, of SF6 805254.
        for (name, code) in [
            ("F2", [620, 364]),
            ("SF6", [805, 254]),
            ("SK16", [620, 603]),
        ] {
            let g = named(name).unwrap();
            assert_eq!(((g.index - 1.0) * 1000.0).round() as i32, code[0]);
            assert_eq!((g.abbe.unwrap() * 10.0).round() as i32, code[1]);
        }
    }
}
