//! The parser: a stream of directives from a file and everything it includes.
//!
//! Open files are kept on an explicit stack, so that includes nest as deeply as memory allows; as in pbrt-v3 an
//! included file is a sequence of tokens, and a parameter list begun in it may continue after it. After a syntax error
//! the parser reports it, skips to the next directive's word, and continues.
//!
//! The meaning of a pbrt-v3 scene is never changed. Where pbrt-v3 stops, or silently drops something, this parser does
//! the following:
//!
//! | in the file | pbrt-v3 | here |
//! |---|---|---|
//! | byte-order mark (UTF-8) | unknown directive | skipped |
//! | UTF-16 | unknown directive | error naming the encoding |
//! | form feed, vertical tab | part of a word | blank |
//! | `1,2` `2deg` `1.2.3` `40#note` | tail dropped silently | tail dropped, warning |
//! | `nan` | accepted | error: not a number |
//! | `inf` | accepted | accepted in parameters, error in transforms |
//! | `true`, `false` without quotes | fatal | accepted for `bool` |
//! | backslash that starts no escape | fatal | kept, warning |
//! | `LookAt [ … ]`, `Translate [ … ]`, … | fatal | accepted, warning |
//! | `Transform` without brackets | fatal | accepted, warning |
//! | missing `]` before a directive | fatal | error, list taken as closed |
//! | include cycle | runs until memory is exhausted | error naming the cycle |
//! | include found only next to the including file | error | accepted, warning |
//! | directives of pbrt-v2 | fatal | passed on |
//! | `Include` among parameters, as in pbrt-v2 | fatal | followed, and recorded in the directive |

use super::diagnostic::{Diagnostic, Diagnostics};
use super::directive::{Directive, WORDS};
use super::files::SearchFolder;
use super::lexer::lexeme;
use super::number::number;
use super::source::{FileId, SourceMap, Span};
use super::suggest::nearest;
use super::token::{Token, TokenKind};
use crate::files::FileProblem;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Maximum number of inclusions, more than any scene has (the largest public ones have some thousand); a few files that
/// include each other's successors twice would otherwise keep the parser busy for years without any cycle.
const MAX_INCLUDES: usize = 50_000;

/// Maximum number of bytes included repeatedly: even a large file of comments would keep the parser busy.
const MAX_REPEATED: u64 = 16 << 30;

/// Maximum number of files of a cycle that are named; the middle of longer ones is omitted.
const CYCLE_NAMED: usize = 10;

/// The directive cannot be parsed; this has been reported.
#[derive(Debug)]
pub(super) struct Abandoned;

/// The result of parsing part of a directive.
pub(super) type Parsed<T> = Result<T, Abandoned>;

/// A file being parsed.
#[derive(Debug)]
pub(super) struct OpenFile {
    pub file: FileId,
    pub bytes: Rc<Vec<u8>>,
    pub at: usize,
    /// Path without links and detours, for identification.
    canonical: PathBuf,
}

/// Words of other renderers, each list with a note on it.
const FOREIGN: [(&[&str], &str); 3] = [
    (
        &V4_WORDS,
        "this word belongs to pbrt-v4; pbrt-v3 scenes are read here",
    ),
    (
        &[
            "LightGroup",
            "Exterior",
            "Interior",
            "PortalShape",
            "MakeNamedVolume",
            "MotionBegin",
            "MotionEnd",
        ],
        "this word belongs to LuxRender, whose scenes only resemble pbrt's",
    ),
    (
        &["SearchPath"],
        "this word belongs to pbrt-v1; files are looked for beside the scene",
    ),
];

const V4_WORDS: [&str; 4] = ["Option", "Attribute", "ColorSpace", "Import"];

/// The note on a word of another renderer.
fn foreign(word: &str) -> Option<&'static str> {
    let mut lists = FOREIGN.iter();
    let (_, note) = lists.find(|(words, _)| words.contains(&word))?;
    Some(note)
}

/// First bytes of files that are no plain text, what they are, and the remedy.
const UNREADABLE: [(&[u8], &str, &str); 3] = [
    (b"\xff\xfe", "UTF-16", "save it as UTF-8 or ASCII"),
    (b"\xfe\xff", "UTF-16", "save it as UTF-8 or ASCII"),
    (b"\x1f\x8b", "compressed", "unpack it with gunzip"),
];

