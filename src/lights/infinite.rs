//! `infinite` (also `exinfinite`): light from all around, constant or from an image.
//!
//! `L` (spectrum, 1): radiance, or factor of the image's texels. `scale` (spectrum, 1): factor.
//! `mapname` (string): the image, in the layout of [`super::environment_map`]; no gamma.
//! `samples`, else `nsamples` (integer, 1): samples at each point in `directlighting`.
//! Source: Pharr, Jakob and Humphreys 2016, §12.6 and §14.2.4; docs/scene-language.md §3.10.

use super::emission::{Emission, EmissionDensity, SceneSphere};
use super::environment_map::EnvironmentMap;
use super::even_sky::{self, BehindNormal};
use super::sample_count::sample_count;
use super::sky_density::Receiver;
use super::{LightBounds, LightMap, LightSample, LightType, strength};
use crate::math::angle::turns;
use crate::math::float::is_positive;
use crate::math::sampling::{UNIFORM_SPHERE_PDF, sin_cos_turns, uniform_sphere};
use crate::math::transform::Transform;
use crate::math::{Rgb, Vec2, Vec3};
use crate::params::ParamReader;
use crate::surface::{ReceiverSide, ReferencePoint, SurfaceHit};
use glam::Mat3;
use std::f32::consts::PI;

/// Parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct InfiniteSpec {
    /// How the image is turned; its translation does not count.
    pub light_to_world: Transform,
    /// Radiance, or factor of the image.
    pub radiance: Rgb,
    /// Samples at each point in `directlighting`.
    pub samples: u32,
}

impl InfiniteSpec {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader, light_to_world: &Transform) -> InfiniteSpec {
        InfiniteSpec {
            light_to_world: *light_to_world,
            radiance: strength(reader, "L"),
            samples: sample_count(reader),
        }
    }
}

/// An infinite light in render space.
#[derive(Clone, Debug)]
pub struct InfiniteLight {
    radiance: Rgb,
    map: Option<Box<PlacedMap>>,
    samples: u32,
}

impl InfiniteLight {
    /// Compiles `spec`; `map` is its image, where it has one that could be read.
    pub fn new(spec: &InfiniteSpec, map: Option<LightMap>, render_from_world: &Transform) -> Self {
        let render_from_light = *render_from_world * spec.light_to_world;
        InfiniteLight {
            radiance: spec.radiance,
            map: map
                .map(|map| Box::new(PlacedMap::new(EnvironmentMap::new(map), &render_from_light))),
            samples: spec.samples,
        }
    }

    /// Mean radiance over all directions.
    fn mean(&self) -> Rgb {
        self.map
            .as_ref()
            .map_or(self.radiance, |map| self.radiance * map.map.mean)
    }
}

impl LightType for InfiniteLight {
    const MAPPED: bool = true;
    const IS_DELTA: bool = false;
    const IS_INFINITE: bool = true;
    const IS_AT_INFINITY: bool = true;

    fn escaped(&self, d: Vec3) -> Rgb {
        match &self.map {
            Some(map) => self.radiance * map.radiance(d),
            None => self.radiance,
        }
    }

    fn sample(&self, from: &ReferencePoint, u: Vec2) -> Option<LightSample> {
        let (wi, pdf, radiance) = match &self.map {
            Some(map) => map
                .sample_from(from, u)
                .map(|(d, pdf, texel)| (d, pdf, self.radiance * texel))?,
            None => {
                let (wi, pdf) = even_sky::sample(from, u);
                (wi, pdf, self.radiance)
            }
        };
        if pdf.is_nan() || pdf <= 0.0 {
            return None;
        }
        Some(LightSample::only(radiance, wi, || from.shadow_ray_toward(wi))?.with_pdf(pdf))
    }

    fn pdf(&self, from: &ReferencePoint, wi: Vec3, _hit: Option<&SurfaceHit>) -> f32 {
        match &self.map {
            Some(map) => mixed_pdf(from, wi, map.pdf(map.receiver(from), wi)),
            None => even_sky::pdf(from, wi),
        }
    }

    fn escaped_and_pdf(&self, from: &ReferencePoint, d: Vec3) -> (Rgb, f32) {
        match &self.map {
            Some(map) => {
                let (texel, pdf) = map.radiance_and_pdf(map.receiver(from), d);
                (self.radiance * texel, mixed_pdf(from, d, pdf))
            }
            None => (self.radiance, even_sky::pdf(from, d)),
        }
    }

