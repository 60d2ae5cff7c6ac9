//! `sobol`: scrambled points of low discrepancy, and what stands for all other types that promise such.
//!
//! `pixelsamples` (integer, 16), rounded up to a power of two as pbrt-v3 does.
//!
//! The points are those of [`super::net`], 16 dimensions that belong together, scrambled by Owen's method:
//! every bit of a coordinate is flipped or not by all that stand before it, which keeps all their
//! spread and makes each number uniform. The hash that decides is that of Burley, "Practical Hash-based Owen
//! Scrambling", JCGT 9(4), 2020, improved by Vegdahl (crate `sobol_burley`). After 16 dimensions the next 16 begin with
//! indices shuffled by the same method: aligned runs of samples stay together, and the dimensions have no limit.
//!
//! Pairs are taken from sets of their own, two from each: film and lens point share four dimensions, or
//! film and first light point where there is no lens. Single numbers share sets too.
//!
//! Tried, as variance against this at 16, 64 and 256 samples (`docs/samplers.md`):
//! * Pairs of Sobol' points, each shuffled by itself: 1.6, 2.0, 3.3 times for a defocused picture, 0.9, 1.1, 1.3 for a
//!   box of bounces.
//! * Sobol's own dimensions up to 64 at once: 1.1, 0.9, 1.1 for the picture, 1.0, 1.2, 1.0 for the box.

use super::SamplerSpec;
use super::count::power_of_two;
use super::net::{SETS, point};
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
    /// Index in the order of the present 16 dimensions.
    shuffled: u32,
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
            shuffled: 0,
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
        let set = self.sets % SETS as u32;
        if set == 0 {
            let order = key as u32;
            self.shuffled = owen_scramble_rev(self.index_reversed, order).reverse_bits();
        }
        self.sets = self.sets.wrapping_add(1);
        // A key for each dimension: distinct words, hashed again.
        let key = (key >> 32) as u32;
        let keys = [
            key,
            key ^ 0x9e37_79b9,
            key ^ 0x7f4a_7c15,
            key ^ 0xe17d_05ac,
        ];
        owen_scramble_int4_rev(point(self.shuffled, set).into(), hash_int4(keys.into()))
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
