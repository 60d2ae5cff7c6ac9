//! Parameters with a valid range, as constants and as texture values.

use crate::inputs::FloatInput;
use crate::math::float::clamp_nan_low;
use crate::params::ParamReader;
use std::ops::RangeInclusive;

/// Refractive index if none, or an invalid one, is given.
pub(super) const USUAL_INDEX: f32 = 1.5;

/// Range of refractive indices: beyond these everything is reflected anyway.
pub(super) const INDICES: RangeInclusive<f32> = 1e-3..=1e3;

/// A float or a texture. A constant outside `range` gives a warning and is clamped.
pub(super) fn float_within(
    reader: &ParamReader,
    name: &str,
    default: f32,
    range: RangeInclusive<f32>,
) -> FloatInput {
    match reader.find_float_input(name) {
        Some(FloatInput::Constant(given)) => {
            let used = clamp_nan_low(given, *range.start(), *range.end());
            // NaN differs from the value used too.
            if used != given {
                reader.warn(name, format!("`{name}` is {given}: {used} is used"));
            }
            FloatInput::Constant(used)
        }
        Some(texture) => texture,
        None => FloatInput::Constant(default),
    }
}

/// A float from 0 to 1, or a texture.
pub(super) fn unit_input(reader: &ParamReader, name: &str, default: f32) -> FloatInput {
    float_within(reader, name, default, 0.0..=1.0)
}

/// `eta`, else its older name `index` (the only one in pbrt-v2), 1.5 by default.
pub(super) fn refractive_index(reader: &ParamReader) -> FloatInput {
    given_refractive_index(reader, "eta")
        .or_else(|| given_refractive_index(reader, "index"))
        .unwrap_or(FloatInput::Constant(USUAL_INDEX))
}

/// A refractive index, if it is given. Invalid constants give a warning and are replaced by 1.5.
pub(super) fn given_refractive_index(reader: &ParamReader, name: &str) -> Option<FloatInput> {
    let given = reader.find_float_input(name)?;
    Some(match given {
        FloatInput::Constant(x) if x <= 0.0 || !x.is_finite() => {
            let message = format!("`{name}` is {x}, no refractive index: {USUAL_INDEX} is used");
            reader.warn(name, message);
            FloatInput::Constant(USUAL_INDEX)
        }
        _ => given,
    })
}
