//! Diagnostics: problems found in a scene, collected while reading and printed together at the end.
//!
//! A [`Diagnostics`] is shared by reference between the parser, the parameter readers and the scene; it takes reports
//! through `&self` and keeps them in order of occurrence, which is the order of the file. The same message at the same
//! location is kept once, and of a message with many locations only the first few are kept and the rest counted, so
//! that a million shapes with the same misspelled parameter neither produce a million lines nor exhaust memory.

use super::groups::Groups;
use super::source::{SourceMap, Span};
use super::suggest::nearest;
use std::cell::RefCell;
use std::collections::HashMap;
use std::ffi::OsStr;
use std::io::IsTerminal;

/// The severity of a problem.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Severity {
    /// The scene is invalid or does not mean what its author intended: it is not rendered.
    #[default]
    Error,
    /// Something was ignored or replaced by a default; rendering continues.
    Warning,
    /// Information.
    Note,
}

/// How text is styled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Plain text, for files and pipes.
    Plain,
    /// With ANSI colors, for terminals.
    Colored,
}

impl Style {
    /// The style for standard error: colors if it is a terminal and `NO_COLOR` is not set.
    pub fn of_stderr() -> Self {
        let no_color = std::env::var_os("NO_COLOR");
        Self::suited(std::io::stderr().is_terminal(), no_color.as_deref())
    }

    /// As specified by <https://no-color.org>: any nonempty value of `NO_COLOR` counts.
    fn suited(terminal: bool, no_color: Option<&OsStr>) -> Self {
        match terminal && no_color.is_none_or(OsStr::is_empty) {
            true => Self::Colored,
            false => Self::Plain,
        }
    }
}

/// A single problem, with its location and advice.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagnostic {
    /// Its severity.
    pub severity: Severity,
    /// One line, without a final period.
    pub message: String,
    /// Its location.
    pub span: Option<Span>,
    /// Index of the item of the list at `span`, from 0; `None` for the whole list. The location of the item is
    /// determined when the message is printed, so that the locations of a million numbers need not be stored.
    pub item: Option<usize>,
    /// `true` if this is an error that pbrt-v3 reports but tolerates, such as an unusable file or an undefined name. It
    /// is replaced by something, so the rest can be rendered (`--keep-going`).
    pub recoverable: bool,
    /// `true` if it is an error of reading a file that another machine may read: see
    /// [`FileProblem::is_failure`](crate::files::FileProblem::is_failure).
    pub failed: bool,
    /// The name of the missing file, as given in the scene: those in one folder are reported together.
    pub missing: Option<String>,
    /// Text next to the caret.
    pub label: Option<String>,
    /// Other relevant locations, each with a text.
    pub related: Vec<(Span, String)>,
    /// Facts shown below the excerpt.
    pub notes: Vec<String>,
    /// Advice shown below the excerpt.
    pub help: Vec<String>,
}

impl Diagnostic {
    fn new(severity: Severity, message: impl Into<String>) -> Self {
        Self {
            severity,
            message: message.into(),
            ..Self::default()
        }
    }

    /// An error without a location.
    pub fn error(message: impl Into<String>) -> Self {
        Self::new(Severity::Error, message)
    }

    /// A warning without a location.
    pub fn warning(message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, message)
    }

    /// A note without a location.
    pub fn note(message: impl Into<String>) -> Self {
        Self::new(Severity::Note, message)
    }

    /// Sets the location.
    pub fn at(mut self, span: Span) -> Self {
        self.span = Some(span);
        self
    }

    /// Sets the location to one item, counted from 0, of the list of values at `span`.
    pub fn at_item(mut self, span: Span, item: usize) -> Self {
        self.span = Some(span);
        self.item = Some(item);
        self
    }

    /// Marks the error as recoverable: see [`recoverable`](field@Diagnostic::recoverable).
    pub fn recoverable(mut self) -> Self {
        self.recoverable = true;
        self
    }

    /// Marks the error as one of the machine: see [`failed`](field@Diagnostic::failed).
    pub fn failed_if(mut self, failed: bool) -> Self {
        self.failed = failed;
        self
    }

    /// Marks a file of this name as missing: see [`missing`](field@Diagnostic::missing).
    pub fn missing(mut self, name: &str) -> Self {
        self.missing = Some(name.to_owned());
        self
    }

    /// Sets the text next to the caret.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = Some(label.into());
        self
    }

    /// Adds another relevant location.
    pub fn related(mut self, span: Span, label: impl Into<String>) -> Self {
        self.related.push((span, label.into()));
        self
    }

    /// Adds a fact.
    pub fn with_note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// Adds advice.
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help.push(help.into());
        self
    }

    /// Adds "did you mean" if there is a suggestion.
    pub fn with_suggestion(self, suggestion: Option<&str>) -> Self {
        match suggestion {
            Some(word) => self.with_help(format!("did you mean `{word}`?")),
            None => self,
        }
    }
}

