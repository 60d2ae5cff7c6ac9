//! Hair and fur (Chiang, Bitterli, Tappan and Burley, "A Practical and Controllable Hair and Fur
//! Model for Production Path Tracing", 2016; Pharr, "The Implementation of a Hair Scattering Model",
//! 2016, sections cited by number below). Directions are local: x along the hair, z along the normal.
//!
//! Scattered light is split by the number of internal reflections in the fiber: p = 0 reflects off the surface, 1 is
//! transmitted straight through, 2 has one internal reflection, and all further ones are combined.

use super::fresnel::dielectric;
use super::lobe_sample::LobeSample;
use crate::math::color::luminance;
use crate::math::float::clamp_nan_low;
use crate::math::{Rgb, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Number of paths with a lobe of their own; the others share one more.
const PATHS: usize = 3;

/// Minimum roughness: narrower lobes exceed single precision.
const MIN_ROUGHNESS: f32 = 0.01;

/// A fiber at a ray's hit point.
#[derive(Clone, Copy, Debug)]
pub struct Hair {
    /// Scale of the whole.
    pub(super) scale: Rgb,
    /// Absorption coefficient, per fiber radius.
    sigma_a: Rgb,
    /// Offset of the hit from the fiber's axis, −1 to 1.
    h: f32,
    eta: f32,
    /// Longitudinal variance of p = 0; that of the others is a quarter and four times as much.
    variance: f32,
    /// Scale of the azimuthal logistic distribution.
    spread: f32,
    /// Sine and cosine of the scales' tilt.
    tilt: (f32, f32),
}

/// A direction in the fiber's angles: θ to the normal plane, φ around the fiber.
#[derive(Clone, Copy)]
struct FibreAngles {
    sin: f32,
    cos: f32,
    phi: f32,
}

impl FibreAngles {
    fn new(w: Vec3) -> FibreAngles {
        FibreAngles {
            sin: w.x.clamp(-1.0, 1.0),
            cos: (w.y * w.y + w.z * w.z).sqrt(),
            phi: w.z.atan2(w.y),
        }
    }
}

/// Properties of the fiber that depend on the outgoing direction only.
struct Seen {
    o: FibreAngles,
    gamma_o: f32,
    gamma_t: f32,
    /// Attenuation by path (§2.3).
    attenuation: [Rgb; PATHS + 1],
    /// Probability of each path in sampling (§2.6).
    chance: [f32; PATHS + 1],
}

impl Hair {
    /// A fiber of refractive index `eta` at offset `h` from its axis (−1 to 1), with absorption `sigma_a` per radius,
    /// longitudinal and azimuthal roughness `beta_m` and `beta_n` in 0…1, and scales tilted by `alpha` degrees. Values
    /// out of range are clamped; the index is at least 1.
    pub fn new(h: f32, eta: f32, sigma_a: Rgb, beta: [f32; 2], alpha: f32) -> Hair {
        let [m, n] = beta.map(|beta| clamp_nan_low(beta, MIN_ROUGHNESS, 1.0));
        // §2.1 and §2.4: fitted so that equal steps in β are perceptually equal.
        let deviation = 0.726 * m + 0.812 * m * m + 3.7 * m.powi(20);
        let spread = (PI / 8.0).sqrt() * (0.265 * n + 1.194 * n * n + 5.372 * n.powi(22));
        Hair {
            scale: Rgb::ONE,
            sigma_a,
            h: clamp_nan_low(h, -1.0, 1.0),
            eta: eta.max(1.0),
            variance: deviation * deviation,
            spread,
            tilt: alpha.to_radians().sin_cos(),
        }
    }

    /// The lobe's value in 1/sr (§2): the sum over paths of longitudinal, attenuation and azimuthal terms, divided by
    /// the cosine of the scattering equation.
    pub fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        let seen = self.seen(wo);
        let mut sum = Rgb::ZERO;
        self.visit_paths(&seen, wi, |p, density| sum += seen.attenuation[p] * density);
        // No direction is as grazing as this bound, which keeps the value finite.
        self.scale * sum / wi.z.abs().max(1e-20)
    }

    /// Density of [`Hair::sample`].
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let seen = self.seen(wo);
        let mut sum = 0.0;
        self.visit_paths(&seen, wi, |p, density| sum += seen.chance[p] * density);
        sum
    }

    /// Samples a path in proportion to its attenuation, and a direction of its lobe (§2.6).
    pub fn sample(&self, wo: Vec3, uc: f32, u: Vec2) -> Option<LobeSample> {
        let seen = self.seen(wo);
        let (p, uc) = choose_path(&seen.chance, uc);
        let (sin_o, cos_o) = self.tilted(p, &seen.o);
        let v = self.variance_of(p);
        // Rounding errors must not lead to the logarithm of 0.
        let u_cos = u.x.max(1e-5);
        let cos = 1.0 + v * (u_cos + (1.0 - u_cos) * (-2.0 / v).exp()).ln();
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let sin_i = (-cos * sin_o + sin * (TAU * u.y).cos() * cos_o).clamp(-1.0, 1.0);
        let cos_i = (1.0 - sin_i * sin_i).sqrt();
        let turn = if p < PATHS {
            deflection(p, &seen) + sample_trimmed_logistic(uc, self.spread)
        } else {
            TAU * uc
        };
        let (sin_phi, cos_phi) = (seen.o.phi + turn).sin_cos();
        let wi = Vec3::new(sin_i, cos_i * cos_phi, cos_i * sin_phi);
        let sample = LobeSample::evaluated(wi, self.pdf(wo, wi), || self.f(wo, wi))?;
        Some(LobeSample {
            transmission: wo.z * wi.z < 0.0,
            ..sample
        })
    }

    /// Calls `visit` with each path's density of scattering to `wi`, without the attenuation.
    fn visit_paths(&self, seen: &Seen, wi: Vec3, mut visit: impl FnMut(usize, f32)) {
        let i = FibreAngles::new(wi);
        let phi = i.phi - seen.o.phi;
        for p in 0..=PATHS {
            let (sin_o, cos_o) = self.tilted(p, &seen.o);
            let along = longitudinal(&i, sin_o, cos_o, self.variance_of(p));
            let around = if p < PATHS {
                trimmed_logistic(wrapped(phi - deflection(p, seen)), self.spread)
            } else {
                1.0 / TAU
            };
            visit(p, along * around);
        }
    }

    fn seen(&self, wo: Vec3) -> Seen {
        let o = FibreAngles::new(wo);
        // Refraction into the fiber (§2.3): in the normal plane by Bravais' index.
        let sin_t = o.sin / self.eta;
        let cos_t = (1.0 - sin_t * sin_t).max(f32::MIN_POSITIVE).sqrt();
        let across = (self.eta * self.eta - o.sin * o.sin).max(0.0).sqrt();
        let sin_gamma_t = (self.h * o.cos / across.max(1e-10)).clamp(-1.0, 1.0);
        let cos_gamma_t = (1.0 - sin_gamma_t * sin_gamma_t).sqrt();
        let transmittance = (-self.sigma_a * (2.0 * cos_gamma_t / cos_t)).exp();
        let attenuation = self.attenuation(o.cos, transmittance);
        let worth = attenuation.map(luminance);
        let total: f32 = worth.iter().sum();
        Seen {
            o,
            gamma_o: self.h.asin(),
            gamma_t: sin_gamma_t.asin(),
            attenuation,
            chance: worth.map(|w| if total > 0.0 { w / total } else { 0.0 }),
        }
    }

    /// The attenuation of each path (§2.3, equation 9 and the sum of its series).
    fn attenuation(&self, cos_o: f32, transmittance: Rgb) -> [Rgb; PATHS + 1] {
        let cos_gamma_o = (1.0 - self.h * self.h).max(0.0).sqrt();
        let f = dielectric(cos_o * cos_gamma_o, 1.0, self.eta);
        let through = (1.0 - f) * (1.0 - f) * transmittance;
        let again = f * transmittance;
        // Grazing reflection is total and lets nothing in to be reflected internally.
        let rest = (Rgb::ONE - again).max(Rgb::splat(f32::MIN_POSITIVE));
        let further = through * again * again;
        [Rgb::splat(f), through, through * again, further / rest]
    }

    /// Longitudinal variance of a path (§2.1).
    fn variance_of(&self, p: usize) -> f32 {
        match p {
            0 => self.variance,
            1 => 0.25 * self.variance,
            _ => 4.0 * self.variance,
        }
    }

    /// Sine and cosine of the outgoing angle, rotated by the tilt of the scales for a path (§2.5).
    fn tilted(&self, p: usize, o: &FibreAngles) -> (f32, f32) {
        let double = |(sin, cos): (f32, f32)| (2.0 * sin * cos, cos * cos - sin * sin);
        let once = self.tilt;
        let (sin, cos) = match p {
            0 => {
                let (sin, cos) = double(once);
                (-sin, cos)
            }
            1 => once,
            2 => double(double(once)),
            _ => return (o.sin, o.cos),
        };
        (o.sin * cos + o.cos * sin, (o.cos * cos - o.sin * sin).abs())
    }
}

