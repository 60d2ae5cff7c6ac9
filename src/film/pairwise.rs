//! Sums in one order, for ever: the fixed tree that an image is added up by.
//!
//! Floating-point addition is not associative, so an image whose sums follow the order of work would differ in its last
//! bits with every way to divide the work. Here the order is a property of the samples: sixteen consecutive samples of
//! a pixel are a leaf, added one after the other; two neighbors whose first has an even index are joined, and so on up,
//! however long it takes. Threads, tiles, shards and resumed renders walk the same tree, each a part of it. Besides,
//! errors of rounding grow with the height of the tree only (N. J. Higham, "The accuracy of floating point summation",
//! 1993, §3).
//!
//! Light paths, which end anywhere on the film, cannot be ordered by pixel: see [`super::splats`].

use super::PixelStatistics;
use crate::math::Rgb;
use glam::DVec3;

/// What neighbors in the tree are joined by.
pub(crate) trait Join {
    /// Adds the right neighbor.
    fn join(&mut self, right: &Self);
}

/// Joins a sequence pairwise, like the carries of a binary counter.
#[derive(Clone, Debug)]
pub(crate) struct Pairwise<T> {
    /// Complete subtrees, each higher than the next: one for every bit of `count`.
    nodes: Vec<T>,
    count: u32,
}

impl<T> Default for Pairwise<T> {
    fn default() -> Pairwise<T> {
        let nodes = Vec::new();
        Pairwise { nodes, count: 0 }
    }
}

impl<T: Join> Pairwise<T> {
    /// Adds the next of the sequence.
    pub(crate) fn push(&mut self, mut node: T) {
        for _ in 0..self.count.trailing_ones() {
            if let Some(mut left) = self.nodes.pop() {
                left.join(&node);
                node = left;
            }
        }
        self.nodes.push(node);
        self.count += 1;
    }

    /// A sequence of `count` already joined.
    pub(crate) fn of(nodes: Vec<T>, count: u32) -> Pairwise<T> {
        Pairwise { nodes, count }
    }

    /// Its complete subtrees, from left to right.
    pub(crate) fn nodes(&self) -> &[T] {
        &self.nodes
    }

    /// Adds the whole tree, which lacks nodes on its right, to `rest`, which follows the sequence: for sums, whose addends may change places. Starts
    /// anew.
    pub(crate) fn take_into(&mut self, rest: &mut T) {
        self.count = 0;
        self.nodes.drain(..).rev().for_each(|left| rest.join(&left));
    }

    /// The whole tree, which lacks nodes on its right; `rest` follows the sequence. Starts anew.
    pub(crate) fn take(&mut self, rest: Option<T>) -> Option<T> {
        self.count = 0;
        let join = |right: Option<T>, mut left: T| {
            if let Some(right) = &right {
                left.join(right);
            }
            Some(left)
        };
        self.nodes.drain(..).rev().fold(rest, join)
    }
}

/// Consecutive samples of one pixel. Their first index must be that of a leaf, for the tree to be the pixel's.
///
/// Within a leaf, differences from its first sample and their squares are added, without a division for each. As that
/// sample is one of them, their squares sum to at most 16 times the squared deviations, so that cancellation costs four
/// bits at most; equal samples deviate by exactly 0.
#[derive(Clone, Debug, Default)]
pub(super) struct PixelSum {
    /// Number of samples in the leaf.
    count: u32,
    first: DVec3,
    differences: DVec3,
    squares: DVec3,
    leaves: Pairwise<PixelStatistics>,
}

impl PixelSum {
    /// Number of samples in a leaf.
    pub(super) const LEAF: u32 = 16;

    /// Adds the next sample.
    #[inline(always)]
    pub(super) fn add(&mut self, value: Rgb) {
        let value = value.as_dvec3();
        if self.count == 0 {
            (self.first, self.differences, self.squares) = (value, DVec3::ZERO, DVec3::ZERO);
        }
        let difference = value - self.first;
        self.differences += difference;
        self.squares += difference * difference;
        self.count += 1;
        if self.count == Self::LEAF {
            self.next_leaf();
        }
    }

