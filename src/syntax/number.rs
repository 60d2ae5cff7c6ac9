//! Parses numbers as pbrt-v3 does: C's `strtof`, but correctly rounded to 64 bits.
//!
//! Decimal with or without a point and an exponent (`.5`, `5.`, `1e-009`, `+1`), hexadecimal (`0x28`, `0x1.8p3`),
//! `inf`, `infinity` and `nan` in any case. There are two parsers: [`number`] reads any token; `plain_numbers` is fast
//! on the long lists of meshes and stops at the first token that is not a plain decimal.

use nom::branch::alt;
use nom::bytes::complete::{tag, tag_no_case};
use nom::character::complete::{digit0, digit1, one_of};
use nom::combinator::{opt, recognize, value};
use nom::{IResult, Parser};

type Read<'a, T> = IResult<&'a [u8], T, ()>;

/// The number at the start of a token and its length in bytes. `None` if there is none; a token of one byte must be a
/// digit.
///
/// ```
/// use fstop::syntax::number::number;
/// assert_eq!(number(b"5.e-1"), Some((0.5, 5)));
/// assert_eq!(number(b"0x28"), Some((40.0, 4)));
/// assert_eq!(number(b"40deg"), Some((40.0, 2)));
/// assert_eq!(number(b"-"), None);
/// ```
pub fn number(token: &[u8]) -> Option<(f64, usize)> {
    let (rest, (sign, magnitude)) = (sign, alt((hexadecimal, decimal, not_finite)))
        .parse(token)
        .ok()?;
    Some((sign * magnitude, token.len() - rest.len()))
}

fn sign(input: &[u8]) -> Read<'_, f64> {
    alt((value(-1.0, tag("-")), value(1.0, opt(tag("+"))))).parse(input)
}

fn decimal(input: &[u8]) -> Read<'_, f64> {
    let mantissa = alt((
        recognize((digit1, opt((tag("."), digit0)))),
        recognize((tag("."), digit1)),
    ));
    let exponent = (one_of("eE"), opt(one_of("+-")), digit1);
    recognize((mantissa, opt(exponent)))
        .map_opt(|text: &[u8]| fast_float2::parse(text).ok())
        .parse(input)
}

fn not_finite(input: &[u8]) -> Read<'_, f64> {
    alt((
        value(
            f64::INFINITY,
            alt((tag_no_case("infinity"), tag_no_case("inf"))),
        ),
        value(f64::NAN, tag_no_case("nan")),
    ))
    .parse(input)
}

/// Exact up to 53 bits of mantissa; longer ones are rounded digit by digit, which is more than scene files need.
fn hexadecimal(input: &[u8]) -> Read<'_, f64> {
    let (rest, _) = tag_no_case("0x").parse(input)?;
    let whole = digits_of(rest, 16);
    let after_whole = &rest[whole..];
    let fraction = match after_whole.first() {
        Some(b'.') => digits_of(&after_whole[1..], 16),
        _ => 0,
    };
    if whole + fraction == 0 {
        return Err(nom::Err::Error(()));
    }
    let (digits, rest) = match fraction {
        // `0x1.` keeps its point, as `strtof` does.
        0 => (
            &rest[..whole],
            after_whole.strip_prefix(b".").unwrap_or(after_whole),
        ),
        _ => rest.split_at(whole + 1 + fraction),
    };
    let (rest, exponent) = opt(binary_exponent).parse(rest)?;
    let mantissa = digits
        .iter()
        .filter_map(|&b| char::from(b).to_digit(16))
        .fold(0.0, |sum: f64, digit| sum * 16.0 + f64::from(digit));
    // In two steps, so that neither factor leaves the range of f64 before the product does.
    let exponent = exponent
        .unwrap_or(0)
        .saturating_sub(4 * i32::try_from(fraction).unwrap_or(i32::MAX));
    let exponent = exponent.clamp(-4000, 4000);
    let half = exponent / 2;
    Ok((
        rest,
        mantissa * libm::exp2(f64::from(half)) * libm::exp2(f64::from(exponent - half)),
    ))
}

