//! The tests' outcome.

use super::{Correction, two_sided_p};
use crate::film::PixelBounds;
use crate::math::UVec2;
use libm::erfc;
use rayon::prelude::*;

/// The outcome of all tests.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The requested false-alarm rate.
    pub alpha: f64,
    /// How it was divided: evenly among the levels, then among the tests of each.
    pub correction: Correction,
    /// One for each block size, then one for the whole image.
    pub levels: Vec<Level>,
}

/// The tests on blocks of one size.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Side of the blocks in pixels; `None` for the whole image.
    pub side: Option<u32>,
    /// The statistic tested in each block.
    pub statistic: Statistic,
    /// Number of tests: blocks × channels.
    pub tests: usize,
    /// Number of tests significant at the level's share of the false-alarm rate, corrected for all of them.
    pub rejected: usize,
    /// The test with the smallest p-value.
    pub worst: Finding,
    /// Upper bound on the probability of a p-value as small as the worst one among that many tests.
    pub p: f64,
}

/// A statistic of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statistic {
    /// The mean of the difference; 0 if the images agree.
    Mean,
    /// The correlation of each pixel's difference with those of its right and lower neighbors. Noise has none; moved or
    /// sharpened content does.
    Neighbors,
}

/// The result of one test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finding {
    /// The block.
    pub bounds: PixelBounds,
    /// 0 red, 1 green, 2 blue.
    pub channel: usize,
    /// The block's mean in the image.
    pub a: f64,
    /// The block's mean in the reference.
    pub b: f64,
    /// The statistic over its standard error.
    pub t: f64,
    /// Degrees of freedom of that standard error.
    pub freedom: f64,
    /// Probability of so large a |t| if the expectations are equal. With light that one image may have missed it is the larger of two: with that
    /// noise, of which `t` and `freedom` are, and without.
    pub p: f64,
}

impl Verdict {
    /// Upper bound on the probability that images with the same expectation look this different.
    pub fn p(&self) -> f64 {
        let smallest = self.levels.iter().fold(1.0f64, |p, level| p.min(level.p));
        self.correction.adjust(smallest, self.levels.len())
    }

    /// Returns `true` if no test shows that the images differ.
    pub fn agrees(&self) -> bool {
        self.p() >= self.alpha
    }

    /// The most significant level.
    pub fn worst(&self) -> Option<&Level> {
        self.levels.iter().min_by(|x, y| {
            x.p.total_cmp(&y.p)
                .then(y.worst.t.abs().total_cmp(&x.worst.t.abs()))
        })
    }
}

/// A test before its p-value, which is expensive, has been computed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    /// The means in the image and in the reference.
    pub means: [f64; 2],
    pub t: f64,
    pub freedom: f64,
    /// Standard error of the difference.
    pub error: f64,
    /// Light that one of the images may have missed.
    pub missed: Option<MayLack>,
    /// Differences up to this are ignored.
    pub tolerated: f64,
    /// Lower bound on the p-value of any test of this block.
    pub floor: f64,
    /// The same if all its observations differed.
    pub floor_of_all: f64,
}

/// A test with the noise of light that one of the images may have missed, which has to be significant, too.
#[derive(Clone, Copy, Debug)]
pub(super) struct MayLack {
    /// The most that the variance of the difference may grow by for each unit of light that one of the images has missed.
    pub portion: f64,
    pub t: f64,
    pub freedom: f64,
}

impl Candidate {
    pub(super) fn p(&self) -> f64 {
        let with = self.missed.map(|m| two_sided_p(m.t, m.freedom));
        two_sided_p(self.t, self.freedom)
            .max(with.unwrap_or(0.0))
            .max(self.floor)
    }

    /// The statistic, with all noise that there may be.
    pub(super) fn t(&self) -> f64 {
        self.missed.map_or(self.t, |missed| missed.t)
    }

    /// A lower bound: Student's tails are heavier than the normal distribution's.
    fn min_p(&self) -> f64 {
        erfc(self.t().abs() * std::f64::consts::FRAC_1_SQRT_2).max(self.floor)
    }
}

/// A statistical test applied to every block, channel by channel.
pub(super) trait BlockTest: Sync {
    const STATISTIC: Statistic;
    fn ask(&self, bounds: PixelBounds) -> [Candidate; 3];
}

/// The outcome of several tests.
#[derive(Default)]
struct Gathered {
    tests: usize,
    worst: Option<Finding>,
    /// p-values small enough to be rejected.
    small: Vec<f64>,
}

impl Gathered {
    fn add(&mut self, bounds: PixelBounds, channel: usize, candidate: Candidate, alpha: f64) {
        self.tests += 1;
        let least = match candidate.t.is_nan() {
            true => 0.0,
            false => candidate.min_p(),
        };
        if least > alpha && self.worst.is_some_and(|worst| least > worst.p) {
            return;
        }
        let p = candidate.p();
        if p <= alpha {
            self.small.push(p);
        }
        let finding = Finding {
            bounds,
            channel,
            a: candidate.means[0],
            b: candidate.means[1],
            t: candidate.t(),
            freedom: candidate.missed.map_or(candidate.freedom, |m| m.freedom),
            p,
        };
        self.offer(finding);
    }

    fn offer(&mut self, finding: Finding) {
        let more_significant = |worst: Finding| {
            let larger = finding.t.abs() > worst.t.abs();
            finding.p < worst.p || (finding.p == worst.p && larger)
        };
        if self.worst.is_none_or(more_significant) {
            self.worst = Some(finding);
        }
    }

    /// Appends the outcome of the rows below.
    fn append(mut self, below: Gathered) -> Gathered {
        self.tests += below.tests;
        self.small.extend(below.small);
        below.worst.into_iter().for_each(|worst| self.offer(worst));
        self
    }
}

/// Tests all blocks of one size in parallel; `alpha` is the level's share.
pub(super) fn test_level<T: BlockTest>(
    test: &T,
    image: PixelBounds,
    side: Option<u32>,
    alpha: f64,
    correction: Correction,
) -> Option<Level> {
    let rows: Vec<PixelBounds> = image_rows(image, side).collect();
    let gathered = rows.into_par_iter().map(|row| {
        let mut gathered = Gathered::default();
        for bounds in row.tiles(side.unwrap_or(u32::MAX)) {
            for (channel, candidate) in (0..).zip(test.ask(bounds)) {
                gathered.add(bounds, channel, candidate, alpha);
            }
        }
        gathered
    });
    let gathered = gathered.collect::<Vec<_>>().into_iter();
    let gathered = gathered.fold(Gathered::default(), Gathered::append);
    gathered.worst.map(|worst| Level {
        side,
        statistic: T::STATISTIC,
        tests: gathered.tests,
        rejected: correction.rejected(gathered.small, gathered.tests, alpha),
        worst,
        p: correction.adjust(worst.p, gathered.tests),
    })
}

/// The image divided into rows of blocks.
fn image_rows(image: PixelBounds, side: Option<u32>) -> impl Iterator<Item = PixelBounds> {
    let side = side.unwrap_or(u32::MAX).max(1);
    let count = image.size().y.div_ceil(side);
    (0..count).map(move |j| {
        let top = image.min.y + j * side;
        let bottom = top + side.min(image.max.y - top);
        PixelBounds::new(
            UVec2::new(image.min.x, top),
            UVec2::new(image.max.x, bottom),
        )
    })
}
