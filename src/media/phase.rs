//! The Henyey–Greenstein phase function (Henyey and Greenstein 1941; Pharr, Jakob and Humphreys 2016, §11.2 and
//! §15.2.3): how a medium scatters light.

use crate::math::frame::coordinate_system;
use crate::math::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, PI};

/// Maximum absolute mean cosine. At 1 all light continues straight, which no density can represent; at 0.9999 it is
/// deflected by some thousandths of a radian.
const LARGEST_MEAN_COSINE: f32 = 0.9999;

/// The Henyey–Greenstein phase function with mean cosine `g`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HenyeyGreenstein {
    /// |g|: how narrow the lobe is.
    sharpness: f32,
    /// −1 for forward scattering, 1 for backward: `wo` times this is the lobe's axis.
    side: f32,
}

impl Default for HenyeyGreenstein {
    /// Isotropic scattering.
    fn default() -> Self {
        HenyeyGreenstein::new(0.0)
    }
}

impl HenyeyGreenstein {
    /// `g` ranges from −1 (backward) over 0 (isotropic) to 1 (forward); it is clamped to ±0.9999, and NaN counts as 0.
    pub fn new(g: f32) -> HenyeyGreenstein {
        let g = if g.is_nan() { 0.0 } else { g };
        HenyeyGreenstein {
            sharpness: g.abs().min(LARGEST_MEAN_COSINE),
            side: if g < 0.0 { 1.0 } else { -1.0 },
        }
    }

    /// Value, and density per steradian, for light from `wi` that is scattered to `wo`. Both are unit vectors that
    /// point away from the scattering point.
    pub fn value(&self, wo: Vec3, wi: Vec3) -> f32 {
        // 1 − cos of the angle to the lobe's axis, without cancellation near the axis.
        let versine = 0.5 * (self.side * wo - wi).length_squared();
        self.density(versine)
    }

    fn density(&self, versine: f32) -> f32 {
        let a = self.sharpness;
        // 1 + a² − 2a cos, again without cancellation.
        let below = (1.0 - a) * (1.0 - a) + 2.0 * a * versine;
        0.25 * FRAC_1_PI * (1.0 - a) * (1.0 + a) / (below * below.sqrt())
    }

