//! An image as a statistical estimate.

use super::{Side, extent};
use crate::film::{Image, LightPathUse, LoadedImage, PixelBounds};
use crate::math::Rgb;

/// An image with its uncertainty.
#[derive(Clone, Copy, Debug)]
pub struct Estimate<'a> {
    /// Mean and, if known, variance of the mean of every pixel.
    pub image: &'a Image,
    /// Degrees of freedom of each variance: the number of observations it was estimated from, minus one.
    pub freedom: f64,
    /// If the variances of neighboring pixels share a factor: which, and how well it is known.
    pub pool: Option<Pool>,
    /// Samples per pixel in total, if known. If both images know theirs, they are compared with a common variance per
    /// sample (see [`Options`](super::Options) for the reason).
    pub samples: Option<f64>,
    /// How light paths are used, if known. Where two images differ in that, one of them may lack light that the other knows well.
    pub light_paths: Option<LightPathUse>,
}

/// Squares of pixels whose variances are those of the samples of each, times a factor that is found from all of them
/// (`render --variance` of well-distributed samples).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pool {
    /// Side of the squares in pixels, counted from the corner of the whole image.
    pub side: u32,
    /// Degrees of freedom that each pixel of a square brings: 1 for each pair of halves.
    pub freedom: f64,
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
    /// As many pixels, but from another part of the full image.
    #[error("the images differ in crop window: A holds {}, B {}", extent(*.0), extent(*.1))]
    Window(PixelBounds, PixelBounds),
    /// There is nothing to compare.
    #[error("the images have no pixels")]
    Empty,
    /// Stored variances were requested but are missing.
    #[error("{0} has no usable variances (channels var.R, var.G, var.B of two samples or more)")]
    NoVariance(Side),
}

impl<'a> Estimate<'a> {
    /// The estimate according to a file's metadata. A file that says its degrees of freedom has them. Otherwise one with the
    /// attribute `runs` above 1 has its variance estimated from the scatter of its runs, any other from its samples; if a
    /// file has neither count, its variances are taken as exact (infinitely many degrees of freedom).
    pub fn of(loaded: &'a LoadedImage) -> Estimate<'a> {
        let several = loaded.runs.filter(|&runs| runs > 1);
        let observations = several.or(loaded.spp);
        let counted = observations.map_or(f64::INFINITY, |n| f64::from(n) - 1.0);
        // Of the mean of several runs each has found the factors for itself.
        let runs = f64::from(loaded.runs.unwrap_or(1).max(1));
        let by_scatter = several.is_some() && loaded.freedom.is_none();
        let pool = loaded.pool.filter(|_| !by_scatter);
        let samples = loaded.spp.map(|spp| f64::from(spp) * runs);
        Estimate {
            image: &loaded.image,
            freedom: loaded.freedom.unwrap_or(counted),
            pool: pool.map(|side| Pool {
                side,
                freedom: runs,
            }),
            samples: samples.filter(|&n| n > 0.0),
            light_paths: loaded.light_paths,
        }
    }

    /// Returns `true` if the variance of pixels is known. It is not for a single sample.
    pub fn has_variance(&self) -> bool {
        let known = |v: &Rgb| v.is_finite() && v.cmpge(Rgb::ZERO).all();
        self.freedom >= 1.0 && self.image.variance.iter().flatten().any(known)
    }
}

/// Checks that both images hold the same pixels, and at least one.
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