/// Reads directives one by one; an iterator. Problems go to the diagnostics it was given.
pub struct Parser<'a> {
    pub(super) sources: &'a SourceMap,
    pub(super) diagnostics: &'a Diagnostics,
    /// The main file's search folder, where `Include` looks.
    search: SearchFolder,
    pub(super) open: Vec<OpenFile>,
    open_paths: HashSet<PathBuf>,
    includes: usize,
    /// Bytes of files beyond their first inclusion.
    repeated: u64,
    max_repeated: u64,
    /// Number of inclusions of each file.
    included: HashMap<PathBuf, usize>,
    peeked: Option<Token>,
    /// Location of the word of the current directive.
    pub(super) statement: Span,
    /// See [`Directive::include_in_list`], for the current directive.
    pub(super) include_in_list: Option<Span>,
    /// A comma separates numbers (pbrt-v2, which reports it); else what follows it in a word is passed over (pbrt-v3).
    pub commas_separate: bool,
}

impl<'a> Parser<'a> {
    /// A parser that starts at the beginning of `main`.
    pub fn new(sources: &'a SourceMap, main: FileId, diagnostics: &'a Diagnostics) -> Self {
        let path = sources.path(main);
        let mut parser = Self {
            sources,
            diagnostics,
            search: sources.search_folder(main),
            open: Vec::new(),
            open_paths: HashSet::new(),
            includes: 0,
            repeated: 0,
            max_repeated: MAX_REPEATED,
            included: HashMap::new(),
            peeked: None,
            statement: main.span(0..0),
            include_in_list: None,
            commas_separate: false,
        };
        let canonical = path.canonicalize().unwrap_or(path);
        parser.enter(main, canonical);
        parser
    }

    fn enter(&mut self, file: FileId, canonical: PathBuf) {
        let bytes = self.sources.bytes(file).unwrap_or_default();
        let mut at = 0;
        if bytes.starts_with(b"\xef\xbb\xbf") {
            at = 3;
        }
        for (magic, what, remedy) in UNREADABLE {
            if bytes.starts_with(magic) {
                let diagnostic = Diagnostic::error(format!("this file is {what}"));
                self.report(diagnostic.at(file.span(0..2)).with_help(remedy));
                at = bytes.len();
            }
        }
        self.open_paths.insert(canonical.clone());
        self.open.push(OpenFile {
            file,
            bytes,
            at,
            canonical,
        });
    }

    pub(super) fn leave(&mut self) {
        if let Some(done) = self.open.pop() {
            self.open_paths.remove(&done.canonical);
            self.sources.release(done.file);
        }
    }