/// Maximum number of locations kept for one message; by then the pattern is clear.
const PLACES_KEPT: usize = 5;

/// Maximum number of errors, and of warnings and notes, that are printed. More than a person reads.
const PRINTED: usize = 100;

/// Maximum number of distinct problems kept, so that a file of noise cannot exhaust memory.
const KEPT: usize = 10_000;

/// Occurrences of a message.
#[derive(Debug)]
struct Seen {
    /// Number of locations, each different from the one before.
    places: usize,
    last_span: Option<Span>,
    /// Index in `State::kept` of the last one kept.
    last_kept: usize,
}

#[derive(Debug)]
struct Kept {
    diagnostic: Diagnostic,
    /// Number of occurrences at locations not kept.
    elsewhere: usize,
}

#[derive(Debug, Default)]
struct State {
    kept: Vec<Kept>,
    /// Only looked up, never iterated: the order of a hash map must not be visible.
    seen: HashMap<(Severity, String), Seen>,
    errors: usize,
    recoverable_errors: usize,
    failures: usize,
    warnings: usize,
    dropped: usize,
    groups: Groups,
    /// Number of features found that only pbrt-v4 has.
    v4_signs: usize,
}

/// Collects problems through a shared reference.
#[derive(Debug, Default)]
pub struct Diagnostics {
    state: RefCell<State>,
}

impl Diagnostics {
    /// An empty collection.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a problem.
    pub fn push(&self, diagnostic: Diagnostic) {
        let state = &mut *self.state.borrow_mut();
        let key = (diagnostic.severity, diagnostic.message.clone());
        let seen = state.seen.get_mut(&key);
        if seen
            .as_ref()
            .is_some_and(|seen| seen.last_span == diagnostic.span)
        {
            // A parameter read for several shapes is a single mistake.
            return;
        }
        match diagnostic.severity {
            Severity::Error => {
                state.errors += 1;
                state.recoverable_errors += usize::from(diagnostic.recoverable);
                state.failures += usize::from(diagnostic.failed);
            }
            Severity::Warning => state.warnings += 1,
            Severity::Note => {}
        }
        if !state.groups.admit(&diagnostic) {
            return;
        }
        match seen {
            Some(seen) if seen.places >= PLACES_KEPT => {
                seen.last_span = diagnostic.span;
                state.kept[seen.last_kept].elsewhere += 1;
            }
            _ if state.kept.len() >= KEPT => state.dropped += 1,
            seen => {
                let places = seen.map_or(1, |s| s.places + 1);
                let last_kept = state.kept.len();
                state.seen.insert(
                    key,
                    Seen {
                        places,
                        last_span: diagnostic.span,
                        last_kept,
                    },
                );
                state.kept.push(Kept {
                    diagnostic,
                    elsewhere: 0,
                });
            }
        }
    }

