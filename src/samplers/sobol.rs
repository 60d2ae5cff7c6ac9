//! `sobol`: Owen-scrambled low-discrepancy points, which also replace those of all other low-discrepancy types.
//!
//! `pixelsamples` (integer, 16), rounded up to a power of two as pbrt-v3 does.
//!
//! Dimensions come in sets of four, those of [`super::net`], each with Owen scrambling: every
//! bit of a coordinate is flipped or not depending on the more significant ones, which keeps the stratification of all
//! aligned runs and makes each coordinate uniform. The order of the points is shuffled in the same way for each set,
//! so that sets are independent of each other and the number of dimensions is unlimited (Burley, "Practical
//! Hash-based Owen Scrambling", JCGT 9(4), 2020, with the hash of the crate `sobol_burley`).
//!
//! Pairs have sets of their own, two in each: film and lens point share four dimensions, or
//! film and first light point if the camera has no lens. Single dimensions share sets of four, too. A stream counts both: to skip some is to add a number.
//!
//! A sample count that is not a power of two ends within an aligned run: some regions of the unit square then have twice the density of others. Where the count n is
//! fixed, each set is a Hammersley set instead ("Monte Carlo Methods for Solving Multivariable Problems", Annals of the New York Academy of Sciences 86, 1960): the
//! first coordinate is stratified into n intervals by the point's index, and the points of any run of intervals are as well distributed in each other coordinate
//! as their number allows. The order of the points is a random permutation. `docs/samplers.md` has what that gains.
//!
//! Tried; variance in units of this one's, at 16, 64 and 256 samples of the scenes of `docs/samplers.md`:
//! * Each pair in a set of its own with two singles, of Sobol's first four dimensions: lens 1.8, 2.0, 2.7;
//!   box 1.1, 1.0, 1.0; motion 1.0, 0.9, 0.9 (time shares a set with the film point).
//! * 64 dimensions of Sobol's sequence with one order of points: lens 1.2, 0.9, 0.9; box 1.1, 1.1, 0.8; motion
//!   1.0, 0.9, 0.6.
//! * A (0, 16)-sequence in base 16 of four such sets with one order of points: lens 1.1, 1.0, 0.8; box 1.0, 0.9, 0.8;
//!   but motion 1.1, 2.1, 0.5: with other counts than powers of 16 some dimensions are poorly stratified together.
//! * Hammersley sets: the first with the net's first coordinate beside the index, as the others have it: 1.17 for film and lens together
//!   (`dgauss` of `benches/peer`, 24 samples); the others like the first: 1.07 (`cornell`, 25).

use super::SamplerSpec;
use super::count::power_of_two;
use super::net::{point, point_of, points_of_all};
use super::permutation::Permutation;
use crate::math::Vec2;
use crate::math::hash::{mix, mix2};
use crate::math::instruction_set::{Instructions, Kernel, vectorize};
use crate::math::sampling::BELOW_ONE;
use crate::params::ParamReader;
use sobol_burley::parts::{hash, owen_scramble_rev, u32_to_f32_norm};
use std::num::NonZeroU32;

/// Reads the parameters.
pub(super) fn from_params(reader: &ParamReader) -> SamplerSpec {
    SamplerSpec::sobol(power_of_two(reader, "pixelsamples", 16))
}

/// The dimensions of one camera sample.
#[derive(Clone, Copy, Debug)]
pub struct SobolStream {
    pub(super) points: ScrambledPoints,
    /// Pairs and single numbers that have been drawn or skipped.
    pairs: u32,
    singles: u32,
    /// The last sets of both whose values have been needed.
    of_pairs: Known,
    of_singles: Known,
}

/// A set of dimensions whose values are known.
#[derive(Clone, Copy, Debug)]
struct Known {
    number: u32,
    values: [f32; 4],
}

impl Known {
    /// No set has this number.
    const NOTHING: Known = Known {
        number: u32::MAX,
        values: [0.0; 4],
    };
}

/// The set that a pair is in, which is below [`SINGLES`].
fn set_of_pair(pair: u32) -> u32 {
    pair / 2
}