    /// Samples an incident direction by `u` in [0, 1)² with the density [`HenyeyGreenstein::value`]: the weight of the
    /// sample is 1.
    pub fn sample(&self, wo: Vec3, u: Vec2) -> (Vec3, f32) {
        let a = self.sharpness;
        // The inverse of the distribution (equation 15.22 there), solved for 1 − cos.
        let x = 1.0 - a + 2.0 * a * u.x;
        let s = (1.0 - a) * (1.0 + a) / x;
        let versine = ((1.0 - a) * (1.0 - u.x) * (s + 1.0 - a) / x).clamp(0.0, 2.0);
        let sin = (versine * (2.0 - versine)).sqrt();
        let (sin_phi, cos_phi) = (2.0 * PI * u.y).sin_cos();
        let axis = self.side * wo;
        let (s, t) = coordinate_system(axis);
        let wi = axis * (1.0 - versine) + (s * cos_phi + t * sin_phi) * sin;
        (wi, self.density(versine))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{mix2, unit_float};
    use statrs::distribution::{ChiSquared, ContinuousCDF};

    const WO: Vec3 = Vec3::new(0.36, -0.48, 0.8);

    fn numbers(i: u64) -> Vec2 {
        Vec2::new(unit_float(mix2(i, 1)), unit_float(mix2(i, 2)))
    }

    /// ∫ p dω and ∫ p cosθ dω, where θ is the deflection angle, by the midpoint rule in the square root of 1 − cos.
    fn moments(phase: &HenyeyGreenstein) -> (f64, f64) {
        let n = 200_000;
        let (s, _) = coordinate_system(WO);
        let (mut total, mut mean) = (0.0, 0.0);
        for i in 0..n {
            let root = (f64::from(i) + 0.5) / f64::from(n) * 2f64.sqrt();
            let cos = 1.0 - root * root;
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            // On the side of the peak the angle is small and cos near 1; on either side the direction is computed from
            // sine and cosine alike.
            for half in [1.0, -1.0] {
                let turned = half * cos;
                let wi = (-WO.as_dvec3() * turned + s.as_dvec3() * sin).normalize();
                let p = f64::from(phase.value(WO, wi.as_vec3()));
                // dω = 2π dcos, dcos = 2 root droot; each half of the sphere once.
                let weight = if cos >= 0.0 {
                    4.0 * std::f64::consts::PI * root * 2f64.sqrt() / f64::from(n)
                } else {
                    0.0
                };
                total += p * weight;
                mean += p * turned * weight;
            }
        }
        (total, mean)
    }

    #[test]
    fn is_normalized_and_has_its_mean_cosine() {
        for g in [-0.95f32, -0.5, 0.0, 1e-5, 0.3, 0.9, 0.99] {
            let (total, mean) = moments(&HenyeyGreenstein::new(g));
            // Single-precision directions: their angle to the axis is good to 1e-7, of a lobe some
            // (1 − |g|) wide.
            assert!((total - 1.0).abs() < 1e-3, "{g}: {total}");
            assert!((mean - f64::from(g)).abs() < 1e-3, "{g}: {mean}");
        }
    }

    /// Equal quantiles of the cumulative distribution, which is known in closed form, get equal numbers of samples.
    #[test]
    fn samples_follow_the_density() {
        const BINS: usize = 50;
        const SAMPLES: u64 = 100_000;
        for g in [-0.8f64, 0.0, 0.4, 0.98] {
            let phase = HenyeyGreenstein::new(g as f32);
            let mut counts = [[0.0f64; 4]; BINS];
            for i in 0..SAMPLES {
                let (wi, pdf) = phase.sample(WO, numbers(i));
                assert!((wi.length() - 1.0).abs() < 1e-5);
                // The direction is rounded; the peak is (1 − |g|) wide.
                let said = phase.value(WO, wi);
                assert!((said / pdf - 1.0).abs() < 1e-3, "{g}: {said} but {pdf}");
                let cos = -WO.as_dvec3().dot(wi.as_dvec3());
                let below = if g == 0.0 {
                    0.5 * (1.0 + cos)
                } else {
                    let root = (1.0 + g * g - 2.0 * g * cos).max(0.0).sqrt();
                    (1.0 - g * g) / (2.0 * g) * (1.0 / root - 1.0 / (1.0 + g))
                };
                let (s, t) = coordinate_system(WO);
                let quarter = 2 * usize::from(wi.dot(s) > 0.0) + usize::from(wi.dot(t) > 0.0);
                counts[((below * BINS as f64) as usize).min(BINS - 1)][quarter] += 1.0;
            }
            let expected = SAMPLES as f64 / (4.0 * BINS as f64);
            let chi2: f64 = counts
                .as_flattened()
                .iter()
                .map(|c| (c - expected) * (c - expected) / expected)
                .sum();
            let freedom = ChiSquared::new(4.0 * BINS as f64 - 1.0).unwrap();
            // Samples are fixed: a one-time probability of failure of 1 in 10,000.
            assert!(freedom.sf(chi2) > 1e-4, "{g}: χ² = {chi2}");
        }
    }

    #[test]
    fn extreme_lobes_have_a_meaning() {
        for g in [1.0, -1.0, 7.0, f32::INFINITY, f32::NAN, 0.0, 1e-30] {
            let phase = HenyeyGreenstein::new(g);
            for u in [0.0, 0.5, 1.0 - f32::EPSILON / 2.0] {
                let (wi, pdf) = phase.sample(WO, Vec2::splat(u));
                assert!(wi.is_finite() && pdf.is_finite() && pdf > 0.0, "{g} {u}");
            }
            assert!(phase.value(WO, WO).is_finite() && phase.value(WO, -WO).is_finite());
        }
        // g = 1: almost straight.
        let (wi, _) = HenyeyGreenstein::new(1.0).sample(WO, Vec2::splat(0.5));
        assert!((wi + WO).length() < 1e-3);
        let (wi, _) = HenyeyGreenstein::new(-1.0).sample(WO, Vec2::splat(0.5));
        assert!((wi - WO).length() < 1e-3);
    }
}
