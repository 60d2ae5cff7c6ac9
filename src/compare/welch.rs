//! Welch's t-test on a block of pixels whose variances are known.

use super::Estimate;
use super::verdict::{BlockTest, Candidate, Statistic};
use crate::film::PixelBounds;
use crate::math::Rgb;
use glam::DVec3;

/// The standard error of a difference is √(va + vb), its degrees of freedom are (va + vb)² / (va²/νa + vb²/νb) (Welch
/// 1947; Satterthwaite 1946); or, if both images have sample counts, that of the [common variance](super::Options).
pub(super) struct WelchTest<'a> {
    pub a: Estimate<'a>,
    pub b: Estimate<'a>,
    /// Relative differences, to the brightest channel, up to this are ignored.
    pub tolerance: f64,
    /// Samples per pixel of both images, if the larger variance per sample is to be used for both.
    pub common: Option<(f64, f64)>,
    /// Treats all variances as 0.
    pub noiseless: bool,
}

impl BlockTest for WelchTest<'_> {
    const STATISTIC: Statistic = Statistic::Mean;

    fn ask(&self, bounds: PixelBounds) -> [Candidate; 3] {
        let [block_a, block_b] =
            [&self.a, &self.b].map(|estimate| block_means(estimate, bounds, self.noiseless));
        let values = block_a.iter().chain(&block_b).map(|block| block.mean.abs());
        let tolerated = self.tolerance * values.fold(0.0, f64::max);
        [0, 1, 2].map(|channel| {
            let (x, y) = (block_a[channel], block_b[channel]);
            let (error, freedom) = match self.common {
                Some((samples_a, samples_b)) => common_error(x, y, samples_a, samples_b),
                None => welch_error(x, y),
            };
            let excess = (x.mean - y.mean).abs() - tolerated;
            let t = if excess <= 0.0 {
                0.0
            } else {
                (excess / error).copysign(x.mean - y.mean)
            };
            Candidate {
                means: [x.mean, y.mean],
                t,
                freedom,
                floor: 0.0,
            }
        })
    }
}

/// Mean and variance of one channel over a block.
#[derive(Clone, Copy, Debug)]
struct BlockMean {
    mean: f64,
    variance: f64,
    freedom: f64,
}

/// Standard error of the difference and its degrees of freedom, by Welch and Satterthwaite.
fn welch_error(a: BlockMean, b: BlockMean) -> (f64, f64) {
    (
        (a.variance + b.variance).sqrt(),
        pooled_freedom([(a.variance, a.freedom), (b.variance, b.freedom)]),
    )
}

/// The same with the larger variance per sample for both.
fn common_error(a: BlockMean, b: BlockMean, samples_a: f64, samples_b: f64) -> (f64, f64) {
    let (of_a, of_b) = (a.variance * samples_a, b.variance * samples_b);
    let (variance, freedom) = match of_a > of_b {
        true => (of_a, a.freedom),
        false => (of_b, b.freedom),
    };
    let error = (variance * (1.0 / samples_a + 1.0 / samples_b)).sqrt();
    (error, freedom)
}

/// Degrees of freedom of a sum of independent variance estimates (Satterthwaite 1946). Without any variance there is no
/// uncertainty.
fn pooled_freedom(parts: [(f64, f64); 2]) -> f64 {
    let sum: f64 = parts.iter().map(|(variance, _)| variance).sum();
    let squares = parts
        .iter()
        .map(|(variance, freedom)| variance * variance / freedom);
    match sum {
        0.0 => f64::INFINITY,
        _ => sum * sum / squares.sum::<f64>(),
    }
}

/// Means over a block, by channel: variances of independent pixels add, and so do their uncertainties: a block whose
/// variance comes from one bright pixel has only that pixel's degrees of freedom.
fn block_means(estimate: &Estimate, bounds: PixelBounds, noiseless: bool) -> [BlockMean; 3] {
    let image = estimate.image;
    let variances = image.variance.as_deref().filter(|_| !noiseless);
    let at = |values: &[Rgb], i: usize| values.get(i).map_or(DVec3::ZERO, |p| p.as_dvec3());
    let (mut mean, mut variance, mut squares) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for index in bounds.pixels().filter_map(|p| image.bounds.index(p)) {
        let v = at(variances.unwrap_or(&[]), index);
        mean += at(&image.pixels, index);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Satterthwaite's own cases: equal variances double the degrees of freedom, a single variance keeps its own.
    #[test]
    fn freedom_of_a_difference() {
        assert_eq!(pooled_freedom([(0.5, 15.0), (0.5, 15.0)]), 30.0);
        assert_eq!(pooled_freedom([(0.5, 15.0), (0.0, 3.0)]), 15.0);
        assert_eq!(pooled_freedom([(0.0, 15.0), (0.0, 3.0)]), f64::INFINITY);
        assert_eq!(pooled_freedom([(1.0, f64::INFINITY), (1.0, 8.0)]), 32.0);
    }
}
