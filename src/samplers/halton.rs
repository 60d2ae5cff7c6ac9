//! `halton`, pbrt-v3's default sampler, served by the points of [`super::sobol`].
//!
//! `pixelsamples` (integer, 16; 4 in pbrt-v2). `samplepixelcenter` (bool, false): every film point
//! lies at a pixel center, which changes the image.

use super::SamplerSpec;
use super::count::positive;
use crate::params::ParamReader;

/// Reads the parameters.
pub(super) fn from_params(reader: &ParamReader) -> SamplerSpec {
    SamplerSpec {
        pixel_centers: reader.boolean("samplepixelcenter", false),
        note: Some(
            "sampler \"halton\" is rendered with Owen-scrambled low-discrepancy points (same image, other noise)",
        ),
        ..SamplerSpec::sobol(positive(reader, "pixelsamples", 16))
    }
}
