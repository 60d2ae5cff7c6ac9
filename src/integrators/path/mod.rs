//! `Integrator "path"`: unidirectional path tracing with next-event estimation, multiple
//! importance sampling (Veach 1997, §9.2) and Russian roulette.
//!
//! The expectation is pbrt-v3's (docs/scene-language.md §4.2). Where pbrt traces one ray for direct light
//! sampled by the BSDF and another to continue the path, one ray serves both here: the emission it
//! meets is weighted by the power heuristic against emitter sampling.
//!
//! Each vertex of a path takes four steps, one file each: emission, emitter sampling, BSDF sampling,
//! Russian roulette. `volpath` is the same with participating media, see [`volpath`](super::volpath). Many paths take them
//! side by side (`wave`).

mod bsdf_sampling;
mod emission;
mod emitter_batches;
mod emitter_sampling;
mod medium;
mod roulette;
mod wave;

pub use medium::MediaSeen;
pub(super) use wave::Wave;

use super::context::{Bundle, Context, WAVE};
use super::witness::Met;
use super::{BOTH_WAYS, MAX_NULL_SURFACES, Sight, Transport};
use crate::accel::GeometryHit;
use crate::bsdf::Bsdf;
use crate::handles::{LightId, MediumId};
use crate::lights::SelectionStrategy;
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::{Rgb, color::is_black};
use crate::params::ParamReader;
use crate::samplers::SampleStream;
use crate::world::World;
use arrayvec::ArrayVec;
use emission::MisState;
use wave::Walk;

/// Parameters of `Integrator "path"`.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// `maxdepth` (5): largest number of scattering events; 0 shows only emitters.
    pub max_depth: u32,
    /// `rrthreshold` (1): Russian roulette applies only where the throughput's largest channel is below a quarter of it, up to the
    /// fourth scattering event an eighth.
    pub rr_threshold: f32,
    /// `lightsamplestrategy` ("spatial"): noise only.
    pub light_strategy: SelectionStrategy,
    /// For pbrt-v2's `directlighting` and `whitted` through volumes: paths end after their first scattering that is not
    /// perfectly specular.
    pub direct_only: bool,
    /// Which light transport in media is simulated.
    pub media: MediaSeen,
}

impl Default for Path {
    fn default() -> Self {
        Path {
            max_depth: 5,
            rr_threshold: 1.0,
            light_strategy: SelectionStrategy::Spatial,
            direct_only: false,
            media: MediaSeen::All,
        }
    }
}

impl Path {
    /// Reads the parameters; v2 counts one scattering event more (docs/scene-language.md §A.3).
    pub fn from_params(reader: &ParamReader) -> Path {
        Path {
            rr_threshold: reader.float("rrthreshold", 1.0) as f32,
            ..Path::with_depth_and_strategy(reader)
        }
    }

    /// Reads the parameters that `bdpt` has, too.
    pub(super) fn with_depth_and_strategy(reader: &ParamReader) -> Path {
        let extra = u32::from(reader.means_v2("maxdepth"));
        Path {
            max_depth: super::max_depth(reader) + extra,
            light_strategy: SelectionStrategy::from_params(reader),
            ..Path::default()
        }
    }

    /// `directlighting` or `whitted` of this depth, but through pbrt-v2's volumes.
    pub(super) fn direct_only(max_depth: u32) -> Path {
        Path {
            max_depth,
            direct_only: true,
            ..Path::default()
        }
    }

    /// Radiance along the camera ray as `volpath` has it.
    pub(super) fn trace_through_media(&self, context: Context) -> Rgb {
        match context.watch {
            None => self.trace::<true, false>(context),
            Some(_) => self.trace::<true, true>(context),
        }
    }

    /// Radiance along each path of a bundle, side by side. `MEDIA`: as `volpath`, where no shadow ray draws samples.
    pub(super) fn radiances_in_waves<const MEDIA: bool>(
        &self,
        bundle: Bundle,
        out: &mut ArrayVec<Rgb, WAVE>,
    ) {
        let world = bundle.world;
        let wave = bundle.workspace.wave.take();
        let mut wave = wave.unwrap_or_else(|| Wave::new(world));
        let (path, watch) = (
            self,
            bundle.paths.first().and_then(|path| path.watch.as_deref()),
        );
        let (is_watched, follows) = (
            watch.is_some(),
            watch.is_some_and(|watch| watch.parts.is_some()),
        );
        let workspace = match is_watched {
            false => Walk::<MEDIA, false> {
                path,
                bundle,
                follows,
            }
            .radiances(&mut wave, out),
            true => Walk::<MEDIA, true> {
                path,
                bundle,
                follows,
            }
            .radiances(&mut wave, out),
        };
        workspace.wave = Some(wave);
    }

