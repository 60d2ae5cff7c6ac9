//! `.bsdf` files: tabulated isotropic BSDFs as layerlab writes them (Jakob, d'Eon, Jakob and
//! Marschner 2014, "A Comprehensive Framework for Rendering Layered Materials"; format `SCATFUN`,
//! version 1).
//!
//! For each pair of cosines to the normal, μi and μo, the BSDF times |μi| is a Fourier series Σ aₖ cos kφ in the
//! difference of azimuths. All numbers are little-endian 32-bit values: a header of 64 bytes, the cosines, running
//! integrals of a₀ (not used here: they follow from the rest), offset and length of each pair's series with μo varying
//! more slowly, and the coefficients, where the series of the channels follow one another. Anything after them is only
//! a description.

use crate::files::{self, FileError};
use std::path::Path;

/// Size of the header in bytes; the cosines follow.
const HEADER: usize = 64;

/// Maximum file size in bytes; published files have some tens of megabytes.
const LARGEST: u64 = 1 << 30;

/// The contents of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct BsdfFile {
    /// Refractive index of the inside over that of the outside.
    pub eta: f32,
    /// 1: luminance; 3: luminance, red and blue.
    pub channels: usize,
    /// Cosines, ascending, in -1…1; at least two. The first two differ, and so do the last two;
    /// others may be equal, as layerlab writes 0 once for each side of the surface.
    pub cosines: Vec<f32>,
    /// For each pair, μo varying more slowly: where its series starts among the coefficients, and how many terms it has
    /// in each channel. Always in bounds.
    pub series: Vec<Series>,
    /// Coefficients, all finite.
    pub coefficients: Vec<f32>,
}

/// The location of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Series {
    /// Index of its first coefficient.
    pub start: usize,
    /// Number of terms in each channel.
    pub length: usize,
}

impl BsdfFile {
    /// Reads a file.
    pub fn read(path: &Path) -> Result<BsdfFile, FileError> {
        Ok(BsdfFile::parse(&files::read(path, LARGEST)?)?)
    }

    /// Decodes a whole file.
    pub fn parse(bytes: &[u8]) -> Result<BsdfFile, String> {
        match bytes {
            [b'S', b'C', b'A', b'T', b'F', b'U', b'N', 1, ..] => {}
            [b'S', b'C', b'A', b'T', b'F', b'U', b'N', other, ..] => {
                return Err(format!(
                    "it is of version {other}, and only version 1 is known"
                ));
            }
            _ => return Err("it does not start with SCATFUN".into()),
        }
        let Header {
            cosines: n,
            coefficients: count,
            channels,
            eta,
        } = Header::read(bytes)?;
        let mut rest = words_of_body(bytes);
        let mut take = |count: usize| rest.by_ref().take(count).collect::<Vec<u32>>();
        let cosines = checked_cosines(&take(n))?;
        take(n * n);
        let series = checked_series(&take(2 * n * n), count, channels)?;
        let coefficients = checked_coefficients(&take(count))?;
        Ok(BsdfFile {
            eta: checked_eta(eta)?,
            channels,
            cosines,
            series,
            coefficients,
        })
    }
}

/// What the first words say of the rest, which is there.
struct Header {
    cosines: usize,
    coefficients: usize,
    channels: usize,
    eta: f32,
}

impl Header {
    fn read(bytes: &[u8]) -> Result<Header, String> {
        let found = bytes.len();
        let truncated = |needed| format!("it ends early: {found} bytes, {needed} needed");
        let short = || truncated(HEADER as u64);
        let words: Vec<u32> = words(bytes.get(8..HEADER).ok_or_else(short)?).collect();
        // The unused ones: the length of the longest series, and three reserved ones.
        let &[
            flags,
            cosines,
            coefficients,
            _,
            channels,
            bases,
            _,
            _,
            _,
            eta,
            ..,
        ] = &words[..]
        else {
            return Err(short());
        };
        if flags != 1 {
            return Err(format!(
                "it holds no plain BSDF (its flags are {flags:#x}, not 0x1)"
            ));
        }
        if channels != 1 && channels != 3 {
            return Err(format!("it has {channels} channels, not 1 or 3"));
        }
        if bases != 1 {
            return Err(format!("it has {bases} bases, not 1"));
        }
        if cosines < 2 {
            return Err(format!("it has {cosines} cosines, fewer than 2"));
        }
        // Never allocates more than the file holds.
        let (n, count) = (u128::from(cosines), u128::from(coefficients));
        let needed = HEADER as u128 + 4 * (n + 3 * n * n + count);
        if needed > bytes.len() as u128 {
            return Err(truncated(u64::try_from(needed).unwrap_or(u64::MAX)));
        }
        Ok(Header {
            cosines: cosines as usize,
            coefficients: coefficients as usize,
            channels: channels as usize,
            eta: f32::from_bits(eta),
        })
    }
}

