//! `Integrator "path"`: unidirectional path tracing with next-event estimation, multiple
//! importance sampling (Veach 1997, §9.2) and Russian roulette.
//!
//! The expectation is pbrt-v3's (docs/scene-language.md §4.2). Where pbrt traces one ray for direct light
//! sampled by the BSDF and another to continue the path, one ray serves both here: the emission it
//! meets is weighted by the power heuristic against the light's own sampling.
//!
//! `volpath` is the same walk with participating media, see [`volpath`](super::volpath).

use super::MAX_NULL_SURFACES;
use super::subsurface::find_exit;
use super::vertex::{MediumVertex, SurfaceVertex, Vertex, receiver};
use super::volpath::{dimmed, transmittance};
use super::witness::{Met, Place, Witness};
use crate::accel::GeometryHit;
use crate::bsdf::{Bsdf, BsdfSample};
use crate::handles::{LightId, MediumId};
use crate::lights::{LightSelector, SelectionStrategy};
use crate::materials::Material;
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::sampling::power_heuristic;
use crate::math::{Rgb, Vec2, color::is_black};
use crate::media::HenyeyGreenstein;
use crate::params::{Dialect, ParamReader};
use crate::samplers::SampleStream;
use crate::surface::ReferencePoint;
use crate::world::World;

/// The number of scattering events after which Russian roulette is played for all that a path is worth (pbrt-v3: bounce
/// counter > 3).
const ROULETTE_AFTER: u32 = 3;

/// Before, a path counts for so many times its worth: only those end that dark surfaces have left little of, as in foliage,
/// where their bounces cost two fifths of the time and bring no noise (docs/notes/performance.md).
const EARLY_WORTH: f32 = 4.0;

/// Only directions drawn with at most this density per steradian, three times a diffuse surface's largest: what light
/// sampling misses is often bright, and mirrors and glossy surfaces that take little light from it would show it seldom.
const BROAD: f32 = 1.0;

/// Parameters of `Integrator "path"`.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// `maxdepth` (5): largest number of scattering events; 0 shows only what emits.
    pub max_depth: u32,
    /// `rrthreshold` (1): roulette is played only where the throughput's largest channel is below; up to the fourth
    /// scattering event only below a quarter of it.
    pub rr_threshold: f32,
    /// `lightsamplestrategy` ("spatial"): noise only.
    pub light_strategy: SelectionStrategy,
    /// For `sppm`: mirrors and glass between the camera and the first other surface are counted
    /// apart, as many as `max_depth` − 1 of them, because its photons end at that surface.
    pub mirrors_apart: bool,
    /// For pbrt-v2's `directlighting` and `whitted` through volumes: paths end after the first scattering by other surfaces
    /// than mirrors and glass.
    pub direct_only: bool,
    /// What is seen of media.
    pub media: MediaSeen,
}

/// How much of what light does in media is followed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MediaSeen {
    /// All of it.
    #[default]
    All,
    /// pbrt-v2's `VolumeIntegrator "single"`: what the camera sees, directly or by mirrors and glass, of light that is
    /// emitted or is scattered once; beyond other surfaces media dim.
    Single,
    /// pbrt-v2's `VolumeIntegrator "emission"`: the same without scattering.
    Emission,
}

impl MediaSeen {
    /// Reads a `VolumeIntegrator`. `stepsize` (1): noise only here, where nothing marches.
    pub fn from_params(reader: &ParamReader) -> MediaSeen {
        reader.accept("stepsize");
        match reader.kind() {
            "single" => MediaSeen::Single,
            "emission" => MediaSeen::Emission,
            _ => {
                reader.unknown_kind(&["emission", "single"]);
                MediaSeen::Emission
            }
        }
    }
}

impl Default for Path {
    fn default() -> Self {
        Path {
            max_depth: 5,
            rr_threshold: 1.0,
            light_strategy: SelectionStrategy::Spatial,
            mirrors_apart: false,
            direct_only: false,
            media: MediaSeen::All,
        }
    }
}

/// How the path came to its present vertex: decides what emission met there counts for.
#[derive(Clone, Copy)]
enum MisState {
    /// From the camera or by a mirror: no light sampling competes.
    Delta,
    /// Scattered with this density at this point: weigh against light sampling, of every light there or of one.
    Sampled {
        from: ReferencePoint,
        pdf: f32,
        every: bool,
    },
    /// Scattered and then passed a surface without material, which blocks shadow rays:
    /// as in pbrt-v3 the light behind it is not seen (docs/scene-language.md §4.3).
    Blocked,
}

