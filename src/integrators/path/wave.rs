//! Many paths side by side: a wave of them takes each step together.
//!
//! The commonest vertices, on matte and on coated surfaces, are kept as rows of numbers, and the functions that serve a single one are run in loops over
//! them that have no branches and are compiled to vector instructions ([`crate::math::instruction_set`]). A path that meets something else
//! takes that step alone, as in [`super::PathState::extend`]. Nothing that a path brings depends on the others, and all bits are those of
//! one path at a time (Lee, Green, Xie and Tabellion, "Vectorized Production Path Tracing", HPG 2017, has this arrangement for all
//! materials of a film).

mod emitters;

use super::emission::{MisState, Sampled};
use super::emitter_batches::{EmitterBatches, Gain};
use super::{Branch, MAX_BRANCHES, Path, PathState, Trail};
use crate::accel::{BareHits, BareTriangle, ClosestHit, FlatHits, GeometryHit, SmoothHits};
use crate::bsdf::{Coated, Matte, Scatterer};
use crate::handles::InterfaceId;
use crate::integrators::Sight;
use crate::integrators::context::{Bundle, CameraPath, WAVE, Workspace};
use crate::integrators::shadows::Shadows;
use crate::integrators::vertices::Vertices;
use crate::math::frame::Frame;
use crate::math::ray::Ray;
use crate::math::{Rgb, Vec2};
use crate::samplers::Pairs;
use crate::world::World;
use arrayvec::ArrayVec;

/// What the waves of a thread use one after the other.
pub(in super::super) struct Wave {
    paths: Paths,
    /// The rays of those that go on, and what these hit.
    rays: ArrayVec<Ray, WAVE>,
    found: [Option<ClosestHit>; WAVE],
    /// What is neither a flat matte nor a smooth coated triangle.
    others: ArrayVec<(u32, Option<ClosestHit>), WAVE>,
    flats: FlatHits<WAVE>,
    smooth: SmoothHits<WAVE>,
    /// For layers: how many paths have not met all that these tell of, and whether they ask for (u, v).
    looking: usize,
    wants_uv: bool,
    mattes: Box<Lot<Matte>>,
    coated: Box<Lot<Coated>>,
}

/// What vertices of all kinds share.
struct Paths {
    /// By path.
    trails: Vec<Trail>,
    /// The ways that are left to paths.
    branches: ArrayVec<(u32, Branch), { MAX_BRANCHES * WAVE }>,
    /// How many of them there are, by path.
    waiting: [u8; WAVE],
    /// The paths that go on.
    walking: ArrayVec<u32, WAVE>,
    shadows: Shadows<Gain>,
    /// 2-D samples of many paths at a time.
    pairs: Box<Pairs<WAVE>>,
}

/// The vertices of a kind.
struct Lot<S: Scatterer> {
    vertices: Vertices<S, WAVE>,
    batches: EmitterBatches<S>,
}

impl<S: Scatterer> Lot<S> {
    /// Never inlined: it is made on the stack, twice over until it is in its box.
    #[inline(never)]
    fn new(world: &World) -> Box<Lot<S>> {
        Box::new(Lot {
            vertices: Vertices::default(),
            batches: EmitterBatches::new(world),
        })
    }
}

impl Wave {
    /// Never inlined: no caller's stack is to hold it as well.
    #[inline(never)]
    pub(in super::super) fn new(world: &World) -> Box<Wave> {
        Box::new(Wave {
            paths: Paths {
                trails: Vec::with_capacity(WAVE),
                branches: ArrayVec::new(),
                waiting: [0; WAVE],
                walking: ArrayVec::new(),
                shadows: Shadows::default(),
                pairs: Box::default(),
            },
            rays: ArrayVec::new(),
            found: [None; WAVE],
            others: ArrayVec::new(),
            flats: FlatHits::default(),
            smooth: SmoothHits::default(),
            looking: 0,
            wants_uv: false,
            mattes: Lot::new(world),
            coated: Lot::new(world),
        })
    }
}

/// A wave's work. `MEDIA`: as `volpath`. `WATCHED`: layers look at the paths.
pub(super) struct Walk<'a, 'p, const MEDIA: bool, const WATCHED: bool> {
    pub path: &'a Path,
    pub bundle: Bundle<'a, 'p>,
    /// Layers of light follow what the paths bring.
    pub follows: bool,
}

