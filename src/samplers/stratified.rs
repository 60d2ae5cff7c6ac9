//! `stratified`: a grid of cells over the pixel, one sample in each.
//!
//! `xsamples`, `ysamples` (integers, 4 each; 2 each in pbrt-v2): the grid; their product is the
//! number of samples. `jitter` (bool, true): a random point in each cell, else its center.
//! `dimensions` (integer): only so many leading pairs and single dimensions are stratified, the rest
//! is random. Without it all of them are, which pbrt's arrays could not afford.
//!
//! Every pair of dimensions visits the cells of the grid in an order of its own, every single dimension
//! as many intervals of [0, 1) in its own order (Latin hypercubes between them).
//! Source: Pharr, Jakob and Humphreys 2016, §7.3.

use super::count::positive;
use super::permutation::Permutation;
use super::random::RandomStream;
use super::{Points, SamplerSpec};
use crate::math::Vec2;
use crate::math::hash::{mix, mix2, unit_float};
use crate::math::sampling::BELOW_ONE;
use crate::params::ParamReader;

/// The most cells per side: see [`positive`].
const MAX_PER_SIDE: u32 = 1 << 12;

/// The grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stratified {
    /// Cells in x and y.
    nx: u32,
    ny: u32,
    /// Orders in which the cells are visited.
    order: Permutation,
    jitter: bool,
    dimensions: Option<u32>,
}

/// Reads the parameters.
pub(super) fn from_params(reader: &ParamReader) -> SamplerSpec {
    let side = |name: &str| {
        let given = positive(reader, name, 4);
        if given > MAX_PER_SIDE {
            reader.error(
                name,
                format!("more than {MAX_PER_SIDE} strata; using {MAX_PER_SIDE}"),
            );
        }
        given.min(MAX_PER_SIDE)
    };
    let (nx, ny) = (side("xsamples"), side("ysamples"));
    let dimensions = reader
        .find_integer("dimensions")
        .map(|d| d.clamp(0, i64::from(u32::MAX)) as u32);
    let grid = Stratified::new(nx, ny, reader.boolean("jitter", true), dimensions);
    SamplerSpec::new(Points::Stratified(grid), nx * ny)
}

impl Stratified {
    /// `nx` × `ny` cells (each 1 to 4096), the first `dimensions` pairs and single numbers
    /// stratified (all for `None`).
    pub fn new(nx: u32, ny: u32, jitter: bool, dimensions: Option<u32>) -> Stratified {
        let (nx, ny) = (nx.clamp(1, MAX_PER_SIDE), ny.clamp(1, MAX_PER_SIDE));
        Stratified {
            nx,
            ny,
            order: Permutation::new(nx * ny),
            jitter,
            dimensions,
        }
    }

    /// A nearly square grid of at least `n` cells, of exactly `n` where a factor of n allows it.
    /// With more cells than samples each sample still lands in every cell with equal probability.
    pub(super) fn with_samples(self, n: u32) -> Stratified {
        let root = n.isqrt().max(1);
        let nx = (root.div_ceil(2)..=root)
            .rev()
            .find(|nx| n.is_multiple_of(*nx))
            .unwrap_or(root);
        Stratified::new(nx, n.div_ceil(nx), self.jitter, self.dimensions)
    }
}

/// The dimensions of one camera sample.
#[derive(Clone, Copy, Debug)]
pub struct StratifiedStream {
    grid: Stratified,
    /// Seed of the pixel and of the turn of visits to all cells.
    seed: u64,
    /// Index within that turn.
    index: u32,
    singles: u32,
    pairs: u32,
    /// Beyond the stratified dimensions.
    rest: RandomStream,
}

impl StratifiedStream {
    /// Sample `index` of the pixel hashed into `seed`. Once all cells are visited, another turn
    /// begins.
    pub(super) fn new(grid: Stratified, seed: u64, index: u32) -> StratifiedStream {
        let turn = index / grid.order.len();
        let seed = mix2(seed, u64::from(turn));
        let index = index % grid.order.len();
        StratifiedStream {
            grid,
            seed,
            index,
            singles: 0,
            pairs: 0,
            rest: RandomStream::new(!seed, index),
        }
    }

    /// See [`super::SampleStream::fork`].
    pub(super) fn fork(&mut self) -> StratifiedStream {
        // Far from what a path comes to otherwise; and beyond the stratified dimensions, if these are limited.
        let first = mix2(self.singles.into(), self.pairs.into()) as u32 | 1 << 31;
        self.singles = self.singles.wrapping_add(1);
        StratifiedStream {
            singles: first,
            pairs: first,
            rest: self.rest.fork(),
            ..*self
        }
    }

    /// Returns `true` if the dimension after `count` others of its kind is still stratified.
    fn is_stratified(&self, count: u32) -> bool {
        self.grid.dimensions.is_none_or(|limit| count < limit)
    }

    /// The cell this sample visits in the dimension hashed into `key`, and two jitters.
    fn visit(&self, key: u64) -> (u32, Vec2) {
        let cell = self.grid.order.apply(self.index, key);
        if !self.grid.jitter {
            return (cell, Vec2::splat(0.5));
        }
        let bits = mix(key ^ u64::from(self.index + 1) << 32);
        (cell, Vec2::new(unit_float(bits), unit_float(bits << 24)))
    }

    pub(super) fn next_1d(&mut self) -> f32 {
        if !self.is_stratified(self.singles) {
            return self.rest.next_1d();
        }
        let (cell, jitter) = self.visit(mix2(self.seed, u64::from(self.singles) << 1));
        self.singles = self.singles.wrapping_add(1);
        ((cell as f32 + jitter.x) / self.grid.order.len() as f32).min(BELOW_ONE)
    }

    pub(super) fn next_2d(&mut self) -> Vec2 {
        if !self.is_stratified(self.pairs) {
            return self.rest.next_2d();
        }
        let (cell, jitter) = self.visit(mix2(self.seed, u64::from(self.pairs) << 1 | 1));
        self.pairs = self.pairs.wrapping_add(1);
        let corner = Vec2::new((cell % self.grid.nx) as f32, (cell / self.grid.nx) as f32);
        let cells = Vec2::new(self.grid.nx as f32, self.grid.ny as f32);
        ((corner + jitter) / cells).min(Vec2::splat(BELOW_ONE))
    }
}
