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
    /// quantile where variances are stored. `None` if
    /// the noise is unknown.
    pub ratio_error: Option<f64>,
}

impl Metrics {
    /// The metrics of images that are black in the `left_out` pixels, which do not count.
    pub(super) fn new(a: &Estimate, b: &Estimate, noise: NoiseSource, left_out: usize) -> Metrics {
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
            channels: channel_means(a, b, noise, count),
            largest_tile: largest_tile(a, b),
        }
    }
}

/// Mean of the variances of the pixels.
fn mean_variance(estimate: &Estimate, count: f64) -> Option<DVec3> {
    let variance = estimate.image.variance.as_ref()?;
    Some(variance.iter().map(|p| p.as_dvec3()).sum::<DVec3>() / count)
}

fn channel_means(a: &Estimate, b: &Estimate, noise: NoiseSource, count: f64) -> [ChannelMeans; 3] {
    let mean = |e: &Estimate| e.image.pixels.iter().map(|p| p.as_dvec3()).sum::<DVec3>() / count;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let errors = errors_of_means(a, b, noise, count);
    let freedom = freedom_of_means(a, b, noise);
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
                cell: 1,
            };
            Some([scatter.error_of_mean(), DVec3::ZERO])
        }
    }
}

/// Degrees of freedom of the errors of both means together.
fn freedom_of_means(a: &Estimate, b: &Estimate, noise: NoiseSource) -> [f64; 3] {
    if noise != NoiseSource::Stored {
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
        let m = Metrics::new(&a, &b, NoiseSource::Stored, 0);
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
        let m = Metrics::new(&e, &e, NoiseSource::SpatialWithoutBoth, 0);
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
        let m = Metrics::new(&a, &b, NoiseSource::SpatialWithoutBoth, 0);
        let error = m.channels[1].ratio_error.unwrap();
        // Inputs in single precision.
        assert!((error - 1.959964 * (0.04f64 / 12.0).sqrt()).abs() < 1e-6);
        assert!((m.channels[1].ratio - 1.1).abs() < 1e-6);
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
        let m = Metrics::new(&a, &b, NoiseSource::None, 3);
        assert_eq!(
            (m.mse, m.channels[0].a, m.channels[0].ratio_error),
            (1.0, 2.0, None)
        );
    }
}
