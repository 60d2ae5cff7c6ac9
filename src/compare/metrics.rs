//! Differences of two pictures as plain numbers.

use super::Estimate;
use glam::DVec3;

/// How far a picture is from its reference. All over pixels and channels alike, in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metrics {
    /// Mean squared error.
    pub mse: f64,
    /// The mean squared error that noise alone would make: the mean of both variances. `None` where a
    /// picture has no variances. `mse` minus this estimates the squared bias.
    pub expected_mse: Option<f64>,
    /// Mean of (a − b)² / (b² + ε²), ε being 1 % of the reference's mean (dark pixels would otherwise
    /// decide alone).
    pub relative_mse: f64,
    /// Peak signal-to-noise ratio in dB, the peak being the reference's largest value; infinite for
    /// equal pictures.
    pub psnr: f64,
    /// Largest |a − b|.
    pub max_difference: f64,
    /// The means of red, green and blue.
    pub channels: [ChannelMeans; 3],
}

/// The means of one channel over the whole picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelMeans {
    /// Of the picture.
    pub a: f64,
    /// Of the reference.
    pub b: f64,
    /// a / b; 1 where both are 0.
    pub ratio: f64,
    /// Half the width of the ratio's 95 % confidence interval, to first order in the noise (delta
    /// method). `None` where a picture has no variances.
    pub ratio_error: Option<f64>,
}

impl Metrics {
    pub(super) fn new(a: &Estimate, b: &Estimate) -> Metrics {
        let count = a.image.pixels.len() as f64;
        let pairs = || {
            a.image
                .pixels
                .iter()
                .zip(&b.image.pixels)
                .map(|(p, q)| (p.as_dvec3(), q.as_dvec3()))
        };
        let per_value = |sum: DVec3| sum.element_sum() / (3.0 * count);
        let mean_b = per_value(pairs().map(|(_, q)| q).sum());
        let floor = DVec3::splat((0.01 * mean_b).powi(2).max(f64::MIN_POSITIVE));
        let mse = per_value(pairs().map(|(p, q)| (p - q) * (p - q)).sum());
        let relative = pairs()
            .map(|(p, q)| (p - q) * (p - q) / (q * q + floor))
            .sum();
        let peak = pairs().fold(0.0f64, |peak, (_, q)| peak.max(q.max_element()));
        Metrics {
            mse,
            expected_mse: mean_variance(a)
                .zip(mean_variance(b))
                .map(|(u, v)| (u + v).element_sum() / 3.0),
            relative_mse: per_value(relative),
            psnr: if mse == 0.0 {
                f64::INFINITY
            } else {
                10.0 * (peak * peak / mse).log10()
            },
            max_difference: pairs().fold(0.0, |most, (p, q)| (p - q).abs().max_element().max(most)),
            channels: channel_means(a, b),
        }
    }
}

/// Mean over the pixels of their variances.
fn mean_variance(estimate: &Estimate) -> Option<DVec3> {
    let variance = estimate.image.variance.as_ref()?;
    Some(variance.iter().map(|v| v.as_dvec3()).sum::<DVec3>() / variance.len() as f64)
}

fn channel_means(a: &Estimate, b: &Estimate) -> [ChannelMeans; 3] {
    let count = a.image.pixels.len() as f64;
    let mean = |e: &Estimate| e.image.pixels.iter().map(|p| p.as_dvec3()).sum::<DVec3>() / count;
    let (mean_a, mean_b) = (mean(a), mean(b));
    // Pixels are independent: the variance of their mean is the mean variance over their number.
    let variances = mean_variance(a)
        .zip(mean_variance(b))
        .map(|(u, v)| (u / count, v / count));
    [0, 1, 2].map(|i| {
        let (a, b) = (mean_a[i], mean_b[i]);
        let ratio = if a == b { 1.0 } else { a / b };
        // 1.96: 97.5 % of the normal distribution.
        let ratio_error =
            variances.map(|(u, v)| 1.96 * (u[i] + ratio * ratio * v[i]).sqrt() / b.abs());
        ChannelMeans {
            a,
            b,
            ratio,
            ratio_error: ratio_error.map(|e| if e.is_nan() { 0.0 } else { e }),
        }
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
            samples: None,
        });
        let m = Metrics::new(&a, &b);
        assert_eq!(m.mse, 1.0 / 3.0);
        // Two images' variance 0.01 each; single precision of the inputs.
        assert!((m.expected_mse.unwrap() - 0.02).abs() < 1e-9);
        // (1/16 + 1/4) / 6, but for ε² = (0.01·2)².
        assert!((m.relative_mse - (1.0 / (16.0 + 4e-4) + 1.0 / (4.0 + 4e-4)) / 6.0).abs() < 1e-12);
        assert!((m.psnr - 10.0 * 48f64.log10()).abs() < 1e-12);
        assert_eq!(m.max_difference, 1.0);
        assert_eq!(m.channels[2].ratio, 2.0 / 3.0);
        // Variance of each mean 0.005: 1.96 √(0.005 (1 + 4/9)) / 3.
        let error = m.channels[2].ratio_error.unwrap();
        assert!((error - 1.96 * (0.005f64 * 13.0 / 9.0).sqrt() / 3.0).abs() < 1e-6);
    }

    #[test]
    fn equal_pictures() {
        let image = Image::black(UVec2::new(3, 3));
        let e = Estimate {
            image: &image,
            freedom: 1.0,
            samples: None,
        };
        let m = Metrics::new(&e, &e);
        assert_eq!((m.mse, m.relative_mse, m.expected_mse), (0.0, 0.0, None));
        assert_eq!(m.channels[0].ratio, 1.0);
    }
}
