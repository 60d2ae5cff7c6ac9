//! Adaptive allocation of samples to the tiles of an image.
//!
//! A tile whose pixels have the squared relative error v / n after n samples each, and which costs a·n samples (a
//! pixels), gets n in proportion to √(v / a): the least work for a given sum of errors (by Lagrange multipliers; the
//! Neyman allocation of stratified surveys, Neyman 1934).

/// A tile's properties that determine its allocation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Share {
    /// Squared relative error of one sample, summed over the tile's pixels.
    pub noise: f64,
    /// Number of pixels.
    pub area: f64,
    /// Number of samples per pixel so far.
    pub count: u32,
}

/// A tile's noise is taken to be at least this fraction of the average: rare events may not have been sampled yet.
const MIN_NOISE: f64 = 0.05;

/// No tile's count more than doubles in a pass: the first estimate of its noise may be wrong.
const GROWTH: u32 = 2;

/// Counts after the next pass for which Σ noise / count is `target`, limited to `most`. At least one of them increases,
/// unless all are at `most`.
pub(super) fn for_error(tiles: &[Share], target: f64, most: u32) -> Vec<u32> {
    let wishes = wishes(tiles);
    let sum: f64 = tiles.iter().zip(&wishes).map(|(t, w)| w * t.area).sum();
    // Counts λ·wish give Σ noise / (λ·wish) = Σ wish·area / λ.
    let counts = counts(tiles, &wishes, sum / target, most);
    if counts.iter().zip(tiles).any(|(&n, t)| n > t.count) {
        return counts;
    }
    // The estimate says that this should be enough, but the image shows that it is not.
    let more = |t: &Share| (t.count + t.count.div_ceil(4)).min(most);
    tiles.iter().map(more).collect()
}

/// Counts after a pass of about `samples` samples in all pixels together; at most `most` each.
pub(super) fn for_samples(tiles: &[Share], samples: f64, most: u32) -> Vec<u32> {
    let wishes = wishes(tiles);
    let cost = |scale: f64| -> f64 {
        let counts = counts(tiles, &wishes, scale, most);
        let pairs = counts.iter().zip(tiles);
        pairs.map(|(&n, t)| f64::from(n - t.count) * t.area).sum()
    };
    // The cost increases with the scale: bisect its logarithm to 1e-3.
    let (mut low, mut high) = (-60.0f64, 60.0f64);
    while high - low > 1e-3 {
        let middle = 0.5 * (low + high);
        match cost(middle.exp2()) > samples {
            true => high = middle,
            false => low = middle,
        }
    }
    counts(tiles, &wishes, low.exp2(), most)
}

/// Doubled counts, limited to `most`: used if nothing is known of the noise.
pub(super) fn doubled(tiles: &[Share], most: u32) -> Vec<u32> {
    let double = |t: &Share| t.count.saturating_mul(GROWTH).min(most.max(t.count));
    tiles.iter().map(double).collect()
}

/// √(noise / area) of every tile, with the noise at least [`MIN_NOISE`] of the average; uniform if there is no noise
/// anywhere.
fn wishes(tiles: &[Share]) -> Vec<f64> {
    let area: f64 = tiles.iter().map(|t| t.area).sum();
    let average = tiles.iter().map(|t| t.noise).sum::<f64>() / area;
    if average <= 0.0 {
        return vec![1.0; tiles.len()];
    }
    let wish = |t: &Share| (t.noise / t.area).max(MIN_NOISE * average).sqrt();
    tiles.iter().map(wish).collect()
}

fn counts(tiles: &[Share], wishes: &[f64], scale: f64, most: u32) -> Vec<u32> {
    let count = |(t, wish): (&Share, &f64)| {
        let least = t.count.min(most);
        let limit = t.count.saturating_mul(GROWTH).min(most);
        // A float beyond u32 saturates, NaN (no noise at all) becomes zero.
        ((wish * scale).ceil() as u32).clamp(least, limit)
    };
    tiles.iter().zip(wishes).map(count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn share(noise: f64, count: u32) -> Share {
        Share {
            noise,
            area: 256.0,
            count,
        }
    }

    fn error(tiles: &[Share], counts: &[u32]) -> f64 {
        let pairs = tiles.iter().zip(counts);
        pairs.map(|(t, &n)| t.noise / f64::from(n)).sum()
    }

    #[test]
    fn four_times_the_noise_gets_twice_the_samples() {
        let tiles = [share(256.0, 70), share(1024.0, 140)];
        let counts = for_error(&tiles, 10.0, 1 << 20);
        assert_eq!(counts, [77, 154]);
        // Rounding up makes the error slightly smaller than requested, by at most one part in a hundred samples.
        let reached = error(&tiles, &counts);
        assert!(reached <= 10.0 && reached > 9.8, "{reached}");
    }

    #[test]
    fn counts_never_fall_nor_more_than_double() {
        let tiles = [share(1e9, 8), share(0.0, 8), share(1.0, 8)];
        assert_eq!(for_error(&tiles, 1e-9, 1 << 20), [16, 16, 16]);
        assert_eq!(for_error(&tiles, 1e-9, 12), [12, 12, 12]);
        for target in [1e-6, 1.0, 1e9] {
            for (n, t) in for_error(&tiles, target, 1 << 20).iter().zip(&tiles) {
                assert!((t.count..=2 * t.count).contains(n));
            }
        }
    }

    #[test]
    fn there_is_always_progress_until_the_limit() {
        let tiles = [share(1.0, 8), share(1.0, 8)];
        assert_eq!(for_error(&tiles, 1e9, 1 << 20), [10, 10]);
        assert_eq!(for_error(&tiles, 1e9, 8), [8, 8]);
        // Nothing known of the noise, or no noise.
        assert_eq!(for_error(&[share(0.0, 8)], 1.0, 64), [16]);
        assert_eq!(for_error(&[share(f64::NAN, 8)], 1.0, 64), [10]);
    }

    #[test]
    fn a_number_of_samples_is_spent() {
        let tiles = [share(100.0, 64), share(400.0, 64), share(900.0, 64)];
        let spent = |samples: f64| -> f64 {
            let counts = for_samples(&tiles, samples, 1 << 20);
            let pairs = counts.iter().zip(&tiles);
            pairs.map(|(&n, t)| f64::from(n - t.count) * t.area).sum()
        };
        // One more sample in a single tile is 256 samples.
        for samples in [2560.0, 10_000.0, 30_000.0] {
            let s = spent(samples);
            assert!(
                s <= samples && s > samples - 3.0 * 256.0,
                "{s} of {samples}"
            );
        }
        // If no noise has been found, uniformly.
        let blank = [share(0.0, 8), share(0.0, 8)];
        assert_eq!(for_samples(&blank, 2000.0, 1 << 20), [11, 11]);
        assert_eq!(doubled(&blank, 1 << 20), [16, 16]);
        assert_eq!(doubled(&blank, 12), [12, 12]);
        // All double: no more can be spent.
        assert_eq!(spent(1e9), 3.0 * 64.0 * 256.0);
        assert_eq!(spent(0.0), 0.0);
    }
}
