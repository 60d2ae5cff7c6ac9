//! How to compare.

use super::{CompareError, Correction, Estimate, Side};

/// How to test.
///
/// **Common variance.** Welch's test proper fails on rare bright samples: where an image of few
/// samples has met none of them, its mean *and* its variance are too low, and the test is certain of a
/// difference that is mere luck. So where both images know their number of samples, the larger
/// variance *per sample* of the two is taken for both: an image that was spared cannot claim more
/// certainty than the other's samples allow. Between images that were sampled alike this is Student's
/// test with a slightly high variance; otherwise it errs towards "agree".
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// The probability, at most, that images of the same expectation are said to differ: of one
    /// whole comparison, all its tests together.
    pub alpha: f64,
    /// Sides, in pixels, of the square blocks whose means are tested; 1 tests single pixels. The mean
    /// of the whole image is always tested too. Pixels find what is small and wrong, large blocks
    /// what is everywhere and slight.
    pub blocks: Vec<u32>,
    /// Differences up to this fraction of the brightest channel's value do not count. The default,
    /// 1e-5, is ten times what pbrt-v3's single-precision sums and its way through XYZ and back,
    /// which mixes the channels, leave in a reference (1e-6); noise hides anything so small elsewhere.
    pub relative_tolerance: f64,
    /// How `alpha` is shared among the tests.
    pub correction: Correction,
    /// Where the noise is known from.
    pub noise: Noise,
    /// Side in pixels of the squares that count as one observation where the noise is estimated from
    /// the scatter of the difference: 1 for pixels that are independent of each other, the width of
    /// the reconstruction filter where samples are splatted.
    pub cell: u32,
    /// Take the common variance described above, where possible; otherwise Welch's test always.
    pub common_variance: bool,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            alpha: 1e-3,
            blocks: vec![1, 8, 32],
            relative_tolerance: 1e-5,
            correction: Correction::default(),
            noise: Noise::default(),
            cell: 1,
            common_variance: true,
        }
    }
}

/// What the caller says about the noise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Noise {
    /// Variances stored in the files; where one of them has none, the scatter of the difference.
    #[default]
    Auto,
    /// Variances stored in the files, or an error.
    Stored,
    /// The scatter of the difference between neighboring pixels.
    Spatial,
    /// There is none: every pixel must be equal but for the tolerance. For images made from the same
    /// random numbers, or from none.
    None,
}

/// Where a verdict's noise was known from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseSource {
    /// Variances in both files.
    Stored,
    /// The scatter of the difference, because the caller asked for it.
    Spatial,
    /// The scatter of the difference, because this image has no variances.
    SpatialWithout(Side),
    /// The same, because neither has.
    SpatialWithoutBoth,
    /// The caller said that there is none.
    None,
}

impl NoiseSource {
    /// Is the noise estimated from the scatter of the difference?
    pub fn is_spatial(self) -> bool {
        !matches!(self, NoiseSource::Stored | NoiseSource::None)
    }

    pub(super) fn of(
        a: &Estimate,
        b: &Estimate,
        options: &Options,
    ) -> Result<NoiseSource, CompareError> {
        Ok(match options.noise {
            Noise::None => NoiseSource::None,
            Noise::Spatial => NoiseSource::Spatial,
            Noise::Stored | Noise::Auto => match (a.has_variance(), b.has_variance()) {
                (true, true) => NoiseSource::Stored,
                (false, _) if options.noise == Noise::Stored => {
                    return Err(CompareError::NoVariance(Side::A));
                }
                (true, false) if options.noise == Noise::Stored => {
                    return Err(CompareError::NoVariance(Side::B));
                }
                (false, true) => NoiseSource::SpatialWithout(Side::A),
                (true, false) => NoiseSource::SpatialWithout(Side::B),
                (false, false) => NoiseSource::SpatialWithoutBoth,
            },
        })
    }
}
