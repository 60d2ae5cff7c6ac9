//! Common glasses by name.

use crate::optics::dispersion::{AbbeModel, Dispersion};

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

/// How many glasses are known.
pub const COUNT: usize = GLASSES.len();

/// The glass of this name, whatever its case.
pub fn named(name: &str) -> Option<Glass> {
    if name.is_empty() || name.eq_ignore_ascii_case("AIR") {
        return Some(AIR);
    }
    GLASSES
        .iter()
        .find(|(known, _, _)| known.eq_ignore_ascii_case(name))
        .map(|(known, index, abbe)| Glass {
            index: *index,
            abbe: Some(*abbe),
            formula: FORMULAS
                .iter()
                .find(|(names, _, _)| names.contains(known))
                .map(|(_, coefficients, range)| Formula {
                    dispersion: Dispersion::Sellmeier(*coefficients),
                    range: *range,
                }),
        })
}

/// Names, Sellmeier coefficients and wavelengths (µm) of the materials that ultraviolet lenses are made of, where n_d and V_d
/// say nothing: Malitson, J. Opt. Soc. Am. 55, 1965 (fused silica) and Appl. Opt. 2, 1963 (calcium fluoride); Schott's data
/// sheet of N-BK7.
static FORMULAS: [(&[&str], [f64; 6], [f64; 2]); 3] = [
    (
        &["SILICA", "F_SILICA"],
        [
            0.6961663,
            0.4079426,
            0.8974794,
            0.0046791483,
            0.0135120631,
            97.9340025,
        ],
        [0.21, 3.71],
    ),
    (
        &["CAF2"],
        [
            0.5675888,
            0.4710914,
            3.8484723,
            0.0025264300,
            0.0100783328,
            1200.5559735,
        ],
        [0.23, 9.7],
    ),
    (
        &["N-BK7", "BK7"],
        [
            1.03961212,
            0.231792344,
            1.01046945,
            0.00600069867,
            0.0200179144,
            103.560653,
        ],
        [0.3, 2.5],
    ),
];

