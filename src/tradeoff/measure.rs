//! Error, bias and cost of one setting, from its images.

use crate::film::Image;
use glam::DVec3;

/// An estimate with half the width of its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Half the width of the interval.
    pub within: f64,
}

impl Estimate {
    /// The mean of independent values, by Student's t; the interval is infinite for fewer than two.
    pub fn of_mean(values: &[f64]) -> Estimate {
        let n = values.len() as f64;
        let value = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|v| (v - value).powi(2)).sum();
        let within = match values.len() {
            0 | 1 => f64::INFINITY,
            count => student_97_5(count - 1) * (squares / (n * (n - 1.0))).sqrt(),
        };
        Estimate { value, within }
    }

    /// The jackknife estimate (Quenouille 1949, Tukey 1958): `statistic` of all values but one, each in turn.
    pub fn jackknife(count: usize, statistic: impl Fn(&dyn Fn(usize) -> bool) -> f64) -> Estimate {
        let value = statistic(&|_| true);
        let without: Vec<f64> = (0..count).map(|i| statistic(&|j| j != i)).collect();
        let n = count as f64;
        let mean = without.iter().sum::<f64>() / n;
        let squares: f64 = without.iter().map(|v| (v - mean).powi(2)).sum();
        let within = match count {
            0..3 => f64::INFINITY,
            _ => student_97_5(count - 1) * (squares * (n - 1.0) / n).sqrt(),
        };
        Estimate { value, within }
    }

    /// Returns `true` if `value` is outside the interval.
    pub fn excludes(&self, value: f64) -> bool {
        (self.value - value).abs() > self.within
    }
}

/// The 97.5 % quantile of Student's t.
fn student_97_5(freedom: usize) -> f64 {
    // Abramowitz and Stegun, table 26.10; beyond it their expansion 26.7.5 to the second order, good to 1e-4.
    const TABLE: [f64; 10] = [
        12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
    ];
    const X: f64 = 1.959_964;
    let n = freedom as f64;
    match freedom {
        0 => f64::INFINITY,
        1..=10 => TABLE[freedom - 1],
        _ => {
            let first = (X.powi(3) + X) / 4.0;
            let second = (5.0 * X.powi(5) + 16.0 * X.powi(3) + 3.0 * X) / 96.0;
            X + first / n + second / (n * n)
        }
    }
}

/// The reference image.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The image.
    pub image: Image,
    /// Its own relative error, squared.
    pub squared_error: f64,
    /// ε², which keeps dark pixels from dominating: 1 % of the image's mean, squared.
    floor: f64,
}

impl Reference {
    /// An image with its estimated relative error (`render::Progressive::error`).
    pub fn new(image: Image, error: f64) -> Reference {
        let count = 3.0 * image.pixels.len().max(1) as f64;
        let sum: f64 = image
            .pixels
            .iter()
            .map(|p| p.as_dvec3().element_sum())
            .sum();
        Reference {
            floor: (0.01 * sum / count).powi(2).max(f64::MIN_POSITIVE),
            squared_error: error * error,
            image,
        }
    }

    /// Mean over pixels and channels of `difference`² / (reference² + ε²).
    fn relative(&self, difference: impl Fn(usize) -> DVec3) -> f64 {
        let pixels = self.image.pixels.iter().enumerate();
        let one = |(i, r): (usize, &crate::math::Rgb)| {
            let (d, r) = (difference(i), r.as_dvec3());
            (d * d / (r * r + DVec3::splat(self.floor))).element_sum()
        };
        pixels.map(one).sum::<f64>() / (3.0 * self.image.pixels.len().max(1) as f64)
    }
}

/// The results of one setting; all errors are relative to the reference.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// Samples per pixel.
    pub spp: u32,
    /// Mean squared error of one image, minus the reference's own.
    pub squared_error: Estimate,
    /// The part of it that varies from seed to seed.
    pub variance: Estimate,
    /// The rest: non-negative except for noise.
    pub squared_bias: Estimate,
    /// Seconds of CPU time for one image ([`super::clock::processor_time`]).
    pub seconds: Estimate,
    /// 1 / (mean squared error · seconds), where only a significant bias counts: without one it is the same for any
    /// number of samples, and with one it does not promise what more samples cannot achieve.
    pub efficiency: Estimate,
}

impl Measurement {
    /// The measurement from `images` of one setting with different seeds, at least 3, and the seconds each took.
    pub fn new(reference: &Reference, spp: u32, images: &[Image], seconds: &[f64]) -> Measurement {
        let count = images.len();
        let errors: Vec<f64> = images
            .iter()
            .map(|image| {
                let difference =
                    |i: usize| image.pixels[i].as_dvec3() - reference.image.pixels[i].as_dvec3();
                reference.relative(difference) - reference.squared_error
            })
            .collect();
        // Σ over images of the squared distance from their mean, for any subset of them.
        let variance = |kept: &dyn Fn(usize) -> bool| {
            let kept: Vec<&Image> = (0..count)
                .filter(|&i| kept(i))
                .map(|i| &images[i])
                .collect();
            let n = kept.len() as f64;
            let mean = |i: usize| kept.iter().map(|m| m.pixels[i].as_dvec3()).sum::<DVec3>() / n;
            let means: Vec<DVec3> = (0..reference.image.pixels.len()).map(mean).collect();
            let of = |m: &Image| reference.relative(|i| m.pixels[i].as_dvec3() - means[i]);
            kept.iter().map(|m| of(m)).sum::<f64>() / (n - 1.0)
        };
        let mean_of = |values: &[f64], kept: &dyn Fn(usize) -> bool| {
            let kept: Vec<f64> = (0..count).filter(|&i| kept(i)).map(|i| values[i]).collect();
            kept.iter().sum::<f64>() / kept.len() as f64
        };
        let squared_bias =
            Estimate::jackknife(count, |kept| mean_of(&errors, kept) - variance(kept));
        let certain_bias = if squared_bias.excludes(0.0) {
            squared_bias.value.max(0.0)
        } else {
            0.0
        };
        Measurement {
            spp,
            squared_error: Estimate::of_mean(&errors),
            variance: Estimate::jackknife(count, variance),
            squared_bias,
            seconds: Estimate::of_mean(seconds),
            efficiency: Estimate::jackknife(count, |kept| {
                1.0 / ((variance(kept) + certain_bias) * mean_of(seconds, kept))
            }),
        }
    }