impl Path {
    /// Reads the parameters; v2 counts one scattering event more (docs/scene-language.md §A.3).
    pub fn from_params(reader: &ParamReader) -> Path {
        let extra = u32::from(reader.dialect() == Dialect::V2);
        Path {
            max_depth: super::max_depth(reader) + extra,
            rr_threshold: reader.float("rrthreshold", 1.0) as f32,
            light_strategy: match reader
                .one_of("lightsamplestrategy", &["spatial", "power", "uniform"])
            {
                "power" => SelectionStrategy::Power,
                "uniform" => SelectionStrategy::Uniform,
                _ => SelectionStrategy::Spatial,
            },
            ..Path::default()
        }
    }

    /// Radiance along a camera ray. `MEDIA`: as `volpath`, which sees participating media and lets
    /// light through surfaces without material; a constant, so that `path` pays nothing for it.
    pub fn radiance<const MEDIA: bool>(
        &self,
        world: &World,
        selector: &LightSelector,
        ray: Ray,
        differentials: Option<&RayDifferentials>,
        stream: &mut SampleStream,
        witness: &mut impl Witness,
    ) -> Rgb {
        let mut walk = Walk::<MEDIA> {
            path: self,
            world,
            selector,
            ray,
            differentials,
            mis: MisState::Delta,
            medium: if MEDIA { world.media.camera } else { None },
            throughput: Rgb::ONE,
            radiance: Rgb::ZERO,
            eta_scale: 1.0,
            depth: 0,
            max_depth: self.max_depth,
            apart: self.mirrors_apart,
            straight: true,
            nulls: 0,
        };
        while walk.step(stream, witness).is_some() {}
        walk.radiance
    }
}

/// A path under way. Methods answer `None` where it ends.
struct Walk<'a, const MEDIA: bool> {
    path: &'a Path,
    world: &'a World,
    selector: &'a LightSelector,
    /// To the next vertex.
    ray: Ray,
    /// Those of the camera ray.
    differentials: Option<&'a RayDifferentials>,
    mis: MisState,
    /// What the ray goes through.
    medium: Option<MediumId>,
    throughput: Rgb,
    /// Gathered so far.
    radiance: Rgb,
    /// Undoes the radiance scaling inside dielectrics when roulette judges a path's worth.
    eta_scale: f32,
    /// Scattering events so far.
    depth: u32,
    max_depth: u32,
    /// See [`Path::mirrors_apart`].
    apart: bool,
    /// Has the path met nothing but mirrors and glass so far?
    straight: bool,
    /// Surfaces without material so far.
    nulls: u32,
}