/// The 32-bit words in `bytes`; an incomplete last one is dropped.
fn words(bytes: &[u8]) -> impl Iterator<Item = u32> + '_ {
    let (words, _) = bytes.as_chunks::<4>();
    words.iter().map(|word| u32::from_le_bytes(*word))
}

fn words_of_body(bytes: &[u8]) -> impl Iterator<Item = u32> + '_ {
    words(bytes.get(HEADER..).unwrap_or_default())
}

fn checked_cosines(words: &[u32]) -> Result<Vec<f32>, String> {
    let cosines: Vec<f32> = words.iter().map(|&w| f32::from_bits(w)).collect();
    let mut before = f32::NEG_INFINITY;
    for (i, &mu) in cosines.iter().enumerate() {
        let at_an_end = i <= 1 || i + 1 == cosines.len();
        let ascends = mu > before || (mu == before && !at_an_end);
        if !((-1.0..=1.0).contains(&mu) && ascends) {
            return Err(format!(
                "its cosines do not ascend from -1 to 1: {mu} is number {i}"
            ));
        }
        before = mu;
    }
    Ok(cosines)
}

fn checked_series(
    words: &[u32],
    coefficients: usize,
    channels: usize,
) -> Result<Vec<Series>, String> {
    let (pairs, _) = words.as_chunks::<2>();
    let series = pairs.iter().enumerate().map(|(i, &[start, length])| {
        let end = u64::from(start) + u64::from(length) * channels as u64;
        if end > coefficients as u64 {
            return Err(format!("series {i} goes beyond the coefficients"));
        }
        Ok(Series {
            start: start as usize,
            length: length as usize,
        })
    });
    series.collect()
}

fn checked_coefficients(words: &[u32]) -> Result<Vec<f32>, String> {
    let coefficients: Vec<f32> = words.iter().map(|&w| f32::from_bits(w)).collect();
    match coefficients.iter().position(|a| !a.is_finite()) {
        Some(i) => Err(format!("coefficient {i} is not finite")),
        None => Ok(coefficients),
    }
}

/// Files that do not use the index store 0.
fn checked_eta(eta: f32) -> Result<f32, String> {
    match eta {
        0.0 => Ok(1.0),
        eta if eta > 0.0 && eta.is_finite() => Ok(eta),
        _ => Err(format!("its refractive index is {eta}")),
    }
}

#[cfg(test)]
pub(crate) mod generator;

#[cfg(test)]
mod tests {
    use super::generator::{Analytic, encode};
    use super::*;
    use proptest::prelude::*;

    fn lambert(channels: usize) -> Vec<u8> {
        let color = |mu_i: f64, mu_o: f64, _: f64| {
            let reflects = if mu_i * mu_o < 0.0 { 1.0 } else { 0.0 };
            [0.2, 0.5, 0.8].map(|kd| kd * reflects)
        };
        encode(&Analytic {
            eta: 1.3,
            channels,
            cosines: 8,
            terms: 2,
            value: &color,
        })
    }

    fn with_word(mut bytes: Vec<u8>, word: usize, value: u32) -> Vec<u8> {
        bytes[8 + 4 * word..12 + 4 * word].copy_from_slice(&value.to_le_bytes());
        bytes
    }

