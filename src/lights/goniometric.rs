//! `goniometric`: a point light whose intensity an image gives for every direction.
//!
//! `I` (spectrum, 1): intensity, or factor of the image. `scale` (spectrum, 1): factor.
//! `mapname` (string): the image, latitude by longitude: row 0 toward the light's +y, column 0
//! toward +x, then +z (pbrt exchanges y and z before it asks for polar angles about z); no gamma.
//! The light is at the transformation's origin.
//! Source: Pharr, Jakob and Humphreys 2016, §12.3.3; docs/scene-language.md §3.10.

use super::emission::{Directions, Emission, EmissionDensity, SceneSphere};
use super::map_density::{Cell, MapDensity};
use super::{LightBounds, LightMap, LightSample, LightType, sample_point, strength};
use crate::math::angle::turns;
use crate::math::sampling::{UNIFORM_SPHERE_PDF, uniform_sphere};
use crate::math::transform::Transform;
use crate::math::{DVec3, Rgb, Vec2, Vec3};
use crate::params::ParamReader;
use crate::surface::ReferencePoint;
use glam::Mat3;
use std::f32::consts::PI;
use std::f64::consts;

/// Parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct GoniometricSpec {
    /// Where the light is, and how the image is turned.
    pub light_to_world: Transform,
    /// Flux per solid angle, or factor of the image's texels.
    pub intensity: Rgb,
}

impl GoniometricSpec {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader, light_to_world: &Transform) -> GoniometricSpec {
        GoniometricSpec {
            light_to_world: *light_to_world,
            intensity: strength(reader, "I"),
        }
    }
}

/// A goniometric light in render space.
#[derive(Clone, Debug)]
pub struct GoniometricLight {
    p: Vec3,
    intensity: Rgb,
    map: Option<LightMap>,
    light_from_render: Mat3,
    /// Mean of the image over all directions.
    mean: Rgb,
    /// Where it is bright, once light is to be emitted.
    density: Option<Box<MapDensity>>,
}

impl GoniometricLight {
    /// Compiles `spec`; `map` is its image, where it has one that could be read.
    pub fn new(
        spec: &GoniometricSpec,
        map: Option<LightMap>,
        render_from_world: &Transform,
    ) -> Self {
        let render_from_light = *render_from_world * spec.light_to_world;
        GoniometricLight {
            p: render_from_light.point(DVec3::ZERO).as_vec3(),
            intensity: spec.intensity,
            light_from_render: super::of_volume_1(&render_from_light).inverse().as_mat3(),
            mean: map.as_ref().map_or(Rgb::ONE, LightMap::sphere_mean),
            map,
            density: None,
        }
    }

    /// The image in the unit direction `w` away from the light.
    fn factor(&self, w: Vec3) -> Rgb {
        let Some(map) = &self.map else {
            return Rgb::ONE;
        };
        map.lookup(self.coordinates(w))
    }

    /// Where the direction `w` away from the light is in the image.
    fn coordinates(&self, w: Vec3) -> Vec2 {
        let w = self.light_from_render * w;
        Vec2::new(turns(w.x, w.z), w.x.hypot(w.z).atan2(w.y) / PI)
    }

    /// Density per solid angle with which the unit direction `d` is chosen.
    fn direction_density(&self, d: Vec3) -> f32 {
        let Some(density) = &self.density else {
            return UNIFORM_SPHERE_PDF;
        };
        let cell = density.cell_at(self.coordinates(d));
        let [low, high] = cell.corners(density);
        cell.probability / solid_angle(low, high) as f32
            * Directions::new(&self.light_from_render).density_change(d)
    }
}

/// That of the part of the image between two corners (u, v).
fn solid_angle(low: [f64; 2], high: [f64; 2]) -> f64 {
    let height = |v: f64| (consts::PI * v).cos();
    consts::TAU * (high[0] - low[0]) * (height(low[1]) - height(high[1]))
}

/// A direction, light space, evenly from those of a cell of the image.
fn direction_in(cell: &Cell, density: &MapDensity) -> Vec3 {
    let [low, high] = cell.corners(density);
    let inside = cell.inside.as_dvec2();
    let (top, bottom) = ((consts::PI * low[1]).cos(), (consts::PI * high[1]).cos());
    let y = top + (bottom - top) * inside.y;
    let (sin, cos) = (consts::TAU * (low[0] + (high[0] - low[0]) * inside.x)).sin_cos();
    let across = ((1.0 - y) * (1.0 + y)).max(0.0).sqrt();
    DVec3::new(across * cos, y, across * sin).as_vec3()
}

impl LightType for GoniometricLight {
    const MAPPED: bool = true;