impl<'a, 'p, const MEDIA: bool, const WATCHED: bool> Walk<'a, 'p, MEDIA, WATCHED> {
    /// The radiance along each path. Returns what else the bundle has lent.
    pub(super) fn radiances(
        mut self,
        wave: &mut Wave,
        out: &mut ArrayVec<Rgb, WAVE>,
    ) -> &'a mut Workspace {
        let (max_depth, world) = (self.path.max_depth, self.bundle.world);
        let medium = world.media.camera.filter(|_| MEDIA);
        let begin = |path: &CameraPath| Trail::new(path.end.ray.ray, medium, max_depth, world);
        wave.paths.trails.clear();
        wave.paths
            .trails
            .extend(self.bundle.paths.iter().take(WAVE).map(begin));
        wave.paths.walking.clear();
        wave.paths.walking.extend(0..wave.paths.trails.len() as u32);
        self.begin_to_look(wave);
        self.walk(wave, true);
        out.extend(wave.paths.trails.iter().map(|trail| trail.radiance));
        self.bundle.workspace
    }

    /// Extends all paths to their ends.
    fn walk(&mut self, wave: &mut Wave, mut is_first: bool) {
        while !wave.paths.walking.is_empty() {
            if WATCHED && !self.follows && wave.looking == 0 {
                // All has been seen.
                return self.unwatched().walk(wave, is_first);
            }
            self.extend(wave, is_first);
            is_first = false;
            if wave.paths.walking.is_empty() {
                wave.paths.turn_back(self.bundle.paths);
            }
        }
    }

    /// The same work, but nobody looks.
    fn unwatched(&mut self) -> Walk<'_, 'p, MEDIA, false> {
        let Bundle {
            world,
            lights,
            paths,
            workspace,
            light_job,
        } = &mut self.bundle;
        Walk {
            path: self.path,
            bundle: Bundle {
                world,
                lights,
                paths,
                workspace,
                light_job: *light_job,
            },
            follows: false,
        }
    }

    /// Extends all paths by a vertex.
    fn extend(&mut self, wave: &mut Wave, is_first: bool) {
        self.intersect(wave);
        self.resolve_flats(wave);
        self.resolve_smooth(wave);
        for i in 0..wave.others.len() {
            let (path, found) = wave.others[i];
            self.extend_alone(wave, path, found, is_first);
        }
        wave.coated.vertices.finish();
        let Wave {
            paths,
            mattes,
            coated,
            ..
        } = wave;
        self.sample_lights(mattes, paths);
        self.sample_lights(coated, paths);
        self.trace_shadows(paths);
        self.sample_directions(&mut mattes.vertices, paths);
        self.sample_directions(&mut coated.vertices, paths);
        if WATCHED && wave.looking > 0 {
            wave.looking -= self.look_at_weights(&wave.coated.vertices);
        }
    }

    /// Finds what the paths hit, and sorts it.
    fn intersect(&mut self, wave: &mut Wave) {
        let world = self.bundle.world;
        wave.rays.clear();
        let trails = &wave.paths.trails;
        let ray = |&path: &u32| trails[path as usize].ray;
        wave.rays.extend(wave.paths.walking.iter().map(ray));
        world.closest(&wave.rays, &mut wave.found[..wave.rays.len()]);
        wave.mattes.vertices.clear();
        wave.coated.vertices.clear();
        wave.others.clear();
        for i in 0..wave.paths.walking.len() {
            let (path, found) = (wave.paths.walking[i], wave.found[i].take());
            if !wave.add_triangle::<MEDIA, WATCHED>(world, path, found.as_ref()) {
                wave.others.push((path, found));
            }
        }
        wave.paths.walking.clear();
    }

    /// Finds where on flat triangles the hits are.
    fn resolve_flats(&mut self, wave: &mut Wave) {
        let count = wave.mattes.vertices.count();
        let wants_uv = WATCHED && wave.looking > 0 && wave.wants_uv;
        wave.flats.resolve(count, wants_uv);
        wave.mattes.vertices.place(&wave.flats);
        for i in 0..count {
            if let Some(found) = wave.flats.grazing(i) {
                let ray = &wave.paths.trails[wave.mattes.vertices.path(i)].ray;
                if let Some(hit) = self.bundle.world.surface(ray, &found) {
                    wave.mattes.vertices.place_alone(i, &hit.surface);
                }
            }
        }
        if WATCHED && wave.looking > 0 {
            let vertices = &wave.mattes.vertices;
            let known = (vertices, &wave.paths.trails[..]);
            let reflectance = |i| Some(vertices.reflectance(i));
            wave.looking -= self.look_at(&wave.flats.bare, known, wave.wants_uv, reflectance);
        }
    }

    /// Finds where on smooth triangles the hits are.
    fn resolve_smooth(&mut self, wave: &mut Wave) {
        wave.smooth.resolve(wave.coated.vertices.count());
        wave.coated.vertices.place_smooth(&wave.smooth);
        if WATCHED && wave.looking > 0 {
            let known = (&wave.coated.vertices, &wave.paths.trails[..]);
            wave.looking -= self.look_at(&wave.smooth.bare, known, wave.wants_uv, |_| None);
        }
    }

    /// Looks at triangles, for layers: at all `vertices` that there are. Returns of how many paths all is known then.
    // By itself, so that profiles tell it from the rest of a step.
    #[inline(never)]
    fn look_at<S: Scatterer>(
        &mut self,
        bare: &BareHits<WAVE>,
        (vertices, trails): (&Vertices<S, WAVE>, &[Trail]),
        wants_uv: bool,
        reflectance: impl Fn(usize) -> Option<Rgb>,
    ) -> usize {
        let mut seen = 0;
        // No more than a wave has, as the compiler does not know of every list: so fewer indices are checked.
        for i in 0..vertices.count().min(WAVE) {
            let path = vertices.path(i);
            let looks = |sight: &&mut Sight| trails[path].is_seen && sight.is_looking();
            let Some(sight) = sight(&mut self.bundle.paths[path]).filter(looks) else {
                continue;
            };
            let uv = match bare.parameters(i) {
                Some(uv) => uv,
                None if wants_uv => {
                    parameters_of_mesh(self.bundle.world, &trails[path].ray, bare.found(i))
                }
                None => Vec2::ZERO,
            };
            let point = (vertices.p(i), vertices.turned_normal(i), uv);
            sight.meet_bare(bare.noted(i), point, reflectance(i));
            seen += usize::from(sight.is_done());
        }
        seen
    }

    /// Looks at what sampled directions pass on, for layers. Returns of how many paths all is known then.
    fn look_at_weights<S: Scatterer>(&mut self, vertices: &Vertices<S, WAVE>) -> usize {
        let mut seen = 0;
        for i in 0..vertices.count() {
            let sight = sight(&mut self.bundle.paths[vertices.path(i)]);
            if let Some(sight) = sight.filter(|sight| !sight.is_done()) {
                sight.pass_on(vertices.weight(i));
                seen += usize::from(sight.is_done());
            }
        }
        seen
    }

    /// Has layers look at all paths, if they look at the first.
    fn begin_to_look(&self, wave: &mut Wave) {
        let paths = &*self.bundle.paths;
        let watch = paths.first().and_then(|path| path.watch.as_deref());
        let sight = watch.map(|watch| &watch.sight);
        let sight = sight.filter(|sight| WATCHED && sight.is_on());
        wave.looking = sight.map_or(0, |_| paths.len());
        wave.wants_uv = sight.is_some_and(|sight| sight.wants_uv);
    }

    /// A step that a path takes alone, unless it finds that the surface is of a kind of which vertices are kept.
    fn extend_alone(
        &mut self,
        wave: &mut Wave,
        path: u32,
        found: Option<ClosestHit>,
        is_first: bool,
    ) {
        let Wave {
            paths,
            mattes,
            coated,
            looking,
            ..
        } = wave;
        let (mattes, coated) = (&mut mattes.vertices, &mut coated.vertices);
        let (trail, waiting) = (
            &mut paths.trails[path as usize],
            paths.waiting[path as usize],
        );
        let mut state = self.state(path, (trail, waiting), is_first);
        let world = state.context.world;
        let (is_looking, wants_uv) = (state.is_looking(), state.wants_parameters());
        let ray = &state.trail.ray;
        let hit = found.and_then(|found| world.surface_with(ray, &found, wants_uv));
        if let Some(hit) = &hit
            && !(MEDIA && is_in_media(state.trail, hit.interface))
            && state.trail.depth < state.trail.max_depth
            && add_coated(coated, world, (path, state.trail.throughput), hit)
        {
            let ray = state.trail.ray;
            state.look(|sight| sight.meet_coated(world, &ray, hit));
            return;
        }
        let goes_on = state.arrive_at(hit.as_ref(), |state, hit, bsdf| {
            if MEDIA && is_in_media(state.trail, hit.interface) {
                return state.scatter(hit, bsdf);
            }
            let throughput = state.trail.throughput;
            if let Some(matte) = bsdf.matte(hit.surface.wo) {
                mattes.add(path, &hit.surface, (&matte, bsdf.frame()), throughput);
                return None;
            }
            if let Some(lobes) = bsdf.coated() {
                coated.begin(path, &hit.surface, (&lobes, bsdf.frame()), throughput);
                return None;
            }
            state.scatter(hit, bsdf)
        });
        if goes_on.is_none() {
            state.look_along(state.trail.ray);
        }
        if is_looking && state.context.has_seen() {
            *looking -= 1;
        }
        paths.waiting[path as usize] += state.branches.len() as u8;
        // Not moved, mostly empty as they are, out of the path's memory.
        let branches = state.branches.iter().map(|branch| (path, *branch));
        paths.branches.extend(branches);
        if goes_on.is_some() {
            paths.walking.push(path);
        }
    }

    /// BSDF sampling at all vertices of a kind, and Russian roulette.
    fn sample_directions<S: Scatterer>(
        &mut self,
        vertices: &mut Vertices<S, WAVE>,
        paths: &mut Paths,
    ) {
        // Reflection has no use for a third number.
        self.draw(vertices, paths, |_| Some(true));
        vertices.sample();
        for i in 0..vertices.count() {
            let path = vertices.path(i);
            let trail = &mut paths.trails[path];
            let Some(next) = vertices.next(i) else {
                continue;
            };
            trail.specular_only = false;
            if self.path.direct_only {
                trail.max_depth = trail.max_depth.min(trail.depth + 1);
            }
            trail.throughput = next.throughput;
            let time = trail.ray.time;
            trail.mis = MisState::Sampled(Sampled {
                from: vertices.from(i, time),
                pdf: next.pdf,
                is_first: trail.is_first(),
            });
            trail.ray = Ray::new(next.o, next.d, time);
            let stream = &mut *self.bundle.paths[path].stream;
            let goes_on = trail.russian_roulette(self.path.rr_threshold, || stream.next_1d());
            if goes_on.is_some() {
                paths.walking.push(path as u32);
            }
        }
    }

    /// Draws a 2-D sample for each vertex of a kind that `wants` one: `Some(true)` skips one dimension first.
    #[inline(always)]
    fn draw<S: Scatterer>(
        &mut self,
        vertices: &mut Vertices<S, WAVE>,
        Paths { trails, pairs, .. }: &mut Paths,
        wants: impl Fn(&Trail) -> Option<bool>,
    ) {
        pairs.clear();
        for i in 0..vertices.count() {
            let path = vertices.path(i);
            let Some(skips) = wants(&trails[path]) else {
                continue;
            };
            let stream = &mut *self.bundle.paths[path].stream;
            if skips {
                stream.skip_1d();
            }
            if let Some(known) = pairs.ask(stream, i) {
                vertices.set_number(i, known);
            }
        }
        pairs.compute();
        for asked in 0..pairs.asked() {
            let i = pairs.whose(asked);
            let stream = &mut *self.bundle.paths[vertices.path(i)].stream;
            vertices.set_number(i, pairs.answer(asked, stream));
        }
    }

    /// A path by itself.
    #[inline(always)]
    fn state<'s>(
        &'s mut self,
        path: u32,
        (trail, waiting): (&'s mut Trail, u8),
        is_first: bool,
    ) -> PathState<'s, MEDIA, WATCHED> {
        let context = self.bundle.context(path as usize);
        PathState {
            path: self.path,
            differentials: context.differentials.filter(|_| is_first),
            reports: false,
            trail,
            branches: ArrayVec::new(),
            waiting: waiting.into(),
            context,
        }
    }
}

