//! A subpath from the camera or from a light, one vertex after the other.

use super::vertex::{FlatVertex, importance_cosine, normals};
use super::weights::{History, Onward};
use crate::accel::GeometryHit;
use crate::bsdf::{Boundary, Bsdf, BsdfSample, Way};
use crate::handles::MediumId;
use crate::integrators::vertex::{MediumVertex, Vertex as _};
use crate::integrators::vertices::Next;
use crate::integrators::{BOTH_WAYS, MAX_NULL_SURFACES};
use crate::math::color::is_black;
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::{Rgb, Vec3};
use crate::samplers::SampleStream;
use crate::surface::{ReceiverSide, ReferencePoint, SurfaceHit};
use crate::world::World;
use arrayvec::ArrayVec;

/// Scattering events after which Russian roulette decides whether a subpath continues; before, unlike in [`crate::integrators::Path`], no
/// direction is judged.
const MIN_BOUNCES: u32 = 3;

/// The survival probability over the throughput. Where a dim mirror or glass shows something bright, a subpath of low throughput brings much of the
/// error: with 8 instead of 1 seven scenes of the census have 0.69 times the squared relative error (`spot_mirrorball` 0.39) in 1.00 to 1.04 times the
/// instructions; 16 is no better (docs/notes/light-paths.md).
const SCALE: f32 = 8.0;

/// No subpath is ended with less than this probability once roulette applies.
const MIN_TERMINATION: f32 = 0.05;

/// How the density of the next vertex follows from what was sampled at the last one.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Spread {
    /// A direction from a point, with this density per solid angle; the cosine there turns densities of the other side into
    /// those per area.
    FromPoint { pdf: f32, cosine: f32 },
    /// A point of a beam of parallel rays from a light at infinity, with this density per area across. Densities
    /// of the light itself are per solid angle.
    Beam { pdf: f32 },
    /// The camera's, whose densities are in [`Onward::before`]: those of the lens over those of the film's samples.
    #[default]
    Camera,
}

/// A subpath on its way to the next vertex.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Walk {
    /// To the next vertex.
    pub ray: Ray,
    /// Around the ray.
    pub medium: Option<MediumId>,
    /// Values over densities so far.
    pub throughput: Rgb,
    /// The last vertex.
    pub from: ReferencePoint,
    pub spread: Spread,
    pub onward: Onward,
    /// No strategy joins the last vertex to others: the camera, or a delta.
    pub after_delta: bool,
    /// Scattering events so far.
    pub depth: u32,
    /// Throughput that Russian roulette judges by.
    roulette: Rgb,
    null_surfaces: u32,
}

/// A way that a subpath takes when it has come to the end of others, and its numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Branch {
    walk: Walk,
    stream: SampleStream,
}

/// Those of a path: at most one for each smooth boundary where it takes both.
pub(super) type Branches = ArrayVec<Branch, { BOTH_WAYS as usize }>;

impl Branch {
    /// Lets the subpath take this way.
    pub(super) fn take(self, walk: &mut Walk, stream: &mut SampleStream) {
        (*walk, *stream) = (self.walk, self.stream);
    }
}

/// What a subpath meets.
#[derive(Clone, Copy)]
pub(super) enum Met {
    /// Nothing.
    Background,
    /// A particle.
    Medium(MediumVertex),
    /// A surface, with or without material.
    Surface,
}

impl Met {
    /// At the end of a ray that hits a surface at distance `t`, if any.
    #[inline(always)]
    pub(super) fn at_end(t: Option<f32>) -> Met {
        t.map_or(Met::Background, |_| Met::Surface)
    }
}

impl Walk {
    /// Begins at a vertex; what is known of that depends on the next. In place: a copy would wait for all that was just written.
    #[inline(always)]
    pub(super) fn begin(
        &mut self,
        ray: &Ray,
        medium: Option<MediumId>,
        (from, spread): (&ReferencePoint, Spread),
        throughput: Rgb,
    ) {
        self.ray = *ray;
        self.medium = medium;
        self.throughput = throughput;
        self.from = *from;
        self.spread = spread;
        self.onward = Onward::default();
        self.after_delta = true;
        self.depth = 0;
        self.roulette = Rgb::ONE;
        self.null_surfaces = 0;
    }

