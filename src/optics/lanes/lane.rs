//! A bundle of numbers side by side.

use crate::optics::real::{Index, Mask, Number};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// `N` numbers in single precision, on which every operation acts one by one, each rounded as
/// IEEE 754 says: a lane holds the bits that an f32 alone would.
///
/// Plain loops of fixed length, all inlined, which the compiler turns into the vector instructions
/// of the function around them; that is what lets [`super::vectorize`] choose the instructions at
/// run time. `wide`'s types fix them when the program is built. Measured through the 11 surfaces of the
/// double Gauss on an AMD EPYC with AVX-512, ns a ray, 8 and 16 lanes: `wide` 34 and 26, these without
/// vector instructions beyond SSE2 36 and 27, with AVX2 29 and 18, with AVX-512 28 and 16. One loop
/// over the lanes around the whole of a surface, instead of one for each operation: 34 with AVX2 and 16 lanes,
/// and 129 with SSE2, where it is not vectorised at all.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct Lanes<const N: usize>(pub [f32; N]);

/// Answers for `N` lanes: all bits set for yes, none for no.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(align(32))]
pub struct LaneMask<const N: usize>(pub [u32; N]);

impl<const N: usize> Lanes<N> {
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(x: f32) -> Lanes<N> {
        Lanes([x; N])
    }

    /// The magnitude.
    #[inline(always)]
    pub fn abs(self) -> Lanes<N> {
        let mut r = self;
        for x in &mut r.0 {
            *x = x.abs();
        }
        r
    }

    /// Where `mask` says yes from `yes`, elsewhere from `no`.
    #[inline(always)]
    pub fn select(mask: LaneMask<N>, yes: Lanes<N>, no: Lanes<N>) -> Lanes<N> {
        let mut r = no;
        for i in 0..N {
            let bits = (yes.0[i].to_bits() & mask.0[i]) | (no.0[i].to_bits() & !mask.0[i]);
            r.0[i] = f32::from_bits(bits);
        }
        r
    }
}

impl<const N: usize> LaneMask<N> {
    /// Does lane `i` say yes?
    #[inline(always)]
    pub fn at(&self, i: usize) -> bool {
        self.0[i] != 0
    }

    /// How many lanes say yes.
    #[inline(always)]
    pub fn count(&self) -> u32 {
        self.0.iter().map(|x| x & 1).sum()
    }
}

impl<const N: usize> Mask for LaneMask<N> {
    const YES: LaneMask<N> = LaneMask([u32::MAX; N]);
    #[inline(always)]
    fn and(self, other: LaneMask<N>) -> LaneMask<N> {
        let mut r = self;
        for i in 0..N {
            r.0[i] &= other.0[i];
        }
        r
    }
    #[inline(always)]
    fn or(self, other: LaneMask<N>) -> LaneMask<N> {
        let mut r = self;
        for i in 0..N {
            r.0[i] |= other.0[i];
        }
        r
    }
    #[inline(always)]
    fn any(self) -> bool {
        let mut all = 0;
        for x in self.0 {
            all |= x;
        }
        all != 0
    }
}

macro_rules! lane_by_lane {
    ($($operation:ident $function:ident $symbol:tt),*) => {$(
        impl<const N: usize> $operation for Lanes<N> {
            type Output = Lanes<N>;
            #[inline(always)]
            fn $function(self, other: Lanes<N>) -> Lanes<N> {
                let mut r = self;
                for i in 0..N {
                    r.0[i] = self.0[i] $symbol other.0[i];
                }
                r
            }
        }
    )*};
}
lane_by_lane!(Add add +, Sub sub -, Mul mul *, Div div /);

impl<const N: usize> Neg for Lanes<N> {
    type Output = Lanes<N>;
    #[inline(always)]
    fn neg(self) -> Lanes<N> {
        let mut r = self;
        for x in &mut r.0 {
            *x = -*x;
        }
        r
    }
}

macro_rules! compare {
    ($($function:ident $symbol:tt),*) => {$(
        #[inline(always)]
        fn $function(self, base: f32) -> LaneMask<N> {
            let mut r = LaneMask([0; N]);
            for i in 0..N {
                r.0[i] = if self.0[i] $symbol base { u32::MAX } else { 0 };
            }
            r
        }
    )*};
}

impl<const N: usize> Number for Lanes<N> {
    type Base = f32;
    type Mask = LaneMask<N>;
    compare!(greater >, at_least >=, at_most <=);
    #[inline(always)]
    fn constant(base: f32) -> Lanes<N> {
        Lanes([base; N])
    }
    #[inline(always)]
    fn sqrt(self) -> Lanes<N> {
        let mut r = self;
        for x in &mut r.0 {
            *x = x.sqrt();
        }
        r
    }
    #[inline(always)]
    fn times(self, base: f32) -> Lanes<N> {
        self * Lanes([base; N])
    }
    #[inline(always)]
    fn plus(self, base: f32) -> Lanes<N> {
        self + Lanes([base; N])
    }
    #[inline(always)]
    fn finite(self) -> LaneMask<N> {
        // Infinity and NaN are no smaller than the largest number.
        self.abs().at_most(f32::MAX)
    }
}

impl<const N: usize> Index for Lanes<N> {
    type Place = [u32; N];
    #[inline(always)]
    fn place(self, last: usize) -> ([u32; N], Lanes<N>) {
        // Tables are shorter than 2^24, so that a place is exact as an f32.
        let last = last as u32;
        let mut place = [0; N];
        let mut rest = self;
        for (rest, place) in rest.0.iter_mut().zip(&mut place) {
            *place = (*rest as u32).min(last);
            *rest -= *place as f32;
        }
        (place, rest)
    }
    #[inline(always)]
    fn look_up<const K: usize>(
        table: &[f32],
        at: [([u32; N], usize); K],
        offset: usize,
    ) -> Lanes<N> {
        let mut r = Lanes([0.0; N]);
        for i in 0..N {
            let mut entry = offset;
            for (place, stride) in &at {
                entry += place[i] as usize * stride;
            }
            r.0[i] = table.get(entry).copied().unwrap_or(0.0);
        }
        r
    }
}