/// Chooses a path by its probability, and rescales `u` for reuse.
fn choose_path(chance: &[f32; PATHS + 1], mut u: f32) -> (usize, f32) {
    for (p, &c) in chance.iter().enumerate() {
        if u < c || p == PATHS {
            let stretched = if c > 0.0 { u / c } else { 0.0 };
            return (p, stretched.clamp(0.0, 1.0 - f32::EPSILON / 2.0));
        }
        u -= c;
    }
    (PATHS, u)
}

/// Longitudinal scattering (§2.2, equation 4; d'Eon et al. 2011): a density over the latitudes of the sphere. The
/// Bessel function is exponentially scaled, so that one formula serves all variances.
fn longitudinal(i: &FibreAngles, sin_o: f32, cos_o: f32, v: f32) -> f32 {
    let a = i.cos * cos_o / v;
    let exponent = a - i.sin * sin_o / v - 1.0 / v;
    // 1/(2 v sinh(1/v)) = e^(−1/v)/(v (1 − e^(−2/v))).
    exponent.min(0.0).exp() * scaled_bessel_i0(a) / (v * -(-2.0 / v).exp_m1())
}

/// e⁻ˣ I₀(x) for x ≥ 0 (Abramowitz and Stegun 1964, 9.8.1 and 9.8.2), to 2e-7.
fn scaled_bessel_i0(x: f32) -> f32 {
    let horner = |t: f32, c: &[f32]| c.iter().rev().fold(0.0, |sum, &c| sum * t + c);
    if x <= 3.75 {
        let t = (x / 3.75) * (x / 3.75);
        const C: [f32; 7] = [
            1.0,
            3.515_622_9,
            3.089_942,
            1.206_749_2,
            0.265_973_2,
            0.036_076_8,
            0.004_581_3,
        ];
        (-x).exp() * horner(t, &C)
    } else {
        const C: [f32; 9] = [
            0.398_942_3,
            0.013_285_92,
            0.002_253_19,
            -0.001_575_65,
            0.009_162_81,
            -0.020_577_06,
            0.026_355_37,
            -0.016_476_33,
            0.003_923_77,
        ];
        horner(3.75 / x, &C) / x.sqrt()
    }
}

