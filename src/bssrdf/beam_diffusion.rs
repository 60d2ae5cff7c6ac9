//! Photon beam diffusion (Habel, Christensen and Jarosz 2013; Pharr, Jakob and Humphreys 2016, §15.5): the radiant
//! exitance of a flat, semi-infinite medium at a distance from the entry point of a perpendicular pencil beam, per unit
//! area and unit incident flux.
//!
//! Multiple scattering is modeled by dipoles along the refracted beam, with Grosjean's non-classical diffusion; single
//! scattering is integrated along the beam exactly. Lengths are in mean free paths, so extinction is 1 and only the
//! albedo matters.

use crate::bsdf::fresnel::dielectric;
use crate::bsdf::fresnel_moments::FresnelMoments;
use std::f64::consts::PI;

/// Number of points along the beam, equally probable under exponential attenuation. The number is pbrt-v3's: near the
/// entry point the sum depends on it, so that another one would change images.
const DEPTHS: usize = 100;

/// Half-spaces of one boundary and one phase function, whatever their albedo (scattering over extinction, 0…1).
#[derive(Clone, Debug)]
pub(super) struct BeamDiffusion {
    g: f64,
    eta: f64,
    moments: FresnelMoments,
    /// Depths along the beam, in mean free paths.
    depths: [f64; DEPTHS],
}

impl BeamDiffusion {
    /// A medium with mean scattering cosine `g` in -1…1 (Henyey–Greenstein) and refractive index `eta`, positive,
    /// relative to the outside.
    pub(super) fn new(g: f64, eta: f64) -> BeamDiffusion {
        BeamDiffusion {
            g,
            eta,
            moments: FresnelMoments::inside(eta),
            depths: std::array::from_fn(|i| -(1.0 - (i as f64 + 0.5) / DEPTHS as f64).ln()),
        }
    }

    /// Radiant exitance at distance `r`, in mean free paths, from the beam; `single` is
    /// [`BeamDiffusion::single`] there.
    pub(super) fn exitance(&self, albedo: f64, r: f64, single: f64) -> f64 {
        let e = albedo * single + self.multiple(albedo, r);
        if e.is_finite() { e.max(0.0) } else { 0.0 }
    }

    /// Multiple scattering (equations 15.24–15.32).
    fn multiple(&self, albedo: f64, r: f64) -> f64 {
        let scattering = albedo * (1.0 - self.g);
        let absorption = 1.0 - albedo;
        let extinction = absorption + scattering;
        if scattering <= 0.0 {
            return 0.0;
        }
        let reduced = scattering / extinction;
        let diffusion = (2.0 * absorption + scattering) / (3.0 * extinction * extinction);
        let transport = (absorption / diffusion).sqrt();
        let FresnelMoments { first, second } = self.moments;
        // Where the linearly extrapolated fluence vanishes outside.
        let vanishing = -2.0 * diffusion * (1.0 + 3.0 * second) / (1.0 - 2.0 * first);
        let from_fluence = 0.25 * (1.0 - 2.0 * first) / diffusion;
        let from_flux = 0.5 * (1.0 - 3.0 * second);
        let mut sum = 0.0;
        for depth in self.depths {
            let real = depth / extinction;
            // Fluence (except for the factor 1/D) and flux of a source of unit power, times 4π.
            let source = |z: f64| {
                let d = (r * r + z * z).sqrt();
                let fluence = (-transport * d).exp() / d;
                (d, fluence, z * (1.0 + transport * d) * fluence / (d * d))
            };
            let (d, fluence, flux) = source(real);
            let (_, mirrored_fluence, mirrored_flux) = source(2.0 * vanishing - real);
            let exitance =
                (fluence - mirrored_fluence) * from_fluence + (flux - mirrored_flux) * from_flux;
            // Diffusion overestimates close to the beam: the paper's empirical correction.
            let correction = 1.0 - (-2.0 * extinction * (d + real)).exp();
            sum += correction * exitance;
        }
        reduced * reduced * sum / (4.0 * PI * DEPTHS as f64)
    }

