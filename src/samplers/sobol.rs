//! `sobol`: scrambled points of low discrepancy, and what stands for all other types that promise such.
//!
//! `pixelsamples` (integer, 16), rounded up to a power of two as pbrt-v3 does.
//!
//! Numbers come in sets of four dimensions, those of [`super::net`], each scrambled by Owen's method: every
//! bit of a coordinate is flipped or not by what stands before it, which keeps the spread of all aligned
//! runs and makes each number uniform. The order of the points is shuffled in the same way for each set,
//! so that sets are independent of each other and there is no limit to the number of dimensions (Burley, "Practical
//! Hash-based Owen Scrambling", JCGT 9(4), 2020, with the hash of the crate `sobol_burley`).
//!
//! Pairs are taken from sets of their own, two from each: film and lens point share four dimensions, or
//! film and first light point where the camera has no lens. Single numbers share sets of four, too.
//!
//! Tried; variance in units of this one's, at 16, 64 and 256 samples of the scenes of `docs/samplers.md`:
//! * Each pair in a set of its own with two singles, of Sobol's first four dimensions: lens 1.8, 2.0, 2.7;
//!   box 1.1, 1.0, 1.0; motion 1.0, 0.9, 0.9 (time shares a set with the film point).
//! * 64 dimensions of Sobol's sequence with one order of points: lens 1.2, 0.9, 0.9; box 1.1, 1.1, 0.8; motion
//!   1.0, 0.9, 0.6.
//! * A (0, 16)-sequence in base 16 of four such sets with one order of points: lens 1.1, 1.0, 0.8; box 1.0, 0.9, 0.8;
//!   but motion 1.1, 2.1, 0.5: with other counts than powers of 16 some dimensions go together badly.

use super::SamplerSpec;
use super::count::power_of_two;
use super::net::point;
use crate::math::Vec2;
use crate::math::hash::mix;
use crate::params::ParamReader;
use sobol_burley::parts::{hash_int4, owen_scramble_int4_rev, owen_scramble_rev};

/// Reads the parameters.
pub(super) fn from_params(reader: &ParamReader) -> SamplerSpec {
    SamplerSpec::sobol(power_of_two(reader, "pixelsamples", 16))
}

/// Four numbers, and how many of them are used up.
#[derive(Clone, Copy, Debug)]
struct Drawn {
    values: [f32; 4],
    used: usize,
}

impl Drawn {
    const NOTHING: Drawn = Drawn {
        values: [0.0; 4],
        used: 4,
    };
}

/// One sample's numbers.
#[derive(Clone, Copy, Debug)]
pub struct SobolStream {
    /// Seed of the pixel.
    seed: u64,
    /// Sample index, its bits reversed.
    index_reversed: u32,
    /// Sets drawn so far.
    sets: u32,
    pairs: Drawn,
    singles: Drawn,
}

impl SobolStream {
    /// Sample `index` of the pixel hashed into `seed`.
    pub(super) fn new(seed: u64, index: u32) -> SobolStream {
        SobolStream {
            seed,
            index_reversed: index.reverse_bits(),
            sets: 0,
            pairs: Drawn::NOTHING,
            singles: Drawn::NOTHING,
        }
    }

    #[inline]
    fn draw(&mut self) -> [f32; 4] {
        // Weyl's sequence mixed, as in SplitMix64: the seed is hashed already.
        let step = u64::from(self.sets).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let key = mix(self.seed.wrapping_add(step));
        self.sets = self.sets.wrapping_add(1);
        let shuffled = owen_scramble_rev(self.index_reversed, key as u32);
        // A key for each dimension: distinct words, hashed again.
        let key = (key >> 32) as u32;
        let keys = [key, key ^ 0x9e37_79b9, key ^ 0x7f4a_7c15, key ^ 0xe17d_05ac];
        owen_scramble_int4_rev(point(shuffled).into(), hash_int4(keys.into()))
            .reverse_bits()
            .to_f32_norm()
    }

    pub(super) fn next_1d(&mut self) -> f32 {
        if self.singles.used > 3 {
            self.singles = Drawn {
                values: self.draw(),
                used: 0,
            };
        }
        let at = self.singles.used & 3;
        self.singles.used += 1;
        self.singles.values[at]
    }

    pub(super) fn next_2d(&mut self) -> Vec2 {
        if self.pairs.used > 2 {
            let values = self.draw();
            self.pairs = Drawn { values, used: 2 };
            return Vec2::new(values[0], values[1]);
        }
        let [_, _, x, y] = self.pairs.values;
        self.pairs.used = 4;
        Vec2::new(x, y)
    }
}