    /// Kept apart, so that the rest is small enough to be inlined where samples are added.
    #[inline(never)]
    fn next_leaf(&mut self) {
        let leaf = self.leaf();
        self.leaves.push(leaf);
    }

    /// The leaf as far as it is filled. Starts the next one.
    fn leaf(&mut self) -> PixelStatistics {
        let count = std::mem::take(&mut self.count);
        if count == 0 {
            return PixelStatistics::default();
        }
        let mean = self.differences / f64::from(count);
        let squared_deviations = self.squares - self.differences * mean;
        PixelStatistics {
            mean: self.first + mean,
            // Below 0 by rounding only.
            squared_deviations: squared_deviations.max(DVec3::ZERO),
            count: count.into(),
        }
    }

    /// Number of samples.
    pub(super) fn count(&self) -> u64 {
        u64::from(self.leaves.count) * u64::from(Self::LEAF) + u64::from(self.count)
    }

    /// All samples, pooled. Starts anew.
    pub(super) fn take(&mut self) -> PixelStatistics {
        let rest = (self.count > 0).then(|| self.leaf());
        self.leaves.take(rest).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shows how it was joined.
    impl Join for String {
        fn join(&mut self, right: &String) {
            *self = format!("({self} {right})");
        }
    }

    #[test]
    fn the_tree_is_that_of_indices() {
        let tree = |n: u32| {
            let mut sum = Pairwise::default();
            (0..n).for_each(|i| sum.push(i.to_string()));
            sum.take(None)
        };
        assert_eq!(tree(0), None);
        assert_eq!(tree(1).unwrap(), "0");
        assert_eq!(tree(4).unwrap(), "((0 1) (2 3))");
        assert_eq!(tree(7).unwrap(), "(((0 1) (2 3)) ((4 5) 6))");
        assert_eq!(tree(9).unwrap(), "((((0 1) (2 3)) ((4 5) (6 7))) 8)");
    }

    /// Samples whose sum depends on its order.
    fn value(index: u32) -> Rgb {
        let phase = (index as f32 * 0.618).fract();
        Rgb::new(phase, phase * 1e6, (20.0 * phase).exp())
    }

    fn sum(samples: std::ops::Range<u32>) -> PixelStatistics {
        let mut sum = PixelSum::default();
        samples.for_each(|index| sum.add(value(index)));
        sum.take()
    }

    /// A leaf whose first sample is far from all others loses four bits, no more.
    #[test]
    fn fireflies_leave_the_variance_its_digits() {
        for firefly in [1e3, 1e10, 1e30] {
            let samples = |i: u32| {
                if i == 0 {
                    firefly
                } else {
                    1.0 + 1e-3 * i as f32
                }
            };
            let mut sum = PixelSum::default();
            (0..PixelSum::LEAF).for_each(|i| sum.add(Rgb::splat(samples(i))));
            let n = f64::from(PixelSum::LEAF);
            let mean = (0..PixelSum::LEAF)
                .map(|i| f64::from(samples(i)))
                .sum::<f64>()
                / n;
            let deviations = (0..PixelSum::LEAF).map(|i| (f64::from(samples(i)) - mean).powi(2));
            let expected = deviations.sum::<f64>() / (n * (n - 1.0));
            let found = sum.take().variance_of_mean().x;
            // Four bits of 1.1e-16 in each of some twenty roundings.
            assert!(
                (found / expected - 1.0).abs() < 4e-14,
                "{firefly}: {found} {expected}"
            );
        }
    }

    #[test]
    fn blocks_of_any_power_of_two_make_the_same_bits() {
        for count in [1, 15, 16, 17, 100, 255, 256, 1000, 4097] {
            let whole = sum(0..count);
            for leaves in [1, 2, 8, 64] {
                let size = (leaves * PixelSum::LEAF) as usize;
                let mut blocks = Pairwise::default();
                for start in (0..count).step_by(size) {
                    blocks.push(sum(start..count.min(start + size as u32)));
                }
                assert_eq!(blocks.take(None), Some(whole), "{count} in {size}");
            }
            // Another order makes other bits, or nothing was tested.
            let mut backwards = PixelSum::default();
            { (0..count).rev() }.for_each(|index| backwards.add(value(index)));
            assert!(count <= 2 || backwards.take() != whole, "{count}");
        }
    }
}
