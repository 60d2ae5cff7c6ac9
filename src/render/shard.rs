//! A render divided into shards: parts of equal cost, for different machines.
//!
//! The image is divided into small square **cells**; where it has few pixels for so many shards, the samples of a pixel
//! into **blocks**, which are nodes of the image's tree of sums ([`crate::film`]). A shard's pieces lie on a lattice: the
//! cell in column x and row y belongs to shard (x + g y) mod N, with g chosen so that neighbors in the lattice are as
//! far apart as they can be (the spectral test of linear congruential generators: D. E. Knuth, "The Art of Computer
//! Programming" 2, §3.3.4). So every shard sees all of the image, and none gets the expensive corner.

use super::halves::{Counts, follows};
use super::paired_light::{Pairing, Pairs};
use super::work::{Worked, work};
use super::{Goal, Progress, RenderJob, TILE_SIZE, light_pass};
use crate::checkpoint::{Journal, Shard, Unit};
use crate::film::{LightShare, PixelBounds, Splats};
use crate::integrators::Workspace;
use crate::math::UVec2;
use crate::samplers::Sampler;
use rayon::prelude::*;
use std::ops::Range;

/// A shard has at least so many pieces, where there are enough. The cost of a sample jumps at the outlines of things;
/// of the cells there, about 4√256, a shard has half by chance, give or take four: under 2 % of its pieces.
const PIECES: u64 = 256;

/// Samples in the smallest block: a leaf of the tree.
const SMALLEST_BLOCK: u32 = 16;

/// How an image is divided. A pure function of the film and the numbers of samples and shards.
#[derive(Clone, Debug)]
pub struct Division {
    bounds: PixelBounds,
    /// Side of a cell in pixels: a divisor of [`TILE_SIZE`].
    side: u32,
    /// Samples in a block: a power of two.
    block: u32,
    of: u32,
    /// The lattice's steps from row to row and from block to block.
    steps: [u64; 2],
    /// Its only pass has all samples.
    is_whole: bool,
}

/// For each half of the image (or the one image), the samples of each tile that a pass takes.
pub type Pass = Vec<Vec<Range<u32>>>;

/// The passes of an adaptive render of `bounds`: the first, and those with these counts after them. `None` if they cannot
/// be a plan for it.
pub fn passes(bounds: PixelBounds, goal: &Goal, planned: &[Counts]) -> Option<Vec<Pass>> {
    let tiles = bounds.tiles(TILE_SIZE).count();
    let mut have = [vec![0; tiles], vec![0; tiles]];
    let first = [0, 1].map(|_| vec![Goal::PILOT_OF_HALF; tiles]);
    let mut passes = Vec::with_capacity(planned.len() + 1);
    for next in [&first].into_iter().chain(planned) {
        if !follows(&have, next, goal) {
            return None;
        }
        let ranges = |half: usize| {
            let pairs = have[half].iter().zip(&next[half]);
            pairs.map(|(&have, &next)| have..next).collect()
        };
        passes.push(vec![ranges(0), ranges(1)]);
        have.clone_from(next);
    }
    Some(passes)
}

/// Some samples of a cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// Its name; the number is the cell's.
    pub unit: Unit,
    /// The cell.
    pub bounds: PixelBounds,
}

impl Division {
    /// Divides `bounds`; `samples` are those of each pixel, if they may be divided too.
    pub fn new(bounds: PixelBounds, samples: Option<u32>, of: u32) -> Division {
        let wanted = PIECES * u64::from(of.max(1));
        let cells = |side: u32| {
            let [x, y] = bounds
                .size()
                .to_array()
                .map(|n| u64::from(n.div_ceil(side)));
            x * y
        };
        let mut side = TILE_SIZE;
        while side > 1 && cells(side) < wanted {
            side /= 2;
        }
        let blocks = wanted.div_ceil(cells(side).max(1));
        let block = samples.map_or(u32::MAX, |samples| {
            let even = u64::from(samples) / blocks.next_power_of_two();
            (even as u32).max(SMALLEST_BLOCK)
        });
        Division {
            bounds,
            side,
            // The power of two not above.
            block: 1 << block.ilog2(),
            of: of.max(1),
            is_whole: samples.is_some(),
            steps: [
                generator(of.max(1).into()),
                (f64::from(of) * 0.618).round() as u64,
            ],
        }
    }

