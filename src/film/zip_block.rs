//! Blocks of OpenEXR files in ZIP compression.
//!
//! The crate `exr` compresses as zlib does at level 4, which takes three times as long as level 1 for a file that is a
//! fortieth smaller (`docs/notes/performance.md`): with ten layers and 8 samples a pixel that was a tenth of a render's instructions.

use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::{self, Write};

/// Compresses pixels whose numbers are little-endian: their bytes of even and of odd places apart, of these the differences,
/// of these a zlib stream (OpenEXR, "File Layout", section on compression; `ImfZip.cpp` of the reference implementation). What does
/// not become shorter is stored as it is, by which readers know it.
///
/// # Errors
/// None, as long as there is memory.
pub(super) fn compress(plain: Vec<u8>) -> io::Result<Vec<u8>> {
    let packed = packed(&plain);
    let mut encoder = ZlibEncoder::new(Vec::with_capacity(plain.len() / 2), Compression::fast());
    encoder.write_all(&packed)?;
    let zipped = encoder.finish()?;
    Ok(match zipped.len() < plain.len() {
        true => zipped,
        false => plain,
    })
}

/// The bytes of even places, then those of odd places; each but the first less the one before it, plus 128.
fn packed(plain: &[u8]) -> Vec<u8> {
    let (pairs, rest) = plain.as_chunks::<2>();
    let Some((first, others)) = pairs.split_first() else {
        return plain.to_vec();
    };
    let difference = |before: u8, byte: u8| byte.wrapping_sub(before).wrapping_add(128);
    let mut packed = Vec::with_capacity(plain.len());
    packed.push(first[0]);
    packed
        .extend({ pairs.iter().zip(others) }.map(|(before, pair)| difference(before[0], pair[0])));
    let mut last = others.last().unwrap_or(first)[0];
    for &byte in rest {
        packed.push(difference(last, byte));
        last = byte;
    }
    packed.push(difference(last, first[1]));
    packed
        .extend({ pairs.iter().zip(others) }.map(|(before, pair)| difference(before[1], pair[1])));
    packed
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    #[test]
    fn bytes_are_parted_and_predicted() {
        assert_eq!(packed(&[7, 9, 4, 255]), [7, 125, 133, 118]);
        // 1, 3, 5, 2, 4.
        assert_eq!(packed(&[1, 2, 3, 4, 5]), [1, 130, 130, 125, 130]);
        assert_eq!(packed(&[7, 0]), [7, 121]);
        assert_eq!(packed(&[7]), [7]);
        assert!(packed(&[]).is_empty());
    }

    #[test]
    fn what_gets_no_shorter_is_kept() {
        let line: Vec<u8> = (0..600_u16).flat_map(u16::to_le_bytes).collect();
        let zipped = compress(line.clone()).unwrap();
        assert!(zipped.len() < line.len() / 8, "{}", zipped.len());
        let mut again = Vec::new();
        let mut decoder = flate2::read::ZlibDecoder::new(zipped.as_slice());
        decoder.read_to_end(&mut again).unwrap();
        assert_eq!(again, packed(&line));
        assert_eq!(compress(vec![3, 1, 2]).unwrap(), [3, 1, 2]);
    }
}
