//! What a camera ray shows before any light is known: the surfaces that layers tell of.
//!
//! Perfect mirrors and smooth glass are followed, as denoisers want it (Intel Open Image Denoise, documentation of its
//! auxiliary images): each ray takes one of the ways that the surface offers, with its probability, so that a pixel blends
//! what is reflected with what is seen through. `path`, `volpath`, `bdpt`, `directlighting` and `whitted` note what their paths meet. Where `path` and
//! `volpath` go both ways, they note it along one of these, at glass chosen by Fresnel reflectance. Where paths go another way (they scatter in a medium, or go all
//! ways) or end too early, it is followed from there. For other integrators a ray is traced for the layers alone. Whatever that draws is drawn from a
//! copy of the path's stream, so that no color depends on whether layers are wanted.

use super::MAX_NULL_SURFACES;
use crate::accel::{ClosestHit, GeometryHit, Thing};
use crate::bsdf::{Bsdf, BsdfSample};
use crate::film::SurfaceSample;
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::{Rgb, Vec2, Vec3};
use crate::samplers::SampleStream;
use crate::world::World;

/// Mirrors and panes that are followed; a ray that is caught between more has no albedo.
const MAX_SPECULAR: u8 = 32;

/// What a camera ray has met.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct FirstSurfaces {
    /// The ray's first point on a surface with a material, and the surface's parameters there; and of the first surface that is not
    /// perfectly specular: the estimate of the share of light from everywhere that it sends back, times what those before it let
    /// through, and its shading normal, turned to where the ray came from. Both are 0 if there is none.
    pub surface: SurfaceSample,
    /// What the first surface is of.
    pub thing: Thing,
    /// What has been found there, if it moves.
    pub moving: Option<ClosestHit>,
}

/// Looks at a path from the camera, up to its first surface that is not perfectly specular.
///
/// All that most paths touch is in one cache line: the fields up to `first.thing`.
#[derive(Debug)]
#[repr(C)]
pub struct Sight {
    state: State,
    pub(super) wants_uv: bool,
    /// `first.moving` is set, which is in another line.
    moves: bool,
    /// Perfectly specular surfaces so far.
    specular: u8,
    first: FirstSurfaces,
    /// What these pass on, if there are any.
    share: Rgb,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd)]
#[repr(u8)]
enum State {
    /// Along the ray from the camera: nothing has been met.
    Looking,
    /// Along the ray from a specular surface.
    LookingOn,
    /// At the last surface, whose albedo the direction tells that the path samples.
    AtLast,
    /// All is known.
    Done,
    /// It is known that nothing is met.
    Empty,
    /// No layers are wanted.
    Off,
}

#[cfg(test)]
impl Sight {
    /// Bytes up to what most paths do not need.
    pub(super) const HOT: usize =
        std::mem::offset_of!(Sight, first) + std::mem::offset_of!(FirstSurfaces, moving);
}

impl Default for Sight {
    /// Looks at nothing.
    fn default() -> Sight {
        Sight {
            state: State::Off,
            wants_uv: false,
            moves: false,
            specular: 0,
            first: FirstSurfaces::default(),
            share: Rgb::ONE,
        }
    }
}

impl Sight {
    /// Meets a surface of `world` with a material; `has_interior`: there is a medium inside, into which no sight goes.
    #[inline(always)]
    pub(super) fn meet(
        &mut self,
        world: &World,
        (ray, hit): (&Ray, &GeometryHit),
        (bsdf, has_interior): (&Bsdf, bool),
    ) {
        if !self.is_looking() {
            return;
        }
        self.find(world, ray, hit);
        // Of no lobes it is 0.
        let albedo = bsdf.diffuse_reflectance();
        if albedo.is_none() && !bsdf.has_non_specular() && !has_interior {
            return;
        }
        let normal = hit.surface.turned(bsdf.shading_normal());
        self.first.surface.set_normal(normal);
        self.state = State::AtLast;
        if let Some(albedo) = albedo {
            self.stay(albedo);
        }
    }

    /// Follows the ray, which has met this, where the path does not: it has scattered in a medium before, and media are not seen.
    pub(super) fn follow(
        &mut self,
        world: &World,
        (ray, hit): (&Ray, Option<&GeometryHit>),
        differentials: Option<&RayDifferentials>,
        stream: &SampleStream,
    ) {
        if self.is_looking() {
            let mut follower = Follower::new(self, world, stream);
            let next = follower.step(ray, hit, differentials);
            follower.trace(next);
        }
    }

    /// The same of a ray that the path does not take.
    #[inline(always)]
    pub(super) fn follow_ray(&mut self, world: &World, ray: Ray, stream: &SampleStream) {
        if self.is_looking() {
            Follower::new(self, world, stream).trace(Some(ray));
        }
    }

    /// Crosses a smooth boundary one way, which passes on so much, or nothing: as [`Sight::meet`] and [`Sight::scatter`].
    pub(super) fn cross(
        &mut self,
        world: &World,
        (ray, hit): (&Ray, &GeometryHit),
        weight: Option<Rgb>,
    ) {
        if self.is_looking() {
            self.find(world, ray, hit);
            self.pass_through(weight);
        }
    }