/// Name, n_d, V_d: from the makers' catalogs, to the digits they print.
#[rustfmt::skip]
static GLASSES: [(&str, f64, f64); 154] = [
    // Schott.
    ("N-BK7", 1.51680, 64.17),
    ("N-BK10", 1.49782, 66.95),
    ("N-K5", 1.52249, 59.48),
    ("N-KF9", 1.52346, 51.54),
    ("N-ZK7", 1.50847, 61.19),
    ("N-FK5", 1.48749, 70.41),
    ("N-FK51A", 1.48656, 84.47),
    ("N-FK58", 1.45600, 90.90),
    ("N-PK51", 1.52855, 76.98),
    ("N-PK52A", 1.49700, 81.61),
    ("N-PSK3", 1.55232, 63.46),
    ("N-PSK53A", 1.61800, 63.39),
    ("N-BAK1", 1.57250, 57.55),
    ("N-BAK2", 1.53996, 59.71),
    ("N-BAK4", 1.56883, 55.98),
    ("N-SK2", 1.60738, 56.65),
    ("N-SK4", 1.61272, 58.63),
    ("N-SK5", 1.58913, 61.27),
    ("N-SK11", 1.56384, 60.80),
    ("N-SK14", 1.60311, 60.60),
    ("N-SK16", 1.62041, 60.32),
    ("N-SSK2", 1.62229, 53.27),
    ("N-SSK5", 1.65844, 50.88),
    ("N-SSK8", 1.61773, 49.83),
    ("N-BALF4", 1.57956, 53.87),
    ("N-BALF5", 1.54739, 53.63),
    ("N-BAF4", 1.60568, 43.72),
    ("N-BAF10", 1.67003, 47.11),
    ("N-BAF51", 1.65224, 44.96),
    ("N-BAF52", 1.60863, 46.60),
    ("N-BASF2", 1.66446, 36.00),
    ("N-BASF64", 1.70400, 39.38),
    ("LLF1", 1.54814, 45.75),
    ("LF5", 1.58144, 40.85),
    ("N-F2", 1.62005, 36.43),
    ("F2", 1.62004, 36.37),
    ("F5", 1.60342, 38.03),
    ("N-SF1", 1.71736, 29.62),
    ("SF1", 1.71736, 29.51),
    ("N-SF2", 1.64769, 33.82),
    ("SF2", 1.64769, 33.85),
    ("N-SF4", 1.75513, 27.38),
    ("SF4", 1.75520, 27.58),
    ("N-SF5", 1.67271, 32.25),
    ("SF5", 1.67270, 32.21),
    ("N-SF6", 1.80518, 25.36),
    ("SF6", 1.80518, 25.43),
    ("N-SF8", 1.68894, 31.31),
    ("N-SF10", 1.72828, 28.53),
    ("SF10", 1.72825, 28.41),
    ("N-SF11", 1.78472, 25.68),
    ("SF11", 1.78472, 25.76),
    ("N-SF14", 1.76182, 26.53),
    ("N-SF15", 1.69892, 30.20),
    ("N-SF57", 1.84666, 23.78),
    ("SF57", 1.84666, 23.83),
    ("N-SF66", 1.92286, 20.88),
    ("N-KZFS2", 1.55836, 54.01),
    ("N-KZFS4", 1.61336, 44.49),
    ("N-KZFS5", 1.65412, 39.70),
    ("N-KZFS8", 1.72047, 34.70),
    ("N-KZFS11", 1.63775, 42.41),
    ("N-LAK7", 1.65160, 58.52),
    ("N-LAK8", 1.71300, 53.83),
    ("N-LAK9", 1.69100, 54.71),
    ("N-LAK10", 1.72003, 50.62),
    ("N-LAK12", 1.67790, 55.20),
    ("N-LAK14", 1.69680, 55.41),
    ("N-LAK21", 1.64049, 60.10),
    ("N-LAK22", 1.65113, 55.89),
    ("N-LAK33B", 1.75500, 52.30),
    ("N-LAK34", 1.72916, 54.50),
    ("N-LAF2", 1.74397, 44.85),
    ("N-LAF7", 1.74950, 34.82),
    ("N-LAF21", 1.78800, 47.49),
    ("N-LAF33", 1.78582, 44.05),
    ("N-LAF34", 1.77250, 49.62),
    ("N-LAF35", 1.74330, 49.40),
    ("N-LASF9", 1.85025, 32.17),
    ("N-LASF31A", 1.88300, 40.76),
    ("N-LASF40", 1.83404, 37.30),
    ("N-LASF41", 1.83501, 43.13),
    ("N-LASF43", 1.80610, 40.61),
    ("N-LASF44", 1.80420, 46.50),
    ("N-LASF45", 1.80107, 34.97),
    ("N-LASF46A", 1.90366, 31.32),
    // Ohara.
    ("S-BSL7", 1.51633, 64.14),
    ("S-NSL36", 1.51742, 52.43),
    ("S-FSL5", 1.48749, 70.24),
    ("S-FPL51", 1.49700, 81.55),
    ("S-FPL53", 1.43875, 94.95),
    ("S-PHM52", 1.61800, 63.33),
    ("S-BAL14", 1.56883, 56.36),
    ("S-BAL35", 1.58913, 61.14),
    ("S-BAM4", 1.60562, 43.71),
    ("S-BSM14", 1.60311, 60.64),
    ("S-BSM16", 1.62041, 60.29),
    ("S-TIL1", 1.54814, 45.78),
    ("S-TIL6", 1.53172, 48.84),
    ("S-TIM2", 1.62004, 36.26),
    ("S-TIM8", 1.59551, 39.24),
    ("S-TIM22", 1.64769, 33.79),
    ("S-TIM28", 1.68893, 31.08),
    ("S-TIH1", 1.71736, 29.52),
    ("S-TIH4", 1.75520, 27.51),
    ("S-TIH6", 1.80518, 25.43),
    ("S-TIH11", 1.78472, 25.68),
    ("S-TIH13", 1.74077, 27.79),
    ("S-TIH53", 1.84666, 23.78),
    ("S-LAL7", 1.65160, 58.55),
    ("S-LAL8", 1.71299, 53.87),
    ("S-LAL12", 1.67790, 55.34),
    ("S-LAL14", 1.69680, 55.53),
    ("S-LAL18", 1.72916, 54.68),
    ("S-LAM3", 1.71700, 47.93),
    ("S-LAM60", 1.74320, 49.34),
    ("S-LAH51", 1.78590, 44.20),
    ("S-LAH53", 1.80610, 40.93),
    ("S-LAH58", 1.88300, 40.77),
    ("S-LAH60", 1.83400, 37.16),
    ("S-LAH66", 1.77250, 49.60),
    ("S-LAH79", 2.00330, 28.27),
    ("S-NPH1", 1.80809, 22.76),
    ("S-NPH2", 1.92286, 18.90),
    // Hoya.
    ("BSC7", 1.51680, 64.20),
    ("FC5", 1.48749, 70.44),
    ("FCD1", 1.49700, 81.61),
    ("E-FD1", 1.71736, 29.50),
    ("E-FD4", 1.75520, 27.53),
    ("E-FD10", 1.72825, 28.32),
    ("E-FD15", 1.69895, 30.05),
    ("FD60", 1.80518, 25.46),
    ("FDS90", 1.84666, 23.78),
    ("BACD16", 1.62041, 60.34),
    ("TAC8", 1.72916, 54.67),
    ("TAF1", 1.77250, 49.62),
    ("TAFD5F", 1.83481, 42.72),
    ("TAFD30", 1.88300, 40.81),
    // Schott's names before 1998 that files still use.
    ("BK7", 1.51680, 64.17),
    ("K5", 1.52249, 59.48),
    ("BAK4", 1.56883, 56.13),
    ("SK16", 1.62041, 60.33),
    ("SSK5", 1.65844, 50.88),
    ("LAK8", 1.71300, 53.83),
    ("LAK9", 1.69100, 54.71),
    ("FK5", 1.48749, 70.41),
    ("BAF10", 1.67003, 47.11),
    // Fused silica, crystals, plastics.
    ("SILICA", 1.45846, 67.82),
    ("F_SILICA", 1.45846, 67.82),
    ("CAF2", 1.43385, 95.23),
    ("PMMA", 1.49176, 57.44),
    ("ACRYLIC", 1.49176, 57.44),
    ("POLYCARB", 1.58547, 29.91),
    ("POLYSTYR", 1.59048, 30.87),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::dispersion::{LINE_C, LINE_D, LINE_F};

    #[test]
    fn names_are_found_once_and_have_the_numbers_of_glasses() {
        for (i, (name, index, abbe)) in GLASSES.iter().enumerate() {
            assert!(GLASSES[..i].iter().all(|(n, _, _)| n != name), "{name}");
            assert!(
                (1.4..2.1).contains(index) && (17.0..100.0).contains(abbe),
                "{name}"
            );
        }
        assert_eq!(named("n-bk7").map(|g| g.index), Some(1.5168));
        assert_eq!(named("air"), Some(AIR));
        assert_eq!(named("NO-SUCH"), None);
    }

    #[test]
    fn formulas_are_those_of_their_glasses() {
        for (names, _, _) in &FORMULAS {
            for name in *names {
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
