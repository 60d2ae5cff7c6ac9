//! Multiple-testing corrections: many tests, one false-alarm rate.

/// How the false-alarm rate of one comparison is divided among its tests.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Correction {
    /// Holm's step-down form of the Bonferroni correction (S. Holm, "A simple sequentially rejective multiple test
    /// procedure", Scand. J. Statist. 6, 1979). Valid however the tests depend on each other: overlapping blocks,
    /// channels that share their paths.
    #[default]
    Holm,
    /// The same steps with Šidák's bound 1 − (1 − p)ⁿ (Z. Šidák, J. Am. Stat. Assoc. 62, 1967). Exact for independent
    /// tests, and proven for two-sided tests of jointly normal variables however they correlate. Slightly more
    /// powerful, by a relative difference of less than α.
    Sidak,
}

impl Correction {
    /// Upper bound on the probability that the smallest of `tests` p-values is as small as `p`.
    pub fn adjust(self, p: f64, tests: usize) -> f64 {
        match self {
            Correction::Holm => (p * tests as f64).min(1.0),
            // 1 − (1 − p)^tests without cancellation.
            Correction::Sidak => -(tests as f64 * (-p).ln_1p()).exp_m1(),
        }
    }

    /// The significance level of each of `tests` tests for a family-wise level of `alpha`: the inverse of
    /// [`adjust`](Self::adjust).
    pub fn share(self, alpha: f64, tests: usize) -> f64 {
        let tests = tests.max(1) as f64;
        match self {
            Correction::Holm => alpha / tests,
            Correction::Sidak => -((-alpha).ln_1p() / tests).exp_m1(),
        }
    }

    /// The number of `tests` hypotheses that are rejected at a family-wise error rate of `alpha`. `smallest` holds the
    /// p-values, in any order; those above `alpha`, which are never rejected, may be missing.
    pub fn rejected(self, mut smallest: Vec<f64>, tests: usize, alpha: f64) -> usize {
        smallest.sort_by(f64::total_cmp);
        let steps = smallest.iter().enumerate();
        // The kth smallest is compared with the level for the remaining tests.
        let accepted = |(k, &p): (usize, &f64)| p >= self.share(alpha, tests.saturating_sub(k));
        steps.clone().position(accepted).unwrap_or(smallest.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_the_inverse_of_adjusted_values() {
        for correction in [Correction::Holm, Correction::Sidak] {
            for alpha in [1e-9, 1e-3, 0.3] {
                for tests in [1, 7, 36_000_000] {
                    let back = correction.adjust(correction.share(alpha, tests), tests);
                    assert!(
                        (back - alpha).abs() < 1e-12 * alpha + 1e-15,
                        "{correction:?} {back}"
                    );
                }
            }
        }
    }

    /// An example in the style of Holm's: with four tests at 5 %, the levels are 0.05/4 = 0.0125, 0.05/3 = 0.0167 and
    /// 0.05/2 = 0.025 in turn; Bonferroni would stop after the first.
    #[test]
    fn stepping_down_by_hand() {
        let p = vec![0.03, 0.01, 0.016, 0.9];
        assert_eq!(Correction::Holm.rejected(p.clone(), 4, 0.05), 2);
        assert_eq!(Correction::Holm.rejected(p[..3].to_vec(), 4, 0.05), 2);
        assert_eq!(Correction::Sidak.rejected(p, 4, 0.05), 2);
        assert_eq!(Correction::Holm.rejected(vec![0.0125], 4, 0.05), 0);
        // Between the two bounds: 1 − 0.95^(1/4) = 0.01274.
        assert_eq!(Correction::Sidak.rejected(vec![0.0126], 4, 0.05), 1);
        assert_eq!(Correction::Holm.rejected(vec![], 4, 0.05), 0);
    }
}
