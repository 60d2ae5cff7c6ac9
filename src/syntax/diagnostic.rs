//! Problems found in a scene: collected while reading, printed together at the end.
//!
//! A [`Diagnostics`] is shared by reference between the parser, the parameter readers and the
//! scene; it takes reports through `&self` and keeps them in the order they were met, which is
//! the order of the file. The same message at the same place is kept once, and of a message that
//! comes from many places only the first few are kept and the rest counted, so that a million
//! shapes with the same misspelt parameter make neither a million lines nor fill the memory.

use super::groups::Groups;
use super::source::{SourceMap, Span};
use super::suggest::nearest;
use std::cell::RefCell;
use std::collections::HashMap;
use std::ffi::OsStr;
use std::io::IsTerminal;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Severity {
    /// The scene does not mean what its author wanted, or means nothing: no rendering.
    Error,
    /// Something was ignored or replaced by a default; rendering goes on.
    Warning,
    /// Worth knowing.
    Note,
}

/// How text is dressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Text alone, for files and pipes.
    Plain,
    /// With ANSI colors, for terminals.
    Colored,
}

impl Style {
    /// What suits standard error: colors where it is a terminal and `NO_COLOR` is not set.
    pub fn of_stderr() -> Self {
        let no_color = std::env::var_os("NO_COLOR");
        Self::suited(std::io::stderr().is_terminal(), no_color.as_deref())
    }

    /// As <https://no-color.org> has it: any text in `NO_COLOR` counts, an empty one does not.
    fn suited(terminal: bool, no_color: Option<&OsStr>) -> Self {
        if terminal && no_color.is_none_or(OsStr::is_empty) {
            Self::Colored
        } else {
            Self::Plain
        }
    }
}

/// One problem.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// One line, no full stop at its end.
    pub message: String,
    /// Where.
    pub span: Option<Span>,
    /// Which item of the list at `span` is meant, from 0; `None` for the whole of it. Where the
    /// item stands is found out when the message is printed, so that places of a million numbers
    /// need not be kept.
    pub item: Option<usize>,
    /// Is it an error that pbrt-v3 reports and renders on after, such as a file that cannot be used or
    /// a name that nobody has defined? Something stands in its place, so the rest can be rendered
    /// (`--keep-going`).
    pub recoverable: bool,
    /// The name of the file that is not there, as the scene gives it: those of one folder are told
    /// together.
    pub missing: Option<String>,
    /// What stands beside the caret.
    pub label: Option<String>,
    /// Other places that matter, with what to say about them.
    pub related: Vec<(Span, String)>,
    /// Facts below the excerpt.
    pub notes: Vec<String>,
    /// Advice below the excerpt.
    pub help: Vec<String>,
}

impl Diagnostic {
    fn new(severity: Severity, message: impl Into<String>) -> Self {
        Self {
            severity,
            message: message.into(),
            span: None,
            item: None,
            recoverable: false,
            missing: None,
            label: None,
            related: Vec::new(),
            notes: Vec::new(),
            help: Vec::new(),
        }
    }

    /// An error without a place.
    pub fn error(message: impl Into<String>) -> Self {
        Self::new(Severity::Error, message)
    }

    /// A warning without a place.
    pub fn warning(message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, message)
    }

    /// A note without a place.
    pub fn note(message: impl Into<String>) -> Self {
        Self::new(Severity::Note, message)
    }

    /// Puts the caret.
    pub fn at(mut self, span: Span) -> Self {
        self.span = Some(span);
        self
    }

    /// Puts the caret under one item, counted from 0, of the list of values at `span`.
    pub fn at_item(mut self, span: Span, item: usize) -> Self {
        self.span = Some(span);
        self.item = Some(item);
        self
    }

    /// Something stands in the place of what is wrong: see [`recoverable`](field@Diagnostic::recoverable).
    pub fn recoverable(mut self) -> Self {
        self.recoverable = true;
        self
    }

    /// There is no file of this name: see [`missing`](field@Diagnostic::missing).
    pub fn missing(mut self, name: &str) -> Self {
        self.missing = Some(name.to_owned());
        self
    }

    /// Says something beside the caret.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = Some(label.into());
        self
    }

    /// Points at another place as well.
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

    /// Adds "did you mean" where there is something to propose.
    pub fn with_suggestion(self, suggestion: Option<&str>) -> Self {
        match suggestion {
            Some(word) => self.with_help(format!("did you mean `{word}`?")),
            None => self,
        }
    }
}

/// How many places of one message are kept; a person mending a file sees the pattern by then.
const PLACES_KEPT: usize = 5;

/// How many errors, and how many warnings and notes, are printed. More than a person reads.
const PRINTED: usize = 100;

/// How many distinct problems are kept at all, so that a file of noise cannot fill the memory.
const KEPT: usize = 10_000;

