//! The levels of a file, and all reductions of its faces made from them.

use super::block::Block;
use super::bytes::Bytes;
use super::edits::Edit;
use super::face::{Face, Resolution};
use super::header::{Header, MeshKind};
use super::reduce;
use super::sample::Sample;
use crate::assets::image_data::{FREE_BYTES, MAX_EXPANSION};
use crate::budget::Budget;
use rayon::prelude::*;
use std::cmp::Reverse;

/// Number of levels that faces can have; further levels in a file belong to no face.
const MAX_LEVELS: u16 = 17;

/// Rank of each face in the levels of reductions: faces with a larger shorter side come first, and constant ones count
/// as two texels wide.
pub(super) fn reduction_order(faces: &[Face]) -> Vec<u32> {
    let shorter_side = |face: &Face| match face.is_constant() {
        true => 1,
        false => face.resolution.u.min(face.resolution.v),
    };
    let mut order: Vec<u32> = (0..faces.len() as u32).collect();
    order.sort_by_key(|&face| Reverse(shorter_side(&faces[face as usize])));
    let mut ranks = vec![0; faces.len()];
    for (rank, face) in (0..).zip(order) {
        ranks[face as usize] = rank;
    }
    ranks
}

/// The stored blocks of each face.
pub(super) struct Stored<'a> {
    /// By level: in the finest, the blocks of all faces; in the others, ordered by `ranks`.
    levels: Vec<Vec<Block<'a>>>,
    ranks: &'a [u32],
}

impl<'a> Stored<'a> {
    /// Finds all blocks.
    pub(super) fn find(
        header: &Header,
        file: &'a [u8],
        ranks: &'a [u32],
        edits: &[Edit<'a>],
    ) -> Result<Stored<'a>, String> {
        let mut table = Bytes::from(file, header.level_table.start, "table of levels")?;
        let mut start = header.level_data;
        let mut levels = Vec::new();
        for number in 0..header.levels.min(MAX_LEVELS) {
            let (size, zipped, faces) = (table.u64()?, table.u32()?, table.u32()?);
            if faces > header.faces {
                return Err(format!("level {number} has more faces than there are"));
            }
            let mut bytes = Bytes::from(file, start, "levels")?;
            levels.push(Block::take_table(&mut bytes, zipped, faces.into())?);
            start = start.saturating_add(size);
        }
        if let Some(finest) = levels.first_mut() {
            for edit in edits {
                if let (Some(place), Some(block)) = (finest.get_mut(edit.number), edit.block) {
                    *place = block;
                }
            }
        }
        Ok(Stored { levels, ranks })
    }

    /// The block of a face halved `halvings` times.
    fn block(&self, number: usize, face: &Face, halvings: u8) -> Option<&Block<'a>> {
        let level = self.levels.get(usize::from(halvings))?;
        match halvings {
            0 => level.get(number),
            // Reductions predate the edit.
            _ if face.is_edited() => None,
            _ => level.get(*self.ranks.get(number)? as usize),
        }
    }
}

/// Assigns every face its position, and fills in its texels.
pub(super) fn fill<S: Sample>(
    header: &Header,
    faces: &mut [Face],
    constants: &[S],
    stored: &Stored,
    budget: &Budget,
) -> Result<Box<[S]>, String> {
    let kept = header.channels.kept().len();
    let mut total = 0usize;
    let mut sizes = Vec::with_capacity(faces.len());
    for face in faces.iter_mut() {
        let texels = match face.is_constant() {
            true => 1,
            false => header.mesh.texels_in_all(face.resolution),
        };
        face.first = total;
        sizes.push(texels * kept);
        total = total.saturating_add(texels * kept);
    }
    let most = FREE_BYTES.max((header.file_bytes as u64).saturating_mul(MAX_EXPANSION));
    if (total as u64).saturating_mul(size_of::<S>() as u64) > most {
        return Err("its faces claim too many texels for a file of this size".into());
    }
    let bytes = (total as u64).saturating_mul(size_of::<S>() as u64);
    budget.take(bytes).map_err(|e| format!("it {e}"))?;
    let mut texels = vec![S::default(); total].into_boxed_slice();
    let mut places = Vec::with_capacity(faces.len());
    let mut rest = &mut texels[..];
    for size in sizes {
        let (place, others) = rest.split_at_mut(size);
        places.push(place);
        rest = others;
    }
    // All, so that the first problem in file order is the one reported.
    let results: Vec<Result<(), String>> = places
        .into_par_iter()
        .zip(faces.par_iter())
        .enumerate()
        .map(|(number, (place, face))| {
            let constant = &constants[number * kept..][..kept];
            fill_face(header, (number, face), constant, stored, place)
                .map_err(|message| format!("face {number}: {message}"))
        })
        .collect();
    results.into_iter().collect::<Result<(), String>>()?;
    Ok(texels)
}

/// A face with all its reductions. The one-texel reduction is its mean from the file.
fn fill_face<S: Sample>(
    header: &Header,
    (number, face): (usize, &Face),
    constant: &[S],
    stored: &Stored,
    place: &mut [S],
) -> Result<(), String> {
    let kept = header.channels.kept().len();
    if !face.is_constant() {
        let full = face.resolution;
        let position = |at| header.mesh.texels_before(full, at) * kept;
        let mut given = [false; MAX_LEVELS as usize];
        for halvings in 0..=full.u.min(full.v) {
            let at = Resolution {
                u: full.u - halvings,
                v: full.v - halvings,
            };
            let Some(block) = stored.block(number, face, halvings) else {
                continue;
            };
            let into = &mut place[position(at)..][..at.texels() * kept];
            block.decode(header, at, halvings == 0, into)?;
            given[usize::from(halvings)] = true;
        }
        if !given[0] {
            return Err("it has no texels".into());
        }
        match header.mesh {
            MeshKind::Triangles => reduce::triangle(place, full, kept, &given),
            MeshKind::Quads => reduce::quadrilateral(place, full, kept, &given),
        }
    }
    place[..kept].copy_from_slice(constant);
    Ok(())
}
