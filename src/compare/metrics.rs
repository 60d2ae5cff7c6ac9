//! Error metrics of an image: MSE, PSNR and others.

use super::scatter::Scatter;
use super::student::two_sided_t;
use super::verdict::BlockTest;
use super::welch::{Known, WelchTest};
use super::{Estimate, NoiseSource};
use crate::film::PixelBounds;
use crate::math::color::luminance;
use glam::DVec3;
use rayon::prelude::*;

/// Error metrics of an image against its reference, over all pixels and channels, in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metrics {
    /// Mean squared error.
    pub mse: f64,
    /// The mean squared error expected from noise alone: the mean of both variances. `None` if an image has no
    /// variances. `mse` minus this estimates the squared bias.
    pub expected_mse: Option<f64>,
    /// Mean of (a − b)² / (b² + ε²), where ε is 1 % of the reference's mean (otherwise dark pixels would dominate).
    pub relative_mse: f64,
    /// Peak signal-to-noise ratio in dB, the peak being the reference's largest value; infinite for
    /// equal images.
    pub psnr: f64,
    /// Largest |a − b|.
    pub max_difference: f64,
    /// The means of red, green and blue.
    pub channels: [ChannelMeans; 3],
    /// The tile whose mean luminance differs most.
    pub largest_tile: TileDifference,
}

/// Mean luminances of one tile of 32 × 32 pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileDifference {
    /// The tile, smaller at the right and bottom edges.
    pub bounds: PixelBounds,
    /// Mean luminance of the image.
    pub a: f64,
    /// Mean luminance of the reference.
    pub b: f64,
}

/// Side of a tile of [`TileDifference`]: large enough to average out noise, small enough to locate a difference.
pub(super) const TILE: u32 = 32;

/// The means of one channel over the whole image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelMeans {
    /// Mean of the image.
    pub a: f64,
    /// Mean of the reference.
    pub b: f64,
    /// a / b; 1 if both are 0.
    pub ratio: f64,
    /// Half the width of the ratio's 95 % confidence interval, to first order in the noise (delta method), by Student's
    /// quantile. `None` if the noise is unknown.
    pub ratio_error: Option<f64>,
}

impl Metrics {
    /// The metrics of images that are black in the `left_out` pixels, which do not count. Where the difference tells the noise, squares
    /// of `cell` pixels are independent of each other.
    pub(super) fn new(
        a: &Estimate,
        b: &Estimate,
        noise: NoiseSource,
        cell: u32,
        left_out: usize,
    ) -> Metrics {
        let count = a.image.pixels.len().saturating_sub(left_out).max(1) as f64;
        let pairs = || {
            let pixels = a.image.pixels.iter().zip(&b.image.pixels);
            pixels.map(|(p, q)| (p.as_dvec3(), q.as_dvec3()))
        };
        let per_value = |sum: DVec3| sum.element_sum() / (3.0 * count);
        let mean_b = per_value(pairs().map(|(_, q)| q).sum());
        let floor = DVec3::splat((0.01 * mean_b).powi(2).max(f64::MIN_POSITIVE));
        let mse = per_value(pairs().map(|(p, q)| (p - q) * (p - q)).sum());
        let relative = pairs().map(|(p, q)| (p - q) * (p - q) / (q * q + floor));
        let peak = pairs().fold(0.0f64, |peak, (_, q)| peak.max(q.max_element()));
        Metrics {
            mse,
            expected_mse: mean_variance(a, count)
                .zip(mean_variance(b, count))
                .map(|(u, v)| (u + v).element_sum() / 3.0)
                .filter(|v| v.is_finite()),
            relative_mse: per_value(relative.sum()),
            psnr: if mse == 0.0 {
                f64::INFINITY
            } else {
                10.0 * (peak * peak / mse).log10()
            },
            max_difference: pairs().fold(0.0, |most, (p, q)| (p - q).abs().max_element().max(most)),
            channels: channel_means(a, b, noise, cell.max(1), count),
            largest_tile: largest_tile(a, b),
        }
    }
}

/// Mean of the variances of the pixels.
fn mean_variance(estimate: &Estimate, count: f64) -> Option<DVec3> {
    let variance = estimate.image.variance.as_ref()?;
    Some(variance.iter().map(|p| p.as_dvec3()).sum::<DVec3>() / count)
}

fn channel_means(
    a: &Estimate,
    b: &Estimate,
    noise: NoiseSource,
    cell: u32,
    count: f64,
) -> [ChannelMeans; 3] {
    let mean = |e: &Estimate| e.image.pixels.iter().map(|p| p.as_dvec3()).sum::<DVec3>() / count;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let errors = errors_of_means(a, b, noise, cell, count);
    let freedom = freedom_of_means(a, b, noise, cell);
    [0, 1, 2].map(|i| {
        let (a, b) = (mean_a[i], mean_b[i]);
        let ratio = if a == b { 1.0 } else { a / b };
        let quantile = two_sided_t(0.05, freedom[i]);
        let ratio_error = errors.map(|[u, v]| quantile * u[i].hypot(ratio * v[i]) / b.abs());
        ChannelMeans {
            a,
            b,
            ratio,
            ratio_error: ratio_error.map(|e| if e.is_nan() { 0.0 } else { e }),
        }
    })
}

