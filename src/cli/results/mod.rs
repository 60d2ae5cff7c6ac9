//! What became of many images: for a terminal, a program, a test runner, a pull request and a browser.

mod json;
mod junit;
mod markdown;
mod page;
mod text;
mod thumbnails;

pub(super) use thumbnails::Thumbnails;

use super::codes::{ANSWER_IS_NO, CANNOT_TELL};
use super::messages::Failure;
use crate::compare::{Answer, Comparison, Correction, Findable, rate, relative};
use crate::output;
use crate::suite::{Family, Spent};
use std::path::Path;

/// All images, in the order of the suite.
pub(super) struct Results {
    /// What was compared.
    pub title: String,
    /// The false-alarm rate, and among how many images it is shared.
    pub family: Family,
    /// The level at which an image differs ([`Results::settle`]).
    pub level: f64,
    /// The commit's share, where the rate is shared among commits: of which rate.
    pub spent: Option<(Spent, f64)>,
    /// The images.
    pub rows: Vec<Row>,
}

/// An image.
pub(super) struct Row {
    /// With its folders.
    pub name: String,
    /// What became of it.
    pub outcome: Outcome,
    /// `true` if it is a reference now (`--update`), whatever became of it before.
    pub accepted: Option<String>,
    /// What else is to be known.
    pub notes: Vec<String>,
    /// Seconds that it took to render.
    pub seconds: Option<f64>,
    /// Where its page is, relative to the index; with `/` between folders.
    pub page: Option<String>,
    /// Thumbnails.
    pub thumbnails: Thumbnails,
}

/// What became of an image.
pub(super) enum Outcome {
    /// It was compared.
    Compared(Box<Comparison>),
    /// It cannot be compared, being of other pixels: why.
    Other(String),
    /// There is nothing to compare it with.
    New,
    /// There is only what it would have been compared with.
    Missing,
    /// There is none, or it cannot be compared: why.
    Failed(String),
    /// Its turn did not come.
    NotRun,
}

/// An outcome in a word; the most alarming first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Status {
    Failed,
    Changed,
    Missing,
    New,
    CannotTell,
    NotRun,
    Accepted,
    Agree,
}

impl Status {
    const ALL: [Status; 8] = [
        Status::Failed,
        Status::Changed,
        Status::Missing,
        Status::New,
        Status::CannotTell,
        Status::NotRun,
        Status::Accepted,
        Status::Agree,
    ];

    /// For people and programs.
    pub(super) fn word(self) -> &'static str {
        match self {
            Status::Failed => "failed",
            Status::Changed => "changed",
            Status::Missing => "missing",
            Status::New => "new",
            Status::CannotTell => "cannot tell",
            Status::NotRun => "not run",
            Status::Accepted => "accepted",
            Status::Agree => "agree",
        }
    }

    /// A sign for people, beside the word.
    fn sign(self) -> &'static str {
        match self {
            Status::Failed => "✗",
            Status::Changed => "≠",
            Status::Missing => "−",
            Status::New => "+",
            Status::CannotTell | Status::NotRun => "?",
            Status::Accepted | Status::Agree => "✓",
        }
    }
}

impl Row {
    pub(super) fn new(name: impl Into<String>, outcome: Outcome) -> Row {
        Row {
            name: name.into(),
            outcome,
            accepted: None,
            notes: Vec::new(),
            seconds: None,
            page: None,
            thumbnails: Thumbnails::default(),
        }
    }

    pub(super) fn status(&self) -> Status {
        match &self.outcome {
            _ if self.accepted.is_some() => Status::Accepted,
            Outcome::Compared(comparison) => match comparison.answer() {
                Answer::Agree => Status::Agree,
                Answer::Differ => Status::Changed,
                Answer::CannotTell => Status::CannotTell,
            },
            Outcome::Other(_) => Status::Changed,
            Outcome::New => Status::New,
            Outcome::Missing => Status::Missing,
            Outcome::Failed(_) => Status::Failed,
            Outcome::NotRun => Status::NotRun,
        }
    }

    pub(super) fn comparison(&self) -> Option<&Comparison> {
        match &self.outcome {
            Outcome::Compared(comparison) => Some(comparison),
            _ => None,
        }
    }

    /// What became of it, in a sentence or a few.
    fn detail(&self) -> String {
        match (&self.accepted, &self.outcome) {
            (Some(how), _) => how.clone(),
            (_, Outcome::Compared(comparison)) => comparison.sentence(),
            (_, Outcome::New) => "There is no reference.".to_owned(),
            (_, Outcome::Missing) => "There is only the reference.".to_owned(),
            (_, Outcome::Failed(why) | Outcome::Other(why)) => why.clone(),
            (_, Outcome::NotRun) => "The suite was interrupted before.".to_owned(),
        }
    }