    /// All samples of an image that is not rendered in passes: of the one set, or of each half.
    pub fn whole(&self, samples: &[u32]) -> Pass {
        let tiles = self.bounds.size().map(|n| n.div_ceil(TILE_SIZE));
        let of_set = |&samples| vec![0..samples; tiles.x as usize * tiles.y as usize];
        samples.iter().map(of_set).collect()
    }

    fn columns(&self) -> u32 {
        self.bounds.size().x.div_ceil(self.side)
    }

    /// Number of cells.
    pub fn cells(&self) -> u32 {
        self.columns() * self.bounds.size().y.div_ceil(self.side)
    }

    /// The pixels of a cell.
    fn cell(&self, number: u32) -> PixelBounds {
        let at = UVec2::new(number % self.columns(), number / self.columns()) * self.side;
        let min = self.bounds.min + at;
        PixelBounds::new(min, min + UVec2::splat(self.side)).intersection(self.bounds)
    }

    /// The tile that a cell is in.
    fn tile(&self, cell: u32) -> usize {
        let at = UVec2::new(cell % self.columns(), cell / self.columns()) * self.side / TILE_SIZE;
        (at.y * self.bounds.size().x.div_ceil(TILE_SIZE) + at.x) as usize
    }

    /// The shard that renders a piece, from 1.
    pub fn owner(&self, piece: &Piece, pass: &Pass) -> u32 {
        let Unit { half, tile, .. } = piece.unit;
        let first = pass[usize::from(half)][self.tile(tile)].start;
        let block = u64::from((piece.unit.samples.start - first) / self.block);
        let (x, y) = (tile % self.columns(), tile / self.columns());
        self.place(x.into(), y.into(), block, half.into()) as u32 + 1
    }

    /// The shard of a block of a cell, from 0.
    fn place(&self, x: u64, y: u64, block: u64, half: u64) -> u64 {
        let [row, layer] = self.steps;
        (x + row * y + layer * (2 * block + half)) % u64::from(self.of)
    }

    /// The light paths of a pass in one half that a shard traces: those that its own camera samples are joined to, where they are, and an equal
    /// part of the others. They cost the same on average, wherever they are.
    pub fn light(
        &self,
        shard: Shard,
        (half, pass): (usize, &Pass),
        (share, are_paired): (LightShare, bool),
    ) -> Vec<Range<u64>> {
        let until = |end: fn(&Range<u32>) -> u32| -> u64 {
            let tiles = self.bounds.tiles(TILE_SIZE).zip(&pass[half]);
            let samples = tiles.map(|(tile, samples)| tile.area() as u64 * u64::from(end(samples)));
            share.paths(samples.sum())
        };
        let (mut start, end) = (until(|samples| samples.start), until(|samples| samples.end));
        let mut paths = Vec::new();
        if are_paired {
            let pairing = Pairing::new(self.bounds, share, pass[half].iter().cloned());
            let of_half = |piece: &Piece| usize::from(piece.unit.half) == half;
            for piece in self.pieces_by(shard, pass).filter(of_half) {
                pairing.add_paths_of((piece.bounds, &piece.unit.samples), &mut paths);
            }
            start = pairing.end();
        }
        let part = |number: u32| {
            let before = u128::from(end - start) * u128::from(number) / u128::from(self.of);
            start + before as u64
        };
        let others = part(shard.number - 1)..part(shard.number);
        paths.extend((!others.is_empty()).then_some(others));
        paths
    }

    /// The pieces of a cell in one half of a pass, in the order of their samples.
    pub fn pieces_of(&self, half: usize, cell: u32, pass: &Pass) -> impl Iterator<Item = Piece> {
        let samples = pass[half][self.tile(cell)].clone();
        let bounds = self.cell(cell);
        let starts = { samples.clone() }.step_by(self.block as usize);
        let block = self.block;
        starts.map(move |start| Piece {
            unit: Unit {
                half: half as u8,
                tile: cell,
                samples: start..start.saturating_add(block).min(samples.end),
            },
            bounds,
        })
    }