    fn sample(&self, from: &ReferencePoint, _u: Vec2) -> Option<LightSample> {
        sample_point(self.p, from, |w| self.intensity * self.factor(w))
    }

    fn prepare_emission(&mut self) {
        let density = |map| Box::new(MapDensity::new(map, solid_angle));
        self.density = self.map.as_ref().map(density);
    }

    fn place(&self) -> Vec3 {
        self.p
    }

    fn emit(&self, _scene: &SceneSphere, _u_position: Vec2, u_direction: Vec2) -> Option<Emission> {
        let d = match &self.density {
            Some(density) => {
                let w = direction_in(&density.sample(u_direction), density);
                Directions::new(&self.light_from_render).to_render(w)
            }
            None => uniform_sphere(u_direction),
        };
        self.emit_toward(Vec2::ZERO, d)
    }

    fn emit_toward(&self, _u_position: Vec2, d: Vec3) -> Option<Emission> {
        let intensity = self.intensity * self.factor(d);
        Emission::from_point(self.p, d, intensity, self.direction_density(d))
    }

    fn emission_density(&self, _scene: &SceneSphere, _n: Vec3, d: Vec3) -> EmissionDensity {
        EmissionDensity::of_point(self.direction_density(d))
    }

    /// Flux: exact for a transformation that keeps angles.
    fn power(&self, _scene_radius: f32) -> Rgb {
        4.0 * PI * self.intensity * self.mean
    }

    fn bounds(&self) -> LightBounds {
        LightBounds::point(self.p, self.intensity * self.mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sampling::uniform_sphere;

    fn light(map: Option<LightMap>, light_to_world: Transform) -> GoniometricLight {
        let spec = GoniometricSpec {
            light_to_world,
            intensity: Rgb::new(1.0, 2.0, 3.0),
        };
        GoniometricLight::new(&spec, map, &Transform::translate(DVec3::X))
    }

    fn numbered() -> Option<LightMap> {
        LightMap::new(8, 4, (0..32).map(|i| Rgb::splat(i as f32)).collect())
    }

    #[test]
    fn the_pole_is_up_and_columns_go_from_x_to_z() {
        let l = light(numbered(), Transform::translate(DVec3::Y));
        assert_eq!(l.p, Vec3::new(1.0, 1.0, 0.0));
        let direction = |column: f32, row: f32| {
            let (phi, theta) = ((column + 0.5) * PI / 4.0, (row + 0.5) * PI / 4.0);
            Vec3::new(
                theta.sin() * phi.cos(),
                theta.cos(),
                theta.sin() * phi.sin(),
            )
        };
        for texel in 0..32 {
            let w = direction((texel % 8) as f32, (texel / 8) as f32);
            // Texels differ by up to 8 from one to the next; angles round to 1e-7.
            assert!((l.factor(w).x - texel as f32).abs() < 1e-4, "{texel}");
        }
        // Turned with the light: y goes to z, and z to −y.
        let turned = light(numbered(), Transform::rotate(90.0, DVec3::X));
        let w = direction(2.0, 1.0);
        let found = turned.factor(Vec3::new(w.x, -w.z, w.y));
        assert!((found - l.factor(w)).length() < 1e-3);
    }

    #[test]
    fn power_is_the_integral_of_the_intensity() {
        for (map, scale) in [(None, 1.0), (numbered(), 1.0), (numbered(), 3e6)] {
            let turned = Transform::rotate(70.0, DVec3::new(1.0, 2.0, 0.5));
            let l = light(map, turned * Transform::scale(DVec3::splat(scale)));
            let n = 256;
            let mut mean = 0.0;
            for i in 0..n * n {
                let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                mean += f64::from(l.factor(uniform_sphere(u)).y) / f64::from(n * n);
            }
            let expected = f64::from(l.power(1.0).x / (4.0 * PI));
            // The mean takes sin θ at the middle of four rows.
            assert!((mean / expected - 1.0).abs() < 0.03, "{mean} {expected}");
        }
    }

    #[test]
    fn light_falls_off_with_the_square_of_the_distance() {
        let l = light(numbered(), Transform::IDENTITY);
        let at = |y: f32| ReferencePoint {
            p: l.p + Vec3::new(0.5 * y, y, 0.25 * y),
            n: Vec3::NEG_Y,
            ..Default::default()
        };
        let (near, far) = (
            l.sample(&at(1.0), Vec2::ZERO).unwrap(),
            l.sample(&at(4.0), Vec2::ZERO).unwrap(),
        );
        assert!((near.radiance / far.radiance - 16.0).abs().max_element() < 1e-3);
        assert!(near.delta && near.pdf == 1.0);
    }
}
