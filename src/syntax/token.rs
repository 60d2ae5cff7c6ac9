//! Tokens with their places, as the parser passes them around.

use super::lexer::{Lexeme, unescape};
use super::source::Span;
use std::rc::Rc;

/// What sort of token it is.
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

/// A token that keeps its file's bytes alive while it is looked at.
#[derive(Clone, Debug)]
pub(super) struct Token {
    pub kind: TokenKind,
    pub span: Span,
    pub bytes: Rc<Vec<u8>>,
}

/// Longer words are cut in messages.
const SHOWN: usize = 40;

impl Token {
    pub fn kind_of(lexeme: Lexeme<'_>) -> TokenKind {
        match lexeme {
            Lexeme::Open => TokenKind::Open,
            Lexeme::Close => TokenKind::Close,
            Lexeme::Quoted(_) => TokenKind::Quoted,
            Lexeme::Unterminated(_) => TokenKind::Unterminated,
            Lexeme::Bare(_) => TokenKind::Bare,
        }
    }

    /// The token as written.
    pub fn text(&self) -> &[u8] {
        self.bytes
            .get(self.span.start as usize..self.span.end as usize)
            .unwrap_or_default()
    }

    /// Is it this word?
    pub fn is_word(&self, word: &str) -> bool {
        self.kind == TokenKind::Bare && self.text() == word.as_bytes()
    }

    /// The contents of a string, escapes resolved, and whether there was a stray backslash.
    pub fn string(&self) -> (String, bool) {
        let text = self.text();
        let inner = text.strip_prefix(b"\"").unwrap_or(text);
        let (plain, stray) = unescape(inner.strip_suffix(b"\"").unwrap_or(inner));
        (String::from_utf8_lossy(&plain).into_owned(), stray)
    }

    /// How a message calls it.
    pub fn description(&self) -> String {
        let text = String::from_utf8_lossy(self.text());
        let mut shown: String = text.trim_end().chars().take(SHOWN).collect();
        if shown.len() < text.trim_end().len() {
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