    /// Like [`Diagnostics::push`], with "did you mean" if one of `known` is near `word`. The search is skipped if its
    /// result would not be printed, so that thousands of unknown names among thousands of known ones do not take
    /// quadratic time.
    pub fn push_with_nearest<'a>(
        &self,
        diagnostic: Diagnostic,
        word: &str,
        known: impl IntoIterator<Item = &'a str>,
    ) {
        let read = self.will_be_read(&diagnostic);
        let suggestion = read.then(|| nearest(word, known)).flatten();
        self.push(diagnostic.with_suggestion(suggestion));
    }

    /// Returns `true` if this problem might be printed if it were added now.
    fn will_be_read(&self, diagnostic: &Diagnostic) -> bool {
        let state = self.state.borrow();
        let key = (diagnostic.severity, diagnostic.message.clone());
        let repeated = state
            .seen
            .get(&key)
            .is_some_and(|seen| seen.places >= PLACES_KEPT || seen.last_span == diagnostic.span);
        let severe = diagnostic.severity == Severity::Error;
        let same = |kept: &&Kept| (kept.diagnostic.severity == Severity::Error) == severe;
        // Counts those before it, but no more than needed for the answer.
        !repeated
            && !state.groups.is_full(diagnostic)
            && state.kept.iter().filter(same).nth(PRINTED - 1).is_none()
    }

    /// Records a feature that only pbrt-v4 has. A single one may be a mistake; if there are more, the output starts by
    /// saying that the scene is for pbrt-v4.
    pub fn looks_like_v4(&self) {
        self.state.borrow_mut().v4_signs += 1;
    }

    /// Number of errors, including those at locations not kept.
    pub fn errors(&self) -> usize {
        self.state.borrow().errors
    }

    /// Number of recoverable errors: see [`recoverable`](field@Diagnostic::recoverable).
    pub fn recoverable_errors(&self) -> usize {
        self.state.borrow().recoverable_errors
    }

    /// Number of errors of the machine: see [`failed`](field@Diagnostic::failed).
    pub fn failures(&self) -> usize {
        self.state.borrow().failures
    }

    /// Number of warnings, including those at locations not kept.
    pub fn warnings(&self) -> usize {
        self.state.borrow().warnings
    }

    /// Returns `true` if there was at least one error.
    pub fn has_errors(&self) -> bool {
        self.errors() > 0
    }

    /// Returns `true` if nothing was reported.
    pub fn is_empty(&self) -> bool {
        self.state.borrow().kept.is_empty()
    }

    /// The problems kept, in order of occurrence.
    pub fn kept(&self) -> Vec<Diagnostic> {
        let kept = &self.state.borrow().kept;
        kept.iter().map(|k| k.diagnostic.clone()).collect()
    }

    /// `2 errors and 1 warning`, for a closing line; `None` if there were neither.
    pub fn summary(&self) -> Option<String> {
        let counted = |n: usize, what: &str| match n {
            0 => None,
            1 => Some(format!("1 {what}")),
            n => Some(format!("{n} {what}s")),
        };
        match (
            counted(self.errors(), "error"),
            counted(self.warnings(), "warning"),
        ) {
            (Some(errors), Some(warnings)) => Some(format!("{errors} and {warnings}")),
            (one, other) => one.or(other),
        }
    }

    /// All problems as text: each with its excerpt, the first hundred errors and the first hundred warnings and notes
    /// in order of occurrence, then the number of further ones. Many warnings of one kind are shown as a few and a
    /// count, and so are missing files in one folder.
    pub fn render(&self, sources: &SourceMap, style: Style) -> String {
        let messages = self.messages(sources, style).into_iter();
        messages.map(|(_, text)| text + "\n\n").collect()
    }

    /// As [`Diagnostics::render`], message by message.
    pub fn messages(&self, sources: &SourceMap, style: Style) -> Vec<(Severity, String)> {
        let state = self.state.borrow();
        let mut messages = Vec::new();
        if state.v4_signs > 1 {
            let said =
                Diagnostic::note("this is a pbrt-v4 scene, and fstop reads those of pbrt-v3");
            messages.push((Severity::Note, said.render(sources, style)));
        }
        let (mut errors, mut others) = (0, 0);
        let mut kinds = HashMap::new();
        for kept in &state.kept {
            let number = kinds.entry(Groups::key(&kept.diagnostic)).or_insert(0);
            *number += 1;
            let Some(complete) = state.groups.shown(kept.complete(), *number) else {
                continue;
            };
            let printed = match kept.diagnostic.severity {
                Severity::Error => &mut errors,
                Severity::Warning | Severity::Note => &mut others,
            };
            *printed += 1;
            if *printed <= PRINTED {
                messages.push((complete.severity, complete.render(sources, style)));
            }
        }
        let more = errors.saturating_sub(PRINTED) + others.saturating_sub(PRINTED) + state.dropped;
        if more > 0 {
            messages.push((Severity::Note, format!("… and {more} more problems")));
        }
        messages
    }
}

