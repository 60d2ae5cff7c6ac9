//! The texels of one face at one resolution, in the four encodings of the format.

use super::bytes::{Bytes, inflate};
use super::face::Resolution;
use super::header::Header;
use super::sample::Sample;

/// How a block encodes texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// A single texel for all.
    Constant,
    /// Compressed, channel by channel.
    Zipped,
    /// Differences, compressed channel by channel.
    Differences,
    /// A block for each rectangular tile of the face.
    Tiled,
}

/// Texels as encoded in the file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block<'a> {
    encoding: Encoding,
    bytes: &'a [u8],
}

/// Encoding and size of a block, from the top two bits and the rest of its table entry.
fn encoding_and_size(entry: u32) -> (Encoding, u64) {
    let encoding = match entry >> 30 {
        0 => Encoding::Constant,
        1 => Encoding::Zipped,
        2 => Encoding::Differences,
        _ => Encoding::Tiled,
    };
    (encoding, u64::from(entry & 0x3fff_ffff))
}

impl<'a> Block<'a> {
    /// The next block of `bytes`, described by a table entry.
    pub(super) fn take(entry: u32, bytes: &mut Bytes<'a>) -> Result<Block<'a>, String> {
        let (encoding, size) = encoding_and_size(entry);
        let bytes = bytes.take(size)?;
        Ok(Block { encoding, bytes })
    }

    /// The blocks described by a table of `zipped` compressed bytes at the front of `bytes`, and which follow it.
    pub(super) fn take_table(
        bytes: &mut Bytes<'a>,
        zipped: u32,
        count: u64,
    ) -> Result<Vec<Block<'a>>, String> {
        let table = bytes.inflate(zipped.into(), 4 * count)?;
        let mut table = Bytes::new(&table, "table of blocks");
        (0..count)
            .map(|_| Block::take(table.u32()?, bytes))
            .collect()
    }

    /// Writes the texels of a face of `resolution` to `into`, multiplied by alpha if requested.
    pub(super) fn decode<S: Sample>(
        &self,
        header: &Header,
        resolution: Resolution,
        multiply: bool,
        into: &mut [S],
    ) -> Result<(), String> {
        let texel = header.channels.kept().len();
        let target = Target {
            header,
            multiply,
            resolution,
            stride: resolution.width() * texel,
        };
        match self.encoding {
            Encoding::Tiled => self.decode_tiles(&target, into),
            _ => self.decode_rectangle(&target, into),
        }
    }

    /// Tiles go along u first.
    fn decode_tiles<S: Sample>(&self, face: &Target, into: &mut [S]) -> Result<(), String> {
        let mut bytes = Bytes::new(self.bytes, "tiles");
        let tile = Resolution::read(&mut bytes)?;
        let full = face.resolution;
        if tile.u > full.u || tile.v > full.v {
            return Err("a tile is larger than its face".into());
        }
        let (along_u, along_v) = (1u64 << (full.u - tile.u), 1u64 << (full.v - tile.v));
        let zipped = bytes.u32()?;
        let tiles = Block::take_table(&mut bytes, zipped, along_u * along_v)?;
        let texel = face.header.channels.kept().len();
        let target = Target {
            resolution: tile,
            ..*face
        };
        for (number, block) in (0..).zip(tiles) {
            if block.encoding == Encoding::Tiled {
                return Err("a tile is made of tiles".into());
            }
            let (column, row) = (number % along_u, number / along_u);
            let start =
                row as usize * tile.height() * face.stride + column as usize * tile.width() * texel;
            block.decode_rectangle(&target, &mut into[start..])?;
        }
        Ok(())
    }

    /// Writes rows of `target.stride` samples each, from the start of `into`.
    fn decode_rectangle<S: Sample>(&self, target: &Target, into: &mut [S]) -> Result<(), String> {
        let header = target.header;
        let texels = target.resolution.texels();
        let bytes = header.samples.bytes();
        // Planar: one channel of every texel follows another.
        let (numbers, apart): (Vec<S>, usize) = match self.encoding {
            Encoding::Constant => {
                let texel = Bytes::new(self.bytes, "texels").take(header.texel_bytes() as u64)?;
                (numbers(texel, bytes), 0)
            }
            _ => {
                let size = header.texel_bytes() as u64 * texels as u64;
                let plain = inflate(self.bytes, size, "texels")?;
                let mut numbers = numbers(&plain, bytes);
                if self.encoding == Encoding::Differences {
                    S::sum_up(&mut numbers);
                }
                (numbers, 1)
            }
        };
        let plane = if apart == 0 { 1 } else { texels };
        let kept = header.channels.kept().len();
        let width = target.resolution.width();
        for (y, row) in into
            .chunks_mut(target.stride)
            .take(target.resolution.height())
            .enumerate()
        {
            for (x, texel) in row.chunks_exact_mut(kept).take(width).enumerate() {
                let at = (y * width + x) * apart;
                keep(header, target.multiply, |c| numbers[c * plane + at], texel);
            }
        }
        Ok(())
    }
}

/// The destination of a decoded block.
#[derive(Clone, Copy)]
struct Target<'a> {
    header: &'a Header,
    multiply: bool,
    resolution: Resolution,
    /// Samples from one row to the next.
    stride: usize,
}

fn numbers<S: Sample>(bytes: &[u8], each: usize) -> Vec<S> {
    bytes.chunks_exact(each).map(S::from_bytes).collect()
}

/// Writes the channels that are kept of a texel; `of` returns its samples by channel.
fn keep<S: Sample>(header: &Header, multiply: bool, of: impl Fn(usize) -> S, texel: &mut [S]) {
    let channels = &header.channels;
    for (number, &channel) in texel.iter_mut().zip(channels.kept()) {
        *number = match channels.alpha {
            Some(alpha) if multiply && channels.is_multiplied(channel) => {
                of(channel).scaled(of(alpha).value() / S::ONE)
            }
            _ => of(channel),
        };
    }
}

/// The mean values of all faces, one texel each.
pub(super) fn constants<S: Sample>(header: &Header, file: &[u8]) -> Result<Vec<S>, String> {
    let section = header.constants;
    let size = header.texel_bytes() as u64 * u64::from(header.faces);
    let plain = Bytes::from(file, section.start, "constants")?.inflate(section.size, size)?;
    let kept = header.channels.kept().len();
    let mut constants = vec![S::default(); kept * header.faces as usize];
    let texels = plain.chunks_exact(header.texel_bytes());
    for (texel, bytes) in constants.chunks_exact_mut(kept).zip(texels) {
        constant(header, bytes, texel);
    }
    Ok(constants)
}

/// The mean of one face, from the bytes of a texel.
pub(super) fn constant<S: Sample>(header: &Header, bytes: &[u8], texel: &mut [S]) {
    let each = header.samples.bytes();
    let number = |channel| S::from_bytes(bytes.get(channel * each..).unwrap_or_default());
    keep(header, true, number, texel);
}