    /// The relative error, as a fraction.
    pub fn error(&self) -> Estimate {
        root(&self.squared_error)
    }

    /// The relative bias, as a fraction; 0 if it is not significant.
    pub fn bias(&self) -> Estimate {
        root(&self.squared_bias)
    }
}

/// The square root, to first order in its uncertainty; for values not significantly positive, the root of the upper
/// bound.
fn root(square: &Estimate) -> Estimate {
    let value = square.value.max(0.0).sqrt();
    let most = (square.value + square.within).max(0.0).sqrt();
    Estimate {
        value,
        within: most - value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rgb, UVec2};

    fn image(values: impl Fn(usize) -> f32) -> Image {
        let mut image = Image::black(UVec2::new(40, 40));
        for (i, pixel) in image.pixels.iter_mut().enumerate() {
            *pixel = Rgb::splat(values(i));
        }
        image
    }

    /// Noise of variance 1/12 · width².
    fn noise(seed: u64, i: usize, width: f32) -> f32 {
        let bits = crate::math::hash::mix2(seed, i as u64);
        width * (crate::math::hash::unit_float(bits) - 0.5)
    }

    #[test]
    fn bias_and_variance_are_told_apart() {
        let reference = Reference::new(image(|_| 1.0), 0.0);
        let images: Vec<Image> = (0..5)
            .map(|seed| image(|i| 1.02 + noise(seed, i, 0.1)))
            .collect();
        let measured = Measurement::new(&reference, 4, &images, &[1.0, 1.1, 0.9, 1.0, 1.0]);
        // 1600 pixels of uniform noise, five times: the variance is known to 2 %, times t for 4 degrees of freedom.
        let variance = 0.01 / 12.0;
        assert!((measured.variance.value / variance - 1.0).abs() < 0.06);
        assert!((measured.squared_bias.value / 0.0004 - 1.0).abs() < 0.15);
        assert!(!measured.squared_bias.excludes(0.0004) && measured.squared_bias.excludes(0.0));
        assert!((measured.error().value.powi(2) / (variance + 0.0004) - 1.0).abs() < 0.06);
        assert!((measured.efficiency.value * (variance + 0.0004) - 1.0).abs() < 0.1);
    }

    #[test]
    fn a_biased_setting_is_not_efficient() {
        let reference = Reference::new(image(|_| 1.0), 0.0);
        // Three times brighter and noiseless, in a tenth of the time.
        let images = |offset: f32, width: f32| -> Vec<Image> {
            let one = |seed| image(|i| offset + noise(seed, i, width));
            (0..5).map(one).collect()
        };
        let fair = Measurement::new(&reference, 4, &images(1.0, 0.1), &[1.0; 5]);
        let biased = Measurement::new(&reference, 4, &images(3.0, 0.01), &[0.1; 5]);
        assert!(biased.efficiency.value < 0.01 * fair.efficiency.value);
        // Without a bias only the variance counts.
        assert!((fair.efficiency.value * 0.01 / 12.0 - 1.0).abs() < 0.1);
    }

    #[test]
    fn the_references_own_noise_is_taken_off() {
        let noisy = image(|i| 1.0 + noise(99, i, 0.1));
        let reference = Reference::new(noisy, (0.01f64 / 12.0).sqrt());
        let images: Vec<Image> = (0..4)
            .map(|seed| image(|i| 1.0 + noise(seed, i, 0.1)))
            .collect();
        let measured = Measurement::new(&reference, 4, &images, &[1.0; 4]);
        assert!((measured.squared_error.value / (0.01 / 12.0) - 1.0).abs() < 0.1);
        assert!(measured.squared_bias.value.abs() < 0.1 * 0.01 / 12.0);
        assert_eq!(measured.seconds.within, 0.0);
    }

    #[test]
    fn intervals() {
        let e = Estimate::of_mean(&[1.0, 3.0]);
        // s/√n = 1.
        assert_eq!((e.value, e.within), (2.0, 12.706));
        assert!(Estimate::of_mean(&[1.0]).within.is_infinite());
        // The jackknife of a mean is its usual error.
        let values = [1.0, 2.0, 4.0, 8.0];
        let mean = |kept: &dyn Fn(usize) -> bool| {
            let kept: Vec<f64> = (0..4).filter(|&i| kept(i)).map(|i| values[i]).collect();
            kept.iter().sum::<f64>() / kept.len() as f64
        };
        let (a, b) = (Estimate::jackknife(4, mean), Estimate::of_mean(&values));
        assert!((a.value - b.value).abs() < 1e-12 && (a.within - b.within).abs() < 1e-12);
        for (freedom, quantile) in [(20, 2.086), (60, 2.000), (1000, 1.962)] {
            assert!((student_97_5(freedom) - quantile).abs() < 2e-3);
        }
    }
}
