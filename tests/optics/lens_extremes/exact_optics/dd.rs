//! Numbers of 32 digits: the unevaluated sum of two f64 (Dekker, Numerische Mathematik 18, 1971; Hida, Li and
//! Bailey, ARITH-15, 2001).

use std::ops::{Add, Div, Mul, Neg, Sub};

/// `hi + lo`, |lo| at most half a unit in the last place of `hi`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dd {
    pub hi: f64,
    pub lo: f64,
}

impl From<f64> for Dd {
    fn from(x: f64) -> Dd {
        Dd { hi: x, lo: 0.0 }
    }
}

impl Dd {
    pub(crate) const ZERO: Dd = Dd { hi: 0.0, lo: 0.0 };
    pub(crate) const ONE: Dd = Dd { hi: 1.0, lo: 0.0 };

    /// The exact sum of two f64.
    fn sum(a: f64, b: f64) -> Dd {
        let hi = a + b;
        let part = hi - a;
        Dd {
            hi,
            lo: (a - (hi - part)) + (b - part),
        }
    }

    /// The exact product of two f64.
    fn product(a: f64, b: f64) -> Dd {
        let hi = a * b;
        Dd {
            hi,
            lo: a.mul_add(b, -hi),
        }
    }

    pub(crate) fn sqrt(self) -> Dd {
        if self.hi <= 0.0 {
            return Dd::ZERO;
        }
        // One step of Newton's method doubles the digits of the f64 root.
        let root = self.hi.sqrt();
        let rest = self - Dd::product(root, root);
        Dd::sum(root, rest.hi / (2.0 * root))
    }
}

impl Add for Dd {
    type Output = Dd;
    fn add(self, b: Dd) -> Dd {
        let hi = Dd::sum(self.hi, b.hi);
        let lo = Dd::sum(self.lo, b.lo);
        let first = Dd::sum(hi.hi, hi.lo + lo.hi);
        Dd::sum(first.hi, first.lo + lo.lo)
    }
}

impl Neg for Dd {
    type Output = Dd;
    fn neg(self) -> Dd {
        Dd {
            hi: -self.hi,
            lo: -self.lo,
        }
    }
}

impl Sub for Dd {
    type Output = Dd;
    fn sub(self, b: Dd) -> Dd {
        self + -b
    }
}

impl Mul for Dd {
    type Output = Dd;
    fn mul(self, b: Dd) -> Dd {
        let p = Dd::product(self.hi, b.hi);
        Dd::sum(p.hi, p.lo + (self.hi * b.lo + self.lo * b.hi))
    }
}

impl Div for Dd {
    type Output = Dd;
    fn div(self, b: Dd) -> Dd {
        let first = self.hi / b.hi;
        let rest = self - b * Dd::from(first);
        let second = rest.hi / b.hi;
        let rest = rest - b * Dd::from(second);
        Dd::sum(first, second) + Dd::from(rest.hi / b.hi)
    }
}
