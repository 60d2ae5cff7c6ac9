//! Emitter sampling at the vertices of a wave: as [`PathState::sample_direct`](super::super::PathState::sample_direct), side by side where
//! the light is one of few that [batches](EmitterBatches) know.

use super::{Lot, Paths, Walk};
use crate::bsdf::Scatterer;
use crate::handles::LightId;
use crate::integrators::context::{CameraPath, Lights, WAVE};
use crate::integrators::path::Trail;
use crate::integrators::path::emitter_batches::{EmitterBatches, Gain};
use crate::integrators::path::emitter_sampling::choose;
use crate::integrators::shadows::Shadows;
use crate::integrators::volpath::{dimmed_along, shadow_segment};
use crate::math::ray::Ray;
use crate::math::{Vec2, color::is_black};
use crate::samplers::ChoiceSample;
use crate::world::World;
use arrayvec::ArrayVec;

impl<const MEDIA: bool, const WATCHED: bool> Walk<'_, '_, MEDIA, WATCHED> {
    /// Emitter sampling at all vertices of a kind.
    pub(super) fn sample_lights<S: Scatterer>(&mut self, lot: &mut Lot<S>, paths: &mut Paths) {
        let selector = &self.bundle.lights.selector;
        if let Some(only) = selector.only() {
            self.sample_everywhere(lot, paths, only, |_| true);
            return;
        }
        for light in 0..selector.sample_all_count().unwrap_or(0) {
            self.sample_everywhere(lot, paths, LightId(light), Trail::is_first);
        }
        // As many rounds as a path's first vertex takes: it may lie beyond surfaces without material, in any step.
        for number in 0..selector.choices(true) {
            let choices = self.choices(lot, paths, number);
            for (i, numbers) in choices.into_iter().enumerate() {
                if let Some(numbers) = numbers {
                    self.sample_some(lot, paths, i, (number, numbers));
                }
            }
            self.light(&mut lot.batches, paths);
        }
    }

    /// Samples for one of the choices of a light, for each vertex of a kind that makes it.
    #[inline(always)]
    fn choices<S: Scatterer>(
        &mut self,
        lot: &Lot<S>,
        paths: &mut Paths,
        number: u32,
    ) -> ArrayVec<Option<ChoiceSample>, WAVE> {
        let is_choice = self.bundle.lights.selector.chooses();
        let mut choices = ArrayVec::<_, WAVE>::new();
        paths.pairs.clear();
        for i in 0..lot.vertices.count() {
            let path = lot.vertices.path(i);
            let known = (paths.choices(self.bundle.lights, path) > number).then(|| {
                let stream = &mut *self.bundle.paths[path].stream;
                paths.pairs.ask_choice(stream, is_choice, i)
            });
            choices.push(known.flatten());
        }
        paths.pairs.compute();
        for asked in 0..paths.pairs.asked() {
            let i = paths.pairs.whose(asked);
            let stream = &mut *self.bundle.paths[lot.vertices.path(i)].stream;
            let pair = paths.pairs.answer(asked, stream);
            choices[i] = Some(ChoiceSample::shared(pair, is_choice));
        }
        choices
    }

    /// Samples one light at all vertices of a kind whose paths `do_so`.
    fn sample_everywhere<S: Scatterer>(
        &mut self,
        lot: &mut Lot<S>,
        paths: &mut Paths,
        light: LightId,
        do_so: impl Fn(&Trail) -> bool,
    ) {
        let world = self.bundle.world;
        let is_only = !self.bundle.lights.selector.chooses();
        let count = lot.vertices.count();
        // Where there is one light, the number that would choose is skipped.
        let wants = |trail: &Trail| do_so(trail).then_some(is_only);
        self.draw(&mut lot.vertices, paths, wants);
        let mut are_side_by_side = [false; WAVE];
        for (i, is_side_by_side) in are_side_by_side.iter_mut().enumerate().take(count) {
            let path = lot.vertices.path(i);
            let trail = &paths.trails[path];
            if !do_so(trail) {
                continue;
            }
            let from = lot.vertices.from(i, trail.ray.time);
            if lot.batches.has(world, light, &from) {
                *is_side_by_side = true;
            } else {
                let u = lot.vertices.number(i);
                self.sample_light(lot, paths, i, ((light, 1.0), u));
            }
        }
        if are_side_by_side.contains(&true) {
            lot.batches
                .light_all((world, light), lot.vertices.rows(), count);
        }
        for i in (0..count).filter(|&i| are_side_by_side[i]) {
            let path = lot.vertices.path(i);
            let time = paths.trails[path].ray.time;
            if let Some((shadow, found)) = lot.batches.found(i, time) {
                let gain = Gain {
                    path: path as u32,
                    from: light,
                    light: found,
                };
                if wait::<MEDIA>(&mut paths.shadows, world, &shadow, gain) {
                    self.trace_shadows(paths);
                }
            }
        }
    }

