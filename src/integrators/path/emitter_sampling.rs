//! Emitter sampling (next-event estimation) at a vertex of a path: of one light; of some, or of every one if there are few, at what the
//! camera sees.

use super::{PathState, Trail};
use crate::accel::GeometryHit;
use crate::bsdf::Bsdf;
use crate::handles::LightId;
use crate::integrators::context::Lights;
use crate::integrators::vertex::{SurfaceVertex, Vertex};
use crate::integrators::volpath::transmittance;
use crate::lights::{LightSelector, Selected};
use crate::math::ray::Ray;
use crate::math::sampling::power_heuristic;
use crate::math::{Rgb, Vec2, Vec3, color::is_black};
use crate::samplers::ChoiceSample;
use crate::surface::ReferencePoint;

impl<const MEDIA: bool, const WATCHED: bool> PathState<'_, MEDIA, WATCHED> {
    /// Adds direct light at a surface, unless all its lobes are perfectly specular.
    #[inline(always)]
    pub(super) fn sample_direct_at_surface(&mut self, hit: &GeometryHit, bsdf: &Bsdf) {
        if bsdf.has_non_specular() {
            let medium = self.trail.medium;
            self.sample_direct(&SurfaceVertex { hit, bsdf, medium });
        } else {
            self.context.stream.skip_1d();
            self.context.stream.skip_2d();
        }
    }

    /// Adds direct light by sampling every light or some, weighted against BSDF sampling.
    #[inline(always)]
    pub(super) fn sample_direct(&mut self, vertex: &impl Vertex) {
        let from = vertex.reference_point();
        if let Some(count) = self.sample_all_count() {
            for id in 0..count {
                let u = self.context.stream.next_2d();
                self.sample_light((LightId(id), 1.0), vertex, &from, u);
            }
            return;
        }
        let selector = &self.context.lights.selector;
        let all = selector.choices(self.trail.is_first());
        for number in 0..all {
            let numbers = self.context.stream.next_choice(selector.chooses());
            if let Some((chosen, u)) = choose(selector, &from, (number, all), numbers) {
                self.sample_light(chosen, vertex, &from, u);
            }
        }
    }

    /// See [`Trail::sample_all_count`].
    #[inline(always)]
    pub(super) fn sample_all_count(&self) -> Option<u32> {
        self.trail.sample_all_count(self.context.lights)
    }

    /// Adds a sample of a light that is chosen so many times on average.
    #[inline(always)]
    fn sample_light(
        &mut self,
        chosen: (LightId, f32),
        vertex: &impl Vertex,
        from: &ReferencePoint,
        u: Vec2,
    ) {
        if let Some((light, left)) = self.light_sample(chosen, vertex, from, u) {
            let light = self.trail.throughput * light;
            self.gain_from(chosen.0, if MEDIA { light * left } else { light });
        }
    }

    /// The contribution of a light sample, and how much of it the media on the way leave; `None` for nothing.
    #[inline]
    fn light_sample(
        &mut self,
        chosen: (LightId, f32),
        vertex: &impl Vertex,
        from: &ReferencePoint,
        u: Vec2,
    ) -> Option<(Rgb, Rgb)> {
        let arriving = self.unshadowed(chosen, u, vertex, from)?;
        let (world, shadow) = (self.context.world, arriving.shadow);
        if WATCHED && self.reports {
            self.context.shadow(chosen.0, false);
        }
        let mut left = Rgb::ONE;
        if MEDIA {
            let medium = vertex.medium_toward(world, arriving.wi);
            left = transmittance(world, self.context.stream, &shadow, medium);
            if is_black(arriving.contribution * left) {
                return None;
            }
        } else if world.occluded(&shadow) {
            return None;
        }
        if WATCHED && self.reports {
            self.context.shadow(chosen.0, true);
        }
        Some((arriving.weighted(), left))
    }

    /// What a light sample brings that `u` chooses, if nothing blocks the shadow ray; `None` for nothing.
    #[inline(always)]
    pub(super) fn unshadowed(
        &self,
        (id, pmf): (LightId, f32),
        u: Vec2,
        vertex: &impl Vertex,
        from: &ReferencePoint,
    ) -> Option<Arriving> {
        let light = self.context.world.light(id).sample(from, u)?;
        let (scattered, scattered_pdf) = vertex.scattered_and_pdf(light.wi);
        let contribution = scattered * light.radiance;
        if is_black(contribution) {
            return None;
        }
        Some(Arriving {
            contribution,
            wi: light.wi,
            pdf: pmf * light.pdf,
            competing: (!light.delta).then_some(scattered_pdf),
            shadow: light.shadow,
        })
    }
}

/// What a light sample brings if nothing is in its way.
pub(super) struct Arriving {
    contribution: Rgb,
    wi: Vec3,
    pdf: f32,
    competing: Option<f32>,
    pub(super) shadow: Ray,
}

impl Arriving {
    /// The estimate, weighted against BSDF sampling.
    #[inline(always)]
    pub(super) fn weighted(&self) -> Rgb {
        weighted(self.contribution, self.pdf, self.competing)
    }
}

impl Trail {
    /// Returns `true` before the first scattering event.
    #[inline(always)]
    pub(super) fn is_first(&self) -> bool {
        self.depth == 0
    }

    /// The number of lights if each is sampled: at primary hits if there are few, because shadows are most of
    /// their noise.
    #[inline]
    pub(super) fn sample_all_count(&self, lights: &Lights) -> Option<u32> {
        match self.is_first() {
            true => lights.selector.sample_all_count(),
            false => None,
        }
    }
}

/// One of `all` choices of a light, each from a part of the lights of its own; how many times that light is chosen on average
/// by all of them; and the numbers of a point on it.
#[inline(always)]
pub(super) fn choose(
    selector: &LightSelector,
    from: &ReferencePoint,
    (number, all): (u32, u32),
    mut numbers: ChoiceSample,
) -> Option<((LightId, f32), Vec2)> {
    if all > 1 {
        numbers = numbers.within(number, all);
    }
    let Selected { light, pmf, rest } = selector.sample(from, numbers.choice)?;
    Some(((light, pmf * all as f32), numbers.point(pmf, rest)))
}

/// The estimate by a light sample of this density, where BSDF sampling may find the same with another.
#[inline(always)]
pub(super) fn weighted(contribution: Rgb, pdf: f32, competing: Option<f32>) -> Rgb {
    let weight = competing.map_or(1.0, |competing| power_heuristic(pdf, competing));
    contribution * (weight / pdf)
}
