//! Blocks of an image's pixels.

use crate::film::PixelBounds;
use crate::math::UVec2;

/// So many blocks to either side tell of a block's brightness.
const AROUND: usize = 2;

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

    /// A pixel of the block.
    pub(super) fn middle(&self, block: usize) -> UVec2 {
        self.corner(block) + self.size(block) / 2
    }
}
