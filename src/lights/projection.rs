//! `projection`: a slide projector.
//!
//! `I` (spectrum, 1): intensity, or factor of the image. `scale` (spectrum, 1): factor. `fov`
//! (float, 45): degrees that the image's shorter side subtends, between 0 and 180. `mapname`
//! (string): the slide, without gamma; its top row lands at the *bottom* (−y). It shines along the
//! transformed +z from the transformation's origin.
//! Source: Pharr, Jakob and Humphreys 2016, §12.3.2; docs/scene-language.md §3.10.

use super::emission::{Directions, Emission, EmissionDensity, SceneSphere};
use super::map_density::MapDensity;
use super::{LightBounds, LightMap, LightSample, LightType, sample_point, strength};
use crate::math::transform::Transform;
use crate::math::{DVec3, Rgb, Vec2, Vec3};
use crate::params::ParamReader;
use crate::surface::ReferencePoint;
use glam::Mat3;

/// Parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct ProjectionSpec {
    /// Where the projector stands and where it looks.
    pub light_to_world: Transform,
    /// Flux per solid angle, or factor of the image's texels.
    pub intensity: Rgb,
    /// Full angle of the shorter side, degrees.
    pub fov: f64,
}

impl ProjectionSpec {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader, light_to_world: &Transform) -> ProjectionSpec {
        ProjectionSpec {
            light_to_world: *light_to_world,
            intensity: strength(reader, "I"),
            fov: fov(reader),
        }
    }
}

fn fov(reader: &ParamReader) -> f64 {
    const DEFAULT: f64 = 45.0;
    let given = reader.float("fov", DEFAULT);
    if given > 0.0 && given < 180.0 {
        return given;
    }
    reader.warn(
        "fov",
        format!("`fov` is {given} degrees, not between 0 and 180: {DEFAULT} is used"),
    );
    DEFAULT
}

/// A projector in render space.
#[derive(Clone, Debug)]
pub struct ProjectionLight {
    p: Vec3,
    intensity: Rgb,
    map: Option<LightMap>,
    light_from_render: Mat3,
    /// Unit axis, render space.
    axis: Vec3,
    /// The image's half sides at unit distance.
    half: Vec2,
    /// Mean of the image over the solid angle it fills, and that angle.
    mean: Rgb,
    solid_angle: f32,
    /// Where the image is bright, once light is to be emitted.
    density: Option<Box<MapDensity>>,
}

impl ProjectionLight {
    /// Compiles `spec`; `map` is its image, where it has one that could be read.
    pub fn new(
        spec: &ProjectionSpec,
        map: Option<LightMap>,
        render_from_world: &Transform,
    ) -> Self {
        let render_from_light = *render_from_world * spec.light_to_world;
        let aspect = map.as_ref().map_or(1.0, |map| map.aspect);
        let half = (0.5 * spec.fov).to_radians().tan() as f32
            * Vec2::new(aspect.max(1.0), (1.0 / aspect).max(1.0));
        // The solid angle of a piece of the plane z = 1 is its area times cos³.
        let [a, b] = half.as_dvec2().to_array();
        let cos3 = |u: f64, v: f64| {
            let (x, y) = ((2.0 * u - 1.0) * a, (2.0 * v - 1.0) * b);
            (1.0 + x * x + y * y).powf(-1.5)
        };
        ProjectionLight {
            p: render_from_light.point(DVec3::ZERO).as_vec3(),
            intensity: spec.intensity,
            light_from_render: super::of_volume_1(&render_from_light).inverse().as_mat3(),
            axis: render_from_light
                .vector(DVec3::Z)
                .normalize_or_zero()
                .as_vec3(),
            mean: map.as_ref().map_or(Rgb::ONE, |map| map.mean(cos3)),
            solid_angle: (4.0 * (a * b / (1.0 + a * a + b * b + a * a * b * b).sqrt()).asin())
                as f32,
            half,
            map,
            density: None,
        }
    }

    /// The image in the unit direction `w` away from the light; black beyond it.
    fn factor(&self, w: Vec3) -> Rgb {
        match (self.coordinates(w), &self.map) {
            (Some((uv, _)), Some(map)) => map.lookup(uv),
            (Some(_), None) => Rgb::ONE,
            (None, _) => Rgb::ZERO,
        }
    }

    /// Where the unit direction `w` away from the light is in the image, if it is, and the cosine to the axis, light space.
    fn coordinates(&self, w: Vec3) -> Option<(Vec2, f32)> {
        /// Cosine below which there is no projection, as in pbrt-v3.
        const MIN_COSINE: f32 = 1e-3;
        let w = (self.light_from_render * w).normalize_or_zero();
        let at = w.truncate() / w.z;
        if w.z < MIN_COSINE || at.abs().cmpgt(self.half).any() {
            return None;
        }
        Some((0.5 * (at / self.half) + 0.5, w.z))
    }

    /// Density per solid angle with which the unit direction `d` is chosen.
    fn direction_density(&self, d: Vec3) -> f32 {
        let Some((uv, cos)) = self.coordinates(d) else {
            return 0.0;
        };
        let of_image = self.density.as_ref().map_or(1.0, |density| density.at(uv));
        let of_plane = of_image / (4.0 * self.half.x * self.half.y);
        let change = Directions::new(&self.light_from_render).density_change(d);
        of_plane / (cos * cos * cos) * change
    }
}

