//! Uniformity of the p-values, as expected if two images agree.
//!
//! Jung, Hanika and Dachsbacher (JCGT 9(2), 2020, §4) look at the histogram of all p-values: for images with the same
//! expectation it is flat, and a peak at 0 reveals bias that no single test can prove. Here Kolmogorov's test measures
//! how far from flat it is. It is a diagnostic, not part of the verdict: t-tests of skewed samples are not exactly
//! uniform, and stratified samples, whose variance is overestimated, have too few small p-values, so that its own
//! false-alarm rate could not be guaranteed.

use super::verdict::{BlockTest, Candidate};
use crate::film::PixelBounds;
use rayon::prelude::*;

/// Number of histogram bins.
pub const BINS: usize = 20;

/// Number of finer bins, for Kolmogorov's statistic.
const FINE: usize = 400;

/// Maximum number of blocks examined: more would change nothing (Kolmogorov's test detects deviations of 1/√n = 0.2 %).
/// They are spread evenly over the image.
const ENOUGH: usize = 1 << 18;

/// With fewer p-values than this a histogram says nothing.
const FEW: u64 = 64;

/// The distribution of the p-values of one level.
#[derive(Clone, Debug, PartialEq)]
pub struct Uniformity {
    /// Side of the blocks in pixels.
    pub side: u32,
    /// Number of p-values in one channel; blocks without noise have none.
    pub tests: u64,
    /// Number of p-values of all three channels in each twentieth of 0…1.
    pub histogram: [u64; BINS],
    /// Fraction of p-values below 0.05; 5 % is expected.
    pub small: f64,
    /// Largest deviation of the distribution function from the diagonal, over all channels; positive if there are too
    /// many small p-values.
    pub deviation: f64,
    /// Probability of so large a deviation if the p-values are uniform: Kolmogorov's, times 3 for as many channels.
    pub p: f64,
}

impl Uniformity {
    /// The uniformity of all blocks of one size, by `test`; `None` if there are too few.
    pub(super) fn of<T: BlockTest>(test: &T, image: PixelBounds, side: u32) -> Option<Uniformity> {
        let blocks: Vec<PixelBounds> = {
            let size = image.size().map(|n| n.div_ceil(side.max(1)));
            let count = size.x as usize * size.y as usize;
            let stride = count.div_ceil(ENOUGH).max(1);
            image.tiles(side).step_by(stride).collect()
        };
        let values: Vec<[Option<f64>; 3]> = blocks
            .into_par_iter()
            .map(|bounds| test.ask(bounds).map(|candidate| informative(&candidate)))
            .collect();
        let channels: Vec<Channel> = (0..3)
            .map(|c| Channel::new(values.iter().filter_map(|v| v.get(c).copied().flatten())))
            .filter(|channel| channel.count >= FEW)
            .collect();
        let worst = channels
            .iter()
            .max_by(|x, y| x.lambda().total_cmp(&y.lambda()))?;
        let total: u64 = channels.iter().map(|c| c.count).sum();
        let share = FINE / BINS;
        let mut histogram = [0; BINS];
        for (bar, fine) in (0..FINE).map(|i| (i / share, i)) {
            histogram[bar] += channels.iter().map(|c| c.bins[fine]).sum::<u64>();
        }
        Some(Uniformity {
            side,
            tests: worst.count,
            small: histogram[0] as f64 / total as f64,
            histogram,
            deviation: worst.deviation(),
            p: (3.0 * kolmogorov(worst.lambda())).min(1.0),
        })
    }

    /// Returns `true` if there are significantly too many small p-values (at one in a thousand).
    pub fn too_small(&self) -> bool {
        self.p < 1e-3 && self.deviation > 0.0
    }

    /// Returns `true` if there are significantly too few.
    pub fn too_large(&self) -> bool {
        self.p < 1e-3 && self.deviation < 0.0
    }
}

/// The p-value of a test that had noise to compare with.
fn informative(candidate: &Candidate) -> Option<f64> {
    let noisy = candidate.t.is_finite() && candidate.t != 0.0 && candidate.freedom > 0.0;
    noisy.then(|| candidate.p())
}

/// The p-values of one channel.
struct Channel {
    bins: Vec<u64>,
    count: u64,
}

impl Channel {
    fn new(values: impl Iterator<Item = f64>) -> Channel {
        let mut bins = vec![0; FINE];
        let mut count = 0;
        for p in values {
            bins[((p * FINE as f64) as usize).min(FINE - 1)] += 1;
            count += 1;
        }
        Channel { bins, count }
    }

    /// Kolmogorov's statistic with its sign, evaluated only at the bins' edges: never larger than the true one, so the
    /// test errs toward "uniform".
    fn deviation(&self) -> f64 {
        let (mut below, mut most) = (0, 0.0f64);
        for (i, bin) in (1..FINE).zip(&self.bins) {
            below += bin;
            let deviation = below as f64 / self.count as f64 - i as f64 / FINE as f64;
            if deviation.abs() > most.abs() {
                most = deviation;
            }
        }
        most
    }

    /// The deviation in units of its own scatter, with Stephens' correction for few values (M. A. Stephens, J. R.
    /// Statist. Soc. B 32, 1970).
    fn lambda(&self) -> f64 {
        let root = (self.count as f64).sqrt();
        self.deviation().abs() * (root + 0.12 + 0.11 / root)
    }
}

/// Kolmogorov's distribution: the probability of a larger λ, 2 Σ (−1)ᵏ⁻¹ exp(−2 k² λ²).
fn kolmogorov(lambda: f64) -> f64 {
    // Below this, the probability is 1 to ten digits and the series converges slowly.
    if lambda < 0.2 {
        return 1.0;
    }
    let term = |k: i32| {
        let sign = if k % 2 == 1 { 2.0 } else { -2.0 };
        sign * (-2.0 * f64::from(k * k) * lambda * lambda).exp()
    };
    (1..=30).map(term).sum::<f64>().clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smirnov's table (Ann. Math. Stat. 19, 1948): 5 % at 1.3581, 1 % at 1.6276, half at 0.8276.
    #[test]
    fn kolmogorovs_distribution() {
        for (lambda, p) in [(1.3581, 0.05), (1.6276, 0.01), (0.8276, 0.5)] {
            assert!((kolmogorov(lambda) - p).abs() < 1e-4);
        }
        assert_eq!(kolmogorov(0.0), 1.0);
        assert!(kolmogorov(30.0) < 1e-300);
    }

    #[test]
    fn deviations_have_a_sign() {
        let uniform = |n: usize| (0..n).map(move |i| (i as f64 + 0.5) / n as f64);
        assert!(Channel::new(uniform(1000)).deviation().abs() < 2e-3);
        let small = Channel::new(uniform(1000).map(|p| p * p));
        // √p − p is largest at p = 1/4.
        assert!((small.deviation() - 0.25).abs() < 5e-3);
        assert!(Channel::new(uniform(1000).map(f64::sqrt)).deviation() < -0.2);
        assert_eq!(Channel::new(std::iter::once(1.0)).bins[FINE - 1], 1);
    }
}
