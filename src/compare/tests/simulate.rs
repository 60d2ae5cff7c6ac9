//! Simulated renders: pixels drawn from distributions whose expectation is known.

use super::super::Estimate;
use crate::film::{Image, PixelStatistics};
use crate::math::hash::mix2;
use crate::math::{Rgb, UVec2};

/// Uniform samples in (0, 1), one stream per seed.
pub(super) struct Random {
    seed: u64,
    drawn: u64,
}

impl Random {
    pub(super) fn uniform(&mut self) -> f64 {
        self.drawn += 1;
        ((mix2(self.seed, self.drawn) >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    /// A normal sample, by the Box–Muller transform.
    pub(super) fn normal(&mut self) -> f64 {
        let r = (-2.0 * self.uniform().ln()).sqrt();
        r * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// A render with the metadata of its file.
pub(super) struct Render {
    pub image: Image,
    groups: u32,
    samples: u32,
}

impl Render {
    /// `samples` per pixel, their variance estimated from the scatter of `groups` equal groups of samples (`groups =
    /// samples`: from the samples themselves).
    pub(super) fn new(
        seed: u64,
        side: u32,
        samples: u32,
        groups: u32,
        draw: impl Fn(UVec2, &mut Random) -> Rgb,
    ) -> Render {
        let mut random = Random { seed, drawn: 0 };
        let mut image = Image::black(UVec2::splat(side));
        let mut variance = Vec::new();
        let per_group = samples / groups;
        for (i, pixel) in image.bounds.pixels().enumerate() {
            let group = |_| {
                let sum: Rgb = (0..per_group).map(|_| draw(pixel, &mut random)).sum();
                sum / per_group as f32
            };
            let statistics = PixelStatistics::of((0..groups).map(group));
            image.pixels[i] = statistics.mean().as_vec3();
            variance.push(statistics.variance_of_mean().as_vec3());
        }
        image.variance = Some(variance);
        Render {
            image,
            groups,
            samples,
        }
    }

    pub(super) fn estimate(&self) -> Estimate<'_> {
        Estimate {
            image: &self.image,
            freedom: f64::from(self.groups - 1),
            pool: None,
            samples: Some(f64::from(self.samples)),
            light_paths: None,
        }
    }

    /// The same image as from a program that writes no variances.
    pub(super) fn without_variance(mut self) -> Render {
        self.image.variance = None;
        self
    }
}

/// Noise of 30 % per sample around a gray gradient, independent for each channel.
pub(super) fn mild(pixel: UVec2, random: &mut Random) -> Rgb {
    let mean = 0.2 + 0.01 * (pixel.x + pixel.y) as f32;
    Rgb::from([(); 3].map(|()| mean * (1.0 + 0.3 * random.normal() as f32)))
}

/// Samples as from a path tracer: log-normal light (skewness 6), and one sample in 250 that hits a light 100 times
/// brighter, in all channels at once. Kurtosis of a sample: 240.
pub(super) fn fireflies(_: UVec2, random: &mut Random) -> Rgb {
    let light = random.normal().exp();
    let emitter = if random.uniform() < 0.004 { 100.0 } else { 0.0 };
    Rgb::new(0.3, 0.2, 0.1) * (light + emitter) as f32
}

/// Log-normal light alone.
pub(super) fn skewed(_: UVec2, random: &mut Random) -> Rgb {
    Rgb::new(0.3, 0.2, 0.1) * random.normal().exp() as f32
}