impl<const MEDIA: bool> Walk<'_, MEDIA> {
    /// Follows the ray, and scatters where it ends.
    #[inline(always)]
    fn step(&mut self, stream: &mut SampleStream, witness: &mut impl Witness) -> Option<()> {
        let depth = self.depth;
        let hit = self.world.intersect(&self.ray);
        if MEDIA && let Some(id) = self.medium {
            let t_max = hit.as_ref().map_or(f32::INFINITY, |hit| hit.t);
            if let Some((t, phase)) = self.fly(id, t_max, stream)? {
                let met = Met::Medium;
                witness.arrive(Place { depth, met }, self.radiance);
                self.scatter_in_medium((id, phase), t, stream)?;
                return self.survive(stream);
            }
        }
        let Some(hit) = &hit else {
            let met = Met::Background;
            witness.arrive(Place { depth, met }, self.radiance);
            let light = escaped(self.world, self.selector, &self.ray, &self.mis);
            self.radiance += self.throughput * light;
            return None;
        };
        let met = Met::Surface(hit.material);
        witness.arrive(Place { depth, met }, self.radiance);
        if let Some(light) = hit.light {
            let (world, selector) = (self.world, self.selector);
            let light = emitted(world, selector, &self.ray, (hit, light), &self.mis);
            self.radiance += self.throughput * light;
        }
        let Some(material) = self.world.material(hit.material) else {
            return self.pass(hit);
        };
        if depth >= self.max_depth {
            return None;
        }
        self.scatter(hit, material, stream)?;
        self.survive(stream)
    }

    /// Goes through a medium up to `t_max`: answers where and how it scatters, if it does.
    fn fly(
        &mut self,
        id: MediumId,
        t_max: f32,
        stream: &mut SampleStream,
    ) -> Option<Option<(f32, HenyeyGreenstein)>> {
        let medium = self.world.media.medium(id);
        let (emits, scatters) = match self.path.media {
            MediaSeen::All => (true, true),
            MediaSeen::Single => (self.straight, self.straight),
            MediaSeen::Emission => (self.straight, false),
        };
        if emits {
            self.radiance += self.throughput * medium.emission(&self.ray, t_max, stream);
        }
        let (weight, scattered) = if scatters {
            let (flight, phase) = medium.sample(&self.ray, t_max, self.throughput, stream);
            (flight.weight, flight.scattered.map(|t| (t, phase)))
        } else {
            (medium.transmittance(&self.ray, t_max, stream), None)
        };
        self.throughput *= weight;
        (!is_black(self.throughput)).then_some(scattered)
    }

    /// Scatters at the distance `t` in a medium.
    fn scatter_in_medium(
        &mut self,
        (id, phase): (MediumId, HenyeyGreenstein),
        t: f32,
        stream: &mut SampleStream,
    ) -> Option<()> {
        let vertex = MediumVertex::new(id, phase, &self.ray, t);
        if self.depth >= self.max_depth || !vertex.p.is_finite() {
            return None;
        }
        self.light(&vertex, stream);
        let (wi, pdf) = vertex.phase.sample(vertex.wo, stream.next_2d());
        let from = vertex.reference_point();
        self.ray = Ray::new(vertex.p, wi, from.time);
        let every = self.every_light().is_some();
        self.mis = MisState::Sampled { from, pdf, every };
        self.differentials = None;
        self.straight = false;
        if self.path.media == MediaSeen::Single {
            self.max_depth = self.depth + 1;
        }
        Some(())
    }

    /// Continues through a surface without material, which is not a scattering event.
    ///
    /// At the last depth only a scattered path of `volpath` does: it is the half of its last vertex's direct
    /// light that the scattered direction finds, and light sampling's half passes these surfaces too.
    /// A path from the camera or a mirror has found all that it may, and ends as in pbrt-v3.
    fn pass(&mut self, hit: &GeometryHit) -> Option<()> {
        let seeks_light = MEDIA && matches!(self.mis, MisState::Sampled { .. });
        self.nulls += 1;
        if self.nulls > MAX_NULL_SURFACES || (self.depth >= self.max_depth && !seeks_light) {
            return None;
        }
        if MEDIA {
            self.medium = self.world.medium_beyond(hit, self.ray.d, self.medium);
        } else if let MisState::Sampled { .. } = self.mis {
            self.mis = MisState::Blocked;
        }
        self.ray = hit.surface.spawn_ray(self.ray.d);
        self.differentials = None;
        Some(())
    }

    /// Scatters at a surface, and below it where it lets light wander there.
    #[inline(always)]
    fn scatter(
        &mut self,
        hit: &GeometryHit,
        material: &Material,
        stream: &mut SampleStream,
    ) -> Option<()> {
        let differentials = self.differentials.take();
        let mut bsdf = Bsdf::empty();
        self.world
            .fill_bsdf(material, &hit.surface, differentials, &mut bsdf);
        let sample = self.scatter_by(hit, &bsdf, stream)?;
        if sample.transmission {
            return self.enter(hit, (&bsdf, &sample), differentials, stream);
        }
        self.leave(hit, &bsdf, &sample)
    }

    /// Gathers direct light, and draws where the path goes on.
    #[inline(always)]
    fn scatter_by(
        &mut self,
        hit: &GeometryHit,
        bsdf: &Bsdf,
        stream: &mut SampleStream,
    ) -> Option<BsdfSample> {
        if bsdf.has_non_specular() {
            let medium = self.medium;
            self.light(&SurfaceVertex { hit, bsdf, medium }, stream);
        } else {
            stream.skip_1d();
            stream.skip_2d();
        }
        let lobe = stream.next_1d_if(bsdf.chooses());
        let sample = bsdf.sample(hit.surface.wo, lobe, stream.next_2d())?;
        let cosine = sample.wi.dot(bsdf.shading_normal()).abs();
        self.throughput *= sample.f * (cosine / sample.pdf);
        let goes_on = !is_black(self.throughput) && self.throughput.is_finite();
        goes_on.then_some(sample)
    }

    /// Goes where light goes that the surface has let in: straight on, or below the surface to another
    /// point of it and out again.
    #[inline(never)]
    fn enter(
        &mut self,
        hit: &GeometryHit,
        (bsdf, sample): (&Bsdf, &BsdfSample),
        differentials: Option<&RayDifferentials>,
        stream: &mut SampleStream,
    ) -> Option<()> {
        let surface = &hit.surface;
        if sample.specular {
            let entering = surface.wo.dot(surface.n) > 0.0;
            let eta2 = sample.eta * sample.eta;
            self.eta_scale *= if entering { eta2 } else { 1.0 / eta2 };
        }
        let (scattered, choice) = ((bsdf, sample), || stream.next_1d());
        let world = self.world;
        let subsurface =
            world.subsurface_transport(hit.material, surface, scattered, differentials, choice);
        self.throughput *= subsurface.share;
        let Some(bssrdf) = subsurface.bssrdf else {
            return self.leave(hit, bsdf, sample);
        };
        if !sample.specular {
            self.radiance += self.emission_along(hit, bsdf, sample, stream);
        }
        let exit = find_exit(world, &bssrdf, hit, stream)?;
        self.throughput *= exit.weight;
        let sample = self.scatter_by(&exit.hit, &exit.bsdf, stream)?;
        self.leave(&exit.hit, &exit.bsdf, &sample)
    }

    /// Light that the direction of `sample` meets, although the path continues elsewhere: what light
    /// sampling at a rough boundary is weighed against, as in pbrt-v3.
    fn emission_along(
        &self,
        hit: &GeometryHit,
        bsdf: &Bsdf,
        sample: &BsdfSample,
        stream: &mut SampleStream,
    ) -> Rgb {
        let (world, selector) = (self.world, self.selector);
        let mis = self.scattered(hit, bsdf, sample);
        let mut ray = hit.surface.spawn_ray(sample.wi);
        let mut medium = match MEDIA {
            true => world.medium_beyond(hit, sample.wi, self.medium),
            false => None,
        };
        let (mut light, mut throughput) = (Rgb::ZERO, self.throughput);
        for _ in 0..MAX_NULL_SURFACES {
            let next = world.intersect(&ray);
            let t_max = next.as_ref().map_or(f32::INFINITY, |next| next.t);
            throughput *= dimmed(world, medium, &ray, t_max, stream);
            let Some(next) = next else {
                return light + throughput * escaped(world, selector, &ray, &mis);
            };
            if let Some(id) = next.light {
                light += throughput * emitted(world, selector, &ray, (&next, id), &mis);
            }
            if !MEDIA || next.material.is_some() || is_black(throughput) {
                break;
            }
            medium = world.medium_beyond(&next, ray.d, medium);
            ray = next.surface.spawn_ray(ray.d);
        }
        light
    }

    /// Leaves a surface as `sample` says.
    #[inline(always)]
    fn leave(&mut self, hit: &GeometryHit, bsdf: &Bsdf, sample: &BsdfSample) -> Option<()> {
        self.apart &= sample.specular;
        self.straight &= sample.specular;
        if self.path.direct_only && !sample.specular {
            self.max_depth = self.max_depth.min(self.depth + 1);
        }
        if self.apart {
            if self.depth + 1 >= self.path.max_depth {
                return None;
            }
            self.max_depth += 1;
        }
        self.mis = if sample.specular {
            MisState::Delta
        } else {
            self.scattered(hit, bsdf, sample)
        };
        self.ray = hit.surface.spawn_ray(sample.wi);
        if MEDIA {
            self.medium = self.world.medium_beyond(hit, sample.wi, self.medium);
        }
        Some(())
    }

    /// Counts the scattering event. Russian roulette: ends paths that are worth little, and weighs the
    /// others up.
    #[inline(always)]
    fn survive(&mut self, stream: &mut SampleStream) -> Option<()> {
        let late = self.depth > ROULETTE_AFTER;
        self.depth += 1;
        let early = match self.mis {
            _ if late => 1.0,
            MisState::Sampled { pdf, .. } if pdf <= BROAD => EARLY_WORTH,
            _ => return Some(()),
        };
        let worth = early * (self.throughput * self.eta_scale).max_element();
        if worth >= self.path.rr_threshold {
            return Some(());
        }
        let stop = (1.0 - worth).max(0.05);
        self.throughput /= 1.0 - stop;
        (stream.next_1d() >= stop).then_some(())
    }

    /// How a ray sets off that the surface scatters as `sample` says.
    #[inline]
    fn scattered(&self, hit: &GeometryHit, bsdf: &Bsdf, sample: &BsdfSample) -> MisState {
        MisState::Sampled {
            from: receiver(&hit.surface, bsdf),
            pdf: sample.pdf,
            every: self.every_light().is_some(),
        }
    }

    /// How many lights there are, where light is sampled from each. What the camera sees is lit by every
    /// light where there are a few: shadows are most of its noise.
    #[inline]
    fn every_light(&self) -> Option<u32> {
        match self.depth {
            0 => self.selector.sample_all_count(),
            _ => None,
        }
    }

    /// Gathers direct light by sampling every light or one, weighted against meeting it by the scattered ray.
    #[inline(always)]
    fn light(&mut self, vertex: &impl Vertex, stream: &mut SampleStream) {
        let from = vertex.reference_point();
        if let Some(count) = self.every_light() {
            for id in 0..count {
                self.light_from((LightId(id), 1.0), vertex, &from, stream);
            }
            return;
        }
        let choice = stream.next_1d_if(self.selector.chooses());
        match self.selector.sample(&from, choice) {
            Some(chosen) => self.light_from(chosen, vertex, &from, stream),
            None => stream.skip_2d(),
        }
    }

    /// Gathers what a light sends that was chosen with a probability.
    #[inline(always)]
    fn light_from(
        &mut self,
        chosen: (LightId, f32),
        vertex: &impl Vertex,
        from: &ReferencePoint,
        stream: &mut SampleStream,
    ) {
        let u = stream.next_2d();
        if let Some(light) = self.sampled_light(chosen, vertex, from, u, stream) {
            self.radiance += self.throughput * light;
        }
    }

    /// What a light sends that was chosen with a probability; `None` for nothing.
    #[inline]
    fn sampled_light(
        &self,
        (id, probability): (LightId, f32),
        vertex: &impl Vertex,
        from: &ReferencePoint,
        u: Vec2,
        stream: &mut SampleStream,
    ) -> Option<Rgb> {
        let world = self.world;
        let light = world.light(id).sample(from, u)?;
        let (scattered, scattered_pdf) = vertex.scattered_and_pdf(light.wi);
        let mut contribution = scattered * light.radiance;
        if is_black(contribution) {
            return None;
        }
        if MEDIA {
            let medium = vertex.medium_toward(world, light.wi);
            contribution *= transmittance(world, &light.shadow, medium, stream);
            if is_black(contribution) {
                return None;
            }
        } else if world.occluded(&light.shadow) {
            return None;
        }
        let pdf = probability * light.pdf;
        let weight = if light.delta {
            1.0
        } else {
            power_heuristic(pdf, scattered_pdf)
        };
        Some(contribution * (weight / pdf))
    }
}

