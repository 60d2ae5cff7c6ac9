//! Sample statistics of one pixel.

use super::pairwise::Join;
#[cfg(test)]
use super::pairwise::PixelSum;
#[cfg(test)]
use crate::math::Rgb;
use glam::DVec3;

/// Number of samples, their mean, and the sum of squared deviations from it, per channel.
///
/// Two such summaries are pooled as by Chan, Golub and LeVeque ("Updating formulae and a pairwise algorithm for computing
/// sample variances", 1979). Unlike sums of values and of squares, it does not suffer cancellation when the deviation is small compared
/// with the mean: equal samples have variance exactly 0. In double precision: a million single-precision samples lose
/// nothing that the file could show.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelStatistics {
    pub(super) mean: DVec3,
    pub(super) squared_deviations: DVec3,
    pub(super) count: u64,
}

impl PixelStatistics {
    /// Of these samples.
    #[cfg(test)]
    pub(crate) fn of(samples: impl IntoIterator<Item = Rgb>) -> PixelStatistics {
        let mut sum = PixelSum::default();
        samples.into_iter().for_each(|sample| sum.add(sample));
        sum.take()
    }

    /// The plain mean of two independent estimates of one pixel, regardless of their sample counts, or the one of them
    /// that has samples; its variance is a quarter of the sum of theirs. Weighting by sample counts would bias the mean
    /// if these were chosen adaptively.
    pub fn mean_of(a: &PixelStatistics, b: &PixelStatistics) -> PixelStatistics {
        if a.count == 0 || b.count == 0 {
            return if a.count == 0 { *b } else { *a };
        }
        let count = a.count + b.count;
        let variance = (a.variance_of_mean() + b.variance_of_mean()) * 0.25;
        PixelStatistics {
            mean: (a.mean + b.mean) * 0.5,
            // Chosen so that `variance_of_mean` returns this variance.
            squared_deviations: variance * (count as f64 * (count.max(1) - 1) as f64),
            count,
        }
    }

    /// With an independent estimate of more light added, of this mean and variance. A pixel without samples has none.
    pub(super) fn plus(&self, mean: DVec3, variance: DVec3) -> PixelStatistics {
        if self.count == 0 {
            return *self;
        }
        let count = self.count as f64;
        // Chosen so that `variance_of_mean` returns the sum; that of one sample is infinite without.
        let more = match self.count {
            1 => DVec3::ZERO,
            _ => variance * (count * (count - 1.0)),
        };
        PixelStatistics {
            mean: self.mean + mean,
            squared_deviations: self.squared_deviations + more,
            count: self.count,
        }
    }

    /// Number of samples.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Mean of the samples; 0 if there are none.
    pub fn mean(&self) -> DVec3 {
        self.mean
    }

    /// Unbiased estimate, for independent samples, of the variance of [`mean`](Self::mean): M₂ / (n (n − 1)). For
    /// stratified samples it is too large, never too small on average.
    ///
    /// Infinite for a single sample, which says nothing about variance; 0 for a pixel without samples, which is black
    /// by definition.
    pub fn variance_of_mean(&self) -> DVec3 {
        match self.count {
            0 => DVec3::ZERO,
            1 => DVec3::INFINITY,
            n => self.squared_deviations / (n as f64 * (n - 1) as f64),
        }
    }
}

impl Join for PixelStatistics {
    /// Pools these samples with `other`'s. Pooling with empty statistics, either way round, copies exactly; otherwise
    /// the order affects only rounding.
    fn join(&mut self, other: &PixelStatistics) {
        if other.count == 0 {
            return;
        }
        if self.count == 0 {
            *self = *other;
            return;
        }
        let (a, b) = (self.count as f64, other.count as f64);
        let deviation = other.mean - self.mean;
        self.mean += deviation * (b / (a + b));
        self.squared_deviations +=
            other.squared_deviations + deviation * deviation * (a * b / (a + b));
        self.count += other.count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn of(values: &[Rgb]) -> PixelStatistics {
        PixelStatistics::of(values.iter().copied())
    }

    fn two_pass(values: &[Rgb]) -> (DVec3, DVec3) {
        let n = values.len() as f64;
        let mean = values.iter().map(|v| v.as_dvec3()).sum::<DVec3>() / n;
        let m2 = values
            .iter()
            .map(|v| (v.as_dvec3() - mean) * (v.as_dvec3() - mean))
            .sum::<DVec3>();
        (mean, m2 / (n * (n - 1.0)))
    }

    fn samples() -> impl Strategy<Value = Vec<Rgb>> {
        prop::collection::vec(
            (0.0f32..1e3, 1e-6f32..1e-5, 1e5f32..1.001e5).prop_map(Rgb::from),
            2..200,
        )
    }

    proptest! {
        #[test]
        fn agrees_with_two_passes(values in samples()) {
            let statistics = of(&values);
            let (mean, variance) = two_pass(&values);
            // 200 roundings of 1.1e-16 in the mean; the third channel's deviations are 1e-3 of its
            // values, so its variance carries about a thousand times that.
            prop_assert!((statistics.mean() - mean).abs().cmple(mean * 1e-13).all());
            prop_assert!((statistics.variance_of_mean() - variance).abs().cmple(variance * 1e-9 + 1e-18).all());
        }

        #[test]
        fn merging_parts_agrees_with_the_whole(values in samples(), cut in 0.0f64..1.0) {
            let cut = (cut * values.len() as f64) as usize;
            let mut parts = of(&values[..cut]);
            parts.join(&of(&values[cut..]));
            let whole = of(&values);
            prop_assert_eq!(parts.count(), whole.count());
            // As above: rounding only.
            prop_assert!((parts.mean() - whole.mean()).abs().cmple(whole.mean() * 1e-13).all());
            let (a, b) = (parts.variance_of_mean(), whole.variance_of_mean());
            prop_assert!((a - b).abs().cmple(b * 1e-9 + 1e-18).all());
        }
    }

    #[test]
    fn merging_with_nothing_copies_bits() {
        let some = of(&[Rgb::new(0.1, 0.2, 0.3), Rgb::new(0.7, 0.1, 9.0)]);
        let mut empty = PixelStatistics::default();
        empty.join(&some);
        assert_eq!(empty, some);
        let mut same = some;
        same.join(&PixelStatistics::default());
        assert_eq!(same, some);
    }

    #[test]
    fn equal_samples_have_no_variance() {
        let s = of(&[Rgb::new(0.1, 1e-30, 3e8); 1000]);
        assert_eq!(s.variance_of_mean(), DVec3::ZERO);
        assert_eq!(s.mean().as_vec3(), Rgb::new(0.1, 1e-30, 3e8));
    }

    #[test]
    fn one_sample_leaves_the_variance_open() {
        assert_eq!(of(&[Rgb::ONE]).variance_of_mean(), DVec3::INFINITY);
        assert_eq!(of(&[]).variance_of_mean(), DVec3::ZERO);
    }
}
