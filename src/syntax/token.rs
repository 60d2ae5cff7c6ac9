//! Tokens with their locations, as used by the parser.

use super::lexer::{Lexeme, unescape};
use super::source::Span;
use std::fmt;
use std::rc::Rc;

/// The kind of a token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TokenKind {
    Open,
    Close,
    Quoted,
    Unterminated,
    Bare,
    /// The end of the last file.
    End,
}

/// A token, which keeps its file's bytes alive while it is examined.
#[derive(Clone, Debug)]
pub(super) struct Token {
    pub kind: TokenKind,
    pub span: Span,
    pub bytes: Rc<Vec<u8>>,
}

/// Maximum length of a word in messages; longer ones are truncated.
const SHOWN: usize = 40;

impl Token {
    pub(super) fn kind_of(lexeme: Lexeme<'_>) -> TokenKind {
        match lexeme {
            Lexeme::Open => TokenKind::Open,
            Lexeme::Close => TokenKind::Close,
            Lexeme::Quoted(_) => TokenKind::Quoted,
            Lexeme::Unterminated(_) => TokenKind::Unterminated,
            Lexeme::Bare(_) => TokenKind::Bare,
        }
    }

    /// The token as written.
    pub(super) fn text(&self) -> &[u8] {
        self.bytes
            .get(self.span.start as usize..self.span.end as usize)
            .unwrap_or_default()
    }

    /// Returns `true` if it is this word.
    pub(super) fn is_word(&self, word: &str) -> bool {
        self.kind == TokenKind::Bare && self.text() == word.as_bytes()
    }

    /// The contents of a string with escapes resolved, and whether there was a stray backslash.
    pub(super) fn string(&self) -> (String, bool) {
        let text = self.text();
        let inner = text.strip_prefix(b"\"").unwrap_or(text);
        let (plain, stray) = unescape(inner.strip_suffix(b"\"").unwrap_or(inner));
        (String::from_utf8_lossy(&plain).into_owned(), stray)
    }

    /// A description for messages.
    pub(super) fn description(&self) -> String {
        let text = String::from_utf8_lossy(self.text());
        let text = text.trim_end_matches(|c: char| c.is_ascii_whitespace());
        let mut shown: String = text
            .chars()
            .take(SHOWN)
            .map(Shown)
            .map(|c| c.to_string())
            .collect();
        if text.chars().count() > SHOWN {
            shown.push('…');
        }
        match self.kind {
            TokenKind::End => "the end of the file".to_owned(),
            TokenKind::Quoted => format!("the string `{shown}`"),
            TokenKind::Unterminated => format!("the unfinished string `{shown}`"),
            TokenKind::Open | TokenKind::Close | TokenKind::Bare => format!("`{shown}`"),
        }
    }
}

/// A character as it is printed: by its number where it would not be seen, as blanks that are pasted with a word from elsewhere.
struct Shown(char);

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Shown(c) = *self;
        let is_unseen = !c.is_ascii() && (c.is_whitespace() || is_format(c));
        match is_unseen {
            true => write!(f, "⟨U+{:04X}⟩", u32::from(c)),
            false => write!(f, "{c}"),
        }
    }
}

/// Characters without width: soft hyphens, joiners, marks of direction and of byte order.
fn is_format(c: char) -> bool {
    matches!(c, '\u{ad}' | '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
}