impl Paths {
    /// Where all have ended, those to which ways are left take the last of them, as a path alone would.
    fn turn_back(&mut self, paths: &mut [CameraPath]) {
        let mut last = [0; WAVE];
        for (place, &(path, _)) in self.branches.iter().enumerate() {
            last[path as usize] = place;
        }
        let mut place = 0;
        self.branches.retain(|(path, branch)| {
            let index = *path as usize;
            let is_last = last[index] == place;
            if is_last {
                self.trails[index].turn_to(branch.trail);
                *paths[index].stream = branch.stream;
                self.waiting[index] -= 1;
                self.walking.push(*path);
            }
            place += 1;
            !is_last
        });
    }
}

impl Wave {
    /// Takes up a hit if it is of a flat triangle that is matte everywhere, or of a smooth one that is [coated](Coated) alike everywhere,
    /// and emits nothing.
    #[inline(always)]
    fn add_triangle<const MEDIA: bool, const WATCHED: bool>(
        &mut self,
        world: &World,
        path: u32,
        found: Option<&ClosestHit>,
    ) -> bool {
        let Some(found) = found else {
            return false;
        };
        let Some(triangle) = world.geometry.bare_triangle(found) else {
            return false;
        };
        let trail = &self.paths.trails[path as usize];
        if MEDIA && is_in_media(trail, triangle.attributes().interface) {
            return false;
        }
        if WATCHED && self.looking > 0 && trail.depth >= trail.max_depth {
            // Layers may want to know more of it.
            return false;
        }
        match triangle.attributes().light {
            None if triangle.is_flat() => self.add_flat::<WATCHED>(world, path, (&triangle, found)),
            None => self.add_smooth::<WATCHED>(world, path, (&triangle, found)),
            Some(_) => false,
        }
    }