/// How often a message was met.
#[derive(Debug)]
struct Seen {
    /// Different from the one before.
    places: usize,
    last_span: Option<Span>,
    /// Position of the last one kept in `State::kept`.
    last_kept: usize,
}

#[derive(Debug)]
struct Kept {
    diagnostic: Diagnostic,
    /// The same message at places not kept.
    elsewhere: usize,
}

#[derive(Debug, Default)]
struct State {
    kept: Vec<Kept>,
    /// Only ever looked up, never iterated: the order of a hash map is nobody's business.
    seen: HashMap<(Severity, String), Seen>,
    errors: usize,
    recoverable_errors: usize,
    warnings: usize,
    dropped: usize,
    groups: Groups,
    /// Things met that only pbrt-v4 has.
    v4_signs: usize,
}

/// Takes problems as they are met, through a shared reference.
#[derive(Debug, Default)]
pub struct Diagnostics {
    state: RefCell<State>,
}

impl Diagnostics {
    /// Nothing wrong so far.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes a problem.
    pub fn push(&self, diagnostic: Diagnostic) {
        let state = &mut *self.state.borrow_mut();
        let key = (diagnostic.severity, diagnostic.message.clone());
        let seen = state.seen.get_mut(&key);
        if seen
            .as_ref()
            .is_some_and(|seen| seen.last_span == diagnostic.span)
        {
            // A parameter read for several shapes is one mistake.
            return;
        }
        match diagnostic.severity {
            Severity::Error => {
                state.errors += 1;
                state.recoverable_errors += usize::from(diagnostic.recoverable);
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

    /// As [`Diagnostics::push`], with "did you mean" where one of `known` is near `word`. The search is
    /// left out where nobody would read its result, so that thousands of unknown names beside
    /// thousands of known ones take no time squared.
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

    /// Is there a chance that this problem is printed, were it pushed now?
    fn will_be_read(&self, diagnostic: &Diagnostic) -> bool {
        let state = self.state.borrow();
        let key = (diagnostic.severity, diagnostic.message.clone());
        let repeated = state
            .seen
            .get(&key)
            .is_some_and(|seen| seen.places >= PLACES_KEPT || seen.last_span == diagnostic.span);
        let severe = diagnostic.severity == Severity::Error;
        let same = |kept: &&Kept| (kept.diagnostic.severity == Severity::Error) == severe;
        // Those before it, and no more of them than are needed for the answer.
        !repeated
            && !state.groups.is_full(diagnostic)
            && state.kept.iter().filter(same).nth(PRINTED - 1).is_none()
    }

    /// Something was met that only pbrt-v4 has. One such thing may be a slip; of more, the text
    /// begins with what the scene is.
    pub fn looks_like_v4(&self) {
        self.state.borrow_mut().v4_signs += 1;
    }

    /// Errors met, those at places not kept included.
    pub fn errors(&self) -> usize {
        self.state.borrow().errors
    }

    /// How many of the errors leave a scene that can be rendered: see [`recoverable`](field@Diagnostic::recoverable).
    pub fn recoverable_errors(&self) -> usize {
        self.state.borrow().recoverable_errors
    }

    /// Warnings met, those at places not kept included.
    pub fn warnings(&self) -> usize {
        self.state.borrow().warnings
    }

    /// Was there at least one error?
    pub fn has_errors(&self) -> bool {
        self.errors() > 0
    }

    /// Nothing at all was reported.
    pub fn is_empty(&self) -> bool {
        self.state.borrow().kept.is_empty()
    }

    /// The problems kept, in the order they were met.
    pub fn kept(&self) -> Vec<Diagnostic> {
        self.state
            .borrow()
            .kept
            .iter()
            .map(|k| k.diagnostic.clone())
            .collect()
    }

    /// `2 errors and 1 warning`, for a closing line; `None` where there were neither.
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

    /// All of it as text: each problem with its excerpt, the first hundred errors and the first
    /// hundred warnings and notes in the order they were met, then how many there were besides. Many
    /// warnings of one kind are a few and a count, and so are missing files of one folder.
    pub fn render(&self, sources: &SourceMap, style: Style) -> String {
        let state = self.state.borrow();
        let mut text = String::new();
        if state.v4_signs > 1 {
            let said =
                Diagnostic::note("this is a pbrt-v4 scene, and fstop reads those of pbrt-v3");
            text = said.render(sources, style) + "\n\n";
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
                text += &complete.render(sources, style);
                text += "\n\n";
            }
        }
        let more = errors.saturating_sub(PRINTED) + others.saturating_sub(PRINTED) + state.dropped;
        if more > 0 {
            text += &format!("… and {more} more problems\n\n");
        }
        text
    }
}

impl Kept {
    /// With what was counted instead of kept.
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

    /// Errors are not crowded out by warnings, nor is the memory filled by either.
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
