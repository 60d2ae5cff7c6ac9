//! Diagnostics as text: the message, the affected line with a caret, and the chain of includes.
//!
//! Drawing is left to `annotate-snippets`, which draws like rustc. It gets only the part of a line around the caret,
//! since one line may be a mesh of many megabytes.

use super::diagnostic::{Diagnostic, Severity, Style};
use super::lexer::{Lexeme, lexeme};
use super::source::{SourceMap, Span};
use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use std::ops::Range;

/// Maximum bytes of a line that are shown: one and a half times a terminal's width.
const SHOWN: usize = 120;

/// Bytes shown before the caret.
const SHOWN_BEFORE: usize = 40;

/// Maximum number of `Include`s listed; the chain may be ten thousand long.
const CHAIN: usize = 5;

/// A line, or the visible part of it, ready to be drawn.
struct Excerpt {
    line: usize,
    column: usize,
    text: String,
    /// Byte range in `text`.
    marked: Range<usize>,
}

impl Diagnostic {
    /// The problem as text of several lines, without a final line break.
    pub fn render(&self, sources: &SourceMap, style: Style) -> String {
        let level = match self.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
            Severity::Note => Level::NOTE,
        };
        let mut group = Group::with_title(level.primary_title(self.message.as_str()));
        let primary = self.span.map(|whole| {
            let item = self.item.and_then(|item| item_span(sources, whole, item));
            let span = item.unwrap_or(whole);
            (span, self.label.as_deref(), AnnotationKind::Primary)
        });
        let related = self
            .related
            .iter()
            .map(|(span, text)| (*span, Some(text.as_str()), AnnotationKind::Context));
        let mut moved = Vec::new();
        for (span, label, kind) in primary.into_iter().chain(related) {
            let path = sources.path(span.file).display().to_string();
            let Some(excerpt) = excerpt(sources, span) else {
                group = group.element(Origin::path(path));
                continue;
            };
            moved.extend(excerpt.moved(&path));
            let marked = kind.span(excerpt.marked).label(label);
            group = group.element(
                Snippet::source(excerpt.text)
                    .path(path)
                    .line_start(excerpt.line)
                    .annotation(marked),
            );
        }
        let inclusions = self.span.map(|span| inclusions(sources, span));
        for note in self
            .notes
            .iter()
            .cloned()
            .chain(inclusions.into_iter().flatten())
        {
            group = group.element(Level::NOTE.message(note));
        }
        for help in &self.help {
            group = group.element(Level::HELP.message(help.as_str()));
        }
        let renderer = match style {
            Style::Plain => Renderer::plain(),
            Style::Colored => Renderer::styled(),
        };
        // The excerpt has already been cut to size; the margin holds the line number.
        let text = renderer.term_width(SHOWN + 40).render(&[group]).to_string();
        moved.into_iter().fold(text, |text, (shown, really)| {
            text.replacen(&shown, &really, 1)
        })
    }
}

/// The location of an item, counted from 0, of the list of values at `list`.
fn item_span(sources: &SourceMap, list: Span, item: usize) -> Option<Span> {
    let bytes = sources.bytes(list.file)?;
    let whole = bytes.get(list.start as usize..list.end as usize)?;
    let mut rest = whole;
    let mut items = 0;
    while let Some((found, blanks, after)) = lexeme(rest) {
        let is_item = !matches!(found, Lexeme::Open | Lexeme::Close);
        if is_item && items == item {
            let place = |left: usize| list.start + (whole.len() - left) as u32;
            let bytes = place(rest.len() - blanks)..place(after.len());
            return Some(list.file.span(bytes));
        }
        items += usize::from(is_item);
        rest = after;
    }
    None
}

impl Excerpt {
    /// `annotate-snippets` counts columns in the text it is given. If that does not start at the start of the line,
    /// this returns the location as it will print it, and the true one.
    fn moved(&self, path: &str) -> Option<(String, String)> {
        let shown = self.text.get(..self.marked.start)?.chars().count() + 1;
        let place = |column: usize| format!("{path}:{}:{column}", self.line);
        (shown != self.column).then(|| (place(shown), place(self.column)))
    }
}

/// The chain of includes that led to a location's file, innermost first.
fn inclusions(sources: &SourceMap, span: Span) -> Vec<String> {
    let mut chain = Vec::new();
    let mut from = sources.included_at(span.file);
    let mut more = 0;
    while let Some(at) = from {
        if chain.len() < CHAIN {
            let path = sources.path(at.file);
            let path = path.display();
            chain.push(match sources.locate(at) {
                Some(place) => format!("included from {path}:{}:{}", place.line, place.column),
                None => format!("included from {path}"),
            });
        } else {
            more += 1;
        }
        from = sources.included_at(at.file);
    }
    if more > 0 {
        chain.push(format!("… and so on, {more} more"));
    }
    chain
}

fn excerpt(sources: &SourceMap, span: Span) -> Option<Excerpt> {
    let bytes = sources.bytes(span.file)?;
    let place = sources.locate(span)?;
    let start = span.start as usize;
    let line_start = bytes
        .get(..start)?
        .iter()
        .rposition(|&b| b == b'\n')
        .map_or(0, |at| at + 1);
    let mut lines = bytes[start..].split(|&b| b == b'\n');
    let rest = lines.next().unwrap_or_default();
    let line_end = start + rest.strip_suffix(b"\r").unwrap_or(rest).len();
    let (from, to) = window(&bytes, line_start..line_end, start);
    let marked_to = (span.end as usize).clamp(start, to);

    let text_of = |range: Range<usize>| String::from_utf8_lossy(&bytes[range]).into_owned();
    let mut text = String::from(if from > line_start { "…" } else { "" });
    text += &text_of(from..start);
    let marked_start = text.len();
    text += &text_of(start..marked_to);
    let marked = marked_start..text.len();
    text += &text_of(marked_to..to);
    text += if to < line_end { "…" } else { "" };
    Some(Excerpt {
        line: place.line,
        column: place.column,
        text,
        marked,
    })
}

/// The visible part of a line, which contains `caret` and does not split a UTF-8 character.
fn window(bytes: &[u8], line: Range<usize>, caret: usize) -> (usize, usize) {
    if line.len() <= SHOWN {
        return (line.start, line.end);
    }
    let continues = |at: usize| at < line.end && bytes[at] & 0xc0 == 0x80;
    let mut from = caret.saturating_sub(SHOWN_BEFORE).max(line.start);
    let mut to = (from + SHOWN).min(line.end);
    // A character has at most three continuation bytes; more of them are not text.
    for _ in 0..3 {
        from += usize::from(from < caret && continues(from));
        to += usize::from(continues(to));
    }
    (from, to)
}
