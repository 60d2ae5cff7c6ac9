//! Zemax' sequential files.

use super::{WriteError, Written};
use crate::optics::coating::Coating;
use crate::optics::dispersion::LINE_D;
use crate::optics::prescription::positions::PositionTable;
use crate::optics::prescription::zmx::{LABELS, MAX_POSITIONS};
use crate::optics::prescription::{Prescription, agf, glass};
use crate::optics::surface::Surface;
use std::fmt::Write;

/// An index this near to that of the formula is the formula's: readers compute it from there.
const SAME_INDEX: f64 = 1e-12;

/// The file of `lens`, and the catalogue of its glasses that have formulas.
pub(super) fn written(lens: &Prescription, name: &str) -> Result<Written, WriteError> {
    let stops = lens.surfaces.iter().enumerate().filter(|(_, s)| s.is_stop);
    if let Some((second, _)) = stops.clone().nth(1) {
        return Err(WriteError::Stops(second + 1));
    }
    let mut catalogue = Catalogue::default();
    let configurations = lens.positions.as_ref().map(|p| p.to_table());
    let mut text = head(lens, name);
    if let Some(table) = &configurations {
        text += &labels(table);
    }
    text += OBJECT;
    let mut before = (1.0, None, None);
    for (i, s) in lens.surfaces.iter().enumerate() {
        let last = i + 1 == lens.surfaces.len();
        let thickness = if last {
            lens.film_distance
        } else {
            s.thickness
        };
        let medium = (s.index, s.abbe, s.dispersion);
        let bends = medium != before;
        before = medium;
        text += &surface(i + 1, s, thickness, bends)?;
        match s.coating {
            None => {}
            Some(coating) if coating == Coating::magnesium_fluoride(1000.0 * LINE_D) => {
                text += "  COAT AR\n";
            }
            Some(_) => return Err(WriteError::Coating(i + 1)),
        }
        if let Some(glass) = catalogue.glass(i + 1, s)? {
            let _ = writeln!(text, "  GLAS {glass} 0 0 0 0 0 0");
        }
    }
    let film = lens.surfaces.len() + 1;
    let _ = writeln!(text, "SURF {film}\n  TYPE STANDARD\n  CURV 0.0\n  DISZ 0");
    if let Some(table) = &configurations {
        text += &operands(lens, table)?;
    }
    Ok(Written {
        text,
        catalogue: Some(catalogue.text).filter(|text| !text.is_empty()),
    })
}

/// What stands in front of the first surface.
fn head(lens: &Prescription, name: &str) -> String {
    let name: String = name.chars().filter(|c| !c.is_control()).collect();
    // The stop is as wide as it is.
    let aperture = if lens.has_stop() { "FLOA\n" } else { "" };
    format!(
        "VERS 140124 0 0\nMODE SEQ\nNAME {name}\nUNIT MM X W X CM MR CPMM\n{aperture}WAVM 1 {LINE_D} 1\nPWAV 1\n"
    )
}

/// It is far away.
const OBJECT: &str = "SURF 0\n  TYPE STANDARD\n  CURV 0.0\n  DISZ INFINITY\n";

/// What zoom and focus are called at each position, of which the format knows nothing: notes, which our reader knows.
fn labels(table: &PositionTable) -> String {
    let line = |word: &str, numbers: Vec<String>| {
        format!("NOTE 0 {LABELS} {word} {}\n", numbers.join(" "))
    };
    let zoom = table.zoom.as_ref().map(|zoom| {
        let numbers = zoom.iter().map(f64::to_string);
        line("zoom", numbers.collect())
    });
    let focus = table.focus.as_ref().map(|focus| {
        let numbers = focus.iter().map(|d| d.unwrap_or(f64::INFINITY).to_string());
        line("focus", numbers.collect())
    });
    [zoom, focus].into_iter().flatten().collect()
}

