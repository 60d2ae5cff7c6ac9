//! `.brdf` files of pbrt-v2: isotropic BRDFs measured at arbitrary (scattered) pairs of directions.
//!
//! Numbers as text, separated by white space; `#` starts a comment. The first is the number n of wavelengths, which
//! follow in nm. Then each sample has θ and φ of the direction to the light, θ and φ of the one to the viewer, in radians,
//! and the BRDF in 1/sr at the n wavelengths.

use crate::files::{self, FileError};
use std::path::Path;

/// Maximum file size in bytes; published files have some ten thousand samples.
const LARGEST: u64 = 256 << 20;

/// Maximum number of wavelengths: more than one per nm between ultraviolet and infrared.
const MAX_WAVELENGTHS: usize = 1024;

/// The contents of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct BrdfFile {
    /// In nm, positive, all different, at least one.
    pub wavelengths: Vec<f64>,
    /// All samples one after another, at least one: four angles and one value per wavelength.
    pub numbers: Vec<f64>,
}

impl BrdfFile {
    /// Reads a file.
    pub fn read(path: &Path) -> Result<BrdfFile, FileError> {
        Ok(BrdfFile::parse(&files::read(path, LARGEST)?)?)
    }

    /// Decodes a whole file.
    pub fn parse(bytes: &[u8]) -> Result<BrdfFile, String> {
        let mut wavelengths = numbers(bytes)?;
        let &first = wavelengths.first().ok_or("it has no numbers")?;
        if !(1.0..=MAX_WAVELENGTHS as f64).contains(&first) || first.fract() != 0.0 {
            return Err(format!(
                "it starts with {first}, where a number of wavelengths from 1 to {MAX_WAVELENGTHS} was expected"
            ));
        }
        let (count, found) = (first as usize, wavelengths.len() - 1);
        if found < count {
            return Err(format!("it ends after {found} of {count} wavelengths"));
        }
        let numbers = wavelengths.split_off(1 + count);
        wavelengths.remove(0);
        check_wavelengths(&wavelengths)?;
        let each = 4 + count;
        if numbers.is_empty() || !numbers.len().is_multiple_of(each) {
            return Err(format!(
                "{} numbers after the wavelengths do not make samples of {each}",
                numbers.len()
            ));
        }
        for (i, sample) in numbers.chunks_exact(each).enumerate() {
            let too_large = |value: &&f64| value.abs() > super::MAX_MEASURED;
            if let Some(&value) = sample[4..].iter().find(too_large) {
                return Err(format!(
                    "sample {i} has the value {value}, which is not a reflectance"
                ));
            }
        }
        Ok(BrdfFile {
            wavelengths,
            numbers,
        })
    }

    /// The samples, each as four angles and its values.
    pub fn samples(&self) -> impl Iterator<Item = ([f64; 4], &[f64])> {
        let each = 4 + self.wavelengths.len();
        self.numbers
            .chunks_exact(each)
            .filter_map(|sample| sample.split_first_chunk::<4>())
            .map(|(angles, values)| (*angles, values))
    }
}

/// All numbers of a file, all finite.
fn numbers(bytes: &[u8]) -> Result<Vec<f64>, String> {
    let mut numbers = Vec::new();
    for (i, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let told = line.split(|&byte| byte == b'#').next().unwrap_or_default();
        let words = told.split(u8::is_ascii_whitespace);
        for word in words.filter(|word| !word.is_empty()) {
            let text = std::str::from_utf8(word).ok();
            let number = text.and_then(|text| text.parse::<f64>().ok());
            let number = number.filter(|number| number.is_finite());
            numbers.push(number.ok_or_else(|| format!("line {}: expected a number", i + 1))?);
        }
    }
    Ok(numbers)
}

fn check_wavelengths(wavelengths: &[f64]) -> Result<(), String> {
    let mut sorted = wavelengths.to_vec();
    sorted.sort_by(f64::total_cmp);
    if let Some(&wrong) = sorted.iter().find(|&&wavelength| wavelength <= 0.0) {
        return Err(format!("a wavelength is {wrong} nm"));
    }
    match sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(format!("the wavelength {} nm is there twice", pair[0])),
        None => Ok(()),
    }
}

#[cfg(test)]
pub(crate) mod generator;

#[cfg(test)]
mod tests {
    use super::generator::{encode, pairs};
    use super::*;
    use crate::bsdf::measured::{MeasuredTable, tests::do_no_harm};
    use proptest::prelude::*;

    fn small() -> String {
        encode(&[450.0, 600.5], &pairs(2, 2), &|[ti, _, to, _]| {
            vec![0.25 * ti, 0.5 + to]
        })
    }

    #[test]
    fn what_is_written_is_read() {
        let file = BrdfFile::parse(small().as_bytes()).unwrap();
        assert_eq!(file.wavelengths, [450.0, 600.5]);
        assert_eq!(file.samples().count(), 8);
        for ([ti, _, to, _], values) in file.samples() {
            assert_eq!(values, [0.25 * ti, 0.5 + to]);
        }
        let short = BrdfFile::parse(b"1 # one\n500#nm\n0 0 .5 1e0\n\t-.1").unwrap();
        assert_eq!(short.numbers, [0.0, 0.0, 0.5, 1.0, -0.1]);
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, message) in [
            ("# nothing", "it has no numbers"),
            ("1\n5o0 0 0 0 0 1", "line 2: expected a number"),
            ("1 500\n\n0 0 0 nan 1", "line 3: expected a number"),
            (
                "0 1 2 3 4",
                "it starts with 0, where a number of wavelengths from 1 to 1024 was expected",
            ),
            (
                "1e30 1 2 3 4",
                "it starts with 1000000000000000000000000000000, where a number of wavelengths from 1 to 1024 was expected",
            ),
            (
                "1.5 500 0 0 0 0 1",
                "it starts with 1.5, where a number of wavelengths from 1 to 1024 was expected",
            ),
            ("4 500 600 700", "it ends after 3 of 4 wavelengths"),
            ("1 0 0 0 0 0 1", "a wavelength is 0 nm"),
            (
                "2 500 500 0 0 0 0 1 1",
                "the wavelength 500 nm is there twice",
            ),
            (
                "1 500",
                "0 numbers after the wavelengths do not make samples of 5",
            ),
            (
                "1 500 0 0 0 0 1 2",
                "6 numbers after the wavelengths do not make samples of 5",
            ),
            (
                "1 500 0 0 0 0 1 0 0 0 0 1e10",
                "sample 1 has the value 10000000000, which is not a reflectance",
            ),
        ] {
            let error = BrdfFile::parse(text.as_bytes()).unwrap_err();
            assert_eq!(error, message);
        }
    }

    proptest! {
        #[test]
        fn damage_is_refused_or_harmless(
            at in prop::collection::vec((0usize..4000, any::<u8>()), 1..8),
            cut in 0usize..2000,
        ) {
            let mut bytes = small().into_bytes();
            for (i, byte) in at {
                let i = i % bytes.len();
                bytes[i] = byte;
            }
            bytes.truncate(cut);
            if let Ok(file) = BrdfFile::parse(&bytes) {
                prop_assert!(file.samples().count() > 0);
                do_no_harm(&MeasuredTable::from_brdf(&file));
            }
        }
    }
}
