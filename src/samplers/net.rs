//! Points of four dimensions that are well distributed in several ways at once.
//!
//! Any aligned run of 4ᵐ points has exactly one in each box of 4^(−a) × 4^(−b) × 4^(−c) × 4^(−d) with
//! a + b + c + d = m: a (0, 4)-sequence in base 4. The first and the last **pair** of dimensions each have one
//! of an aligned run of 2ᵐ points in each box of 2^(−a) × 2^(−b), a + b = m: (0, 2)-sequences in base 2.
//! Sobol's sequence has the second property only, and only in its first pair.
//!
//! Construction: Niederreiter, "Point sets and sequences with small discrepancy", Monatshefte für
//! Mathematik 104, 1987, over the field of four elements. The index's digits, from the least significant, are
//! elements of the field; digit i of a coordinate, from the most significant, is Σⱼ C(j, i) a^(j−i) · (digit j), with
//! another a for each coordinate. Invertible maps of single digits keep that property; [`DIGIT_MAPS`], found by
//! trying all, make the pairs sequences in base 2. That pairs can be put together so is shown, in another
//! way, by Ahmed, Skopenkov, Hadwiger and Wonka, "SZ Sequences: Binary-Based (0, 2^q)-Sequences",
//! SIGGRAPH Asia 2024.

/// Bits of index and coordinates.
const BITS: usize = 32;

/// Groups of four bits of an index, the unit that the table is made for.
const NIBBLES: usize = BITS / 4;

/// An element of GF(4) = {0, 1, ω, ω²}, ω² = ω + 1: bit 0 counts 1, bit 1 counts ω. Sums are exclusive or.
type Digit = u8;

const OMEGA: Digit = 0b10;

/// The factor a of each coordinate.
const FACTORS: [Digit; 4] = [0, 1, OMEGA, OMEGA ^ 1];

/// The map of each coordinate's digits: the rows of a matrix of bits, the first column being bit 0.
const DIGIT_MAPS: [[u8; 2]; 4] = [[0b01, 0b10], [0b11, 0b10], [0b01, 0b10], [0b11, 0b01]];

/// The product in GF(4).
const fn times(x: Digit, y: Digit) -> Digit {
    // ω·(x₁ω + x₀) = (x₁ + x₀)ω + x₁.
    let by_omega = ((x >> 1) ^ (x & 1)) << 1 | x >> 1;
    (if y & 1 == 0 { 0 } else { x }) ^ (if y & 2 == 0 { 0 } else { by_omega })
}

const fn mapped(map: [u8; 2], digit: Digit) -> Digit {
    let [low, high] = [map[0] & digit, map[1] & digit];
    (low.count_ones() & 1 | (high.count_ones() & 1) << 1) as u8
}

/// What bit `bit` of the index adds to a coordinate, the most significant bit in bit 0.
const fn column(dimension: usize, bit: usize) -> u32 {
    let j = bit / 2;
    // From i = j down, the power of the factor grows by one each time.
    let mut digit: Digit = 1 << (bit % 2);
    let mut result = 0;
    let mut i = j;
    loop {
        // C(j, i) is odd where i has no bit that j has not (Lucas 1878).
        if i & !j == 0 {
            result |= (mapped(DIGIT_MAPS[dimension], digit) as u32) << (2 * i);
        }
        if i == 0 {
            return result;
        }
        digit = times(digit, FACTORS[dimension]);
        i -= 1;
    }
}

/// What each bit of an index adds to the four coordinates, the most significant bit of which is in bit 0.
static COLUMNS: [[u32; 4]; BITS] = columns();

const fn columns() -> [[u32; 4]; BITS] {
    let mut table = [[0; 4]; BITS];
    let mut i = 0;
    while i < 4 * BITS {
        table[i / 4][i % 4] = column(i % 4, i / 4);
        i += 1;
    }
    table
}

/// The points of many indices of so many bits, by coordinate: in loops that are compiled to vector instructions. The most significant bit of each
/// coordinate is in bit 0.
#[inline(always)]
pub(super) fn points_of_all<const L: usize>(indices: [u32; L], bits: u32) -> [[u32; L]; 4] {
    let mut points = [[0; L]; 4];
    for (bit, columns) in COLUMNS.iter().enumerate().take(bits as usize) {
        let mut is_set = indices;
        for index in &mut is_set {
            *index = 0u32.wrapping_sub(*index >> bit & 1);
        }
        for (coordinates, column) in points.iter_mut().zip(columns) {
            for (coordinate, is_set) in coordinates.iter_mut().zip(is_set) {
                *coordinate ^= is_set & column;
            }
        }
    }
    points
}

/// For each nibble of the reversed index and each of its values what it adds to the four coordinates: 2 KiB.
static SUMS: [[[u32; 4]; 16]; NIBBLES] = sums();