    pub(super) fn report(&self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    /// The next token of the innermost file; `End` at its end.
    pub(super) fn token_of_file(&mut self) -> Token {
        let Some(open) = self.open.last_mut() else {
            return Token {
                kind: TokenKind::End,
                span: FileId(0).span(0..0),
                bytes: Rc::default(),
            };
        };
        let bytes = Rc::clone(&open.bytes);
        let (kind, start, end) = match lexeme(bytes.get(open.at..).unwrap_or_default()) {
            Some((found, blanks, rest)) => (
                Token::kind_of(found),
                open.at + blanks,
                bytes.len() - rest.len(),
            ),
            None => (TokenKind::End, bytes.len(), bytes.len()),
        };
        open.at = end;
        let span = open.file.span(start as u32..end as u32);
        Token { kind, span, bytes }
    }

    /// Consumes the next token; continues in the including file at the end of a file.
    pub(super) fn bump(&mut self) -> Token {
        if let Some(token) = self.peeked.take() {
            return token;
        }
        loop {
            let token = self.token_of_file();
            if token.kind != TokenKind::End || self.open.len() <= 1 {
                return token;
            }
            self.leave();
        }
    }

    /// Returns the next token without consuming it.
    pub(super) fn peek(&mut self) -> &Token {
        let token = self.bump();
        self.peeked.insert(token)
    }

    /// Skips to the next directive's word, or a possible misspelling of one, without a message: the reason has been
    /// reported.
    fn resynchronize(&mut self) {
        loop {
            let next = self.peek();
            match next.kind {
                TokenKind::End => return,
                TokenKind::Bare
                    if directive_word(next.text()).is_some() || looks_like_a_directive(next) =>
                {
                    return;
                }
                _ => drop(self.bump()),
            }
        }
    }

    /// Returns `true` if this token, which no directive begins with, is the first of a file on disk, and nothing that a
    /// person would write there by mistake: the file need not be a scene at all.
    fn begins_something_else(&self, token: &Token) -> bool {
        let before = token.bytes.get(..token.span.start as usize);
        let is_first = lexeme(before.unwrap_or_default()).is_none();
        let text = String::from_utf8_lossy(token.text());
        is_first
            && self.sources.is_on_disk(token.span.file)
            && foreign(&text).is_none()
            && nearest(&text, WORDS).is_none()
    }

    /// Reports, without quoting it, that the file starting with `token` is not a scene, and closes it.
    fn not_a_scene(&mut self, token: &Token) {
        let name = self.sources.path(token.span.file);
        let diagnostic = Diagnostic::error(format!(
            "`{}` is not a scene file: it does not begin with a directive",
            name.display()
        ));
        self.report(match self.sources.included_at(token.span.file) {
            Some(include) => diagnostic.at(include),
            None => diagnostic,
        });
        if let Some(open) = self.open.last_mut() {
            open.at = open.bytes.len();
        }
    }

    fn not_a_directive(&self, token: &Token) {
        let found = token.description();
        let text = String::from_utf8_lossy(token.text()).into_owned();
        let diagnostic =
            Diagnostic::error(format!("expected a directive, found {found}")).at(token.span);
        if token.kind == TokenKind::Bare
            && let Some(note) = foreign(&text)
        {
            if V4_WORDS.contains(&text.as_str()) {
                self.diagnostics.looks_like_v4();
            }
            return self.report(diagnostic.with_note(note));
        }
        self.report(match (token.kind, text.as_str()) {
            (TokenKind::Bare, _) if number(token.text()).is_some() => {
                diagnostic.label("one number too many?")
            }
            (TokenKind::Bare, word) => {
                let near = nearest(word, WORDS);
                let named = diagnostic.label("no directive has this name");
                if near.is_none() && word.starts_with(|c: char| c.is_ascii_lowercase()) {
                    named.with_help("parameters stand in quotes, like \"float radius\"")
                } else {
                    named.with_suggestion(near)
                }
            }
            (TokenKind::Unterminated, _) => {
                diagnostic.label("this string does not end on its line")
            }
            _ => diagnostic.label("directives start with a word without quotes"),
        });
    }

    /// Continues in the file that is named next. Returns `false` if it does not exist, which is reported.
    pub(super) fn include(&mut self, word: Span) -> Parsed<bool> {
        let name = self.name("Include", "the name of a file")?;
        let path = match self.search.resolve(&name.text) {
            Ok(Some(path)) => path,
            Ok(None) => self.beside_includer(&name),
            Err(problem) => {
                let message = format!("cannot include `{}`: {problem}", name.text);
                self.report(Diagnostic::error(message).at(name.span).recoverable());
                return Ok(false);
            }
        };
        let canonical = path.canonicalize().unwrap_or_else(|_| path.clone());
        if self.open_paths.contains(&canonical) {
            let circle = self.circle(&canonical);
            let message = format!("files include each other in a circle: {circle}");
            let error = Diagnostic::error(message).at(name.span);
            self.report(error.label("this file is being read already"));
            return Ok(true);
        }
        if self.includes >= MAX_INCLUDES {
            self.too_many_includes(word, &format!("{MAX_INCLUDES} inclusions"));
            return Ok(true);
        }
        self.includes += 1;
        let times = self.included.entry(canonical.clone()).or_default();
        *times += 1;
        if *times > 1 {
            self.repeated += path.metadata().map_or(0, |metadata| metadata.len());
            if self.repeated > self.max_repeated {
                let much = format!("{} bytes included again", self.max_repeated);
                self.too_many_includes(word, &much);
                return Ok(true);
            }
        }
        match self.sources.include(&path, word) {
            Ok(file) => {
                self.enter(file, canonical);
                Ok(true)
            }
            Err(error) => {
                let diagnostic = Diagnostic::error(format!("cannot include this file: {error}"))
                    .at(name.span)
                    .recoverable()
                    .failed_if(error.problem.is_failure())
                    .with_note("the directory of the main scene file is where `Include` looks");
                self.report(match error.problem {
                    FileProblem::Missing => diagnostic.missing(&name.text),
                    _ => diagnostic,
                });
                Ok(false)
            }
        }
    }

    /// Follows an `Include` between directives.
    fn include_directives(&mut self, word: Span) -> Parsed<()> {
        if !self.include(word)? {
            // A list that would have continued after the file now belongs to nothing.
            drop(self.parameters()?);
        }
        Ok(())
    }

    /// Follows every `Include` that comes next among parameters, as pbrt-v2's lexer does; the caller checks whether
    /// what follows still is a parameter. Returns the last one.
    pub(super) fn follow_includes(&mut self) -> Parsed<Option<Span>> {
        let mut last = None;
        while self.peek().is_word("Include") {
            let word = self.bump().span;
            self.include(word)?;
            last = Some(word);
        }
        Ok(last)
    }

    /// Reports an `Include` beyond the limit, and the file that was included most often.
    fn too_many_includes(&self, word: Span, limit: &str) {
        let most = self.included.iter().max_by_key(|&(path, n)| (n, path));
        let message = format!("more than {limit}: no more are followed");
        let diagnostic = Diagnostic::error(message).at(word);
        self.report(match most {
            Some((path, n)) => {
                diagnostic.with_note(format!("`{}` alone was included {n} times", path.display()))
            }
            None => diagnostic,
        });
    }

    /// The path relative to the file with the `Include`, as people expect, for a file that is not found from the main
    /// file's folder.
    fn beside_includer(&self, name: &super::Name) -> PathBuf {
        let beside = self.sources.search_folder(name.span.file);
        let Ok(Some(beside)) = beside.resolve(&name.text) else {
            return self.search.directory.join(&name.text);
        };
        let message = format!("`{}` was found beside the including file only", name.text);
        let warning = Diagnostic::warning(message).at(name.span);
        self.report(warning.with_note("pbrt-v3 looks in the directory of the main scene file"));
        beside
    }

    /// Formats a cycle as `a.pbrt -> b.pbrt -> a.pbrt`, omitting the middle of a long one.
    fn circle(&self, canonical: &Path) -> String {
        let start = self
            .open
            .iter()
            .position(|open| open.canonical == canonical)
            .unwrap_or(0);
        let file_name = |path: &Path| {
            let name = path.file_name().unwrap_or(path.as_os_str());
            name.to_string_lossy().into_owned()
        };
        let members = self.open[start..].iter();
        let mut names: Vec<String> = members.map(|open| file_name(&open.canonical)).collect();
        if names.len() > CYCLE_NAMED {
            let left_out = names.len() - CYCLE_NAMED;
            let middle = CYCLE_NAMED / 2..names.len() - CYCLE_NAMED / 2;
            names.splice(middle, [format!("… {left_out} more …")]);
        }
        names.push(file_name(canonical));
        names.join(" -> ")
    }
}

impl Iterator for Parser<'_> {
    type Item = Directive;

