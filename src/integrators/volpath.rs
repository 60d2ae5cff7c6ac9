//! `Integrator "volpath"`: [`path`](super::path) through participating media (Pharr, Jakob and
//! Humphreys 2016, §15.3; docs/scene-language.md §4.2 and §4.3).
//!
//! Parameters are those of `path`. Scattering in a medium counts as a bounce. Unlike under `path`,
//! light passes surfaces without material, attenuated by the media along the way; as in pbrt-v3 these
//! shadow rays ignore `shadowalpha`.

use super::context::{Bundle, WAVE};
use super::shadows::unblocked;
use super::{Context, MAX_NULL_SURFACES, Path, Transport};
use crate::accel::{Crossing, Passage};
use crate::handles::MediumId;
use crate::math::ray::Ray;
use crate::math::{Rgb, color::is_black};
use crate::params::ParamReader;
use crate::samplers::SampleStream;
use crate::world::World;
use arrayvec::ArrayVec;

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
    const IN_WAVES: bool = true;

    fn radiance(&self, context: Context) -> Rgb {
        self.path.trace_through_media(context)
    }

    fn radiances(&self, bundle: Bundle, out: &mut ArrayVec<Rgb, WAVE>) {
        if bundle.world.media.are_estimated() {
            // Each shadow ray draws samples: it cannot wait for others.
            return self.radiances_one_by_one(bundle, out);
        }
        self.path.radiances_in_waves::<true>(bundle, out);
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
    medium: Option<MediumId>,
) -> Rgb {
    let ray = shadow_segment(world, shadow, medium);
    let mut left = Rgb::ZERO;
    unblocked::<1>(world, &[ray], &mut [None], |_, passage| {
        left = dimmed_along(world, stream, medium, &ray, passage);
    });
    left
}

/// Transmittance of the media along a ray that nothing with a material blocks, and that begins in `medium`; `passage`: the surfaces without
/// material on its way, if there are any in the scene.
pub(super) fn dimmed_along(
    world: &World,
    stream: &mut SampleStream,
    mut medium: Option<MediumId>,
    ray: &Ray,
    passage: Option<&mut Passage>,
) -> Rgb {
    let Some(passage) = passage else {
        return dimmed(world, stream, medium, ray, ray.t_max);
    };
    let sides = |crossing: &Crossing| {
        let interface = world.media.interface(crossing.interface);
        let beyond = |is_outward| interface.beyond(is_outward);
        (beyond(!crossing.is_outward), beyond(crossing.is_outward))
    };
    let Some(crossings) = passage.crossings(medium, sides) else {
        return dimmed_by_steps(world, stream, medium, ray);
    };
    let mut left = Rgb::ONE;
    let mut rest = *ray;
    let mut passed = 0.0;
    for crossing in crossings {
        // Rounding may have put one before the last at the same place.
        let t = crossing.t.max(passed);
        left *= dimmed(world, stream, medium, &rest, t - passed);
        if is_black(left) {
            return Rgb::ZERO;
        }
        medium = sides(crossing).1;
        (passed, rest.o) = (t, ray.at(t));
    }
    left * dimmed(world, stream, medium, &rest, ray.t_max - passed)
}

