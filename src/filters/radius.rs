//! The `xwidth` and `ywidth` that every filter has.

use crate::math::DVec2;
use crate::params::ParamReader;

/// Half widths in pixels. One that is not positive and finite is an error and becomes `default`.
pub(super) fn radius_from_params(reader: &ParamReader, default: f64) -> DVec2 {
    let read = |name: &str| {
        let width = reader.float(name, default);
        if width > 0.0 && width.is_finite() {
            return width;
        }
        reader.error(
            name,
            format!("a filter's half width must be a positive number of pixels; using {default}"),
        );
        default
    };
    DVec2::new(read("xwidth"), read("ywidth"))
}
