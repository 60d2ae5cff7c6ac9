//! The `wide` crate's bundles as numbers to trace with: what [`super::Lanes`] are measured against,
//! in speed and to the bit. Their instructions are fixed when the crate is built.

use crate::optics::real::{Mask, Number};
use wide::{f32x8, f32x16};

macro_rules! wide_number {
    ($($t:ident $n:literal),*) => {$(
        impl Mask for $t {
            const YES: $t = $t::new([f32::from_bits(u32::MAX); $n]);
            #[inline(always)]
            fn and(self, other: $t) -> $t { self & other }
            #[inline(always)]
            fn or(self, other: $t) -> $t { self | other }
            #[inline(always)]
            fn any(self) -> bool { $t::any(self) }
        }

        impl Number for $t {
            type Base = f32;
            type Mask = $t;
            #[inline(always)]
            fn constant(base: f32) -> $t { $t::splat(base) }
            #[inline(always)]
            fn sqrt(self) -> $t { $t::sqrt(self) }
            #[inline(always)]
            fn times(self, base: f32) -> $t { self * $t::splat(base) }
            #[inline(always)]
            fn plus(self, base: f32) -> $t { self + $t::splat(base) }
            #[inline(always)]
            fn greater(self, base: f32) -> $t { self.simd_gt($t::splat(base)) }
            #[inline(always)]
            fn at_least(self, base: f32) -> $t { self.simd_ge($t::splat(base)) }
            #[inline(always)]
            fn at_most(self, base: f32) -> $t { self.simd_le($t::splat(base)) }
            #[inline(always)]
            fn finite(self) -> $t { self.abs().simd_le($t::splat(f32::MAX)) }
        }
    )*};
}
wide_number!(f32x8 8, f32x16 16);