/// The sets of single numbers, four in each, begin here.
const SINGLES: u32 = 1 << 31;

/// The point of one sample in every set of four dimensions.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScrambledPoints {
    /// Seed of the pixel.
    pub(super) seed: u64,
    pub(super) kind: Kind,
}

/// The kind of sets, and the sample's index in them.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    /// An infinite sequence.
    Sequence {
        /// Sample index, its bits reversed.
        index_reversed: u32,
    },
    /// A Hammersley set of exactly `count` points.
    Hammersley { index: u32, count: NonZeroU32 },
}

impl ScrambledPoints {
    /// The point in the set with this number. Integers are multiplied four at a time, for which the oldest processors of x86-64 have no instruction.
    pub(super) fn in_set(&self, number: u32) -> [f32; 4] {
        let key = key_of(self.seed, number);
        match self.kind {
            Kind::Sequence { index_reversed } => vectorize::<4, _>(SequencePoint {
                index_reversed,
                key,
            }),
            Kind::Hammersley { index, count } => {
                let count = count.get();
                let stratum = Permutation::new(count).apply_fast(index, key);
                let kernel = HammersleyPoint {
                    stratum,
                    is_first: number == 0,
                    key,
                };
                let [offset, y, z, w] = vectorize::<4, _>(kernel);
                [in_stratum(stratum, offset, count), y, z, w]
            }
        }
    }
}

/// The key of the set with this number, of the pixel hashed into `seed`: Weyl's sequence mixed, as in SplitMix64, for the seed is hashed already.
#[inline(always)]
fn key_of(seed: u64, number: u32) -> u64 {
    mix(seed.wrapping_add(u64::from(number).wrapping_mul(0x9e37_79b9_7f4a_7c15)))
}

/// The number at `offset` (0 to 1) of a stratum's width, of so many strata.
#[inline(always)]
fn in_stratum(stratum: u32, offset: f32, count: u32) -> f32 {
    ((stratum as f32 + offset) / count as f32).min(BELOW_ONE)
}

/// What [`ScrambledPoints::in_set`] is for many samples of the same kind, `count` of them in a Hammersley set, each in a set of its own, by coordinate: in loops
/// that are compiled to vector instructions. `indices` are those of [`Kind`].
#[inline(always)]
pub(super) fn points_in_sets<const L: usize>(
    count: Option<NonZeroU32>,
    indices: [u32; L],
    (seeds, numbers): (&[u64; L], &[u32; L]),
) -> [[f32; L]; 4] {
    // Loops that write to arrays of keys and places: with `from_fn` their closures were not inlined.
    let mut keys = [0; L];
    for ((key, seed), number) in keys.iter_mut().zip(seeds).zip(numbers) {
        *key = key_of(*seed, *number);
    }
    let Some(count) = count.map(NonZeroU32::get) else {
        let mut places = [0; L];
        for ((place, index), key) in places.iter_mut().zip(indices).zip(&keys) {
            *place = owen_scramble_rev(index, *key as u32).reverse_bits();
        }
        return scrambled_all(points_of_all(places, u32::BITS), &keys);
    };
    let strata = Permutation::new(count).apply_fast_to_all(indices, &keys);
    let [a, b, c, d] = points_of_all(strata, u32::BITS - count.leading_zeros());
    let choose = |first: &[u32; L], other: &[u32; L]| {
        std::array::from_fn(|i| if numbers[i] == 0 { first[i] } else { other[i] })
    };
    let coordinates = [
        choose(&c, &b),
        choose(&d, &a),
        choose(&a, &c),
        choose(&b, &d),
    ];
    let [offsets, y, z, w] = scrambled_all(coordinates, &keys);
    let x = std::array::from_fn(|i| in_stratum(strata[i], offsets[i], count));
    [x, y, z, w]
}

struct SequencePoint {
    index_reversed: u32,
    key: u64,
}

impl Kernel for SequencePoint {
    type Output = [f32; 4];

