//! Photon beam diffusion (Habel, Christensen and Jarosz 2013; Pharr, Jakob and Humphreys 2016,
//! §15.5): the light that leaves a flat, infinitely deep medium at a distance from where a
//! perpendicular pencil of light enters it, per unit area and of unit entering flux.
//!
//! Light scattered many times is that of dipoles along the refracted beam, in Grosjean's
//! non-classical diffusion; light scattered once is integrated along the beam exactly.
//! Lengths are in mean free paths, so the extinction is 1 and the albedo is all that counts.

use crate::bsdf::fresnel::dielectric;
use crate::bsdf::fresnel_moments::FresnelMoments;
use std::f64::consts::PI;

/// Points along the beam, equally probable under exponential decay. The number is pbrt-v3's: near
/// the entry the sum depends on it, so that another one would give other pictures.
const DEPTHS: usize = 100;

/// A half-space that scatters light.
#[derive(Clone, Copy, Debug)]
pub struct HalfSpace {
    /// Scattering over extinction, in 0…1.
    pub albedo: f64,
    /// Mean cosine of scattering (Henyey–Greenstein), in -1…1.
    pub g: f64,
    /// Refractive index relative to the outside.
    pub eta: f64,
    /// Moments of the reflectance of its boundary seen from inside.
    pub moments: FresnelMoments,
}

impl HalfSpace {
    /// Radiant exitance at distance `r`, in mean free paths, from the beam.
    pub fn exitance(&self, r: f64) -> f64 {
        let e = self.single(r) + self.multiple(r);
        if e.is_finite() { e.max(0.0) } else { 0.0 }
    }

    /// Light scattered several times (equations 15.24–15.32).
    fn multiple(&self, r: f64) -> f64 {
        let scattering = self.albedo * (1.0 - self.g);
        let absorption = 1.0 - self.albedo;
        let extinction = absorption + scattering;
        if scattering <= 0.0 {
            return 0.0;
        }
        let albedo = scattering / extinction;
        let diffusion = (2.0 * absorption + scattering) / (3.0 * extinction * extinction);
        let transport = (absorption / diffusion).sqrt();
        let FresnelMoments { first, second } = self.moments;
        // Where the fluence, continued linearly, vanishes outside.
        let vanishing = -2.0 * diffusion * (1.0 + 3.0 * second) / (1.0 - 2.0 * first);
        let from_fluence = 0.25 * (1.0 - 2.0 * first);
        let from_flux = 0.5 * (1.0 - 3.0 * second);
        let mut sum = 0.0;
        for depth in depths() {
            let real = depth / extinction;
            let mirrored = 2.0 * vanishing - real;
            let [d, d_mirrored] = [real, mirrored].map(|z| (r * r + z * z).sqrt());
            let potential = |d: f64| (-transport * d).exp() / d;
            let fluence = (potential(d) - potential(d_mirrored)) / (4.0 * PI * diffusion);
            let field =
                |z: f64, d: f64| z * (1.0 + transport * d) * (-transport * d).exp() / (d * d * d);
            let flux = (field(real, d) - field(mirrored, d_mirrored)) / (4.0 * PI);
            // Diffusion is too bright close to the beam: the empirical correction of the paper.
            let correction = 1.0 - (-2.0 * extinction * (d + real)).exp();
            sum += correction * albedo * albedo * (fluence * from_fluence + flux * from_flux);
        }
        sum / DEPTHS as f64
    }

    /// Light scattered once (equation 15.34).
    fn single(&self, r: f64) -> f64 {
        // Nearer to the surface than this the light meets it beyond the critical angle.
        let least = r * (self.eta * self.eta - 1.0).max(0.0).sqrt();
        let mut sum = 0.0;
        for depth in depths() {
            let t = least + depth;
            let d = (r * r + t * t).sqrt();
            let cos = t / d;
            let leaving = 1.0 - f64::from(dielectric(-cos as f32, 1.0, self.eta as f32));
            let phase = henyey_greenstein(cos, self.g);
            sum += self.albedo * (-(d + least)).exp() / (d * d) * phase * leaving * cos;
        }
        sum / DEPTHS as f64
    }
}

/// Depths in mean free paths.
fn depths() -> impl Iterator<Item = f64> {
    (0..DEPTHS).map(|i| -(1.0 - (i as f64 + 0.5) / DEPTHS as f64).ln())
}

/// The phase function where `cos` is the cosine between both directions pointing away from the
/// point, as pbrt has it: `g` > 0 scatters forward, to `cos` < 0.
fn henyey_greenstein(cos: f64, g: f64) -> f64 {
    let denominator = 1.0 + g * g + 2.0 * g * cos;
    (1.0 - g * g) / (4.0 * PI * denominator * denominator.max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn half_space(albedo: f64, g: f64, eta: f64) -> HalfSpace {
        let moments = FresnelMoments::inside(eta);
        HalfSpace {
            albedo,
            g,
            eta,
            moments,
        }
    }

    /// 2π ∫ E r dr, in the logarithm of r.
    fn reflected(medium: &HalfSpace) -> f64 {
        let (from, to, n) = (1e-5f64.ln(), 300f64.ln(), 4000);
        let width = (to - from) / f64::from(n);
        (0..n)
            .map(|i| {
                let r = (from + (f64::from(i) + 0.5) * width).exp();
                2.0 * PI * r * r * medium.exitance(r) * width
            })
            .sum()
    }

    #[test]
    fn nothing_returns_from_what_does_not_scatter() {
        let black = half_space(0.0, 0.0, 1.33);
        assert_eq!([0.001, 0.1, 1.0, 30.0].map(|r| black.exitance(r)), [0.0; 4]);
    }

    #[test]
    fn more_albedo_returns_more_and_never_more_than_entered() {
        for eta in [1.0, 1.33, 1.5] {
            let mut before = 0.0;
            for albedo in [0.1, 0.5, 0.9, 0.99, 0.999] {
                let now = reflected(&half_space(albedo, 0.0, eta));
                assert!(now > before, "{albedo} returns {now}, less {before}");
                before = now;
            }
            // Diffusion is an approximation; it does not lose or make more than a few hundredths.
            let all = reflected(&half_space(1.0, 0.0, eta));
            assert!((0.9..1.03).contains(&all), "η {eta}: {all}");
        }
    }

    #[test]
    fn forward_scattering_spreads_the_light() {
        // By similarity theory g is as good as less scattering: less returns close by.
        let (even, forward) = (half_space(0.9, 0.0, 1.33), half_space(0.9, 0.8, 1.33));
        assert!(forward.exitance(0.3) < even.exitance(0.3));
    }

    #[test]
    fn numbers_at_the_ends_of_their_ranges_do_no_harm() {
        for albedo in [0.0, 1e-9, 1.0] {
            for g in [-1.0, -0.999, 0.999, 1.0] {
                for eta in [1e-3, 0.5, 1.0, 1e3] {
                    for r in [0.0, 1e-9, 1.0, 1e9] {
                        let e = half_space(albedo, g, eta).exitance(r);
                        assert!(e.is_finite() && e >= 0.0);
                    }
                }
            }
        }
    }
}
