//! The `samples` parameter of area and infinite lights.

use crate::params::{Dialect, ParamReader};

/// The most samples of one light at one point.
const MOST: i64 = 1 << 16;

/// `samples`, else its older name `nsamples` (the only one in pbrt-v2), default 1.
pub(super) fn sample_count(reader: &ParamReader) -> u32 {
    let older = reader.find_integer("nsamples");
    let given = match reader.dialect() {
        Dialect::V2 => older,
        Dialect::V3 => reader.find_integer("samples").or(older),
    };
    given.unwrap_or(1).clamp(1, MOST) as u32
}