    /// Radiance along the camera ray. `MEDIA`: as `volpath`, which simulates participating media and lets light through surfaces
    /// without material; a constant, so that `path` pays nothing for it. Nor does either for being watched.
    fn trace<const MEDIA: bool, const WATCHED: bool>(&self, context: Context) -> Rgb {
        let medium = context.world.media.camera.filter(|_| MEDIA);
        let mut trail = Trail::new(*context.ray(), medium, self.max_depth, context.world);
        let mut state = PathState::<MEDIA, WATCHED> {
            path: self,
            reports: WATCHED && context.watch.as_ref().is_some_and(|watch| watch.reports()),
            differentials: context.differentials,
            trail: &mut trail,
            branches: ArrayVec::new(),
            waiting: 0,
            context,
        };
        loop {
            while state.extend().is_some() {}
            state.look_along(state.trail.ray);
            if state.turn_back().is_none() {
                return state.trail.radiance;
            }
        }
    }
}

impl Transport for Path {
    const INDIRECT: bool = true;
    const IN_WAVES: bool = true;

    fn radiance(&self, context: Context) -> Rgb {
        match context.watch {
            None => self.trace::<false, false>(context),
            Some(_) => self.trace::<false, true>(context),
        }
    }

    fn radiances(&self, bundle: Bundle, out: &mut ArrayVec<Rgb, WAVE>) {
        self.radiances_in_waves::<false>(bundle, out);
    }

    fn path(&self) -> Option<Path> {
        Some(self.clone())
    }
}

/// At most so many ways wait for others to end. Where there are no media, there are no more than [`BOTH_WAYS`].
const MAX_BRANCHES: usize = 4;

/// What a path has come to.
#[derive(Clone, Copy)]
struct Trail {
    /// To the next vertex.
    ray: Ray,
    mis: MisState,
    /// Around the ray.
    medium: Option<MediumId>,
    throughput: Rgb,
    /// Collected so far.
    radiance: Rgb,
    /// What Russian roulette multiplies the throughput by: n² for every perfectly specular refraction, either way. Where a path enters glass, that undoes the scaling of
    /// radiance; where it leaves, it spares what is seen through glass, lamps among it. Undoing the scaling alone took the same time
    /// in `glass` of benches/peer, and had 1.11 times the squared relative error.
    eta_scale: f32,
    /// Scattering events so far.
    depth: u32,
    max_depth: u32,
    /// What comes after the last scattering event may bring light: a light is met there, or a medium glows.
    looks_on: bool,
    /// All scattering so far was perfectly specular.
    specular_only: bool,
    /// Surfaces without material so far.
    null_surfaces: u32,
    /// Layers look along it, if they look: of the ways that a path takes, along one.
    is_seen: bool,
}

impl Trail {
    /// One that begins with this ray, in this medium of `world`.
    fn new(ray: Ray, medium: Option<MediumId>, max_depth: u32, world: &World) -> Trail {
        Trail {
            ray,
            mis: MisState::Delta,
            medium,
            throughput: Rgb::ONE,
            radiance: Rgb::ZERO,
            eta_scale: 1.0,
            depth: 0,
            max_depth,
            looks_on: world.has_visible_lights() || !world.media.is_empty(),
            specular_only: true,
            null_surfaces: 0,
            is_seen: true,
        }
    }

    /// Takes another way, with the light that was collected by this one.
    fn turn_to(&mut self, branch: Trail) {
        *self = Trail {
            radiance: self.radiance,
            ..branch
        };
    }
}

/// A way that a path takes when it has come to the end of others, and its numbers.
#[derive(Clone, Copy)]
struct Branch {
    trail: Trail,
    stream: SampleStream,
}

/// A path being traced. Its methods return `None` where it ends.
struct PathState<'a, const MEDIA: bool, const WATCHED: bool> {
    path: &'a Path,
    context: Context<'a>,
    /// Those of the camera ray, up to its hit.
    differentials: Option<&'a RayDifferentials>,
    /// Every step is reported.
    reports: bool,
    trail: &'a mut Trail,
    /// Ways that are left. The last one is taken first.
    branches: ArrayVec<Branch, MAX_BRANCHES>,
    /// So many ways are left besides, which a wave keeps.
    waiting: usize,
}