    /// All pieces of a pass.
    #[cfg(test)]
    fn pieces<'a>(&'a self, pass: &'a Pass) -> impl Iterator<Item = Piece> + 'a {
        let halves = 0..pass.len();
        halves.flat_map(move |half| {
            (0..self.cells()).flat_map(move |cell| self.pieces_of(half, cell, pass))
        })
    }

    /// The pieces of one shard.
    pub fn pieces_by<'a>(
        &'a self,
        shard: Shard,
        pass: &'a Pass,
    ) -> impl Iterator<Item = Piece> + 'a {
        let columns = u64::from(self.columns());
        let rows = u64::from(self.cells()) / columns.max(1);
        let longest = |half: usize| {
            let lengths = pass[half].iter().map(ExactSizeIterator::len);
            lengths.max().unwrap_or(0).div_ceil(self.block as usize)
        };
        let lines = (0..pass.len()).flat_map(move |half| {
            let blocks = 0..longest(half);
            blocks.flat_map(move |block| (0..rows).map(move |y| (half, block, y)))
        });
        lines.flat_map(move |(half, block, y)| {
            let of = u64::from(self.of);
            let row = self.place(0, y, block as u64, half as u64);
            let first = (u64::from(shard.number) - 1 + of - row) % of;
            let own = (first..columns).step_by(of as usize);
            own.filter_map(move |x| {
                let cell = (y * columns + x) as u32;
                self.pieces_of(half, cell, pass).nth(block)
            })
        })
    }
}

/// Renders what a shard's checkpoint does not have of a pass. Returns whether it has all of it then: it may have been
/// stopped, or the disk be full.
pub fn render_shard(
    job: &RenderJob,
    division: &Division,
    shard: Shard,
    pass: &Pass,
    light: &mut LightOfShard,
    progress: &Progress,
) -> bool {
    let samplers = samplers(job, pass.len(), division.is_whole);
    let pieces: Vec<Piece> = division.pieces_by(shard, pass).collect();
    let mut splats = light.splats.iter_mut();
    let pairs = |(half, samples): (usize, &Vec<Range<u32>>)| {
        let pairing = Pairing::of_pass(job, samples.iter().cloned());
        Pairs::new(job, pairing, (half as u8, splats.next()), progress)
    };
    let pairs: Vec<Option<Pairs>> = pass.iter().enumerate().map(pairs).collect();
    let render = |workspace: &mut Workspace, piece: &Piece| {
        let sampler = &samplers[usize::from(piece.unit.half)];
        if let Some(journal) = progress.journal()
            && journal.has_whole(&piece.unit)
        {
            let samples = piece.unit.samples.len() as u64;
            progress.advance(piece.bounds.area() as u64 * samples);
            return true;
        }
        let unit = (&piece.unit, piece.bounds);
        let pairs = pairs[usize::from(piece.unit.half)].as_ref();
        let worked = work(job, sampler, unit, (workspace, pairs), progress);
        let is_kept = progress
            .journal()
            .is_none_or(|journal| !journal.has_failed());
        matches!(worked, Worked::Finished(_)) && is_kept
    };
    // All of them: `all` would leave others under way without waiting for their records.
    let rendered = pieces.par_iter().map_init(|| job.workspace(), render);
    let is_whole = rendered.reduce(|| true, |a, b| a && b);
    let traced = pairs
        .into_iter()
        .map(|pairs| pairs.map_or(0, Pairs::traced));
    let traced: Vec<u64> = traced.collect();
    let how = (job.splat_share(), job.pairs_paths());
    let halves = light.splats.iter_mut().zip(&samplers).zip(traced);
    (0..)
        .zip(halves)
        .fold(is_whole, |is_whole, (half, of_half)| {
            let ((splats, sampler), traced) = of_half;
            let paths = division.light(shard, (half.into(), pass), how);
            let (sampler, paths) = ((half, sampler), (&paths[..], traced));
            light_pass::trace(job, sampler, splats, paths, || true, progress) && is_whole
        })
}

fn samplers(job: &RenderJob, halves: usize, is_whole: bool) -> Vec<Sampler> {
    match (halves, is_whole) {
        (1, _) => vec![job.sampler.clone()],
        (_, true) => (0..halves)
            .map(|half| job.sampler.half_of_samples(half))
            .collect(),
        (_, false) => (0..halves).map(|half| job.sampler.half(half)).collect(),
    }
}

