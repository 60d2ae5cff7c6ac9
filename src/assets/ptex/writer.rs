//! Writes Ptex files for tests: every kind of mesh, sample and encoding, from floats.

use super::face::{Face, Resolution};
use super::header::MeshKind;
pub(crate) use super::sample::SampleKind;
use flate2::{Compression, write::ZlibEncoder};
use half::f16;
use std::io::Write;

/// How texels are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Packing {
    /// Only the first texel, as a constant.
    Constant,
    Zipped,
    Differences,
    /// Tiles of this size, each difference-encoded if integer, or constant if it is.
    Tiled(Resolution),
}

/// A file to be written.
#[derive(Clone, Debug)]
pub(crate) struct Writer {
    pub mesh: MeshKind,
    pub samples: SampleKind,
    pub channels: usize,
    /// -1 if there is none.
    pub alpha: i32,
    pub borders: [u16; 2],
    pub tangent_vectors: bool,
    pub packing: Packing,
    /// How many reductions to store.
    pub reductions: u8,
    /// `true` if metadata is included, small and large, to be skipped.
    pub meta_data: bool,
    /// Each with its texels, rows along u, channels interleaved; a constant face with a single texel.
    pub faces: Vec<(Face, Vec<f32>)>,
    /// Replaced faces, by index.
    pub edits: Vec<(u32, Face, Vec<f32>)>,
}

impl Default for Writer {
    fn default() -> Writer {
        Writer {
            mesh: MeshKind::Quads,
            samples: SampleKind::F32,
            channels: 1,
            alpha: -1,
            borders: [0; 2],
            tangent_vectors: false,
            packing: Packing::Zipped,
            reductions: 0,
            meta_data: false,
            faces: Vec::new(),
            edits: Vec::new(),
        }
    }
}

fn zip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn shorter_side(face: &Face) -> u8 {
    match face.is_constant() {
        true => 1,
        false => face.resolution.u.min(face.resolution.v),
    }
}

/// Halves the resolution by taking means.
pub(crate) fn halved(mesh: MeshKind, at: Resolution, channels: usize, texels: &[f32]) -> Vec<f32> {
    let (width, height) = (at.width(), at.height());
    let of = |x: usize, y: usize, c: usize| texels[(y * width + x) * channels + c];
    let mut smaller = Vec::new();
    for y in 0..height / 2 {
        for x in 0..width / 2 {
            for c in 0..channels {
                let fourth = match mesh {
                    MeshKind::Quads => of(2 * x + 1, 2 * y + 1, c),
                    // Faces of triangles are square, but where a test wants them wrong.
                    MeshKind::Triangles => {
                        let mirrored = |at: usize| width.saturating_sub(1 + 2 * at);
                        of(mirrored(y), mirrored(x).min(height - 1), c)
                    }
                };
                let three = of(2 * x, 2 * y, c) + of(2 * x + 1, 2 * y, c) + of(2 * x, 2 * y + 1, c);
                smaller.push(0.25 * (three + fourth));
            }
        }
    }
    smaller
}

impl Writer {
    /// The bytes of a sample.
    fn number(&self, value: f32) -> Vec<u8> {
        match self.samples {
            SampleKind::U8 => vec![(value * 255.0 + 0.5) as u8],
            SampleKind::U16 => ((value * 65535.0 + 0.5) as u16).to_le_bytes().into(),
            SampleKind::F16 => f16::from_f32(value).to_le_bytes().into(),
            SampleKind::F32 => value.to_le_bytes().into(),
        }
    }

    fn texel(&self, values: &[f32]) -> Vec<u8> {
        values.iter().flat_map(|&v| self.number(v)).collect()
    }

    fn mean(&self, texels: &[f32]) -> Vec<f32> {
        let count = texels.len() / self.channels;
        let sum = |c: usize| texels.iter().skip(c).step_by(self.channels).sum::<f32>();
        (0..self.channels).map(|c| sum(c) / count as f32).collect()
    }