    #[inline(always)]
    fn run(self, _: impl Instructions) -> [f32; 4] {
        let shuffled = owen_scramble_rev(self.index_reversed, self.key as u32);
        scrambled(point(shuffled), self.key)
    }
}

// Without what comes before and after: with it, the compiler would not keep the four lanes together.
struct HammersleyPoint {
    /// Of the first coordinate, which is the point's index in the set.
    stratum: u32,
    /// The pixel's first set, which film and lens point share: the net's last coordinates are better there, where blurred edges depend on all four.
    is_first: bool,
    key: u64,
}

impl Kernel for HammersleyPoint {
    type Output = [f32; 4];

    #[inline(always)]
    fn run(self, _: impl Instructions) -> [f32; 4] {
        let [a, b, c, d] = point_of(self.stratum);
        let coordinates = match self.is_first {
            true => [c, d, a, b],
            false => [b, a, c, d],
        };
        scrambled(coordinates, self.key)
    }
}

/// Distinct words, combined with the key of a set for each coordinate and hashed again.
const KEYS: [u32; 4] = [0, 0x9e37_79b9, 0x7f4a_7c15, 0xe17d_05ac];

/// Owen scrambling of the coordinates, each with a key of its own.
#[inline(always)]
fn scrambled(point: [u32; 4], key: u64) -> [f32; 4] {
    let mut values = [0.0; 4];
    for ((value, x), own) in values.iter_mut().zip(point).zip(KEYS) {
        *value = scrambled_by(x, (key >> 32) as u32 ^ own);
    }
    values
}

/// The same of many points, by coordinate.
#[inline(always)]
fn scrambled_all<const L: usize>(points: [[u32; L]; 4], keys: &[u64; L]) -> [[f32; L]; 4] {
    let mut values = [[0.0; L]; 4];
    for ((values, points), own) in values.iter_mut().zip(&points).zip(KEYS) {
        for ((value, x), key) in values.iter_mut().zip(points).zip(keys) {
            *value = scrambled_by(*x, (key >> 32) as u32 ^ own);
        }
    }
    values
}

#[inline(always)]
fn scrambled_by(coordinate: u32, key: u32) -> f32 {
    u32_to_f32_norm(owen_scramble_rev(coordinate, hash(key)).reverse_bits())
}

/// What a fork draws first, made after so many pairs and single numbers: far from all that is drawn elsewhere, as a test says of the first forks. Forks of forks
/// are scattered among 2³¹ sets of pairs and 2³⁰ of single numbers, too. The constant is one of those with which the first forks are so far apart.
fn first_of_fork(pairs: u32, singles: u32) -> (u32, u32) {
    const FORK: u64 = 0x666f_726f;
    let first = mix2(u64::from(pairs) << 32 | u64::from(singles), FORK);
    (first as u32, (first >> 32) as u32)
}

impl SobolStream {
    /// Sample `index` of the pixel hashed into `seed`, one of `fixed_count` if there will be no others.
    #[inline]
    pub(super) fn new(seed: u64, index: u32, fixed_count: Option<NonZeroU32>) -> SobolStream {
        let kind = match fixed_count {
            Some(count) if index < count.get() => Kind::Hammersley { index, count },
            _ => Kind::Sequence {
                index_reversed: index.reverse_bits(),
            },
        };
        SobolStream {
            points: ScrambledPoints { seed, kind },
            pairs: 0,
            singles: 0,
            of_pairs: Known::NOTHING,
            of_singles: Known::NOTHING,
        }
    }

    /// See [`super::SampleStream::fork`]. Pairs share sets with those that they would share them with here.
    pub(super) fn fork(&mut self) -> SobolStream {
        let (pairs, singles) = first_of_fork(self.pairs, self.singles);
        // Another fork from here has others.
        self.skip_1d();
        SobolStream {
            points: self.points,
            pairs: pairs & !1 | self.pairs & 1,
            singles,
            of_pairs: Known::NOTHING,
            of_singles: Known::NOTHING,
        }
    }

