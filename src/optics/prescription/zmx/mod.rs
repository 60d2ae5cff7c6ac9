//! Zemax' sequential lens files (`.zmx`).
//!
//! Lines of a keyword and values; `SURF n` begins surface n. What is read of a surface: `TYPE` (STANDARD, EVENASPH; ODDASPHE and
//! COORDBRK where they are centered and even), `CURV` curvature, `CONI` conic constant, `PARM i` coefficient of r^2i, `DISZ` distance to
//! the next, `GLAS` medium behind, `DIAM` half the clear diameter (`CLAP` goes before it), `STOP`; of the whole: `MODE`,
//! `UNIT`, and the primary wavelength of `WAVM` or `WAVL` by `PWAV`, which indices are those of. Where `DIAM` is missing or 0, the
//! clear diameter is that of the rays which the file describes: `ENPD`, `FNUM`, `OBNA` or `FLOA` say how wide the axial beam is, `FTYP`, `XFLN`
//! and `YFLN` the fields, `VDYN` and `VCYN` their vignetting. The first surface is the object, the last one the film. What
//! the tracer cannot do (mirrors, tilts, other types) is an error that names its line; what changes no ray on its way is
//! passed over. Surfaces between equal media that are not the stop are auxiliary planes of the design and left out, but
//! for baffles and field stops: those with an aperture of their own (`CLAP`, `FLAP`). As in Zemax the semi-diameter of
//! a surface without power blocks nothing. Configurations (`MNUM`, `THIC`) are positions of a zoom, by focal length, or of focus where
//! one alone looks at infinity; files that fstop has written say in notes what they are called.
//!
//! ```
//! use fstop::optics::prescription::{Glasses, zmx};
//! let lens = zmx::parse(
//!     "MODE SEQ\nUNIT MM\nSURF 0\n DISZ INFINITY\nSURF 1\n STOP\n CURV 0.02\n DISZ 5\n GLAS N-BK7\n DIAM 10\n\
//!      SURF 2\n CURV 0\n DISZ 95\n DIAM 10\nSURF 3\n",
//!     &Glasses::COMMON,
//! )?;
//! assert_eq!(lens.surfaces.len(), 2);
//! assert_eq!(lens.film_distance, 95.0);
//! # Ok::<(), fstop::optics::PrescriptionError>(())
//! ```

mod block;
mod configurations;
mod head;
#[cfg(test)]
mod tests;

pub(super) use self::configurations::{LABELS, MAX_POSITIONS};

use self::block::Block;
use self::configurations::Configurations;
use self::head::Head;
use super::cells::lines;
use super::design::{Design, Medium};
use super::glass::Glasses;
use super::{Notes, Prescription, PrescriptionError, RowNote};

/// Reads the text of a file, with the glasses that it may name.
pub fn parse(text: &str, glasses: &Glasses) -> Result<Prescription, PrescriptionError> {
    let mut reader = Reader::default();
    for (line, content) in lines(text) {
        let mut words = content.split_whitespace();
        let Some(keyword) = words.next() else {
            continue;
        };
        let words: Vec<&str> = words.collect();
        if let Err(message) = reader.line(line, keyword, &words, glasses) {
            reader.notes.errors.push(RowNote {
                line,
                column: content.len() - content.trim_start().len() + 1,
                // Surfaces count from the object, 0.
                row: reader.blocks.len().saturating_sub(1),
                message,
            });
        }
    }
    reader.finish()
}

/// Collects surfaces and what is wrong.
#[derive(Default)]
struct Reader {
    head: Head,
    blocks: Vec<Block>,
    configurations: Configurations,
    notes: Notes,
}

/// Keywords of a surface that stop rays in ways the tracer does not know, with what they are.
const UNKNOWN_OPTICS: [(&str, &str); 7] = [
    ("OBDC", "decentered apertures"),
    ("OBSC", "central obscurations"),
    ("SQAP", "rectangular apertures"),
    ("SQOB", "rectangular obscurations"),
    ("ELAP", "elliptical apertures"),
    ("ELOB", "elliptical obscurations"),
    ("SPID", "spiders"),
];

impl Reader {
    /// Reads a line.
    fn line(
        &mut self,
        line: usize,
        keyword: &str,
        words: &[&str],
        glasses: &Glasses,
    ) -> Result<(), String> {
        if keyword == "SURF" {
            self.blocks.push(Block::new(line, self.blocks.len()));
            return Ok(());
        }
        if self.configurations.set(keyword, words)? {
            return Ok(());
        }
        let Some((block, before)) = self.blocks.split_last_mut() else {
            return self.head.set(line, keyword, words);
        };
        if let Some((_, what)) = UNKNOWN_OPTICS.iter().find(|(k, _)| *k == keyword)
            && !before.is_empty()
        {
            return Err(format!("{keyword}: {what} cannot be traced"));
        }
        // Some files have lines of the head behind their surfaces.
        match Head::says_units(keyword) {
            true => self.head.set(line, keyword, words),
            false => block.set(keyword, words, before, glasses),
        }
    }

    fn finish(mut self) -> Result<Prescription, PrescriptionError> {
        if self.notes.errors.is_empty() && self.blocks.len() < 3 {
            return Err(PrescriptionError::Empty);
        }
        // The last one is the film.
        let film = self.blocks.pop();
        let film_curvature = film.map_or(0.0, |film| film.surface.curvature);
        let unit = self.head.unit();
        let (gaps, remark) = self.configurations.positions(&self.blocks, unit);
        let first = self.blocks.get(1).map(|block| &block.surface);
        let note = remark.zip(first).map(|(message, s)| s.note(message));
        self.notes.warnings.extend(note);
        let mut surfaces = Vec::new();
        for mut block in self.blocks {
            let warning = block.warning.take().map(|w| block.surface.note(w));
            self.notes.warnings.extend(warning);
            let (surface, unfit) = block.finish();
            self.notes.errors.extend(unfit.map(|m| surface.note(m)));
            surfaces.push(surface);
        }
        let mut light = self.head.light();
        let mut object_medium = Medium::default();
        if !surfaces.is_empty() {
            let object = surfaces.remove(0);
            light.object_distance = object.thickness;
            object_medium = object.medium;
        }
        let design = Design {
            surfaces,
            unit,
            wavelength: self.head.primary_wavelength(),
            light,
            object_medium,
            film_curvature,
            notes: self.notes,
            gaps,
        };
        design.prescription()
    }
}
