//! Ptex files: a separate image for every face of a mesh, without texture coordinates
//! (Burley and Lacewell 2008, "Ptex: Per-Face Texture Mapping for Production Rendering", EGSR;
//! the format as its authors publish it, version 1).
//!
//! A file holds, little-endian and mostly zlib-compressed:
//!
//! | section | what |
//! |---|---|
//! | header, extended header | kind of mesh and sample, channels, sizes of the other sections, borders |
//! | face table | resolution, flags and neighbors of each face |
//! | constants | the mean of each face |
//! | level table, levels | the texels of all faces; then halved once, twice … for the large ones |
//! | meta data | skipped |
//! | edits | replaced faces |
//!
//! [`PtexFile`] holds everything in flat arrays: for a quadrilateral, every resolution that a filter may request,
//! halved in u and v independently, which takes less than four times the finest. Reductions stored in the file are
//! used; the others are computed as the format's authors do, in the file's own sample type, so that the same values
//! result.
//!
//! Texels are multiplied by alpha if there is such a channel, as pbrt-v3 has them read; the file's reductions are
//! stored that way in any case.

mod block;
mod bytes;
mod edits;
mod face;
mod header;
mod levels;
mod reduce;
mod sample;
#[cfg(test)]
mod tests;
#[cfg(test)]
pub(crate) mod writer;

pub use face::{Face, Resolution};
pub use header::{Border, MeshKind};
pub use sample::{Sample, Texels};

use super::image_data;
use crate::budget::Budget;
use crate::files::FileError;
use header::Header;
use sample::SampleKind;
use std::path::Path;

/// A Ptex file (per-face textures), ready for lookups.
#[derive(Clone, Debug)]
pub struct PtexFile {
    /// The shape of the faces.
    pub mesh: MeshKind,
    /// Border modes for edges without a neighbor, in u and in v.
    pub borders: [Border; 2],
    /// `true` if the first two channels are a vector in a face's own (u, v), to be rotated from face to face.
    pub tangent_vectors: bool,
    /// Channels per texel: 1 or 3.
    pub channels: usize,
    faces: Box<[Face]>,
    texels: Texels,
}

impl PtexFile {
    /// Reads the file at `path`. Corrupt files are errors and never take more memory than their size justifies, nor
    /// more than is left of `budget`.
    pub fn load(path: &Path, budget: &Budget) -> Result<PtexFile, FileError> {
        let (bytes, _held) = image_data::read(path, budget)?;
        let parsed = PtexFile::parse_within(&bytes, budget);
        Ok(parsed.map_err(|e| format!("cannot decode '{}': {e}", path.display()))?)
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.faces[..]) + self.texels.bytes()
    }

    /// Reads a file from memory; the error is a sentence without the file's name.
    #[cfg(any(test, feature = "internals"))]
    pub fn parse(bytes: &[u8]) -> Result<PtexFile, String> {
        PtexFile::parse_within(bytes, &Budget::unlimited())
    }

    fn parse_within(bytes: &[u8], budget: &Budget) -> Result<PtexFile, String> {
        let header = Header::parse(bytes)?;
        let (faces, texels) = match header.samples {
            SampleKind::U8 => read(&header, bytes, budget, Texels::U8),
            SampleKind::U16 => read(&header, bytes, budget, Texels::U16),
            SampleKind::F16 => read(&header, bytes, budget, Texels::F16),
            SampleKind::F32 => read(&header, bytes, budget, Texels::F32),
        }?;
        Ok(PtexFile {
            mesh: header.mesh,
            borders: header.borders,
            tangent_vectors: header.tangent_vectors && header.channels.kept().len() == 3,
            channels: header.channels.kept().len(),
            faces,
            texels,
        })
    }

    /// The faces.
    #[cfg(any(test, feature = "internals"))]
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// Face `id`; `None` if there is no such face.
    #[inline]
    pub fn face(&self, id: u32) -> Option<&Face> {
        self.faces.get(id as usize)
    }

    /// The texels of all faces; [`PtexFile::position`] locates those of one.
    pub fn texels(&self) -> &Texels {
        &self.texels
    }

    /// Index of the first sample of `face` at a resolution, which must be no finer than its own, and for a triangle
    /// equal in u and v. Rows along u follow one another. A constant face has a single texel.
    #[inline]
    pub fn position(&self, face: &Face, at: Resolution) -> usize {
        match face.is_constant() {
            true => face.first,
            false => face.first + self.mesh.texels_before(face.resolution, at) * self.channels,
        }
    }
}

/// The faces, and the texels of all of them.
fn read<S: Sample>(
    header: &Header,
    bytes: &[u8],
    budget: &Budget,
    texels: fn(Box<[S]>) -> Texels,
) -> Result<(Box<[Face]>, Texels), String> {
    let mut faces = face::read(header, bytes)?;
    let order = levels::reduction_order(&faces);
    let mut constants = block::constants::<S>(header, bytes)?;
    let edits = edits::read(header, bytes)?;
    edits::apply(&edits, header, &mut faces, &mut constants);
    let stored = levels::Stored::find(header, bytes, &order, &edits)?;
    let filled = levels::fill(header, &mut faces, &constants, &stored, budget)?;
    Ok((faces.into(), texels(filled)))
}