impl<const MEDIA: bool, const WATCHED: bool> PathState<'_, MEDIA, WATCHED> {
    /// Adds light that the path has met, which comes from this light.
    #[inline(always)]
    fn gain_from(&mut self, id: LightId, light: Rgb) {
        if WATCHED {
            self.context.part(Some(id), light);
        }
        self.gain(light);
    }

    /// Adds light whose parts are known.
    #[inline(always)]
    fn gain(&mut self, light: Rgb) {
        self.trail.radiance += light;
    }

    /// Extends the path by a vertex.
    #[inline(always)]
    fn extend(&mut self) -> Option<()> {
        let (world, wants_uv) = (self.context.world, self.wants_parameters());
        let hit = world.intersect_with(&self.trail.ray, wants_uv);
        self.arrive_at(hit.as_ref(), |path, hit, bsdf| path.scatter(hit, bsdf))
    }

    /// Returns `true` if there is room for one more way.
    #[inline(always)]
    fn may_branch(&self) -> bool {
        self.waiting + self.branches.len() < MAX_BRANCHES
    }

    /// Takes the last of the ways that are left, if there is one.
    fn turn_back(&mut self) -> Option<()> {
        let Branch { trail, stream } = self.branches.pop()?;
        self.trail.turn_to(trail);
        *self.context.stream = stream;
        // The way that has ended may have been the camera ray's.
        self.differentials = None;
        Some(())
    }

    /// Where the ray has led; at a surface that scatters, `scatter` continues.
    #[inline(always)]
    fn arrive_at(
        &mut self,
        hit: Option<&GeometryHit>,
        scatter: impl FnOnce(&mut Self, &GeometryHit, &Bsdf) -> Option<()>,
    ) -> Option<()> {
        let world = self.context.world;
        if MEDIA && let Some(id) = self.trail.medium {
            let t_max = hit.map_or(f32::INFINITY, |hit| hit.t);
            let vertex = self.cross_medium((id, t_max), hit);
            if is_black(self.trail.throughput) {
                self.look_beyond(hit);
                return None;
            }
            if let Some(vertex) = vertex {
                self.arrive(Met::Medium);
                self.look_beyond(hit);
                self.scatter_in_medium(&vertex)?;
                return self.russian_roulette();
            }
        }
        let Some(hit) = hit else {
            self.arrive(Met::Background);
            self.look(Sight::escape);
            self.add_escaped();
            return None;
        };
        self.arrive(Met::Surface(hit.material));

        // 1. Emission.
        self.add_emission(hit);
        let Some(material) = world.material(hit.material) else {
            return self.skip_null_surface(hit);
        };
        if self.trail.depth >= self.trail.max_depth {
            self.look_beyond(Some(hit));
            return None;
        }
        if let Some(boundary) = world.even_boundary(hit.material) {
            self.differentials = None;
            if self.takes_both_ways() && boundary.is_glass() {
                return self.cross_both_ways(hit, boundary);
            }
            self.cross(hit, boundary)?;
            return self.russian_roulette();
        }
        let mut bsdf = Bsdf::empty();
        world.fill_bsdf(material, &hit.surface, self.differentials, &mut bsdf);
        bsdf.prepare(hit.surface.wo);
        let ray = self.trail.ray;
        self.look(|sight| sight.meet(world, (&ray, hit), (&bsdf, material.has_interior())));
        scatter(self, hit, &bsdf)
    }

    /// Continues from a surface.
    #[inline(always)]
    fn scatter(&mut self, hit: &GeometryHit, bsdf: &Bsdf) -> Option<()> {
        // 2. Emitter sampling.
        self.sample_direct_at_surface(hit, bsdf);

        // 3. BSDF sampling.
        let differentials = self.differentials.take();
        let sample = self.sample_bsdf(hit, bsdf);
        self.look(|sight| sight.scatter(bsdf, sample.as_ref()));
        let sample = sample?;
        if sample.transmission {
            self.sample_transmission(hit, (bsdf, &sample), differentials)?;
        } else {
            self.continue_with(hit, bsdf, &sample)?;
        }

        // 4. Stopping.
        self.russian_roulette()
    }

    /// Russian roulette decides whether the path continues after a scattering event.
    #[inline(always)]
    fn russian_roulette(&mut self) -> Option<()> {
        let (threshold, stream) = (self.path.rr_threshold, &mut *self.context.stream);
        self.trail.russian_roulette(threshold, || stream.next_1d())
    }

    /// Looks at the path, for layers.
    #[inline(always)]
    fn look(&mut self, note: impl FnOnce(&mut Sight)) {
        if WATCHED && self.trail.is_seen {
            self.context.look(note);
        }
    }

    /// Returns `true` if layers look along the path's way.
    #[inline(always)]
    fn is_looking(&self) -> bool {
        WATCHED && self.trail.is_seen && self.context.is_looked_at()
    }

    /// Returns `true` if layers ask for (u, v) of what the path meets next.
    #[inline(always)]
    fn wants_parameters(&self) -> bool {
        WATCHED && self.trail.is_seen && self.context.wants_parameters()
    }

    /// Looks at what is behind the point where the path scatters in a medium, or ends, for layers, by the numbers that the path has then.
    fn look_beyond(&mut self, hit: Option<&GeometryHit>) {
        let (world, ray, differentials) = (self.context.world, self.trail.ray, self.differentials);
        if let Some((sight, numbers)) = self.sight() {
            sight.follow(world, (&ray, hit), differentials, numbers);
        }
    }

    /// Looks along a ray that the path does not take, for layers.
    #[inline(always)]
    fn look_along(&mut self, ray: Ray) {
        let world = self.context.world;
        if let Some((sight, numbers)) = self.sight() {
            sight.follow_ray(world, ray, numbers);
        }
    }

    /// What looks along the path's way, for layers, and the numbers that it may look on by.
    #[inline(always)]
    fn sight(&mut self) -> Option<(&mut Sight, &SampleStream)> {
        match WATCHED && self.trail.is_seen {
            true => self.context.sight(),
            false => None,
        }
    }

    /// Reports the vertex just reached, for the search for samples that are not finite.
    #[inline(always)]
    fn arrive(&mut self, met: Met) {
        if WATCHED && self.reports {
            self.context
                .arrive(self.trail.depth, met, self.trail.radiance);
        }
    }
}
