//! The header and extended header of a file.

use super::bytes::Bytes;
use super::face::Resolution;
use super::sample::SampleKind;
use arrayvec::ArrayVec;

/// The shape of a mesh's faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshKind {
    /// Triangles: u and v are barycentric, and the file's squares hold two triangular halves.
    Triangles,
    /// Quadrilaterals.
    Quads,
}

impl MeshKind {
    /// Number of edges of a face.
    pub fn edges(self) -> u8 {
        match self {
            MeshKind::Triangles => 3,
            MeshKind::Quads => 4,
        }
    }

    /// Number of texels of a face of resolution `full` that precede its reduction to `at`, the coarsest being first:
    /// halved in u and v independently, or in both at once for triangles.
    #[inline]
    pub(super) fn texels_before(self, full: Resolution, at: Resolution) -> usize {
        match self {
            MeshKind::Triangles => ((1 << (2 * at.u)) - 1) / 3,
            // Reductions are ordered by v, then by u.
            MeshKind::Quads => {
                (at.height() - 1) * (2 * full.width() - 1) + at.height() * (at.width() - 1)
            }
        }
    }

    /// Number of texels of a face with all its reductions.
    pub(super) fn texels_in_all(self, full: Resolution) -> usize {
        match self {
            MeshKind::Triangles => ((1 << (2 * (full.u + 1))) - 1) / 3,
            MeshKind::Quads => (2 * full.height() - 1) * (2 * full.width() - 1),
        }
    }
}

/// The border mode for edges without a neighbor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Border {
    /// Repeats the outermost texels.
    Clamp,
    /// Zero.
    Black,
    /// Wraps around to the opposite side.
    Periodic,
}

impl Border {
    fn from_number(number: u16) -> Result<Border, String> {
        match number {
            0 => Ok(Border::Clamp),
            1 => Ok(Border::Black),
            2 => Ok(Border::Periodic),
            _ => Err(format!("its border mode {number} is unknown")),
        }
    }
}

/// Which channels of a texel are kept.
#[derive(Clone, Debug)]
pub(super) struct Channels {
    /// Channels per texel in the file.
    pub stored: usize,
    /// The alpha channel, if any.
    pub alpha: Option<usize>,
    kept: ArrayVec<usize, 3>,
}

impl Channels {
    /// One channel or three are all kept, as in pbrt-v3, whichever is marked as alpha. Of two or four, those other than
    /// alpha are kept; pbrt-v3 rejects such files.
    fn new(stored: usize, alpha: i32) -> Result<Channels, String> {
        let alpha = usize::try_from(alpha).ok().filter(|&a| a < stored);
        let kept: Option<ArrayVec<usize, 3>> = match (stored, alpha) {
            (1 | 3, _) => Some((0..stored).collect()),
            (2 | 4, Some(alpha)) => Some((0..stored).filter(|&c| c != alpha).collect()),
            _ => None,
        };
        let kept = kept.ok_or_else(|| {
            format!("it has {stored} channels: 1 or 3 are read, or one more with alpha")
        })?;
        Ok(Channels {
            stored,
            alpha,
            kept,
        })
    }

    /// The channels that are kept.
    pub(super) fn kept(&self) -> &[usize] {
        &self.kept
    }

    /// Returns `true` if the channel is to be multiplied by alpha: all others if alpha comes first, otherwise those
    /// before it.
    pub(super) fn is_multiplied(&self, channel: usize) -> bool {
        match self.alpha {
            None => false,
            Some(0) => channel > 0,
            Some(alpha) => channel < alpha,
        }
    }
}

/// Header and extended header, and the locations of the sections.
#[derive(Debug)]
pub(super) struct Header {
    pub mesh: MeshKind,
    pub samples: SampleKind,
    pub channels: Channels,
    pub levels: u16,
    pub faces: u32,
    pub borders: [Border; 2],
    pub tangent_vectors: bool,
    pub face_table: Section,
    pub constants: Section,
    pub level_table: Section,
    /// Offset of the levels.
    pub level_data: u64,
    pub edits: Edits,
    /// Size of the file in bytes, against which its claims are checked.
    pub file_bytes: usize,
}

