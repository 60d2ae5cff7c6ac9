//! Many paths side by side: a wave of them takes each step together.
//!
//! The commonest vertices, on matte surfaces, are kept as rows of numbers, and the functions that serve a single one are run in loops over
//! them that have no branches and are compiled to vector instructions ([`crate::math::instruction_set`]). A path that meets something else
//! takes that step alone, as in [`super::PathState::extend`]. Nothing that a path brings depends on the others, and all bits are those of
//! one path at a time (Lee, Green, Xie and Tabellion, "Vectorized Production Path Tracing", HPG 2017, has this arrangement for all
//! materials of a film).

mod mattes;

use super::emission::{MisState, Sampled};
use super::lamps::Lamps;
use super::shadows::{Gain, Shadows};
use super::{Path, PathState, Trail};
use crate::accel::{ClosestHit, FlatHits};
use crate::handles::LightId;
use crate::integrators::Sight;
use crate::integrators::context::{Bundle, CameraPath, Lights, WAVE, Workspace};
use crate::math::Rgb;
use crate::math::ray::Ray;
use crate::world::World;
use arrayvec::ArrayVec;
use mattes::Mattes;

/// What the waves of a thread use one after the other.
pub(in super::super) struct Wave {
    /// By path.
    trails: Vec<Trail>,
    /// The paths that go on.
    walking: ArrayVec<u32, WAVE>,
    /// Their rays, and what these hit.
    rays: ArrayVec<Ray, WAVE>,
    found: [Option<ClosestHit>; WAVE],
    /// What is not a flat matte triangle.
    others: ArrayVec<(u32, Option<ClosestHit>), WAVE>,
    flats: FlatHits<WAVE>,
    /// For layers: whether some paths have not met what these tell of, and whether they ask for (u, v).
    is_looking: bool,
    wants_uv: bool,
    mattes: Mattes<WAVE>,
    lamps: Lamps,
    shadows: Shadows,
}

impl Wave {
    pub(in super::super) fn new(world: &World) -> Wave {
        Wave {
            trails: Vec::with_capacity(WAVE),
            walking: ArrayVec::new(),
            rays: ArrayVec::new(),
            found: [None; WAVE],
            others: ArrayVec::new(),
            flats: FlatHits::default(),
            is_looking: false,
            wants_uv: false,
            mattes: Mattes::default(),
            lamps: Lamps::new(world),
            shadows: Shadows::default(),
        }
    }
}

/// A wave's work. `WATCHED`: layers look at the paths.
pub(super) struct Walk<'a, 'p, const WATCHED: bool> {
    pub path: &'a Path,
    pub bundle: Bundle<'a, 'p>,
}

