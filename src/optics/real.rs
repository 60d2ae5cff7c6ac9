//! The numbers a lens is traced with: f64, f32, bundles of f32 side by side, and dual numbers that
//! carry derivatives along.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

/// What tracing asks of a number: one of them, or a bundle of them side by side
/// ([`super::lanes::Lanes`]). Lens data themselves are of the plain type `Base`, so that
/// multiplying a dual number by a curvature costs nothing for the curvature's derivative.
///
/// Implementations are `#[inline(always)]` throughout: a bundle's arithmetic must end up inside the
/// function that was compiled for the processor's widest registers (see [`super::lanes`]).
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The plain floating-point type underneath.
    type Base: Plain;
    /// What a comparison gives: one answer, or one for each of a bundle.
    type Mask: Mask;

    /// A constant.
    fn constant(base: Self::Base) -> Self;
    /// Square root; of a negative number: not a number.
    fn sqrt(self) -> Self;
    /// Product with a constant.
    fn times(self, base: Self::Base) -> Self;
    /// Sum with a constant.
    fn plus(self, base: Self::Base) -> Self;
    /// True where it is larger than `base`; like every comparison, false for what is not a number.
    fn greater(self, base: Self::Base) -> Self::Mask;
    /// True where it is `base` or larger.
    fn at_least(self, base: Self::Base) -> Self::Mask;
    /// True where it is `base` or smaller.
    fn at_most(self, base: Self::Base) -> Self::Mask;
    /// True where it is neither infinite nor not a number.
    fn finite(self) -> Self::Mask;
}

/// Numbers that say where in a table to look: one place, or one for each of a bundle.
pub trait Index: Number {
    /// Places in a table.
    type Place: Copy;
    /// The whole part as a place from 0 to `last`, and what is left beyond it. What is not a number
    /// looks at 0.
    fn place(self, last: usize) -> (Self::Place, Self);
    /// The `M` entries that begin at the sum of place · stride over `at`, plus `offset`; 0 where some lie beyond the table's end.
    fn row<const K: usize, const M: usize>(
        table: &[Self::Base],
        at: [(Self::Place, usize); K],
        offset: usize,
    ) -> [Self; M];
    /// `yes` where `mask` says so, elsewhere `no`: both are known, and nothing branches.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// The magnitude.
    #[inline(always)]
    fn abs(self) -> Self {
        Self::select(self.at_least(Self::Base::ZERO), self, -self)
    }
}

/// The answers of a comparison.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> {
    /// Yes throughout.
    const YES: Self;
    /// Returns `true` if any lane is true.
    fn any(self) -> bool;
}

impl Mask for bool {
    const YES: bool = true;
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
}

/// One number, not a bundle.
pub trait Real: Number<Mask = bool> {}

impl<T: Number<Mask = bool>> Real for T {}

/// f32 and f64.
pub trait Plain: Real<Base = Self> + Index + PartialOrd {
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// Distance from 1 to the next larger number.
    const EPSILON: Self;
    /// Rounds to this type.
    fn round_from(x: f64) -> Self;
    /// As an f64, exactly.
    fn to_f64(self) -> f64;
}

macro_rules! plain {
    ($($t:ty)*) => {$(
        impl Number for $t {
            type Base = $t;
            type Mask = bool;
            #[inline(always)]
            fn constant(base: $t) -> $t { base }
            #[inline(always)]
            fn sqrt(self) -> $t { <$t>::sqrt(self) }
            #[inline(always)]
            fn times(self, base: $t) -> $t { self * base }
            #[inline(always)]
            fn plus(self, base: $t) -> $t { self + base }
            #[inline(always)]
            fn greater(self, base: $t) -> bool { self > base }
            #[inline(always)]
            fn at_least(self, base: $t) -> bool { self >= base }
            #[inline(always)]
            fn at_most(self, base: $t) -> bool { self <= base }
            #[inline(always)]
            fn finite(self) -> bool { <$t>::is_finite(self) }
        }
        impl Index for $t {
            type Place = usize;
            #[inline(always)]
            fn place(self, last: usize) -> (usize, $t) {
                // The cast stops at the ends, and takes what is not a number for 0.
                let place = (self as usize).min(last);
                (place, self - place as $t)
            }
            #[inline(always)]
            fn row<const K: usize, const M: usize>(
                table: &[$t],
                at: [(usize, usize); K],
                offset: usize,
            ) -> [$t; M] {
                let mut entry = offset;
                for (place, stride) in at {
                    entry += place * stride;
                }
                let row = table.get(entry..).and_then(|rest| rest.first_chunk());
                row.copied().unwrap_or([0.0; M])
            }
            #[inline(always)]
            fn select(mask: bool, yes: $t, no: $t) -> $t { if mask { yes } else { no } }
        }
        impl Plain for $t {
            const ZERO: $t = 0.0;
            const ONE: $t = 1.0;
            const EPSILON: $t = <$t>::EPSILON;
            #[inline(always)]
            fn round_from(x: f64) -> $t { x as $t }
            #[inline(always)]
            fn to_f64(self) -> f64 { f64::from(self) }
        }
    )*};
}
plain!(f32 f64);

