//! The configurations of a file: where the groups of a zoom are at each of its positions.
//!
//! `MNUM count saved`, then one line for each operand and configuration: its name, a surface (0 is the object), the number of the
//! configuration from 1, a value. `THIC` says thicknesses.
//!
//! What zoom and distance are called the format does not say. fstop writes `NOTE 0 fstop-positions zoom 80 200` and `… focus inf 2`
//! (meters from the film), and reads that where there are as many numbers as configurations.

use super::block::Block;
use crate::optics::prescription::design::value;
use crate::optics::prescription::positions::{GapTable, PositionTable};
use std::collections::BTreeMap;

/// The most configurations of a zoom that are read.
pub(in crate::optics::prescription) const MAX_POSITIONS: usize = 100;

/// The word that begins the notes on what positions are called.
pub(in crate::optics::prescription) const LABELS: &str = "fstop-positions";

/// What configurations may differ by that changes the lens, and positions have no place for.
const NOT_READ: [(&str, &str); 7] = [
    ("APER", "aperture"),
    ("CRVT", "curvatures"),
    ("CONN", "conic constants"),
    ("GLSS", "glasses"),
    ("PRAM", "aspheric terms"),
    ("SDIA", "clear diameters"),
    ("STPS", "stop"),
];

/// Configurations as far as they are read.
#[derive(Default)]
pub(super) struct Configurations {
    count: usize,
    /// By surface as the file counts them: the thickness in each configuration, in units of the file.
    thicknesses: BTreeMap<usize, Vec<Option<f64>>>,
    /// What else differs.
    others: Vec<&'static str>,
    /// What positions are called, by notes.
    zooms: Vec<f64>,
    /// Meters.
    distances: Vec<f64>,
}

/// Positions of groups, with what is to be said about them.
pub(super) type Read = (Option<PositionTable>, Option<String>);

impl Configurations {
    /// Reads a line; whether it is one of these.
    pub(super) fn set(&mut self, keyword: &str, words: &[&str]) -> Result<bool, String> {
        if let ("NOTE", [_, LABELS, word, numbers @ ..]) = (keyword, words) {
            let numbers = numbers.iter().take(MAX_POSITIONS + 1);
            let numbers = numbers.map(|n| n.parse().unwrap_or(f64::NAN)).collect();
            match *word {
                "zoom" => self.zooms = numbers,
                "focus" => self.distances = numbers,
                _ => {}
            }
            return Ok(true);
        }
        if keyword == "MNUM" {
            let count = value(words, 0, "the number of configurations")?;
            self.count = if (1.0..=MAX_POSITIONS as f64).contains(&count) {
                count as usize
            } else {
                0
            };
            return Ok(true);
        }
        if self.count < 2 {
            return Ok(false);
        }
        if let Some((_, what)) = NOT_READ.iter().find(|(name, _)| *name == keyword) {
            // Of the first configuration alone it changes nothing.
            let later = words
                .get(1)
                .is_some_and(|w| w.parse().is_ok_and(|i: f64| i > 1.0));
            if later && !self.others.contains(what) {
                self.others.push(what);
            }
            return Ok(true);
        }
        if keyword != "THIC" {
            return Ok(false);
        }
        let surface = value(words, 0, "the number of a surface")?;
        let configuration = value(words, 1, "the number of a configuration")?;
        let known =
            (1.0..=self.count as f64).contains(&configuration) && (0.0..=1e4).contains(&surface);
        if !known {
            return Err(format!(
                "THIC of surface {surface} in configuration {configuration}; the file has {} of them",
                self.count
            ));
        }
        // The object may be at infinity, by a word.
        let thickness = value(words, 2, "a thickness");
        let thickness = if surface == 0.0 {
            thickness.unwrap_or(f64::INFINITY)
        } else {
            thickness?
        };
        let row = self
            .thicknesses
            .entry(surface as usize)
            .or_insert_with(|| vec![None; self.count]);
        // A second `MNUM` may have said more.
        if let Some(cell) = row.get_mut(configuration as usize - 1) {
            *cell = Some(thickness);
        }
        Ok(true)
    }

