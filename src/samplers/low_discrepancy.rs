//! `lowdiscrepancy`, also called `02sequence`, served by the points of [`super::sobol`]: each pair of
//! dimensions is itself a (0,2)-sequence.
//!
//! `pixelsamples` (integer, 16; 4 in pbrt-v2), rounded up to a power of two as pbrt does.
//! `dimensions` (integer, 4): accepted; all dimensions are well distributed.

use super::SamplerSpec;
use super::count::power_of_two;
use crate::params::ParamReader;

/// Reads the parameters.
pub(super) fn from_params(reader: &ParamReader) -> SamplerSpec {
    reader.find_integer("dimensions");
    SamplerSpec {
        note: Some(
            "(0,2)-sequences are rendered with Owen-scrambled low-discrepancy points (same image, other noise)",
        ),
        ..SamplerSpec::sobol(power_of_two(reader, "pixelsamples", 16))
    }
}
