//! `.spd` files: sampled spectra as text, alternating wavelength in nm and value.
//!
//! Read as pbrt-v3 does (docs/scene-language.md §1.5): numbers separated by white space, `#` starts a comment. Its
//! quirks are not reproduced: a last number without a line break after it counts, a comment may directly follow a
//! number, `1E5` is a number. Samples out of order are sorted; two at the same wavelength are an error, as it is
//! unclear which was meant.

use crate::files::{self, FileError};
use std::path::Path;

/// Maximum file size in bytes; the largest published files have some thousand samples.
const LARGEST: u64 = 16 << 20;

/// Reads a file into (wavelength in nm, value) pairs, ascending.
pub fn read(path: &Path) -> Result<Vec<(f64, f64)>, FileError> {
    let bytes = files::read(path, LARGEST)?;
    Ok(parse(&String::from_utf8_lossy(&bytes))?)
}

/// Parses the text of a file.
///
/// ```
/// use fstop::assets::spd::parse;
/// assert_eq!(parse("700 .5\n400 .25 # blue").unwrap(), [(400.0, 0.25), (700.0, 0.5)]);
/// ```
pub fn parse(text: &str) -> Result<Vec<(f64, f64)>, String> {
    let mut numbers = Vec::new();
    let text = text.trim_start_matches('\u{feff}');
    for (index, line) in text.split(['\n', '\r']).enumerate() {
        let content = line.split('#').next().unwrap_or_default();
        for word in content.split_whitespace() {
            let number = fast_float2::parse(word);
            numbers.push(number.map_err(|_| format!("line {}: expected a number", index + 1))?);
        }
    }
    samples(&numbers)
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
            assert_eq!(parse(text).expect(text), expected, "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, message) in [
            ("", "it has no samples"),
            (
                "400 1 500",
                "3 numbers do not make pairs of wavelength and value",
            ),
            ("400 1\n500 x", "line 2: expected a number"),
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
            if let Ok(samples) = parse(&text) {
                prop_assert!(samples.windows(2).all(|pair| pair[0].0 < pair[1].0));
            }
        }
    }
}
