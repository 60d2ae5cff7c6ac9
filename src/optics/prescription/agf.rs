//! Glass catalogues in the AGF form, which Zemax reads and glass makers publish (`SCHOTT.AGF`).
//!
//! Lines of a keyword and values. What is read of a glass: `NM name formula code n_d V_d …`, which begins it, `CD` the
//! coefficients of its formula ([`catalogue_formula`](crate::optics::catalogue_formula)), `LD` the wavelengths it is good for, µm.
//! A glass without a formula that gives an index of light at the d line is left out, and nothing is said of it until a lens asks for
//! it. Indices are relative to air at the catalogue's temperature.

use super::INDICES;
use super::cells::lines;
use super::glass::{Formula, Glass};
use crate::optics::catalogue_formula::{COEFFICIENTS, CatalogueFormula};
use crate::optics::dispersion::{Dispersion, LINE_D};
use std::collections::HashMap;
use std::fmt::Write;

/// What a formula whose file does not say is good for, µm: what is seen.
pub(super) const VISIBLE: [f64; 2] = [0.36, 0.83];

/// The glasses of a catalogue by their names in capitals.
pub fn parse(text: &str) -> HashMap<String, Glass> {
    let mut glasses = HashMap::new();
    let mut entry = Entry::default();
    for (_, line) in lines(text) {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("NM") => {
                entry.finish(&mut glasses);
                entry = Entry::named(&words.collect::<Vec<_>>());
            }
            Some("CD") => {
                // They end at the first word that is not a number; Zemax pads with zeros.
                let numbers = words.map_while(|word| word.parse().ok());
                let mut numbers: Vec<f64> = numbers.take(2 * COEFFICIENTS).collect();
                while numbers.len() > COEFFICIENTS && numbers.last() == Some(&0.0) {
                    numbers.pop();
                }
                entry.coefficients = numbers;
            }
            Some("LD") => {
                let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
                if let [shortest, longest] = numbers[..] {
                    entry.range = [shortest, longest];
                }
            }
            _ => {}
        }
    }
    entry.finish(&mut glasses);
    glasses
}

/// One glass as far as its lines have been read.
#[derive(Default)]
struct Entry {
    name: String,
    /// V_d; 0 where it is not given.
    abbe: f64,
    formula: u8,
    coefficients: Vec<f64>,
    range: [f64; 2],
}

impl Entry {
    /// Of the words behind `NM`.
    fn named(words: &[&str]) -> Entry {
        let formula = words.get(1).and_then(|word| word.parse::<f64>().ok());
        Entry {
            name: words.first().unwrap_or(&"").to_ascii_uppercase(),
            // Some programs write it as 2.0; no other fraction numbers a formula.
            formula: formula.map_or(0, |number| number as u8),
            abbe: words.get(4).and_then(|v| v.parse().ok()).unwrap_or(0.0),
            range: VISIBLE,
            ..Entry::default()
        }
    }

    /// The first of a name stays.
    fn finish(self, glasses: &mut HashMap<String, Glass>) {
        if let Some(glass) = self.glass() {
            glasses.entry(self.name).or_insert(glass);
        }
    }

    fn glass(&self) -> Option<Glass> {
        let formula = CatalogueFormula::new(self.formula, &self.coefficients)?;
        let dispersion = Dispersion::of_catalogue(formula);
        let index = dispersion.index(LINE_D);
        let [shortest, longest] = self.range;
        let known = !self.coefficients.is_empty() && INDICES.contains(&index);
        let ordered = shortest < longest;
        if !known || !ordered {
            return None;
        }
        Some(Glass {
            index,
            // Infrared materials have no glass code.
            abbe: Some(self.abbe).filter(|v| v.is_finite() && *v > 0.0),
            formula: Some(Formula {
                dispersion,
                range: self.range,
            }),
        })
    }
}

/// The lines of a glass in a catalogue; `None` for a formula that catalogues lack.
pub(super) fn entry(name: &str, dispersion: &Dispersion, abbe: Option<f64>) -> Option<String> {
    let formula = dispersion.to_catalogue()?;
    let (number, index) = (formula.number(), dispersion.index(LINE_D));
    let abbe = abbe.unwrap_or(0.0);
    let mut text = format!("NM {name} {number} 0 {index} {abbe} 0 -1 -1\nCD");
    for coefficient in formula.coefficients() {
        let _ = write!(text, " {coefficient:e}");
    }
    let [shortest, longest] = VISIBLE;
    let _ = writeln!(text, "\nLD {shortest} {longest}");
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// N-BK7 and F2 of Schott's data sheets, and a plastic by the formula Extended 2, as catalogues have them.
    const CATALOGUE: &str = "CC test\r\nNM N-BK7 2 517642.251 1.5168 64.17 0 1 -1\r\nGC comment\r\nED 7.1 8.3 2.51 -0.0009 0\r\n\
        CD 1.03961212E+00 6.00069867E-03 2.31792344E-01 2.00179144E-02 1.01046945E+00 1.03560653E+02 0 0 0 0 0 0\r\n\
        TD 1.86E-06 1.31E-08 -1.37E-11 4.34E-07 6.27E-10 1.7E-01 20\r\nLD 3.0000000E-01 2.500000E+00\r\nIT 0.3 0.05 25\r\n\
        NM f2 2 620364.360 1.62004 36.37 0 0 -1\r\nCD 1.34533359 0.00997743871 0.209073176 0.0470450767 0.937357162 111.886764\r\n\
        NM NOTHING 0 0 1.5 50\r\nNM BROKEN 2 0 1.5 50\r\nCD x\r\nNM TWICE 5 0\r\nCD 1.5 0.01\r\nNM TWICE 5 0\r\nCD 1.7 0.01\r\n";

    #[test]
    fn a_catalogue_gives_its_glasses() {
        let glasses = parse(CATALOGUE);
        assert_eq!(glasses.len(), 3, "{glasses:?}");
        let bk7 = glasses["N-BK7"];
        assert!((bk7.index - 1.5168).abs() < 5e-7 && bk7.abbe == Some(64.17));
        assert_eq!(bk7.formula.unwrap().range, [0.3, 2.5]);
        let f2 = glasses["F2"];
        assert!((f2.index - 1.62004).abs() < 5e-6 && f2.abbe == Some(36.37));
        assert_eq!(f2.formula.unwrap().range, VISIBLE);
        assert!((glasses["TWICE"].index - 1.51702).abs() < 1e-5);
    }

    #[test]
    fn what_is_written_is_read() {
        let glass = parse(CATALOGUE)["N-BK7"];
        let formula = glass.formula.unwrap().dispersion;
        let text = entry("X", &formula, glass.abbe).unwrap();
        let back = parse(&text)["X"];
        assert_eq!(back.formula.unwrap().dispersion, formula);
        assert_eq!((back.index, back.abbe), (glass.index, glass.abbe));
        assert_eq!(entry("X", &Dispersion::Cauchy([1.5, 0.0, 0.0]), None), None);
    }

    proptest! {
        /// Whatever the text, reading ends, and its glasses refract.
        #[test]
        fn reading_never_panics(words in prop::collection::vec("NM|CD|LD|\n|\n|[A-Z]{1,2}|-?[0-9]{1,3}|1e-?[0-9]{3}|nan|é", 0..60)) {
            for glass in parse(&words.join(" ")).values() {
                prop_assert!(INDICES.contains(&glass.index));
            }
        }
    }
}