    #[inline(always)]
    fn add_flat<const WATCHED: bool>(
        &mut self,
        world: &World,
        path: u32,
        (triangle, found): (&BareTriangle, &ClosestHit),
    ) -> bool {
        let Some(reflectance) = world.even_reflectance(triangle.attributes().material) else {
            return false;
        };
        let trail = &self.paths.trails[path as usize];
        // Beyond the last depth only emission is seen.
        if trail.depth < trail.max_depth {
            let i = self.mattes.vertices.count();
            let vertices = &mut self.mattes.vertices;
            vertices.add_flat(path, reflectance, trail.throughput);
            self.flats.set(i, &trail.ray, (triangle, found));
            if WATCHED && self.looking > 0 {
                self.flats.bare.note(i, triangle);
            }
        }
        true
    }

    #[inline(always)]
    fn add_smooth<const WATCHED: bool>(
        &mut self,
        world: &World,
        path: u32,
        (triangle, found): (&BareTriangle, &ClosestHit),
    ) -> bool {
        let Some(lobes) = world.even_coat(triangle.attributes().material) else {
            return false;
        };
        let trail = &self.paths.trails[path as usize];
        if trail.depth < trail.max_depth {
            let i = self.coated.vertices.count();
            let vertices = &mut self.coated.vertices;
            vertices.add_smooth(path, lobes, trail.throughput);
            self.smooth.set(i, &trail.ray, (triangle, found));
            if WATCHED && self.looking > 0 {
                self.smooth.bare.note(i, triangle);
            }
        }
        true
    }
}