const fn sums() -> [[[u32; 4]; 16]; NIBBLES] {
    let mut table = [[[0; 4]; 16]; NIBBLES];
    let mut i = 0;
    while i < 4 * BITS * 16 {
        let (dimension, bit, value) = (i % 4, i / 4 % BITS, i / 4 / BITS);
        if value >> (bit % 4) & 1 == 1 {
            table[bit / 4][value][dimension] ^= column(dimension, BITS - 1 - bit);
        }
        i += 1;
    }
    table
}

/// The point whose index has the bits of `reversed`, the least significant in bit 31: as shuffling leaves
/// them. The most significant bit of each coordinate is in bit 0: as scrambling wants them.
#[inline(always)]
pub(super) fn point(reversed: u32) -> [u32; 4] {
    let mut point = [0; 4];
    for (place, values) in SUMS.iter().enumerate() {
        let added = values[(reversed >> (4 * place) & 15) as usize];
        for (coordinate, added) in point.iter_mut().zip(added) {
            *coordinate ^= added;
        }
    }
    point
}

/// [`point`] of an index whose bits are as they are: faster for small ones.
#[inline(always)]
pub(super) fn point_of(index: u32) -> [u32; 4] {
    /// The four bits of each number, reversed.
    const REVERSED: [u8; 16] = [0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15];
    let mut point = [0; 4];
    let mut rest = index;
    for values in SUMS.iter().rev() {
        let added = values[usize::from(REVERSED[(rest & 15) as usize])];
        for (coordinate, added) in point.iter_mut().zip(added) {
            *coordinate ^= added;
        }
        rest >>= 4;
        if rest == 0 {
            break;
        }
    }
    point
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(indices: std::ops::Range<u32>) -> Vec<[f64; 4]> {
        let float = |x: u32| f64::from(x.reverse_bits()) / 2f64.powi(32);
        indices
            .map(|i| point(i.reverse_bits()).map(float))
            .collect()
    }

    #[test]
    fn points_are_those_of_their_index() {
        for i in (0..1000).chain([1 << 20, 0x1234_5678, u32::MAX]) {
            assert_eq!(point_of(i), point(i.reverse_bits()));
            let bits = u32::BITS - i.leading_zeros();
            for bits in [bits, u32::BITS] {
                let [x, y, z, w] = points_of_all([0, i], bits);
                assert_eq!([x[1], y[1], z[1], w[1]], point_of(i));
                assert_eq!([x[0], y[0], z[0], w[0]], [0; 4]);
            }
        }
    }

    /// Returns `true` if there is one point in each box, when coordinates are cut into so many parts.
    fn one_in_each_box(points: &[[f64; 4]], parts: [usize; 4]) -> bool {
        assert_eq!(points.len(), parts.iter().product::<usize>());
        let mut seen = vec![false; points.len()];
        points.iter().all(|p| {
            let cell = p.iter().zip(parts).fold(0, |cell, (x, parts)| {
                cell * parts + (x * parts as f64) as usize
            });
            !std::mem::replace(&mut seen[cell], true)
        })
    }

    #[test]
    fn all_four_dimensions_are_a_net_of_base_four() {
        for m in 0..=5u32 {
            let count = 4u32.pow(m);
            // The first points, and a later aligned run.
            for first in [0, 5 * count] {
                let run = points(first..first + count);
                for a in 0..=m {
                    for b in 0..=m - a {
                        for c in 0..=m - a - b {
                            let parts = [a, b, c, m - a - b - c].map(|e| 4usize.pow(e));
                            assert!(one_in_each_box(&run, parts), "{first}: {parts:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn both_pairs_are_nets_of_base_two() {
        for m in 0..=12u32 {
            for first in [0u32, 3 << m, 1 << 24] {
                let run = points(first..first + (1 << m));
                for a in 0..=m {
                    let (x, y) = (1 << a, 1 << (m - a));
                    assert!(one_in_each_box(&run, [x, y, 1, 1]), "{first}: {x} {y}");
                    assert!(one_in_each_box(&run, [1, 1, x, y]), "{first}: {x} {y}");
                }
            }
        }
    }

    #[test]
    fn all_bits_of_the_index_count() {
        // Each coordinate is an invertible function of the index: nothing stands below the diagonal of digits,
        // whose blocks are invertible.
        for d in 0..4 {
            for digit in 0..BITS / 2 {
                let seen: std::collections::BTreeSet<u32> = (0..4u32)
                    .map(|value| point((value << (2 * digit)).reverse_bits())[d] >> (2 * digit))
                    .collect();
                assert!(
                    seen.iter().eq(&[0, 1, 2, 3]),
                    "dimension {d}, digit {digit}"
                );
            }
        }
    }
}
