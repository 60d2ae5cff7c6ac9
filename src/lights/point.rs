//! `point`: the same intensity in all directions.
//!
//! `I` (spectrum, 1): intensity. `scale` (spectrum, 1): factor. `from` (point, origin): position,
//! which pbrt adds in *world* space to where the transformation takes the origin.
//! Source: Pharr, Jakob and Humphreys 2016, §12.3; docs/scene-language.md §3.10.

use super::emission::{Emission, EmissionDensity, SceneSphere};
use super::{LightBounds, LightMap, LightSample, LightType, strength};
use crate::math::sampling::{UNIFORM_SPHERE_PDF, uniform_sphere};
use crate::math::transform::Transform;
use crate::math::{DVec3, Rgb, Vec2, Vec3};
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
            position: position(reader.point3("from", DVec3::ZERO), light_to_world),
            intensity: strength(reader, "I"),
        }
    }
}

/// World position of a light with this `from`: see the top of this file.
fn position(from: DVec3, light_to_world: &Transform) -> DVec3 {
    from + light_to_world.point(DVec3::ZERO)
}

/// A point light in render space.
#[derive(Clone, Debug)]
pub struct PointLight {
    p: Vec3,
    intensity: Rgb,
}

impl PointLight {
    /// Compiles `spec`.
    pub fn new(spec: &PointSpec, _map: Option<LightMap>, render_from_world: &Transform) -> Self {
        PointLight {
            p: render_from_world.point(spec.position).as_vec3(),
            intensity: spec.intensity,
        }
    }
}

impl LightType for PointLight {
    #[inline]
    fn sample(&self, from: &ReferencePoint, _u: Vec2) -> Option<LightSample> {
        sample_point(self.p, from, |_| self.intensity)
    }

    fn place(&self) -> Vec3 {
        self.p
    }

    fn emit(&self, _scene: &SceneSphere, _u_position: Vec2, u_direction: Vec2) -> Option<Emission> {
        self.emit_toward(Vec2::ZERO, uniform_sphere(u_direction))
    }

    fn emit_toward(&self, _u_position: Vec2, d: Vec3) -> Option<Emission> {
        Emission::from_point(self.p, d, self.intensity, UNIFORM_SPHERE_PDF)
    }

    fn emission_density(&self, _scene: &SceneSphere, _n: Vec3, _d: Vec3) -> EmissionDensity {
        EmissionDensity::of_point(UNIFORM_SPHERE_PDF)
    }

    /// Flux.
    fn power(&self, _scene_radius: f32) -> Rgb {
        4.0 * PI * self.intensity
    }

    fn bounds(&self) -> LightBounds {
        LightBounds::point(self.p, self.intensity)
    }
}

/// Light from the point `p` whose intensity in a unit direction away from it is `intensity`.
#[inline(always)]
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
    LightSample::only(radiance, wi, || {
        from.shadow_ray_to(p, Vec3::ZERO, Vec3::ZERO)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn from_is_added_after_the_transformation() {
        let turned = Transform::translate(DVec3::X) * Transform::scale(DVec3::splat(3.0));
        assert_eq!(
            position(DVec3::new(0.0, 2.0, 0.0), &turned),
            DVec3::new(1.0, 2.0, 0.0)
        );
    }

    #[test]
    fn falls_with_the_square_of_the_distance() {
        let spec = PointSpec {
            position: DVec3::new(0.0, 3.0, 4.0),
            intensity: Rgb::new(50.0, 25.0, 0.0),
        };
        let light = PointLight::new(&spec, None, &Transform::translate(DVec3::X));
        let from = ReferencePoint {
            p: Vec3::X,
            n: Vec3::Y,
            time: 0.5,
            ..Default::default()
        };
        let s = light.sample(&from, Vec2::ZERO).unwrap();
        assert!((s.radiance - Rgb::new(2.0, 1.0, 0.0)).length() < 1e-6);
        assert!((s.wi - Vec3::new(0.0, 0.6, 0.8)).length() < 1e-6);
        assert!(s.delta && s.pdf == 1.0 && s.shadow.time == 0.5);
        // A ten-thousandth short of the light.
        assert!((s.shadow.t_max - 4.9995).abs() < 1e-5);
        // At the light itself there is no direction; very far away nothing arrives, and no NaN.
        for (p, n) in [
            (light.p, Vec3::Y),
            (Vec3::splat(1e25), Vec3::Y),
            (light.p, Vec3::ZERO),
        ] {
            assert!(
                light
                    .sample(&ReferencePoint { p, n, ..from }, Vec2::ZERO)
                    .is_none()
            );
        }
    }
}