    /// Notes, and the cautions of the comparison.
    fn remarks(&self) -> Vec<String> {
        let cautions = self.comparison().map(Comparison::cautions);
        { self.notes.iter().cloned() }
            .chain(cautions.unwrap_or_default())
            .collect()
    }
}

/// The smallest difference that would have been found of the whole image, and in blocks of the largest size, in a few words.
fn found(comparison: &Comparison) -> String {
    let side = comparison
        .findable
        .iter()
        .filter_map(|found| found.side)
        .max();
    let of = |found: &Findable| match found.side {
        None => format!("{} of all", relative(found.relative)),
        Some(side) => format!("{} in {side} × {side}", relative(found.relative)),
    };
    let both = { comparison.findable.iter().rev() }
        .filter(|found| found.side.is_none() || found.side == side);
    both.map(of).collect::<Vec<_>>().join(", ")
}

impl Results {
    /// Shares the false-alarm rate among the images that were compared, and settles which of them differ.
    pub(super) fn settle(&mut self) {
        let p = |comparison: &Comparison| match comparison.non_finite.unmatched {
            0 => comparison.verdict.p(),
            _ => 0.0,
        };
        let all: Vec<f64> = self
            .rows
            .iter()
            .filter_map(Row::comparison)
            .map(p)
            .collect();
        self.level = self.family.level(&all);
        for row in &mut self.rows {
            if let Outcome::Compared(comparison) = &mut row.outcome {
                comparison.verdict.alpha = self.level;
            }
        }
    }

    /// How many images there are of a kind.
    fn count(&self, status: Status) -> usize {
        let of_kind = |row: &&Row| row.status() == status;
        self.rows.iter().filter(of_kind).count()
    }

    /// The rows, the most alarming first, each kind in its order.
    fn sorted(&self) -> Vec<&Row> {
        let mut rows: Vec<&Row> = self.rows.iter().collect();
        rows.sort_by_key(|row| row.status());
        rows
    }

    /// The exit code.
    pub(super) fn code(&self) -> u8 {
        let has = |statuses: &[Status]| statuses.iter().any(|&status| self.count(status) > 0);
        if has(&[
            Status::Failed,
            Status::Changed,
            Status::Missing,
            Status::New,
        ]) {
            return ANSWER_IS_NO;
        }
        match has(&[Status::CannotTell]) {
            true => CANNOT_TELL,
            false => 0,
        }
    }

    /// Such as `2 changed, 1 new, 5 agree`.
    fn counts(&self) -> String {
        let count = |status: Status| match self.count(status) {
            0 => None,
            n => Some(format!("{n} {}", status.word())),
        };
        let counts: Vec<String> = Status::ALL.into_iter().filter_map(count).collect();
        match counts.is_empty() {
            true => "no images".to_owned(),
            false => counts.join(", "),
        }
    }

    /// How sure all of it is.
    fn promise(&self) -> String {
        let Family {
            alpha,
            images,
            correction,
        } = self.family;
        let whose = match correction {
            Correction::Holm => "Holm",
            Correction::Sidak => "Šidák",
        };
        let shared = match self.spent {
            Some((spent, of)) => format!(
                "{}, the share of commit {} of the {} of all commits to come,",
                rate(alpha),
                spent.number,
                rate(of)
            ),
            None => rate(alpha),
        };
        let plural = if images == 1 { "image" } else { "images" };
        format!(
            "The probability of any false alarm is {shared} at most, over {images} {plural} ({whose}): one differs where \
             p is below {}.",
            rate(self.level)
        )
    }

    pub(super) fn text(&self) -> String {
        text::text(self)
    }

    pub(super) fn json(&self) -> Result<String, String> {
        serde_json::to_string_pretty(&json::value(self)).map_err(|e| e.to_string())
    }

    pub(super) fn junit(&self) -> String {
        junit::xml(self)
    }

    pub(super) fn markdown(&self) -> String {
        markdown::text(self)
    }

    pub(super) fn page(&self) -> String {
        page::html(self)
    }

    /// Writes all of them into a folder, which is made if need be.
    pub(super) fn write(&self, folder: &Path) -> Result<(), Failure> {
        make(folder)?;
        output::write(&folder.join("results.json"), self.json()?.as_bytes())?;
        output::write(&folder.join("junit.xml"), self.junit().as_bytes())?;
        output::write(&folder.join("summary.md"), self.markdown().as_bytes())?;
        output::write(&folder.join("index.html"), self.page().as_bytes())?;
        Ok(())
    }
}

/// Makes a folder, and those it is in.
pub(super) fn make(folder: &Path) -> Result<(), Failure> {
    let made = std::fs::create_dir_all(folder);
    made.map_err(|error| {
        Failure::new(
            format!("{}: cannot make the folder: {error}", folder.display()),
            true,
        )
    })
}
