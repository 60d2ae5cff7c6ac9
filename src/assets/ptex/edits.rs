//! Edits: replaced faces, at the end of the file.

use super::block::{Block, constant};
use super::bytes::Bytes;
use super::face::Face;
use super::header::Header;
use super::sample::Sample;

/// The kind of edit that replaces a face. Others concern metadata.
const FACE: u8 = 0;

/// A replaced face.
pub(super) struct Edit<'a> {
    pub number: usize,
    face: Face,
    mean: &'a [u8],
    /// Its texels; `None` for a constant face.
    pub block: Option<Block<'a>>,
}

/// The edits of faces, in the order in which they were made.
pub(super) fn read<'a>(header: &Header, file: &'a [u8]) -> Result<Vec<Edit<'a>>, String> {
    let start = usize::try_from(header.edits.start).unwrap_or(usize::MAX);
    let Some(mut given) = file.get(start..) else {
        return Ok(Vec::new());
    };
    if let Some(size) = header.edits.size {
        given = &given[..usize::try_from(size).unwrap_or(usize::MAX).min(given.len())];
    }
    let mut bytes = Bytes::new(given, "edits");
    let mut edits = Vec::new();
    // Kind and size of an edit take five bytes; fewer are not an edit.
    while let (Ok(kind), Ok(size)) = (bytes.u8(), bytes.u32()) {
        if size == 0 {
            break;
        }
        let edit = bytes.take(size.into())?;
        if kind == FACE {
            edits.extend(face(header, edit)?);
        }
    }
    Ok(edits)
}

/// `None` for a face that does not exist.
fn face<'a>(header: &Header, edit: &'a [u8]) -> Result<Option<Edit<'a>>, String> {
    let mut bytes = Bytes::new(edit, "edited face");
    let number = bytes.u32()?;
    if number >= header.faces {
        return Ok(None);
    }
    let face = Face::read(&mut bytes, header, number)?;
    let entry = bytes.u32()?;
    let mean = bytes.take(header.texel_bytes() as u64)?;
    let block = match face.is_constant() {
        true => None,
        false => Some(Block::take(entry, &mut bytes)?),
    };
    Ok(Some(Edit {
        number: number as usize,
        face,
        mean,
        block,
    }))
}

/// Applies the edits to faces and their means.
pub(super) fn apply<S: Sample>(
    edits: &[Edit],
    header: &Header,
    faces: &mut [Face],
    constants: &mut [S],
) {
    let kept = header.channels.kept().len();
    for edit in edits {
        let texel = constants.chunks_exact_mut(kept).nth(edit.number);
        if let (Some(face), Some(texel)) = (faces.get_mut(edit.number), texel) {
            *face = edit.face;
            face.mark_edited();
            constant(header, edit.mean, texel);
        }
    }
}