    /// Meets a surface and follows one way from there: the path goes all of them.
    pub(super) fn meet_alone(
        &mut self,
        world: &World,
        met: (&Ray, &GeometryHit),
        scattering: (&Bsdf, bool),
        stream: &SampleStream,
    ) {
        self.meet(world, met, scattering);
        if !self.is_done() {
            let mut follower = Follower::new(self, world, stream);
            let next = follower.scatter(met.1, scattering.0);
            follower.trace(next);
        }
    }

    /// Meets a surface that is coated alike everywhere, which [scatters](Sight::pass_on).
    pub(super) fn meet_coated(&mut self, world: &World, ray: &Ray, hit: &GeometryHit) {
        if self.is_looking() {
            self.find(world, ray, hit);
            let normal = hit.surface.turned(hit.surface.shading.n);
            self.first.surface.set_normal(normal);
            self.state = State::AtLast;
        }
    }

    /// Meets a triangle that does not move, of which all is known: the point, the shading normal, turned to where the ray came from, and
    /// (u, v). It is matte with this reflectance, or [scatters](Sight::pass_on) otherwise.
    #[inline(always)]
    pub(super) fn meet_bare(
        &mut self,
        thing: Thing,
        (p, normal, uv): (Vec3, Vec3, Vec2),
        reflectance: Option<Rgb>,
    ) {
        let first = &mut self.first;
        if self.state == State::Looking {
            first.thing = thing;
            first.surface.set_p(p);
            first.surface.set_uv(uv);
        }
        first.surface.set_normal(normal);
        self.state = State::AtLast;
        match reflectance {
            // Its numbers are known to be finite.
            Some(reflectance) if self.specular == 0 => {
                first.surface.set_albedo(reflectance);
                self.state = State::Done;
            }
            Some(reflectance) => self.stay(reflectance),
            None => {}
        }
    }

    /// The path continues from the last surface with this weight, or does not.
    #[inline(always)]
    pub(super) fn pass_on(&mut self, weight: Option<Rgb>) {
        if self.state == State::AtLast {
            self.stay(weight.unwrap_or(Rgb::ZERO));
        }
    }

    /// Nothing is known yet of the first surface that is not perfectly specular.
    #[inline(always)]
    pub(super) fn is_looking(&self) -> bool {
        self.state <= State::LookingOn
    }

    /// (u, v) of the first surface are wanted, and not known yet.
    #[inline(always)]
    pub(super) fn wants_parameters(&self) -> bool {
        self.state == State::Looking && self.wants_uv
    }

    /// What a ray meets, with what is asked of it.
    #[inline(always)]
    pub(super) fn intersect(&self, world: &World, ray: &Ray) -> Option<GeometryHit> {
        world.intersect_with(ray, self.wants_parameters())
    }

    /// All is known, or nothing asked for.
    #[inline(always)]
    pub(super) fn is_done(&self) -> bool {
        self.state >= State::Done
    }

    /// Notes the first surface, which may be this one.
    #[inline(always)]
    fn find(&mut self, world: &World, ray: &Ray, hit: &GeometryHit) {
        if self.state != State::Looking {
            return;
        }
        self.state = State::LookingOn;
        let (point, found, first) = (&hit.surface, &hit.found, &mut self.first);
        first.surface.set_p(point.p);
        // Where the path has not asked for them, they are not known.
        let is_bare = point.dpdu == Vec3::ZERO && point.uv == Vec2::ZERO;
        let lacks_uv = self.wants_uv && is_bare;
        first.surface.set_uv(match lacks_uv {
            true => parameters(world, ray, found),
            false => point.uv,
        });
        first.thing = Thing::new(hit.material, world.geometry.standing(hit));
        if world.moves() && world.geometry.moves_there(found) {
            first.moving = Some(*found);
            self.moves = true;
        }
    }

    /// Looks no further.
    #[inline(always)]
    fn stay(&mut self, albedo: Rgb) {
        let share = match self.specular {
            0 => albedo,
            _ => self.share * albedo,
        };
        self.first.surface.set_albedo(share);
        self.first.surface.make_finite();
        self.state = State::Done;
    }

    /// The path continues from that surface, or does not.
    pub(super) fn scatter(&mut self, bsdf: &Bsdf, sample: Option<&BsdfSample>) {
        let weight = sample.map_or(Rgb::ZERO, |sample| {
            Sight::weight(bsdf.shading_normal(), sample)
        });
        match self.state {
            State::Looking | State::LookingOn => self.pass_through(sample.map(|_| weight)),
            _ => self.pass_on(Some(weight)),
        }
    }

    /// A perfectly specular surface passes on so much, or nothing.
    fn pass_through(&mut self, weight: Option<Rgb>) {
        let share = weight.unwrap_or(Rgb::ZERO);
        self.share = match self.specular {
            0 => share,
            _ => self.share * share,
        };
        self.specular += 1;
        if weight.is_none() || self.specular > MAX_SPECULAR {
            self.stop();
        }
    }