    /// The next directive that could be parsed, with `Include`s followed.
    fn next(&mut self) -> Option<Directive> {
        loop {
            let token = self.bump();
            let word = match token.kind {
                TokenKind::End => {
                    self.leave();
                    return None;
                }
                TokenKind::Bare => directive_word(token.text()),
                _ => None,
            };
            self.statement = token.span;
            self.include_in_list = None;
            let read = match word {
                Some("Include") => self.include_directives(token.span).map(|()| None),
                Some(word) => self.statement(word).map(Some),
                None => {
                    if self.begins_something_else(&token) {
                        self.not_a_scene(&token);
                    } else {
                        self.not_a_directive(&token);
                    }
                    Err(Abandoned)
                }
            };
            match read {
                Ok(Some(kind)) => {
                    return Some(Directive {
                        span: token.span,
                        kind,
                        include_in_list: self.include_in_list,
                    });
                }
                Ok(None) => {}
                Err(Abandoned) => self.resynchronize(),
            }
        }
    }
}

/// Returns `true` for the first word of a line, consisting of letters, that is capitalized or similar to a directive.
fn looks_like_a_directive(token: &Token) -> bool {
    let before = token.bytes.get(..token.span.start as usize);
    let indent = before.unwrap_or_default().iter().rev();
    let starts_line = indent
        .take_while(|byte| !matches!(byte, b'\n' | b'\r'))
        .all(|byte| matches!(byte, b' ' | b'\t'));
    let word = token.text();
    if !starts_line || !word.iter().all(u8::is_ascii_alphabetic) {
        return false;
    }
    word.first().is_some_and(u8::is_ascii_uppercase)
        || nearest(&String::from_utf8_lossy(word), WORDS).is_some()
}

/// The directive that a word starts, if any.
pub(super) fn directive_word(text: &[u8]) -> Option<&'static str> {
    WORDS.into_iter().find(|word| word.as_bytes() == text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_that_are_included_again_have_a_limit() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("part"), "Identity # and more\n").expect("a file");
        std::fs::write(path("all"), "Include \"part\"\n".repeat(8)).expect("a file");
        for (limit, read) in [(7 * 20, 8), (3 * 20, 4), (0, 1)] {
            let (sources, diagnostics) = (SourceMap::new(), Diagnostics::new());
            let main = sources.open(&path("all")).expect("the scene");
            let mut parser = Parser::new(&sources, main, &diagnostics);
            parser.max_repeated = limit;
            assert_eq!(parser.by_ref().count(), read);
            assert_eq!(diagnostics.errors(), 8 - read);
        }
    }
}
