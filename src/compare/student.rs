//! Student's t distribution, computed with the incomplete beta function.

use libm::{erfc, lgamma};

/// Above this many degrees of freedom the normal distribution is used: its p-values are too small by a relative error
/// of about t⁴/4ν (Fisher 1925), 0.1 % at the t = 8 that is significant among a million pixels.
const NORMAL_FROM: f64 = 1e6;

/// The probability that |T| ≥ |t| for Student's distribution with `freedom` > 0 degrees of freedom (infinitely many:
/// the normal distribution): I_x(ν/2, 1/2) with x = ν/(ν + t²), DLMF 8.17.
///
/// 1 if `freedom` is not positive (nothing is known), 0 if `t` is infinite or NaN.
pub fn two_sided_p(t: f64, freedom: f64) -> f64 {
    if freedom.is_nan() || freedom <= 0.0 {
        return 1.0;
    }
    if !t.is_finite() {
        return 0.0;
    }
    if freedom >= NORMAL_FROM {
        return erfc(t.abs() * std::f64::consts::FRAC_1_SQRT_2);
    }
    let (a, b) = (freedom / 2.0, 0.5);
    // Beyond this the square would overflow; below its inverse, underflow.
    let t = t.abs().min(1e150);
    let ratio = t * t / freedom;
    if ratio == 0.0 {
        return 1.0;
    }
    // Both fractions directly from t: 1 − x would lose a small t to rounding.
    let (x, y) = (1.0 / (1.0 + ratio), ratio / (1.0 + ratio));
    let log_front = -a * ratio.ln_1p() + b * y.ln() + lgamma(a + b) - lgamma(a) - lgamma(b);
    // The continued fraction converges fast below this point; above it, that of the other tail is used.
    let p = if x < (a + 1.0) / (a + b + 2.0) {
        log_front.exp() * continued_fraction(x, a, b) / a
    } else {
        1.0 - log_front.exp() * continued_fraction(y, b, a) / b
    };
    p.clamp(0.0, 1.0)
}

/// The t with this two-sided probability: the inverse of [`two_sided_p`] in t. Infinite if nothing is known.
pub fn two_sided_t(p: f64, freedom: f64) -> f64 {
    if two_sided_p(1e150, freedom) > p {
        return f64::INFINITY;
    }
    // Bisection of the logarithm, to the last digits but few.
    let (mut low, mut high) = (-40.0f64, 500.0f64);
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        match two_sided_p(middle.exp2(), freedom) > p {
            true => low = middle,
            false => high = middle,
        }
    }
    high.exp2()
}

/// The continued fraction of DLMF 8.17.22, evaluated by the modified Lentz method (Thompson and
/// Barnett 1986).
fn continued_fraction(x: f64, a: f64, b: f64) -> f64 {
    // Replaces a zero denominator.
    const TINY: f64 = 1e-300;
    // Convergence takes about √max(a, b) terms: 700 at the largest ν that gets here.
    const TERMS: usize = 10_000;
    let away_from_zero = |v: f64| if v.abs() < TINY { TINY } else { v };
    let (mut c, mut d) = (1.0, 1.0 / away_from_zero(1.0 - (a + b) * x / (a + 1.0)));
    let mut value = d;
    for m in (1..TERMS).map(|m| m as f64) {
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut step = 1.0;
        for term in [even, odd] {
            d = 1.0 / away_from_zero(1.0 + term * d);
            c = away_from_zero(1.0 + term / c);
            step = c * d;
            value *= step;
        }
        if (step - 1.0).abs() < 1e-15 {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ContinuousCDF, StudentsT};

    #[test]
    fn quantiles_are_the_inverse() {
        for freedom in [0.7, 1.0, 7.3, 63.0, f64::INFINITY] {
            for p in [0.9, 0.05, 1e-3, 1e-9] {
                let t = two_sided_t(p, freedom);
                // Bisection ends at 2⁻⁵⁵ of 540 octaves; the tail of few degrees falls slowly, of many fast.
                assert!(
                    (two_sided_p(t, freedom) / p - 1.0).abs() < 1e-10,
                    "{freedom} {p}"
                );
            }
        }
        assert_eq!(two_sided_t(0.05, 0.0), f64::INFINITY);
        // Tables' 97.5 % of ten degrees of freedom, to its digits.
        assert!((two_sided_t(0.05, 10.0) - 2.228139).abs() < 5e-7);
    }

    #[test]
    fn agrees_with_statrs() {
        for freedom in [0.7, 1.0, 2.0, 7.3, 15.0, 63.0, 1000.0, 9.9e5] {
            let reference = StudentsT::new(0.0, 1.0, freedom).unwrap();
            for t in [0.0, 1e-3, 0.3, 1.0, 2.5, 6.0, 12.0] {
                let (p, q) = (two_sided_p(t, freedom), 2.0 * reference.cdf(-t));
                // Both subtract logarithms of the gamma function of ν/2, which lose about ν·1e-15.
                assert!(
                    (p - q).abs() <= q * (1e-10 + 1e-14 * freedom),
                    "t {t} ν {freedom}: {p} {q}"
                );
            }
        }
    }

    #[test]
    fn closed_forms() {
        // ν = 1 is the Cauchy distribution, ν = 2 has p = 1 − t/√(2 + t²).
        for t in [0.1f64, 1.0, 3.0, 30.0] {
            let cauchy = 1.0 - 2.0 * t.atan() / std::f64::consts::PI;
            assert!((two_sided_p(t, 1.0) - cauchy).abs() < 1e-13);
            assert!((two_sided_p(-t, 2.0) - (1.0 - t / (2.0 + t * t).sqrt())).abs() < 1e-13);
        }
    }

    #[test]
    fn runs_smoothly_into_the_normal_distribution() {
        for t in [0.1f64, 1.0, 4.0, 8.0] {
            let freedom = NORMAL_FROM * 0.999;
            let normal = two_sided_p(t, NORMAL_FROM);
            // Fisher's expansion to first order in 1/ν: 2 φ(t) t (t² + 1) / 4ν more than normal.
            let density = (-0.5 * t * t).exp() / std::f64::consts::TAU.sqrt();
            let more = 2.0 * density * t * (t * t + 1.0) / (4.0 * freedom);
            // The second order is about the square of the first; the logarithms of the gamma function, which are 1e7
            // and have 16 digits, lose 1e-8.
            let tolerance = normal * ((more / normal).powi(2) + 1e-8);
            assert!(
                (two_sided_p(t, freedom) - normal - more).abs() < tolerance,
                "t {t}"
            );
        }
    }

    #[test]
    fn edges() {
        assert_eq!(two_sided_p(0.0, 5.0), 1.0);
        assert_eq!(two_sided_p(f64::INFINITY, 5.0), 0.0);
        assert_eq!(two_sided_p(f64::NAN, 5.0), 0.0);
        assert_eq!(two_sided_p(3.0, 0.0), 1.0);
        assert!(two_sided_p(1e200, 15.0) < 1e-300);
        // p = 1 − 2t/π to first order, where the square of t alone would be lost next to 1.
        assert!(two_sided_p(1e-12, 1.0) < 1.0);
    }
}
