//! Light that one of two images may have missed in all its samples.
//!
//! Where paths from the lights bring light to one image and not to the other, what the first knows well may come to the second by rare bright
//! samples. A block that they have not met has neither their light nor their variance, and the larger variance per sample of both
//! images is that of better samples. What is known is how bright samples are where the image has met them. If light comes in
//! such portions, their number is Poisson's, whose variance is its mean: the variance of a mean that lacks δ is δ times the portion.

use super::Estimate;
use crate::film::LightPathUse;
use crate::math::DVec3;

/// Light paths have changed a pixel's noise where the variance per sample of one image is more than this times that of the other. The
/// variance of 16 normal samples is 2.5 times too large once in a thousand (chi-squared, 15 degrees of freedom).
const MIN_CHANGE: f64 = 4.0;

/// The largest portions of light of both images.
#[derive(Clone, Copy, Debug)]
pub(super) struct Missed {
    /// How each uses light paths.
    pub light_paths: [LightPathUse; 2],
    /// The variance of a pixel's mean for each unit of light that it lacks, by channel.
    portions: [DVec3; 2],
}

impl Missed {
    /// `None` of images in which light paths do the same, or that do not say, or that do not know their number of samples.
    pub(super) fn of(a: &Estimate, b: &Estimate) -> Option<Missed> {
        let (of_a, of_b) = a.light_paths.zip(b.light_paths)?;
        let samples = a.samples.zip(b.samples).filter(|_| of_a != of_b)?;
        Some(Missed {
            light_paths: [of_a, of_b],
            portions: [
                largest_portion(a, b, samples.1 / samples.0),
                largest_portion(b, a, samples.0 / samples.1),
            ],
        })
    }

    /// The variance of the mean over so many pixels of the image that is darker, for each unit of light that it lacks.
    pub(super) fn of_darker(&self, means: [f64; 2], channel: usize, pixels: usize) -> f64 {
        let darker = if means[0] < means[1] { 0 } else { 1 };
        self.portions[darker][channel] / pixels as f64
    }

    /// The same, the larger of both images', whichever is darker.
    pub(super) fn of_either(&self, channel: usize, pixels: usize) -> f64 {
        self.portions[0].max(self.portions[1])[channel] / pixels as f64
    }
}

/// The largest standard error of a pixel whose noise the other image, which has `more` times the samples, does not have: u/n if
/// one of n samples has brought u, whatever else is there. No more than the mean, as at least one sample has brought that: a variance that
/// is partly its neighbors' may be larger.
fn largest_portion(image: &Estimate, other: &Estimate, more: f64) -> DVec3 {
    let [own, others] = [image, other].map(|estimate| {
        let image = estimate.image;
        let variances = image.independent.as_ref().or(image.variance.as_ref());
        variances.into_iter().flatten()
    });
    let pixels = image.image.pixels.iter().zip(own.zip(others));
    let portions = pixels.map(|(mean, (own, other))| {
        let (mean, own, other) = (mean.as_dvec3(), own.as_dvec3(), other.as_dvec3());
        let is_changed = own.cmpgt(MIN_CHANGE * more * other) & own.cmplt(DVec3::INFINITY);
        let portion = own.map(f64::sqrt).min(mean).max(DVec3::ZERO);
        DVec3::select(is_changed, portion, DVec3::ZERO)
    });
    portions.fold(DVec3::ZERO, DVec3::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Image;
    use crate::math::{Rgb, UVec2};

    /// A spike of one sample on a lit floor counts with its own light. The edge of a lamp, as noisy by the sample in both images, does not; nor do
    /// variances that are not known.
    #[test]
    fn portions_are_those_that_light_paths_have_changed() {
        let image = |variances: [f32; 4]| {
            let mut image = Image::black(UVec2::new(4, 1));
            image.pixels = [1.5, 50.0, 1.0, 1.0].map(Rgb::splat).to_vec();
            image.variance = Some(variances.map(Rgb::splat).to_vec());
            image
        };
        let few = image([0.25, 400.0, f32::INFINITY, 0.01]);
        let many = image([1e-4, 25.0, 1e-4, 1e-4]);
        let using = |image, samples, per_sample| Estimate {
            image,
            freedom: 15.0,
            pool: None,
            samples: Some(samples),
            light_paths: Some(LightPathUse {
                per_sample,
                joined: 0.0,
            }),
        };
        let (a, b) = (using(&few, 16.0, 0.0), using(&many, 256.0, 0.5));
        let missed = Missed::of(&a, &b).expect("other light paths");
        // The root of 0.25, over four pixels.
        assert_eq!(missed.of_darker([0.1, 0.2], 1, 4), 0.125);
        assert_eq!(missed.of_darker([0.2, 0.1], 1, 4), 0.0);
        assert_eq!(missed.of_either(1, 4), 0.125);
        assert!(Missed::of(&a, &using(&many, 256.0, 0.0)).is_none());
    }
}
