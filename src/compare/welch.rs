//! Welch's t-test on pixels, blocks and the whole picture.

use super::estimate::check_pair;
use super::{CompareError, Estimate, two_sided_p};
use crate::film::{Image, PixelBounds};
use crate::math::Rgb;
use glam::DVec3;

/// How to test.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// The probability, at most, that pictures of the same expectation are said to differ: of one
    /// whole comparison, all its tests together.
    pub alpha: f64,
    /// Sides, in pixels, of the square blocks whose means are tested; 1 tests single pixels. The mean
    /// of the whole picture is always tested too. Pixels find what is small and wrong, large blocks
    /// what is everywhere and slight.
    pub blocks: Vec<u32>,
    /// Differences up to this fraction of the brightest channel's value do not count. The default,
    /// 1e-5, is ten times what pbrt-v3's single-precision sums and its way through XYZ and back,
    /// which mixes the channels, leave in a reference (1e-6); noise hides anything so small elsewhere.
    pub relative_tolerance: f64,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            alpha: 1e-3,
            blocks: vec![1, 8, 32],
            relative_tolerance: 1e-5,
        }
    }
}

/// The outcome of all tests.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The false-alarm rate that was asked for.
    pub alpha: f64,
    /// One for each block size, then the whole picture.
    pub levels: Vec<Level>,
}

/// The tests on blocks of one size.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Side of the blocks in pixels; `None` for the whole picture.
    pub side: Option<u32>,
    /// Number of tests: blocks × channels.
    pub tests: usize,
    /// The test with the smallest p-value.
    pub worst: Finding,
    /// The probability of a p-value as small as the worst's among so many tests (Šidák 1967, whose
    /// inequality holds for two-sided tests however correlated).
    pub p: f64,
}

/// One test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finding {
    /// The block.
    pub bounds: PixelBounds,
    /// 0 red, 1 green, 2 blue.
    pub channel: usize,
    /// The block's mean in the picture.
    pub a: f64,
    /// The block's mean in the reference.
    pub b: f64,
    /// Difference over its standard error.
    pub t: f64,
    /// Degrees of freedom of that standard error.
    pub freedom: f64,
    /// Probability of so large a |t| where the expectations are equal.
    pub p: f64,
}

impl Verdict {
    /// The probability, at most, of pictures of the same expectation looking this different.
    pub fn p(&self) -> f64 {
        let smallest = self.levels.iter().fold(1.0f64, |p, level| p.min(level.p));
        sidak(smallest, self.levels.len())
    }

    /// True where nothing says that the pictures differ.
    pub fn agrees(&self) -> bool {
        self.p() >= self.alpha
    }
}

/// Mean and variance of one channel over a block.
#[derive(Clone, Copy, Debug)]
struct BlockMean {
    mean: f64,
    variance: f64,
    freedom: f64,
}

/// Tests `a` against `b`; `Ok(None)` where one of them has no variances.
///
/// With Welch's test proper the standard error is √(va + vb), its degrees of freedom are
/// (va + vb)² / (va²/νa + vb²/νb) (Welch 1947; Satterthwaite 1946). It fails on rare bright samples:
/// where a picture of few samples has met none of them, its mean *and* its variance are too low, and
/// the test is certain of a difference that is mere luck. So where both pictures know their number of
/// samples, the larger variance *per sample* of the two is taken for both: a picture that was spared
/// cannot claim more certainty than the other's samples allow. Against pictures that were sampled
/// alike this is Student's test with a slightly high variance; otherwise it errs towards "agree".
///
/// # Errors
/// Pictures of different pixels, or of none.
pub fn welch(
    a: &Estimate,
    b: &Estimate,
    options: &Options,
) -> Result<Option<Verdict>, CompareError> {
    check_pair(a, b)?;
    if a.image.variance.is_none() || b.image.variance.is_none() {
        return Ok(None);
    }
    let sides = options.blocks.iter().map(|&side| Some(side)).chain([None]);
    let levels = sides
        .filter_map(|side| test_level(a, b, side, options.relative_tolerance))
        .collect();
    Ok(Some(Verdict {
        alpha: options.alpha,
        levels,
    }))
}

/// The p-value of every pixel and channel, for a picture of where two pictures differ; `None` where
/// one has no variances.
///
/// # Errors
/// As [`welch`].
pub fn p_values(
    a: &Estimate,
    b: &Estimate,
    options: &Options,
) -> Result<Option<Image>, CompareError> {
    check_pair(a, b)?;
    if a.image.variance.is_none() || b.image.variance.is_none() {
        return Ok(None);
    }
    let pixels = a.image.bounds.pixels().map(|pixel| {
        let bounds = PixelBounds::new(pixel, pixel + 1);
        let findings = test_block(a, b, bounds, options.relative_tolerance);
        Rgb::from(findings.map(|f| f.p as f32))
    });
    Ok(Some(Image {
        pixels: pixels.collect(),
        variance: None,
        ..a.image.clone()
    }))
}