/// Solid angle of the part between two corners (u, v) of an image with the half sides `half` at unit distance.
fn solid_angle(half: [f64; 2], low: [f64; 2], high: [f64; 2]) -> f64 {
    let at = |uv: f64, k: usize| (2.0 * uv - 1.0) * half[k];
    // Of the rectangle between the axis and (x, y), with the signs of both.
    let from_axis = |u: f64, v: f64| {
        let (x, y) = (at(u, 0), at(v, 1));
        (x * y / (1.0 + x * x + y * y).sqrt()).atan()
    };
    let angle =
        from_axis(high[0], high[1]) - from_axis(low[0], high[1]) - from_axis(high[0], low[1])
            + from_axis(low[0], low[1]);
    // Never nothing, whatever rounding leaves of far corners.
    angle.max(f64::MIN_POSITIVE)
}

impl LightType for ProjectionLight {
    const MAPPED: bool = true;

    fn sample(&self, from: &ReferencePoint, _u: Vec2) -> Option<LightSample> {
        sample_point(self.p, from, |w| self.intensity * self.factor(w))
    }

    fn prepare_emission(&mut self) {
        let half = self.half.as_dvec2().to_array();
        let white = || LightMap::new(1, 1, vec![Rgb::ONE]);
        let density = |map: &LightMap| {
            Box::new(MapDensity::new(map, |low, high| {
                solid_angle(half, low, high)
            }))
        };
        self.density = match &self.map {
            Some(map) => Some(density(map)),
            None => white().as_ref().map(density),
        };
    }

    fn place(&self) -> Vec3 {
        self.p
    }

    fn emit(&self, _scene: &SceneSphere, _u_position: Vec2, u_direction: Vec2) -> Option<Emission> {
        let uv = match &self.density {
            Some(density) => density.sample(u_direction).position(density),
            None => u_direction,
        };
        let w = ((2.0 * uv - 1.0) * self.half).extend(1.0);
        let d = Directions::new(&self.light_from_render).to_render(w);
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
        self.solid_angle * self.intensity * self.mean
    }

    fn bounds(&self) -> LightBounds {
        let cos = 1.0 / (1.0 + self.half.length_squared()).sqrt();
        LightBounds::point(self.p, self.intensity * self.mean).within_cone(self.axis, cos, cos)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sampling::uniform_sphere;
    use crate::params::testing::read;
    use std::f32::consts::PI;

    fn light(map: Option<LightMap>, fov: f64, light_to_world: Transform) -> ProjectionLight {
        let spec = ProjectionSpec {
            light_to_world,
            intensity: Rgb::new(2.0, 1.0, 0.5),
            fov,
        };
        ProjectionLight::new(&spec, map, &Transform::translate(DVec3::X))
    }

    fn slide() -> Option<LightMap> {
        LightMap::new(4, 2, (1..9).map(|i| Rgb::splat(i as f32)).collect())
    }

    #[test]
    fn the_top_row_lands_at_the_bottom() {
        // Half a unit high at distance 1, a unit wide.
        let fov = 2.0 * 0.5f64.atan().to_degrees();
        let l = light(slide(), fov, Transform::IDENTITY);
        assert!((l.half - Vec2::new(1.0, 0.5)).length() < 1e-6);
        for texel in 0..8 {
            let (column, row) = ((texel % 4) as f32, (texel / 4) as f32);
            let w = Vec3::new(column * 0.5 - 0.75, row * 0.5 - 0.25, 1.0).normalize();
            assert!((l.factor(w).x - (texel + 1) as f32).abs() < 1e-4, "{texel}");
        }
        for outside in [
            Vec3::new(1.01, 0.0, 1.0),
            Vec3::new(0.0, -0.51, 1.0),
            Vec3::NEG_Z,
            Vec3::X,
        ] {
            assert_eq!(l.factor(outside.normalize()), Rgb::ZERO);
        }
    }

    #[test]
    fn size_does_not_matter() {
        // pbrt-v3 forgets to bring the direction to unit length: black from a scale of 1000 on.
        for scale in [1e-6, 1.0, 1e6] {
            let l = light(None, 45.0, Transform::scale(DVec3::splat(scale)));
            assert_eq!(l.factor(Vec3::Z), Rgb::ONE, "{scale}");
        }
    }

    #[test]
    fn power_is_the_integral_of_the_intensity() {
        for (map, fov) in [(None, 45.0), (slide(), 45.0), (slide(), 120.0)] {
            let turned = Transform::rotate(70.0, DVec3::new(1.0, 2.0, 0.5));
            let l = light(map, fov, turned);
            let n = 512;
            let mut mean = 0.0;
            for i in 0..n * n {
                let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                mean += f64::from(l.factor(uniform_sphere(u)).y) / f64::from(n * n);
            }
            let expected = f64::from(l.power(1.0).y / (4.0 * PI));
            // Four by two texels over up to a third of the sphere, their cos³ taken at the centers.
            assert!((mean / expected - 1.0).abs() < 0.04, "{mean} {expected}");
        }
    }

    #[test]
    fn fields_of_view_out_of_range_are_warned_of() {
        for (given, used, warnings) in [
            ("30", 30.0, 0),
            ("0", 45.0, 1),
            ("180", 45.0, 1),
            // Said when the file was read.
            ("nan", 45.0, 0),
        ] {
            let outcome = read("projection", &format!("\"float fov\" {given}"), fov);
            assert_eq!((outcome.value, outcome.warnings), (used, warnings));
        }
    }
}
