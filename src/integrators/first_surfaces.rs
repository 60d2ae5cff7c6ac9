//! What a camera ray shows before any light is known: the surfaces that layers tell of.
//!
//! Perfect mirrors and smooth glass are followed, as denoisers want it (Intel Open Image Denoise, documentation of its
//! auxiliary images): each ray takes one of the ways that the surface offers, with its probability, so that a pixel blends
//! what is reflected with what is seen through. `path` and `volpath` note what their paths meet; where these are of no use (they
//! have scattered in a medium, or ended too early), and for other integrators, a ray is traced for the layers alone, with the
//! path's first sample points on a copy of the stream. So no color depends on whether layers are wanted.

use super::MAX_NULL_SURFACES;
use crate::accel::{ClosestHit, GeometryHit, Standing};
use crate::bsdf::{Bsdf, BsdfSample};
use crate::handles::MaterialId;
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::{Rgb, Vec2, Vec3};
use crate::samplers::SampleStream;
use crate::surface::SurfaceHit;
use crate::world::World;

/// Mirrors and panes that are followed; a ray that is caught between more has no albedo.
const MAX_SPECULAR: u32 = 32;

/// What a camera ray has met.
#[derive(Clone, Copy, Debug)]
pub struct FirstSurfaces {
    /// Its first point on a surface with a material, in render space.
    pub p: Vec3,
    /// The surface's parameters there; `None` where nothing else asks for them.
    pub uv: Option<Vec2>,
    /// The ray that has met it: the camera's, or what is left of that beyond surfaces without material.
    pub ray: Ray,
    /// What it has met.
    pub found: ClosestHit,
    /// Its material.
    pub material: Option<MaterialId>,
    /// The shape or instance that it is of, if that is known already.
    pub standing: Option<Standing>,
    /// The estimate of the share of light from everywhere that the first surface which is not perfectly specular sends
    /// back, times what those before it let through; black if there is none.
    pub albedo: Rgb,
    /// Shading normal of that surface in render space, turned to where the ray came from; 0 if there is none.
    pub normal: Vec3,
}

/// Looks at a path from the camera, up to its first surface that is not perfectly specular.
#[derive(Debug)]
pub struct Sight {
    found: Option<FirstSurfaces>,
    share: Rgb,
    specular: u32,
    state: State,
    pub(super) wants_uv: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Along the ray, from the camera or a specular surface.
    Looking,
    /// At the last surface, whose albedo the direction tells that the path samples.
    AtLast,
    /// All is known.
    Done,
    /// The path has gone another way than light that is seen.
    Lost,
}

impl Default for Sight {
    fn default() -> Sight {
        Sight {
            found: None,
            share: Rgb::ONE,
            specular: 0,
            state: State::Looking,
            wants_uv: false,
        }
    }
}

impl Sight {
    /// Meets a surface with a material; `has_interior`: there is a medium inside, into which no sight goes.
    pub(super) fn meet(&mut self, ray: &Ray, hit: &GeometryHit, bsdf: &Bsdf, has_interior: bool) {
        if !self.is_looking() {
            return;
        }
        let surface = &hit.surface;
        let found = self.find(ray, (&hit.found, hit.material, None), point(surface));
        if !bsdf.has_non_specular() && !has_interior && bsdf.lobe_count() > 0 {
            return;
        }
        found.turn(bsdf.shading_normal(), surface.wo);
        self.state = State::AtLast;
        if let Some(albedo) = bsdf.diffuse_reflectance() {
            self.stay(albedo);
        }
    }

    /// Meets a surface that is coated alike everywhere.
    pub(super) fn meet_coated(&mut self, ray: &Ray, hit: &GeometryHit) {
        let (p, uv) = point(&hit.surface);
        let normal = hit.surface.shading.n;
        self.meet_bare(ray, (&hit.found, hit.material, None), (p, normal, uv), None);
    }

