//! Lexer: bytes to tokens (bare words, quoted strings, brackets), separated by white space and comments.
//!
//! The rules are pbrt-v3's (docs/scene-language.md §1.1): a comment starts with `#` at the start of a
//! token and ends with the line (`40#deg` is one word); a bare word ends at white space, a
//! quotation mark or a bracket; strings do not span lines.

use super::number::{ends_word, is_blank};
use nom::branch::alt;
use nom::bytes::complete::{is_not, tag, take_till, take_till1, take_while_m_n, take_while1};
use nom::combinator::{opt, recognize, value};
use nom::multi::many0_count;
use nom::sequence::{preceded, terminated};
use nom::{IResult, Parser};
use std::borrow::Cow;

type Lexed<'a, T> = IResult<&'a [u8], T, ()>;

/// The smallest unit of the language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lexeme<'a> {
    /// `[`
    Open,
    /// `]`
    Close,
    /// The text between two quotation marks, with escapes unresolved.
    Quoted(&'a [u8]),
    /// The text between a quotation mark and the end of its line.
    Unterminated(&'a [u8]),
    /// A keyword, a number, or something else.
    Bare(&'a [u8]),
}

/// The next token and the rest after it; `None` at the end. The token is the part of `input` before the rest, after
/// white space and comments: the second value is the number of bytes these took.
///
/// ```
/// use fstop::syntax::lexer::{Lexeme, lexeme};
/// let (found, blanks, rest) = lexeme(b" # a ball\n\"sphere\" [").unwrap();
/// assert_eq!(found, Lexeme::Quoted(b"sphere"));
/// assert_eq!((blanks, rest), (10, &b" ["[..]));
/// ```
pub fn lexeme(input: &[u8]) -> Option<(Lexeme<'_>, usize, &[u8])> {
    let (start, _) = blanks(input).ok()?;
    let (rest, found) = alt((
        value(Lexeme::Open, tag("[")),
        value(Lexeme::Close, tag("]")),
        quoted,
        bare,
    ))
    .parse(start)
    .ok()?;
    Some((found, input.len() - start.len(), rest))
}

fn blanks(input: &[u8]) -> Lexed<'_, usize> {
    many0_count(alt((take_while1(is_blank), comment))).parse(input)
}

fn comment(input: &[u8]) -> Lexed<'_, &[u8]> {
    preceded(tag("#"), take_till(|b| b == b'\n' || b == b'\r')).parse(input)
}

fn bare(input: &[u8]) -> Lexed<'_, Lexeme<'_>> {
    take_till1(ends_word).map(Lexeme::Bare).parse(input)
}

fn quoted(input: &[u8]) -> Lexed<'_, Lexeme<'_>> {
    let (input, _) = tag("\"").parse(input)?;
    // Not `none_of`: nom 8 takes a byte above 127 for a two-byte character there.
    let escape = || preceded(tag("\\"), take_while_m_n(1, 1, |b| b != b'\n'));
    let text = || recognize(many0_count(alt((is_not("\"\\\n"), escape()))));
    alt((
        terminated(text(), tag("\"")).map(Lexeme::Quoted),
        terminated(text(), opt(tag("\\"))).map(Lexeme::Unterminated),
    ))
    .parse(input)
}

/// A string with its escapes resolved (`\b \f \n \r \t \\ \' \"`), and whether it contained a backslash that starts
/// none of these; such a backslash is kept, as in Windows paths (pbrt-v3 stops).
pub fn unescape(text: &[u8]) -> (Cow<'_, [u8]>, bool) {
    if !text.contains(&b'\\') {
        return (Cow::Borrowed(text), false);
    }
    let mut plain = Vec::with_capacity(text.len());
    let mut stray = false;
    let mut bytes = text.iter().copied();
    while let Some(byte) = bytes.next() {
        if byte != b'\\' {
            plain.push(byte);
            continue;
        }
        match bytes.next() {
            Some(b'b') => plain.push(b'\x08'),
            Some(b'f') => plain.push(b'\x0c'),
            Some(b'n') => plain.push(b'\n'),
            Some(b'r') => plain.push(b'\r'),
            Some(b't') => plain.push(b'\t'),
            Some(same @ (b'\\' | b'\'' | b'"')) => plain.push(same),
            other => {
                stray = true;
                plain.push(b'\\');
                plain.extend(other);
            }
        }
    }
    (Cow::Owned(plain), stray)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn all(input: &[u8]) -> Vec<Lexeme<'_>> {
        let mut rest = input;
        std::iter::from_fn(|| {
            let (found, _, after) = lexeme(rest)?;
            rest = after;
            Some(found)
        })
        .collect()
    }

    #[test]
    fn tokens_of_every_kind() {
        use Lexeme::{Bare, Close, Open, Quoted};
        assert_eq!(
            all(b"Shape\"sphere\"\t[1 .5]# comment ] \"\r\nTranslate\x0c-1"),
            [
                Bare(b"Shape"),
                Quoted(b"sphere"),
                Open,
                Bare(b"1"),
                Bare(b".5"),
                Close,
                Bare(b"Translate"),
                Bare(b"-1")
            ]
        );
    }

    #[test]
    fn a_hash_inside_a_word_or_a_string_is_no_comment() {
        assert_eq!(
            all(b"40#deg note"),
            [Lexeme::Bare(b"40#deg"), Lexeme::Bare(b"note")]
        );
        assert_eq!(all(b"\"a # b\""), [Lexeme::Quoted(b"a # b")]);
    }

    #[test]
    fn a_comment_ends_at_cr_too() {
        assert_eq!(all(b"# old Mac\rIdentity"), [Lexeme::Bare(b"Identity")]);
    }

    #[test]
    fn strings_end_with_their_line() {
        assert_eq!(
            all(b"\"open\nIdentity"),
            [Lexeme::Unterminated(b"open"), Lexeme::Bare(b"Identity")]
        );
        assert_eq!(all(b"\"open\\"), [Lexeme::Unterminated(b"open")]);
        assert_eq!(all(b"\""), [Lexeme::Unterminated(b"")]);
        assert_eq!(all(b"\"\""), [Lexeme::Quoted(b"")]);
        assert_eq!(all(br#""a\"b""#), [Lexeme::Quoted(br#"a\"b"#)]);
        assert_eq!(all(b"\"\\\x80"), [Lexeme::Unterminated(b"\\\x80")]);
    }

    #[test]
    fn escapes() {
        assert_eq!(
            unescape(br#"\b\f\n\r\t\\\'\""#),
            (Cow::Borrowed(&b"\x08\x0c\n\r\t\\'\""[..]), false)
        );
        assert_eq!(
            unescape(br"textures\wood.png"),
            (Cow::Borrowed(&br"textures\wood.png"[..]), true)
        );
    }

    proptest! {
        /// Whatever the bytes, every step makes progress and only white space is skipped.
        #[test]
        fn always_ends(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let mut rest = &bytes[..];
            while let Some((_, _, after)) = lexeme(rest) {
                prop_assert!(after.len() < rest.len());
                rest = after;
            }
            prop_assert!(blanks(rest).is_ok_and(|(left, _)| left.is_empty()));
        }
    }
}