impl<'a, 'p, const WATCHED: bool> Walk<'a, 'p, WATCHED> {
    /// The radiance along each path. Returns what else the bundle has lent.
    pub(super) fn radiances(
        mut self,
        wave: &mut Wave,
        out: &mut ArrayVec<Rgb, WAVE>,
    ) -> &'a mut Workspace {
        let max_depth = self.path.max_depth;
        let begin = |path: &CameraPath| Trail::new(path.end.ray.ray, None, max_depth);
        wave.trails.clear();
        wave.trails
            .extend(self.bundle.paths.iter().take(WAVE).map(begin));
        wave.walking.clear();
        wave.walking.extend(0..wave.trails.len() as u32);
        self.walk(wave, true);
        out.extend(wave.trails.iter().map(|trail| trail.radiance));
        self.bundle.workspace
    }

    /// Extends all paths to their ends.
    fn walk(&mut self, wave: &mut Wave, mut is_first: bool) {
        let mut is_watched = self.see(wave);
        while !wave.walking.is_empty() {
            if WATCHED && !is_watched {
                // All has been seen.
                return self.unwatched().walk(wave, is_first);
            }
            self.extend(wave, is_first);
            is_first = false;
            is_watched = self.see(wave);
        }
    }

    /// The same work, but nobody looks.
    fn unwatched(&mut self) -> Walk<'_, 'p, false> {
        let Bundle {
            world,
            lights,
            paths,
            workspace,
        } = &mut self.bundle;
        Walk {
            path: self.path,
            bundle: Bundle {
                world,
                lights,
                paths,
                workspace,
            },
        }
    }

    /// Extends all paths by a vertex.
    fn extend(&mut self, wave: &mut Wave, is_first: bool) {
        self.intersect(wave);
        self.resolve_flats(wave);
        for i in 0..wave.others.len() {
            let (path, found) = wave.others[i];
            self.extend_alone(wave, path, found, is_first);
        }
        self.sample_lights(wave);
        self.trace_shadows(wave);
        self.sample_directions(wave);
    }

    /// Finds what the paths hit, and sorts it.
    fn intersect(&mut self, wave: &mut Wave) {
        let world = self.bundle.world;
        wave.rays.clear();
        let trails = &wave.trails;
        let ray = |&path: &u32| trails[path as usize].ray;
        wave.rays.extend(wave.walking.iter().map(ray));
        world.closest(&wave.rays, &mut wave.found[..wave.rays.len()]);
        wave.mattes.clear();
        wave.others.clear();
        for i in 0..wave.walking.len() {
            let (path, found) = (wave.walking[i], wave.found[i].take());
            if !wave.add_flat::<WATCHED>(world, path, found.as_ref()) {
                wave.others.push((path, found));
            }
        }
        wave.walking.clear();
    }

    /// Finds where on flat triangles the hits are.
    fn resolve_flats(&mut self, wave: &mut Wave) {
        let count = wave.mattes.count();
        wave.flats.resolve(count);
        wave.mattes.place(&wave.flats);
        for i in 0..count {
            if let Some(found) = wave.flats.grazing(i) {
                let ray = &wave.trails[wave.mattes.path(i)].ray;
                if let Some(hit) = self.bundle.world.surface(ray, &found) {
                    wave.mattes.place_alone(i, &hit.surface);
                }
            }
        }
        if WATCHED && wave.is_looking {
            self.look_at_flats(wave, count);
        }
    }

    /// Looks at flat triangles, for layers.
    fn look_at_flats(&mut self, wave: &mut Wave, count: usize) {
        if wave.wants_uv {
            wave.flats.find_parameters(count);
        }
        for i in 0..count {
            let path = wave.mattes.path(i);
            let (Some(sight), Some(found)) =
                (sight(&mut self.bundle.paths[path]), wave.flats.found(i))
            else {
                continue;
            };
            let ray = &wave.trails[path].ray;
            let from = wave.mattes.from(i, ray.time);
            let uv = wave.flats.parameters(i).filter(|_| wave.wants_uv);
            let (material, standing) = wave.flats.noted(i);
            let hit = (&found, material, Some(standing));
            sight.meet_matte(ray, hit, (from.p, from.n, uv), wave.mattes.reflectance(i));
        }
    }

    /// Finds out whether layers still look at any path, or follow its light: returns `true` if they do.
    fn see(&mut self, wave: &mut Wave) -> bool {
        if !WATCHED {
            return false;
        }
        let paths = &mut *self.bundle.paths;
        let mut watches = paths.iter().filter_map(|path| path.watch.as_deref());
        let follows = watches.next().is_some_and(|watch| watch.parts.is_some());
        let looking = { paths.iter_mut().filter_map(sight) }.find(|sight| !sight.is_done());
        wave.is_looking = looking.is_some();
        wave.wants_uv = looking.is_some_and(|sight| sight.wants_uv);
        follows || wave.is_looking
    }

    /// A step that a path takes alone, unless it finds that the surface is matte.
    fn extend_alone(
        &mut self,
        wave: &mut Wave,
        path: u32,
        found: Option<ClosestHit>,
        is_first: bool,
    ) {
        let trail = wave.trails[path as usize];
        let mut state = self.state(path, trail, is_first);
        let hit = found.and_then(|found| state.context.world.surface(&state.trail.ray, &found));
        let mattes = &mut wave.mattes;
        let goes_on = state.arrive_at(hit.as_ref(), |state, hit, bsdf| {
            match bsdf.matte(hit.surface.wo) {
                Some(matte) => {
                    let throughput = state.trail.throughput;
                    mattes.add(path, &hit.surface, (&matte, bsdf.frame()), throughput);
                    None
                }
                None => state.scatter(hit, bsdf),
            }
        });
        wave.trails[path as usize] = state.trail;
        if goes_on.is_some() {
            wave.walking.push(path);
        }
    }

    /// Emitter sampling at all matte surfaces.
    fn sample_lights(&mut self, wave: &mut Wave) {
        let selector = &self.bundle.lights.selector;
        for light in 0..selector.sample_all_count().unwrap_or(0) {
            for i in 0..wave.mattes.count() {
                if wave.samples_all(self.bundle.lights, i) {
                    self.sample_light(wave, i, (LightId(light), 1.0));
                }
            }
            self.light(wave);
        }
        for i in 0..wave.mattes.count() {
            if wave.samples_all(self.bundle.lights, i) {
                continue;
            }
            let path = wave.mattes.path(i);
            let stream = &mut *self.bundle.paths[path].stream;
            let choice = stream.next_1d_if(selector.chooses());
            let from = wave.mattes.from(i, wave.trails[path].ray.time);
            match selector.sample(&from, choice) {
                Some(chosen) => self.sample_light(wave, i, chosen),
                None => stream.skip_2d(),
            }
        }
        self.light(wave);
    }

    /// Samples one light at a vertex.
    #[inline(always)]
    fn sample_light(&mut self, wave: &mut Wave, i: usize, chosen: (LightId, f32)) {
        let path = wave.mattes.path(i);
        let u = self.bundle.paths[path].stream.next_2d();
        let trail = &wave.trails[path];
        let vertex = wave.mattes.vertex(i, trail.ray.time);
        if wave.lamps.has(self.bundle.world, chosen.0, &vertex.from) {
            let (known, whose) = (
                (&vertex.from, &vertex.matte),
                (path as u32, trail.throughput),
            );
            if wave.lamps.keep(chosen, u, known, whose) {
                self.light(wave);
            }
        } else {
            let state = self.state(path as u32, *trail, false);
            let sample = state.unshadowed(chosen, u, &vertex, &vertex.from);
            if let Some(arriving) = sample {
                let gain = Gain {
                    path: path as u32,
                    from: chosen.0,
                    light: trail.throughput * arriving.weighted(),
                };
                if wave.shadows.push(&arriving.shadow, gain) {
                    self.trace_shadows(wave);
                }
            }
        }
    }

    /// BSDF sampling at all matte surfaces, and Russian roulette.
    fn sample_directions(&mut self, wave: &mut Wave) {
        for i in 0..wave.mattes.count() {
            let stream = &mut *self.bundle.paths[wave.mattes.path(i)].stream;
            // Diffuse reflection has no use for a third number.
            stream.skip_1d();
            wave.mattes.set_number(i, stream.next_2d());
        }
        wave.mattes.sample();
        for i in 0..wave.mattes.count() {
            let path = wave.mattes.path(i);
            let all_lights = wave.samples_all(self.bundle.lights, i);
            let trail = &mut wave.trails[path];
            let Some(next) = wave.mattes.next(i) else {
                continue;
            };
            trail.specular_only = false;
            if self.path.direct_only {
                trail.max_depth = trail.max_depth.min(trail.depth + 1);
            }
            trail.throughput = next.throughput;
            let time = trail.ray.time;
            trail.mis = MisState::Sampled(Sampled {
                from: wave.mattes.from(i, time),
                pdf: next.pdf,
                all_lights,
            });
            trail.ray = Ray::new(next.o, next.d, time);
            let stream = &mut *self.bundle.paths[path].stream;
            let goes_on = trail.russian_roulette(self.path.rr_threshold, || stream.next_1d());
            if goes_on.is_some() {
                wave.walking.push(path as u32);
            }
        }
    }

    /// Computes the light that waits, but for what blocks it.
    fn light(&mut self, wave: &mut Wave) {
        let world = self.bundle.world;
        let (trails, paths) = (&mut wave.trails, &mut *self.bundle.paths);
        let shadows = &mut wave.shadows;
        wave.lamps.light(world, |shadow, gain| {
            if shadows.push(shadow, gain) {
                shadows.trace(world, |gain| add::<WATCHED>(world, trails, paths, gain));
            }
        });
    }

    /// Adds the light that nothing blocks.
    fn trace_shadows(&mut self, wave: &mut Wave) {
        let world = self.bundle.world;
        let (trails, paths) = (&mut wave.trails, &mut *self.bundle.paths);
        wave.shadows
            .trace(world, |gain| add::<WATCHED>(world, trails, paths, gain));
    }

    /// A path by itself.
    #[inline(always)]
    fn state(&mut self, path: u32, trail: Trail, is_first: bool) -> PathState<'_, false, WATCHED> {
        let context = self.bundle.context(path as usize);
        PathState {
            path: self.path,
            differentials: context.differentials.filter(|_| is_first),
            reports: false,
            trail,
            context,
        }
    }
}