    #[test]
    fn what_is_written_is_read() {
        for channels in [1, 3] {
            let file = BsdfFile::parse(&lambert(channels)).unwrap();
            assert_eq!(
                (file.eta, file.channels, file.cosines.len()),
                (1.3, channels, 8)
            );
            assert_eq!(file.series.len(), 64);
            let longest = file.series.iter().map(|s| s.length).max().unwrap();
            assert!(longest <= 2 && file.coefficients.len() >= channels);
        }
        // A description may follow.
        let described = [lambert(1), b"made by hand".to_vec()].concat();
        assert_eq!(BsdfFile::parse(&described), BsdfFile::parse(&lambert(1)));
    }

    /// As in every layerlab file: 0 occurs once for each side of the surface.
    #[test]
    fn the_cosine_0_may_stand_twice() {
        let file = BsdfFile::parse(&lambert(3)).unwrap();
        assert_eq!(file.cosines[3..5], [0.0, 0.0]);
        assert!(file.cosines[2] < 0.0 && file.cosines[5] > 0.0);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let says = |bytes: &[u8]| BsdfFile::parse(bytes).unwrap_err();
        let good = lambert(3);
        let mut newer = good.clone();
        newer[7] = 2;
        let nan = f32::NAN.to_bits();
        // Words of the header; the cosines start at word 14.
        for (bytes, message) in [
            (b"PF 1 1".to_vec(), "it does not start with SCATFUN"),
            (newer, "it is of version 2, and only version 1 is known"),
            (good[..30].to_vec(), "it ends early: 30 bytes, 64 needed"),
            (
                with_word(good.clone(), 0, 3),
                "it holds no plain BSDF (its flags are 0x3, not 0x1)",
            ),
            (
                with_word(good.clone(), 1, 1),
                "it has 1 cosines, fewer than 2",
            ),
            (
                with_word(good.clone(), 4, 2),
                "it has 2 channels, not 1 or 3",
            ),
            (with_word(good.clone(), 5, 7), "it has 7 bases, not 1"),
            (
                with_word(good.clone(), 9, nan),
                "its refractive index is NaN",
            ),
            (
                with_word(good.clone(), 15, f32::to_bits(2.0)),
                "its cosines do not ascend from -1 to 1: 2 is number 1",
            ),
            // No interval of width 0 at either end.
            (
                with_word(good.clone(), 15, f32::to_bits(-1.0)),
                "its cosines do not ascend from -1 to 1: -1 is number 1",
            ),
            (
                with_word(good.clone(), 14 + 6, f32::to_bits(1.0)),
                "its cosines do not ascend from -1 to 1: 1 is number 7",
            ),
            (
                with_word(good.clone(), 14 + 8 + 64, u32::MAX),
                "series 0 goes beyond the coefficients",
            ),
            (
                with_word(good.clone(), 14 + 8 + 3 * 64, nan),
                "coefficient 0 is not finite",
            ),
        ] {
            assert_eq!(says(&bytes), message);
        }
        let huge = with_word(with_word(good.clone(), 1, u32::MAX), 2, u32::MAX);
        assert!(says(&huge).starts_with("it ends early"), "{}", says(&huge));
        for cut in 64..good.len() {
            assert!(says(&good[..cut]).starts_with("it ends early"));
        }
    }

    proptest! {
        #[test]
        fn damage_is_refused_or_harmless(
            at in prop::collection::vec((0usize..2000, any::<u8>()), 1..8),
            cut in 0usize..4000,
        ) {
            let mut bytes = lambert(3);
            for (i, byte) in at {
                let i = i % bytes.len();
                bytes[i] = byte;
            }
            bytes.truncate(cut);
            if let Ok(file) = BsdfFile::parse(&bytes) {
                let n = file.cosines.len();
                prop_assert!(file.series.len() == n * n && file.eta > 0.0);
                let within = |s: &Series| {
                    s.start + s.length * file.channels <= file.coefficients.len()
                };
                prop_assert!(file.series.iter().all(within));
                let table = crate::bsdf::fourier::FourierTable::new(file);
                crate::bsdf::fourier::tests::do_no_harm(&table);
            }
        }
    }
}