    /// As a receiver that light reaches from everywhere looks for it.
    fn emit(&self, scene: &SceneSphere, u_position: Vec2, u_direction: Vec2) -> Option<Emission> {
        let (toward, density, texel) = match &self.map {
            Some(map) => map.sample(Receiver::Alone, u_direction)?,
            None => (uniform_sphere(u_direction), UNIFORM_SPHERE_PDF, Rgb::ONE),
        };
        Emission::from_infinity(scene, -toward, self.radiance * texel, density, u_position)
    }

    fn emit_toward(&self, _u_position: Vec2, _d: Vec3) -> Option<Emission> {
        None
    }

    fn emission_density(&self, scene: &SceneSphere, _n: Vec3, d: Vec3) -> EmissionDensity {
        let direction = match &self.map {
            Some(map) => map.pdf(Receiver::Alone, -d),
            None => UNIFORM_SPHERE_PDF,
        };
        EmissionDensity::at_infinity(scene, direction)
    }

    /// Flux through the sphere around the scene.
    fn power(&self, scene_radius: f32) -> Rgb {
        let projected_area = PI * scene_radius * scene_radius;
        4.0 * PI * projected_area * self.mean()
    }

    fn sample_count(&self) -> u32 {
        self.samples
    }

    fn bounds(&self) -> LightBounds {
        // Irradiance under a sky of this mean radiance.
        LightBounds::everywhere(PI * self.mean())
    }
}

/// The density of `d`, given that of a map's samples alone.
fn mixed_pdf(from: &ReferencePoint, d: Vec3, of_map: f32) -> f32 {
    BehindNormal::new(from).map_or(of_map, |behind| behind.pdf(d, of_map))
}

/// A map turned, mirrored or even sheared into place.
#[derive(Clone, Debug)]
struct PlacedMap {
    map: EnvironmentMap,
    render_from_light: Mat3,
    light_from_render: Mat3,
    /// |det| of `render_from_light`.
    volume: f32,
}

impl PlacedMap {
    fn new(map: EnvironmentMap, render_from_light: &Transform) -> PlacedMap {
        // Lengths do not count.
        let m = super::of_volume_1(render_from_light);
        PlacedMap {
            map,
            render_from_light: m.as_mat3(),
            light_from_render: m.inverse().as_mat3(),
            volume: m.determinant().abs() as f32,
        }
    }

    /// A point as the map's sampling sees it.
    fn receiver(&self, from: &ReferencePoint) -> Receiver {
        // The cosine to n of M w is that to Mᵀ n of w, but for a factor that hardly changes in what is not sheared.
        let m = &self.render_from_light;
        let facing = |n: Vec3| {
            Receiver::Facing(Vec3::new(m.x_axis.dot(n), m.y_axis.dot(n), m.z_axis.dot(n)))
        };
        match from.receiver_side {
            ReceiverSide::NoMis => Receiver::Alone,
            ReceiverSide::Front if from.n != Vec3::ZERO => facing(from.n),
            ReceiverSide::Back if from.n != Vec3::ZERO => facing(-from.n),
            _ => Receiver::BothSides,
        }
    }

    /// Map coordinates of the render-space direction `d`, and sin θ there.
    fn coordinates(&self, d: Vec3) -> (Vec2, f32) {
        let w = self.light_from_render * d;
        // No lengths that could overflow: the matrix has volume 1.
        let across = (w.x * w.x + w.y * w.y).sqrt();
        let uv = Vec2::new(turns(w.x, w.y), across.atan2(w.z) / PI);
        (uv, across / w.length())
    }

    fn radiance(&self, d: Vec3) -> Rgb {
        self.map.map.lookup(self.coordinates(d).0)
    }

    /// A direction that counts for a receiver, its density, and the texels there.
    fn sample_from(&self, from: &ReferencePoint, u: Vec2) -> Option<(Vec3, f32, Rgb)> {
        let receiver = self.receiver(from);
        let Some(behind) = BehindNormal::new(from) else {
            return self.sample(receiver, u);
        };
        let (d, pdf, texel) = match behind.sample(u) {
            Some(d) => {
                let (texel, pdf) = self.radiance_and_pdf(receiver, d);
                (d, pdf, texel)
            }
            None => self.sample(receiver, behind.rest(u))?,
        };
        Some((d, behind.pdf(d, pdf), texel))
    }

