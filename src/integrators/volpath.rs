//! `Integrator "volpath"`: [`path`](super::path) through participating media (Pharr, Jakob and
//! Humphreys 2016, §15.3; docs/scene-language.md §4.2 and §4.3).
//!
//! Parameters are those of `path`. Scattering in a medium counts as a bounce. Unlike under `path`,
//! light passes surfaces without material, attenuated by the media along the way; as in pbrt-v3 these
//! shadow rays ignore `shadowalpha`.

use super::{Context, MAX_NULL_SURFACES, Path, Transport};
use crate::handles::MediumId;
use crate::math::ray::Ray;
use crate::math::{Rgb, color::is_black};
use crate::params::ParamReader;
use crate::samplers::SampleStream;
use crate::world::World;

/// Shadow rays toward lights that are infinitely far away end after this part of the way, as toward others.
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
}

impl Transport for VolPath {
    const MEDIA: bool = true;
    const INDIRECT: bool = true;

    fn radiance(&self, context: Context) -> Rgb {
        self.path.trace_through_media(context)
    }

    fn path(&self) -> Option<Path> {
        Some(self.path.clone())
    }
}

/// The part of a shadow ray from `medium` that [`transmittance`] traces.
pub(super) fn shadow_segment(world: &World, shadow: &Ray, medium: Option<MediumId>) -> Ray {
    let mut ray = *shadow;
    let whole = medium.is_some_and(|id| world.media.medium(id).is_crossed_whole());
    if ray.t_max == f32::INFINITY && !whole {
        let (_, radius) = world.geometry.bounds().bounding_sphere();
        ray.t_max = 2.0 * radius * SHORT_OF_THE_LIGHT;
    }
    ray
}

/// Transmittance of the shadow ray, which begins in `medium`: black behind anything with a material, else the product
/// over the media along it.
///
/// For the media, infinite lights are two radii of the scene's bounding sphere away, as in pbrt-v3: in endless fog
/// the sun would be black. pbrt-v2's volumes are finite.
pub(super) fn transmittance(
    world: &World,
    stream: &mut SampleStream,
    shadow: &Ray,
    mut medium: Option<MediumId>,
) -> Rgb {
    let mut ray = shadow_segment(world, shadow, medium);
    if !world.has_recoverable_surfaces() {
        return if world.occluded(&ray) {
            Rgb::ZERO
        } else {
            dimmed(world, stream, medium, &ray, ray.t_max)
        };
    }
    let end = ray.at(ray.t_max);
    let mut left = Rgb::ONE;
    for _ in 0..MAX_NULL_SURFACES {
        let Some(hit) = world.intersect(&ray) else {
            return left * dimmed(world, stream, medium, &ray, ray.t_max);
        };
        if hit.material.is_some() {
            return Rgb::ZERO;
        }
        left *= dimmed(world, stream, medium, &ray, hit.t);
        if is_black(left) {
            return Rgb::ZERO;
        }
        medium = world.medium_beyond(&hit, ray.d, medium);
        let finite = ray.t_max.is_finite();
        ray = hit.surface.spawn_ray(ray.d);
        if finite {
            ray.t_max = (end - ray.o).dot(ray.d);
        }
        // False where the surface is at the light.
        let ahead = ray.t_max > 0.0;
        if !ahead {
            return left;
        }
    }
    Rgb::ZERO
}

/// Transmittance of a medium over the first `t_max` of a ray.
pub(super) fn dimmed(
    world: &World,
    stream: &mut SampleStream,
    medium: Option<MediumId>,
    ray: &Ray,
    t_max: f32,
) -> Rgb {
    match medium {
        Some(id) => {
            let medium = world.media.medium(id);
            medium.transmittance(ray, t_max, stream)
        }
        None => Rgb::ONE,
    }
}
