//! `Integrator "volpath"`: [`path`](super::path) through participating media (Pharr, Jakob and
//! Humphreys 2016, §15.3; docs/scene-language.md §4.2 and §4.3).
//!
//! Parameters are those of `path`. Scattering in a medium counts as a bounce. Unlike under `path`,
//! light passes surfaces without material, dimmed by the media along the way; as in pbrt-v3 these
//! shadow rays do not ask `shadowalpha`.

use super::witness::Witness;
use super::{MAX_NULL_SURFACES, Path};
use crate::handles::MediumId;
use crate::lights::LightSelector;
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::{Rgb, color::is_black};
use crate::params::ParamReader;
use crate::samplers::SampleStream;
use crate::world::World;

/// Shadow rays end this part of the way before a light that is infinitely far away, as they do
/// before others.
const SHORT_OF_THE_LIGHT: f32 = 1.0 - 1e-4;

/// Parameters of `Integrator "volpath"`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VolPath {
    /// Those of `path`.
    pub path: Path,
}

impl VolPath {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> VolPath {
        VolPath {
            path: Path::from_params(reader),
        }
    }

    /// Radiance along a camera ray.
    pub fn radiance(
        &self,
        world: &World,
        selector: &LightSelector,
        ray: Ray,
        differentials: Option<&RayDifferentials>,
        stream: &mut SampleStream,
        witness: &mut impl Witness,
    ) -> Rgb {
        self.path
            .radiance::<true>(world, selector, ray, differentials, stream, witness)
    }
}

/// The part of a light's radiance that comes along the shadow ray, which begins in `medium`: black
/// behind anything with a material, dimmed by media and borders of media.
///
/// Lights that are infinitely far away stand, for the media between, two radii of the scene's
/// bounding sphere away, as in pbrt-v3: in fog without end the sun would be black. pbrt-v2's volumes end by themselves.
pub(super) fn transmittance(
    world: &World,
    shadow: &Ray,
    mut medium: Option<MediumId>,
    stream: &mut SampleStream,
) -> Rgb {
    let mut ray = *shadow;
    let whole = medium.is_some_and(|id| world.media.medium(id).is_crossed_whole());
    if ray.t_max == f32::INFINITY && !whole {
        let (_, radius) = world.geometry.bounds().bounding_sphere();
        ray.t_max = 2.0 * radius * SHORT_OF_THE_LIGHT;
    }
    if !world.has_recoverable_surfaces() {
        return if world.occluded(&ray) {
            Rgb::ZERO
        } else {
            dimmed(world, medium, &ray, ray.t_max, stream)
        };
    }
    let end = ray.at(ray.t_max);
    let mut left = Rgb::ONE;
    for _ in 0..MAX_NULL_SURFACES {
        let Some(hit) = world.intersect(&ray) else {
            return left * dimmed(world, medium, &ray, ray.t_max, stream);
        };
        if hit.material.is_some() {
            return Rgb::ZERO;
        }
        left *= dimmed(world, medium, &ray, hit.t, stream);
        if is_black(left) {
            return Rgb::ZERO;
        }
        medium = world.medium_beyond(&hit, ray.d, medium);
        let finite = ray.t_max.is_finite();
        ray = hit.surface.spawn_ray(ray.d);
        if finite {
            ray.t_max = (end - ray.o).dot(ray.d);
        }
        // The surface stands where the light is.
        let ahead = ray.t_max > 0.0;
        if !ahead {
            return left;
        }
    }
    Rgb::ZERO
}

/// What a medium leaves of light over the first `t_max` of a ray.
pub(super) fn dimmed(
    world: &World,
    medium: Option<MediumId>,
    ray: &Ray,
    t_max: f32,
    stream: &mut SampleStream,
) -> Rgb {
    match medium {
        Some(id) => world.media.medium(id).transmittance(ray, t_max, stream),
        None => Rgb::ONE,
    }
}