    /// A direction, its density, and the texels there.
    fn sample(&self, receiver: Receiver, u: Vec2) -> Option<(Vec3, f32, Rgb)> {
        let (uv, pdf) = self.map.density.sample(receiver, u);
        let (sin_theta, cos_theta) = sin_cos_turns(0.5 * uv.y);
        let (sin_phi, cos_phi) = sin_cos_turns(uv.x);
        let w = Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta);
        let d = self.render_from_light * w;
        let length = d.length();
        let pdf = pdf / (2.0 * PI * PI * sin_theta) * self.density_change(length);
        is_positive(pdf).then(|| (d / length, pdf, self.map.map.lookup(uv)))
    }

    fn pdf(&self, receiver: Receiver, d: Vec3) -> f32 {
        let (uv, sin_theta) = self.coordinates(d);
        self.pdf_at(receiver, d, uv, sin_theta)
    }

    fn radiance_and_pdf(&self, receiver: Receiver, d: Vec3) -> (Rgb, f32) {
        let (uv, sin_theta) = self.coordinates(d);
        (
            self.map.map.lookup(uv),
            self.pdf_at(receiver, d, uv, sin_theta),
        )
    }

    fn pdf_at(&self, receiver: Receiver, d: Vec3, uv: Vec2, sin_theta: f32) -> f32 {
        if sin_theta == 0.0 {
            return 0.0;
        }
        // The unit vector w of light space with M w parallel to d has |M w| = 1 / |M⁻¹ d|.
        let length = 1.0 / (self.light_from_render * d).length();
        self.map.density.pdf(receiver, uv) / (2.0 * PI * PI * sin_theta)
            * self.density_change(length)
    }

    /// What a density per solid angle is multiplied with when a unit vector of light space becomes
    /// one of this length in render space: dω = |det M| / |M w|³ dω' for w ↦ M w / |M w|.
    fn density_change(&self, length: f32) -> f32 {
        length * length * length / self.volume
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec3;
    use crate::math::hash::{mix2, unit_float};

    const RECEIVER_SIDES: [ReceiverSide; 4] = [
        ReceiverSide::NoMis,
        ReceiverSide::BothSides,
        ReceiverSide::Front,
        ReceiverSide::Back,
    ];

    fn point(n: Vec3, receiver_side: ReceiverSide) -> ReferencePoint {
        ReferencePoint {
            p: Vec3::ONE,
            n,
            shading_n: n,
            receiver_side,
            ..Default::default()
        }
    }

    /// On a surface, also with shading normals that are tilted by 53 degrees, and seen from behind; and in a medium. With light from everywhere it
    /// may count from.
    fn points() -> impl Iterator<Item = ReferencePoint> {
        let n = Vec3::new(0.6, 0.0, 0.8);
        let tilted = [Vec3::new(-0.28, 0.0, 0.96), Vec3::new(-0.8, 0.0, -0.6)];
        let tilted = tilted.map(|shading_n| {
            RECEIVER_SIDES.map(|r| ReferencePoint {
                shading_n,
                ..point(n, r)
            })
        });
        let surface = RECEIVER_SIDES.map(|r| point(n, r));
        let medium = [ReceiverSide::NoMis, ReceiverSide::BothSides].map(|r| point(Vec3::ZERO, r));
        surface
            .into_iter()
            .chain(tilted.into_iter().flatten())
            .chain(medium)
    }

    fn constant() -> InfiniteLight {
        InfiniteLight {
            radiance: Rgb::new(1.0, 2.0, 3.0),
            map: None,
            samples: 1,
        }
    }

    fn mapped(light_to_world: Transform) -> InfiniteLight {
        let texels = (0..128)
            .map(|i| Rgb::splat(0.05 + (i % 5) as f32) * if i == 37 { 50.0 } else { 1.0 })
            .collect();
        let spec = InfiniteSpec {
            light_to_world,
            radiance: Rgb::ONE,
            samples: 1,
        };
        InfiniteLight::new(
            &spec,
            LightMap::new(16, 8, texels),
            &Transform::translate(DVec3::ONE),
        )
    }

    fn placements() -> Vec<InfiniteLight> {
        let turned = Transform::rotate(35.0, DVec3::Y) * Transform::rotate(-90.0, DVec3::X);
        vec![
            constant(),
            mapped(Transform::IDENTITY),
            mapped(turned),
            mapped(turned * Transform::scale(DVec3::new(-1.0, 1.0, 1.0))),
            mapped(Transform::scale(DVec3::new(3e6, 1e6, 2e6)) * turned),
        ]
    }

    #[test]
    fn density_integrates_to_one_and_agrees_with_samples() {
        for (k, light) in placements().into_iter().enumerate() {
            for from in points() {
                let side = 512;
                let cosine = |d: Vec3| match from.shading_n == Vec3::ZERO {
                    true => 1.0,
                    false => from.shading_n.dot(d).abs(),
                };
                // What the receiver makes of light from there.
                let received = |d: Vec3| match from.receiver_side {
                    ReceiverSide::Front if from.n.dot(d) < 0.0 => 0.0,
                    ReceiverSide::Back if from.n.dot(d) > 0.0 => 0.0,
                    _ => cosine(d),
                };
                let (mut total, mut estimate, mut integral) = (0.0, 0.0, 0.0);
                for i in 0..side * side {
                    let jitter = [1, 2].map(|k| unit_float(mix2(i, k)));
                    let corner = Vec2::new((i % side) as f32, (i / side) as f32);
                    let u = (corner + Vec2::from_array(jitter)) / side as f32;
                    let d = uniform_sphere(u);
                    let pdf = light.pdf(&from, d, None);
                    total += f64::from(pdf / UNIFORM_SPHERE_PDF);
                    integral += f64::from(received(d) * light.escaped(d).x / UNIFORM_SPHERE_PDF);
                    if let Some(s) = light.sample(&from, u) {
                        assert!((s.wi.length() - 1.0).abs() < 1e-5);
                        // Rounding may put a direction into the neighboring cell, so only the
                        // estimate below is held against the density there.
                        estimate += f64::from(received(s.wi) * s.radiance.x / s.pdf);
                    }
                }
                let count = (side * side) as f64;
                // The brightest cells are about 32 by 32 of the points: those at their border, one in eight,
                // fall inside or outside by chance, which makes 0.3 %. Four times that.
                assert!(
                    (total / count - 1.0).abs() < 0.013,
                    "{k}: {}",
                    total / count
                );
                assert!(
                    (estimate / integral - 1.0).abs() < 0.013,
                    "{k}: {}",
                    estimate / integral
                );
            }
        }
    }

    #[test]
    fn samples_carry_their_density() {
        for light in placements() {
            let mut agree = 0;
            for i in 0..1000 {
                let from = point(Vec3::Y, RECEIVER_SIDES[i % 4]);
                let u = Vec2::new((i as f32 * 0.618_034).fract(), (i as f32 + 0.5) / 1000.0);
                let s = light.sample(&from, u).unwrap();
                let pdf = light.pdf(&from, s.wi, None);
                // Single-precision angles: a relative error of a few 1e-6 over sin θ.
                agree += i32::from((pdf / s.pdf - 1.0).abs() < 1e-3);
            }
            // All but those that rounding moves over a cell's border.
            assert!(agree >= 995, "{agree}");
        }
    }

    #[test]
    fn map_is_laid_out_as_pbrt_does() {
        // One bright texel in each of four places of a 4 × 2 map.
        for (texel, direction) in [
            (0, Vec3::new(1.0, 1.0, 1.4)),
            (1, Vec3::new(-1.0, 1.0, 1.4)),
            (4, Vec3::new(1.0, 1.0, -1.4)),
            (7, Vec3::new(1.0, -1.0, -1.4)),
        ] {
            let mut texels = vec![Rgb::ZERO; 8];
            texels[texel] = Rgb::ONE;
            let spec = InfiniteSpec {
                light_to_world: Transform::IDENTITY,
                radiance: Rgb::ONE,
                samples: 1,
            };
            let light =
                InfiniteLight::new(&spec, LightMap::new(4, 2, texels), &Transform::IDENTITY);
            let away = light.escaped(-direction.normalize()).x;
            assert!(
                light.escaped(direction.normalize()).x > 0.8 && away < 0.1,
                "{texel}"
            );
        }
    }

    /// Constant light at a receiver that scatters evenly is known without noise, however its shading normal is tilted.
    #[test]
    fn constant_light_is_sampled_by_what_it_brings() {
        let light = constant();
        for from in points().filter(|from| from.receiver_side != ReceiverSide::NoMis) {
            let in_medium = from.n == Vec3::ZERO;
            let all = match from.receiver_side {
                _ if in_medium => 4.0 * PI,
                ReceiverSide::BothSides => 2.0 * PI,
                _ => PI,
            };
            for i in 0..1000 {
                let i = i as f32 + 0.5;
                let u = Vec2::new(i / 1000.0, (i * 0.618_034).fract());
                let s = light.sample(&from, u).unwrap();
                let cosine = from.shading_n.dot(s.wi).abs();
                let brings = if in_medium { 1.0 } else { cosine } / s.pdf;
                assert!((brings / all - 1.0).abs() < 1e-5, "{from:?}");
                let side = s.wi.dot(from.n);
                match from.receiver_side {
                    ReceiverSide::Front => assert!(side > -1e-6),
                    ReceiverSide::Back => assert!(side < 1e-6),
                    _ => {}
                }
            }
        }
        // By light sampling alone all directions are.
        let horizon = light.pdf(&point(Vec3::Z, ReceiverSide::NoMis), Vec3::X, None);
        assert_eq!(horizon, 0.125 * UNIFORM_SPHERE_PDF);
    }

    /// Tilted by a bump, a surface has light from behind its shading normal, which BSDF sampling does not find: no sample of it may bring more
    /// than twice what there is in all.
    #[test]
    fn what_lies_behind_a_shading_normal_is_not_rare() {
        let spec = InfiniteSpec {
            light_to_world: Transform::IDENTITY,
            radiance: Rgb::ONE,
            samples: 1,
        };
        let map = LightMap::new(64, 32, vec![Rgb::ONE; 2048]);
        let light = InfiniteLight::new(&spec, map, &Transform::IDENTITY);
        let map = light.map.as_ref().unwrap();
        let shading_n = Vec3::new(0.8, 0.0, 0.6);
        for side in [1.0, -1.0] {
            let from = ReferencePoint {
                shading_n: side * shading_n,
                ..point(Vec3::Z, ReceiverSide::Front)
            };
            let (mut most, mut most_of_map) = (0f32, 0f32);
            for i in 0..4096 {
                let u = Vec2::new((i as f32 + 0.5) / 4096.0, (i as f32 * 0.618_034).fract());
                let Some(s) = light.sample(&from, u) else {
                    continue;
                };
                let is_behind = s.wi.z > 0.0 && s.wi.dot(from.shading_n) < 0.0;
                if is_behind {
                    let counts = s.radiance.x * from.shading_n.dot(s.wi).abs();
                    most = most.max(counts / s.pdf);
                    most_of_map = most_of_map.max(counts / map.pdf(map.receiver(&from), s.wi));
                }
            }
            assert!(most > 0.5 * PI && most < 2.001 * PI, "{most}");
            assert!(most_of_map > 4.0 * PI, "{most_of_map}");
        }
    }

    /// Light is sought on the side that counts, however the image is placed.
    #[test]
    fn samples_lie_before_the_receiver() {
        let spec = InfiniteSpec {
            light_to_world: Transform::rotate(35.0, DVec3::Y) * Transform::rotate(-90.0, DVec3::X),
            radiance: Rgb::ONE,
            samples: 1,
        };
        let even = LightMap::new(64, 32, vec![Rgb::ONE; 2048]);
        let mapped = InfiniteLight::new(&spec, even, &Transform::IDENTITY);
        for light in [constant(), mapped] {
            for n in [Vec3::Y, Vec3::new(0.6, 0.0, -0.8), Vec3::NEG_Z] {
                for (receiver_side, side) in
                    [(ReceiverSide::Front, 1.0), (ReceiverSide::Back, -1.0)]
                {
                    let from = point(n, receiver_side);
                    let before = (0..1000)
                        .filter_map(|i| {
                            let u = Vec2::new((i as f32 * 0.618_034).fract(), i as f32 / 1000.0);
                            light.sample(&from, u)
                        })
                        .filter(|s| side * s.wi.dot(n) > 0.0)
                        .count();
                    // Some lie in what a class of normals has beyond this one's horizon.
                    assert!(before > 900, "{n} {receiver_side:?}: {before}");
                }
            }
        }
    }
}
