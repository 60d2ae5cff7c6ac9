//! Perfectly specular boundaries: mirrors and smooth glass (Pharr, Jakob and Humphreys 2016, §8.2). Directions are
//! local.
//!
//! These are delta distributions, not functions: they have no value for a given pair of directions, only samples, whose
//! `f` is the factor of the delta, divided by the cosine because the scattering equation multiplies by it.

use super::fresnel::{Fresnel, dielectric};
use super::lobe_sample::LobeSample;
use crate::math::{Rgb, Vec3};

/// A mirror.
#[derive(Clone, Copy, Debug)]
pub struct SpecularReflection {
    /// Scale of the reflected light.
    pub reflectance: Rgb,
    /// Fresnel reflectance.
    pub fresnel: Fresnel,
}

impl SpecularReflection {
    /// Samples the mirror direction.
    pub fn sample(&self, wo: Vec3) -> LobeSample {
        reflected(wo, self.reflectance * self.fresnel.evaluate(wo.z), 1.0)
    }
}

/// Refraction through a boundary.
#[derive(Clone, Copy, Debug)]
pub struct SpecularTransmission {
    /// Scale of the refracted light.
    pub transmittance: Rgb,
    /// Refractive index on the normal's side.
    pub eta_a: f32,
    /// Refractive index on the other side; with equal indices light is transmitted straight.
    pub eta_b: f32,
}

impl SpecularTransmission {
    /// Samples the refracted direction; `None` for total internal reflection. Radiance is scaled by the squared ratio
    /// of indices, as for paths that start at the camera (§8.2.3).
    pub fn sample(&self, wo: Vec3) -> Option<LobeSample> {
        let share = 1.0 - dielectric(wo.z, self.eta_a, self.eta_b);
        refracted(wo, self.transmittance * share, self.eta_a, self.eta_b, 1.0)
    }
}

/// A smooth dielectric: reflects or refracts with probability given by the Fresnel reflectance.
#[derive(Clone, Copy, Debug)]
pub struct FresnelSpecular {
    /// Scale of the reflected light.
    pub reflectance: Rgb,
    /// Scale of the refracted light.
    pub transmittance: Rgb,
    /// Refractive index on the normal's side.
    pub eta_a: f32,
    /// Refractive index on the other side.
    pub eta_b: f32,
    /// How much more evenly than by flux reflection and refraction are chosen, from 0, which makes all paths carry the
    /// same flux, to 1, by the square roots of the fluxes.
    pub evenness: f32,
}

impl FresnelSpecular {
    /// Samples reflection if `uc` in [0, 1) is below its probability, otherwise refraction.
    pub fn sample(&self, wo: Vec3, uc: f32) -> Option<LobeSample> {
        let f = dielectric(wo.z, self.eta_a, self.eta_b);
        let share = 1.0 - f;
        let p = reflection_probability(f, self.evenness);
        if uc < p {
            Some(reflected(wo, self.reflectance * f, p))
        } else {
            refracted(
                wo,
                self.transmittance * share,
                self.eta_a,
                self.eta_b,
                1.0 - p,
            )
        }
    }

    /// The reflection alone.
    pub fn reflect(&self, wo: Vec3) -> LobeSample {
        let f = dielectric(wo.z, self.eta_a, self.eta_b);
        reflected(wo, self.reflectance * f, 1.0)
    }

    /// The refraction alone.
    pub fn refract(&self, wo: Vec3) -> Option<LobeSample> {
        let share = 1.0 - dielectric(wo.z, self.eta_a, self.eta_b);
        refracted(wo, self.transmittance * share, self.eta_a, self.eta_b, 1.0)
    }
}

/// Probability of reflection where the Fresnel reflectance is `f`: that (evenness 0) makes all paths carry the same flux.
/// Where they light different pixels, the faint light of reflections is as noisy as it is faint, and chances that go
/// with the square roots of the fluxes (evenness 1) share the noise between both.
pub fn reflection_probability(f: f32, evenness: f32) -> f32 {
    if evenness == 0.0 {
        return f;
    }
    let (reflected, refracted) = (f.sqrt(), (1.0 - f).sqrt());
    let even = reflected / (reflected + refracted);
    f + evenness * (even - f)
}

fn reflected(wo: Vec3, factor: Rgb, pdf: f32) -> LobeSample {
    let wi = Vec3::new(-wo.x, -wo.y, wo.z);
    LobeSample::reflected(wi, factor / wi.z.abs(), pdf)
}

fn refracted(wo: Vec3, factor: Rgb, eta_a: f32, eta_b: f32, pdf: f32) -> Option<LobeSample> {
    let (eta_i, eta_t) = if wo.z > 0.0 {
        (eta_a, eta_b)
    } else {
        (eta_b, eta_a)
    };
    let n = Vec3::Z * 1.0f32.copysign(wo.z);
    let eta = eta_t / eta_i;
    let wi = refract(wo, n, eta)?;
    let f = factor / (eta * eta * wi.z.abs());
    Some(LobeSample::reflected(wi, f, pdf).transmitted(eta))
}

/// The direction in which light from `wo` (pointing away, on the side of `n`) is refracted by a boundary whose far
/// index is `eta` times the near one (Snell's law); `None` for total internal reflection.
pub fn refract(wo: Vec3, n: Vec3, eta: f32) -> Option<Vec3> {
    // From the tangential component, not from 1 − cos²: near the normal that has no significant digits left.
    let along = (wo.dot(n) * n - wo) / eta;
    let sin2_t = along.length_squared();
    (sin2_t < 1.0).then(|| along - (1.0 - sin2_t).sqrt() * n)
}