    /// Meets a surface with this shading normal, of which nothing but layers asks for (u, v): it is matte with this reflectance, or
    /// [scatters](Sight::pass_on) otherwise.
    #[inline(always)]
    pub(super) fn meet_bare(
        &mut self,
        ray: &Ray,
        hit: (&ClosestHit, Option<MaterialId>, Option<Standing>),
        (p, n, uv): (Vec3, Vec3, Option<Vec2>),
        reflectance: Option<Rgb>,
    ) {
        if self.is_looking() {
            self.find(ray, hit, (p, uv)).turn(n, -ray.d);
            self.state = State::AtLast;
            if let Some(reflectance) = reflectance {
                self.stay(reflectance);
            }
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
        self.state == State::Looking
    }

    /// All is known, or nothing will be.
    #[inline(always)]
    pub(super) fn is_done(&self) -> bool {
        matches!(self.state, State::Done | State::Lost)
    }

    /// The first surface, which may be this one.
    #[inline(always)]
    fn find(
        &mut self,
        ray: &Ray,
        (found, material, standing): (&ClosestHit, Option<MaterialId>, Option<Standing>),
        (p, uv): (Vec3, Option<Vec2>),
    ) -> &mut FirstSurfaces {
        self.found.get_or_insert(FirstSurfaces {
            standing,
            p,
            uv,
            ray: *ray,
            found: *found,
            material,
            albedo: Rgb::ZERO,
            normal: Vec3::ZERO,
        })
    }

    /// Looks no further.
    fn stay(&mut self, albedo: Rgb) {
        if let Some(found) = &mut self.found {
            found.albedo = self.share * albedo;
        }
        self.state = State::Done;
    }

    /// The path continues from that surface, or does not.
    pub(super) fn scatter(&mut self, bsdf: &Bsdf, sample: Option<&BsdfSample>) {
        let weight = sample.map_or(Rgb::ZERO, |sample| weight(bsdf, sample));
        match self.state {
            State::Looking => {
                self.share *= weight;
                self.specular += 1;
                if sample.is_none() || self.specular > MAX_SPECULAR {
                    self.state = State::Done;
                }
            }
            _ => self.pass_on(Some(weight)),
        }
    }

    /// There is nothing more.
    pub(super) fn escape(&mut self) {
        if self.state == State::Looking {
            self.state = State::Done;
        }
    }

    /// The path scatters in a medium.
    pub(super) fn lose(&mut self) {
        if self.state == State::Looking {
            self.state = State::Lost;
        }
    }

    /// What has been met, nothing perhaps; `None` if the path has not told it.
    pub fn known(&self) -> Option<Option<&FirstSurfaces>> {
        (self.state == State::Done).then_some(self.found.as_ref())
    }

    /// Looks at another path, and where `wants_uv` is `true` asks for (u, v) of what it meets.
    #[inline(always)]
    pub(super) fn restart(&mut self, wants_uv: bool) {
        self.found = None;
        (self.share, self.specular) = (Rgb::ONE, 0);
        (self.state, self.wants_uv) = (State::Looking, wants_uv);
    }
}

impl FirstSurfaces {
    /// Albedo and normal, if they are numbers: one sample that is not finite would spoil its pixel.
    #[inline(always)]
    pub fn finite(&self) -> (Rgb, Vec3) {
        let is_finite = || self.albedo.is_finite() && self.normal.is_finite();
        // Nearly always: then no addend was anything else.
        match (self.albedo + self.normal).element_sum().is_finite() || is_finite() {
            true => (self.albedo, self.normal),
            false => (Rgb::ZERO, Vec3::ZERO),
        }
    }

    /// Sets the normal, turned to where the ray came from.
    fn turn(&mut self, n: Vec3, wo: Vec3) {
        self.normal = if n.dot(wo) < 0.0 { -n } else { n };
    }
}

/// A point and its parameters, if they are known: nothing asks for those of bare triangles.
fn point(surface: &SurfaceHit) -> (Vec3, Option<Vec2>) {
    let uv = (surface.dpdu != Vec3::ZERO).then_some(surface.uv);
    (surface.p, uv)
}

/// What a sampled direction passes on, if reflectances are not scaled between media as radiance is.
fn weight(bsdf: &Bsdf, sample: &BsdfSample) -> Rgb {
    let cosine = sample.wi.dot(bsdf.shading_normal()).abs();
    let unscaled = if sample.transmission {
        sample.eta * sample.eta
    } else {
        1.0
    };
    sample.f * (cosine * unscaled / sample.pdf)
}

/// Traces a camera ray. `None` if it meets no surface with a material. Participating media are not seen.
pub fn first_surfaces(
    world: &World,
    ray: &Ray,
    mut differentials: Option<&RayDifferentials>,
    mut stream: SampleStream,
) -> Option<FirstSurfaces> {
    let (mut ray, mut sight, mut null) = (*ray, Sight::default(), 0);
    while sight.state == State::Looking {
        let Some(hit) = world.intersect(&ray) else {
            break;
        };
        let surface = &hit.surface;
        let Some(material) = world.material(hit.material) else {
            null += 1;
            if null > MAX_NULL_SURFACES {
                break;
            }
            (ray, differentials) = (surface.spawn_ray(ray.d), None);
            continue;
        };
        let mut bsdf = Bsdf::empty();
        world.fill_bsdf(material, surface, differentials.take(), &mut bsdf);
        sight.meet(&ray, &hit, &bsdf, material.has_interior());
        if sight.state == State::Done {
            break;
        }
        // As a path does, which samples no light here.
        stream.skip_1d();
        stream.skip_2d();
        let third = stream.next_1d_if(bsdf.needs_third());
        let sample = bsdf.sample(surface.wo, third, stream.next_2d());
        sight.scatter(&bsdf, sample.as_ref());
        if let Some(sample) = sample {
            ray = surface.spawn_ray(sample.wi);
        }
    }
    sight.found
}