/// The location of a section.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section {
    pub start: u64,
    pub size: u64,
}

/// The location of the edits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edits {
    pub start: u64,
    /// `None` in older files: up to the end of the file.
    pub size: Option<u64>,
}

/// Size of the header.
const HEADER_SIZE: u64 = 64;

/// Size of the known part of the extended header.
const EXTENDED_SIZE: u32 = 40;

/// Zeros after the metadata, at which the earliest readers stopped.
const BARRIER: u64 = 8;

impl Header {
    pub(super) fn parse(file: &[u8]) -> Result<Header, String> {
        if !file.starts_with(b"Ptex") {
            return Err("it is not a Ptex file: it does not start with \"Ptex\"".into());
        }
        let mut bytes = Bytes::new(file, "header");
        bytes.take(4)?;
        let version = bytes.u32()?;
        if version != 1 {
            return Err(format!("it is of version {version}: version 1 is read"));
        }
        let mesh = match bytes.u32()? {
            0 => MeshKind::Triangles,
            1 => MeshKind::Quads,
            other => return Err(format!("its kind of mesh {other} is unknown")),
        };
        let samples = SampleKind::from_number(bytes.u32()?)?;
        let alpha = bytes.i32()?;
        let channels = Channels::new(usize::from(bytes.u16()?), alpha)?;
        let levels = bytes.u16()?;
        let faces = bytes.u32()?;
        let extended_size = bytes.u32()?;
        let [face_table, constants, level_table] = [bytes.u32()?, bytes.u32()?, bytes.u32()?];
        let _minor_version = bytes.u32()?;
        let level_data_size = bytes.u64()?;
        let meta_data_size = bytes.u32()?;
        let _meta_data_plain_size = bytes.u32()?;
        let extended = Extended::parse(bytes.take(u64::from(extended_size))?)?;

        let mut at = HEADER_SIZE + u64::from(extended_size);
        let mut section = |size: u64| {
            let start = at;
            at = at.saturating_add(size);
            Section { start, size }
        };
        let face_table = section(face_table.into());
        let constants = section(constants.into());
        let level_table = section(level_table.into());
        let level_data = section(level_data_size);
        section(u64::from(meta_data_size) + BARRIER);
        section(extended.large_meta_data);
        Ok(Header {
            mesh,
            samples,
            channels,
            levels,
            faces,
            borders: extended.borders,
            tangent_vectors: extended.tangent_vectors,
            face_table,
            constants,
            level_table,
            level_data: level_data.start,
            edits: Edits {
                start: extended.edits_start.max(at),
                size: (extended.edits_start > 0).then_some(extended.edits_size),
            },
            file_bytes: file.len(),
        })
    }

    /// Bytes per texel in the file.
    pub(super) fn texel_bytes(&self) -> usize {
        self.channels.stored * self.samples.bytes()
    }
}

/// The extended header. Fields missing from older files are 0.
struct Extended {
    borders: [Border; 2],
    tangent_vectors: bool,
    large_meta_data: u64,
    edits_start: u64,
    edits_size: u64,
}

impl Extended {
    fn parse(given: &[u8]) -> Result<Extended, String> {
        let mut known = [0; EXTENDED_SIZE as usize];
        let length = given.len().min(known.len());
        known[..length].copy_from_slice(&given[..length]);
        let mut bytes = Bytes::new(&known, "extended header");
        let u_border = bytes.u16()?;
        let _padding = bytes.u16()?;
        let v_border = bytes.u16()?;
        let edge_filter = bytes.u16()?;
        let large_headers = bytes.u32()?;
        let _large_headers_plain_size = bytes.u32()?;
        let large_data = bytes.u64()?;
        Ok(Extended {
            borders: [
                Border::from_number(u_border)?,
                Border::from_number(v_border)?,
            ],
            tangent_vectors: edge_filter == 1,
            large_meta_data: u64::from(large_headers).saturating_add(large_data),
            edits_size: bytes.u64()?,
            edits_start: bytes.u64()?,
        })
    }
}