fn binary_exponent(input: &[u8]) -> Read<'_, i32> {
    let (input, _) = one_of("pP").parse(input)?;
    let (input, sign) = sign(input)?;
    let (input, digits) = digit1(input)?;
    let size = digits.iter().fold(0_i32, |n, &b| {
        n.saturating_mul(10).saturating_add(i32::from(b - b'0'))
    });
    Ok((input, if sign < 0.0 { -size } else { size }))
}

fn digits_of(input: &[u8], radix: u32) -> usize {
    input
        .iter()
        .take_while(|&&b| char::from(b).is_digit(radix))
        .count()
}

/// Powers of ten that are exact in f64.
const EXACT: [f64; 16] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
];

/// White space between tokens. pbrt-v3 accepts space, tab, LF and CR; form feed and vertical tab are accepted too
/// (pbrt-v3 makes them part of a word, which is then unknown).
pub(super) fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\n' | b'\r' | b'\x0b' | b'\x0c')
}

/// Returns `true` if the byte ends a word: white space, quotation mark, bracket.
pub(super) fn ends_word(byte: u8) -> bool {
    is_blank(byte) || matches!(byte, b'"' | b'[' | b']')
}

/// Reads plain decimal numbers separated by white space into `into`, and returns the rest: the first word that is not
/// entirely a plain decimal, or a bracket, quotation mark or comment, with or without the white space before it.
///
/// Up to fifteen digits and no exponent, which is nearly every number of nearly every mesh, take one integer and one
/// division, both exact up to the division's own rounding (Clinger, *How to Read Floating Point Numbers Accurately*,
/// 1990); everything else is left to `fast_float2`. Either way the result is correctly rounded.
pub(super) fn plain_numbers<'a>(mut input: &'a [u8], into: &mut Vec<f64>) -> &'a [u8] {
    loop {
        while let [first, rest @ ..] = input
            && is_blank(*first)
        {
            input = rest;
        }
        let Some((number, length)) = short_decimal(input).or_else(|| long_decimal(input)) else {
            return input;
        };
        into.push(number);
        input = &input[length..];
    }
}

fn short_decimal(input: &[u8]) -> Option<(f64, usize)> {
    let negative = input.first() == Some(&b'-');
    let mut at = usize::from(negative);
    let mut mantissa = 0_u64;
    let mut take_digits = |mut at: usize| {
        while let Some(&byte) = input.get(at)
            && byte.is_ascii_digit()
        {
            // Wraps for numbers too long for this path; those are rejected below.
            mantissa = mantissa
                .wrapping_mul(10)
                .wrapping_add(u64::from(byte - b'0'));
            at += 1;
        }
        at
    };
    let first = at;
    at = take_digits(at);
    let mut digits = at - first;
    let mut decimals = 0;
    if input.get(at) == Some(&b'.') {
        let end = take_digits(at + 1);
        decimals = end - (at + 1);
        digits += decimals;
        at = end;
    }
    if digits == 0 || digits > 15 || !input.get(at).is_none_or(|&b| ends_word(b)) {
        return None;
    }
    let magnitude = mantissa as f64 / EXACT[decimals];
    Some((if negative { -magnitude } else { magnitude }, at))
}