    /// Planar, channel by channel; as differences if requested.
    fn planes(&self, texels: &[f32], differences: bool) -> Vec<u8> {
        let planes = (0..self.channels).flat_map(|c| texels.iter().skip(c).step_by(self.channels));
        let plain: Vec<u8> = planes.flat_map(|&v| self.number(v)).collect();
        let wide = |b: &[u8]| u16::from_le_bytes([b[0], b[1]]);
        match self.samples {
            SampleKind::U8 if differences => {
                let before = [0].iter().chain(&plain);
                plain
                    .iter()
                    .zip(before)
                    .map(|(a, b)| a.wrapping_sub(*b))
                    .collect()
            }
            SampleKind::U16 if differences => {
                let numbers: Vec<u16> = plain.chunks(2).map(wide).collect();
                let before = [0].iter().chain(&numbers);
                let apart = numbers.iter().zip(before).map(|(a, b)| a.wrapping_sub(*b));
                apart.flat_map(u16::to_le_bytes).collect()
            }
            _ => plain,
        }
    }

    /// The block and its table entry.
    fn block(&self, at: Resolution, texels: &[f32], packing: Packing) -> (u32, Vec<u8>) {
        let (code, bytes) = match packing {
            Packing::Constant => (0u32, self.texel(&texels[..self.channels])),
            Packing::Zipped => (1, zip(&self.planes(texels, false))),
            Packing::Differences => (2, zip(&self.planes(texels, true))),
            Packing::Tiled(tile) => (3, self.tiles(at, tile, texels)),
        };
        (code << 30 | bytes.len() as u32, bytes)
    }

    fn tiles(&self, at: Resolution, tile: Resolution, texels: &[f32]) -> Vec<u8> {
        let tile = Resolution {
            u: tile.u.min(at.u),
            v: tile.v.min(at.v),
        };
        let (mut table, mut blocks) = (Vec::new(), Vec::new());
        let n = self.channels;
        for y in (0..at.height()).step_by(tile.height()) {
            for x in (0..at.width()).step_by(tile.width()) {
                let rows = (y..y + tile.height()).flat_map(|y| {
                    texels[(y * at.width() + x) * n..]
                        .iter()
                        .take(tile.width() * n)
                });
                let part: Vec<f32> = rows.copied().collect();
                let integer = matches!(self.samples, SampleKind::U8 | SampleKind::U16);
                let packing = match part.chunks(n).all(|t| *t == part[..n]) {
                    true => Packing::Constant,
                    false if integer => Packing::Differences,
                    false => Packing::Zipped,
                };
                let (entry, block) = self.block(tile, &part, packing);
                table.extend(entry.to_le_bytes());
                blocks.extend(block);
            }
        }
        let table = zip(&table);
        let size = (table.len() as u32).to_le_bytes();
        [&[tile.u, tile.v], &size[..], &table, &blocks].concat()
    }

    /// Multiplied by alpha, as reductions are stored.
    fn multiplied(&self, texels: &[f32]) -> Vec<f32> {
        let Ok(alpha) = usize::try_from(self.alpha) else {
            return texels.into();
        };
        let texel = |t: &[f32]| {
            let times = |(c, v): (usize, &f32)| match alpha {
                0 if c > 0 => v * t[0],
                _ if c < alpha => v * t[alpha],
                _ => *v,
            };
            t.iter().enumerate().map(times).collect::<Vec<f32>>()
        };
        texels.chunks(self.channels).flat_map(texel).collect()
    }

