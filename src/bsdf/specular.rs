//! Perfectly smooth boundaries (Pharr, Jakob and Humphreys 2016, §8.2). Directions are local.
//!
//! These are distributions, not functions: they have no value for a given pair of directions, only
//! samples, whose `f` is the factor of the direction's delta, divided by the cosine as the
//! scattering equation multiplies with it.

use super::fresnel::{Fresnel, dielectric};
use super::lobe::LobeSample;
use crate::math::{Rgb, Vec3};

/// A mirror.
#[derive(Clone, Copy, Debug)]
pub struct SpecularReflection {
    /// Factor of the reflected light.
    pub reflectance: Rgb,
    /// Share of the light that is reflected.
    pub fresnel: Fresnel,
}

impl SpecularReflection {
    /// The mirrored direction.
    pub fn sample(&self, wo: Vec3) -> LobeSample {
        reflected(wo, self.reflectance * self.fresnel.evaluate(wo.z), 1.0)
    }
}

/// Refraction through a boundary.
#[derive(Clone, Copy, Debug)]
pub struct SpecularTransmission {
    /// Factor of the refracted light.
    pub transmittance: Rgb,
    /// Refractive index on the normal's side.
    pub eta_a: f32,
    /// Refractive index on the other side; equal indices pass light straight on.
    pub eta_b: f32,
}

impl SpecularTransmission {
    /// The refracted direction; `None` under total reflection. Radiance is scaled by the squared
    /// ratio of indices, as rays that start at the camera see it (§8.2.3).
    pub fn sample(&self, wo: Vec3) -> Option<LobeSample> {
        let share = 1.0 - dielectric(wo.z, self.eta_a, self.eta_b);
        refracted(wo, self.transmittance * share, self.eta_a, self.eta_b, 1.0)
    }
}

/// A smooth dielectric: reflects or refracts, chosen in proportion to the Fresnel reflectance.
#[derive(Clone, Copy, Debug)]
pub struct FresnelSpecular {
    /// Factor of the reflected light.
    pub reflectance: Rgb,
    /// Factor of the refracted light.
    pub transmittance: Rgb,
    /// Refractive index on the normal's side.
    pub eta_a: f32,
    /// Refractive index on the other side.
    pub eta_b: f32,
}

impl FresnelSpecular {
    /// Reflection where `uc` in [0, 1) is below the Fresnel reflectance, else refraction.
    pub fn sample(&self, wo: Vec3, uc: f32) -> Option<LobeSample> {
        let f = dielectric(wo.z, self.eta_a, self.eta_b);
        if uc < f {
            Some(reflected(wo, self.reflectance * f, f))
        } else {
            refracted(
                wo,
                self.transmittance * (1.0 - f),
                self.eta_a,
                self.eta_b,
                1.0 - f,
            )
        }
    }

    /// Its reflection alone.
    pub fn reflection(&self) -> SpecularReflection {
        let fresnel = Fresnel::Dielectric {
            eta_i: self.eta_a,
            eta_t: self.eta_b,
        };
        SpecularReflection {
            reflectance: self.reflectance,
            fresnel,
        }
    }

    /// Its refraction alone.
    pub fn transmission(&self) -> SpecularTransmission {
        SpecularTransmission {
            transmittance: self.transmittance,
            eta_a: self.eta_a,
            eta_b: self.eta_b,
        }
    }
}

fn reflected(wo: Vec3, factor: Rgb, pdf: f32) -> LobeSample {
    let wi = Vec3::new(-wo.x, -wo.y, wo.z);
    LobeSample {
        f: factor / wi.z.abs(),
        wi,
        pdf,
        transmission: false,
        eta: 1.0,
    }
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
    Some(LobeSample {
        f,
        wi,
        pdf,
        transmission: true,
        eta,
    })
}

/// The direction that light from `wo` (pointing away, on the side of `n`) goes on in beyond a
/// boundary whose far index is `eta` times the near one; `None` under total reflection.
pub fn refract(wo: Vec3, n: Vec3, eta: f32) -> Option<Vec3> {
    // From the part along the surface, not from 1 − cos²: near the normal that has no digits left.
    let along = (wo.dot(n) * n - wo) / eta;
    let sin2_t = along.length_squared();
    (sin2_t < 1.0).then(|| along - (1.0 - sin2_t).sqrt() * n)
}
