//! Blocks of OpenEXR files in ZIP compression.
//!
//! The crate `exr` compresses as zlib does at level 4, which with layers takes nine to twelve times as long as [`deflate`] for files 3 to 14 % smaller
//! (`docs/notes/performance.md`, "EXR blocks"): with ten of them and 8 samples a pixel that would be a quarter of a render's time.

use super::deflate;
use crate::math::instruction_set::{Instructions, Kernel, WIDEST, vectorize};

/// Compresses pixels whose numbers are little-endian: their bytes of even and of odd places apart, of these the differences,
/// of these a zlib stream (OpenEXR, "File Layout", section on compression; `ImfZip.cpp` of the reference implementation). What does
/// not become shorter is stored as it is, by which readers know it.
pub(super) fn compress(plain: &[u8], memory: &mut Memory) -> Vec<u8> {
    vectorize::<WIDEST, _>(Compress { plain, memory })
}

/// The computation, for each instruction set.
struct Compress<'a> {
    plain: &'a [u8],
    memory: &'a mut Memory,
}

impl Kernel for Compress<'_> {
    type Output = Vec<u8>;

    #[inline(always)]
    fn run(self, _: impl Instructions) -> Vec<u8> {
        let Memory { packed, zipped } = self.memory;
        pack(self.plain, packed);
        let zipped = deflate::zlib(packed, zipped);
        match zipped.len() < self.plain.len() {
            true => zipped.to_vec(),
            false => self.plain.to_vec(),
        }
    }
}

/// What is used for one block after the other: new memory takes the system longer than the bytes take.
#[derive(Default)]
pub(super) struct Memory {
    packed: Vec<u8>,
    zipped: Vec<u8>,
}

/// The bytes of even places, then those of odd places; each but the first less the one before it, plus 128.
#[inline(always)]
fn pack(plain: &[u8], packed: &mut Vec<u8>) {
    packed.resize(plain.len(), 0);
    let (pairs, rest) = plain.as_chunks::<2>();
    let Some((first, others)) = pairs.split_first() else {
        return packed.copy_from_slice(plain);
    };
    let difference = |before: u8, byte: u8| byte.wrapping_sub(before).wrapping_add(128);
    let (evens, odds) = packed.split_at_mut(plain.len() - pairs.len());
    let last_even = others.last().unwrap_or(first)[0];
    evens[0] = first[0];
    odds[0] = difference(*rest.first().unwrap_or(&last_even), first[1]);
    let halves = evens[1..].iter_mut().zip(&mut odds[1..]);
    for ((even, odd), (before, pair)) in halves.zip(pairs.iter().zip(others)) {
        // As one number each: so they are parted by vector instructions.
        let [before, pair] = [*before, *pair].map(u16::from_le_bytes);
        *even = difference(before as u8, pair as u8);
        *odd = difference((before >> 8) as u8, (pair >> 8) as u8);
    }
    for (even, byte) in evens.iter_mut().skip(pairs.len()).zip(rest) {
        *even = difference(last_even, *byte);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    fn packed(plain: &[u8]) -> Vec<u8> {
        // With what is left of another block.
        let mut packed = vec![3; 4];
        pack(plain, &mut packed);
        packed
    }

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
        let zipped = compress(&line, &mut Memory::default());
        assert!(zipped.len() < line.len() / 8, "{}", zipped.len());
        let mut again = Vec::new();
        let mut decoder = flate2::read::ZlibDecoder::new(zipped.as_slice());
        decoder.read_to_end(&mut again).unwrap();
        assert_eq!(again, packed(&line));
        assert_eq!(compress(&[3, 1, 2], &mut Memory::default()), [3, 1, 2]);
    }
}
