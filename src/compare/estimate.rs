//! A picture as the statistician sees it.

use crate::film::{Image, Loaded, PixelBounds};

/// A picture with how sure it is of itself.
#[derive(Clone, Copy, Debug)]
pub struct Estimate<'a> {
    /// Mean and, for tests, variance of that mean of every pixel.
    pub image: &'a Image,
    /// Degrees of freedom of each variance: observations it was estimated from, less one.
    pub freedom: f64,
    /// Samples per pixel altogether, where known. Two pictures that both know theirs are compared
    /// with a common variance per sample ([`welch`](super::welch())).
    pub samples: Option<f64>,
}

/// Why two pictures cannot be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompareError {
    /// They do not cover the same pixels.
    #[error("the pictures differ in size or crop window: {} and {}", show(.0), show(.1))]
    Bounds(PixelBounds, PixelBounds),
    /// There is nothing to compare.
    #[error("the pictures have no pixels")]
    Empty,
}

fn show(bounds: &PixelBounds) -> String {
    format!(
        "x {}..{} y {}..{}",
        bounds.min.x, bounds.max.x, bounds.min.y, bounds.max.y
    )
}

impl<'a> Estimate<'a> {
    /// What a file says of itself. A file with the attribute `runs` estimated its variance from the
    /// scatter of its runs, any other from its samples; a file that counts neither is taken at its
    /// word (infinitely many degrees of freedom).
    pub fn of(loaded: &'a Loaded) -> Estimate<'a> {
        let observations = loaded.runs.or(loaded.spp);
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
}

/// Both pictures must hold the same pixels, and at least one.
pub(super) fn check_pair(a: &Estimate, b: &Estimate) -> Result<(), CompareError> {
    if a.image.bounds != b.image.bounds || a.image.pixels.len() != b.image.pixels.len() {
        return Err(CompareError::Bounds(a.image.bounds, b.image.bounds));
    }
    if a.image.pixels.is_empty() {
        return Err(CompareError::Empty);
    }
    Ok(())
}