    /// The positions of groups, surfaces counted from 0 at the first behind the object; `blocks` are object and lens, without the film.
    pub(super) fn positions(&self, blocks: &[Block], unit: f64) -> Read {
        let lens = blocks.get(1..).unwrap_or(&[]);
        let gaps = self.gaps(lens);
        if let Some(table) = self.labeled(&gaps, unit) {
            return (Some(table), None);
        }
        if self.count < 2
            || gaps
                .iter()
                .all(|gap| gap.values.windows(2).all(|w| w[0] == w[1]))
        {
            let other = (!self.others.is_empty()).then(|| self.differ());
            return (None, other);
        }
        let object = blocks
            .first()
            .map_or(f64::INFINITY, |b| b.surface.thickness);
        let views: Vec<View> = (0..self.count)
            .map(|i| {
                View::new(
                    lens,
                    |k| self.thickness(k + 1, i, lens[k].surface.thickness),
                    self.thickness(0, i, object),
                )
            })
            .collect();
        let Some((chosen, zooms)) = choose(&views) else {
            let message =
                "configurations that neither zoom nor focus; the one that was saved is read";
            return (None, Some(message.to_string()));
        };
        let of = |values: &[f64]| chosen.iter().map(|i| values[*i] * unit).collect();
        let focus = |i: &usize| Some(1e-3 * unit * views[*i].distance).filter(|d| d.is_finite());
        let table = PositionTable {
            zoom: zooms.then(|| labels(chosen.iter().map(|i| views[*i].focal_length * unit))),
            focus: (!zooms).then(|| chosen.iter().map(focus).collect()),
            gaps: gaps
                .into_iter()
                .map(|gap| GapTable {
                    values: of(&gap.values),
                    ..gap
                })
                .collect(),
        };
        (Some(table), self.remark(chosen.len()))
    }

    /// All configurations, by the names that notes give them; `None` without such notes.
    fn labeled(&self, gaps: &[GapTable], unit: f64) -> Option<PositionTable> {
        let all = |labels: &[f64]| labels.len() == self.count && !labels.iter().any(|x| x.is_nan());
        let zoom = Some(self.zooms.clone()).filter(|zooms| all(zooms));
        let focus = Some(&self.distances).filter(|distances| all(distances));
        if zoom.is_none() && focus.is_none() || self.count < 1 || gaps.is_empty() {
            return None;
        }
        let finite = |distances: &Vec<f64>| {
            let distances = distances.iter();
            distances
                .map(|d| Some(*d).filter(|d| d.is_finite()))
                .collect()
        };
        let gap = |gap: &GapTable| GapTable {
            values: gap.values.iter().map(|x| x * unit).collect(),
            ..gap.clone()
        };
        Some(PositionTable {
            zoom,
            focus: focus.map(finite),
            gaps: gaps.iter().map(gap).collect(),
        })
    }

    /// The thickness behind surface number `surface` of the file, where `saved` is what its own lines say.
    fn thickness(&self, surface: usize, configuration: usize, saved: f64) -> f64 {
        let row = self.thicknesses.get(&surface);
        row.and_then(|row| row[configuration]).unwrap_or(saved)
    }

    /// Thicknesses by configuration, in units of the file; that of the film where a solve moves it.
    fn gaps(&self, lens: &[Block]) -> Vec<GapTable> {
        let rows = self
            .thicknesses
            .keys()
            .filter(|k| (1..=lens.len()).contains(*k));
        let at = |k: usize, i: usize| self.thickness(k + 1, i, lens[k].surface.thickness);
        let table = |k: usize| GapTable {
            name: format!("D{}", k + 1),
            behind: vec![k],
            values: (0..self.count).map(|i| at(k, i)).collect(),
        };
        let mut gaps: Vec<GapTable> = rows.map(|k| table(k - 1)).collect();
        let last = lens.len().saturating_sub(1);
        if lens.last().is_some_and(|b| b.solved) && !self.thicknesses.contains_key(&lens.len()) {
            let object = self.thicknesses.get(&0);
            let far = |i: usize| object.and_then(|row| row[i]).unwrap_or(f64::INFINITY);
            let values = (0..self.count)
                .map(|i| View::new(lens, |k| at(k, i), far(i)).image)
                .collect();
            gaps.push(GapTable {
                values,
                ..table(last)
            });
        }
        gaps
    }