#[cold]
fn long_decimal(input: &[u8]) -> Option<(f64, usize)> {
    let (rest, (sign, magnitude)) = (sign, decimal).parse(input).ok()?;
    rest.first()
        .is_none_or(|&b| ends_word(b))
        .then_some((sign * magnitude, input.len() - rest.len()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn every_form_of_number() {
        for (token, expected) in [
            ("0", 0.0),
            ("7", 7.0),
            ("-7", -7.0),
            ("+1", 1.0),
            (".5", 0.5),
            ("-.5", -0.5),
            ("5.", 5.0),
            ("1e3", 1000.0),
            ("1E+3", 1000.0),
            ("2.5e-009", 2.5e-9),
            ("0x28", 40.0),
            ("-0XfF", -255.0),
            ("0x1.8p3", 12.0),
            ("0x.8", 0.5),
            ("0x1.", 1.0),
            ("0x1p-1074", f64::from_bits(1)),
            ("inf", f64::INFINITY),
            ("-Infinity", f64::NEG_INFINITY),
            ("1e999", f64::INFINITY),
            (
                "123456789012345678901234567890",
                123_456_789_012_345_678_901_234_567_890.0,
            ),
        ] {
            assert_eq!(
                number(token.as_bytes()),
                Some((expected, token.len())),
                "{token}"
            );
        }
        assert!(number(b"nan").is_some_and(|(v, used)| v.is_nan() && used == 3));
        assert!(number(b"-0").is_some_and(|(v, _)| v == 0.0 && v.is_sign_negative()));
    }

    #[test]
    fn what_follows_a_number_is_left_over() {
        for (token, expected, used) in [
            ("1,2", 1.0, 1),
            ("40deg", 40.0, 2),
            ("1e", 1.0, 1),
            ("1.2.3", 1.2, 3),
            ("0x", 0.0, 1),
            ("5.f", 5.0, 2),
        ] {
            assert_eq!(number(token.as_bytes()), Some((expected, used)), "{token}");
        }
        for token in ["", "-", "+", ".", "e5", "-.e1", "true", "x1", ",1"] {
            assert_eq!(number(token.as_bytes()), None, "{token}");
        }
    }

    #[test]
    fn plain_numbers_stop_where_it_gets_interesting() {
        for (text, numbers, rest) in [
            ("1 2 3 ]", vec![1.0, 2.0, 3.0], "]"),
            ("1 .5 5. -2e1\r\n\t7", vec![1.0, 0.5, 5.0, -20.0, 7.0], ""),
            ("1 # two", vec![1.0], "# two"),
            ("1]2", vec![1.0], "]2"),
            ("1 2,3", vec![1.0], "2,3"),
            ("1 - 2", vec![1.0], "- 2"),
            ("1 . 2", vec![1.0], ". 2"),
            ("1 0x10", vec![1.0], "0x10"),
            ("1 inf", vec![1.0], "inf"),
            (
                "12345678901234567890 1",
                vec![12_345_678_901_234_567_890.0, 1.0],
                "",
            ),
        ] {
            let mut read = Vec::new();
            let left = plain_numbers(text.as_bytes(), &mut read);
            assert_eq!((read, left), (numbers, rest.as_bytes()), "{text}");
        }
    }

    fn agrees_with_std(text: &str) {
        let expected = text.parse::<f64>().expect("a decimal number").to_bits();
        assert_eq!(
            number(text.as_bytes()).map(|(v, n)| (v.to_bits(), n)),
            Some((expected, text.len())),
            "{text}"
        );
        let mut read = Vec::new();
        let left = plain_numbers(text.as_bytes(), &mut read);
        assert_eq!((read[0].to_bits(), left.len()), (expected, 0), "{text}");
    }

    proptest! {
        #[test]
        fn bits_equal_std_for_any_float(bits: u64) {
            let value = f64::from_bits(bits);
            if value.is_finite() {
                agrees_with_std(&format!("{value}"));
                agrees_with_std(&format!("{value:e}"));
            }
        }

        #[test]
        fn bits_equal_std_for_what_meshes_hold(text in "[-+]?([0-9]{1,12}\\.?[0-9]{0,12}|\\.[0-9]{1,18})([eE][-+]?[0-9]{1,4})?") {
            agrees_with_std(&text);
        }

        #[test]
        fn any_bytes_are_read_without_panic(bytes in proptest::collection::vec(any::<u8>(), 0..64)) {
            if let Some((_, used)) = number(&bytes) {
                prop_assert!(used > 0 && used <= bytes.len());
            }
            let left = plain_numbers(&bytes, &mut Vec::new());
            prop_assert!(bytes.ends_with(left));
        }
    }
}
