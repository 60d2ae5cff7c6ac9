//! Blocks of an image's pixels.

use crate::film::PixelBounds;
use crate::math::UVec2;
use crate::math::hash::mix2;
use std::collections::BTreeMap;

/// So many blocks to either side tell of a block's brightness.
const AROUND: usize = 2;

/// Blocks along a side of a region, of which two samples each say more than of one.
const REGION: usize = 8;

/// Squares of pixels, row by row.
pub(super) struct Blocks {
    bounds: PixelBounds,
    side: u32,
    columns: u32,
}

impl Blocks {
    /// At most so many along a side.
    pub(super) fn new(bounds: PixelBounds, most: u32) -> Blocks {
        let size = bounds.size();
        let side = size.max_element().div_ceil(most).max(1);
        Blocks {
            bounds,
            side,
            columns: size.x.div_ceil(side),
        }
    }

    pub(super) fn count(&self) -> usize {
        (self.columns * self.bounds.size().y.div_ceil(self.side)) as usize
    }

    /// The mean of each block's value and those around it.
    pub(super) fn smooth(&self, values: &[f64]) -> Vec<f64> {
        let columns = self.columns as usize;
        let rows = values.len() / columns.max(1);
        let near =
            |at: usize, count: usize| at.saturating_sub(AROUND)..(at + AROUND + 1).min(count);
        let mean = |index: usize| {
            let (xs, ys) = (near(index % columns, columns), near(index / columns, rows));
            let sum: f64 = { ys.clone() }
                .map(|y| xs.clone().map(|x| values[y * columns + x]).sum::<f64>())
                .sum();
            sum / (xs.len() * ys.len()) as f64
        };
        (0..values.len()).map(mean).collect()
    }

    pub(super) fn of(&self, pixel: UVec2) -> u32 {
        let at = (pixel - self.bounds.min) / self.side;
        at.y * self.columns + at.x
    }

    pub(super) fn corner(&self, block: usize) -> UVec2 {
        let block = block as u32;
        self.bounds.min + self.side * UVec2::new(block % self.columns, block / self.columns)
    }

    pub(super) fn size(&self, block: usize) -> UVec2 {
        (self.bounds.max - self.corner(block)).min(UVec2::splat(self.side))
    }

    /// Pixels of all of them.
    pub(super) fn all_pixels(&self) -> f64 {
        self.bounds.area() as f64
    }

    /// Pixels of a block.
    pub(super) fn pixels(&self, block: usize) -> f64 {
        let size = self.size(block);
        f64::from(size.x * size.y)
    }

    /// A pixel of the block, not the same in each: a pattern as wide as blocks would show all of them the same part of it.
    pub(super) fn pixel(&self, block: usize) -> UVec2 {
        let size = self.size(block);
        let chosen = mix2(block as u64, 0);
        let (x, y) = (chosen as u32 % size.x, (chosen >> 32) as u32 % size.y);
        self.corner(block) + UVec2::new(x, y)
    }

    /// The mean of the squares of a value's means in regions of blocks, each estimated from two of the value in each block that have nothing else in
    /// common.
    pub(super) fn mean_square_of_regions(&self, values: impl Iterator<Item = [f64; 2]>) -> f64 {
        let columns = self.columns as usize;
        let mut regions = BTreeMap::new();
        for (block, [a, b]) in values.enumerate() {
            let region = (block / columns / REGION, block % columns / REGION);
            let (sums, count) = regions.entry(region).or_insert(([0.0; 2], 0.0));
            *sums = [sums[0] + a, sums[1] + b];
            *count += 1.0;
        }
        let blocks: f64 = regions.values().map(|(_, count)| count).sum();
        let squares = regions.values().map(|([a, b], count)| a * b / count);
        squares.sum::<f64>() / blocks
    }
}