    /// Makes one of the choices of a light at a vertex where not all are sampled, and samples that light.
    #[inline(always)]
    fn sample_some<S: Scatterer>(
        &mut self,
        lot: &mut Lot<S>,
        paths: &mut Paths,
        i: usize,
        (number, numbers): (u32, ChoiceSample),
    ) {
        let path = lot.vertices.path(i);
        let selector = &self.bundle.lights.selector;
        let trail = &paths.trails[path];
        let all = selector.choices(trail.is_first());
        let from = lot.vertices.from(i, trail.ray.time);
        if let Some(chosen) = choose(selector, &from, (number, all), numbers) {
            self.sample_light(lot, paths, i, chosen);
        }
    }

    /// Samples one light at a vertex.
    #[inline(always)]
    fn sample_light<S: Scatterer>(
        &mut self,
        lot: &mut Lot<S>,
        paths: &mut Paths,
        i: usize,
        (chosen, u): ((LightId, f32), Vec2),
    ) {
        let path = lot.vertices.path(i);
        let world = self.bundle.world;
        let trail = &paths.trails[path];
        let vertex = lot.vertices.vertex(i, trail.ray.time);
        if lot.batches.has(world, chosen.0, &vertex.from) {
            let (known, whose) = (
                (&vertex.from, &vertex.scatterer),
                (path as u32, trail.throughput),
            );
            if lot.batches.keep(chosen, u, known, whose) {
                self.light(&mut lot.batches, paths);
            }
        } else {
            let mut trail = *trail;
            let state = self.state(path as u32, (&mut trail, 0), false);
            let sample = state.unshadowed(chosen, u, &vertex, &vertex.from);
            if let Some(arriving) = sample {
                let gain = Gain {
                    path: path as u32,
                    from: chosen.0,
                    light: trail.throughput * arriving.weighted(),
                };
                if wait::<MEDIA>(&mut paths.shadows, world, &arriving.shadow, gain) {
                    self.trace_shadows(paths);
                }
            }
        }
    }

    /// Computes the light that waits, but for what blocks it.
    fn light<S: Scatterer>(&mut self, batches: &mut EmitterBatches<S>, waiting: &mut Paths) {
        let (world, follows) = (self.bundle.world, WATCHED && self.follows);
        let (trails, paths) = (&mut waiting.trails, &mut *self.bundle.paths);
        let shadows = &mut waiting.shadows;
        batches.light(world, |shadow, gain| {
            if wait::<MEDIA>(shadows, world, shadow, gain) {
                trace::<MEDIA>(shadows, (world, follows), (trails, paths));
            }
        });
    }

    /// Adds the light that nothing blocks.
    pub(super) fn trace_shadows(&mut self, waiting: &mut Paths) {
        let with = (self.bundle.world, WATCHED && self.follows);
        let (trails, paths) = (&mut waiting.trails, &mut *self.bundle.paths);
        trace::<MEDIA>(&mut waiting.shadows, with, (trails, paths));
    }
}

impl Paths {
    /// How many lights are chosen at the vertex that this path is at: none where every light is sampled.
    #[inline(always)]
    fn choices(&self, lights: &Lights, path: usize) -> u32 {
        let trail = &self.trails[path];
        match trail.sample_all_count(lights) {
            Some(_) => 0,
            None => lights.selector.choices(trail.is_first()),
        }
    }
}

/// Keeps a shadow ray that begins in no medium. Returns `true` if the next one needs room.
#[inline(always)]
fn wait<const MEDIA: bool>(
    shadows: &mut Shadows<Gain>,
    world: &World,
    shadow: &Ray,
    gain: Gain,
) -> bool {
    match MEDIA {
        true => shadows.push(&shadow_segment(world, shadow, None), gain),
        false => shadows.push(shadow, gain),
    }
}

/// Traces shadow rays, and adds the light that nothing blocks. They begin in no medium.
fn trace<const MEDIA: bool>(
    shadows: &mut Shadows<Gain>,
    (world, follows): (&World, bool),
    (trails, paths): (&mut [Trail], &mut [CameraPath]),
) {
    let with = (world, follows);
    if !MEDIA {
        shadows.trace(world, |_, gain| add(with, trails, paths, gain));
        return;
    }
    shadows.trace_through(world, |shadow, gain, passage| {
        let stream = &mut *paths[gain.path as usize].stream;
        let left = dimmed_along(world, stream, None, shadow, passage);
        let light = gain.light * left;
        if !is_black(light) {
            add(with, trails, paths, Gain { light, ..gain });
        }
    });
}

/// Adds light that a path has gained, to its layer as well, if layers of light follow it.
#[inline(always)]
fn add(
    (world, follows): (&World, bool),
    trails: &mut [Trail],
    paths: &mut [CameraPath],
    gain: Gain,
) {
    let path = gain.path as usize;
    trails[path].radiance += gain.light;
    if follows && let Some(watch) = &mut paths[path].watch {
        watch.part(|| world.light_layer(Some(gain.from)), gain.light);
    }
}
