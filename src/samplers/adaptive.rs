//! pbrt-v2's `adaptive`, which takes more samples where the first ones of a pixel differ.
//!
//! Deciding by the samples themselves biases the mean of a pixel, so every pixel gets the larger
//! count here. `minsamples` (integer, 4) and `method` (string, "contrast"): accepted.
//! `maxsamples` (integer, 32), rounded up to a power of two as pbrt-v2 does.

use super::SamplerSpec;
use super::count::power_of_two;
use crate::params::ParamReader;

/// Reads the parameters.
pub(super) fn from_params(reader: &ParamReader) -> SamplerSpec {
    reader.find_integer("minsamples");
    reader.find_string("method");
    SamplerSpec {
        note: Some("sampler \"adaptive\" is rendered with maxsamples in every pixel"),
        ..SamplerSpec::sobol(power_of_two(reader, "maxsamples", 32))
    }
}
