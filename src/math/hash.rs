//! Integer hashes: every random sample is a pure function of (seed, pixel, sample, dimension).

/// Mixes 64 bits thoroughly (Stafford's variant 13 of the MurmurHash3 finalizer, as in SplitMix64).
#[inline(always)]
pub const fn mix(mut x: u64) -> u64 {
    x ^= x >> 30;
    x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^= x >> 27;
    x = x.wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// Mixes two words into one.
pub const fn mix2(a: u64, b: u64) -> u64 {
    mix(a
        .wrapping_add(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(mix(b.wrapping_add(0x9e37_79b9_7f4a_7c15))))
}

/// The top 24 bits as a float in [0, 1).
pub const fn unit_float(bits: u64) -> f32 {
    (bits >> 40) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_floats_stay_below_one() {
        assert_eq!(unit_float(0), 0.0);
        assert!(unit_float(u64::MAX) < 1.0);
    }
}
