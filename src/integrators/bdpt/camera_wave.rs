//! Many camera paths side by side, whose rays are traced together. Nothing that a path brings depends on the others, and all bits are those
//! of one path at a time.

use super::Bdpt;
use super::camera_path::{CameraPath, Trail};
use super::flats::Flats;
use super::joins::Gain;
use super::kept::{self, LightPath, LightPaths};
use super::light_path::LightVertex;
use super::light_wave::{PathStart, Visitor, trace_all};
use super::splat::{self, Waiting};
use super::walk::Met;
use crate::accel::ClosestHit;
use crate::cameras::Camera;
use crate::handles::LightId;
use crate::integrators::Splat;
use crate::integrators::context::{Bundle, WAVE};
use crate::integrators::shadows::Shadows;
use crate::integrators::witness::Watch;
use crate::math::Rgb;
use crate::math::ray::Ray;
use crate::samplers::SampleStream;
use crate::world::World;
use arrayvec::ArrayVec;
use std::iter::repeat_n;

/// Memory that the waves of a thread use in turn: too large to be initialized for each.
#[derive(Default)]
pub(in crate::integrators) struct WaveBuffers {
    /// By path; perhaps more than there are paths.
    trails: ArrayVec<Trail, WAVE>,
    /// The paths that continue.
    walking: ArrayVec<u32, WAVE>,
    shadows: Shadows<Gain>,
    pub(super) flats: Flats,
}

/// Paths on their way.
struct Wave<'a, 'p> {
    bdpt: &'a Bdpt,
    bundle: Bundle<'a, 'p>,
    buffers: Box<WaveBuffers>,
    /// `true` if shadow rays wait for others.
    waits: bool,
}

/// The radiance along each path of the bundle.
pub(super) fn radiances(bdpt: &Bdpt, bundle: Bundle, out: &mut ArrayVec<Rgb, WAVE>) {
    let mut wave = Wave {
        bdpt,
        buffers: bundle.workspace.buffers.take().unwrap_or_default(),
        waits: shadows_may_wait(bundle.world),
        bundle,
    };
    let light_paths = wave.begin();
    let mut is_first = true;
    while !wave.buffers.walking.is_empty() {
        wave.extend(&light_paths, is_first);
        is_first = false;
    }
    let brought = |trail: &Trail| trail.radiance + trail.joined;
    let trails = wave.buffers.trails.iter().take(wave.bundle.paths.len());
    out.extend(trails.map(brought));
    let Wave {
        bundle, buffers, ..
    } = wave;
    light_paths.give_back(&mut bundle.workspace.vertices);
    bundle.workspace.buffers = Some(buffers);
}

/// Keeps the vertices of light paths.
struct Keep<'k, 'a> {
    bdpt: &'k Bdpt,
    light_paths: &'k mut LightPaths<'a>,
    /// If the paths are of the light pass, which takes numbers for the lens.
    camera: Option<&'k Camera>,
}

impl<'a> Visitor<'a> for Keep<'_, 'a> {
    fn visit(
        &mut self,
        start: &PathStart,
        light: LightId,
        vertex: LightVertex<'_, 'a>,
        stream: &mut SampleStream,
    ) {
        if self.bdpt.joins_vertex(&vertex) {
            self.light_paths.push(start.place as usize, light, &vertex);
        }
        if let Some(camera) = self.camera {
            splat::skip_lens(camera, stream);
        }
    }
}

/// Keeps them, and joins them to the lens as well.
struct KeepAndJoin<'k, 'c, 'a, S> {
    keep: Keep<'k, 'a>,
    lens: &'k mut Waiting<'c, 'a, S>,
}

impl<'a, S: FnMut(Splat)> Visitor<'a> for KeepAndJoin<'_, '_, 'a, S> {
    fn visit(
        &mut self,
        start: &PathStart,
        light: LightId,
        vertex: LightVertex<'_, 'a>,
        stream: &mut SampleStream,
    ) {
        self.keep.visit(start, light, vertex, stream);
        self.lens.visit(start, light, vertex, stream);
    }
}

