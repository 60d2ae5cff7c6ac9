//! Many light paths side by side, whose rays are traced together. Nothing that a path brings depends on the others.

use super::light_path::{Begun, LightTracer, LightVertex};
use super::walk::Walk;
use crate::handles::LightId;
use crate::math::ray::Ray;
use crate::samplers::SampleStream;
use arrayvec::ArrayVec;

/// Paths that are traced together: enough to fill packets of rays when many of them have ended.
const WAVE: usize = 64;

/// A path on its way.
struct Traveler {
    known: Known,
    begun: Begun,
    walk: Walk,
    stream: SampleStream,
}

/// What is known of a path before it begins.
#[derive(Clone, Copy)]
pub(super) struct Known {
    /// Its number.
    pub path: u64,
    pub time: f32,
    /// See [`CameraSample::wavelength`](crate::cameras::CameraSample::wavelength).
    pub wavelength: f32,
}

/// What is told of paths on their way.
pub(super) trait Visitor<'a> {
    /// A path has come to a vertex that can be joined to others: those of a path in order.
    fn visit(
        &mut self,
        known: &Known,
        light: LightId,
        vertex: LightVertex<'_, 'a>,
        stream: &mut SampleStream,
    );

    /// A path has ended, and leaves these numbers.
    fn end(&mut self, _known: &Known, _stream: &SampleStream) {}
}

/// Traces paths.
pub(super) fn trace_all<'a>(
    tracer: &LightTracer<'_, 'a>,
    mut paths: impl Iterator<Item = (Known, SampleStream)>,
    visitor: &mut impl Visitor<'a>,
) {
    let world = tracer.world;
    let mut travelers = ArrayVec::<Traveler, WAVE>::new();
    let mut rays = ArrayVec::<Ray, WAVE>::new();
    let mut found = [None; WAVE];
    loop {
        let room = travelers.remaining_capacity();
        let begin = |(known, stream)| begin(tracer, known, stream, visitor);
        travelers.extend(paths.by_ref().filter_map(begin).take(room));
        if travelers.is_empty() {
            return;
        }
        rays.clear();
        rays.extend(travelers.iter().map(|traveler| traveler.walk.ray));
        world.closest(&rays, &mut found[..rays.len()]);
        // From the last, so that others take the places of those that end.
        for i in (0..travelers.len()).rev() {
            let Traveler {
                known,
                begun,
                walk,
                stream,
            } = &mut travelers[i];
            let hit = found[i].take();
            let hit = hit.and_then(|found| world.surface(&walk.ray, &found));
            let mut visit = |vertex: LightVertex<'_, 'a>, stream: &mut SampleStream| {
                visitor.visit(known, begun.light, vertex, stream);
            };
            let extended = tracer.extend(begun, (walk, hit.as_ref()), stream, &mut visit);
            if extended.is_none() || walk.depth >= tracer.max_depth {
                visitor.end(known, stream);
                travelers.swap_remove(i);
            }
        }
    }
}

fn begin<'a>(
    tracer: &LightTracer<'_, 'a>,
    known: Known,
    mut stream: SampleStream,
    visitor: &mut impl Visitor<'a>,
) -> Option<Traveler> {
    let begun = tracer.begin(known.time, &mut stream);
    let Some((begun, walk)) = begun.filter(|_| tracer.max_depth > 0) else {
        visitor.end(&known, &stream);
        return None;
    };
    Some(Traveler {
        known,
        begun,
        walk,
        stream,
    })
}
