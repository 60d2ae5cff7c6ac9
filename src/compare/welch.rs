//! Welch's t-test on a block of pixels whose variances are known.

use super::Estimate;
use super::missed::Missed;
use super::verdict::{BlockTest, Candidate, MayLack, Statistic};
use crate::film::PixelBounds;
use crate::math::Rgb;
use glam::DVec3;

/// The standard error of a difference is √(va + vb), its degrees of freedom are (va + vb)² / (va²/νa + vb²/νb) (Welch
/// 1947; Satterthwaite 1946); or, if both images have sample counts, that of the [common variance](super::Options).
pub(super) struct WelchTest<'a> {
    pub a: Known<'a>,
    pub b: Known<'a>,
    /// Relative differences, to the brightest channel, up to this are ignored.
    pub tolerance: f64,
    /// Samples per pixel of both images, if the larger variance per sample is to be used for both.
    pub common: Option<(f64, f64)>,
    /// Light that one of them may have missed.
    pub missed: Option<Missed>,
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
            let means = [x.mean, y.mean];
            let difference = x.mean - y.mean;
            let t = |error: f64| match difference.abs() - tolerated {
                excess if excess > 0.0 => (excess / error).copysign(difference),
                _ => 0.0,
            };
            let missed = self.missed.map(|missed| {
                let lacking = missed.of_darker(means, channel, bounds.area()) * difference.abs();
                MayLack {
                    portion: missed.of_either(channel, bounds.area()),
                    t: t(error.hypot(lacking.sqrt())),
                    freedom: freedom_with((error * error, freedom), lacking),
                }
            });
            Candidate {
                means,
                t: t(error),
                freedom,
                error,
                missed,
                tolerated,
                floor: 0.0,
                floor_of_all: 0.0,
            }
        })
    }
}

/// Degrees of freedom of a variance, by its own and with one that is known.
pub(super) fn freedom_with(own: (f64, f64), known: f64) -> f64 {
    pooled_freedom([own, (known, f64::INFINITY)])
}

/// For degrees of freedom a factor counts as at least this: where one pixel has nearly all of a square's variance, chance may make the
/// halves of an image so alike there that the square seems to have none, and its factor not to matter.
const MIN_FACTOR: f32 = 0.1;

/// An estimate, and how well the factors of its [`Pool`](super::Pool) are known.
pub(super) struct Known<'a> {
    estimate: Estimate<'a>,
    /// Σσ² and Σσ⁴ of each square, row by row.
    sums: Vec<[DVec3; 2]>,
    /// All squares: from the first one's corner, in units of their side.
    squares: PixelBounds,
}

