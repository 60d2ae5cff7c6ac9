//! Points of 16 dimensions that are well spread in many ways at once.
//!
//! The dimensions come in four sets of four. In each **set** any aligned run of 4ᵐ points has exactly
//! one in each box of 4^(−a) × 4^(−b) × 4^(−c) × 4^(−d) with a + b + c + d = m: a (0, 4)-sequence in base 4.
//! Its first and its last **pair** each have one of an aligned run of 2ᵐ points in each box of
//! 2^(−a) × 2^(−b), a + b = m: (0, 2)-sequences in base 2. **All 16 dimensions** together are a (0, 16)-sequence in
//! base 16: of 256 points one lies in each square of a 16 × 16 grid, for any two dimensions. Sobol's sequence
//! has the second property only, and only in its first pair.
//!
//! Construction: Niederreiter, "Point sets and sequences with small discrepancy", Monatshefte für
//! Mathematik 104, 1987, over GF(4) and GF(16). The index's digits, from the least significant, are elements of the
//! field; digit i of a coordinate, from the most significant, is Σⱼ C(j, i) a^(j−i) · (digit j), with another a
//! for each coordinate. Invertible maps of single digits keep that property, and those used here were
//! found by trying all: [`DIGIT_MAPS`] make the pairs sequences in base 2, [`Set::map`] spread the
//! sets against each other where points are few. That (0, 2)-sequences can be put together so is shown, in
//! another way, by Ahmed, Skopenkov, Hadwiger and Wonka, "SZ Sequences: Binary-Based (0, 2^q)-Sequences",
//! SIGGRAPH Asia 2024.
//!
//! Why the sets fit together: with P(a) for the matrix of the sum above, P(a)·P(b) = P(a + b), so that a set read at
//! the index P(b)·index has the coordinates a + b; and two digits of GF(4) are one of GF(16), P(a)
//! there being P(a²) here but for a map of digits (for C(2j + s, 2i + r) is C(j, i)·C(s, r), modulo 2, and
//! squaring is linear). Four b of which no two differ by an element of GF(4) give all 16 coordinates.

use super::field::{OMEGA, times_power};

/// Bits of index and coordinates.
const BITS: usize = 32;

/// Four bits of an index, the unit that tables are made for.
const NIBBLES: usize = BITS / 4;

/// A square matrix of bits applied to a digit: its rows, the first column being bit 0.
type DigitMap<const N: usize> = [u8; N];

/// What a set's four coordinates are multiplied with: a in GF(4).
const FACTORS: [u8; 4] = [0, 1, OMEGA, OMEGA ^ 1];

/// Maps of their digits.
const DIGIT_MAPS: [DigitMap<2>; 4] = [[0b01, 0b10], [0b11, 0b10], [0b01, 0b10], [0b11, 0b01]];

/// How many sets fit together.
pub(super) const SETS: usize = 4;

/// How a set reads the index.
struct Set {
    /// b in GF(16).
    factor: u8,
    /// Map of the digits of P(b)·index: ones on the diagonal and above, so that aligned runs remain such.
    map: DigitMap<4>,
}

const SET_TABLES: [[[u32; 16]; NIBBLES]; SETS - 1] = [
    Set {
        factor: 0b1000,
        map: [0b0111, 0b1110, 0b1100, 0b1000],
    }
    .table(),
    Set {
        factor: 0b1100,
        map: [0b0101, 0b1010, 0b0100, 0b1000],
    }
    .table(),
    Set {
        factor: 0b0100,
        map: [0b1011, 0b0110, 0b1100, 0b1000],
    }
    .table(),
];

const fn mapped<const N: usize>(map: DigitMap<N>, digit: u8) -> u8 {
    let mut result = 0;
    let mut row = 0;
    while row < N {
        result |= ((map[row] & digit).count_ones() as u8 & 1) << row;
        row += 1;
    }
    result
}

/// Column `bit` of P(`factor`), its digits of N bits mapped.
const fn column<const N: usize>(factor: u8, map: DigitMap<N>, bit: usize) -> u32 {
    let (j, unit) = (bit / N, 1 << (bit % N));
    let mut result = 0;
    let mut i = 0;
    while i <= j {
        // C(j, i) is odd where i has no bit that j has not (Lucas 1878).
        if i & !j == 0 {
            let digit = mapped(map, times_power(unit, factor, j - i));
            result |= (digit as u32) << (N * i);
        }
        i += 1;
    }
    result
}

/// For each nibble and each of its values the sum of the columns that it stands for.
const fn sums<const N: usize>(factor: u8, map: DigitMap<N>) -> [[u32; 16]; NIBBLES] {
    let mut table = [[0; 16]; NIBBLES];
    let mut entry = 0;
    while entry < 16 * NIBBLES {
        let (nibble, value) = (entry / 16, entry % 16);
        let mut bit = 0;
        while bit < 4 {
            if value >> bit & 1 == 1 {
                table[nibble][value] ^= column(factor, map, 4 * nibble + bit);
            }
            bit += 1;
        }
        entry += 1;
    }
    table
}

impl Set {
    const fn table(&self) -> [[u32; 16]; NIBBLES] {
        sums(self.factor, self.map)
    }
}

/// What each nibble of the index adds to the four coordinates.
static POINTS: [[[u32; 4]; 16]; NIBBLES] = points();

