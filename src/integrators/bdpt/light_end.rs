//! The light's end of a path x₀ x₁ …: the densities with which x₀ is found by each of the three ways that begin or end there.

use crate::handles::LightId;
use crate::integrators::context::Lights;
use crate::lights::{EmissionDensity, Light, LightEnd};
use crate::math::Vec2;
use crate::math::Vec3;
use crate::surface::{ReferencePoint, ShadingGeometry, SurfaceHit};
use crate::world::World;

/// Densities at x₀ and, from there, at x₁. Those of x₀ are per area of the light; for a light at infinity per solid angle, for a
/// light without area probabilities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightDensities {
    /// With which emitter sampling from x₁ chooses x₀.
    pub direct: f64,
    /// With which a path begins at x₀.
    pub emitted: f64,
    /// Per area, with which a path that began at x₀ comes to x₁.
    pub onward: f64,
    /// Turns a density per solid angle at x₁ into the measure of x₀.
    pub backward: f64,
}

/// A light as x₁ sees it.
pub(super) struct Lit<'a> {
    /// Which.
    pub id: LightId,
    /// Where on it; the point does not matter for a light at infinity.
    pub end: LightEnd,
    /// x₁, and the cosine there.
    pub from: &'a ReferencePoint,
    pub cosine: f32,
    /// Unit direction from x₁ toward the light.
    pub wi: Vec3,
    /// Density per solid angle with which [`crate::lights::Light::sample`] chooses `wi`; 1 for a light without area.
    pub pdf: f32,
}

impl Lit<'_> {
    /// The probability with which emitter sampling at x₁ chooses this light is `pmf`.
    pub(super) fn densities(&self, world: &World, lights: &Lights, pmf: f32) -> LightDensities {
        let emitters = lights.emitters.as_ref();
        let begins = emitters.map_or(0.0, |emitters| emitters.choice.pmf(self.id));
        let Some(emitters) = emitters.filter(|_| begins > 0.0) else {
            return LightDensities {
                direct: f64::from(pmf) * f64::from(self.pdf),
                emitted: 0.0,
                onward: 0.0,
                backward: 1.0,
            };
        };
        let density = emitters.density(world, self.id, self.end.n, self.from.p, -self.wi);
        self.densities_of(world.light(self.id), pmf, begins, density)
    }

    /// [`Lit::densities`] where paths begin at this light with the probability `begins`, and leave it with `density` as they would
    /// come to x₁.
    pub(super) fn densities_of(
        &self,
        light: &Light,
        pmf: f32,
        begins: f32,
        density: EmissionDensity,
    ) -> LightDensities {
        let begins = f64::from(begins);
        let LightEnd { p, n } = self.end;
        let (position, direction) = (f64::from(density.position), f64::from(density.direction));
        let (direct, cosine) = (f64::from(pmf) * f64::from(self.pdf), f64::from(self.cosine));
        if light.is_at_infinity() {
            return LightDensities {
                direct,
                emitted: begins * direction,
                onward: position * cosine,
                backward: 1.0,
            };
        }
        let distance2 = (p.as_dvec3() - self.from.p.as_dvec3()).length_squared();
        let delta = n == Vec3::ZERO;
        let at_light = if delta {
            1.0
        } else {
            f64::from(n.dot(self.wi).abs())
        };
        let backward = if delta { 1.0 } else { at_light / distance2 };
        LightDensities {
            direct: direct * backward,
            emitted: begins * position,
            onward: direction * cosine / distance2,
            backward,
        }
    }
}

/// The point on a light where a ray in direction `wo` begins, as if a ray had met it there.
pub(super) fn end_as_hit(end: &LightEnd, wo: Vec3, time: f32) -> SurfaceHit {
    SurfaceHit {
        p: end.p,
        p_error: Vec3::ZERO,
        n: end.n,
        uv: Vec2::ZERO,
        dpdu: Vec3::ZERO,
        dpdv: Vec3::ZERO,
        shading: ShadingGeometry {
            n: end.n,
            dpdu: Vec3::ZERO,
            dpdv: Vec3::ZERO,
            dndu: Vec3::ZERO,
            dndv: Vec3::ZERO,
        },
        wo,
        time,
        face: 0,
    }
}
