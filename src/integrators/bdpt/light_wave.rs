//! Many light paths side by side, whose rays are traced together. Nothing that a path brings depends on the others.

use super::flats::Flats;
use super::light_path::{Begun, LightTracer, LightVertex};
use super::vertex::Vertex;
use super::walk::{Branches, Met, Walk};
use crate::accel::ClosestHit;
use crate::handles::LightId;
use crate::integrators::emitters::Chosen;
use crate::math::ray::Ray;
use crate::math::{Rgb, Vec2};
use crate::samplers::SampleStream;
use arrayvec::ArrayVec;
use std::iter::repeat_n;

/// Paths that are traced together: enough to fill packets of rays when many of them have ended.
const LIGHT_WAVE: usize = 64;

/// A path being traced.
struct ActivePath {
    start: PathStart,
    begun: Begun,
    walk: Walk,
    stream: SampleStream,
    /// It has come to an end in this step, at least by this way.
    has_ended: bool,
}

/// What is known of a path before it begins.
#[derive(Clone, Copy)]
pub(super) struct PathStart {
    /// Its number.
    pub path: u64,
    /// That of the camera path that is joined to it, if one is.
    pub place: u32,
    pub time: f32,
    /// See [`CameraSample::wavelength`](crate::cameras::CameraSample::wavelength).
    pub wavelength: f32,
}

/// Receives the vertices of light paths.
pub(super) trait Visitor<'a> {
    /// A path has come to a vertex that can be joined to others: those of a path in order.
    fn visit(
        &mut self,
        start: &PathStart,
        light: LightId,
        vertex: LightVertex<'_, 'a>,
        stream: &mut SampleStream,
    );
}

/// Traces paths.
pub(super) fn trace_all<'a>(
    tracer: &LightTracer<'_, 'a>,
    mut paths: impl Iterator<Item = (PathStart, SampleStream)>,
    flats: &mut Flats,
    visitor: &mut impl Visitor<'a>,
) {
    let mut wave = Wave::new();
    while wave.begin(tracer, &mut paths) {
        wave.extend(tracer, flats, visitor);
        wave.extend_from_flats(tracer, flats, visitor);
        wave.end(tracer);
    }
}

/// Paths being traced.
struct Wave {
    /// In their places. One that has ended stays until another takes its place.
    paths: ArrayVec<ActivePath, LIGHT_WAVE>,
    /// The ways that are left to each. Not in an array: that would be zeroed for each wave, 45 KiB.
    branches: ArrayVec<Branches, LIGHT_WAVE>,
    /// The places of those being traced.
    active: ArrayVec<u8, LIGHT_WAVE>,
    /// The places of others.
    free: ArrayVec<u8, LIGHT_WAVE>,
}

impl Wave {
    fn new() -> Wave {
        Wave {
            paths: ArrayVec::new(),
            branches: ArrayVec::new(),
            active: ArrayVec::new(),
            free: ArrayVec::new(),
        }
    }

