//! Many light paths side by side, whose rays are traced together. Nothing that a path brings depends on the others.

use super::flats::Flats;
use super::light_path::{Begun, LightTracer, LightVertex};
use super::vertex::Vertex;
use super::walk::{Met, Walk};
use crate::accel::ClosestHit;
use crate::handles::LightId;
use crate::math::ray::Ray;
use crate::math::{Rgb, Vec2};
use crate::samplers::SampleStream;
use arrayvec::ArrayVec;

/// Paths that are traced together: enough to fill packets of rays when many of them have ended.
const WAVE: usize = 64;

/// A path being traced.
struct ActivePath {
    start: PathStart,
    begun: Begun,
    walk: Walk,
    stream: SampleStream,
}

/// What is start of a path before it begins.
#[derive(Clone, Copy)]
pub(super) struct PathStart {
    /// Its number.
    pub path: u64,
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

    /// A path has ended, with its sample stream as it leaves it.
    fn end(&mut self, _start: &PathStart, _stream: &SampleStream) {}
}

/// Traces paths.
pub(super) fn trace_all<'a>(
    tracer: &LightTracer<'_, 'a>,
    mut paths: impl Iterator<Item = (PathStart, SampleStream)>,
    flats: &mut Flats,
    visitor: &mut impl Visitor<'a>,
) {
    let mut active = ArrayVec::<ActivePath, WAVE>::new();
    loop {
        while !active.is_full()
            && let Some((start, mut stream)) = paths.next()
        {
            match tracer.begin(start.time, &mut stream) {
                Some((begun, walk)) if tracer.max_depth > 0 => active.push(ActivePath {
                    start,
                    begun,
                    walk,
                    stream,
                }),
                _ => visitor.end(&start, &stream),
            }
        }
        if active.is_empty() {
            return;
        }
        let mut has_ended = [false; WAVE];
        extend(tracer, (&mut active, &mut has_ended), flats, visitor);
        extend_from_flats(tracer, (&mut active, &mut has_ended), flats, visitor);
        // From the last, so that others take the places of those that end.
        for i in (0..active.len()).rev() {
            let ActivePath {
                start,
                walk,
                stream,
                ..
            } = &active[i];
            if has_ended[i] || walk.depth >= tracer.max_depth {
                visitor.end(start, stream);
                active.swap_remove(i);
            }
        }
    }
}

/// Extends paths by a vertex, and takes up those that come to flat triangles.
fn extend<'a>(
    tracer: &LightTracer<'_, 'a>,
    (active, has_ended): (&mut [ActivePath], &mut [bool; WAVE]),
    flats: &mut Flats,
    visitor: &mut impl Visitor<'a>,
) {
    let world = tracer.world;
    let rays: ArrayVec<Ray, WAVE> = active.iter().map(|path| path.walk.ray).collect();
    let mut found = [None; WAVE];
    world.closest(&rays, &mut found[..rays.len()]);
    flats.clear();
    for (i, (path, found)) in active.iter_mut().zip(found).enumerate() {
        let ActivePath {
            start,
            begun,
            walk,
            stream,
        } = path;
        let t = found.as_ref().map(ClosestHit::t);
        let Some(met) = walk.advance(world, t, stream) else {
            has_ended[i] = true;
            continue;
        };
        let found = found.filter(|_| matches!(met, Met::Surface));
        let mut add = |found| flats.add(world, (i as u32, walk), found, Rgb::ONE);
        if found.as_ref().is_some_and(&mut add) {
            continue;
        }
        let hit = found.and_then(|found| world.surface(&walk.ray, &found));
        let mut visit = |vertex: LightVertex<'_, 'a>, stream: &mut SampleStream| {
            visitor.visit(start, begun.light, vertex, stream);
        };
        let at = (walk, (met, hit.as_ref()));
        let extended = tracer.extend(begun, at, stream, &mut visit);
        has_ended[i] = extended.is_none();
    }
}

/// Extends the paths that have come to flat triangles.
fn extend_from_flats<'a>(
    tracer: &LightTracer<'_, 'a>,
    (active, has_ended): (&mut [ActivePath], &mut [bool; WAVE]),
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
        } = &mut active[flats.path(i)];
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
        let (path, at) = (flats.path(i), flats.vertex(i));
        let ActivePath {
            start,
            begun,
            walk,
            stream,
        } = &mut active[path];
        let found = LightVertex {
            vertex: Vertex::Flat(&at),
            throughput: walk.throughput,
            history,
            depth: walk.depth,
        };
        let next = flats.next(i).filter(|_| !tracer.is_last(walk));
        let left = next.and_then(|(next, _)| tracer.leave_flat(walk, &at, &next, &history, stream));
        has_ended[path] = left.is_none();
        visitor.visit(start, begun.light, found, stream);
    }
}