/// The angle by which a path deflects light around the fiber (§2.4).
fn deflection(p: usize, seen: &Seen) -> f32 {
    let p = p as f32;
    2.0 * p * seen.gamma_t - 2.0 * seen.gamma_o + p * PI
}

/// The angle wrapped to −π…π.
fn wrapped(angle: f32) -> f32 {
    let turned = (angle + PI).rem_euclid(TAU) - PI;
    turned.clamp(-PI, PI)
}

/// The logistic distribution of scale `s`, truncated to −π…π (§2.4).
fn trimmed_logistic(x: f32, s: f32) -> f32 {
    let e = (-x.abs() / s).exp();
    e / (s * (1.0 + e) * (1.0 + e)) / (1.0 - 2.0 * logistic_tail(s))
}

/// Samples the truncated logistic distribution by inversion.
fn sample_trimmed_logistic(u: f32, s: f32) -> f32 {
    let tail = logistic_tail(s);
    let cumulated = tail + u * (1.0 - 2.0 * tail);
    (-s * (1.0 / cumulated - 1.0).ln()).clamp(-PI, PI)
}

/// Probability of the logistic distribution below −π.
fn logistic_tail(s: f32) -> f32 {
    // e^(-π/s)/(1 + e^(-π/s)): no overflow for narrow distributions.
    let e = (-PI / s).exp();
    e / (1.0 + e)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::testing::{integrate, random};
    use crate::math::sampling::uniform_sphere;

    const WHITE: Rgb = Rgb::ZERO;

    /// White furnace (Pharr 2016, §2.6): white fibers under white light look white, for all roughnesses; here by
    /// integrating the value, in `laws.rs` by sampling.
    #[test]
    fn white_hair_disappears_in_a_white_furnace() {
        for beta_m in [0.2, 0.5, 1.0] {
            for beta_n in [0.2, 0.5, 1.0] {
                for (h, alpha) in [(-0.9, 0.0), (0.0, 2.0), (0.4, 10.0)] {
                    let hair = Hair::new(h, 1.55, WHITE, [beta_m, beta_n], alpha);
                    let wo = uniform_sphere(random((beta_n * 10.0) as u64).1);
                    let sum = integrate(160, |wi| hair.f(wo, wi) * wi.z.abs()).x;
                    // The grid's error on lobes as narrow as 0.15 rad.
                    assert!(
                        (sum - 1.0).abs() < 2e-3,
                        "{beta_m} {beta_n} {h} {alpha}: {sum}"
                    );
                }
            }
        }
    }

    /// The attenuations of all paths sum to one if there is no absorption (§2.3).
    #[test]
    fn paths_share_the_light() {
        for h in [-1.0, -0.5, 0.0, 0.999] {
            for cos in [1.0, 0.5, 1e-3, 0.0] {
                let hair = Hair::new(h, 1.55, WHITE, [0.3, 0.3], 2.0);
                let sum: Rgb = hair.attenuation(cos, Rgb::ONE).into_iter().sum();
                // Rounding.
                assert!((sum.x - 1.0).abs() < 1e-5, "{h} {cos}: {sum}");
            }
        }
    }

    /// Samples of white hair have weight exactly 1, whatever the path: value and density differ only by the cosine.
    #[test]
    fn samples_of_white_hair_weigh_one() {
        let hair = Hair::new(0.3, 1.55, WHITE, [0.3, 0.4], 2.0);
        for i in 0..1000 {
            let (uc, u) = random(i);
            let wo = uniform_sphere(random(i + 5000).1);
            let s = hair.sample(wo, uc, u).expect("a direction");
            // Rounding of the luminance's weights.
            assert!((s.f.x * s.wi.z.abs() / s.pdf - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn the_bessel_function_has_its_tabulated_values() {
        // e⁻ˣ I₀(x), Abramowitz and Stegun 1964, table 9.8.
        for (x, value) in [
            (0.0, 1.0),
            (1.0, 0.465_759_6),
            (5.0, 0.183_540_8),
            (10.0, 0.127_833_3),
        ] {
            assert!((scaled_bessel_i0(x) - value).abs() < 1e-6, "{x}");
        }
    }

    #[test]
    fn the_trimmed_logistic_is_a_density() {
        for s in [0.05f32, 0.3, 2.0] {
            let n = 20_000;
            let step = TAU / n as f32;
            let sum: f64 = (0..n)
                .map(|i| f64::from(trimmed_logistic(-PI + (i as f32 + 0.5) * step, s) * step))
                .sum();
            assert!((sum - 1.0).abs() < 1e-4, "{s}: {sum}");
            // The sample at the first quartile is that of the distribution.
            let x = sample_trimmed_logistic(0.25, s);
            let below: f64 = (0..n)
                .map(|i| -PI + (i as f32 + 0.5) * step)
                .filter(|at| *at < x)
                .map(|at| f64::from(trimmed_logistic(at, s) * step))
                .sum();
            assert!((below - 0.25).abs() < 1e-3, "{s}: {below}");
        }
    }

    /// Without absorption but with a rough fiber, light transmitted straight through dominates; off the axis p = 1 is
    /// deflected by 2γt − 2γo + π.
    #[test]
    fn light_through_the_middle_goes_straight_on() {
        let hair = Hair::new(0.0, 1.55, WHITE, [0.1, 0.1], 0.0);
        let wo = Vec3::Z;
        let (ahead, aside) = (
            hair.f(wo, Vec3::new(0.0, 0.1, -0.995)),
            hair.f(wo, Vec3::Y.with_z(0.1).normalize()),
        );
        assert!(ahead.x > 100.0 * aside.x, "{ahead} {aside}");
    }
}
