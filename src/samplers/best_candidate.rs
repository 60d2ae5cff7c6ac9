//! pbrt-v2's `bestcandidate`, Poisson-disk points, served by the points of [`super::sobol`].
//!
//! `pixelsamples` (integer, 4).

use super::SamplerSpec;
use super::count::positive;
use crate::params::ParamReader;

/// Reads the parameters.
pub(super) fn from_params(reader: &ParamReader) -> SamplerSpec {
    SamplerSpec {
        note: Some(
            "sampler \"bestcandidate\" is rendered with Owen-scrambled low-discrepancy points (same image, other noise)",
        ),
        ..SamplerSpec::sobol(positive(reader, "pixelsamples", 4))
    }
}
