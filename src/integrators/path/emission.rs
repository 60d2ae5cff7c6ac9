//! Emission that a path meets, weighted by multiple importance sampling: the counterpart of
//! [emitter sampling](super::emitter_sampling).

use super::{MAX_NULL_SURFACES, PathState};
use crate::accel::GeometryHit;
use crate::bsdf::{Bsdf, BsdfSample};
use crate::handles::LightId;
use crate::integrators::Context;
use crate::integrators::vertex::receiver;
use crate::integrators::volpath::dimmed;
use crate::math::ray::Ray;
use crate::math::sampling::power_heuristic;
use crate::math::{Rgb, color::is_black};
use crate::surface::ReferencePoint;

/// How a ray was sampled: decides the weight of the emission that it meets.
#[derive(Clone, Copy)]
pub(super) enum MisState {
    /// From the camera or by a perfectly specular lobe: emitter sampling does not compete.
    Delta,
    /// By a BSDF or a phase function: the weight is the power heuristic's against emitter sampling.
    Sampled(Sampled),
    /// Scattered, then past a surface without material, which blocks shadow rays:
    /// as in pbrt-v3 the light behind it is not seen (docs/scene-language.md §4.3).
    Blocked,
}

/// A scattering event.
#[derive(Clone, Copy)]
pub(super) struct Sampled {
    pub from: ReferencePoint,
    /// Of the direction, per steradian.
    pub pdf: f32,
    /// It was the first, where emitter sampling is of more lights.
    pub is_first: bool,
}

impl MisState {
    /// Weighted emission of the surface hit, which is that of light `id`.
    fn emitted(&self, context: &Context, ray: &Ray, (hit, id): (&GeometryHit, LightId)) -> Rgb {
        let light = context.world.light(id);
        let radiance = light.emitted(&hit.surface);
        if is_black(radiance) {
            return Rgb::ZERO;
        }
        match self {
            MisState::Delta => radiance,
            MisState::Blocked => Rgb::ZERO,
            MisState::Sampled(sampled) => {
                let light_pdf = light.pdf(&sampled.from, ray.d, Some(&hit.surface));
                let light_pdf = sampled.samples(context, id) * light_pdf;
                // A light that is never chosen (an instanced emitter) glows but lights nothing, as in pbrt-v3.
                if light_pdf > 0.0 {
                    radiance * power_heuristic(sampled.pdf, light_pdf)
                } else {
                    Rgb::ZERO
                }
            }
        }
    }

    /// Weighted radiance of the infinite lights along a ray that leaves the scene.
    fn escaped(&self, context: &Context, ray: &Ray) -> Rgb {
        let lights = context.world.infinite_lights.iter();
        lights.map(|&id| self.escaped_of(context, ray, id)).sum()
    }

    /// That of one of them.
    #[inline(always)]
    fn escaped_of(&self, context: &Context, ray: &Ray, id: LightId) -> Rgb {
        let light = context.world.light(id);
        match self {
            MisState::Delta => light.escaped(ray.d),
            MisState::Blocked => Rgb::ZERO,
            MisState::Sampled(sampled) => {
                let (radiance, light_pdf) = light.escaped_and_pdf(&sampled.from, ray.d);
                radiance * power_heuristic(sampled.pdf, sampled.samples(context, id) * light_pdf)
            }
        }
    }
}

impl Sampled {
    /// The expected number of emitter samples of light `id` there.
    fn samples(&self, context: &Context, id: LightId) -> f32 {
        let selector = &context.lights.selector;
        match selector.sample_all_count() {
            Some(count) if self.is_first => f32::from(u8::from(id.0 < count)),
            _ => selector.choices(self.is_first) as f32 * selector.pmf(&self.from, id),
        }
    }
}

impl<const MEDIA: bool, const WATCHED: bool> PathState<'_, MEDIA, WATCHED> {
    /// Adds the emission of the surface hit.
    #[inline(always)]
    pub(super) fn add_emission(&mut self, hit: &GeometryHit) {
        if let Some(id) = hit.light {
            let light = self
                .trail
                .mis
                .emitted(&self.context, &self.trail.ray, (hit, id));
            self.gain_from(id, self.trail.throughput * light);
        }
    }

    /// Adds the radiance of the infinite lights.
    #[inline(always)]
    pub(super) fn add_escaped(&mut self) {
        let (mis, ray) = (self.trail.mis, self.trail.ray);
        self.gain(self.trail.throughput * mis.escaped(&self.context, &ray));
        self.part_escaped((mis, ray), self.trail.throughput);
    }

    /// Adds the same to the layers of light.
    #[inline(always)]
    fn part_escaped(&mut self, (mis, ray): (MisState, Ray), throughput: Rgb) {
        if WATCHED {
            let of_light = |context: &Context, id| throughput * mis.escaped_of(context, &ray, id);
            self.context.parts_at_infinity(of_light);
        }
    }

    /// Emission along the direction of `sample`, although the path continues elsewhere: the counterpart of
    /// emitter sampling at a rough boundary, as in pbrt-v3.
    pub(super) fn emission_along(
        &mut self,
        hit: &GeometryHit,
        bsdf: &Bsdf,
        sample: &BsdfSample,
    ) -> Rgb {
        let world = self.context.world;
        let mis = self.mis_after(hit, bsdf, sample);
        let mut ray = hit.surface.spawn_ray(sample.wi);
        let mut medium = match MEDIA {
            true => world.medium_beyond(hit, sample.wi, self.trail.medium),
            false => None,
        };
        let (mut light, mut throughput) = (Rgb::ZERO, self.trail.throughput);
        for _ in 0..MAX_NULL_SURFACES {
            let next = world.intersect(&ray);
            let t_max = next.as_ref().map_or(f32::INFINITY, |next| next.t);
            throughput *= dimmed(world, self.context.stream, medium, &ray, t_max);
            let Some(next) = next else {
                self.part_escaped((mis, ray), throughput);
                return light + throughput * mis.escaped(&self.context, &ray);
            };
            if let Some(id) = next.light {
                let emitted = throughput * mis.emitted(&self.context, &ray, (&next, id));
                self.context.part(Some(id), emitted);
                light += emitted;
            }
            if !MEDIA || next.material.is_some() || is_black(throughput) {
                break;
            }
            medium = world.medium_beyond(&next, ray.d, medium);
            ray = next.surface.spawn_ray(ray.d);
        }
        light
    }

    /// The state of a ray that the surface scatters as in `sample`, if not by a perfectly specular lobe.
    #[inline]
    pub(super) fn mis_after(
        &self,
        hit: &GeometryHit,
        bsdf: &Bsdf,
        sample: &BsdfSample,
    ) -> MisState {
        self.sampled(receiver(&hit.surface, bsdf), sample.pdf)
    }
    /// The state of a ray that is scattered at a point with this density per steradian.
    #[inline]
    pub(super) fn sampled(&self, from: ReferencePoint, pdf: f32) -> MisState {
        MisState::Sampled(Sampled {
            from,
            pdf,
            is_first: self.trail.is_first(),
        })
    }
}
