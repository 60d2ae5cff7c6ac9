//! `.spd` files: sampled spectra as text, alternating wavelength in nm and value.
//!
//! Read as pbrt-v3 does (docs/scene-language.md §1.5): numbers separated by white space, or by a comma or the like as in tables; `#` starts a
//! comment. What else is there, such as headings and units, is passed over with a warning, and so is a number without another at the end. Quirks
//! are not reproduced: a last number without a line break after it counts, a comment may directly follow a
//! number, `1E5` is a number. Samples out of order are sorted; two at the same wavelength are an error, as it is
//! unclear which was meant.

use crate::files::{self, FileError};
use std::path::Path;

/// Maximum file size in bytes; the largest published files have some thousand samples.
const LARGEST: u64 = 16 << 20;

/// What a file says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpectrumFile {
    /// Wavelengths in nm and values, ascending.
    pub samples: Vec<(f64, f64)>,
    /// What was passed over, for a warning.
    pub passed_over: Option<String>,
}

/// Reads a file.
pub fn read(path: &Path) -> Result<SpectrumFile, FileError> {
    let bytes = files::read(path, LARGEST)?;
    Ok(parse(&String::from_utf8_lossy(&bytes))?)
}

/// Parses the text of a file.
///
/// ```
/// use fstop::assets::spd::parse;
/// let file = parse("nm value\n700, .5\n400, .25 # blue").unwrap();
/// assert_eq!(file.samples, [(400.0, 0.25), (700.0, 0.5)]);
/// assert_eq!(file.passed_over.unwrap(), "line 1: text that is not a number is passed over");
/// ```
pub fn parse(text: &str) -> Result<SpectrumFile, String> {
    let mut numbers = Vec::new();
    // The line of the first of them, and how many.
    let mut others: Option<(usize, usize)> = None;
    let text = text.trim_start_matches('\u{feff}');
    for (index, line) in text.split(['\n', '\r']).enumerate() {
        let content = line.split('#').next().unwrap_or_default();
        if has_decimal_commas(content) {
            return Err(format!("line {}: a comma within a number", index + 1));
        }
        let words = content.split(|c: char| c.is_whitespace() || ",;:".contains(c));
        let before = numbers.len();
        let (mut is_odd, mut first) = (false, None);
        for word in words.filter(|word| !word.is_empty()) {
            let found = number(word);
            first.get_or_insert(found.is_some());
            numbers.extend(found.map(|(number, _)| number));
            if found.is_none_or(|(_, length)| length < word.len()) {
                others.get_or_insert((index + 1, 0)).1 += 1;
                is_odd |= found.is_none();
            }
        }
        // A word in place of a number would shift all that follow, and numbers of a heading are none of the spectrum.
        let (first, count) = (first.unwrap_or(true), numbers.len() - before);
        if is_odd && (count % 2 == 1 || count > 0 && !first) {
            return Err(format!("line {}: expected a number", index + 1));
        }
    }
    if let Some((line, _)) = others.filter(|(_, count)| *count > numbers.len()) {
        return Err(format!("line {line}: expected a number"));
    }
    let mut passed_over =
        others.map(|(line, _)| format!("line {line}: text that is not a number is passed over"));
    if numbers.len() % 2 == 1 && numbers.len() > 1 {
        numbers.pop();
        passed_over =
            Some("its last number has no value beside it, and is passed over".to_string());
    }
    let samples = samples(&numbers)?;
    Ok(SpectrumFile {
        samples,
        passed_over,
    })
}

/// Returns `true` if a comma stands between digits where something else separates columns, as in `400 0,5` and `400;0,5`.
fn has_decimal_commas(line: &str) -> bool {
    let line = line.trim();
    let has_others = line.contains(|c: char| c.is_whitespace() || c == ';');
    let is_within = |three: &[u8]| {
        let [before, comma, after] = three else {
            return false;
        };
        *comma == b',' && before.is_ascii_digit() && after.is_ascii_digit()
    };
    has_others && line.as_bytes().windows(3).any(is_within)
}

