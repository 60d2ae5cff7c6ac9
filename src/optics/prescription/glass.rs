//! Glasses by name: those of catalogues beside a lens, and those of the makers' catalogs that are known without a file.

use super::{INDICES, agf, design};
use crate::files;
use crate::optics::dispersion::{AbbeModel, Dispersion, LINE_C, LINE_D, LINE_F};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
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

/// The makers' glasses by their names in capitals; the file says where its numbers are from.
static MAKERS: LazyLock<HashMap<String, Glass>> =
    LazyLock::new(|| agf::parse(include_str!("makers.agf")));

/// Those that are in no maker's catalog: old names, crystals, plastics.
static OTHERS: LazyLock<Vec<(&str, Glass)>> = LazyLock::new(|| {
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
    MAKERS.len() + OTHERS.len()
}

/// The glass of this name, whatever its case.
pub fn named(name: &str) -> Option<Glass> {
    if name.is_empty() || name.eq_ignore_ascii_case("AIR") {
        return Some(AIR);
    }
    let is_it = |(known, _): &&(&str, Glass)| known.eq_ignore_ascii_case(name);
    let other = OTHERS.iter().find(is_it).map(|(_, glass)| *glass);
    other.or_else(|| MAKERS.get(&name.to_ascii_uppercase()).copied())
}

/// What ends the names of pressed glasses in some catalogues.
const PRESSED: &str = "_MOLD";

/// Where the names of a lens file are looked up: in catalogues, then among those known without one.
#[derive(Clone, Debug, Default)]
pub struct Glasses {
    catalogues: Vec<HashMap<String, Glass>>,
}

/// The environment variable that names folders of catalogues, or catalogues, as `PATH` names folders of programs.
pub const PATH_VARIABLE: &str = "FSTOP_GLASS_PATH";

/// The largest file taken for a catalogue, in bytes; those of the makers have 300 kB.
const LARGEST_CATALOGUE: u64 = 8 << 20;
/// Most catalogue files: nobody has more of their own.
const MOST_CATALOGUES: usize = 100;

impl Glasses {
    /// Those known without a file alone.
    pub const COMMON: Glasses = Glasses {
        catalogues: Vec::new(),
    };

    /// With the catalogues (`.agf`) in the folder of `lens`, and those that the environment names. What cannot be read is passed
    /// over: a lens that needs it says which glass is missing.
    pub fn beside(lens: &Path) -> Glasses {
        let mut files = catalogues_in(lens.parent().unwrap_or(Path::new("")));
        for place in std::env::split_paths(&std::env::var_os(PATH_VARIABLE).unwrap_or_default()) {
            match place.is_dir() {
                true => files.extend(catalogues_in(&place)),
                false => files.push(place),
            }
        }
        files.truncate(MOST_CATALOGUES);
        let read = |file: &PathBuf| files::read(file, LARGEST_CATALOGUE).ok();
        let texts = files.iter().filter_map(read);
        Glasses {
            catalogues: texts
                .map(|bytes| agf::parse(&design::decode(&bytes)))
                .collect(),
        }
    }

    /// With the glasses of this catalogue, which go first.
    pub fn with(mut self, catalogue: HashMap<String, Glass>) -> Glasses {
        self.catalogues.insert(0, catalogue);
        self
    }

    /// The glass of this name, whatever its case: of the first catalogue that has it, a maker's, or of a code, the digits of n_d
    /// − 1 and of the Abbe number in hundreds: 517642, 517.642, 51680.6417.
    pub fn named(&self, name: &str) -> Option<Glass> {
        let upper = name.to_ascii_uppercase();
        let known = self.catalogues.iter().find_map(|c| c.get(&upper)).copied();
        known.or_else(|| named(name)).or_else(|| of_code(name))
    }

    /// The glass that one of this name is pressed from (`L-TIM28_MOLD` from L-TIM28): pressing changes n_d by some
    /// thousandths.
    pub fn unpressed(&self, name: &str) -> Option<Glass> {
        self.named(name.strip_suffix(PRESSED)?)
    }
}

/// The catalogues in a folder, by name. Files that lie there, not links to others elsewhere.
fn catalogues_in(folder: &Path) -> Vec<PathBuf> {
    let folder = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_catalogue = |entry: &std::fs::DirEntry| {
        let path = entry.path();
        let ending = path.extension().unwrap_or_default();
        ending.eq_ignore_ascii_case("agf") && entry.file_type().is_ok_and(|kind| kind.is_file())
    };
    let mut files: Vec<PathBuf> = entries.filter(is_catalogue).map(|e| e.path()).collect();
    files.sort();
    files
}

/// The glass of a code: six digits, or some on both sides of a point, those of n_d − 1 and of V_d/100.
fn of_code(name: &str) -> Option<Glass> {
    let (n, v) = match name.split_once('.') {
        Some(parts) => parts,
        None if name.len() == 6 => name.split_at_checked(3)?,
        None => return None,
    };
    let are_digits =
        |text: &&str| (3..=9).contains(&text.len()) && text.bytes().all(|b| b.is_ascii_digit());
    let [n, v] = [Some(n).filter(are_digits)?, Some(v).filter(are_digits)?];
    let (tens, rest) = v.split_at_checked(2)?;
    Some(Glass {
        index: format!("1.{n}").parse().ok()?,
        abbe: format!("{tens}.{rest}").parse().ok().filter(|v| *v > 0.0),
        formula: None,
    })
}

/// The glass of indices at some wavelengths, [µm, n], by straight lines over 1/λ² between them: that of normal dispersion is nearly one.
/// Without dispersion where the lines F and C are not between the samples; `None` where there are none.
pub(super) fn of_samples(samples: &[[f64; 2]]) -> Option<Glass> {
    let x = |wavelength: f64| 1.0 / (wavelength * wavelength);
    let mut points: Vec<[f64; 2]> = samples.iter().map(|[w, n]| [x(*w), *n]).collect();
    points.retain(|[x, n]| x.is_finite() && INDICES.contains(n));
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    points.dedup_by(|a, b| a[0] == b[0]);
    let at = |wavelength: f64| {
        // Files round lines to three digits and more.
        let between = |pair: &&[[f64; 2]]| {
            (pair[0][0] * (1.0 - 2e-3)..=pair[1][0] * (1.0 + 2e-3)).contains(&x(wavelength))
        };
        let pair = points.windows(2).find(between)?;
        let t = (x(wavelength) - pair[0][0]) / (pair[1][0] - pair[0][0]);
        Some(pair[0][1] + t * (pair[1][1] - pair[0][1]))
    };
    let spread = at(LINE_F).zip(at(LINE_C)).map(|(f, c)| f - c);
    let index = at(LINE_D).or(points.first().map(|p| p[1]))?;
    let abbe = spread.map(|spread| (index - 1.0) / spread);
    Some(Glass {
        index,
        abbe: abbe.filter(|v| v.is_finite() && *v > 0.0),
        formula: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_at_lines_make_a_glass() {
        // N-BK7 at d, F and C, rounded as in files.
        let glass =
            of_samples(&[[0.58756, 1.5168], [0.48613, 1.52238], [0.65627, 1.51432]]).unwrap();
        assert!((glass.index - 1.5168).abs() < 1e-6, "{glass:?}");
        // The difference of two numbers of five digits.
        assert!((glass.abbe.unwrap() - 64.17).abs() < 0.1, "{glass:?}");
        let one = of_samples(&[[0.5, 1.6]]).unwrap();
        assert_eq!((one.index, one.abbe), (1.6, None));
        assert_eq!(of_samples(&[[0.0, 1.6], [0.5, 0.0], [f64::NAN, 1.5]]), None);
    }

    #[test]
    fn codes_and_catalogues_are_found() {
        let of = |name: &str| Glasses::COMMON.named(name).map(|g| (g.index, g.abbe));
        assert_eq!(of("517642"), Some((1.517, Some(64.2))));
        assert_eq!(of("620.364"), Some((1.62, Some(36.4))));
        assert_eq!(of("62041.60323"), Some((1.62041, Some(60.323))));
        for wrong in ["51764", "5176421", "517.64", "51764x", "é517", "1.5168", ""] {
            assert!(of(wrong).is_none() || wrong.is_empty(), "{wrong}");
        }
        let own = agf::parse("NM N-BK7 5 0\nCD 1.6\n");
        let glasses = Glasses::COMMON.with(own);
        assert_eq!(glasses.named("n-bk7").map(|g| g.index), Some(1.6));
        assert_eq!(glasses.named("N-SK16"), named("N-SK16"));
    }

    #[test]
    fn catalogues_lie_beside_the_lens() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("own.AGF"), "NM OWN 5 0\nCD 1.6\n").unwrap();
        std::fs::write(folder.path().join("other.txt"), "NM OTHER 5 0\nCD 1.6\n").unwrap();
        let glasses = Glasses::beside(&folder.path().join("lens.zmx"));
        assert_eq!(glasses.named("own").map(|g| g.index), Some(1.6));
        assert_eq!(glasses.named("other"), None);
    }

    #[test]
    fn names_are_found_once_and_have_the_numbers_of_glasses() {
        let rows = include_str!("glasses.txt").lines();
        let rows = rows.filter(|line| !line.is_empty() && !line.starts_with('#'));
        assert_eq!((OTHERS.len(), rows.count()), (12, 12));
        let entries = include_str!("makers.agf").lines();
        let entries = entries.filter(|line| line.starts_with("NM"));
        assert_eq!((MAKERS.len(), entries.count()), (1582, 1582));
        let others = OTHERS.iter().map(|(name, glass)| (*name, glass));
        let makers = MAKERS.iter().map(|(name, glass)| (&name[..], glass));
        for (name, glass) in others.chain(makers) {
            let abbe = glass.abbe.unwrap();
            assert!(
                (1.4..2.2).contains(&glass.index) && (15.0..100.0).contains(&abbe),
                "{name}"
            );
        }
        for (i, (name, _)) in OTHERS.iter().enumerate() {
            let all = OTHERS[..i].iter().map(|(n, _)| *n);
            assert!(
                all.clone().all(|n| n != *name) && !MAKERS.contains_key(*name),
                "{name}"
            );
        }
        assert!((named("n-bk7").unwrap().index - 1.5168).abs() < 5e-6);
        assert_eq!(named("air"), Some(AIR));
        assert_eq!(named("NO-SUCH"), None);
    }

    #[test]
    fn makers_formulas_give_their_indices() {
        for line in include_str!("makers.agf").lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            let ["NM", name, _, _, index, abbe] = words[..] else {
                continue;
            };
            let glass = named(name).unwrap();
            let at = |line| glass.formula.unwrap().dispersion.index(line);
            // The catalogs print n_d to five digits, some to four. V_d is by the same formula, evaluated by another program, to four digits.
            let [index, abbe]: [f64; 2] = [index, abbe].map(|x| x.parse().unwrap());
            assert!((at(LINE_D) - index).abs() < 6e-5, "{name}");
            let found = (at(LINE_D) - 1.0) / (at(LINE_F) - at(LINE_C));
            assert!((found / abbe - 1.0).abs() < 1e-3, "{name}: {found}");
        }
    }

    #[test]
    fn pressed_glasses_are_known_by_what_they_are_pressed_from() {
        let glasses = Glasses::COMMON;
        assert_eq!(glasses.named("L-TIM28_MOLD"), None);
        assert_eq!(glasses.unpressed("L-TIM28_MOLD"), named("L-TIM28"));
        assert_eq!(glasses.unpressed("L-TIM28"), None);
    }

    #[test]
    fn formulas_are_those_of_their_glasses() {
        for name in ["SILICA", "F_SILICA", "CAF2", "BK7"] {
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