    #[inline]
    pub(super) fn next_1d(&mut self) -> f32 {
        let (number, place) = (SINGLES + self.singles / 4, self.singles & 3);
        self.skip_1d();
        if self.of_singles.number != number {
            let values = self.points.in_set(number);
            self.of_singles = Known { number, values };
        }
        self.of_singles.values[place as usize]
    }

    #[inline]
    pub(super) fn next_2d(&mut self) -> Vec2 {
        if let Some(known) = self.next_known_2d() {
            return known;
        }
        let set = self.begin_pair();
        self.answer(self.points.in_set(set))
    }

    /// The next pair, if the values of its set are known.
    #[inline(always)]
    pub(super) fn next_known_2d(&mut self) -> Option<Vec2> {
        if self.of_pairs.number != set_of_pair(self.pairs) {
            return None;
        }
        self.skip_2d();
        Some(self.last_pair())
    }

    /// Takes the next pair, which is not known and is to be [answered](SobolStream::answer): its set.
    #[inline(always)]
    pub(super) fn begin_pair(&mut self) -> u32 {
        let set = set_of_pair(self.pairs);
        self.skip_2d();
        set
    }

    /// The pair that has been taken, in a set of these values, which are those of [`ScrambledPoints::in_set`].
    #[inline(always)]
    pub(super) fn answer(&mut self, values: [f32; 4]) -> Vec2 {
        let number = set_of_pair(self.pairs.wrapping_sub(1));
        self.of_pairs = Known { number, values };
        self.last_pair()
    }

    #[inline(always)]
    fn last_pair(&self) -> Vec2 {
        let [x, y, z, w] = self.of_pairs.values;
        if self.pairs & 1 == 1 {
            Vec2::new(x, y)
        } else {
            Vec2::new(z, w)
        }
    }

    #[inline(always)]
    pub(super) fn skip_1d(&mut self) {
        self.singles = self.singles.wrapping_add(1);
    }

