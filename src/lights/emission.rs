//! Light as it leaves its source: where the paths of bidirectional methods and of photons begin.
//!
//! A light chooses a ray, by a density over its area and one over directions; the flux that the ray represents is what the
//! light emits there over both. Lights at infinity have no area: their rays start from a disk as wide as the scene, which
//! faces them just outside the scene's bounding sphere. Each type does this in its own file, where its formulas are.
//! Source: Veach 1997, ch. 8 and 10; Pharr, Jakob and Humphreys 2016, §16.1.2.

use super::{LightSample, LightType};
use crate::math::color::is_black;
use crate::math::float::{is_positive, offset_ray_origin};
use crate::math::frame::Frame;
use crate::math::ray::Ray;
use crate::math::sampling::concentric_disk;
use crate::math::{Rgb, Vec2, Vec3};
use crate::surface::ReferencePoint;
use glam::{DMat3, Mat3};
use std::f32::consts::PI;

/// The sphere around the scene, render space.
#[derive(Clone, Copy, Debug)]
pub struct SceneSphere {
    /// Center.
    pub center: Vec3,
    /// Radius.
    pub radius: f32,
}

/// How far from the center lights at infinity begin, in radii: what touches the sphere from within is met.
const OUTSIDE: f32 = 1.001;

impl SceneSphere {
    /// A point of the disk that faces light traveling in unit direction `d`, evenly.
    pub(super) fn disk_point(&self, d: Vec3, u: Vec2) -> Vec3 {
        self.on_disk(d, concentric_disk(u))
    }

    /// The point of the disk's plane that is `at` radii from its center across `d`.
    pub(super) fn on_disk(&self, d: Vec3, at: Vec2) -> Vec3 {
        self.center + self.radius * Frame::from_normal(d).to_world(at.extend(-OUTSIDE))
    }

    /// How many radii `p` is from the center, across `d`: the inverse of [`SceneSphere::on_disk`].
    pub(super) fn across(&self, d: Vec3, p: Vec3) -> Vec2 {
        Frame::from_normal(d)
            .to_local((p - self.center) / self.radius)
            .truncate()
    }

    /// Density of [`SceneSphere::disk_point`] per area.
    pub(super) fn disk_density(&self) -> f32 {
        1.0 / (PI * self.radius * self.radius)
    }
}

/// A ray of light as it leaves its source.
#[derive(Clone, Copy, Debug, Default)]
pub struct Emission {
    /// Its origin, render space; for lights at infinity a point outside the scene's sphere.
    pub p: Vec3,
    /// Half-widths of the box around `p` that holds the exact point.
    pub p_error: Vec3,
    /// Unit geometric normal at `p`, on the side that hits report; zero for lights without area and at infinity.
    pub n: Vec3,
    /// Unit direction in which the light travels.
    pub d: Vec3,
    /// Radiance of area and infinite lights; intensity of lights at a point; of a distant light, irradiance on a facing
    /// surface.
    pub light: Rgb,
    /// How the ray was chosen.
    pub density: EmissionDensity,
}

/// The densities with which a light chooses a ray. A choice that has no alternative counts as 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EmissionDensity {
    /// Of the origin per area: on the emitter, or on the disk perpendicular to the ray for lights at infinity; 1 for lights
    /// at a point.
    pub position: f32,
    /// Of the direction per steradian; 1 for distant lights.
    pub direction: f32,
}

impl EmissionDensity {
    /// 0 for what is no density, and never chosen.
    pub(super) fn or_zero(self) -> EmissionDensity {
        let or_zero = |density: f32| match is_positive(density) {
            true => density,
            false => 0.0,
        };
        EmissionDensity {
            position: or_zero(self.position),
            direction: or_zero(self.direction),
        }
    }

    /// Of a light at a point.
    pub(super) fn of_point(direction: f32) -> EmissionDensity {
        EmissionDensity {
            position: 1.0,
            direction,
        }
    }

    /// Of a light at infinity.
    pub(super) fn at_infinity(scene: &SceneSphere, direction: f32) -> EmissionDensity {
        EmissionDensity {
            position: scene.disk_density(),
            direction,
        }
    }
}