impl<'a> Known<'a> {
    pub(super) fn new(estimate: Estimate<'a>) -> Known<'a> {
        let bounds = estimate.image.bounds;
        let side = estimate.pool.map_or(1, |pool| pool.side.max(1));
        let squares = touched(bounds, side);
        let pooled = estimate.pool.and(estimate.image.variance.as_ref());
        let independent = estimate.image.independent.as_deref().unwrap_or_default();
        let mut sums = vec![[DVec3::ZERO; 2]; pooled.map_or(0, |_| squares.area())];
        let variances = bounds.pixels().zip(pooled.into_iter().flatten());
        for (i, (pixel, variance)) in variances.enumerate() {
            let own = independent.get(i).copied().unwrap_or_default();
            // A black pixel's variance is a part of its neighbors'.
            let mean = estimate.image.pixels.get(i).copied().unwrap_or_default();
            let own = Rgb::select(mean.cmpne(Rgb::ZERO), own, Rgb::ZERO);
            let variance = variance.max(MIN_FACTOR * own).as_dvec3();
            if let Some(sum) = squares.index(pixel / side).and_then(|i| sums.get_mut(i)) {
                *sum = [sum[0] + variance, sum[1] + variance * variance];
            }
        }
        Known {
            estimate,
            sums,
            squares,
        }
    }

    /// Degrees of freedom of the factors of a block's variance: as those of all squares that it touches. Infinite without
    /// any.
    fn freedom_of_factors(&self, block: PixelBounds) -> DVec3 {
        let Some(pool) = self.estimate.pool else {
            return DVec3::INFINITY;
        };
        let squares = touched(block, pool.side.max(1)).pixels();
        let sums = squares.filter_map(|square| self.sums.get(self.squares.index(square)?));
        let add = |[v, q]: [DVec3; 2], sum: &[DVec3; 2]| [v + sum[0], q + sum[1]];
        let [variance, squares] = sums.fold([DVec3::ZERO; 2], add);
        let freedom = pool.freedom * variance * variance / squares;
        DVec3::select(squares.cmpgt(DVec3::ZERO), freedom, DVec3::INFINITY)
    }
}

/// The squares that some pixels lie in, in units of their side.
fn touched(pixels: PixelBounds, side: u32) -> PixelBounds {
    PixelBounds::new(pixels.min / side, pixels.max.map(|n| n.div_ceil(side)))
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
fn block_means(known: &Known, bounds: PixelBounds, noiseless: bool) -> [BlockMean; 3] {
    let (estimate, image) = (&known.estimate, known.estimate.image);
    // What is smaller than a square may have a part of its variance that differs tenfold from the others'.
    let side = estimate.pool.map_or(0, |pool| pool.side);
    let alone = bounds.size().max_element() < side;
    let independent = image.independent.as_deref().filter(|_| alone);
    let variances = independent.or(image.variance.as_deref());
    let variances = variances.filter(|_| !noiseless);
    let at = |values: &[Rgb], i: usize| values.get(i).map_or(DVec3::ZERO, |p| p.as_dvec3());
    let (mut mean, mut variance, mut squares) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for index in bounds.pixels().filter_map(|p| image.bounds.index(p)) {
        let v = at(variances.unwrap_or(&[]), index);
        mean += at(&image.pixels, index);
        variance += v;
        squares += v * v;
    }
    let count = bounds.area() as f64;
    let of_factors = match independent {
        Some(_) => DVec3::INFINITY,
        None => known.freedom_of_factors(bounds),
    };
    [0, 1, 2].map(|i| BlockMean {
        mean: mean[i] / count,
        variance: variance[i] / (count * count),
        freedom: if variance[i] == 0.0 {
            f64::INFINITY
        } else {
            let own = estimate.freedom * variance[i] * variance[i] / squares[i];
            // Relative variances of independent factors add, and are 2/ν each.
            1.0 / (1.0 / own + 1.0 / of_factors[i])
        },
    })
}

#[cfg(test)]
mod tests {
    use super::super::Pool;
    use super::*;
    use crate::film::Image;
    use crate::math::UVec2;

    /// Satterthwaite's own cases: equal variances double the degrees of freedom, a single variance keeps its own.
    #[test]
    fn freedom_of_a_difference() {
        assert_eq!(pooled_freedom([(0.5, 15.0), (0.5, 15.0)]), 30.0);
        assert_eq!(pooled_freedom([(0.5, 15.0), (0.0, 3.0)]), 15.0);
        assert_eq!(pooled_freedom([(0.0, 15.0), (0.0, 3.0)]), f64::INFINITY);
        assert_eq!(pooled_freedom([(1.0, f64::INFINITY), (1.0, 8.0)]), 32.0);
    }

    /// Squares are counted from the corner of the whole image, whatever part of it is there.
    #[test]
    fn factors_are_known_from_their_squares() {
        let mut image = Image::black(UVec2::new(16, 16));
        image.bounds = PixelBounds::new(UVec2::new(2, 0), UVec2::new(16, 16));
        image.pixels.truncate(14 * 16);
        image.variance = Some(vec![Rgb::splat(0.25); 14 * 16]);
        let known = Known::new(Estimate {
            image: &image,
            freedom: 62.0,
            pool: Some(Pool {
                side: 4,
                freedom: 1.0,
            }),
            samples: None,
            light_paths: None,
        });
        let freedom = |x0, x1, y1| {
            let block = PixelBounds::new(UVec2::new(x0, 0), UVec2::new(x1, y1));
            block_means(&known, block, false)[1].freedom
        };
        let both = |own: f64, squares: f64| 1.0 / (1.0 / own + 1.0 / squares);
        // A pixel in a square of which half is there, one in a whole square, and blocks.
        for (found, expected) in [
            (freedom(2, 3, 1), both(62.0, 8.0)),
            (freedom(4, 5, 1), both(62.0, 16.0)),
            (freedom(8, 16, 8), both(62.0 * 64.0, 64.0)),
            (freedom(3, 5, 4), both(62.0 * 8.0, 24.0)),
        ] {
            // A dozen roundings.
            assert!((found / expected - 1.0).abs() < 1e-14, "{found} {expected}");
        }
    }

    /// One pixel has nearly all of a square's variance, and the halves are alike there by chance: the degrees of freedom are those of one pixel.
    #[test]
    fn a_factor_that_chance_made_small_is_not_taken_for_known() {
        let mut image = Image::black(UVec2::new(8, 8));
        let mut own = vec![Rgb::splat(1e-3); 64];
        own[9] = Rgb::splat(1.0);
        // The other squares' factors are 1.
        let is_alike = |i: usize| i % 8 < 4 && i / 8 < 4;
        let pooled = own
            .iter()
            .enumerate()
            .map(|(i, v)| if is_alike(i) { *v * 1e-6 } else { *v });
        image.variance = Some(pooled.collect());
        image.independent = Some(own);
        image.pixels.fill(Rgb::ONE);
        let freedom = |image: &Image| {
            let known = Known::new(Estimate {
                image,
                freedom: 62.0,
                pool: Some(Pool {
                    side: 4,
                    freedom: 1.0,
                }),
                samples: None,
                light_paths: None,
            });
            block_means(&known, image.bounds, false)[1].freedom
        };
        assert!((1.0..2.5).contains(&freedom(&image)), "{}", freedom(&image));
        // The others are black, and what they have is a part of the bright one's.
        for (i, (mean, own)) in { image.pixels.iter_mut() }
            .zip(image.independent.iter_mut().flatten())
            .enumerate()
        {
            if i != 9 {
                (*mean, *own) = (Rgb::ZERO, Rgb::splat(0.25));
            }
        }
        assert!((1.0..2.5).contains(&freedom(&image)), "{}", freedom(&image));
        image.pixels.fill(Rgb::ONE);
        image.independent = None;
        assert!(freedom(&image) > 40.0);
    }
}