/// Standard errors of both images' means. Pixels are independent: the variance of their mean is the mean variance over
/// their number. If only the scatter of the difference is known, all of it is attributed to A, which is right to first
/// order for ratios near 1.
fn errors_of_means(
    a: &Estimate,
    b: &Estimate,
    noise: NoiseSource,
    cell: u32,
    count: f64,
) -> Option<[DVec3; 2]> {
    match noise {
        NoiseSource::None => None,
        NoiseSource::Stored => {
            let error = |e| Some((mean_variance(e, count)? / count).map(f64::sqrt));
            Some([error(a)?, error(b)?])
        }
        _ => {
            let scatter = Scatter {
                a: *a,
                b: *b,
                tolerance: 0.0,
                cell,
            };
            Some([scatter.error_of_mean(), DVec3::ZERO])
        }
    }
}

/// Degrees of freedom of the errors of both means together.
fn freedom_of_means(a: &Estimate, b: &Estimate, noise: NoiseSource, cell: u32) -> [f64; 3] {
    if noise.is_spatial() {
        // One goes into the mean; a single cell has no scatter.
        let cells = a.image.bounds.tiles(cell).count();
        return [cells.saturating_sub(1).max(1) as f64; 3];
    }
    if noise == NoiseSource::None {
        return [f64::INFINITY; 3];
    }
    let test = WelchTest {
        a: Known::new(*a),
        b: Known::new(*b),
        tolerance: 0.0,
        common: None,
        missed: None,
        noiseless: false,
    };
    let freedoms = test.ask(a.image.bounds).map(|candidate| candidate.freedom);
    // Of no noise, or of single samples, nothing has been known either way.
    freedoms.map(|freedom| {
        if freedom >= 1.0 {
            freedom
        } else {
            f64::INFINITY
        }
    })
}