    #[inline(always)]
    pub(super) fn skip_2d(&mut self) {
        self.pairs = self.pairs.wrapping_add(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::IVec2;
    use crate::samplers::Sampler;

    /// Two pairs, which share a set, and a third.
    fn pairs(sampler: &Sampler, pixel: i32) -> Vec<[Vec2; 3]> {
        let sample = |index| {
            let mut stream = sampler.stream(IVec2::new(pixel, 3), index);
            [(); 3].map(|()| stream.next_2d())
        };
        (0..sampler.spp()).map(sample).collect()
    }

    #[test]
    fn hammersley_sets_have_one_point_in_each_stratum() {
        for count in [3, 5, 6, 7, 10, 12, 24, 25, 100, 1000, 70_001] {
            let sampler = Sampler::new(&SamplerSpec::sobol(count), 3);
            // Shared sets begin with the first coordinate; halves have Hammersley sets, too.
            for (sampler, pair) in [
                (&sampler, 0),
                (&sampler, 2),
                (&sampler.half_of_samples(0), 0),
            ] {
                let n = sampler.spp();
                let mut points = pairs(sampler, 5);
                points.sort_unstable_by(|a, b| a[pair].x.total_cmp(&b[pair].x));
                if !n.is_power_of_two() {
                    let interval = |x: f32| (f64::from(x) * f64::from(n)) as usize;
                    let are = points.iter().map(|p| interval(p[pair].x));
                    // Half a spacing of floats at stratum s is at most s / 2²⁴, and rounding moves an offset that near an end to the
                    // neighboring stratum: n² / 2²⁵ of sums at most, and as many of quotients.
                    let off = are.enumerate().filter(|(i, at)| i != at).count();
                    assert!(off <= (n as usize).pow(2) >> 24, "{n}: {off}");
                }
                // Any run of them is as well distributed in the other coordinate: halves differ by one.
                for run in [1, 2, 3, 7].map(|parts| &points[..points.len() / parts]) {
                    let low = run.iter().filter(|p| p[pair].y < 0.5).count();
                    assert!(
                        low.abs_diff(run.len() - low) <= 1,
                        "{n}: {low} of {}",
                        run.len()
                    );
                }
            }
        }
    }

    /// The mean of what `f` makes of a pixel's points, and that of its square: over many pixels.
    fn moments(sampler: &Sampler, f: impl Fn(i32, &[[Vec2; 3]]) -> f64) -> (f64, f64) {
        const PIXELS: i32 = 8000;
        let values = (0..PIXELS).map(|pixel| f(pixel, &pairs(sampler, pixel)));
        let (sum, squares) = values.fold((0.0, 0.0), |(s, q), v| (s + v, q + v * v));
        (sum / f64::from(PIXELS), squares / f64::from(PIXELS))
    }

    #[test]
    fn hammersley_sets_have_less_error() {
        type Place = fn(&[Vec2; 3]) -> Vec2;
        // The area on one side of an edge, in all directions.
        let edge = |place: Place| {
            move |pixel: i32, points: &[[Vec2; 3]]| {
                let (sin, cos) = (0.7 * pixel as f32).sin_cos();
                let is_left = |p: &&[Vec2; 3]| (place(p) - 0.5).dot(Vec2::new(cos, sin)) < 0.0;
                points.iter().filter(is_left).count() as f64 / points.len() as f64 - 0.5
            }
        };
        let pair: Place = |p| p[2];
        let film_and_lens: Place = |p| Vec2::new(p[0].x, p[1].x);
        // With true random bits 0.82 to 0.65 for pairs, 0.71 to 0.58 for film and lens; 8000 squares are good to 2 %.
        for (count, place, most) in [
            (10, pair, 0.9),
            (24, pair, 0.85),
            (25, pair, 0.8),
            (100, pair, 0.8),
            (24, film_and_lens, 0.85),
            (25, film_and_lens, 0.75),
            (100, film_and_lens, 0.75),
        ] {
            let whole = Sampler::new(&SamplerSpec::sobol(count), 3);
            let (bias, with) = moments(&whole, edge(place));
            let (_, without) = moments(&whole.half(0), edge(place));
            // Five standard errors of 8000 means.
            assert!(bias.abs() < 5.0 * (with / 8000.0).sqrt(), "{count}: {bias}");
            let ratio = with / without;
            assert!(ratio < most, "{count}: {ratio}, {most} at most");
        }
    }

    #[test]
    fn hammersley_sets_are_independent() {
        // The variance of a mean of products of independent numbers, one of two in random order: σ⁴ / (n − 1).
        for count in [5, 10, 24, 100] {
            let sampler = Sampler::new(&SamplerSpec::sobol(count), 3);
            let product = |_, points: &[[Vec2; 3]]| {
                let products = points
                    .iter()
                    .map(|p| f64::from((p[0].x - 0.5) * (p[2].x - 0.5)));
                products.sum::<f64>() / points.len() as f64
            };
            let (mean, square) = moments(&sampler, product);
            let expected = 1.0 / 144.0 / f64::from(count - 1);
            assert!(
                mean.abs() < 5.0 * (square / 8000.0).sqrt(),
                "{count}: {mean}"
            );
            assert!(
                (square / expected - 1.0).abs() < 0.1,
                "{count}: {}",
                square / expected
            );
        }
    }

    #[test]
    fn forks_have_sets_of_their_own() {
        // More than paths have. Forks are made after at most 20 pairs and 30 single dimensions here.
        const SETS: u32 = 1000;
        let after = (0..20).flat_map(|pairs| (0..30).map(move |singles| (pairs, singles)));
        let firsts: Vec<(u32, u32)> = { after }.map(|(p, s)| first_of_fork(p, s)).collect();
        let apart = |mut sets: Vec<u32>, end: u32| {
            sets.extend([0, end]);
            sets.sort_unstable();
            sets.windows(2).map(|pair| pair[1] - pair[0]).min()
        };
        let of_pairs = firsts
            .iter()
            .map(|(pairs, _)| set_of_pair(*pairs))
            .collect();
        assert!(apart(of_pairs, SINGLES) > Some(SETS));
        let of_singles = firsts.iter().map(|(_, singles)| singles / 4).collect();
        assert!(apart(of_singles, 1 << 30) > Some(SETS));
    }
}
