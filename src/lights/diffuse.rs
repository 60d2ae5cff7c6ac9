//! `diffuse` (also `area`): a shape that emits the same radiance everywhere and in all directions
//! on the side of its normal.
//!
//! `L` (spectrum, 1): radiance. `scale` (spectrum, 1): factor. `twosided` (bool, false): both
//! sides emit. `samples`, else `nsamples` (integer, 1): samples at each point in `directlighting`.
//! Source: Pharr, Jakob and Humphreys 2016, §12.5; docs/scene-language.md §3.11 and §4.5.

use super::emission::{Emission, EmissionDensity, LightEnd, SceneSphere};
use super::sample_count::{quick, sample_count};
use super::{LightBounds, LightSample, LightType, strength};
use crate::math::color::is_black;
use crate::math::frame::Frame;
use crate::math::sampling::{cosine_hemisphere, cosine_hemisphere_pdf};
use crate::math::{Rgb, Vec2, Vec3};
use crate::params::ParamReader;
use crate::shapes::emitter::{AreaSample, Emitter, EmitterSample};
use crate::surface::{ReferencePoint, SurfaceHit};
use std::f32::consts::PI;

/// What an `AreaLightSource` gives the shapes after it.
#[derive(Clone, Debug, PartialEq)]
pub struct DiffuseAreaSpec {
    /// Emitted radiance.
    pub radiance: Rgb,
    /// `true` if the side away from the normal emits too.
    pub two_sided: bool,
    /// Samples at each point in `directlighting`.
    pub samples: u32,
    /// In pbrt-v2 all pieces of a shape are one light.
    pub one_light: bool,
}

impl DiffuseAreaSpec {
    /// Reads an `AreaLightSource`. `None`, after a warning, for an unknown type; silently for the
    /// empty one, which switches emission off.
    pub fn from_params(reader: &ParamReader) -> Option<DiffuseAreaSpec> {
        match reader.kind() {
            "diffuse" | "area" => Some(DiffuseAreaSpec {
                radiance: strength(reader, "L"),
                two_sided: reader.boolean("twosided", false),
                samples: sample_count(reader),
                one_light: reader.means_v2(""),
            }),
            "" => None,
            _ => {
                reader.unknown_kind_replaced(&["diffuse", "area"], "the shapes will not emit");
                None
            }
        }
    }

    /// A quarter of the samples at each point, for a quick look (`--quick`).
    pub fn make_quick(&mut self) {
        self.samples = quick(self.samples);
    }
}

/// How a surface shines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Glow {
    /// Emitted radiance.
    pub radiance: Rgb,
    /// `true` if the side away from the normal emits too.
    pub two_sided: bool,
}

impl Glow {
    /// Radiance that leaves in unit direction `w` where the normal is `n`.
    #[inline(always)]
    fn toward(&self, n: Vec3, w: Vec3) -> Rgb {
        if self.two_sided | (n.dot(w) > 0.0) {
            self.radiance
        } else {
            Rgb::ZERO
        }
    }

    /// Light from a chosen point, which may be none; without a branch.
    #[inline(always)]
    pub(crate) fn arriving(&self, from: &ReferencePoint, chosen: &EmitterSample) -> LightSample {
        LightSample {
            radiance: self.toward(chosen.n, -chosen.wi),
            wi: chosen.wi,
            pdf: chosen.pdf,
            delta: false,
            shadow: from.shadow_ray_to(chosen.p, chosen.p_error, chosen.n),
        }
    }
}

/// An emitting shape in render space.
#[derive(Clone, Debug)]
pub struct DiffuseAreaLight {
    emitter: Emitter,
    spec: DiffuseAreaSpec,
    group: u32,
}

impl DiffuseAreaLight {
    /// The light of one emitter; those of one mesh share a `group` number of their own.
    pub fn new(spec: &DiffuseAreaSpec, emitter: Emitter, group: u32) -> DiffuseAreaLight {
        let spec = spec.clone();
        DiffuseAreaLight {
            emitter,
            spec,
            group,
        }
    }

    fn glow(&self) -> Glow {
        Glow {
            radiance: self.spec.radiance,
            two_sided: self.spec.two_sided,
        }
    }

    /// Radiance that leaves in unit direction `w` where the normal is `n`.
    #[inline]
    fn toward(&self, n: Vec3, w: Vec3) -> Rgb {
        self.glow().toward(n, w)
    }

    /// Light from a chosen point.
    #[inline]
    fn arriving(&self, from: &ReferencePoint, chosen: &EmitterSample) -> Option<LightSample> {
        let glow = self.glow();
        let dark = is_black(glow.toward(chosen.n, -chosen.wi));
        (!dark).then(|| glow.arriving(from, chosen))
    }

    /// What shines, and how.
    #[inline]
    pub(crate) fn parts(&self) -> (&Emitter, Glow) {
        (&self.emitter, self.glow())
    }

