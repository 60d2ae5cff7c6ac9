//! Options of a comparison.

use super::{CompareError, Correction, Estimate, Side};

/// Settings of the statistical tests.
///
/// **Common variance.** Plain Welch's test fails on rare bright samples (fireflies): if an image of few samples has
/// none of them, its mean *and* its variance are too low, and the test is certain of a difference that is mere chance.
/// So if both images know their number of samples, the larger variance *per sample* of the two is used for both: an
/// image without fireflies cannot claim more certainty than the other's samples allow. For images sampled alike this is
/// Student's test with a slightly high variance; otherwise it errs toward "agree".
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Maximum probability that images with the same expectation are reported as different, for the whole comparison
    /// with all its tests.
    pub alpha: f64,
    /// Sides, in pixels, of the square blocks whose means are tested; 1 tests single pixels. The mean of the whole
    /// image is always tested too. Pixels reveal errors that are small and strong, large blocks those that are
    /// widespread and weak.
    pub blocks: Vec<u32>,
    /// Relative differences, to the brightest channel's value, up to this are ignored. The default, 1e-5, is ten times
    /// what pbrt-v3's single-precision sums and its conversion to XYZ and back, which mixes the channels, leave in a
    /// reference (1e-6); elsewhere noise hides anything this small.
    pub relative_tolerance: f64,
    /// How `alpha` is divided among the tests.
    pub correction: Correction,
    /// Source of the noise estimate.
    pub noise: Noise,
    /// Side in pixels of the squares that count as one observation when noise is estimated from the scatter of the
    /// difference: 1 for pixels that are independent of each other, about twice the width of the reconstruction filter
    /// where samples are splatted.
    pub cell: u32,
    /// Use the common variance described above if possible; otherwise always plain Welch's test.
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

/// The noise, as specified by the caller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Noise {
    /// Variances stored in the files; if one of them has none, the scatter of the difference.
    #[default]
    Auto,
    /// Variances stored in the files, or an error.
    Stored,
    /// The scatter of the difference between neighboring pixels.
    Spatial,
    /// No noise: every pixel must be equal within the tolerance. For images made from the same random samples, or from
    /// none.
    None,
}

/// The source of a verdict's noise estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseSource {
    /// Variances in both files.
    Stored,
    /// The scatter of the difference, as requested.
    Spatial,
    /// The scatter of the difference, because this image has no variances.
    SpatialWithout(Side),
    /// The scatter of the difference, because neither image has variances.
    SpatialWithoutBoth,
    /// No noise, as specified by the caller.
    None,
}

impl NoiseSource {
    /// Returns `true` if the noise is estimated from the scatter of the difference.
    pub fn is_spatial(self) -> bool {
        !matches!(self, NoiseSource::Stored | NoiseSource::None)
    }

    pub(super) fn of(
        a: &Estimate,
        b: &Estimate,
        options: &Options,
    ) -> Result<NoiseSource, CompareError> {
        match (options.noise, a.has_variance(), b.has_variance()) {
            (Noise::None, ..) => Ok(NoiseSource::None),
            (Noise::Spatial, ..) => Ok(NoiseSource::Spatial),
            (_, true, true) => Ok(NoiseSource::Stored),
            (Noise::Stored, false, _) => Err(CompareError::NoVariance(Side::A)),
            (Noise::Stored, true, false) => Err(CompareError::NoVariance(Side::B)),
            (Noise::Auto, false, true) => Ok(NoiseSource::SpatialWithout(Side::A)),
            (Noise::Auto, true, false) => Ok(NoiseSource::SpatialWithout(Side::B)),
            (Noise::Auto, false, false) => Ok(NoiseSource::SpatialWithoutBoth),
        }
    }
}