    /// The entry in the level table, and the level.
    fn level(&self, halvings: u8) -> (Vec<u8>, Vec<u8>) {
        let mut faces: Vec<&(Face, Vec<f32>)> = self.faces.iter().collect();
        if halvings > 0 {
            faces.sort_by_key(|(face, _)| std::cmp::Reverse(shorter_side(face)));
            faces.retain(|(face, _)| shorter_side(face) > halvings);
        }
        let (mut table, mut blocks) = (Vec::new(), Vec::new());
        for (face, texels) in &faces {
            let (mut at, mut texels) = (face.resolution, texels.clone());
            let (entry, block) = if face.is_constant() {
                (0, Vec::new())
            } else {
                for _ in 0..halvings {
                    texels = halved(self.mesh, at, self.channels, &texels);
                    at = Resolution {
                        u: at.u - 1,
                        v: at.v - 1,
                    };
                }
                if halvings > 0 {
                    texels = self.multiplied(&texels);
                }
                self.block(at, &texels, self.packing)
            };
            table.extend(entry.to_le_bytes());
            blocks.extend(block);
        }
        let count = faces.len() as u32;
        let table = zip(&table);
        let level = [&table[..], &blocks].concat();
        let size = (level.len() as u64).to_le_bytes();
        let entry = [
            &size[..],
            &(table.len() as u32).to_le_bytes(),
            &count.to_le_bytes(),
        ]
        .concat();
        (entry, level)
    }

    fn edit(&self, (number, face, texels): &(u32, Face, Vec<f32>)) -> Vec<u8> {
        let (entry, block) = match face.is_constant() {
            true => (0, Vec::new()),
            false => self.block(face.resolution, texels, self.packing),
        };
        let face = face.to_bytes();
        let mean = self.texel(&self.mean(texels));
        let parts = [
            &number.to_le_bytes()[..],
            &face,
            &entry.to_le_bytes(),
            &mean,
            &block,
        ];
        let edit = parts.concat();
        [&[0][..], &(edit.len() as u32).to_le_bytes(), &edit].concat()
    }

    /// The file.
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let table = zip(&self
            .faces
            .iter()
            .flat_map(|(f, _)| f.to_bytes())
            .collect::<Vec<u8>>());
        let means = self
            .faces
            .iter()
            .flat_map(|(_, t)| self.texel(&self.mean(t)));
        let constants = zip(&means.collect::<Vec<u8>>());
        let levels: Vec<_> = (0..=self.reductions).map(|r| self.level(r)).collect();
        let level_table: Vec<u8> = levels.iter().flat_map(|(entry, _)| entry.clone()).collect();
        let level_data: Vec<u8> = levels.iter().flat_map(|(_, level)| level.clone()).collect();
        let meta_plain = if self.meta_data {
            &b"\x05name\0\0\x03\0\0\0abc"[..]
        } else {
            &[]
        };
        let meta = if self.meta_data {
            zip(meta_plain)
        } else {
            Vec::new()
        };
        let large = if self.meta_data {
            vec![7u8; 300]
        } else {
            Vec::new()
        };
        let edits: Vec<u8> = self.edits.iter().flat_map(|e| self.edit(e)).collect();

        let mut out = b"Ptex".to_vec();
        let mut word = |n: usize| out.extend((n as u32).to_le_bytes());
        word(1);
        word(usize::from(self.mesh == MeshKind::Quads));
        word(self.samples as usize);
        word(self.alpha as usize);
        word(self.channels | levels.len() << 16);
        word(self.faces.len());
        word(40);
        word(table.len());
        word(constants.len());
        word(level_table.len());
        word(4); // the minor version of today's files
        word(level_data.len());
        word(0);
        word(meta.len());
        word(meta_plain.len());
        let sections = table.len() + constants.len() + level_table.len() + level_data.len();
        let edits_start = 64 + 40 + sections + meta.len() + 8 + large.len();
        word(usize::from(self.borders[0]));
        word(usize::from(self.borders[1]) | usize::from(self.tangent_vectors) << 16);
        // Large metadata: 100 bytes of headers and 200 of data.
        word(large.len() / 3);
        word(large.len());
        word(large.len() - large.len() / 3);
        word(0);
        word(edits.len());
        word(0);
        word(edits_start);
        word(0);
        for section in [
            table,
            constants,
            level_table,
            level_data,
            meta,
            vec![0; 8],
            large,
            edits,
        ] {
            out.extend(section);
        }
        out
    }
}
