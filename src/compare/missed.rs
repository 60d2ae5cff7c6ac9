//! Light that one of two images may have missed in all its samples.
//!
//! Where paths from the lights bring light to one image and not to the other, what the first knows well may come to the second by rare bright
//! samples. A block that they have not met has neither their light nor their variance, and the larger variance per sample of both
//! images is that of better samples. What is known is how bright samples are where the image has met them. If light comes in
//! such portions, their number is Poisson's, whose variance is its mean: the variance of a mean that lacks δ is δ times the portion.

use super::Estimate;
use crate::film::LightPathUse;
use crate::math::DVec3;

/// The largest portions of light of both images.
#[derive(Clone, Copy, Debug)]
pub(super) struct Missed {
    /// What light paths do in each.
    pub light_paths: [LightPathUse; 2],
    /// The variance of a pixel's mean for each unit of light that it lacks, by channel.
    portions: [DVec3; 2],
}

impl Missed {
    /// `None` of images in which light paths do the same, or that do not say.
    pub(super) fn of(a: &Estimate, b: &Estimate) -> Option<Missed> {
        let (of_a, of_b) = a.light_paths.zip(b.light_paths)?;
        (of_a != of_b).then(|| Missed {
            light_paths: [of_a, of_b],
            portions: [a, b].map(largest_portion),
        })
    }

    /// The variance of the mean over so many pixels of the image that is darker, for each unit of light that it lacks.
    pub(super) fn portion(&self, means: [f64; 2], channel: usize, pixels: usize) -> f64 {
        let darker = if means[0] < means[1] { 0 } else { 1 };
        self.portions[darker][channel] / pixels.max(1) as f64
    }
}

/// The largest index of dispersion (variance over mean; Fano factor) of all pixels: u/n if one of n samples has brought u, and all of the
/// light. Of a light that all samples see it is near 0, and at its edge it is no more than the light itself: then a
/// pixel has its light from one sample at least.
fn largest_portion(estimate: &Estimate) -> DVec3 {
    let image = estimate.image;
    let variances = image.independent.as_ref().or(image.variance.as_ref());
    let pixels = { image.pixels.iter() }.zip(variances.into_iter().flatten());
    let portions = pixels.map(|(mean, variance)| {
        let (mean, variance) = (mean.as_dvec3(), variance.as_dvec3());
        DVec3::select(
            mean.cmpgt(DVec3::ZERO),
            (variance / mean).min(mean),
            DVec3::ZERO,
        )
    });
    portions.fold(DVec3::ZERO, DVec3::max)
}
