//! A piece of a render's work: some samples of every pixel of a tile. Between blocks of samples it can be kept in a
//! checkpoint, and stopped.

use super::paired_light::Pairs;
use super::{Progress, RenderJob, sample_tile};
use crate::checkpoint::Unit;
use crate::film::{Pairwise, PixelBounds, Tile};
use crate::integrators::Workspace;
use crate::samplers::Sampler;

/// Samples of each pixel in a block: a power of two of the leaves of the image's tree of sums ([`crate::film`]), so
/// that the sums are those without blocks. Small enough that a slow scene's block takes seconds.
const BLOCK: u32 = 64;

/// A tile as far as it was rendered.
pub(super) enum Worked {
    /// With all samples of its unit.
    Finished(Tile),
    /// The render was stopped before.
    Stopped(Tile),
}

/// Renders what the checkpoint does not have of `unit`: samples of the pixels in `bounds`. Never inlined, as [`sample_tile`].
#[inline(never)]
pub(super) fn work(
    job: &RenderJob,
    sampler: &Sampler,
    (unit, bounds): (&Unit, PixelBounds),
    (workspace, pairs): (&mut Workspace, Option<&Pairs>),
    progress: &Progress,
) -> Worked {
    let (start, end) = (unit.samples.start, unit.samples.end);
    let blank = || job.film.tile(bounds);
    let journal = progress.journal();
    let restored = journal.and_then(|journal| journal.restore(unit, blank));
    let is_tree = |(done, nodes): &(u32, Vec<Tile>)| match *done == end {
        true => nodes.len() == 1,
        false => nodes.len() == (done - start).div_ceil(BLOCK).count_ones() as usize,
    };
    let restored = restored.filter(is_tree);
    let (mut done, nodes) = restored.unwrap_or((start, Vec::new()));
    let mut kept_until = done;
    let count_of = |samples: u32| bounds.area() as u64 * u64::from(samples);
    progress.advance(count_of(done - start));
    nodes.iter().for_each(|tile| progress.show(unit.half, tile));
    let mut blocks = Pairwise::of(nodes, (done - start).div_ceil(BLOCK));
    if done == end {
        return Worked::Finished(blocks.take(None).unwrap_or_else(blank));
    }
    let interval = || journal.map_or(0, |journal| journal.interval());
    let mut kept = interval();
    while done < end {
        if progress.is_stopped() {
            if let Some(journal) = journal.filter(|_| done > kept_until) {
                journal.under_way(unit, done, blocks.nodes(), false);
            }
            return Worked::Stopped(blocks.take(None).unwrap_or_else(blank));
        }
        let block = done..done.saturating_add(BLOCK).min(end);
        done = block.end;
        let mut tile = blank().after(block.start.into());
        let samples = count_of(block.len() as u32);
        progress.counted(|watch| {
            let own = (&mut *workspace, watch, pairs);
            sample_tile(job, sampler, block, (&mut tile, bounds), own);
        });
        progress.show(unit.half, &tile);
        progress.advance(samples);
        blocks.push(tile);
        if let Some(journal) = journal
            && done < end
            && interval() > kept
        {
            (kept, kept_until) = (interval(), done);
            journal.under_way(unit, done, blocks.nodes(), true);
        }
    }
    let tile = blocks.take(None).unwrap_or_else(blank);
    if let Some(journal) = journal {
        journal.finished(unit, &tile);
    }
    Worked::Finished(tile)
}
