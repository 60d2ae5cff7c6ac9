//! `point`: the same intensity in all directions.
//!
//! `I` (spectrum, 1): intensity. `scale` (spectrum, 1): factor. `from` (point, origin): position,
//! which pbrt adds in *world* space to where the transformation takes the origin.
//! Source: Pharr, Jakob and Humphreys 2016, §12.3; scene-language 3.10.

use super::LightSample;
use super::reach::Reach;
use crate::math::color::is_black;
use crate::math::transform::Transform;
use crate::math::{DVec3, Rgb, Vec3};
use crate::params::ParamReader;
use crate::surface::ReferencePoint;
use std::f32::consts::PI;

/// Parameters, world space.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSpec {
    /// Position.
    pub position: DVec3,
    /// Flux per solid angle.
    pub intensity: Rgb,
}

impl PointSpec {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader, light_to_world: &Transform) -> PointSpec {
        PointSpec {
            position: reader.point3("from", DVec3::ZERO) + light_to_world.point(DVec3::ZERO),
            intensity: reader.spectrum("I", Rgb::ONE) * reader.spectrum("scale", Rgb::ONE),
        }
    }
}

/// A point light in render space.
#[derive(Clone, Debug)]
pub struct PointLight {
    p: Vec3,
    intensity: Rgb,
}

impl PointLight {
    /// Compiles `spec`.
    pub fn new(spec: &PointSpec, render_from_world: &Transform) -> PointLight {
        PointLight {
            p: render_from_world.point(spec.position).as_vec3(),
            intensity: spec.intensity,
        }
    }

    /// The one way light comes from here.
    pub fn sample(&self, from: &ReferencePoint) -> Option<LightSample> {
        sample_point(self.p, from, |_| self.intensity)
    }

    /// Flux.
    pub fn power(&self) -> Rgb {
        4.0 * PI * self.intensity
    }

    pub(super) fn reach(&self) -> Reach {
        Reach::point(self.p, self.intensity)
    }
}

/// Light from the point `p` whose intensity in a unit direction away from it is `intensity`.
pub(super) fn sample_point(
    p: Vec3,
    from: &ReferencePoint,
    intensity: impl Fn(Vec3) -> Rgb,
) -> Option<LightSample> {
    let to_light = p - from.p;
    let distance2 = to_light.length_squared();
    if distance2 == 0.0 {
        return None;
    }
    let wi = to_light / distance2.sqrt();
    let radiance = intensity(-wi) / distance2;
    if is_black(radiance) {
        return None;
    }
    let shadow = from.shadow_ray_to(p, Vec3::ZERO, Vec3::ZERO);
    Some(LightSample {
        radiance,
        wi,
        pdf: 1.0,
        delta: true,
        shadow,
    })
}
