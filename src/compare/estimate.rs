//! An image as the statistician sees it.

use super::Side;
use crate::film::{Image, LoadedImage, PixelBounds};

/// An image with how sure it is of itself.
#[derive(Clone, Copy, Debug)]
pub struct Estimate<'a> {
    /// Mean and, where known, variance of that mean of every pixel.
    pub image: &'a Image,
    /// Degrees of freedom of each variance: observations it was estimated from, less one.
    pub freedom: f64,
    /// Samples per pixel altogether, where known. Two images that both know theirs are compared
    /// with a common variance per sample ([`Options`](super::Options) says why).
    pub samples: Option<f64>,
}

/// Why two images cannot be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompareError {
    /// They do not cover the same pixels.
    #[error(
        "the images differ in size: A is {} × {} pixels, B {} × {}",
        .0.size().x, .0.size().y, .1.size().x, .1.size().y
    )]
    Size(PixelBounds, PixelBounds),
    /// As many pixels, but of another part of the full image.
    #[error("the images differ in crop window: A holds {}, B {}", show(.0), show(.1))]
    Window(PixelBounds, PixelBounds),
    /// There is nothing to compare.
    #[error("the images have no pixels")]
    Empty,
    /// Stored variances were asked for.
    #[error("{0} has no usable variances (channels var.R, var.G, var.B of two samples or more)")]
    NoVariance(Side),
}

fn show(bounds: &PixelBounds) -> String {
    format!(
        "x {}..{} y {}..{}",
        bounds.min.x, bounds.max.x, bounds.min.y, bounds.max.y
    )
}

impl<'a> Estimate<'a> {
    /// What a file says of itself. A file with the attribute `runs` above 1 estimated its variance
    /// from the scatter of its runs, any other from its samples; a file that counts neither is taken
    /// at its word (infinitely many degrees of freedom).
    pub fn of(loaded: &'a LoadedImage) -> Estimate<'a> {
        let observations = loaded.runs.filter(|&runs| runs > 1).or(loaded.spp);
        let freedom = observations.map_or(f64::INFINITY, |n| f64::from(n) - 1.0);
        let samples = loaded
            .spp
            .map(|spp| f64::from(spp) * f64::from(loaded.runs.unwrap_or(1)));
        Estimate {
            image: &loaded.image,
            freedom,
            samples: samples.filter(|&n| n > 0.0),
        }
    }

    /// Does it know how far its pixels scatter? A single sample does not.
    pub fn has_variance(&self) -> bool {
        let known = |variance: &Vec<_>| {
            variance
                .iter()
                .any(|v: &crate::math::Rgb| v.is_finite() && v.cmpge(crate::math::Rgb::ZERO).all())
        };
        self.freedom >= 1.0 && self.image.variance.as_ref().is_some_and(known)
    }
}

/// Both images must hold the same pixels, and at least one.
pub(super) fn check_pair(a: &Estimate, b: &Estimate) -> Result<(), CompareError> {
    let (x, y) = (a.image.bounds, b.image.bounds);
    if x.size() != y.size() || a.image.pixels.len() != b.image.pixels.len() {
        return Err(CompareError::Size(x, y));
    }
    if x != y {
        return Err(CompareError::Window(x, y));
    }
    if a.image.pixels.is_empty() {
        return Err(CompareError::Empty);
    }
    Ok(())
}