    /// Begins as many paths as there is room for. Returns `false` if there are none any more.
    fn begin<'a>(
        &mut self,
        tracer: &LightTracer<'_, 'a>,
        paths: &mut impl Iterator<Item = (PathStart, SampleStream)>,
    ) -> bool {
        let room = LIGHT_WAVE - self.active.len();
        let mut chosen = ArrayVec::<(PathStart, SampleStream, Option<Chosen>), LIGHT_WAVE>::new();
        for (start, mut stream) in paths.take(room) {
            let light = tracer.choose(&mut stream);
            chosen.push((start, stream, light));
        }
        tracer.guide(chosen.iter_mut().filter_map(|(_, _, light)| light.as_mut()));
        let is_any = !self.active.is_empty() || !chosen.is_empty();
        for (start, stream, light) in &chosen {
            let place = self.place(start, stream);
            let path = &mut self.paths[usize::from(place)];
            let begun = light.as_ref().and_then(|light| {
                let in_place = (&mut path.begun, &mut path.walk);
                tracer.begin(start.time, light, in_place)
            });
            if begun.is_some() && tracer.max_depth > 0 {
                path.start = *start;
                path.stream = *stream;
                path.has_ended = false;
                self.active.push(place);
            } else {
                self.free.push(place);
            }
        }
        is_any
    }

    /// A place for a path.
    fn place(&mut self, start: &PathStart, stream: &SampleStream) -> u8 {
        self.free.pop().unwrap_or_else(|| {
            self.paths.push(ActivePath {
                start: *start,
                begun: Begun::default(),
                walk: Walk::default(),
                stream: *stream,
                has_ended: false,
            });
            self.branches.push(Branches::new());
            (self.paths.len() - 1) as u8
        })
    }

    /// Extends paths by a vertex, and takes up those that come to flat triangles.
    fn extend<'a>(
        &mut self,
        tracer: &LightTracer<'_, 'a>,
        flats: &mut Flats,
        visitor: &mut impl Visitor<'a>,
    ) {
        let world = tracer.world;
        let ray = |&place: &u8| self.paths[usize::from(place)].walk.ray;
        let rays: ArrayVec<Ray, LIGHT_WAVE> = self.active.iter().map(ray).collect();
        let mut found = ArrayVec::<Option<ClosestHit>, LIGHT_WAVE>::new();
        found.extend(repeat_n(None, rays.len()));
        world.closest(&rays, &mut found);
        flats.clear();
        for (&place, found) in self.active.iter().zip(found) {
            let ActivePath {
                start,
                begun,
                walk,
                stream,
                has_ended,
            } = &mut self.paths[usize::from(place)];
            let t = found.as_ref().map(ClosestHit::t);
            let Some(met) = walk.advance(world, t, stream) else {
                *has_ended = true;
                continue;
            };
            let found = found.filter(|_| matches!(met, Met::Surface));
            let mut add = |found| flats.add(world, (place.into(), walk), found, Rgb::ONE);
            if found.as_ref().is_some_and(&mut add) {
                continue;
            }
            let hit = found.and_then(|found| world.surface(&walk.ray, &found));
            let mut visit = |vertex: LightVertex<'_, 'a>, stream: &mut SampleStream| {
                visitor.visit(start, begun.light, vertex, stream);
            };
            let at = (walk, (met, hit.as_ref()));
            let branches = &mut self.branches[usize::from(place)];
            let extended = tracer.extend(begun, at, stream, branches, &mut visit);
            *has_ended = extended.is_none();
        }
    }

    /// Extends the paths that have come to flat triangles.
    fn extend_from_flats<'a>(
        &mut self,
        tracer: &LightTracer<'_, 'a>,
        flats: &mut Flats,
        visitor: &mut impl Visitor<'a>,
    ) {
        flats.resolve(tracer.world);
        for i in 0..flats.count() {
            let ActivePath {
                begun,
                walk,
                stream,
                ..
            } = &mut self.paths[flats.path(i)];
            let history = tracer.meet_flat(begun, walk, &flats.vertex(i));
            let u = match tracer.is_last(walk) {
                true => Vec2::ZERO,
                false => {
                    // Reflection needs no third sample.
                    stream.skip_1d();
                    stream.next_2d()
                }
            };
            flats.set_next(Some((history, u)));
        }
        flats.sample();
        for i in 0..flats.count() {
            let Some(&history) = flats.history(i) else {
                continue;
            };
            let at = flats.vertex(i);
            let ActivePath {
                start,
                begun,
                walk,
                stream,
                has_ended,
            } = &mut self.paths[flats.path(i)];
            let found = LightVertex {
                vertex: Vertex::Flat(&at),
                throughput: walk.throughput,
                history,
                depth: walk.depth,
            };
            let next = flats.next(i).filter(|_| !tracer.is_last(walk));
            let left =
                next.and_then(|(next, _)| tracer.leave_flat(walk, &at, &next, &history, stream));
            *has_ended = left.is_none();
            visitor.visit(start, begun.light, found, stream);
        }
    }

    /// Lets paths that have come to an end take the ways that are left to them, and ends those that have none.
    fn end(&mut self, tracer: &LightTracer) {
        let Wave {
            paths,
            branches,
            active,
            free,
        } = self;
        active.retain(|&mut place| {
            let path = &mut paths[usize::from(place)];
            if !path.has_ended && path.walk.depth < tracer.max_depth {
                return true;
            }
            path.has_ended = false;
            if let Some(branch) = branches[usize::from(place)].pop() {
                branch.take(&mut path.walk, &mut path.stream);
                return true;
            }
            free.push(place);
            false
        });
    }
}