fn test_level(a: &Estimate, b: &Estimate, side: Option<u32>, tolerance: f64) -> Option<Level> {
    let blocks = a.image.bounds.tiles(side.unwrap_or(u32::MAX));
    let (mut tests, mut worst) = (0, None::<Finding>);
    for finding in blocks.flat_map(|bounds| test_block(a, b, bounds, tolerance)) {
        tests += 1;
        if worst
            .is_none_or(|w| finding.p < w.p || (finding.p == w.p && finding.t.abs() > w.t.abs()))
        {
            worst = Some(finding);
        }
    }
    worst.map(|worst| Level {
        side,
        tests,
        worst,
        p: sidak(worst.p, tests),
    })
}

fn test_block(a: &Estimate, b: &Estimate, bounds: PixelBounds, tolerance: f64) -> [Finding; 3] {
    let (block_a, block_b) = (block_means(a, bounds), block_means(b, bounds));
    let values = block_a.iter().chain(&block_b).map(|block| block.mean.abs());
    let tolerated = tolerance * values.fold(0.0, f64::max);
    [0, 1, 2].map(|channel| {
        let (x, y) = (block_a[channel], block_b[channel]);
        let (error, freedom) = match a.samples.zip(b.samples) {
            Some((samples_a, samples_b)) => common_error(x, y, samples_a, samples_b),
            None => welch_error(x, y),
        };
        let excess = (x.mean - y.mean).abs() - tolerated;
        let t = if excess <= 0.0 {
            0.0
        } else {
            (excess / error).copysign(x.mean - y.mean)
        };
        Finding {
            bounds,
            channel,
            a: x.mean,
            b: y.mean,
            t,
            freedom,
            p: two_sided_p(t, freedom),
        }
    })
}

/// Standard error of the difference and its degrees of freedom: Welch and Satterthwaite.
fn welch_error(a: BlockMean, b: BlockMean) -> (f64, f64) {
    (
        (a.variance + b.variance).sqrt(),
        pooled_freedom([(a.variance, a.freedom), (b.variance, b.freedom)]),
    )
}

/// The same with the larger variance per sample for both.
fn common_error(a: BlockMean, b: BlockMean, samples_a: f64, samples_b: f64) -> (f64, f64) {
    let (of_a, of_b) = (a.variance * samples_a, b.variance * samples_b);
    let (variance, freedom) = if of_a > of_b {
        (of_a, a.freedom)
    } else {
        (of_b, b.freedom)
    };
    (
        (variance * (1.0 / samples_a + 1.0 / samples_b)).sqrt(),
        freedom,
    )
}

/// Degrees of freedom of a sum of independent variance estimates (Satterthwaite 1946). Without any
/// variance there is none to be unsure of.
fn pooled_freedom(parts: [(f64, f64); 2]) -> f64 {
    let sum: f64 = parts.iter().map(|(variance, _)| variance).sum();
    let squares: f64 = parts
        .iter()
        .map(|(variance, freedom)| variance * variance / freedom)
        .sum();
    if sum == 0.0 {
        f64::INFINITY
    } else {
        sum * sum / squares
    }
}

/// Means over a block, channel by channel: variances of independent pixels add, and so do their
/// uncertainties: a block whose variance comes from one bright pixel has that pixel's freedom only.
fn block_means(estimate: &Estimate, bounds: PixelBounds) -> [BlockMean; 3] {
    let image = estimate.image;
    let variances = image.variance.as_deref().unwrap_or(&[]);
    let (mut mean, mut variance, mut squares) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for index in bounds
        .pixels()
        .filter_map(|pixel| image.bounds.index(pixel))
    {
        let v = variances.get(index).map_or(DVec3::ZERO, |v| v.as_dvec3());
        mean += image
            .pixels
            .get(index)
            .map_or(DVec3::ZERO, |p| p.as_dvec3());
        variance += v;
        squares += v * v;
    }
    let count = bounds.area() as f64;
    [0, 1, 2].map(|i| BlockMean {
        mean: mean[i] / count,
        variance: variance[i] / (count * count),
        freedom: if variance[i] == 0.0 {
            f64::INFINITY
        } else {
            estimate.freedom * variance[i] * variance[i] / squares[i]
        },
    })
}

/// 1 − (1 − p)^tests without cancellation.
fn sidak(p: f64, tests: usize) -> f64 {
    -(tests as f64 * (-p).ln_1p()).exp_m1()
}