/// The first of the tiles whose mean luminances differ most.
fn largest_tile(a: &Estimate, b: &Estimate) -> TileDifference {
    let tiles: Vec<PixelBounds> = a.image.bounds.tiles(TILE).collect();
    let mean = |e: &Estimate, tile: PixelBounds| {
        let indices = tile.pixels().filter_map(|p| e.image.bounds.index(p));
        let values = indices.filter_map(|i| e.image.pixels.get(i));
        values.map(|&p| f64::from(luminance(p))).sum::<f64>() / tile.area() as f64
    };
    let differences = tiles.par_iter().map(|&bounds| TileDifference {
        bounds,
        a: mean(a, bounds),
        b: mean(b, bounds),
    });
    let size = |tile: &TileDifference| (tile.a - tile.b).abs();
    let larger = |worst, tile| match size(&tile) > size(&worst) {
        true => tile,
        false => worst,
    };
    let differences: Vec<_> = differences.collect();
    differences
        .into_iter()
        .reduce(larger)
        .unwrap_or(TileDifference {
            bounds: a.image.bounds,
            a: 0.0,
            b: 0.0,
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Image;
    use crate::math::hash::mix2;
    use crate::math::{Rgb, UVec2};

    #[test]
    fn by_hand() {
        let mut a = Image::black(UVec2::new(2, 1));
        a.pixels = vec![Rgb::new(1.0, 2.0, 3.0), Rgb::new(1.0, 2.0, 1.0)];
        a.variance = Some(vec![Rgb::splat(0.01); 2]);
        let mut b = a.clone();
        b.pixels = vec![Rgb::new(1.0, 2.0, 4.0), Rgb::new(1.0, 2.0, 2.0)];
        let [a, b] = [&a, &b].map(|image| Estimate {
            image,
            freedom: 9.0,
            pool: None,
            samples: None,
            light_paths: None,
        });
        let m = Metrics::new(&a, &b, NoiseSource::Stored, 1, 0);
        assert_eq!(m.mse, 1.0 / 3.0);
        // A variance of 0.01 in each image; single precision of the inputs.
        assert!((m.expected_mse.unwrap() - 0.02).abs() < 1e-9);
        // (1/16 + 1/4) / 6, but for ε² = (0.01·2)².
        assert!((m.relative_mse - (1.0 / (16.0 + 4e-4) + 1.0 / (4.0 + 4e-4)) / 6.0).abs() < 1e-12);
        assert!((m.psnr - 10.0 * 48f64.log10()).abs() < 1e-12);
        assert_eq!(m.max_difference, 1.0);
        assert_eq!(m.channels[2].ratio, 2.0 / 3.0);
        // Variance of each mean 0.005, 36 degrees of freedom, whose quantile tables give: 2.028094 √(0.005 (1 + 4/9)) / 3.
        let error = m.channels[2].ratio_error.unwrap();
        assert!((error - 2.028094 * (0.005f64 * 13.0 / 9.0).sqrt() / 3.0).abs() < 1e-6);
        // (0.072169 · −1) in both pixels: there is only one tile.
        assert_eq!(m.largest_tile.bounds, a.image.bounds);
        assert!((m.largest_tile.a - m.largest_tile.b + 0.072169).abs() < 1e-6);
    }

    #[test]
    fn equal_images() {
        let image = Image::black(UVec2::new(3, 3));
        let e = Estimate {
            image: &image,
            freedom: 1.0,
            pool: None,
            samples: None,
            light_paths: None,
        };
        let m = Metrics::new(&e, &e, NoiseSource::SpatialWithoutBoth, 1, 0);
        assert_eq!((m.mse, m.relative_mse, m.expected_mse), (0.0, 0.0, None));
        assert_eq!(m.channels[0].ratio, 1.0);
    }

    /// Differences of ±0.1 about 0.1: the standard error of their mean is √(4·0.01 / (4·3)).
    #[test]
    fn without_variances_the_difference_tells() {
        let mut a = Image::black(UVec2::new(2, 2));
        let mut b = a.clone();
        b.pixels.fill(Rgb::ONE);
        a.pixels = [1.2, 1.0, 1.2, 1.0].map(Rgb::splat).to_vec();
        let [a, b] = [&a, &b].map(|image| Estimate {
            image,
            freedom: 1.0,
            pool: None,
            samples: None,
            light_paths: None,
        });
        let m = Metrics::new(&a, &b, NoiseSource::SpatialWithoutBoth, 1, 0);
        let error = m.channels[1].ratio_error.unwrap();
        // Student's quantile for three degrees of freedom, by tables; inputs in single precision.
        assert!((error - 3.182446 * (0.04f64 / 12.0).sqrt()).abs() < 1e-6);
        assert!((m.channels[1].ratio - 1.1).abs() < 1e-6);
    }

    /// Noise that a filter of 3 × 3 pixels has spread, in 2 × 2 cells of 24 pixels: the 95 % intervals of 1,200 ratios hold 1 as often
    /// as they should, but for the cells' edges (√0.96 of the true error, 94.2 to 94.8 %). By single pixels 48 % would, and 84 % by the
    /// normal quantile.
    #[test]
    fn intervals_of_filtered_noise_hold_what_they_say() {
        const SIDE: usize = 48;
        let uniform = |i: u64| (mix2(7, i) >> 11) as f32 / (1u64 << 53) as f32 - 0.5;
        let at = |x: usize, y: usize| y * (SIDE + 2) + x;
        let size = UVec2::splat(SIDE as u32);
        let mut b = Image::black(size);
        b.pixels.fill(Rgb::ONE);
        let (mut held, pairs) = (0, 400);
        for pair in 0..pairs {
            let first = pair * 3 * (SIDE as u64 + 2).pow(2);
            let noise: Vec<Rgb> = { (0..(SIDE as u64 + 2).pow(2)).map(|i| first + 3 * i) }
                .map(|i| Rgb::new(uniform(i), uniform(i + 1), uniform(i + 2)))
                .collect();
            let mut a = b.clone();
            for (pixel, value) in size_pixels(SIDE).zip(&mut a.pixels) {
                let near = size_pixels(3).map(|[i, j]| noise[at(pixel[0] + i, pixel[1] + j)]);
                *value += 0.1 * near.sum::<Rgb>();
            }
            let [a, b] = [&a, &b].map(|image| Estimate {
                image,
                freedom: f64::INFINITY,
                pool: None,
                samples: None,
                light_paths: None,
            });
            let m = Metrics::new(&a, &b, NoiseSource::Spatial, 24, 0);
            let holds = |c: &&ChannelMeans| (c.ratio - 1.0).abs() <= c.ratio_error.unwrap();
            held += m.channels.iter().filter(holds).count();
        }
        let share = held as f64 / (3 * pairs) as f64;
        // 4.75 standard deviations of a binomial share: one false alarm in 500,000, if the seed changes.
        assert!(
            (share - 0.945).abs() < 4.75 * (0.95f64 * 0.05 / 1200.0).sqrt(),
            "{share}"
        );
    }

    /// Columns and rows of a square.
    fn size_pixels(side: usize) -> impl Iterator<Item = [usize; 2]> {
        (0..side).flat_map(move |y| (0..side).map(move |x| [x, y]))
    }

    /// Excluded pixels do not dilute the metrics of the others.
    #[test]
    fn left_out_pixels_do_not_count() {
        let mut a = Image::black(UVec2::new(2, 2));
        let mut b = a.clone();
        a.pixels[0] = Rgb::splat(2.0);
        b.pixels[0] = Rgb::ONE;
        let [a, b] = [&a, &b].map(|image| Estimate {
            image,
            freedom: 1.0,
            pool: None,
            samples: None,
            light_paths: None,
        });
        let m = Metrics::new(&a, &b, NoiseSource::None, 1, 3);
        assert_eq!(
            (m.mse, m.channels[0].a, m.channels[0].ratio_error),
            (1.0, 2.0, None)
        );
    }
}
