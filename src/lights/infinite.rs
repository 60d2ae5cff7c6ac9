//! `infinite` (also `exinfinite`): light from all around, constant or from an image.
//!
//! `L` (spectrum, 1): radiance, or factor of the image's texels. `scale` (spectrum, 1): factor.
//! `mapname` (string): the image, in the layout of [`super::environment_map`]; no gamma.
//! `samples`, else `nsamples` (integer, 1): samples at each point in `directlighting`.
//! Source: Pharr, Jakob and Humphreys 2016, §12.6 and §14.2.4; docs/scene-language.md §3.10.

use super::emission::{Emission, EmissionDensity, SceneSphere};
use super::environment_map::EnvironmentMap;
use super::sample_count::sample_count;
use super::sky_density::Receiver;
use super::{LightBounds, LightMap, LightSample, LightType, strength};
use crate::math::angle::turns;
use crate::math::float::is_positive;
use crate::math::frame::Frame;
use crate::math::sampling::{
    UNIFORM_SPHERE_PDF, cosine_hemisphere, cosine_hemisphere_pdf, sin_cos_turns, uniform_sphere,
};
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
                .sample(map.receiver(from), u)
                .map(|(d, pdf, texel)| (d, pdf, self.radiance * texel))?,
            None => {
                let (wi, pdf) = sample_constant(from, u);
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
            Some(map) => map.pdf(map.receiver(from), wi),
            None => constant_pdf(from, wi),
        }
    }

    fn escaped_and_pdf(&self, from: &ReferencePoint, d: Vec3) -> (Rgb, f32) {
        match &self.map {
            Some(map) => {
                let (texel, pdf) = map.radiance_and_pdf(map.receiver(from), d);
                (self.radiance * texel, pdf)
            }
            None => (self.radiance, constant_pdf(from, d)),
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

    fn reach(&self) -> LightBounds {
        // Irradiance under a sky of this mean radiance.
        LightBounds::everywhere(PI * self.mean())
    }
}

/// Share of directions toward a constant light that is chosen uniformly. The rest follows the
/// cosine at the receiver, which vanishes at the horizon of the true surface but not always at
/// that of a shading normal.
const UNIFORM_SHARE: f32 = 0.125;

/// A direction and its density for light that comes equally from everywhere: by the cosine at a surface, on the sides that
/// count; evenly in a medium.
fn sample_constant(from: &ReferencePoint, u: Vec2) -> (Vec3, f32) {
    let n = from.n;
    if n == Vec3::ZERO {
        return (uniform_sphere(u), UNIFORM_SPHERE_PDF);
    }
    let wi = if u.x < UNIFORM_SHARE {
        uniform_sphere(Vec2::new(u.x / UNIFORM_SHARE, u.y))
    } else {
        let x = (u.x - UNIFORM_SHARE) / (1.0 - UNIFORM_SHARE);
        let (side, y) = match from.receiver_side {
            ReceiverSide::Front => (1.0, u.y),
            ReceiverSide::Back => (-1.0, u.y),
            ReceiverSide::NoMis | ReceiverSide::BothSides if u.y < 0.5 => (1.0, 2.0 * u.y),
            ReceiverSide::NoMis | ReceiverSide::BothSides => (-1.0, 2.0 * u.y - 1.0),
        };
        side * Frame::from_normal(n).to_world(cosine_hemisphere(Vec2::new(x, y)))
    };
    (wi, constant_pdf(from, wi))
}

/// Density of [`sample_constant`].
fn constant_pdf(from: &ReferencePoint, wi: Vec3) -> f32 {
    if from.n == Vec3::ZERO {
        return UNIFORM_SPHERE_PDF;
    }
    let cosine = from.n.dot(wi);
    let by_cosine = match from.receiver_side {
        ReceiverSide::Front => cosine_hemisphere_pdf(cosine),
        ReceiverSide::Back => cosine_hemisphere_pdf(-cosine),
        ReceiverSide::NoMis | ReceiverSide::BothSides => 0.5 * cosine_hemisphere_pdf(cosine.abs()),
    };
    UNIFORM_SHARE * UNIFORM_SPHERE_PDF + (1.0 - UNIFORM_SHARE) * by_cosine
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
            p_error: Vec3::ZERO,
            n,
            time: 0.0,
            receiver_side,
        }
    }

    /// In a medium and on a surface, with light from everywhere it may count from.
    fn points() -> impl Iterator<Item = ReferencePoint> {
        let surface = RECEIVER_SIDES.map(|r| point(Vec3::new(0.6, 0.0, 0.8), r));
        let medium = [ReceiverSide::NoMis, ReceiverSide::BothSides].map(|r| point(Vec3::ZERO, r));
        surface.into_iter().chain(medium)
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
                // What the receiver makes of light from there.
                let received = |d: Vec3| match from.receiver_side {
                    ReceiverSide::Front if from.n != Vec3::ZERO => from.n.dot(d).max(0.0),
                    ReceiverSide::Back if from.n != Vec3::ZERO => from.n.dot(-d).max(0.0),
                    _ => 1.0,
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

    #[test]
    fn constant_light_favors_the_receivers_normal() {
        let pdf = |receiver_side, wi| constant_pdf(&point(Vec3::Z, receiver_side), wi);
        for receiver_side in [ReceiverSide::NoMis, ReceiverSide::BothSides] {
            assert!(pdf(receiver_side, Vec3::Z) > 1.7 * UNIFORM_SPHERE_PDF);
            assert_eq!(pdf(receiver_side, Vec3::Z), pdf(receiver_side, -Vec3::Z));
        }
        assert!(pdf(ReceiverSide::Front, Vec3::Z) > 3.5 * UNIFORM_SPHERE_PDF);
        assert_eq!(
            pdf(ReceiverSide::Back, -Vec3::Z),
            pdf(ReceiverSide::Front, Vec3::Z)
        );
        for receiver_side in RECEIVER_SIDES {
            assert_eq!(
                pdf(receiver_side, Vec3::X),
                UNIFORM_SHARE * UNIFORM_SPHERE_PDF
            );
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
                    // A sixteenth of the samples is spread evenly on the wrong side, or lies in what a class of
                    // normals has beyond this one's horizon.
                    assert!(before > 900, "{n} {receiver_side:?}: {before}");
                }
            }
        }
    }
}
