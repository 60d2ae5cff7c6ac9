//! `maxmindist`, points with a large minimum distance, served by the points of [`super::sobol`].
//!
//! `pixelsamples` (integer, 16), rounded up to a power of two as pbrt does. `dimensions`
//! (integer, 4): accepted; all dimensions are well distributed.

use super::SamplerSpec;
use super::count::power_of_two;
use crate::params::ParamReader;

/// Reads the parameters.
pub(super) fn from_params(reader: &ParamReader) -> SamplerSpec {
    reader.find_integer("dimensions");
    SamplerSpec {
        note: Some(
            "sampler \"maxmindist\" is rendered with Owen-scrambled low-discrepancy points (same image, other noise)",
        ),
        ..SamplerSpec::sobol(power_of_two(reader, "pixelsamples", 16))
    }
}