/// Emission of the surface hit, that of light `id`, weighted by how the path arrived.
fn emitted(
    world: &World,
    selector: &LightSelector,
    ray: &Ray,
    (hit, id): (&GeometryHit, LightId),
    mis: &MisState,
) -> Rgb {
    let light = world.light(id);
    let radiance = light.emitted(&hit.surface);
    if is_black(radiance) {
        return Rgb::ZERO;
    }
    match mis {
        MisState::Delta => radiance,
        MisState::Blocked => Rgb::ZERO,
        MisState::Sampled { from, pdf, every } => {
            let probability = chance(selector, from, id, *every);
            let light_pdf = probability * light.pdf(from, ray.d, Some(&hit.surface));
            // A light that is never chosen (an instanced emitter) glows but lights nothing, as in pbrt-v3.
            if light_pdf > 0.0 {
                radiance * power_heuristic(*pdf, light_pdf)
            } else {
                Rgb::ZERO
            }
        }
    }
}

/// With which probability light from `id` was sought at `from`, where `every` light was sampled or one was chosen.
fn chance(selector: &LightSelector, from: &ReferencePoint, id: LightId, every: bool) -> f32 {
    if !every {
        return selector.pmf(from, id);
    }
    let sampled = selector
        .sample_all_count()
        .is_some_and(|count| id.0 < count);
    f32::from(u8::from(sampled))
}

/// Light from beyond the scene, weighted by how the path arrived.
fn escaped(world: &World, selector: &LightSelector, ray: &Ray, mis: &MisState) -> Rgb {
    match mis {
        MisState::Delta => world.escaped_radiance(ray),
        MisState::Blocked => Rgb::ZERO,
        MisState::Sampled { from, pdf, every } => world
            .infinite_lights
            .iter()
            .map(|&id| {
                let (radiance, light_pdf) = world.light(id).escaped_and_pdf(from, ray.d);
                let probability = chance(selector, from, id, *every);
                radiance * power_heuristic(*pdf, probability * light_pdf)
            })
            .sum(),
    }
}