    fn remark(&self, chosen: usize) -> Option<String> {
        let left_out = self.count - chosen;
        match (left_out, self.others.is_empty()) {
            (0, true) => None,
            (0, false) => Some(self.differ()),
            _ => Some(format!(
                "{left_out} of its {} configurations, at near distances, are left out",
                self.count
            )),
        }
    }

    fn differ(&self) -> String {
        format!(
            "configurations differ by {}, too: that of the one saved holds for all",
            self.others.join(", ")
        )
    }
}

/// What a configuration shows, by first order, in units of the file.
struct View {
    focal_length: f64,
    /// From the film, as Gaussian optics has it, to the object.
    distance: f64,
    /// From the last surface to the image.
    image: f64,
}

impl View {
    fn new(lens: &[Block], thickness: impl Fn(usize) -> f64, object: f64) -> View {
        // Two rays: one parallel to the axis and one from the object (Smith, Modern Optical Engineering, 4th edition, §3.2).
        let last = lens.len().saturating_sub(1);
        let trace = |mut y: f64, mut u: f64| {
            let (mut index, mut length) = (1.0, 0.0);
            for (k, block) in lens.iter().enumerate() {
                let s = &block.surface;
                let next = s.medium.glass.index;
                let curvature = s.curvature + 2.0 * s.asphere.terms[0];
                u = (index * u - y * curvature * (next - index)) / next;
                index = next;
                if k < last {
                    y += thickness(k) * u;
                    length += thickness(k);
                }
            }
            (y, u, length)
        };
        let (_, slope, length) = trace(1.0, 0.0);
        // Beyond 1e9 programs mean infinity.
        let far = object.abs() > 1e9;
        let (y, u, _) = if far {
            trace(1.0, 0.0)
        } else {
            trace(object, 1.0)
        };
        let image = -y / u;
        let distance = if far {
            f64::INFINITY
        } else {
            object + length + image
        };
        View {
            focal_length: -1.0 / slope,
            distance,
            image,
        }
    }
}

/// The configurations that are positions, and whether they are those of a zoom: of one distance all; else, if one alone is far, all as
/// positions of focus, and if several are, those.
fn choose(views: &[View]) -> Option<(Vec<usize>, bool)> {
    let sound = |v: &View| v.focal_length.is_finite() && v.focal_length > 0.0 && v.distance > 0.0;
    if !views.iter().all(sound) {
        return None;
    }
    let far: Vec<usize> = (0..views.len())
        .filter(|i| views[*i].distance.is_infinite())
        .collect();
    let all: Vec<usize> = (0..views.len()).collect();
    // A lens that only moves as a whole keeps its focal length.
    let first = views.first()?;
    let same_focal = views
        .iter()
        .all(|v| (v.focal_length / first.focal_length - 1.0).abs() < 1e-6);
    match far.len() {
        0 => Some((all, !same_focal)),
        1 => Some((all, false)),
        _ => Some((far, true)),
    }
}

/// What is engraved: focal lengths to 0.01 mm, where these differ.
fn labels(focal_lengths: impl Iterator<Item = f64>) -> Vec<f64> {
    let exact: Vec<f64> = focal_lengths.collect();
    let round: Vec<f64> = exact.iter().map(|f| (100.0 * f).round() / 100.0).collect();
    let distinct = (0..round.len()).all(|i| round[i] > 0.0 && !round[..i].contains(&round[i]));
    if distinct { round } else { exact }
}