    /// To the next surface, if the ray hits one, at distance `t`, or to what scatters before it. `None` where the throughput becomes black, or
    /// what is not finite enters a medium.
    pub(super) fn advance(
        &mut self,
        world: &World,
        t: Option<f32>,
        stream: &mut SampleStream,
    ) -> Option<Met> {
        if let Some(id) = self.medium {
            if !self.throughput.is_finite() {
                return None;
            }
            let t_max = t.unwrap_or(self.ray.t_max);
            let medium = world.media.medium(id);
            let (flight, phase) = medium.sample(&self.ray, t_max, self.throughput, stream);
            self.throughput *= flight.weight;
            if is_black(self.throughput) || !self.throughput.is_finite() {
                return None;
            }
            if let Some(t) = flight.scattered {
                let p = self.ray.at(t);
                return p.is_finite().then_some(Met::Medium(MediumVertex {
                    p,
                    wo: -self.ray.d,
                    phase,
                    medium: id,
                    time: self.ray.time,
                }));
            }
        }
        Some(Met::at_end(t))
    }

    /// Through a surface without material.
    pub(super) fn pass(&mut self, world: &World, hit: &GeometryHit) -> Option<()> {
        self.null_surfaces += 1;
        if self.null_surfaces > MAX_NULL_SURFACES {
            return None;
        }
        self.medium = world.medium_beyond(hit, self.ray.d, self.medium);
        self.ray = hit.surface.spawn_ray(self.ray.d);
        Some(())
    }

    /// The vertex at `p`, seen under this cosine to its normal.
    pub(super) fn arrive(&self, p: Vec3, cosine: f32) -> History {
        let Onward { before, rest } = self.onward;
        let cosine = f64::from(cosine);
        let (density, backward) = match self.spread {
            Spread::FromPoint { pdf, cosine: from } => {
                let distance2 = (p.as_dvec3() - self.from.p.as_dvec3()).length_squared();
                (
                    f64::from(pdf) * cosine / distance2,
                    f64::from(from) / distance2,
                )
            }
            Spread::Beam { pdf } => (f64::from(pdf) * cosine, 1.0),
            Spread::Camera => (cosine, 0.0),
        };
        History {
            density,
            backward,
            before,
            rest,
        }
    }

    /// The subpath continues from a point of a medium.
    pub(super) fn scatter_in_medium(
        &mut self,
        at: &MediumVertex,
        history: &History,
        connections: f32,
        stream: &mut SampleStream,
    ) {
        let (wi, pdf) = at.phase.sample(at.wo, stream.next_2d());
        self.from = at.reference_point();
        self.ray = Ray::new(at.p, wi, at.time);
        self.spread = Spread::FromPoint { pdf, cosine: 1.0 };
        self.onward = history.onward(false, pdf.into(), connections);
        self.after_delta = false;
    }

    /// The subpath continues from a surface as in `sample`. `reverse` is the density per solid angle of the opposite
    /// direction.
    pub(super) fn scatter_at_surface(
        &mut self,
        world: &World,
        (hit, bsdf): (&GeometryHit, &Bsdf),
        sample: &BsdfSample,
        reverse: f32,
        (history, connections): (&History, f32),
    ) {
        let delta = sample.specular;
        // Densities of perfectly specular directions are left out on both sides.
        let (pdf, reverse) = if delta {
            (1.0, 1.0)
        } else {
            (sample.pdf, reverse)
        };
        self.medium = world.medium_beyond(hit, sample.wi, self.medium);
        self.from = crate::integrators::vertex::receiver(&hit.surface, bsdf);
        self.ray = hit.surface.spawn_ray(sample.wi);
        let cosine = hit.surface.n.dot(sample.wi).abs();
        self.spread = Spread::FromPoint { pdf, cosine };
        self.onward = history.onward(delta, reverse.into(), connections);
        self.after_delta = delta;
    }

    /// The subpath continues from a smooth boundary, as in [`Turn::sample`] and what follows.
    pub(super) fn cross(
        &mut self,
        world: &World,
        (hit, boundary): (&GeometryHit, &Boundary),
        (carries, connections): (Carries, f32),
        history: &History,
        stream: &mut SampleStream,
    ) -> Option<()> {
        let ways = boundary.ways(hit.surface.shading.n, hit.surface.wo);
        stream.skip_1d();
        let way = ways.choose(carries.evenness(), stream.next_2d().x)?;
        let judged = self.follow(world, hit, way, carries, (history, connections))?;
        self.russian_roulette(judged, stream)
    }

