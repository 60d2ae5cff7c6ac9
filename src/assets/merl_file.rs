//! Tables of the MERL BRDF database (Matusik, Pfister, Brand and McMillan 2003, "A Data-Driven Reflectance Model"):
//! isotropic BRDFs over the angles of Rusinkiewicz 1998, "A New Change of Variables for Efficient BRDF Representation".
//!
//! Three 32-bit integers give the numbers of half angles θh, difference angles θd and azimuths φd (90, 90 and 180 in
//! the database). Then come all red, all green and all blue values, as 64-bit floats with φd varying fastest and θh
//! slowest. Everything is little-endian. Values are the BRDF in 1/sr times 1500, 1500/1.15 and 1500/1.66; negative
//! where nothing was measured, which counts as black.

use crate::files::{self, FileError};
use crate::math::Rgb;
use std::path::Path;

/// Size of the header in bytes; the values follow.
const HEADER: usize = 12;

/// Maximum file size in bytes; those of the database have 33 MB.
const LARGEST: u64 = 1 << 30;

/// Size of a value in bytes.
const VALUE: usize = 8;

/// Scale factors of stored values, by channel.
const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];

/// The contents of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct MerlFile {
    /// Numbers of θh, θd and φd; none is 0.
    pub counts: [usize; 3],
    /// BRDF in 1/sr, not negative, with φd varying fastest and θh slowest.
    pub values: Vec<Rgb>,
}

impl MerlFile {
    /// Reads a file.
    pub fn read(path: &Path) -> Result<MerlFile, FileError> {
        Ok(MerlFile::parse(&files::read(path, LARGEST)?)?)
    }

    /// Decodes a whole file. Bytes after the values are ignored, as in pbrt-v2.
    pub fn parse(bytes: &[u8]) -> Result<MerlFile, String> {
        let found = bytes.len();
        let truncated = |needed: u128| {
            format!(
                "it ends early, or is not a MERL table: {found} bytes, where its sizes ask for {needed}"
            )
        };
        let too_short = || truncated(HEADER as u128);
        let (header, body) = bytes.split_at_checked(HEADER).ok_or_else(too_short)?;
        let (words, _) = header.as_chunks::<4>();
        let &[h, d, phi] = words else {
            return Err(too_short());
        };
        let counts = [h, d, phi].map(i32::from_le_bytes);
        if counts.iter().any(|&count| count < 1) {
            return Err(format!(
                "it starts with {counts:?}, where the three sizes of a MERL table were expected"
            ));
        }
        // Never allocates more than the file holds.
        let entries: u128 = counts.iter().map(|&count| count as u128).product();
        let needed = 3 * VALUE as u128 * entries;
        if needed > body.len() as u128 {
            return Err(truncated(HEADER as u128 + needed));
        }
        let entries = entries as usize;
        let (numbers, _) = body.as_chunks::<VALUE>();
        let value = |entry: usize, channel: usize| {
            let at = channel * entries + entry;
            let raw = f64::from_le_bytes(numbers[at]);
            let value = raw * SCALES[channel];
            // NaN fails either comparison.
            if value.abs() <= super::MAX_MEASURED {
                Ok(value.max(0.0) as f32)
            } else {
                Err(format!("value {at} is {raw}, which is not a reflectance"))
            }
        };
        let color = |entry| {
            let [r, g, b] = [value(entry, 0)?, value(entry, 1)?, value(entry, 2)?];
            Ok(Rgb::new(r, g, b))
        };
        Ok(MerlFile {
            counts: counts.map(|count| count as usize),
            values: (0..entries).map(color).collect::<Result<_, String>>()?,
        })
    }
}

#[cfg(test)]
pub(crate) mod generator;

#[cfg(test)]
mod tests {
    use super::generator::encode;
    use super::*;
    use crate::bsdf::measured::{MeasuredTable, tests::do_no_harm};
    use proptest::prelude::*;

    /// The sizes of a small table.
    const COUNTS: [usize; 3] = [4, 3, 5];

    fn small() -> Vec<u8> {
        encode(COUNTS, &|h, d, phi| [0.1 + h, 0.2 + d, 0.3 + phi])
    }

    fn with_counts(counts: [i32; 3]) -> Vec<u8> {
        let words = counts.iter().flat_map(|count| count.to_le_bytes());
        words.chain(small()[HEADER..].iter().copied()).collect()
    }

    #[test]
    fn what_is_written_is_read() {
        let file = MerlFile::parse(&small()).unwrap();
        assert_eq!((file.counts, file.values.len()), (COUNTS, 60));
        // The second θh of four: (1.5/4)² of π/2; the third θd of three; the fourth φd of five.
        let h = std::f64::consts::FRAC_PI_2 * 0.140625;
        let d = std::f64::consts::FRAC_PI_2 * 2.5 / 3.0;
        let phi = std::f64::consts::PI * 0.7;
        let expected = Rgb::new((0.1 + h) as f32, (0.2 + d) as f32, (0.3 + phi) as f32);
        let found = file.values[3 + 5 * (2 + 3)];
        // Rounding.
        assert!((found - expected).abs().max_element() < 1e-6, "{found}");
        let longer = [small(), vec![7; 11]].concat();
        assert_eq!(MerlFile::parse(&longer).unwrap(), file);
    }

    #[test]
    fn what_was_not_measured_is_black() {
        let file = MerlFile::parse(&encode([1, 1, 1], &|_, _, _| [-1.0, 0.5, -0.1])).unwrap();
        assert!(file.values[0].x == 0.0 && file.values[0].y > 0.4 && file.values[0].z == 0.0);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let says = |bytes: &[u8]| MerlFile::parse(bytes).unwrap_err();
        let header = "where the three sizes of a MERL table were expected";
        for counts in [[0, 3, 5], [4, -3, 5], [4, 3, i32::MIN]] {
            assert_eq!(
                says(&with_counts(counts)),
                format!("it starts with {counts:?}, {header}")
            );
        }
        let most = says(&with_counts([i32::MAX; 3]));
        assert!(
            most.starts_with("it ends early, or is not a MERL table: 1452 bytes, "),
            "{most}"
        );
        let more = says(&with_counts([4, 3, 6]));
        assert_eq!(
            more,
            "it ends early, or is not a MERL table: 1452 bytes, where its sizes ask for 1740"
        );
        for cut in 0..small().len() {
            let error = says(&small()[..cut]);
            assert!(error.starts_with("it ends early"), "{error}");
        }
        for wrong in [f64::NAN, f64::INFINITY, 1e200] {
            let mut bytes = small();
            bytes[HEADER + 7 * VALUE..][..VALUE].copy_from_slice(&wrong.to_le_bytes());
            assert_eq!(
                says(&bytes),
                format!("value 7 is {wrong}, which is not a reflectance")
            );
        }
    }

    proptest! {
        #[test]
        fn damage_is_refused_or_harmless(
            at in prop::collection::vec((0usize..1452, any::<u8>()), 1..8),
            cut in 0usize..3000,
        ) {
            let mut bytes = small();
            at.iter().for_each(|&(i, byte)| bytes[i] = byte);
            bytes.truncate(cut);
            if let Ok(file) = MerlFile::parse(&bytes) {
                prop_assert_eq!(file.counts.iter().product::<usize>(), file.values.len());
                do_no_harm(&MeasuredTable::from_merl(file));
            }
        }
    }
}