    /// No surface is found that is not perfectly specular.
    fn stop(&mut self) {
        self.first.surface.make_black();
        self.state = State::Done;
    }

    /// What a sampled direction passes on where the normal is `n`, if reflectances are not scaled between media as radiance is.
    #[inline(always)]
    pub(super) fn weight(n: Vec3, sample: &BsdfSample) -> Rgb {
        let cosine = sample.wi.dot(n).abs();
        let unscaled = if sample.transmission {
            sample.eta * sample.eta
        } else {
            1.0
        };
        sample.f * (cosine * unscaled / sample.pdf)
    }

    /// There is nothing more.
    pub(super) fn escape(&mut self) {
        match self.state {
            State::Looking => self.state = State::Empty,
            State::LookingOn => self.stop(),
            _ => {}
        }
    }

    /// What has been met, nothing perhaps; `None` if the path has not told it.
    #[inline(always)]
    pub fn known(&self) -> Option<Option<&FirstSurfaces>> {
        match self.state {
            State::Done => Some(Some(&self.first)),
            State::Empty => Some(None),
            _ => None,
        }
    }

    /// What has been met, if anything has.
    #[inline(always)]
    pub(super) fn first(&self) -> &FirstSurfaces {
        &self.first
    }

    /// Returns `true` if layers are wanted.
    #[inline(always)]
    pub(super) fn is_on(&self) -> bool {
        self.state != State::Off
    }

    /// Looks at another path, and where `wants_uv` is `true` asks for (u, v) of what it meets.
    #[inline(always)]
    pub(super) fn restart(&mut self, wants_uv: bool) {
        (self.state, self.wants_uv, self.specular) = (State::Looking, wants_uv, 0);
        if self.moves {
            (self.moves, self.first.moving) = (false, None);
        }
    }
}

/// Those of a hit of which they are not known, as of few.
#[cold]
#[inline(never)]
fn parameters(world: &World, ray: &Ray, found: &ClosestHit) -> Vec2 {
    world.surface_parameters(ray, found)
}

/// The direction in which a path continues that samples no light here.
fn sampled(bsdf: &Bsdf, wo: Vec3, stream: &mut SampleStream) -> Option<BsdfSample> {
    stream.skip_1d();
    stream.skip_2d();
    let third = stream.next_1d_if(bsdf.needs_third());
    bsdf.sample(wo, third, stream.next_2d())
}

/// Follows rays for layers alone.
struct Follower<'a> {
    sight: &'a mut Sight,
    world: &'a World,
    stream: SampleStream,
    null_surfaces: u32,
}

impl<'a> Follower<'a> {
    fn new(sight: &'a mut Sight, world: &'a World, stream: &SampleStream) -> Follower<'a> {
        Follower {
            sight,
            world,
            stream: *stream,
            null_surfaces: 0,
        }
    }

    /// Traces a ray, and what continues it.
    fn trace(&mut self, mut next: Option<Ray>) {
        while let Some(ray) = next {
            let hit = self.sight.intersect(self.world, &ray);
            next = self.step(&ray, hit.as_ref(), None);
        }
    }

    /// What continues a ray that has met this, if there is more to see.
    fn step(
        &mut self,
        ray: &Ray,
        hit: Option<&GeometryHit>,
        differentials: Option<&RayDifferentials>,
    ) -> Option<Ray> {
        let is_caught = self.null_surfaces > MAX_NULL_SURFACES;
        let Some(hit) = hit.filter(|_| !is_caught) else {
            self.sight.escape();
            return None;
        };
        let Some(material) = self.world.material(hit.material) else {
            self.null_surfaces += 1;
            return Some(hit.surface.spawn_ray(ray.d));
        };
        let mut bsdf = Bsdf::empty();
        let surface = &hit.surface;
        { self.world }.fill_bsdf(material, surface, differentials, &mut bsdf);
        self.sight
            .meet(self.world, (ray, hit), (&bsdf, material.has_interior()));
        self.scatter(hit, &bsdf)
    }

    /// What continues a ray from a surface that has been met, if there is more to see.
    fn scatter(&mut self, hit: &GeometryHit, bsdf: &Bsdf) -> Option<Ray> {
        if self.sight.is_done() {
            return None;
        }
        let surface = &hit.surface;
        let sample = sampled(bsdf, surface.wo, &mut self.stream);
        self.sight.scatter(bsdf, sample.as_ref());
        let next = sample.filter(|_| self.sight.is_looking())?;
        Some(surface.spawn_ray(next.wi))
    }
}

/// Traces a camera ray. `None` if it meets no surface with a material. Participating media are not seen.
pub fn first_surfaces(
    world: &World,
    ray: &Ray,
    differentials: Option<&RayDifferentials>,
    stream: SampleStream,
    wants_uv: bool,
) -> Option<FirstSurfaces> {
    let mut sight = Sight::default();
    sight.restart(wants_uv);
    let hit = sight.intersect(world, ray);
    sight.follow(world, (ray, hit.as_ref()), differentials, &stream);
    let is_empty = matches!(sight.state, State::Looking | State::Empty);
    (!is_empty).then_some(sight.first)
}
