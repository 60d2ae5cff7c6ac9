//! Moments of the Fresnel reflectance over the hemisphere (d'Eon and Irving 2011; Pharr, Jakob and Humphreys 2016,
//! §11.4.3): how much diffuse light a smooth boundary reflects.
//!
//! The k-th moment is ∫ F(cosθ) cosᵏθ sinθ dθ over 0…π/2. Those from the optically thin side are
//! integrals of a smooth function; those from the dense side follow from them by Snell's law, below
//! the critical angle, and are elementary above it. (pbrt-v3 has polynomial fits; they are within
//! 0.001 of these for indices from 1 to 2.)

use super::fresnel::dielectric;

/// Points of the quadrature: the integrand is smooth except for its rise near grazing angles, which this resolves to
/// 1e-6.
const STEPS: usize = 256;

/// The first and second moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FresnelMoments {
    /// k = 1: half the reflectance for diffuse light.
    pub first: f64,
    /// k = 2.
    pub second: f64,
}

impl FresnelMoments {
    /// For light incident from a medium of index 1 on one of index `eta` (positive).
    pub fn outside(eta: f64) -> FresnelMoments {
        if eta < 1.0 {
            dense_side(1.0 / eta)
        } else {
            thin_side(eta)
        }
    }

    /// For light incident from a medium of index `eta` (positive) on one of index 1.
    pub fn inside(eta: f64) -> FresnelMoments {
        FresnelMoments::outside(1.0 / eta)
    }
}

/// Sum over midpoints of the square of cosθ on the thin side: the measure is cosθ sinθ dθ, whose integral is 1/2, and
/// `weight` receives cosθ there and in the dense medium.
fn integrate(eta: f64, weight: impl Fn(f64, f64) -> f64) -> f64 {
    // Equal steps in the square root of cosθ concentrate points where F rises.
    let width = 1.0 / STEPS as f64;
    let mut sum = 0.0;
    for i in 0..STEPS {
        let s = (i as f64 + 0.5) * width;
        let cos = s * s;
        let sin2 = 1.0 - cos * cos;
        let inner = (1.0 - sin2 / (eta * eta)).max(0.0).sqrt();
        let f = f64::from(dielectric(cos as f32, 1.0, eta as f32));
        // d cosθ = 2 s ds.
        sum += f * weight(cos, inner) * cos * 2.0 * s * width;
    }
    sum
}

fn thin_side(eta: f64) -> FresnelMoments {
    FresnelMoments {
        first: integrate(eta, |_, _| 1.0),
        second: integrate(eta, |cos, _| cos),
    }
}

/// cosθ sinθ dθ is 1/η² times that on the thin side; beyond the critical angle F is 1.
fn dense_side(eta: f64) -> FresnelMoments {
    let square = eta * eta;
    let sin2_critical = 1.0 / square;
    let cos_critical = (1.0 - sin2_critical).max(0.0).sqrt();
    FresnelMoments {
        first: integrate(eta, |_, _| 1.0) / square + 0.5 * (1.0 - sin2_critical),
        second: integrate(eta, |_, inner| inner) / square + cos_critical.powi(3) / 3.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Brute force over θ with 200 000 steps.
    fn direct(from: f32, to: f32, k: i32) -> f64 {
        let n = 200_000;
        let width = std::f64::consts::FRAC_PI_2 / f64::from(n);
        let term = |i| {
            let (sin, cos) = ((f64::from(i) + 0.5) * width).sin_cos();
            f64::from(dielectric(cos as f32, from, to)) * cos.powi(k) * sin * width
        };
        (0..n).map(term).sum()
    }

    #[test]
    fn moments_are_the_integrals() {
        for eta in [0.7f32, 1.0, 1.1, 1.33, 1.5, 2.0, 4.0] {
            let (outside, inside) = (
                FresnelMoments::outside(f64::from(eta)),
                FresnelMoments::inside(f64::from(eta)),
            );
            for (found, exact) in [
                (outside.first, direct(1.0, eta, 1)),
                (outside.second, direct(1.0, eta, 2)),
                (inside.first, direct(eta, 1.0, 1)),
                (inside.second, direct(eta, 1.0, 2)),
            ] {
                // The quadrature's error near grazing and single precision of F.
                assert!((found - exact).abs() < 1e-5, "{eta}: {found} for {exact}");
            }
        }
    }

    #[test]
    fn water_turns_back_what_books_say() {
        // Diffuse reflectance of water 0.066 from above (e.g. Preisendorfer 1976) and 0.47 from below.
        assert!((2.0 * FresnelMoments::outside(1.33).first - 0.066).abs() < 1e-3);
        assert!((2.0 * FresnelMoments::inside(1.33).first - 0.472).abs() < 2e-3);
    }
}
