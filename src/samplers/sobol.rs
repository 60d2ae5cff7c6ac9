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
//! Tried; variance in units of this one's, at 16, 64 and 256 samples of the scenes of `docs/samplers.md`:
//! * Each pair in a set of its own with two singles, of Sobol's first four dimensions: lens 1.8, 2.0, 2.7;
//!   box 1.1, 1.0, 1.0; motion 1.0, 0.9, 0.9 (time shares a set with the film point).
//! * 64 dimensions of Sobol's sequence with one order of points: lens 1.2, 0.9, 0.9; box 1.1, 1.1, 0.8; motion
//!   1.0, 0.9, 0.6.
//! * A (0, 16)-sequence in base 16 of four such sets with one order of points: lens 1.1, 1.0, 0.8; box 1.0, 0.9, 0.8;
//!   but motion 1.1, 2.1, 0.5: with other counts than powers of 16 some dimensions are poorly stratified together.

use super::SamplerSpec;
use super::count::power_of_two;
use super::net::point;
use crate::math::Vec2;
use crate::math::hash::{mix, mix2};
use crate::math::instruction_set::{Instructions, Kernel, vectorize};
use crate::params::ParamReader;
use sobol_burley::parts::{hash, owen_scramble_rev, u32_to_f32_norm};

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
    /// Sample index, its bits reversed.
    index_reversed: u32,
}

impl ScrambledPoints {
    /// Integers are multiplied four at a time, for which the oldest processors of x86-64 have no instruction.
    fn in_set(&self, number: u32) -> [f32; 4] {
        vectorize::<4, _>(InSet {
            points: *self,
            number,
        })
    }
}

/// The point in the set with this number.
struct InSet {
    points: ScrambledPoints,
    number: u32,
}

impl Kernel for InSet {
    type Output = [f32; 4];

    #[inline(always)]
    fn run(self, _: impl Instructions) -> [f32; 4] {
        let ScrambledPoints {
            seed,
            index_reversed,
        } = self.points;
        // Weyl's sequence mixed, as in SplitMix64: the seed is hashed already.
        let step = u64::from(self.number).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let key = mix(seed.wrapping_add(step));
        let point = point(owen_scramble_rev(index_reversed, key as u32));
        // A key for each dimension: distinct words, hashed again.
        let key = (key >> 32) as u32;
        let keys = [key, key ^ 0x9e37_79b9, key ^ 0x7f4a_7c15, key ^ 0xe17d_05ac];
        let mut values = [0.0; 4];
        for ((value, x), key) in values.iter_mut().zip(point).zip(keys) {
            *value = u32_to_f32_norm(owen_scramble_rev(x, hash(key)).reverse_bits());
        }
        values
    }
}

/// The first set of a fork made after so many sets: far from those of any other, as a test says of the first forks. Those of forks of forks are
/// scattered among 2³² numbers, too.
fn first_of_fork(sets: u32) -> u32 {
    const FORK: u64 = 0x666f_726b;
    mix2(sets.into(), FORK) as u32
}

impl SobolStream {
    /// Sample `index` of the pixel hashed into `seed`.
    #[inline]
    pub(super) fn new(seed: u64, index: u32) -> SobolStream {
        SobolStream {
            points: ScrambledPoints {
                seed,
                index_reversed: index.reverse_bits(),
            },
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
