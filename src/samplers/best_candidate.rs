//! pbrt-v2's `bestcandidate`, Poisson-disk points, served by Sobol' points.
//!
//! `pixelsamples` (integer, 4).

use super::SamplerSpec;
use super::count::positive;
use crate::params::ParamReader;

/// Reads the parameters.
pub(super) fn from_params(reader: &ParamReader) -> SamplerSpec {
    SamplerSpec {
        note: Some(
            "sampler \"bestcandidate\" is rendered with Owen-scrambled Sobol' points (same picture, other noise)",
        ),
        ..SamplerSpec::sobol(positive(reader, "pixelsamples", 4))
    }
}
