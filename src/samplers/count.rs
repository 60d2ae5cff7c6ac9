//! Sample counts as scenes give them.

use crate::params::ParamReader;

/// The most samples a pixel may have: beyond this, single-precision numbers repeat.
const MAX: i64 = 1 << 24;

/// The positive integer `name`. One out of range is reported and clamped.
pub(super) fn positive(reader: &ParamReader, name: &str, default: u32) -> u32 {
    let given = reader.integer(name, i64::from(default));
    let used = given.clamp(1, MAX);
    if used != given {
        reader.error(
            name,
            format!("`{name}` is {given}, not between 1 and {MAX}: {used} is used"),
        );
    }
    used as u32
}

/// The power of two that pbrt raises `name` to, with its warning.
pub(super) fn power_of_two(reader: &ParamReader, name: &str, default: u32) -> u32 {
    let given = positive(reader, name, default);
    let used = given.next_power_of_two();
    if used != given {
        reader.warn(
            name,
            format!("{given} samples a pixel rounded up to the power of two {used}, as pbrt does"),
        );
    }
    used
}
