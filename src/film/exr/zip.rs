//! Blocks of lines as OpenEXR's ZIP compression has them.
//!
//! Even bytes of a block first, then odd ones, each as its difference from the one before plus 128, deflated (OpenEXR's `ImfZip.cpp`; "OpenEXR File
//! Layout", openexr.com). The crate `exr` does so with more effort in deflating, which takes two to four times as long and makes files of colors and
//! layers 1 to 4 % smaller.

use ::exr::block::BlockIndex;
use ::exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use ::exr::error::{Error, Result};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::Write;

/// The block of a file whose data window starts at line `top`: of these bytes, line by line and in each channel by channel, little-endian.
pub(super) fn chunk(index: BlockIndex, top: i32, bytes: Vec<u8>) -> Result<Chunk> {
    let deflated = deflated(&differences(&bytes))?;
    let y = i64::from(top) + index.pixel_position.y() as i64;
    Ok(Chunk {
        layer_index: index.layer,
        compressed_block: CompressedBlock::ScanLine(CompressedScanLineBlock {
            y_coordinate: i32::try_from(y).map_err(|_| Error::Invalid("line".into()))?,
            // As it was, if nothing is gained: that is how a reader knows.
            compressed_pixels_le: if deflated.len() < bytes.len() {
                deflated
            } else {
                bytes
            },
        }),
    })
}

/// The high bytes of numbers differ less from each other than from the low ones, and mostly little.
fn differences(bytes: &[u8]) -> Vec<u8> {
    let mut apart = vec![0; bytes.len()];
    let (even, odd) = apart.split_at_mut(bytes.len().div_ceil(2));
    let pairs = bytes.chunks_exact(2);
    if let ([last], Some(to)) = (pairs.remainder(), even.last_mut()) {
        *to = *last;
    }
    for ((pair, even), odd) in pairs.zip(even).zip(odd) {
        (*even, *odd) = (pair[0], pair[1]);
    }
    let mut differences = apart.clone();
    for (difference, both) in differences.iter_mut().skip(1).zip(apart.windows(2)) {
        *difference = both[1].wrapping_sub(both[0]).wrapping_add(128);
    }
    differences
}

fn deflated(bytes: &[u8]) -> Result<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(Vec::with_capacity(bytes.len() / 2), Compression::fast());
    encoder.write_all(bytes)?;
    Ok(encoder.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::exr::prelude::Vec2;

    fn packed(bytes: &[u8]) -> Vec<u8> {
        let index = BlockIndex {
            layer: 0,
            pixel_position: Vec2(0, 16),
            pixel_size: Vec2(bytes.len(), 1),
            level: Vec2(0, 0),
        };
        let chunk = chunk(index, -20, bytes.to_vec()).unwrap();
        let CompressedBlock::ScanLine(block) = chunk.compressed_block else {
            panic!("a block of lines");
        };
        assert_eq!(block.y_coordinate, -4);
        block.compressed_pixels_le
    }

    /// As OpenEXR's library reads them.
    fn unpacked(packed: &[u8], count: usize) -> Vec<u8> {
        if packed.len() == count {
            return packed.to_vec();
        }
        let mut bytes = Vec::new();
        let mut decoder = flate2::write::ZlibDecoder::new(&mut bytes);
        decoder.write_all(packed).unwrap();
        decoder.finish().unwrap();
        for i in 1..bytes.len() {
            bytes[i] = bytes[i - 1].wrapping_add(bytes[i]).wrapping_sub(128);
        }
        let (even, odd) = bytes.split_at(count.div_ceil(2));
        (0..count)
            .map(|i| if i % 2 == 0 { even[i / 2] } else { odd[i / 2] })
            .collect()
    }

    #[test]
    fn a_reader_finds_what_was_packed() {
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        for count in [1, 2, 3, 255, 256, 4001] {
            let noise: Vec<u8> = (0..count).map(|_| random()).collect();
            assert_eq!(packed(&noise), noise, "{count}: no smaller");
            let smooth: Vec<u8> = (0..count).map(|i| (i / 7) as u8).collect();
            let small = packed(&smooth);
            assert_eq!(unpacked(&small, count), smooth, "{count}");
            assert!(count < 200 || small.len() < count / 2, "{count}");
        }
    }
}