/// What a shard's light paths have brought, in each half.
pub struct LightOfShard {
    splats: Vec<Splats>,
}

impl LightOfShard {
    /// What its checkpoint has, of so many halves.
    pub fn restored(job: &RenderJob, halves: usize, progress: &Progress) -> LightOfShard {
        let splats = (0..halves as u8).filter_map(|half| light_pass::restored(job, half, progress));
        LightOfShard {
            splats: splats.collect(),
        }
    }

    /// Keeps all of it.
    pub fn keep(&self, journal: &Journal) {
        for (splats, half) in self.splats.iter().zip(0..) {
            journal.keep_splats(half, splats);
        }
    }
}

/// The step g of the lattice {(x, y): x + g y ≡ 0 mod n} whose shortest vector is longest, of those without a common
/// divisor with n: a shard then has its share of every column, as it has of every row, and fences cost all the same.
fn generator(n: u64) -> u64 {
    let even = (1..=n / 2).filter(|g| gcd(*g, n) == 1);
    let best = even.max_by_key(|g| (shortest(n as i64, *g as i64), std::cmp::Reverse(*g)));
    best.unwrap_or(1)
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// The squared length of the lattice's shortest vector, by Gauss's reduction of the basis (−g, 1), (n, 0).
fn shortest(n: i64, g: i64) -> i64 {
    let squared = |v: [i64; 2]| v[0] * v[0] + v[1] * v[1];
    let (mut a, mut b) = ([-g, 1], [n, 0]);
    loop {
        let dot = a[0] * b[0] + a[1] * b[1];
        let times = (dot as f64 / squared(a) as f64).round() as i64;
        b = [b[0] - times * a[0], b[1] - times * a[1]];
        if squared(b) >= squared(a) {
            return squared(a);
        }
        std::mem::swap(&mut a, &mut b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::PathSet;
    use std::collections::HashSet;

    fn bounds(width: u32, height: u32) -> PixelBounds {
        PixelBounds::new(UVec2::new(3, 5), UVec2::new(3 + width, 5 + height))
    }

    fn shards(of: u32) -> impl Iterator<Item = Shard> {
        (1..=of).map(move |number| Shard { number, of })
    }

    /// Every sample of every pixel is in one piece, and every piece in one shard.
    #[test]
    fn shards_are_a_partition() {
        for (width, height, samples, of) in [
            (100, 70, 64, 7),
            (100, 70, 64, 1),
            (1, 1, 1000, 5),
            (33, 17, 100, 64),
            (16, 16, 4, 100),
        ] {
            let bounds = bounds(width, height);
            let division = Division::new(bounds, Some(samples), of);
            let pass = division.whole(&[samples]);
            let mut found = HashSet::new();
            for shard in shards(of) {
                for piece in division.pieces_by(shard, &pass) {
                    for pixel in piece.bounds.pixels() {
                        for sample in piece.unit.samples.clone() {
                            assert!(found.insert((pixel, sample)));
                        }
                    }
                }
            }
            assert_eq!(found.len(), bounds.area() * samples as usize);
        }
    }

    /// Every light path is traced by one shard: where they are paired by the one that has its camera sample.
    #[test]
    fn light_paths_are_a_partition() {
        for (width, height, samples, of, in_blocks) in [
            (50, 37, 7..39, 5, false),
            (5, 4, 0..70, 6, true),
            (64, 16, 3..4, 1, false),
        ] {
            let all = in_blocks.then_some(samples.end);
            let division = Division::new(bounds(width, height), all, of);
            let tiles = division.bounds.tiles(TILE_SIZE).count();
            // Of each other tile one sample more.
            let of_tile = |tile: usize| samples.start..samples.end + tile as u32 % 2;
            let pass = vec![(0..tiles).map(of_tile).collect::<Vec<_>>(); 2];
            for (share, are_paired) in [(0.3, false), (1.0, false), (1.0, true), (2.0, true)] {
                let share = LightShare(share);
                let pairing = Pairing::new(division.bounds, share, pass[1].iter().cloned());
                let mut traced = PathSet::default();
                for shard in shards(of) {
                    let paths = division.light(shard, (1, &pass), (share, are_paired));
                    assert!(traced.insert_all(&paths), "{share:?} {are_paired}");
                    let own = division.pieces_by(shard, &pass);
                    for Piece { unit, bounds } in own.filter(|piece| piece.unit.half == 1) {
                        for pixel in bounds.pixels().filter(|_| are_paired) {
                            for sample in unit.samples.clone() {
                                let path = pairing.path(pixel, sample);
                                assert!(paths.iter().any(|range| range.contains(&path)));
                            }
                        }
                    }
                }
                let all = |end: fn(&Range<u32>) -> u32| -> u64 {
                    let tiles = division.bounds.tiles(TILE_SIZE).zip(&pass[1]);
                    let counts =
                        tiles.map(|(tile, range)| tile.area() as u64 * u64::from(end(range)));
                    share.paths(counts.sum())
                };
                let expected = all(|range| range.start)..all(|range| range.end);
                assert_eq!(traced.ranges(), std::slice::from_ref(&expected));
            }
        }
    }

    /// Blocks are nodes of the tree of sums: what starts at a multiple of a power of two is as long as that, but for the
    /// last.
    #[test]
    fn blocks_are_nodes_of_the_tree() {
        for (samples, of) in [(1000, 64), (100, 1000), (64, 300), (17, 9)] {
            let division = Division::new(bounds(8, 8), Some(samples), of);
            let pass = division.whole(&[samples]);
            for piece in division.pieces(&pass) {
                let Range { start, end } = piece.unit.samples;
                assert!(division.block.is_power_of_two() && division.block >= SMALLEST_BLOCK);
                assert_eq!(start % division.block, 0);
                assert!(end == start + division.block || end == samples);
            }
        }
    }

    /// Costs of samples such as scenes have them: each shard's is within 5 % of the mean.
    #[test]
    fn shards_cost_the_same() {
        let at = |pixel: UVec2| (pixel.as_dvec2() - 3.0) / 256.0;
        let costs: [(&str, &dyn Fn(UVec2) -> f64); 5] = [
            ("even", &|_| 1.0),
            ("floor and sky", &|p| if at(p).y > 0.4 { 10.0 } else { 1.0 }),
            ("a corner", &|p| 1.0 + 9.0 * at(p).x * at(p).y),
            ("a glass ball", &|p| {
                if (at(p) - 0.6).length() < 0.2 {
                    20.0
                } else {
                    1.0
                }
            }),
            // As wide as no power of two, nor as the lattices.
            ("a fence", &|p| if p.x % 11 < 4 { 5.0 } else { 1.0 }),
        ];
        for (name, cost) in costs {
            for of in [2, 3, 7, 16, 64, 100] {
                let division = Division::new(bounds(256, 200), Some(64), of);
                let pass = division.whole(&[64]);
                let of_shard = |shard| -> f64 {
                    let pieces = division.pieces_by(shard, &pass);
                    let of_piece = |piece: Piece| {
                        let samples = piece.unit.samples.len() as f64;
                        piece.bounds.pixels().map(cost).sum::<f64>() * samples
                    };
                    pieces.map(of_piece).sum()
                };
                let found: Vec<f64> = shards(of).map(of_shard).collect();
                let mean = found.iter().sum::<f64>() / f64::from(of);
                for cost in found {
                    let off = cost / mean - 1.0;
                    assert!(
                        off.abs() < 0.05,
                        "{name}, {of} shards: {:.1} %",
                        100.0 * off
                    );
                }
            }
        }
    }

    #[test]
    fn lattices_are_wide() {
        // Without the condition on g, the best lattices have a squared shortest vector of 2n/√3. With it, six is worst, whose
        // shards are diagonals; beyond twenty none has less than half.
        for n in 2..500 {
            let found = shortest(n as i64, generator(n) as i64) as f64;
            let best = 2.0 * n as f64 / 3f64.sqrt();
            let least = if n <= 20 { 0.28 } else { 0.5 };
            assert!(
                found <= best && found >= least * best,
                "{n}: {found} {best}"
            );
            assert_eq!(gcd(generator(n), n), 1);
        }
        assert_eq!([1, 2, 3].map(generator), [1, 1, 1]);
    }
}