    /// A direction into which a point with the normal `n` shines, by its cosine.
    fn direction(&self, n: Vec3, u: Vec2) -> Vec3 {
        let (side, y) = match (self.spec.two_sided, u.y < 0.5) {
            (false, _) => (1.0, u.y),
            (true, true) => (1.0, 2.0 * u.y),
            (true, false) => (-1.0, 2.0 * u.y - 1.0),
        };
        side * Frame::from_normal(n).to_world(cosine_hemisphere(Vec2::new(u.x, y)))
    }

    /// Density per solid angle of [`DiffuseAreaLight::direction`].
    fn direction_density(&self, n: Vec3, d: Vec3) -> f32 {
        let cos = n.dot(d);
        if self.spec.two_sided {
            0.5 * cosine_hemisphere_pdf(cos.abs())
        } else {
            cosine_hemisphere_pdf(cos)
        }
    }

    /// Returns `true` if it counts as a part of its group's one light.
    pub fn is_part(&self) -> bool {
        self.spec.one_light
    }

    /// Area of the emitter, render space.
    pub fn area(&self) -> f64 {
        self.emitter.area()
    }

    /// The ray from a point in unit direction `d`.
    fn from_chosen(&self, chosen: &AreaSample, d: Vec3) -> Option<Emission> {
        let emission = Emission {
            p: chosen.p,
            p_error: chosen.p_error,
            n: chosen.n,
            d,
            light: self.toward(chosen.n, d),
            density: EmissionDensity {
                position: chosen.density,
                direction: self.direction_density(chosen.n, d),
            },
        };
        emission.if_any()
    }

    /// A point of the emitter that `p` sees, and the normal there.
    fn look_from(&self, p: Vec3, u: f32) -> Option<(Vec3, Vec3)> {
        let eye = ReferencePoint {
            p,
            ..Default::default()
        };
        // The second number goes round while the first goes through.
        let chosen = self.emitter.sample(&eye, Vec2::new(u, (u * 7.0).fract()))?;
        (chosen.p.is_finite() && chosen.n.is_finite()).then_some((chosen.p, chosen.n))
    }
}

impl LightType for DiffuseAreaLight {
    const IS_DELTA: bool = false;

    fn sample(&self, from: &ReferencePoint, u: Vec2) -> Option<LightSample> {
        let chosen = self.emitter.sample(from, u)?;
        self.arriving(from, &chosen)
    }

    fn sample_with_end(&self, from: &ReferencePoint, u: Vec2) -> Option<(LightSample, LightEnd)> {
        let chosen = self.emitter.sample(from, u)?;
        let EmitterSample { p, n, .. } = chosen;
        Some((self.arriving(from, &chosen)?, LightEnd { p, n }))
    }

    fn emit(&self, _scene: &SceneSphere, u_position: Vec2, u_direction: Vec2) -> Option<Emission> {
        let chosen = self.emitter.sample_area(u_position);
        self.from_chosen(&chosen, self.direction(chosen.n, u_direction))
    }

    fn emit_toward(&self, u_position: Vec2, d: Vec3) -> Option<Emission> {
        self.from_chosen(&self.emitter.sample_area(u_position), d)
    }

    fn emission_density(&self, _scene: &SceneSphere, n: Vec3, d: Vec3) -> EmissionDensity {
        EmissionDensity {
            position: self.emitter.area_density(n),
            direction: self.direction_density(n, d),
        }
    }

    fn pdf(&self, from: &ReferencePoint, wi: Vec3, hit: Option<&SurfaceHit>) -> f32 {
        hit.map_or(0.0, |hit| self.emitter.pdf(from, wi, hit))
    }

    fn emitted(&self, hit: &SurfaceHit) -> Rgb {
        self.toward(hit.n, hit.wo)
    }

    /// Flux.
    fn power(&self, _scene_radius: f32) -> Rgb {
        let sides = if self.spec.two_sided { 2.0 } else { 1.0 };
        sides * PI * self.emitter.area() as f32 * self.spec.radiance
    }

    fn sample_count(&self) -> u32 {
        self.spec.samples
    }

    /// The mesh this emitter is a piece of.
    fn group(&self) -> Option<u32> {
        Some(self.group)
    }

    /// Looks at the emitter from six sides to see roughly where it lies and whether it is flat.
    fn bounds(&self) -> LightBounds {
        // From one point of a sphere, this far away is outside it; a piece of a plane cannot be
        // seen edge-on from all of these at once.
        let size = 2.0 * (self.emitter.area() as f32).sqrt();
        let eyes = [Vec3::ZERO, size * Vec3::X, size * Vec3::Y, size * Vec3::Z];
        let Some(first) = eyes.into_iter().find_map(|eye| self.look_from(eye, 0.5)) else {
            return LightBounds::nowhere();
        };
        let sides = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
        let numbers = [0.1, 0.9, 0.3, 0.7, 0.5, 0.95];
        let seen = sides
            .into_iter()
            .zip(numbers)
            .filter_map(|(side, u)| self.look_from(first.0 + size * side, u));
        let (mut low, mut high, mut flat) = (first.0, first.0, true);
        for (p, n) in seen {
            (low, high) = (low.min(p), high.max(p));
            // A thousandth: 2.6 degrees.
            flat &= n.dot(first.1) > 0.999;
        }
        let area = self.emitter.area() as f32;
        match (flat, self.spec.two_sided) {
            (true, false) => {
                LightBounds::area(low, high, area * self.spec.radiance).on_side(first.1)
            }
            (true, true) => LightBounds::area(low, high, area * self.spec.radiance),
            // A convex shape shows a quarter of its area, on average over all directions (Cauchy).
            (false, _) => LightBounds::area(low, high, 0.25 * area * self.spec.radiance),
        }
    }
}

