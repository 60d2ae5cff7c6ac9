//! The numbers a lens is traced with: f64, f32, and dual numbers that carry derivatives along.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// What tracing asks of a number. Lens data themselves are of the plain type `Base`, so that
/// multiplying a dual number by a curvature costs nothing for the curvature's derivative.
pub trait Real:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The plain floating-point type underneath.
    type Base: Plain;

    /// A constant.
    fn constant(base: Self::Base) -> Self;
    /// The value without derivatives.
    fn value(self) -> Self::Base;
    /// Square root; of a negative number: not a number.
    fn sqrt(self) -> Self;
    /// Product with a constant.
    fn times(self, base: Self::Base) -> Self;
    /// Sum with a constant.
    fn plus(self, base: Self::Base) -> Self;
}

/// f32 and f64.
pub trait Plain: Real<Base = Self> {
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// Rounds to this type.
    fn round_from(x: f64) -> Self;
    /// Neither infinite nor not a number.
    fn is_finite(self) -> bool;
}

macro_rules! plain {
    ($($t:ty)*) => {$(
        impl Real for $t {
            type Base = $t;
            fn constant(base: $t) -> $t { base }
            fn value(self) -> $t { self }
            fn sqrt(self) -> $t { <$t>::sqrt(self) }
            fn times(self, base: $t) -> $t { self * base }
            fn plus(self, base: $t) -> $t { self + base }
        }
        impl Plain for $t {
            const ZERO: $t = 0.0;
            const ONE: $t = 1.0;
            fn round_from(x: f64) -> $t { x as $t }
            fn is_finite(self) -> bool { <$t>::is_finite(self) }
        }
    )*};
}
plain!(f32 f64);

/// A value and its derivatives by two parameters, exact to rounding (forward-mode differentiation:
/// Griewank and Walther, *Evaluating Derivatives*, 2008, chapter 3). Compares by value.
#[derive(Clone, Copy, Debug)]
pub struct Dual {
    /// The value.
    pub value: f64,
    /// Derivatives by the first and by the second parameter.
    pub by: [f64; 2],
}

impl Dual {
    /// The parameter number `i` (0 or 1) itself, at `value`.
    pub fn parameter(value: f64, i: usize) -> Dual {
        let mut by = [0.0; 2];
        by[i] = 1.0;
        Dual { value, by }
    }

    fn map(self, value: f64, slope: f64) -> Dual {
        Dual {
            value,
            by: [self.by[0] * slope, self.by[1] * slope],
        }
    }
}

impl PartialEq for Dual {
    fn eq(&self, other: &Dual) -> bool {
        self.value == other.value
    }
}

impl PartialOrd for Dual {
    fn partial_cmp(&self, other: &Dual) -> Option<std::cmp::Ordering> {
        self.value.partial_cmp(&other.value)
    }
}

impl Add for Dual {
    type Output = Dual;
    fn add(self, b: Dual) -> Dual {
        Dual {
            value: self.value + b.value,
            by: [self.by[0] + b.by[0], self.by[1] + b.by[1]],
        }
    }
}

impl Sub for Dual {
    type Output = Dual;
    fn sub(self, b: Dual) -> Dual {
        Dual {
            value: self.value - b.value,
            by: [self.by[0] - b.by[0], self.by[1] - b.by[1]],
        }
    }
}

#[expect(
    clippy::suspicious_arithmetic_impl,
    reason = "the product and quotient rules"
)]
impl Mul for Dual {
    type Output = Dual;
    fn mul(self, b: Dual) -> Dual {
        let by = |i: usize| self.by[i] * b.value + self.value * b.by[i];
        Dual {
            value: self.value * b.value,
            by: [by(0), by(1)],
        }
    }
}

#[expect(
    clippy::suspicious_arithmetic_impl,
    reason = "the product and quotient rules"
)]
impl Div for Dual {
    type Output = Dual;
    fn div(self, b: Dual) -> Dual {
        let value = self.value / b.value;
        let by = |i: usize| (self.by[i] - value * b.by[i]) / b.value;
        Dual {
            value,
            by: [by(0), by(1)],
        }
    }
}

impl Neg for Dual {
    type Output = Dual;
    fn neg(self) -> Dual {
        self.map(-self.value, -1.0)
    }
}

impl Real for Dual {
    type Base = f64;
    fn constant(base: f64) -> Dual {
        Dual {
            value: base,
            by: [0.0; 2],
        }
    }
    fn value(self) -> f64 {
        self.value
    }
    fn sqrt(self) -> Dual {
        let root = self.value.sqrt();
        self.map(root, 0.5 / root)
    }
    fn times(self, base: f64) -> Dual {
        self.map(self.value * base, base)
    }
    fn plus(self, base: f64) -> Dual {
        Dual {
            value: self.value + base,
            by: self.by,
        }
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