/// A value and its derivatives by two parameters, exact to rounding (forward-mode differentiation:
/// Griewank and Walther, *Evaluating Derivatives*, 2008, chapter 3). Compares by value.
#[derive(Clone, Copy, Debug)]
pub struct Dual<V = f64> {
    /// The value.
    pub value: V,
    /// Derivatives by the first and by the second parameter.
    pub by: [V; 2],
}

impl<V: Number> Dual<V> {
    #[inline(always)]
    fn new(value: V, by_x: V, by_y: V) -> Dual<V> {
        let by = [by_x, by_y];
        Dual { value, by }
    }

    /// The parameter number `i` (0 or 1) itself, at `value`.
    #[inline(always)]
    pub fn parameter(value: V, i: usize) -> Dual<V> {
        let mut by = [V::constant(V::Base::ZERO); 2];
        by[i] = V::constant(V::Base::ONE);
        Dual { value, by }
    }

    /// A value that depends on neither parameter.
    #[inline(always)]
    pub fn fixed(value: V) -> Dual<V> {
        let zero = V::constant(V::Base::ZERO);
        Dual::new(value, zero, zero)
    }
}

impl<V: Number> Add for Dual<V> {
    type Output = Dual<V>;
    #[inline(always)]
    fn add(self, b: Dual<V>) -> Dual<V> {
        Dual::new(
            self.value + b.value,
            self.by[0] + b.by[0],
            self.by[1] + b.by[1],
        )
    }
}

impl<V: Number> Sub for Dual<V> {
    type Output = Dual<V>;
    #[inline(always)]
    fn sub(self, b: Dual<V>) -> Dual<V> {
        Dual::new(
            self.value - b.value,
            self.by[0] - b.by[0],
            self.by[1] - b.by[1],
        )
    }
}

impl<V: Number> Mul for Dual<V> {
    type Output = Dual<V>;
    #[inline(always)]
    fn mul(self, b: Dual<V>) -> Dual<V> {
        let by_x = self.by[0] * b.value + self.value * b.by[0];
        let by_y = self.by[1] * b.value + self.value * b.by[1];
        Dual::new(self.value * b.value, by_x, by_y)
    }
}

impl<V: Number> Div for Dual<V> {
    type Output = Dual<V>;
    #[inline(always)]
    fn div(self, b: Dual<V>) -> Dual<V> {
        let value = self.value / b.value;
        let inverse = V::constant(V::Base::ONE) / b.value;
        let by_x = (self.by[0] - value * b.by[0]) * inverse;
        let by_y = (self.by[1] - value * b.by[1]) * inverse;
        Dual::new(value, by_x, by_y)
    }
}

impl<V: Number> Neg for Dual<V> {
    type Output = Dual<V>;
    #[inline(always)]
    fn neg(self) -> Dual<V> {
        Dual::new(-self.value, -self.by[0], -self.by[1])
    }
}

impl<V: Number> Number for Dual<V> {
    type Base = V::Base;
    type Mask = V::Mask;
    #[inline(always)]
    fn constant(base: V::Base) -> Dual<V> {
        Dual::fixed(V::constant(base))
    }
    #[inline(always)]
    fn sqrt(self) -> Dual<V> {
        let root = self.value.sqrt();
        let slope = V::constant(V::Base::ONE) / (root + root);
        Dual::new(root, self.by[0] * slope, self.by[1] * slope)
    }
    #[inline(always)]
    fn times(self, base: V::Base) -> Dual<V> {
        let [by_x, by_y] = self.by;
        Dual::new(self.value.times(base), by_x.times(base), by_y.times(base))
    }
    #[inline(always)]
    fn plus(self, base: V::Base) -> Dual<V> {
        Dual {
            value: self.value.plus(base),
            ..self
        }
    }
    #[inline(always)]
    fn greater(self, base: V::Base) -> V::Mask {
        self.value.greater(base)
    }
    #[inline(always)]
    fn at_least(self, base: V::Base) -> V::Mask {
        self.value.at_least(base)
    }
    #[inline(always)]
    fn at_most(self, base: V::Base) -> V::Mask {
        self.value.at_most(base)
    }
    #[inline(always)]
    fn finite(self) -> V::Mask {
        self.value.finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dual_numbers_differentiate() {
        let (x, y) = (Dual::parameter(1.3, 0), Dual::parameter(-0.7, 1));
        // f = √(x²+3) y / (x − y) ; f_x = f (x/(x²+3) − 1/(x−y)) ; f_y = f (1/y + 1/(x−y)).
        let f = (x * x).plus(3.0).sqrt() * y / (x - y);
        let expected = (1.3f64 * 1.3 + 3.0).sqrt() * -0.7 / 2.0;
        assert!((f.value - expected).abs() < 1e-15);
        assert!((f.by[0] - expected * (1.3 / (1.3 * 1.3 + 3.0) - 0.5)).abs() < 1e-15);
        assert!((f.by[1] - expected * (-1.0 / 0.7 + 0.5)).abs() < 1e-15);
        assert!((-x).times(2.0).by[0] == -2.0);
    }
}