/// A triangle that emits, for tests.
#[cfg(test)]
pub(super) fn triangle_emitter(corners: [Vec3; 3]) -> Emitter {
    let orientation = crate::shapes::triangle::Orientation::default();
    let triangle = crate::shapes::emitter::TriangleEmitter::new(corners, None, orientation);
    Emitter::Triangle(triangle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::ShadingGeometry;

    const CORNERS: [Vec3; 3] = [
        Vec3::new(-1.0, 2.0, -1.0),
        Vec3::new(1.0, 2.0, -1.0),
        Vec3::new(0.0, 2.5, 1.5),
    ];

    fn light(two_sided: bool) -> DiffuseAreaLight {
        let spec = DiffuseAreaSpec {
            radiance: Rgb::new(3.0, 2.0, 1.0),
            two_sided,
            samples: 1,
            one_light: false,
        };
        DiffuseAreaLight::new(&spec, triangle_emitter(CORNERS), 0)
    }

    fn normal() -> Vec3 {
        (CORNERS[1] - CORNERS[0])
            .cross(CORNERS[2] - CORNERS[0])
            .normalize()
    }

    fn point(p: Vec3) -> ReferencePoint {
        ReferencePoint {
            p,
            time: 0.25,
            ..Default::default()
        }
    }

    fn hit(p: Vec3, wo: Vec3) -> SurfaceHit {
        let zero = Vec3::ZERO;
        let n = normal();
        SurfaceHit {
            p,
            p_error: zero,
            n,
            uv: Vec2::ZERO,
            dpdu: zero,
            dpdv: zero,
            shading: ShadingGeometry {
                n,
                dpdu: zero,
                dpdv: zero,
                dndu: zero,
                dndv: zero,
            },
            wo,
            time: 0.0,
            face: 0,
        }
    }

    #[test]
    fn emits_on_the_side_of_its_normal_or_on_both() {
        let p = (CORNERS[0] + CORNERS[1] + CORNERS[2]) / 3.0;
        for (two_sided, side, bright) in [
            (false, 1.0, true),
            (false, -1.0, false),
            (true, 1.0, true),
            (true, -1.0, true),
        ] {
            let l = light(two_sided);
            let expected = if bright { l.spec.radiance } else { Rgb::ZERO };
            assert_eq!(l.emitted(&hit(p, side * normal())), expected);
            let sample = l.sample(&point(p + side * normal()), Vec2::new(0.3, 0.6));
            assert_eq!(sample.map(|s| s.radiance), bright.then_some(expected));
        }
    }

    #[test]
    fn samples_agree_with_their_density_and_the_solid_angle() {
        let l = light(true);
        let from = point(Vec3::new(0.2, 0.0, 0.1));
        let n = 300;
        let mut solid_angle = 0.0;
        for i in 0..n * n {
            let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            let s = l.sample(&from, u).unwrap();
            let p = s.shadow.at(s.shadow.t_max);
            let pdf = l.pdf(&from, s.wi, Some(&hit(p, -s.wi)));
            // The shadow ray ends a ten-thousandth early.
            assert!((pdf / s.pdf - 1.0).abs() < 1e-3);
            assert!((s.wi.length() - 1.0).abs() < 1e-6 && s.shadow.time == 0.25);
            solid_angle += 1.0 / f64::from(s.pdf) / f64::from(n * n);
        }
        // Van Oosterom and Strackee 1983, equation 8.
        let [a, b, c] = CORNERS.map(|q| (q - from.p).as_dvec3());
        let (x, y, z) = (a.length(), b.length(), c.length());
        let below = x * y * z + a.dot(b) * z + a.dot(c) * y + b.dot(c) * x;
        let expected = 2.0 * a.dot(b.cross(c)).abs().atan2(below);
        // A midpoint sum over 300² points.
        assert!(
            (solid_angle / expected - 1.0).abs() < 1e-4,
            "{solid_angle} but {expected}"
        );
    }

    #[test]
    fn power_counts_sides() {
        let area = light(false).emitter.area() as f32;
        assert!((light(false).power(1.0).x - 3.0 * PI * area).abs() < 1e-4);
        assert_eq!(light(true).power(1.0), 2.0 * light(false).power(1.0));
    }
}