impl Kept {
    /// The problem with the count of occurrences not kept.
    fn complete(&self) -> Diagnostic {
        let mut diagnostic = self.diagnostic.clone();
        if self.elsewhere > 0 {
            let elsewhere = self.elsewhere;
            diagnostic
                .notes
                .push(format!("the same at other places: {elsewhere} more"));
        }
        diagnostic
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::FileId;
    use std::cell::Cell;

    fn at(start: u32) -> Span {
        Span {
            file: FileId(0),
            start,
            end: start + 1,
        }
    }

    #[test]
    fn repeats_are_counted() {
        let diagnostics = Diagnostics::new();
        for start in [0, 0, 0, 1, 2, 3, 4, 5, 6, 7] {
            diagnostics.push(Diagnostic::warning("odd").at(at(start)));
        }
        diagnostics.push(Diagnostic::error("odd").at(at(0)));
        assert_eq!((diagnostics.warnings(), diagnostics.errors()), (8, 1));
        assert_eq!(
            diagnostics.summary().as_deref(),
            Some("1 error and 8 warnings")
        );
        assert_eq!(diagnostics.kept().len(), PLACES_KEPT + 1);
        let text = diagnostics.render(&SourceMap::new(), Style::Plain);
        assert_eq!(
            text.matches("the same at other places: 3 more").count(),
            1,
            "{text}"
        );
    }

    /// Errors are not crowded out by warnings, and neither exhausts memory.
    #[test]
    fn much_is_neither_printed_nor_kept() {
        let diagnostics = Diagnostics::new();
        for i in 0..20_000 {
            diagnostics.push(Diagnostic::warning(format!("warning {i}")));
            diagnostics.push(Diagnostic::error(format!("error {i}")));
        }
        assert_eq!(
            (diagnostics.errors(), diagnostics.kept().len()),
            (20_000, KEPT)
        );
        let text = diagnostics.render(&SourceMap::new(), Style::Plain);
        assert_eq!(text.matches("error: error").count(), PRINTED);
        assert_eq!(text.matches("… and 19,997 more like it").count(), 1);
        assert!(text.ends_with("… and 19900 more problems\n\n"), "{text}");
    }

    #[test]
    fn suggestions_are_for_readers() {
        let diagnostics = Diagnostics::new();
        for i in 0..200 {
            let searched = Cell::new(false);
            let known = ["raduis"].into_iter().inspect(|_| searched.set(true));
            let error = Diagnostic::error(format!("error {i}")).at(at(i));
            diagnostics.push_with_nearest(error, "radius", known);
            assert_eq!(searched.get(), i < PRINTED as u32, "{i}");
        }
        let helped = |kept: &Diagnostic| kept.help == ["did you mean `raduis`?"];
        assert!(diagnostics.kept().iter().take(PRINTED).all(helped));
    }

    #[test]
    fn colors_are_for_those_who_want_them() {
        for (terminal, no_color, expected) in [
            (true, None, Style::Colored),
            (true, Some(""), Style::Colored),
            (true, Some("0"), Style::Plain),
            (false, None, Style::Plain),
        ] {
            assert_eq!(Style::suited(terminal, no_color.map(OsStr::new)), expected);
        }
    }

    #[test]
    fn color_is_for_terminals() {
        let diagnostic = Diagnostic::error("red");
        let sources = SourceMap::new();
        assert_eq!(diagnostic.render(&sources, Style::Plain), "error: red");
        assert!(diagnostic.render(&sources, Style::Colored).contains('\x1b'));
    }
}
