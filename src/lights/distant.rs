//! `distant`: parallel light from infinitely far away.
//!
//! `L` (spectrum, 1): irradiance on a surface that faces the light. `scale` (spectrum, 1): factor.
//! `from` (point, origin), `to` (point, (0,0,1)): light travels from the one toward the other; the
//! transformation turns it, its scale does not count.
//! Source: Pharr, Jakob and Humphreys 2016, §12.4; docs/scene-language.md §3.10.

use super::emission::{Emission, EmissionDensity, SceneSphere};
use super::{LightBounds, LightMap, LightSample, LightType, strength};
use crate::math::transform::Transform;
use crate::math::{DVec3, Rgb, Vec2, Vec3};
use crate::params::ParamReader;
use crate::surface::ReferencePoint;
use std::f32::consts::PI;

/// Parameters, world space.
#[derive(Clone, Debug, PartialEq)]
pub struct DistantSpec {
    /// Unit direction toward the light.
    pub toward: DVec3,
    /// Irradiance on a facing surface.
    pub irradiance: Rgb,
}

impl DistantSpec {
    /// Reads the parameters. Without a direction light travels along +z.
    pub fn from_params(reader: &ParamReader, light_to_world: &Transform) -> DistantSpec {
        let from = reader.point3("from", DVec3::ZERO);
        let to = reader.point3("to", DVec3::Z);
        let back = (from - to).try_normalize().unwrap_or_else(|| {
            reader.error(
                "to",
                "\"from\" and \"to\" of a distant light coincide; shining along z",
            );
            -DVec3::Z
        });
        DistantSpec {
            toward: light_to_world.vector(back).normalize_or(-DVec3::Z),
            irradiance: strength(reader, "L"),
        }
    }
}

/// A distant light in render space.
#[derive(Clone, Debug)]
pub struct DistantLight {
    toward: Vec3,
    irradiance: Rgb,
}

impl DistantLight {
    /// Compiles `spec`.
    pub fn new(spec: &DistantSpec, _map: Option<LightMap>, render_from_world: &Transform) -> Self {
        let toward = render_from_world
            .vector(spec.toward)
            .normalize_or(-DVec3::Z)
            .as_vec3();
        DistantLight {
            toward,
            irradiance: spec.irradiance,
        }
    }
}

impl LightType for DistantLight {
    const IS_AT_INFINITY: bool = true;

    fn sample(&self, from: &ReferencePoint, _u: Vec2) -> Option<LightSample> {
        LightSample::only(self.irradiance, self.toward, || {
            from.shadow_ray_toward(self.toward)
        })
    }

    fn emit(&self, scene: &SceneSphere, u_position: Vec2, _u_direction: Vec2) -> Option<Emission> {
        Emission::from_infinity(scene, -self.toward, self.irradiance, 1.0, u_position)
    }

    fn emit_toward(&self, _u_position: Vec2, _d: Vec3) -> Option<Emission> {
        None
    }

    fn emission_density(&self, scene: &SceneSphere, _n: Vec3, _d: Vec3) -> EmissionDensity {
        EmissionDensity::at_infinity(scene, 1.0)
    }

    /// Flux through the disk that the scene shows the light.
    fn power(&self, scene_radius: f32) -> Rgb {
        PI * scene_radius * scene_radius * self.irradiance
    }

    fn bounds(&self) -> LightBounds {
        LightBounds::everywhere(self.irradiance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shines_the_same_everywhere_and_for_ever() {
        let spec = DistantSpec {
            toward: DVec3::Y,
            irradiance: Rgb::new(1.0, 2.0, 3.0),
        };
        let light = DistantLight::new(&spec, None, &Transform::translate(DVec3::splat(7.0)));
        for p in [Vec3::ZERO, Vec3::splat(1e6)] {
            let from = ReferencePoint {
                p,
                n: Vec3::Y,
                ..Default::default()
            };
            let s = light.sample(&from, Vec2::ZERO).unwrap();
            assert_eq!(
                (s.radiance, s.wi, s.pdf, s.delta),
                (spec.irradiance, Vec3::Y, 1.0, true)
            );
            assert_eq!((s.shadow.d, s.shadow.t_max), (Vec3::Y, f32::INFINITY));
        }
        assert_eq!(light.power(2.0), 4.0 * PI * spec.irradiance);
    }
}