impl<'a> Wave<'a, '_> {
    /// Begins all paths, and traces light paths for those that are joined to one.
    fn begin(&mut self) -> LightPaths<'a> {
        let mut joined = ArrayVec::<u32, WAVE>::new();
        self.buffers.walking.clear();
        for path in 0..self.bundle.paths.len().min(WAVE) {
            let context = self.bundle.context(path);
            let trails = &mut self.buffers.trails;
            if trails.len() == path {
                trails.push(Trail::default());
            }
            trails[path].begin(&context);
            self.buffers.walking.push(path as u32);
            if self.bdpt.joins(context.stream) {
                joined.push(path as u32);
            }
        }
        self.trace_light_paths(&joined)
    }

    fn trace_light_paths(&mut self, joined: &[u32]) -> LightPaths<'a> {
        let bdpt = self.bdpt;
        let Bundle {
            world,
            lights,
            paths,
            workspace,
            light_job,
        } = &mut self.bundle;
        let world = *world;
        let paired = { paths.first() }.and_then(|path| Some((path.end.paired?, path.end.camera)));
        let tracer = bdpt.joinable(world, lights, paired.is_some());
        // For as many as may ever be joined at once: chance decides, and no later wave is to allocate more.
        let most = if self.bdpt.connections > 0.0 { WAVE } else { 0 };
        let room = (most, tracer.max_depth);
        let mut light_paths = LightPaths::in_spare(&mut workspace.vertices, room);
        if joined.is_empty() {
            return light_paths;
        }
        let begin = |&path: &u32| {
            let of_camera = &mut paths[path as usize];
            kept::start((world, &of_camera.end), of_camera.stream, path)
        };
        let starts = joined.iter().map(begin);
        let flats = &mut self.buffers.flats;
        let mut keep = Keep {
            bdpt,
            light_paths: &mut light_paths,
            camera: None,
        };
        match (paired, light_job, &mut workspace.splats) {
            (Some(_), Some(job), Some(buffer)) => {
                let splat = &mut |splat: Splat| splat.add_to(buffer, world);
                let lens = &mut Waiting::new(&tracer, job, splat);
                trace_all(&tracer, starts, flats, &mut KeepAndJoin { keep, lens });
                lens.land();
            }
            _ => {
                keep.camera = paired.map(|(_, camera)| camera);
                trace_all(&tracer, starts, flats, &mut keep);
            }
        }
        light_paths
    }

    /// Extends all paths by a vertex.
    fn extend(&mut self, light_paths: &LightPaths<'a>, is_first: bool) {
        let world = self.bundle.world;
        let mut found = ArrayVec::<Option<ClosestHit>, WAVE>::new();
        found.extend(repeat_n(None, self.buffers.walking.len()));
        self.closest(&mut found);
        self.buffers.flats.clear();
        for (path, found) in std::mem::take(&mut self.buffers.walking)
            .into_iter()
            .zip(found)
        {
            let t = found.as_ref().map(ClosestHit::t);
            let walk = &self.buffers.trails[path as usize].walk;
            // `advance` reports throughput that is not finite.
            let met = match walk.medium.is_none() && walk.throughput.is_finite() {
                true => Some(Met::at_end(t)),
                false => self.with(path, light_paths, |state| state.advance(t)),
            };
            let Some(met) = &met else {
                self.go_on(path, None);
                continue;
            };
            let is_at_surface = matches!(met, Met::Surface);
            let flat = found.as_ref().filter(|_| is_at_surface);
            if flat.is_some_and(|found| self.is_flat(path, found)) {
                continue;
            }
            let extended = self.with(path, light_paths, |state| {
                state.differentials = state.context.differentials.filter(|_| is_first);
                let is_asked = is_at_surface || state.context.is_looked_at();
                let wants_uv = state.context.wants_parameters();
                let ray = &state.trail.walk.ray;
                let hit = found.filter(|_| is_asked);
                let hit = hit.and_then(|found| world.surface_with(ray, &found, wants_uv));
                state.arrive_at(met, hit.as_ref())
            });
            self.go_on(path, extended);
        }
        self.extend_from_flats(light_paths);
        self.trace_shadows();
    }

    /// Takes up what a path's ray has found if it is of a flat matte triangle, from which paths continue side by side. Not where layers look at
    /// the path.
    fn is_flat(&mut self, path: u32, found: &ClosestHit) -> bool {
        let world = self.bundle.world;
        let walk = &self.buffers.trails[path as usize].walk;
        let watch = self.bundle.paths[path as usize].watch.as_deref();
        let is_looked_at = watch.is_some_and(Watch::is_looking);
        // At the end of its depth a path is as well off by itself: it brings nothing.
        let may_be = walk.depth < self.bdpt.max_depth && !is_looked_at;
        may_be
            && self
                .buffers
                .flats
                .add(world, (path, walk), found, walk.throughput)
    }

    /// Extends the paths that have come to flat triangles.
    fn extend_from_flats(&mut self, light_paths: &LightPaths<'a>) {
        self.buffers.flats.resolve(self.bundle.world);
        for i in 0..self.buffers.flats.count() {
            let (path, vertex) = (self.buffers.flats.path(i), self.buffers.flats.vertex(i));
            let met = self.with(path as u32, light_paths, |state| state.meet_flat(&vertex));
            let stream = &mut *self.bundle.paths[path].stream;
            self.buffers.flats.set_next(met.map(|history| {
                // Reflection needs no third sample.
                stream.skip_1d();
                (history, stream.next_2d())
            }));
        }
        self.buffers.flats.sample();
        for i in 0..self.buffers.flats.count() {
            let path = self.buffers.flats.path(i) as u32;
            let known = (
                self.buffers.flats.history(i).copied(),
                self.buffers.flats.next(i),
            );
            let (Some(history), Some((next, weight))) = known else {
                self.go_on(path, None);
                continue;
            };
            let vertex = self.buffers.flats.vertex(i);
            let left = self.with(path, light_paths, |state| {
                state.leave_flat(&vertex, (&next, weight), &history)
            });
            self.go_on(path, left);
        }
    }

    /// Keeps a path that was `extended`, or that has another way to take.
    fn go_on(&mut self, path: u32, extended: Option<()>) {
        let trail = &mut self.buffers.trails[path as usize];
        let stream = &mut *self.bundle.paths[path as usize].stream;
        if extended.or_else(|| trail.turn_back(stream)).is_some() {
            self.buffers.walking.push(path);
        }
    }

    /// Does something with a path.
    #[inline(always)]
    fn with<R>(
        &mut self,
        path: u32,
        light_paths: &LightPaths<'a>,
        act: impl FnOnce(&mut CameraPath) -> R,
    ) -> R {
        let light_path = light_paths.path(path as usize);
        let waits = self.waits && self.make_room(CameraPath::max_shadow_rays(light_path));
        let mut context = self.bundle.context(path as usize);
        act(&mut CameraPath {
            bdpt: self.bdpt,
            differentials: None,
            context: &mut context,
            trail: &mut self.buffers.trails[path as usize],
            light_path,
            waiting: waits.then_some((&mut self.buffers.shadows, path)),
        })
    }

    /// What the paths hit.
    fn closest(&self, found: &mut [Option<ClosestHit>]) {
        let ray = |&path: &u32| self.buffers.trails[path as usize].walk.ray;
        let rays: ArrayVec<Ray, WAVE> = self.buffers.walking.iter().map(ray).collect();
        self.bundle.world.closest(&rays, found);
    }

    /// Returns `true` if there is room for so many shadow rays, now at least.
    fn make_room(&mut self, count: usize) -> bool {
        if self.buffers.shadows.room() < count {
            self.trace_shadows();
        }
        self.buffers.shadows.room() >= count
    }

    /// Adds the light that nothing blocks.
    fn trace_shadows(&mut self) {
        let Wave {
            bdpt,
            bundle,
            buffers,
            ..
        } = self;
        let WaveBuffers {
            trails, shadows, ..
        } = &mut **buffers;
        shadows.trace_through(bundle.world, |shadow, gain, passage| {
            let mut context = bundle.context(gain.path as usize);
            let mut state = CameraPath {
                bdpt,
                differentials: None,
                context: &mut context,
                trail: &mut trails[gain.path as usize],
                light_path: LightPath::default(),
                waiting: None,
            };
            state.gain_unblocked(shadow, &gain, passage);
        });
    }
}

/// Returns `true` if shadow rays may be traced after the rest of their path's step: no path has two vertices in one step, and no samples are drawn
/// for transmittance.
fn shadows_may_wait(world: &World) -> bool {
    !world.has_interiors() && !world.media.are_estimated()
}
