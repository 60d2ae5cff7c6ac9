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
//! film and first light point if the camera has no lens. Single dimensions share sets of four, too.
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
use super::net::{point, point_of};
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

/// A set of four dimensions of which some are used. It is computed when the first value is requested: most
/// surfaces need no sample to choose a lobe, and most scenes none to choose a light.
#[derive(Clone, Copy, Debug)]
struct Drawn {
    values: [f32; 4],
    /// Which set.
    number: u32,
    /// How many of them are used or skipped.
    used: u8,
    /// The values are computed.
    made: bool,
}

impl Drawn {
    const NOTHING: Drawn = Drawn {
        values: [0.0; 4],
        number: 0,
        used: 4,
        made: false,
    };

    /// The index of the next `count` values (1 or 2) in this set or in a new one; `sets` have begun so far.
    #[inline]
    fn take(&mut self, count: u8, sets: &mut u32) -> u8 {
        if self.used > 4 - count {
            (self.number, self.used, self.made) = (*sets, 0, false);
            *sets = sets.wrapping_add(1);
        }
        let at = self.used;
        self.used += count;
        at
    }
}

/// The dimensions of one camera sample.
#[derive(Clone, Copy, Debug)]
pub struct SobolStream {
    points: ScrambledPoints,
    /// Sets begun so far.
    sets: u32,
    pairs: Drawn,
    singles: Drawn,
}

/// The point of one sample in every set of four dimensions.
#[derive(Clone, Copy, Debug)]
struct ScrambledPoints {
    /// Seed of the pixel.
    seed: u64,
    kind: Kind,
}

/// The kind of sets, and the sample's index in them.
#[derive(Clone, Copy, Debug)]
enum Kind {
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
    fn in_set(&self, number: u32) -> [f32; 4] {
        // Weyl's sequence mixed, as in SplitMix64: the seed is hashed already.
        let step = u64::from(number).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let key = mix(self.seed.wrapping_add(step));
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
                let x = (stratum as f32 + offset) / count as f32;
                [x.min(BELOW_ONE), y, z, w]
            }
        }
    }
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

/// Owen scrambling of the coordinates, each with a key of its own: distinct words, hashed again.
#[inline(always)]
fn scrambled(point: [u32; 4], key: u64) -> [f32; 4] {
    let key = (key >> 32) as u32;
    let keys = [key, key ^ 0x9e37_79b9, key ^ 0x7f4a_7c15, key ^ 0xe17d_05ac];
    let mut values = [0.0; 4];
    for ((value, x), key) in values.iter_mut().zip(point).zip(keys) {
        *value = u32_to_f32_norm(owen_scramble_rev(x, hash(key)).reverse_bits());
    }
    values
}

/// The first set of a fork made after so many sets: far from those of any other, as a test says of the first forks. Those of forks of forks are
/// scattered among 2³² numbers, too.
fn first_of_fork(sets: u32) -> u32 {
    const FORK: u64 = 0x666f_726b;
    mix2(sets.into(), FORK) as u32
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
            sets: 0,
            pairs: Drawn::NOTHING,
            singles: Drawn::NOTHING,
        }
    }

    /// See [`super::SampleStream::fork`]. Pairs share sets with those that they would share them with here.
    pub(super) fn fork(&mut self) -> SobolStream {
        let first = first_of_fork(self.sets);
        self.sets = self.sets.wrapping_add(1);
        let pairs = Drawn {
            number: first,
            used: self.pairs.used,
            ..Drawn::NOTHING
        };
        SobolStream {
            points: self.points,
            sets: first.wrapping_add(1),
            pairs,
            singles: Drawn::NOTHING,
        }
    }

    #[inline]
    pub(super) fn next_1d(&mut self) -> f32 {
        let at = self.singles.take(1, &mut self.sets);
        if !self.singles.made {
            self.singles.values = self.points.in_set(self.singles.number);
            self.singles.made = true;
        }
        self.singles.values[usize::from(at & 3)]
    }

    #[inline]
    pub(super) fn next_2d(&mut self) -> Vec2 {
        let at = self.pairs.take(2, &mut self.sets);
        if !self.pairs.made {
            self.pairs.values = self.points.in_set(self.pairs.number);
            self.pairs.made = true;
        }
        let [x, y, z, w] = self.pairs.values;
        if at == 0 {
            Vec2::new(x, y)
        } else {
            Vec2::new(z, w)
        }
    }

    #[inline]
    pub(super) fn skip_1d(&mut self) {
        self.singles.take(1, &mut self.sets);
    }

    #[inline]
    pub(super) fn skip_2d(&mut self) {
        self.pairs.take(2, &mut self.sets);
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
        // More than paths have: a set serves two pairs or four single numbers.
        const SETS: u32 = 1000;
        let mut first: Vec<u32> = (0..SETS).map(first_of_fork).collect();
        first.push(0);
        first.sort_unstable();
        let gaps = first.windows(2).map(|pair| pair[1] - pair[0]);
        assert!(gaps.min() > Some(SETS));
        assert!(first.last() < Some(&(u32::MAX - SETS)));
    }
}