impl Wave {
    /// Takes up a hit if it is of a flat triangle that is matte everywhere and emits nothing.
    #[inline(always)]
    fn add_flat<const WATCHED: bool>(
        &mut self,
        world: &World,
        path: u32,
        found: Option<&ClosestHit>,
    ) -> bool {
        let Some(found) = found else {
            return false;
        };
        let Some(triangle) = world.geometry.flat(found) else {
            return false;
        };
        let attributes = triangle.attributes();
        let (None, Some(reflectance)) = (
            attributes.light,
            world.even_reflectance(attributes.material),
        ) else {
            return false;
        };
        let trail = &self.trails[path as usize];
        // Beyond the last depth only emission is seen.
        if trail.depth < trail.max_depth {
            let i = self.mattes.count();
            self.mattes.add_flat(path, reflectance, trail.throughput);
            self.flats.set(i, &trail.ray, (&triangle, found));
            if WATCHED && self.is_looking {
                self.flats.note(i, &triangle);
            }
        }
        true
    }

    /// Returns `true` if every light is sampled at this vertex.
    #[inline(always)]
    fn samples_all(&self, lights: &Lights, i: usize) -> bool {
        let trail = &self.trails[self.mattes.path(i)];
        trail.sample_all_count(lights).is_some()
    }
}

/// What looks at a path.
#[inline(always)]
fn sight<'a>(path: &'a mut CameraPath) -> Option<&'a mut Sight> {
    path.watch.as_mut()?.sight.as_mut()
}

/// Adds light that a path has gained.
#[inline(always)]
fn add<const WATCHED: bool>(
    world: &World,
    trails: &mut [Trail],
    paths: &mut [CameraPath],
    gain: Gain,
) {
    let path = gain.path as usize;
    trails[path].radiance += gain.light;
    if WATCHED && let Some(watch) = &mut paths[path].watch {
        watch.part(world.light_layer(Some(gain.from)), gain.light);
    }
}

#[cfg(test)]
mod tests;