impl Emission {
    /// From a light at the point `p`.
    pub(super) fn from_point(p: Vec3, d: Vec3, intensity: Rgb, density: f32) -> Option<Emission> {
        let emission = Emission {
            p,
            p_error: Vec3::ZERO,
            n: Vec3::ZERO,
            d,
            light: intensity,
            density: EmissionDensity::of_point(density),
        };
        emission.if_any()
    }

    /// From infinity in unit direction `d`, chosen with the density `direction`.
    pub(super) fn from_infinity(
        scene: &SceneSphere,
        d: Vec3,
        light: Rgb,
        direction: f32,
        u_position: Vec2,
    ) -> Option<Emission> {
        let emission = Emission {
            p: scene.disk_point(d, u_position),
            p_error: Vec3::ZERO,
            n: Vec3::ZERO,
            d,
            light,
            density: EmissionDensity::at_infinity(scene, direction),
        };
        emission.if_any()
    }

    /// Itself where it brings something, and all its numbers are finite.
    pub(super) fn if_any(self) -> Option<Emission> {
        let EmissionDensity {
            position,
            direction,
        } = self.density.or_zero();
        let finite = self.p.is_finite() && self.d.is_finite() && self.light.is_finite();
        (finite && position > 0.0 && direction > 0.0 && !is_black(self.light)).then_some(self)
    }

    /// Cosine between ray and normal, either side; 1 where there is no normal.
    pub fn cosine(&self) -> f32 {
        if self.n == Vec3::ZERO {
            1.0
        } else {
            self.n.dot(self.d).abs()
        }
    }

    /// The flux that the ray represents: its mean over all choices is that of the light.
    pub fn flux(&self) -> Rgb {
        // Each factor by itself: the product of the densities may overflow.
        self.light * (self.cosine() / self.density.direction) / self.density.position
    }

    /// The ray, leaving at `time` from outside the error box.
    pub fn ray(&self, time: f32) -> Ray {
        let o = offset_ray_origin(self.p, self.p_error, self.n, self.d);
        Ray::new(o, self.d, time)
    }
}

/// Where on a light a sample of it came from.
#[derive(Clone, Copy, Debug)]
pub struct LightEnd {
    /// The point, render space; means nothing for lights at infinity.
    pub p: Vec3,
    /// Unit geometric normal there, on the side that hits report; zero where there is none.
    pub n: Vec3,
}

/// [`LightType::sample_with_end`] of a light without area, at `p` if it is anywhere.
#[inline(always)]
pub(super) fn sample_of_point(
    light: &impl LightType,
    p: Vec3,
    from: &ReferencePoint,
    u: Vec2,
) -> Option<(LightSample, LightEnd)> {
    let n = Vec3::ZERO;
    Some((light.sample(from, u)?, LightEnd { p, n }))
}

/// Directions of a light's own space, which its transformation may deform, in render space. In double precision: the
/// matrix may have any scale.
pub(super) struct Directions {
    light_from_render: DMat3,
}

impl Directions {
    /// Made for each use: it takes less than a ray.
    pub(super) fn new(light_from_render: &Mat3) -> Directions {
        let light_from_render = light_from_render.as_dmat3();
        Directions { light_from_render }
    }

    /// The unit direction in render space of the light's direction `w`.
    pub(super) fn to_render(&self, w: Vec3) -> Vec3 {
        let d = self.light_from_render.inverse() * w.as_dvec3();
        d.normalize_or_zero().as_vec3()
    }

    /// What a density per solid angle in light space is multiplied with to be one in render space, at the unit direction
    /// `d` there: dω' = |det M| / |M d|³ dω for d ↦ M d / |M d|.
    pub(super) fn density_change(&self, d: Vec3) -> f32 {
        let length = (self.light_from_render * d.as_dvec3()).length();
        (self.light_from_render.determinant().abs() / (length * length * length)) as f32
    }
}

#[cfg(test)]
mod tests;