/// What each nibble of the index adds to the index that the second, third and fourth set read.
static INDICES: [[[u32; 16]; NIBBLES]; SETS - 1] = SET_TABLES;

const fn points() -> [[[u32; 4]; 16]; NIBBLES] {
    let mut table = [[[0; 4]; 16]; NIBBLES];
    let mut dimension = 0;
    while dimension < 4 {
        let sums = sums(FACTORS[dimension], DIGIT_MAPS[dimension]);
        let mut entry = 0;
        while entry < 16 * NIBBLES {
            table[entry / 16][entry % 16][dimension] = sums[entry / 16][entry % 16];
            entry += 1;
        }
        dimension += 1;
    }
    table
}

fn nibble(index: u32, place: usize) -> usize {
    (index >> (4 * place) & 15) as usize
}

/// Point `index` in set `set` (modulo [`SETS`]); the most significant bit of each coordinate is in bit 0.
#[inline]
pub(super) fn point(index: u32, set: u32) -> [u32; 4] {
    let index = match set as usize % SETS {
        0 => index,
        later => INDICES[later - 1]
            .iter()
            .enumerate()
            .fold(0, |sum, (place, values)| sum ^ values[nibble(index, place)]),
    };
    let mut point = [0; 4];
    for (place, values) in POINTS.iter().enumerate() {
        let added = values[nibble(index, place)];
        for (coordinate, added) in point.iter_mut().zip(added) {
            *coordinate ^= added;
        }
    }
    point
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The points of a set, as numbers.
    fn points(set: u32, indices: std::ops::Range<u32>) -> Vec<[f64; 4]> {
        let float = |x: u32| f64::from(x.reverse_bits()) / 2f64.powi(32);
        indices.map(|i| point(i, set).map(float)).collect()
    }

    /// Is there one point in each box, when coordinates are cut into so many parts?
    fn one_in_each_box<const D: usize>(points: &[[f64; D]], parts: [usize; D]) -> bool {
        assert_eq!(points.len(), parts.iter().product());
        let mut seen = vec![false; points.len()];
        points.iter().all(|p| {
            let cell = p.iter().zip(parts).fold(0, |cell, (x, parts)| {
                cell * parts + (x * parts as f64) as usize
            });
            !std::mem::replace(&mut seen[cell], true)
        })
    }

    #[test]
    fn sets_are_nets_of_base_four() {
        for set in 0..4 {
            for m in 0..=5u32 {
                let count = 4u32.pow(m);
                // The first points, and a later aligned run.
                for first in [0, 5 * count] {
                    let run = points(set, first..first + count);
                    for a in 0..=m {
                        for b in 0..=m - a {
                            for c in 0..=m - a - b {
                                let parts = [a, b, c, m - a - b - c].map(|e| 4usize.pow(e));
                                assert!(one_in_each_box(&run, parts), "set {set}: {parts:?}");
                            }
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn pairs_are_nets_of_base_two() {
        for set in 0..4 {
            for m in 0..=12u32 {
                for first in [0u32, 3 << m, 1 << 24] {
                    let run = points(set, first..first + (1 << m));
                    for a in 0..=m {
                        let (x, y) = (1 << a, 1 << (m - a));
                        assert!(one_in_each_box(&run, [x, y, 1, 1]), "set {set}: {x} {y}");
                        assert!(one_in_each_box(&run, [1, 1, x, y]), "set {set}: {x} {y}");
                    }
                }
            }
        }
    }

    #[test]
    fn any_two_dimensions_have_one_of_256_points_in_each_square() {
        let all: Vec<Vec<[f64; 4]>> = (0..4).map(|set| points(set, 256..512)).collect();
        let coordinate = |d: usize, i: usize| all[d / 4][i][d % 4];
        for a in 0..16 {
            for b in 0..a {
                let pair: Vec<[f64; 2]> = (0..256)
                    .map(|i| [coordinate(a, i), coordinate(b, i)])
                    .collect();
                assert!(one_in_each_box(&pair, [16, 16]), "{a} {b}");
            }
        }
    }

    #[test]
    fn any_three_dimensions_have_one_of_4096_points_in_each_cube() {
        let all: Vec<Vec<[f64; 4]>> = (0..4).map(|set| points(set, 0..4096)).collect();
        let coordinate = |d: usize, i: usize| all[d / 4][i][d % 4];
        // Three of different sets, and two of one with a third.
        for triple in [[0, 5, 10], [3, 4, 15], [0, 1, 9], [6, 7, 12], [2, 8, 14]] {
            let points: Vec<[f64; 3]> = (0..4096)
                .map(|i| triple.map(|d| coordinate(d, i)))
                .collect();
            assert!(one_in_each_box(&points, [16, 16, 16]), "{triple:?}");
        }
    }

    #[test]
    fn all_bits_of_the_index_count() {
        // No coordinate comes twice: each is an invertible function of the index. Its matrix has zeros below the
        // diagonal of digits, so that it is enough that no bit is lost in a digit of its own.
        for set in 0..4 {
            for place in 0..NIBBLES {
                for d in 0..4 {
                    let seen: std::collections::BTreeSet<u32> = (0..16u32)
                        .map(|value| point(value << (4 * place), set)[d] >> (4 * place))
                        .collect();
                    assert_eq!(seen.len(), 16, "set {set}, nibble {place}, dimension {d}");
                    assert!(seen.iter().all(|&x| x < 16));
                }
            }
        }
    }
}
