//! `lowdiscrepancy`, also called `02sequence`, served by the points of [`super::sobol`]: each pair of
//! numbers is itself such a (0,2)-sequence.
//!
//! `pixelsamples` (integer, 16; 4 in pbrt-v2), rounded up to a power of two as pbrt does.
//! `dimensions` (integer, 4): accepted; all dimensions are spread well.

use super::SamplerSpec;
use super::count::power_of_two;
use crate::params::{Dialect, ParamReader};

/// Reads the parameters.
pub(super) fn from_params(reader: &ParamReader) -> SamplerSpec {
    let default = match reader.dialect() {
        Dialect::V2 => 4,
        Dialect::V3 => 16,
    };
    reader.find_integer("dimensions");
    SamplerSpec {
        note: Some(
            "(0,2)-sequences are rendered with Owen-scrambled low-discrepancy points (same image, other noise)",
        ),
        ..SamplerSpec::sobol(power_of_two(reader, "pixelsamples", default))
    }
}
