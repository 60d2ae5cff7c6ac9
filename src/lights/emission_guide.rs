//! Where it pays to begin paths from a light: learned from paths before the image.
//!
//! Most paths from a light bring little that emitter sampling does not find as well; those through a glass or from a mirror bring all
//! that is seen of its caustics. A guide is a density that follows what was brought: of directions for lights with a place,
//! of points of the disk for those at infinity. A part of the paths begins as the light alone would have it, so that nothing is
//! lost that the guide has not seen (Owen and Zhou 2000; for paths Vorba et al. 2014).

use super::emission::{Emission, EmissionDensity, SceneSphere};
use super::kinds::Light;
use crate::math::adaptive_density::AdaptiveDensity;
use crate::math::{Vec2, Vec3};
use std::f32::consts::PI;

/// See above.
#[derive(Clone, Debug)]
pub struct EmissionGuide {
    density: AdaptiveDensity,
}

impl EmissionGuide {
    /// The part of paths that begins without the guide.
    pub const UNGUIDED: f32 = 0.25;

    /// The density on the square of [`place_of_ray`] of a ray with the density `density`.
    pub fn density_on_square(light: &Light, scene: &SceneSphere, density: EmissionDensity) -> f32 {
        match light.is_at_infinity() {
            true => density.position * 4.0 * scene.radius * scene.radius,
            false => density.direction * 4.0 * PI,
        }
    }

    /// From the density on the square of [`place_of_ray`].
    pub fn new(density: AdaptiveDensity) -> EmissionGuide {
        EmissionGuide { density }
    }

    /// What [`Light::emit`] does, guided.
    pub fn emit(
        &self,
        light: &Light,
        scene: &SceneSphere,
        u_position: Vec2,
        u_direction: Vec2,
    ) -> Option<Emission> {
        let at_infinity = light.is_at_infinity();
        let guided = if at_infinity { u_position } else { u_direction };
        let (unguided, rest) = match guided.x < Self::UNGUIDED {
            true => (true, guided.x / Self::UNGUIDED),
            false => (false, (guided.x - Self::UNGUIDED) / (1.0 - Self::UNGUIDED)),
        };
        let guided = Vec2::new(rest.min(1.0 - f32::EPSILON / 2.0), guided.y);
        let mut emission = match (at_infinity, unguided) {
            (true, true) => light.emit(scene, guided, u_direction)?,
            (true, false) => {
                let mut emission = light.emit(scene, Vec2::splat(0.5), u_direction)?;
                let at = 2.0 * self.density.sample(guided) - 1.0;
                if at.length_squared() > 1.0 {
                    return None;
                }
                emission.p = scene.on_disk(emission.d, at);
                emission
            }
            (false, true) => light.emit(scene, u_position, guided)?,
            (false, false) => {
                let d = direction(self.density.sample(guided));
                light.emit_toward(u_position, d)?
            }
        };
        // As others find it for this ray, which by rounding may have come to the next cell.
        let (p, d) = (emission.p, emission.d);
        emission.density = self.mixed(light, scene, emission.density, p, d);
        emission.if_any()
    }

    /// The densities of [`EmissionGuide::emit`] where those of [`Light::emit`] are `alone`, for a ray through `p` in unit
    /// direction `d`.
    pub fn mixed(
        &self,
        light: &Light,
        scene: &SceneSphere,
        alone: EmissionDensity,
        p: Vec3,
        d: Vec3,
    ) -> EmissionDensity {
        let mut density = alone;
        let (mixed, area) = match light.is_at_infinity() {
            true => (&mut density.position, 4.0 * scene.radius * scene.radius),
            false => (&mut density.direction, 4.0 * PI),
        };
        let guided = self.density.at(place_of_ray(light, scene, p, d)) / area;
        *mixed = Self::UNGUIDED * *mixed + (1.0 - Self::UNGUIDED) * guided;
        density
    }
}

/// Maps a ray to the unit square: the point of a ray through `p` in unit direction `d`: for a light at infinity where it crosses
/// the disk, else its direction. Areas are those of the disk's square or of the unit sphere.
pub fn place_of_ray(light: &Light, scene: &SceneSphere, p: Vec3, d: Vec3) -> Vec2 {
    let at = match light.is_at_infinity() {
        true => 0.5 * scene.across(d, p) + 0.5,
        false => Vec2::new(0.5 * d.z + 0.5, super::turns(d.x, d.y)),
    };
    at.clamp(Vec2::ZERO, Vec2::splat(1.0 - f32::EPSILON / 2.0))
}

/// The direction that [`place_of_ray`] puts at `at`.
fn direction(at: Vec2) -> Vec3 {
    let z = 2.0 * at.x - 1.0;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (2.0 * PI * at.y).sin_cos();
    Vec3::new(r * cos, r * sin, z)
}