    /// Single scattering at distance `r`, in mean free paths, over the albedo (equation 15.34).
    pub(super) fn single(&self, r: f64) -> f64 {
        // From points nearer to the surface, light hits it beyond the critical angle.
        let least = r * (self.eta * self.eta - 1.0).max(0.0).sqrt();
        let mut sum = 0.0;
        for depth in self.depths {
            let t = least + depth;
            let d = (r * r + t * t).sqrt();
            let cos = t / d;
            let leaving = 1.0 - f64::from(dielectric(-cos as f32, 1.0, self.eta as f32));
            let phase = henyey_greenstein(cos, self.g);
            sum += (-(d + least)).exp() / (d * d) * phase * leaving * cos;
        }
        sum / DEPTHS as f64
    }
}

/// The Henyey–Greenstein phase function, where `cos` is the cosine between directions that both point away from the
/// point, as in pbrt: `g` > 0 scatters forward, to `cos` < 0.
fn henyey_greenstein(cos: f64, g: f64) -> f64 {
    let denominator = 1.0 + g * g + 2.0 * g * cos;
    (1.0 - g * g) / (4.0 * PI * denominator * denominator.max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exitance(medium: &BeamDiffusion, albedo: f64, r: f64) -> f64 {
        medium.exitance(albedo, r, medium.single(r))
    }

    /// 2π ∫ E r dr, integrated over the logarithm of r.
    fn reflected(medium: &BeamDiffusion, albedo: f64) -> f64 {
        let (from, to, n) = (1e-5f64.ln(), 300f64.ln(), 2000);
        let width = (to - from) / f64::from(n);
        (0..n)
            .map(|i| {
                let r = (from + (f64::from(i) + 0.5) * width).exp();
                2.0 * PI * r * r * exitance(medium, albedo, r) * width
            })
            .sum()
    }

    #[test]
    fn nothing_returns_from_what_does_not_scatter() {
        let medium = BeamDiffusion::new(0.0, 1.33);
        assert_eq!(
            [0.001, 0.1, 1.0, 30.0].map(|r| exitance(&medium, 0.0, r)),
            [0.0; 4]
        );
    }

    #[test]
    fn more_albedo_returns_more_and_all_of_it_nearly_all() {
        for eta in [1.0, 1.33, 1.5] {
            let medium = BeamDiffusion::new(0.0, eta);
            let mut before = 0.0;
            for albedo in [0.1, 0.5, 0.9, 0.99, 0.999] {
                let now = reflected(&medium, albedo);
                assert!(now > before, "{albedo} returns {now}, less {before}");
                before = now;
            }
            // This is an approximation: without absorption it returns up to 9 % more than enters at a boundary without
            // reflection; 2 % in water, 1 % in glass.
            let all = reflected(&medium, 1.0);
            assert!((0.95..1.1).contains(&all), "η {eta}: {all}");
        }
    }

    #[test]
    fn forward_scattering_spreads_the_light() {
        // By similarity theory, forward scattering is equivalent to less scattering: less light returns close by.
        let [even, forward] = [0.0, 0.8].map(|g| BeamDiffusion::new(g, 1.33));
        assert!(exitance(&forward, 0.9, 0.3) < exitance(&even, 0.9, 0.3));
    }

    #[test]
    fn numbers_at_the_ends_of_their_ranges_do_no_harm() {
        for g in [-1.0, -0.999, 0.999, 1.0] {
            for eta in [1e-3, 0.5, 1.0, 1e3] {
                let medium = BeamDiffusion::new(g, eta);
                for albedo in [0.0, 1e-9, 1.0] {
                    for r in [0.0, 1e-9, 1.0, 1e9] {
                        let e = exitance(&medium, albedo, r);
                        assert!(e.is_finite() && e >= 0.0);
                    }
                }
            }
        }
    }
}
