//! The finite fields of 4 and of 16 elements, at compile time.
//!
//! GF(4) = {0, 1, ω, ω²} with ω² = ω + 1: bit 0 counts 1, bit 1 counts ω.
//! GF(16) = GF(4)\[z\] with z² = z + ω: the two low bits count 1, the two high bits z, so that elements
//! of GF(4) keep their bits. Addition is exclusive or in both.

/// ω in GF(4) and in GF(16).
pub(super) const OMEGA: u8 = 0b10;

/// The product in GF(4).
pub(super) const fn times_4(x: u8, y: u8) -> u8 {
    // ω·(x₁ω + x₀) = (x₁ + x₀)ω + x₁.
    let by_omega = (x >> 1 ^ x & 1) << 1 | x >> 1;
    (if y & 1 == 0 { 0 } else { x }) ^ (if y & 2 == 0 { 0 } else { by_omega })
}

/// The product in GF(16).
pub(super) const fn times_16(x: u8, y: u8) -> u8 {
    let (x1, x0, y1, y0) = (x >> 2, x & 3, y >> 2, y & 3);
    let squares = times_4(x1, y1);
    let high = times_4(x1, y0) ^ times_4(x0, y1) ^ squares;
    let low = times_4(x0, y0) ^ times_4(squares, OMEGA);
    high << 2 | low
}

/// x·yⁿ in GF(16), and so also in GF(4).
pub(super) const fn times_power(mut x: u8, y: u8, mut n: usize) -> u8 {
    while n > 0 {
        x = times_16(x, y);
        n -= 1;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The laws of a field of `n` elements with this product.
    fn is_a_field(n: u8, times: fn(u8, u8) -> u8) {
        for x in 0..n {
            assert_eq!((times(x, 0), times(x, 1)), (0, x));
            let inverses = (0..n).filter(|&y| times(x, y) == 1).count();
            assert_eq!(inverses, usize::from(x != 0));
            for y in 0..n {
                assert_eq!(times(x, y), times(y, x));
                for z in 0..n {
                    assert_eq!(times(x, times(y, z)), times(times(x, y), z));
                    assert_eq!(times(x, y ^ z), times(x, y) ^ times(x, z));
                }
            }
        }
    }

    #[test]
    fn both_are_fields_and_the_smaller_lies_in_the_larger() {
        is_a_field(4, times_4);
        is_a_field(16, times_16);
        for x in 0..4 {
            for y in 0..4 {
                assert_eq!(times_16(x, y), times_4(x, y));
            }
        }
        assert_eq!(times_power(7, OMEGA, 3), 7);
    }
}
