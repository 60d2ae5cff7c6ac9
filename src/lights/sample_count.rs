//! The `samples` parameter of area and infinite lights.

use crate::params::ParamReader;

/// The most samples of one light at one point.
const MAX: i64 = 4096;

/// `samples`, else its older name `nsamples` (the only one in pbrt-v2), default 1.
pub(super) fn sample_count(reader: &ParamReader) -> u32 {
    let find = |name| reader.find_integer_within(name, 1..=MAX);
    let older = find("nsamples");
    find("samples").or(older).unwrap_or(1) as u32
}

/// As many as pbrt takes under `--quick`.
pub(super) fn quick(samples: u32) -> u32 {
    (samples / 4).max(1)
}

#[cfg(test)]
mod tests {
    use super::sample_count;
    use crate::params::testing::read;

    #[test]
    fn counts_out_of_range_are_warned_of() {
        for (given, used, warnings) in [(0, 1, 1), (16, 16, 0), (4096, 4096, 0), (5000, 4096, 1)] {
            for name in ["samples", "nsamples"] {
                let params = format!("\"integer {name}\" {given}");
                let outcome = read("infinite", &params, sample_count);
                assert_eq!((outcome.value, outcome.warnings), (used, warnings));
            }
        }
    }
}