/// The number that a word is, or begins with as where a unit follows; and how long it is.
fn number(word: &str) -> Option<(f64, usize)> {
    let (number, length) = fast_float2::parse_partial(word).ok()?;
    // Not the beginning of a word such as `info`.
    let is_number = length == word.len() || !word.starts_with(char::is_alphabetic);
    is_number.then_some((number, length))
}

/// Converts alternating wavelengths in nm and values to pairs, ascending.
pub fn samples(numbers: &[f64]) -> Result<Vec<(f64, f64)>, String> {
    let (pairs, rest) = numbers.as_chunks::<2>();
    if !rest.is_empty() {
        return Err(format!(
            "{} numbers do not make pairs of wavelength and value",
            numbers.len()
        ));
    }
    if pairs.is_empty() {
        return Err("it has no samples".into());
    }
    let mut samples: Vec<(f64, f64)> = pairs
        .iter()
        .map(|&[wavelength, value]| (wavelength, value))
        .collect();
    for &(wavelength, value) in &samples {
        if !(wavelength > 0.0 && wavelength.is_finite()) {
            return Err(format!("a wavelength is {wavelength} nm"));
        }
        if !value.is_finite() {
            return Err(format!("the value at {wavelength} nm is not finite"));
        }
    }
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    match samples.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        Some(pair) => Err(format!("it has two values at {} nm", pair[0].0)),
        None => Ok(samples),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn forms_found_in_the_wild() {
        let expected = [(400.0, 0.1), (500.0, 20.0)];
        for text in [
            "400 .1\n500 20\n",
            "400 .1 500 20",
            "# copper\r\n400 .1\r\n500 2e1",
            "400 .1#glued\n500 2E+1#5 6",
            "500 20 400 .1",
            "\u{feff}400\t0.1\n\n500 20 ",
        ] {
            let file = parse(text).expect(text);
            assert_eq!(file.samples, expected, "{text}");
            assert_eq!(file.passed_over, None, "{text}");
        }
    }

    #[test]
    fn tables_of_other_programs_are_read() {
        let expected = [(400.0, 0.1), (500.0, 20.0)];
        for (text, is_warned_of) in [
            ("400,.1\n500,20\n", false),
            ("400; .1\n500;\t20", false),
            ("wavelength, value\n400, .1\n500, 20", true),
            ("wavelength (nm),reflectance\n400,.1\n500,20", true),
            ("400nm .1\n500nm 20", true),
            ("400 .1\n500 20\n600\n", true),
        ] {
            let file = parse(text).expect(text);
            assert_eq!(file.samples, expected, "{text}");
            assert_eq!(file.passed_over.is_some(), is_warned_of, "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, message) in [
            ("", "it has no samples"),
            ("400", "1 numbers do not make pairs of wavelength and value"),
            ("no spectrum", "line 1: expected a number"),
            ("400 1\n500 two\n600", "line 2: expected a number"),
            ("400 0,5\n500 0,6", "line 1: a comma within a number"),
            ("400;1,5\n500;2,5", "line 1: a comma within a number"),
            (
                "wavelength 380 to 780\n400 1\n500 2",
                "line 1: expected a number",
            ),
            ("root:x:0:0:root:/root:/bin/sh", "line 1: expected a number"),
            ("400 1 400 2", "it has two values at 400 nm"),
            ("0 1", "a wavelength is 0 nm"),
            ("400 inf", "the value at 400 nm is not finite"),
        ] {
            assert_eq!(parse(text).expect_err(text), message);
        }
    }

    #[test]
    fn a_folder_is_no_spectrum() {
        assert_eq!(
            read(Path::new(".")),
            Err("this is a folder".to_string().into())
        );
    }

    proptest! {
        #[test]
        fn ascending_or_refused(text in "([0-9.e+-]{1,5}[ \n#]){0,20}") {
            if let Ok(file) = parse(&text) {
                prop_assert!(file.samples.windows(2).all(|pair| pair[0].0 < pair[1].0));
            }
        }
    }
}
