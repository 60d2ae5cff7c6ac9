//! BSDF sampling: where a path continues at a surface, or below it.

use super::emission::MisState;
use super::{BOTH_WAYS, Branch, PathState};
use crate::accel::GeometryHit;
use crate::bsdf::{Boundary, Bsdf, BsdfSample, Way};
use crate::integrators::Sight;
use crate::integrators::subsurface::find_exit;
use crate::math::color::is_black;
use crate::math::frame::Frame;
use crate::math::ray::RayDifferentials;
use crate::math::{Rgb, Vec3};

impl<const MEDIA: bool, const WATCHED: bool> PathState<'_, MEDIA, WATCHED> {
    /// Samples the BSDF and updates the throughput.
    #[inline(always)]
    pub(super) fn sample_bsdf(&mut self, hit: &GeometryHit, bsdf: &Bsdf) -> Option<BsdfSample> {
        let stream = &mut *self.context.stream;
        let third = stream.next_1d_if(bsdf.needs_third());
        let sample = bsdf.sample(hit.surface.wo, third, stream.next_2d())?;
        self.pass_on(&sample, bsdf.shading_normal())
            .then_some(sample)
    }

    /// Multiplies the throughput by what a sample passes on. Returns `true` if that is light.
    #[inline(always)]
    fn pass_on(&mut self, sample: &BsdfSample, shading_n: Vec3) -> bool {
        let cosine = sample.wi.dot(shading_n).abs();
        self.trail.throughput *= sample.f * (cosine / sample.pdf);
        !is_black(self.trail.throughput) && self.trail.throughput.is_finite()
    }

    /// Continues from a smooth boundary: as [`PathState::scatter`], without a BSDF's memory.
    pub(super) fn cross(&mut self, hit: &GeometryHit, boundary: &Boundary) -> Option<()> {
        let stream = &mut *self.context.stream;
        // Those of emitter sampling, and a third that no boundary has a use for.
        stream.skip_1d();
        stream.skip_2d();
        stream.skip_1d();
        let (surface, u) = (&hit.surface, stream.next_2d());
        let shading = &surface.shading;
        let frame = Frame::from_normal_and_tangent(shading.n, shading.dpdu);
        let sample = boundary.sample(&frame, 0.0, surface.wo, u);
        let weight = |sample: &BsdfSample| Sight::weight(frame.n, sample);
        self.look_across(hit, || sample.as_ref().map(weight));
        let sample = sample?;
        self.go_along(hit, sample.wi);
        if !self.pass_on(&sample, frame.n) {
            return None;
        }
        if sample.transmission {
            self.refract(sample.eta);
        }
        self.trail.mis = MisState::Delta;
        Some(())
    }

    /// Returns `true` if the path takes both ways at glass, and has room for another.
    #[inline(always)]
    pub(super) fn takes_both_ways(&self) -> bool {
        self.trail.depth < BOTH_WAYS && self.may_branch()
    }

    /// Continues from a boundary of glass both ways (`Ways::both`); the fainter one is taken when the other has ended. A
    /// choice by flux makes what is faint as noisy as it is faint (docs/notes/light-paths.md, "Smooth boundaries").
    ///
    /// Layers look along one of them, by Fresnel reflectance. By the same number the path takes the fainter one, of which it takes more: unless glass is
    /// tinted, what layers see is on the path's own way.
    pub(super) fn cross_both_ways(&mut self, hit: &GeometryHit, boundary: &Boundary) -> Option<()> {
        let stream = &mut *self.context.stream;
        // As in `cross`.
        stream.skip_1d();
        stream.skip_2d();
        stream.skip_1d();
        let u = stream.next_2d().x;
        let other_stream = stream.fork();
        let ways = boundary.ways(hit.surface.shading.n, hit.surface.wo);
        let both = ways.both();
        let is_refracted = both.is_some_and(|(_, (fainter, _))| fainter.eta != 1.0);
        let seen = ways.seen(if is_refracted { 1.0 - u } else { u });
        self.look_across(hit, || seen.map(|(way, chance)| way.share / chance));
        let Some((brighter, (fainter, chance))) = both else {
            return self.follow(hit, ways.choose(0.0, u)?);
        };
        let is_seen = self.trail.is_seen;
        let sees_fainter = is_seen && seen.is_some_and(|(way, _)| way.wi == fainter.wi);
        if u < chance {
            let before = *self.trail;
            let numbers = std::mem::replace(self.context.stream, other_stream);
            self.trail.is_seen = sees_fainter;
            let goes_on = self.follow(hit, (fainter, chance));
            if goes_on.is_none() {
                self.look_along(self.trail.ray);
            }
            let trail = std::mem::replace(self.trail, before);
            let stream = std::mem::replace(self.context.stream, numbers);
            self.branches
                .extend(goes_on.map(|()| Branch { trail, stream }));
        } else if sees_fainter {
            self.look_along(hit.surface.spawn_ray(fainter.wi));
        }
        self.trail.is_seen = is_seen && !sees_fainter;
        self.follow(hit, (brighter, 1.0))
    }

    /// Looks on behind a boundary, whose way passes on so much light, or none, for layers.
    #[inline(always)]
    fn look_across(&mut self, hit: &GeometryHit, weight: impl FnOnce() -> Option<Rgb>) {
        let (world, ray) = (self.context.world, self.trail.ray);
        self.look(|sight| sight.cross(world, (&ray, hit), weight()));
    }

    /// Follows a way that was chosen with this probability.
    fn follow(&mut self, hit: &GeometryHit, (way, chance): (Way, f32)) -> Option<()> {
        self.trail.throughput *= way.share / (chance * way.eta * way.eta);
        self.go_along(hit, way.wi);
        if is_black(self.trail.throughput) || !self.trail.throughput.is_finite() {
            return None;
        }
        self.refract(way.eta);
        self.trail.mis = MisState::Delta;
        self.russian_roulette()
    }

    /// Notes a change of the refractive index by this factor, for Russian roulette.
    #[inline(always)]
    fn refract(&mut self, eta: f32) {
        let eta2 = eta * eta;
        self.trail.eta_scale *= eta2.max(1.0 / eta2);
    }

    /// The ray in direction `wi`, and the medium around it.
    #[inline(always)]
    fn go_along(&mut self, hit: &GeometryHit, wi: Vec3) {
        self.trail.ray = hit.surface.spawn_ray(wi);
        if MEDIA {
            let world = self.context.world;
            self.trail.medium = world.medium_beyond(hit, wi, self.trail.medium);
        }
    }

    /// Continues with light that a surface transmits: straight on, or by subsurface scattering from another
    /// point of it.
    #[inline(never)]
    pub(super) fn sample_transmission(
        &mut self,
        hit: &GeometryHit,
        (bsdf, sample): (&Bsdf, &BsdfSample),
        differentials: Option<&RayDifferentials>,
    ) -> Option<()> {
        let surface = &hit.surface;
        if sample.specular {
            self.refract(sample.eta);
        }
        let (world, stream) = (self.context.world, &mut *self.context.stream);
        let (scattered, choice) = ((bsdf, sample), || stream.next_1d());
        let subsurface =
            world.subsurface_transport(hit.material, surface, scattered, differentials, choice);
        self.trail.throughput *= subsurface.share;
        let Some(bssrdf) = subsurface.bssrdf else {
            return self.continue_with(hit, bsdf, sample);
        };
        if !sample.specular {
            let light = self.emission_along(hit, bsdf, sample);
            self.gain(light);
        }
        let exit = find_exit(world, self.context.stream, &bssrdf, hit)?;
        self.trail.throughput *= exit.weight;
        self.sample_direct_at_surface(&exit.hit, &exit.bsdf);
        let sample = self.sample_bsdf(&exit.hit, &exit.bsdf)?;
        self.continue_with(&exit.hit, &exit.bsdf, &sample)
    }

    /// Continues along the direction of `sample`.
    #[inline(always)]
    pub(super) fn continue_with(
        &mut self,
        hit: &GeometryHit,
        bsdf: &Bsdf,
        sample: &BsdfSample,
    ) -> Option<()> {
        self.trail.specular_only &= sample.specular;
        if self.path.direct_only && !sample.specular {
            self.trail.max_depth = self.trail.max_depth.min(self.trail.depth + 1);
        }
        self.trail.mis = if sample.specular {
            MisState::Delta
        } else {
            self.mis_after(hit, bsdf, sample)
        };
        self.go_along(hit, sample.wi);
        Some(())
    }
}