    /// As [`Walk::cross`], but takes both ways of glass (`Ways::both`); the fainter one is returned. So what is lit by the
    /// brighter way depends on where the subpath came from alone.
    pub(super) fn cross_both_ways(
        &mut self,
        world: &World,
        (hit, boundary): (&GeometryHit, &Boundary),
        (carries, connections): (Carries, f32),
        history: &History,
        stream: &mut SampleStream,
    ) -> (Option<()>, Option<Branch>) {
        let ways = boundary.ways(hit.surface.shading.n, hit.surface.wo);
        stream.skip_1d();
        let u = stream.next_2d().x;
        let other_stream = stream.fork();
        let follow = |walk: &mut Walk, way, stream: &mut SampleStream| {
            let judged = walk.follow(world, hit, way, carries, (history, connections))?;
            walk.russian_roulette(judged, stream)
        };
        let Some((brighter, (fainter, chance))) = ways.both() else {
            let only = ways.choose(carries.evenness(), u);
            return (only.and_then(|way| follow(self, way, stream)), None);
        };
        let mut other = (u < chance).then_some(Branch {
            walk: *self,
            stream: other_stream,
        });
        let first = follow(self, (brighter, 1.0), stream);
        let second = other
            .as_mut()
            .and_then(|other| follow(&mut other.walk, (fainter, chance), &mut other.stream));
        (first, other.filter(|_| second.is_some()))
    }

    /// The subpath follows a way that was chosen with this probability. Returns the factor that roulette judges by.
    #[inline(always)]
    fn follow(
        &mut self,
        world: &World,
        hit: &GeometryHit,
        (way, chance): (Way, f32),
        carries: Carries,
        (history, connections): (&History, f32),
    ) -> Option<Rgb> {
        let (surface, wi) = (&hit.surface, way.wi);
        let judged = way.share / chance;
        let factor = match carries {
            // Refraction scales radiance, not importance.
            Carries::Radiance => judged / (way.eta * way.eta),
            Carries::Importance => {
                judged * importance_correction((surface.n, surface.shading.n), surface.wo, wi)
            }
        };
        // A factor that is not finite is passed on, so that what comes of it is counted.
        if is_black(factor) || !wi.is_finite() {
            return None;
        }
        self.throughput *= factor;
        self.medium = world.medium_beyond(hit, wi, self.medium);
        self.from = boundary_receiver(surface);
        self.ray = surface.spawn_ray(wi);
        let cosine = surface.n.dot(wi).abs();
        self.spread = Spread::FromPoint { pdf: 1.0, cosine };
        self.onward = history.onward(true, 1.0, connections);
        self.after_delta = true;
        Some(judged)
    }

    /// The subpath continues from a flat triangle.
    pub(super) fn scatter_at_flat(
        &mut self,
        at: &FlatVertex,
        next: &Next,
        reverse: f32,
        (history, connections): (&History, f32),
    ) {
        self.from = at.from;
        self.ray = Ray::new(next.o, next.d, at.from.time);
        let (pdf, cosine) = (next.pdf, at.from.n.dot(next.d).abs());
        self.spread = Spread::FromPoint { pdf, cosine };
        self.onward = history.onward(false, reverse.into(), connections);
        self.after_delta = false;
    }

    /// Counts a scattering event that has multiplied the throughput by `factor`, apart from what refraction does to
    /// radiance, and decides whether the subpath continues.
    pub(super) fn russian_roulette(
        &mut self,
        factor: Rgb,
        stream: &mut SampleStream,
    ) -> Option<()> {
        self.depth += 1;
        self.roulette *= factor;
        let survival = SCALE * self.roulette.max_element();
        if self.depth <= MIN_BOUNCES + 1 || survival >= 1.0 {
            return Some(());
        }
        let termination = (1.0 - survival).max(MIN_TERMINATION);
        self.throughput /= 1.0 - termination;
        self.roulette /= 1.0 - termination;
        (stream.next_1d() >= termination).then_some(())
    }
}