/// Takes up a hit of a path with this throughput if it is of a surface that is [coated](Coated) alike everywhere and emits nothing.
#[inline(always)]
fn add_coated(
    vertices: &mut Vertices<Coated, WAVE>,
    world: &World,
    (path, throughput): (u32, Rgb),
    hit: &GeometryHit,
) -> bool {
    if hit.light.is_some() {
        return false;
    }
    let Some(lobes) = world.even_coat(hit.material) else {
        return false;
    };
    let (surface, shading) = (&hit.surface, &hit.surface.shading);
    let frame = Frame::from_normal_and_tangent(shading.n, shading.dpdu);
    vertices.begin(path, surface, (lobes, &frame), throughput);
    true
}

/// Returns `true` if there is a medium around the ray, or may be on a side of the surface that it has hit: such steps are taken alone.
#[inline(always)]
fn is_in_media(trail: &Trail, interface: Option<InterfaceId>) -> bool {
    trail.medium.is_some() || interface.is_some()
}

/// The parameters (u, v) of a hit with a mesh that has its own.
#[inline(never)]
fn parameters_of_mesh(world: &World, ray: &Ray, found: Option<ClosestHit>) -> Vec2 {
    found.map_or(Vec2::ZERO, |found| world.surface_parameters(ray, &found))
}

/// What looks at a path.
#[inline(always)]
fn sight<'a>(path: &'a mut CameraPath) -> Option<&'a mut Sight> {
    { path.watch.as_deref_mut() }.map(|watch| &mut watch.sight)
}

#[cfg(test)]
mod tests;
