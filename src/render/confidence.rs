//! How sure the error of an image is: a bound that holds although rendering stops where it is met.
//!
//! E² is a sum over pixels of s = ((p − q)/2)² / (m² + ε²), each a chi-squared variable of one degree of freedom times the
//! pixel's true variance. The sum is nearly one of ν degrees times E²/ν (F. E. Satterthwaite, "An Approximate
//! Distribution of Estimates of Variance Components", Biometrics Bulletin 2, 1946), so that E² ν / χ²(ν, r) is below the true
//! square with a probability of r. A render that looks k times would be wrong more often, by luck at one of the looks: the
//! k-th takes r = (1 − confidence) / (k (k + 1)), which all together add up to 1 − confidence, however many looks there are
//! (Boole's inequality; D. A. Darling and H. Robbins, "Confidence sequences for mean, variance, and median", PNAS 58, 1967).

use std::f64::consts::{E, TAU};

/// The error of an image, and how well it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Noise {
    /// The estimated relative error: see `Progressive::error`.
    pub(super) error: f64,
    /// Degrees of freedom of its square: with one pixel that has most of the noise, little more than one.
    pub(super) freedom: f64,
}

impl Noise {
    /// Of pixels, each with its squared relative error, summed over channels, as the halves' difference tells it and as its samples' scatter does.
    /// Either may be large by chance or small; the fewer degrees of freedom count.
    pub(super) fn of(pixels: impl Iterator<Item = [f64; 2]>) -> Option<Noise> {
        let (mut count, mut sums, mut squares) = (0.0, [0.0; 2], [0.0; 2]);
        for pixel in pixels {
            count += 1.0;
            for i in [0, 1] {
                sums[i] += pixel[i];
                squares[i] += pixel[i] * pixel[i];
            }
        }
        // Of three channels.
        let error = (sums[0] / (3.0 * count)).sqrt();
        let [of_differences, of_scatter] = [0, 1].map(|i| sums[i] * sums[i] / squares[i]);
        // No pixels, or no noise: what has not been sampled yet may be anything.
        (error.is_finite() && error > 0.0).then_some(Noise {
            error,
            // The square of a chi-squared variable of one degree of freedom is 3 on average.
            freedom: (3.0 * of_differences).min(of_scatter),
        })
    }

    /// What the error is below with this confidence, at the `look`-th of any number of looks, from 1.
    pub(super) fn bound(&self, confidence: f64, look: u32) -> f64 {
        let look = f64::from(look.max(1));
        let risk = (1.0 - confidence) / (look * (look + 1.0));
        self.error / lower_quantile_per_degree(self.freedom, risk).sqrt()
    }
}

/// χ²(ν, r) / ν: what a chi-squared variable of ν degrees of freedom is below with a small probability `r`, by Wilson and
/// Hilferty (M. Abramowitz and I. Stegun, "Handbook of Mathematical Functions", 26.4.17): within a few per cent from ten
/// degrees of freedom on. With fewer a value that is less: the density is less than without its exponential, so that the probability
/// of less than x is below (x/2)^(ν/2) / Γ(ν/2 + 1), and Stirling's formula is less than Γ.
fn lower_quantile_per_degree(freedom: f64, r: f64) -> f64 {
    if freedom < 10.0 {
        let half = 0.5 * freedom;
        let gamma = (TAU * half).sqrt() * (half / E).powf(half);
        return (r * gamma).powf(1.0 / half) / half;
    }
    let v = 2.0 / (9.0 * freedom);
    (1.0 - v - upper_normal_quantile(r) * v.sqrt())
        .max(0.0)
        .powi(3)
}

/// What a standard normal variable is above with a probability `r` below one half: 26.2.23 there, within 4.5e-4.
fn upper_normal_quantile(r: f64) -> f64 {
    let t = (-2.0 * r.clamp(f64::MIN_POSITIVE, 0.5).ln()).sqrt();
    let above = 2.515517 + t * (0.802853 + t * 0.010328);
    let below = 1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308));
    t - above / below
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables: χ²(10, 5 %) = 3.940, χ²(10, 0.5 %) = 2.156, χ²(100, 5 %) = 77.93, χ²(1000, 0.1 %) = 867.5; and with few
    /// degrees χ²(1, 5 %) = 0.00393, χ²(2, 1 %) = 0.0201, χ²(5, 0.5 %) = 0.412.
    #[test]
    fn quantiles_by_the_tables() {
        for (freedom, r, expected) in [
            (10.0, 0.05, 3.940),
            (10.0, 0.005, 2.156),
            (100.0, 0.05, 77.93),
            (1000.0, 0.001, 867.5),
        ] {
            let found = freedom * lower_quantile_per_degree(freedom, r);
            // The approximation's own error is largest at few degrees of freedom, far out: 2.9 % too little at (10, 0.5 %).
            assert!(
                (found / expected - 1.0f64).abs() < 0.03,
                "{found} {expected}"
            );
        }
        for (freedom, r, expected) in [
            (1.0, 0.05, 0.00393),
            (2.0, 0.01, 0.0201),
            (5.0, 0.005, 0.412),
        ] {
            let found = freedom * lower_quantile_per_degree(freedom, r);
            // Less, by what Stirling's formula lacks of Γ(1.5) and by the exponential.
            assert!(
                (0.7..1.0).contains(&(found / expected)),
                "{found} {expected}"
            );
        }
    }

    #[test]
    fn equal_pixels_have_a_degree_each() {
        let terms = [0.0, 3.0].map(|s| [s, 1.0]);
        let noise = Noise::of(terms.into_iter().cycle().take(300)).unwrap();
        assert!((noise.error - 0.5f64.sqrt()).abs() < 1e-12);
        // 3 (Σs)² / Σs² = 3 · 300 / 2, and the scatter says 300.
        assert_eq!(noise.freedom, 300.0);
        // 95 % at the first look: 2.5 % are left for it, 1.96 standard errors of 1/√(2 · 300); its square is the second order.
        let bound = noise.bound(0.95, 1) / noise.error;
        assert!((bound - 1.0 - 1.96 / 600f64.sqrt()).abs() < 0.01, "{bound}");
        assert!(noise.bound(0.95, 5) > noise.bound(0.95, 1));
    }

    #[test]
    fn one_bright_pixel_promises_little() {
        let dim = [[1.0, 1.0]; 50];
        let noise = Noise::of(dim.into_iter().chain([[0.0, 30.0]])).unwrap();
        // The scatter knows it although the halves agree by chance: (80)² / (50 + 900).
        assert!((noise.freedom - 6400.0 / 950.0).abs() < 1e-9);
        // Of 50 pixels alone it is 1.24 times.
        assert!(noise.bound(0.95, 1) > 2.0 * noise.error);
        assert!(Noise::of(std::iter::empty()).is_none());
        assert!(Noise::of([[0.0, 0.0]].into_iter()).is_none());
    }
}
