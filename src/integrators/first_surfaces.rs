//! What a camera ray shows before any light is known: the surfaces that layers tell of.
//!
//! Perfect mirrors and smooth glass are followed, as denoisers want it (Intel Open Image Denoise, documentation of its
//! auxiliary images): each ray takes one of the ways that the surface offers, with its probability, so that a pixel blends
//! what is reflected with what is seen through. `path` and `volpath` note what their paths meet, `directlighting` and `whitted` a first surface
//! that is not specular; where these are of no use (they have scattered in a medium, or ended too early, or gone all ways), and for other integrators, a
//! ray is traced for the layers alone, with the path's first sample points on a copy of the stream. So no color depends on whether layers are wanted.

use super::MAX_NULL_SURFACES;
use crate::accel::{ClosestHit, GeometryHit, Standing};
use crate::bsdf::{Bsdf, BsdfSample};
use crate::film::SurfaceSample;
use crate::handles::MaterialId;
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::{Rgb, Vec2, Vec3};
use crate::samplers::SampleStream;
use crate::world::World;

/// Mirrors and panes that are followed; a ray that is caught between more has no albedo.
const MAX_SPECULAR: u32 = 32;

/// What a camera ray has met.
#[derive(Clone, Copy, Debug, Default)]
pub struct FirstSurfaces {
    /// The ray's first point on a surface with a material, and the surface's parameters there; and of the first surface that is not
    /// perfectly specular: the estimate of the share of light from everywhere that it sends back, times what those before it let
    /// through, and its shading normal, turned to where the ray came from. Both are 0 if there is none.
    pub surface: SurfaceSample,
    /// The material of the first surface.
    pub material: Option<MaterialId>,
    /// The shape or instance that it is of, if that is known already.
    pub standing: Option<Standing>,
    /// How it was met, where that may be asked for more; `None` for a shape that does not move, all of which is known.
    pub meeting: Option<Meeting>,
}

/// How a camera ray has met a surface.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// The camera's ray, or what is left of that beyond surfaces without material.
    pub ray: Ray,
    /// What it has met.
    pub found: ClosestHit,
    /// Nothing else asks for the surface's parameters, which are not known.
    pub lacks_uv: bool,
}

/// Looks at a path from the camera, up to its first surface that is not perfectly specular.
#[derive(Debug)]
pub struct Sight {
    state: State,
    /// Nothing has been met.
    is_empty: bool,
    pub(super) wants_uv: bool,
    specular: u32,
    share: Rgb,
    first: FirstSurfaces,
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
            state: State::Looking,
            is_empty: true,
            wants_uv: false,
            specular: 0,
            share: Rgb::ONE,
            first: FirstSurfaces::default(),
        }
    }
}

impl Sight {
    /// Meets a surface with a material; `has_interior`: there is a medium inside, into which no sight goes.
    pub(super) fn meet(&mut self, ray: &Ray, hit: &GeometryHit, bsdf: &Bsdf, has_interior: bool) {
        if !self.is_looking() {
            return;
        }
        self.find(ray, hit);
        if !bsdf.has_non_specular() && !has_interior && bsdf.lobe_count() > 0 {
            return;
        }
        let normal = turned(bsdf.shading_normal(), hit.surface.wo);
        self.first.surface.set_normal(normal);
        self.state = State::AtLast;
        if let Some(albedo) = bsdf.diffuse_reflectance() {
            self.stay(albedo);
        }
    }

    /// Meets a first surface, beyond which all ways are gone and not one: a specular one is no use. `stream` has the path's first numbers.
    pub(super) fn meet_alone(
        &mut self,
        ray: &Ray,
        hit: &GeometryHit,
        (bsdf, has_interior): (&Bsdf, bool),
        mut stream: SampleStream,
    ) {
        self.meet(ray, hit, bsdf, has_interior);
        match self.state {
            State::Looking => self.state = State::Lost,
            State::AtLast => {
                let sample = sampled(bsdf, hit.surface.wo, &mut stream);
                self.scatter(bsdf, sample.as_ref());
            }
            State::Done | State::Lost => {}
        }
    }

    /// Meets a surface that is coated alike everywhere, which [scatters](Sight::pass_on).
    pub(super) fn meet_coated(&mut self, ray: &Ray, hit: &GeometryHit) {
        if self.is_looking() {
            self.find(ray, hit);
            let normal = turned(hit.surface.shading.n, hit.surface.wo);
            self.first.surface.set_normal(normal);
            self.state = State::AtLast;
        }
    }

    /// Meets a triangle that does not move, of which all is known: the point, the shading normal, turned to where the ray came from, and
    /// (u, v). It is matte with this reflectance, or [scatters](Sight::pass_on) otherwise.
    #[inline(always)]
    pub(super) fn meet_bare(
        &mut self,
        (material, standing): (Option<MaterialId>, Standing),
        (p, normal, uv): (Vec3, Vec3, Vec2),
        reflectance: Option<Rgb>,
    ) {
        let first = &mut self.first;
        if self.is_empty {
            self.is_empty = false;
            (first.material, first.standing) = (material, Some(standing));
            first.meeting = None;
            first.surface.set_p(p);
            first.surface.set_uv(uv);
        }
        first.surface.set_normal(normal);
        self.state = State::AtLast;
        if let Some(reflectance) = reflectance {
            self.stay(reflectance);
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

    /// Notes the first surface, which may be this one.
    fn find(&mut self, ray: &Ray, hit: &GeometryHit) {
        if !self.is_empty {
            return;
        }
        let point = &hit.surface;
        let mut surface = SurfaceSample::default();
        surface.set_p(point.p);
        surface.set_uv(point.uv);
        let meeting = Meeting {
            ray: *ray,
            found: hit.found,
            lacks_uv: point.dpdu == Vec3::ZERO,
        };
        self.is_empty = false;
        self.first = FirstSurfaces {
            surface,
            material: hit.material,
            standing: None,
            meeting: Some(meeting),
        };
    }

    /// Looks no further.
    #[inline(always)]
    fn stay(&mut self, albedo: Rgb) {
        let share = match self.specular {
            0 => albedo,
            _ => self.share * albedo,
        };
        self.first.surface.set_albedo(share);
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
    #[inline(always)]
    pub fn known(&self) -> Option<Option<&FirstSurfaces>> {
        (self.state == State::Done).then_some(self.seen())
    }

    fn seen(&self) -> Option<&FirstSurfaces> {
        (!self.is_empty).then_some(&self.first)
    }

    /// Looks at another path, and where `wants_uv` is `true` asks for (u, v) of what it meets.
    #[inline(always)]
    pub(super) fn restart(&mut self, wants_uv: bool) {
        (self.state, self.is_empty, self.wants_uv) = (State::Looking, true, wants_uv);
        (self.share, self.specular) = (Rgb::ONE, 0);
    }
}

/// A normal, turned to where the ray came from.
fn turned(n: Vec3, wo: Vec3) -> Vec3 {
    if n.dot(wo) < 0.0 { -n } else { n }
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

/// The direction in which a path continues that samples no light here.
fn sampled(bsdf: &Bsdf, wo: Vec3, stream: &mut SampleStream) -> Option<BsdfSample> {
    stream.skip_1d();
    stream.skip_2d();
    let third = stream.next_1d_if(bsdf.needs_third());
    bsdf.sample(wo, third, stream.next_2d())
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
        let sample = sampled(&bsdf, surface.wo, &mut stream);
        sight.scatter(&bsdf, sample.as_ref());
        if let Some(sample) = sample {
            ray = surface.spawn_ray(sample.wi);
        }
    }
    sight.seen().copied()
}