/// The same from one surface to the next.
fn dimmed_by_steps(
    world: &World,
    stream: &mut SampleStream,
    mut medium: Option<MediumId>,
    ray: &Ray,
) -> Rgb {
    let mut ray = *ray;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrators::testing::job;
    use crate::math::hash::{mix2, unit_float};
    use crate::math::{IVec2, Vec3};

    /// Media in a sphere within a sphere, in a sphere with reversed orientation, and in a box; a sphere that is not an interface; and an occluder.
    const MEDIA: &str = r#"
        Camera "perspective"
        Film "image" "integer xresolution" 16 "integer yresolution" 16
        Integrator "volpath"
        WorldBegin
        LightSource "point"
        MakeNamedMedium "milk" "string type" "homogeneous" "rgb sigma_a" [ .1 .2 .4 ] "rgb sigma_s" [ .5 .4 .3 ]
        MakeNamedMedium "smoke" "string type" "homogeneous" "rgb sigma_a" [ .3 .2 .1 ] "rgb sigma_s" [ .2 .2 .2 ]
        Material "none"
        MediumInterface "milk" ""
        Shape "sphere" "float radius" 2
        MediumInterface "smoke" "milk"
        Shape "sphere" "float radius" 1
        AttributeBegin
        MediumInterface "" "smoke"
        Translate 3 0 0
        ReverseOrientation
        Shape "sphere" "float radius" .9
        AttributeEnd
        MediumInterface "smoke" ""
        Shape "trianglemesh" "integer indices" [ 0 2 1 0 3 2  4 5 6 4 6 7  0 1 5 0 5 4  1 2 6 1 6 5  2 3 7 2 7 6  3 0 4 3 4 7 ]
            "point P" [ -4 -1 -1  -2 -1 -1  -2 1 -1  -4 1 -1  -4 -1 1  -2 -1 1  -2 1 1  -4 1 1 ]
        MediumInterface "" ""
        Shape "sphere" "float radius" 4
        Material "matte"
        Shape "trianglemesh" "integer indices" [ 0 1 2 ] "point P" [ -3 0 -2  3 0 -2  0 3 2 ]
    "#;

    /// Turned, stretched and mirrored.
    const INSTANCES: &str = r#"
        Material "none"
        MediumInterface "milk" ""
        ObjectBegin "ball and box"
        Shape "sphere" "float radius" .6
        Shape "trianglemesh" "integer indices" [ 0 2 1 0 3 2  4 5 6 4 6 7  0 1 5 0 5 4  1 2 6 1 6 5  2 3 7 2 7 6  3 0 4 3 4 7 ]
            "point P" [ -1 1 -1  1 1 -1  1 2 -1  -1 2 -1  -1 1 1  1 1 1  1 2 1  -1 2 1 ]
        ObjectEnd
        Translate 0 -1 3
        Rotate 40 1 2 3
        ObjectInstance "ball and box"
        Translate -4 3 -4
        Scale -1.5 1 .7
        ObjectInstance "ball and box"
    "#;

    /// What is met by steps: a quadric, and spheres within spheres.
    const OTHERS: &str = r#"
        Material "none"
        MediumInterface "milk" ""
        Translate 0 -1 0
        AttributeBegin
        Translate 0 0 -3
        Shape "cylinder" "float radius" .7
        AttributeEnd
        Translate 3 0 3
        Shape "sphere" "float radius" .5
        Shape "sphere" "float radius" .6
        Shape "sphere" "float radius" .7
        Shape "sphere" "float radius" .8
        Shape "sphere" "float radius" .9
    "#;

    #[test]
    fn what_is_passed_at_once_dims_as_one_surface_after_the_other() {
        for (others, by_steps) in [("", 0..=0), (INSTANCES, 0..=20), (OTHERS, 200..=20_000)] {
            let job = job(&format!("{MEDIA}{others}WorldEnd"));
            let world = &job.world;
            assert!(world.has_recoverable_surfaces());
            let mut stream = job.sampler.stream(IVec2::ZERO, 0);
            let (mut blocked, mut dimmed, mut crossed, mut incomplete, mut grazed) =
                (0, 0, 0, 0, 0);
            let (mut rays, mut alone) = (Vec::new(), Vec::new());
            for i in 0..20_000 {
                let vector =
                    |k| Vec3::from_array([k, k + 1, k + 2].map(|k| unit_float(mix2(i, k))));
                let (o, to) = (vector(0) * 10.0 - 5.0, vector(3) * 10.0 - 5.0);
                let mut ray = Ray::new(o, (to - o).normalize_or(Vec3::Z), 0.0);
                if i % 4 != 0 {
                    ray.t_max = (to - o).length();
                }
                let ray = shadow_segment(world, &ray, None);
                let expected = dimmed_by_steps(world, &mut stream, None, &ray);
                let found = transmittance(world, &mut stream, &ray, None);
                let difference = (found - expected).abs().max_element();
                // A step from a sphere begins some 1e-6 beside it. Where a ray grazes one of radius 2 that is √(2 · 2 · 1e-6) = 2e-3 along it,
                // in a medium of 0.4 to 0.8.
                assert!(difference < 2e-3, "{ray:?}: {found} {expected}");
                // Elsewhere it is the rounding of distances of 10.
                grazed += usize::from(difference > 1e-5);
                unblocked::<1>(world, &[ray], &mut [None], |_, passage| {
                    let passage = passage.expect("surfaces without material");
                    match passage.crossings(0, |_| (0, 0)) {
                        Some(all) => crossed = crossed.max(all.len()),
                        None => incomplete += 1,
                    }
                });
                rays.push(ray);
                alone.push(found);
                blocked += usize::from(is_black(found));
                dimmed += usize::from(!is_black(found) && found != Rgb::ONE);
            }
            assert!(blocked > 1000 && dimmed > 3000, "{blocked} {dimmed}");
            assert!(crossed >= 5, "{crossed}");
            assert!(by_steps.contains(&incomplete), "{incomplete}");
            assert!(grazed < 200, "{grazed}");
            let mut together = vec![Rgb::ZERO; rays.len()];
            unblocked::<16>(world, &rays, &mut vec![None; rays.len()], |i, passage| {
                together[i] = dimmed_along(world, &mut stream, None, &rays[i], passage);
            });
            assert_eq!(together, alone);
        }
    }

    /// Two boxes have a face at one place, and either may be declared first.
    #[test]
    fn of_interfaces_at_one_place_the_one_around_the_ray_comes_first() {
        const FOG: &str = r#"Material "none" MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [ .1 .1 .1 ] "rgb sigma_s" [ 0 0 0 ]
            MakeNamedMedium "smoke" "string type" "homogeneous" "rgb sigma_a" [ .5 .5 .5 ] "rgb sigma_s" [ 0 0 0 ]"#;
        let face = |[below, above]: [&str; 2], y: f32| {
            format!(
                r#"MediumInterface "{below}" "{above}" Shape "trianglemesh" "integer indices" [ 0 2 1 0 3 2 ]
                "point P" [ -1 {y} -1  1 {y} -1  1 {y} 1  -1 {y} 1 ]"#
            )
        };
        // Normals point upward: smoke up to 1, fog up to 1 as well around it, and from below 0 nothing.
        let inner = face(["smoke", "fog"], 1.0);
        let outer = face(["fog", ""], 1.0);
        let floor = face(["", "smoke"], 0.0);
        for faces in [format!("{inner}{outer}"), format!("{outer}{inner}")] {
            let head =
                r#"Camera "perspective" Integrator "volpath" WorldBegin LightSource "point""#;
            let job = job(&format!("{head} {FOG} {faces} {floor} WorldEnd"));
            let world = &job.world;
            let mut stream = job.sampler.stream(IVec2::ZERO, 0);
            // Through both from below, and from above.
            for (y, d) in [(-2.0, Vec3::Y), (3.0, Vec3::NEG_Y)] {
                let mut ray = Ray::new(Vec3::new(0.1, y, 0.3), d, 0.0);
                ray.t_max = 5.0;
                let left = transmittance(world, &mut stream, &ray, None);
                // One unit of smoke, with roundings of distances of 5.
                let expected = Rgb::splat((-0.5f32).exp());
                assert!((left - expected).abs().max_element() < 1e-6, "{left}");
            }
        }
    }
}