/// What receives light on a surface that is perfectly specular.
pub(super) fn boundary_receiver(surface: &SurfaceHit) -> ReferencePoint {
    let receiver_side = match surface.wo.dot(surface.n) < 0.0 {
        true => ReceiverSide::Back,
        false => ReceiverSide::Front,
    };
    ReferencePoint {
        receiver_side,
        ..surface.reference_point()
    }
}

/// A direction from a surface, for a subpath from either end: the sample, the factor of the throughput, that factor for roulette,
/// and the density of the opposite direction.
pub(in super::super) struct Turn {
    pub sample: BsdfSample,
    pub factor: Rgb,
    pub judged: Rgb,
    pub reverse: f32,
}

/// Which quantity a subpath carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Carries {
    /// From the camera.
    Radiance,
    /// From a light.
    Importance,
}

impl Carries {
    /// How evenly paths are divided between what a smooth boundary reflects and what it refracts
    /// ([`Bsdf::even_out`]). From a light both go to different pixels; a camera path's is in one, which is the sum.
    fn evenness(self) -> f32 {
        match self {
            Carries::Radiance => 0.5,
            Carries::Importance => 1.0,
        }
    }
}

impl Turn {
    /// Samples the BSDF at a hit.
    pub(in super::super) fn sample(
        hit: &GeometryHit,
        bsdf: &Bsdf,
        carries: Carries,
        stream: &mut SampleStream,
    ) -> Option<Turn> {
        let wo = hit.surface.wo;
        let third = stream.next_1d_if(bsdf.needs_third());
        let sample = bsdf.sample(wo, third, stream.next_2d())?;
        let back = match carries {
            _ if sample.specular => (Rgb::ZERO, 1.0),
            Carries::Radiance => (Rgb::ZERO, bsdf.pdf(sample.wi, wo)),
            Carries::Importance => bsdf.f_and_pdf(sample.wi, wo),
        };
        Turn::of(sample, (normals(hit, bsdf), wo), carries, back)
    }

    /// Along a direction that was sampled for `wo`, on a surface with these normals; `back`: value and density of the opposite direction.
    fn of(
        sample: BsdfSample,
        (normals, wo): ((Vec3, Vec3), Vec3),
        carries: Carries,
        back: (Rgb, f32),
    ) -> Option<Turn> {
        let eta2 = sample.eta * sample.eta;
        let radiance = normals.1.dot(sample.wi).abs();
        let (factor, judged) = match carries {
            Carries::Radiance => {
                let factor = sample.f * (radiance / sample.pdf);
                (factor, factor * eta2)
            }
            Carries::Importance => {
                // Refraction scales radiance, not importance.
                let f = if sample.specular {
                    sample.f * eta2
                } else {
                    back.0
                };
                let cosine = match sample.specular {
                    // The cosine that a delta's value is divided by.
                    true => radiance * importance_correction(normals, wo, sample.wi),
                    false => importance_cosine(normals, wo, sample.wi),
                };
                let factor = f * (cosine / sample.pdf);
                (factor, factor)
            }
        };
        // A factor that is not finite is passed on, so that what comes of it is counted.
        let valid = !is_black(factor) && sample.wi.is_finite();
        valid.then_some(Turn {
            sample,
            factor,
            judged,
            reverse: back.1,
        })
    }
}

/// [`importance_cosine`] over the shading normal's cosine to `wi`.
fn importance_correction(normals: (Vec3, Vec3), wo: Vec3, wi: Vec3) -> f32 {
    let (n, shading) = normals;
    let (seen, from) = (n.dot(wo).abs(), shading.dot(wi).abs());
    if seen == 0.0 || from == 0.0 {
        return 0.0;
    }
    shading.dot(wo).abs() * n.dot(wi).abs() / (seen * from)
}

/// How a surface scatters that a subpath meets; `None` if it has no material.
pub(super) fn surface_bsdf<'a>(
    world: &'a World,
    hit: &GeometryHit,
    differentials: Option<&RayDifferentials>,
    carries: Carries,
    bsdf: &mut Bsdf<'a>,
) -> Option<()> {
    let material = world.material(hit.material)?;
    world.fill_bsdf(material, &hit.surface, differentials, bsdf);
    bsdf.even_out(carries.evenness());
    Some(())
}
