//! Bundles of numbers side by side.

use crate::optics::real::{Index, Mask, Number};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

/// Does the same for every lane. The end is tested after each, not before: thousands of these loops are inlined into one
/// function, and those with the test in front would each have to be turned around, which takes the compiler longer than all else.
#[inline(always)]
fn for_each<const N: usize>(mut f: impl FnMut(usize)) {
    const { assert!(N > 0) };
    let mut lane = 0;
    loop {
        f(lane);
        lane += 1;
        if lane == N {
            return;
        }
    }
}

/// Makes the bundle `$lanes` of `$float`s with its answers `$mask` of `$bits`; `$digits` is the number of bits
/// that a `$float` has for a fraction.
macro_rules! bundle {
    ($(#[$doc:meta])* $lanes:ident, $mask:ident, $float:ident, $bits:ident, $digits:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[repr(align(32))]
        pub struct $lanes<const N: usize>(pub [$float; N]);

        /// Answers for `N` lanes: all bits set for yes, none for no.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(align(32))]
        pub struct $mask<const N: usize>(pub [$bits; N]);

        impl<const N: usize> $lanes<N> {
            /// The same number in every lane.
            #[inline(always)]
            pub fn splat(x: $float) -> $lanes<N> {
                $lanes([x; N])
            }

            #[inline(always)]
            fn each(mut self, f: impl Fn($float) -> $float) -> $lanes<N> {
                for_each::<N>(|i| self.0[i] = f(self.0[i]));
                self
            }
        }

        impl<const N: usize> $mask<N> {
            /// Returns `true` if lane `i` is true.
            #[inline(always)]
            pub fn at(&self, i: usize) -> bool {
                self.0[i] != 0
            }

            /// How many lanes say yes.
            #[inline(always)]
            pub fn count(&self) -> u32 {
                self.0.iter().map(|x| (x & 1) as u32).sum()
            }
        }

        impl<const N: usize> Mask for $mask<N> {
            const YES: $mask<N> = $mask([$bits::MAX; N]);
            #[inline(always)]
            fn any(self) -> bool {
                let mut all = 0;
                for_each::<N>(|i| all |= self.0[i]);
                all != 0
            }
        }

        bundle!(each $mask: BitAnd bitand &, BitOr bitor |);
        bundle!(each $lanes: Add add +, Sub sub -, Mul mul *, Div div /);

        impl<const N: usize> Neg for $lanes<N> {
            type Output = $lanes<N>;
            #[inline(always)]
            fn neg(self) -> $lanes<N> {
                self.each(|x| -x)
            }
        }

        impl<const N: usize> Number for $lanes<N> {
            type Base = $float;
            type Mask = $mask<N>;
            bundle!(compare $mask $float $bits: greater >, at_least >=, at_most <=);
            #[inline(always)]
            fn constant(base: $float) -> $lanes<N> {
                $lanes([base; N])
            }
            #[inline(always)]
            fn sqrt(self) -> $lanes<N> {
                self.each($float::sqrt)
            }
            #[inline(always)]
            fn times(self, base: $float) -> $lanes<N> {
                self * $lanes([base; N])
            }
            #[inline(always)]
            fn plus(self, base: $float) -> $lanes<N> {
                self + $lanes([base; N])
            }
            #[inline(always)]
            fn finite(self) -> $mask<N> {
                // Infinity and NaN are no smaller than the largest number.
                self.abs().at_most($float::MAX)
            }
        }

        impl<const N: usize> Index for $lanes<N> {
            type Place = [$bits; N];
            #[inline(always)]
            fn place(self, last: usize) -> ([$bits; N], $lanes<N>) {
                // Adding 2^23 (for f32) leaves no bits for a fraction: what it rounds to is the nearest whole number, in the
                // lowest bits, and in three vector instructions where a conversion that minds NaN takes eight or
                // so. Tables are shorter than 2^22, where this is exact.
                const WHOLE: $float = (1u64 << $digits) as $float;
                let last = last.min(1 << 22) as $float;
                let mut place = [0; N];
                let mut rest = self;
                for_each::<N>(|i| {
                    let x = self.0[i];
                    // What is not a number is not greater than 0.
                    let x = if x > 0.0 { x } else { 0.0 };
                    let x = if x < last { x } else { last };
                    let nearest = x + WHOLE;
                    let above = if nearest - WHOLE > x { 1.0 } else { 0.0 };
                    let below = nearest - above;
                    place[i] = below.to_bits() & ((1 << $digits) - 1);
                    rest.0[i] = self.0[i] - (below - WHOLE);
                });
                (place, rest)
            }
            #[inline(always)]
            fn row<const K: usize, const M: usize>(
                table: &[$float],
                at: [([$bits; N], usize); K],
                offset: usize,
            ) -> [$lanes<N>; M] {
                let mut r = [$lanes([0.0; N]); M];
                for_each::<N>(|i| {
                    let mut entry = offset;
                    for (place, stride) in &at {
                        entry += place[i] as usize * stride;
                    }
                    if let Some(row) = table.get(entry..).and_then(|rest| rest.first_chunk::<M>()) {
                        for (r, x) in r.iter_mut().zip(row) {
                            r.0[i] = *x;
                        }
                    }
                });
                r
            }
            #[inline(always)]
            fn select(mask: $mask<N>, yes: $lanes<N>, no: $lanes<N>) -> $lanes<N> {
                let mut r = no;
                for_each::<N>(|i| {
                    let bits = (yes.0[i].to_bits() & mask.0[i]) | (no.0[i].to_bits() & !mask.0[i]);
                    r.0[i] = $float::from_bits(bits);
                });
                r
            }
            #[inline(always)]
            fn abs(self) -> $lanes<N> {
                self.each($float::abs)
            }
        }
    };
    (each $lanes:ident: $($operation:ident $function:ident $symbol:tt),*) => {$(
        impl<const N: usize> $operation for $lanes<N> {
            type Output = $lanes<N>;
            #[inline(always)]
            fn $function(self, other: $lanes<N>) -> $lanes<N> {
                let mut r = self;
                for_each::<N>(|i| r.0[i] = self.0[i] $symbol other.0[i]);
                r
            }
        }
    )*};
    (compare $mask:ident $float:ident $bits:ident: $($function:ident $symbol:tt),*) => {$(
        #[inline(always)]
        fn $function(self, base: $float) -> $mask<N> {
            let mut r = $mask([0; N]);
            for_each::<N>(|i| r.0[i] = if self.0[i] $symbol base { $bits::MAX } else { 0 });
            r
        }
    )*};
}

bundle! {
    /// `N` numbers in single precision, on which every operation acts one by one, each rounded as
    /// IEEE 754 says: a lane holds the bits that an f32 alone would.
    ///
    /// Plain loops of fixed length, all inlined, which the compiler turns into the vector instructions
    /// of the function around them; that is what lets `crate::math::instruction_set::vectorize` choose the instructions at
    /// run time. `wide`'s types fix them when the program is built. Measured through the 11 surfaces of the
    /// double Gauss on an AMD EPYC with AVX-512, ns a ray, 8 and 16 lanes: `wide` 34 and 26, these without
    /// vector instructions beyond SSE2 36 and 27, with AVX2 29 and 18, with AVX-512 28 and 16. One loop
    /// over the lanes around the whole of a surface, instead of one for each operation: 34 with AVX2 and 16 lanes,
    /// and 129 with SSE2, where it is not vectorised at all.
    Lanes, LaneMask, f32, u32, 23
}

bundle! {
    /// `N` numbers in double precision, like [`Lanes`]: for measuring a lens before the first ray is made, where
    /// stops of a micrometer must be found.
    Doubles, DoubleMask, f64, u64, 52
}