/// The configurations: each gap at each position, and where the object is.
fn operands(lens: &Prescription, table: &PositionTable) -> Result<String, WriteError> {
    let count = table.gaps.iter().map(|gap| gap.values.len()).max();
    let count = count.unwrap_or(0);
    if count > MAX_POSITIONS {
        return Err(WriteError::Positions);
    }
    let mut text = format!("MNUM {count} 1\n");
    let mut line = |surface: usize, i: usize, thickness: f64| {
        let _ = writeln!(
            text,
            "THIC {surface} {} {thickness:e} 0 0 0 1 1 1 0 0 \"\" 0",
            i + 1
        );
    };
    for gap in &table.gaps {
        for surface in &gap.behind {
            for (i, value) in gap.values.iter().enumerate() {
                line(surface + 1, i, *value);
            }
        }
    }
    for (i, distance) in table.focus.iter().flatten().enumerate() {
        // From the first vertex, not from the film.
        let thickness = |s: usize, own: f64| {
            let gap = table.gaps.iter().find(|gap| gap.behind.contains(&s));
            gap.map_or(own, |gap| gap.values[i])
        };
        let last = lens.surfaces.len() - 1;
        let own = lens
            .surfaces
            .iter()
            .enumerate()
            .map(|(s, surface)| match s == last {
                true => thickness(s, lens.film_distance),
                false => thickness(s, surface.thickness),
            });
        let object = distance.map_or(INFINITE, |meters| 1e3 * meters - own.sum::<f64>());
        line(0, i, object);
    }
    Ok(text)
}

/// What Zemax' format means by infinity.
const INFINITE: f64 = 1e10;

/// The lines of surface `number`, but for its glass.
fn surface(number: usize, s: &Surface, thickness: f64, bends: bool) -> Result<String, WriteError> {
    if !(s.aperture > 0.0 && s.aperture.is_finite()) {
        return Err(WriteError::NoDiameter(number));
    }
    let asphere = s.asphere.unwrap_or_default();
    let even = asphere.terms.iter().any(|term| *term != 0.0);
    let kind = if even { "EVENASPH" } else { "STANDARD" };
    let mut text = format!("SURF {number}\n");
    if s.is_stop {
        text += "  STOP\n";
    }
    // −0 of an infinite negative radius is 0.
    let curvature = 1.0 / s.radius + 0.0;
    let _ = writeln!(text, "  TYPE {kind}\n  CURV {curvature:e} 0 0 0 0 \"\"");
    if asphere.conic != 0.0 {
        let _ = writeln!(text, "  CONI {:e}", asphere.conic);
    }
    if even {
        for (i, term) in asphere.terms.iter().enumerate() {
            let _ = writeln!(text, "  PARM {} {term:e}", i + 1);
        }
    }
    let radius = 0.5 * s.aperture;
    let _ = writeln!(text, "  DISZ {thickness:e}\n  DIAM {radius:e} 1 0 0 1 \"\"");
    // Without power nothing else would block.
    if !bends && !s.is_stop {
        let _ = writeln!(text, "  CLAP 0 {radius:e} 0");
    }
    Ok(text)
}

/// The glasses that have formulas, as far as they have been written.
#[derive(Default)]
struct Catalogue {
    text: String,
    names: Vec<(String, String)>,
}

impl Catalogue {
    /// What a `GLAS` line says of the glass behind surface `number`; `None` for air.
    fn glass(&mut self, number: usize, s: &Surface) -> Result<Option<String>, WriteError> {
        if s.index == 1.0 && s.dispersion.is_none() {
            return Ok(None);
        }
        let given = s.glass.map(|name| name.to_string());
        let Some(dispersion) = &s.dispersion else {
            let name = given.unwrap_or("___BLANK".to_string());
            let abbe = s.abbe.unwrap_or(0.0);
            return Ok(Some(format!("{name} 1 0 {:e} {abbe:e}", s.index)));
        };
        // A common one needs no catalogue.
        if let Some((name, common)) = given
            .as_ref()
            .and_then(|name| Some((name, glass::named(name)?)))
            && common.formula.map(|f| f.dispersion) == s.dispersion
            && (common.index, common.abbe) == (s.index, s.abbe)
        {
            return Ok(Some(name.clone()));
        }
        if dispersion.to_catalogue().is_none() {
            return Err(WriteError::Formula(number));
        }
        let index = dispersion.index(LINE_D);
        if (index - s.index).abs() > SAME_INDEX {
            return Err(WriteError::Index(number));
        }
        // What glasses are told apart by: all but the name.
        let body = agf::entry("", dispersion, s.abbe).unwrap_or_default();
        if let Some((_, name)) = self.names.iter().find(|(known, _)| *known == body) {
            return Ok(Some(name.clone()));
        }
        let taken = |name: &String| self.names.iter().any(|(_, n)| n.eq_ignore_ascii_case(name));
        // Names with underscores in front are made up, and forgotten when they are read.
        let name = given
            .filter(|name| !taken(name))
            .unwrap_or(format!("___{number}"));
        self.text += &agf::entry(&name, dispersion, s.abbe).unwrap_or_default();
        self.names.push((body, name.clone()));
        Ok(Some(name))
    }
}
