//! Where it pays to begin paths from a light: learned from paths before the image.
//!
//! Most paths from a light bring little that emitter sampling does not find as well; those through a glass or from a mirror bring all
//! that is seen of its caustics. A guide is a density that follows what was brought: of directions for lights with a place,
//! of points of the disk for those at infinity. A part of the paths begins as the light alone would have it, so that nothing is
//! lost that the guide has not seen (Owen and Zhou 2000; for paths Vorba et al. 2014).

use super::emission::{Emission, EmissionDensity, SceneSphere};
use super::kinds::Light;
use crate::math::adaptive_density::{AdaptiveDensity, Sampled};
use crate::math::angle::turns;
use crate::math::hash::{mix2, unit_float};
use crate::math::sampling::BELOW_ONE;
use crate::math::{Vec2, Vec3};
use std::f32::consts::PI;

/// See above.
#[derive(Clone, Debug)]
pub struct EmissionGuide {
    density: AdaptiveDensity,
}

/// What a ray is chosen by: numbers in [0, 1).
#[derive(Clone, Copy, Debug)]
pub struct RayNumbers {
    /// For where it begins.
    pub position: Vec2,
    /// For its direction.
    pub direction: Vec2,
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

    /// From the density on the square of [`place_of_ray`]; `None` where that leads nowhere.
    pub fn new(density: AdaptiveDensity) -> Option<EmissionGuide> {
        (!density.is_even()).then_some(EmissionGuide { density })
    }

    /// The density on the square of [`place_of_ray`] of rays to `points` in the scene, each from a place on the light; `None` where it sends nothing to them. Before anything is learned: paths
    /// to what is small would be too few to learn from (projection maps: Jensen 2001, §5.2).
    pub fn toward(
        light: &Light,
        scene: &SceneSphere,
        points: impl Iterator<Item = Vec3>,
    ) -> Option<AdaptiveDensity> {
        let place = |(i, point): (usize, Vec3)| {
            let u = |k: u64| unit_float(mix2(i as u64, k));
            let (u_position, u_direction) = (Vec2::new(u(0), u(1)), Vec2::new(u(2), u(3)));
            let from = light.emit(scene, u_position, u_direction)?;
            if light.is_at_infinity() {
                return Some(place_of_ray(light, scene, point, from.d));
            }
            let d = (point - from.p).try_normalize()?;
            let lit = light.emit_toward(u_position, d)?.if_any()?;
            Some(place_of_ray(light, scene, lit.p, d))
        };
        let places: Vec<Vec2> = points.enumerate().filter_map(place).collect();
        AdaptiveDensity::of_points(&places)
    }

    /// What leads to a guided ray from these numbers in [0, 1)²; `None` for one that begins without the guide.
    pub fn guided(&self, light: &Light, u: RayNumbers) -> Option<(&AdaptiveDensity, Vec2)> {
        let (is_guided, rest) = Self::part(light, u);
        is_guided.then_some((&self.density, rest))
    }

    /// Returns `true` if the guide is used, and the numbers of what is chosen with it or without.
    fn part(light: &Light, u: RayNumbers) -> (bool, Vec2) {
        let u = match light.is_at_infinity() {
            true => u.position,
            false => u.direction,
        };
        let is_guided = u.x >= Self::UNGUIDED;
        let rest = match is_guided {
            true => (u.x - Self::UNGUIDED) / (1.0 - Self::UNGUIDED),
            false => u.x / Self::UNGUIDED,
        };
        (is_guided, Vec2::new(rest.min(BELOW_ONE), u.y))
    }

    /// What [`Light::emit`] does, guided; `guided`: what [`EmissionGuide::guided`] has led to.
    pub fn emit(
        &self,
        light: &Light,
        scene: &SceneSphere,
        u: RayNumbers,
        guided: Option<Sampled>,
    ) -> Option<Emission> {
        let Some(guided) = guided else {
            let (_, rest) = Self::part(light, u);
            let mut emission = match light.is_at_infinity() {
                true => light.emit(scene, rest, u.direction)?,
                false => light.emit(scene, u.position, rest)?,
            };
            let (p, d) = (emission.p, emission.d);
            emission.density = self.mixed(light, scene, emission.density, p, d);
            return emission.if_any();
        };
        let mut emission = match light.is_at_infinity() {
            true => {
                let mut emission = light.emit(scene, Vec2::splat(0.5), u.direction)?;
                let at = 2.0 * guided.at - 1.0;
                if at.length_squared() > 1.0 {
                    return None;
                }
                emission.p = scene.on_disk(emission.d, at);
                emission
            }
            false => light.emit_toward(u.position, direction(guided.at))?,
        };
        emission.density = Self::mix(light, scene, emission.density, guided.density);
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
        let guided = self.density.at(place_of_ray(light, scene, p, d));
        Self::mix(light, scene, alone, guided)
    }

    /// The densities where the guide's is `guided` on its square.
    fn mix(
        light: &Light,
        scene: &SceneSphere,
        alone: EmissionDensity,
        guided: f32,
    ) -> EmissionDensity {
        let mut density = alone;
        let (mixed, area) = match light.is_at_infinity() {
            true => (&mut density.position, 4.0 * scene.radius * scene.radius),
            false => (&mut density.direction, 4.0 * PI),
        };
        *mixed = Self::UNGUIDED * *mixed + (1.0 - Self::UNGUIDED) * (guided / area);
        density
    }
}

/// Maps a ray to the unit square: the point of a ray through `p` in unit direction `d`: for a light at infinity where it crosses
/// the disk, else its direction. Areas are those of the disk's square or of the unit sphere.
pub fn place_of_ray(light: &Light, scene: &SceneSphere, p: Vec3, d: Vec3) -> Vec2 {
    let at = match light.is_at_infinity() {
        true => 0.5 * scene.across(d, p) + 0.5,
        false => Vec2::new(0.5 * d.z + 0.5, turns(d.x, d.y)),
    };
    at.clamp(Vec2::ZERO, Vec2::splat(BELOW_ONE))
}

/// The direction that [`place_of_ray`] puts at `at`.
fn direction(at: Vec2) -> Vec3 {
    let z = 2.0 * at.x - 1.0;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (2.0 * PI * at.y).sin_cos();
    Vec3::new(r * cos, r * sin, z)
}
