//! Light paths that are kept, so that camera paths can be joined to them.

use super::light_path::LightVertex;
use super::light_wave::PathStart;
use super::splat;
use super::vertex::{FlatVertex, Vertex};
use super::weights::History;
use crate::accel::GeometryHit;
use crate::bsdf::Bsdf;
use crate::handles::{LightId, MediumId};
use crate::integrators::context::{CameraEnd, Paired, WAVE};
use crate::integrators::vertex::MediumVertex;
use crate::math::Rgb;
use crate::samplers::SampleStream;
use crate::world::World;

/// Room is made for so many vertices of a path before there are any.
const INITIAL_CAPACITY: u32 = 16;

/// A [`LightVertex`] that is kept.
struct Kept<'a> {
    at: Place<'a>,
    throughput: Rgb,
    history: History,
    depth: u32,
}

/// A [`Vertex`] that is kept.
#[expect(
    clippy::large_enum_variant,
    reason = "most are surfaces, and none is allocated by itself"
)]
enum Place<'a> {
    Surface {
        hit: GeometryHit,
        bsdf: Bsdf<'a>,
        medium: Option<MediumId>,
        below: bool,
    },
    Flat(FlatVertex),
    Medium(MediumVertex),
}

impl<'a> LightVertex<'_, 'a> {
    fn keep(&self) -> Kept<'a> {
        let at = match self.vertex {
            Vertex::Surface {
                hit,
                bsdf,
                medium,
                below,
            } => Place::Surface {
                hit: *hit,
                bsdf: bsdf.clone(),
                medium,
                below,
            },
            Vertex::Flat(at) => Place::Flat(*at),
            Vertex::Medium(at) => Place::Medium(*at),
        };
        let &LightVertex {
            throughput,
            history,
            depth,
            ..
        } = self;
        Kept {
            at,
            throughput,
            history,
            depth,
        }
    }
}

impl<'a> Kept<'a> {
    fn view(&self) -> LightVertex<'_, 'a> {
        let vertex = match &self.at {
            Place::Surface {
                hit,
                bsdf,
                medium,
                below,
            } => Vertex::Surface {
                hit,
                bsdf,
                medium: *medium,
                below: *below,
            },
            Place::Flat(at) => Vertex::Flat(at),
            Place::Medium(at) => Vertex::Medium(at),
        };
        let &Kept {
            throughput,
            history,
            depth,
            ..
        } = self;
        LightVertex {
            vertex,
            throughput,
            history,
            depth,
        }
    }
}

/// Light paths, each by its vertices that can be joined to a camera path.
pub(super) struct LightPaths<'a> {
    /// Of all paths, in any order.
    vertices: Vec<Link<'a>>,
    /// By number.
    paths: Vec<Option<Ends>>,
}

/// A vertex, and where the next one of its path is.
struct Link<'a> {
    kept: Kept<'a>,
    next: Option<u32>,
}

/// How a light path starts that the camera path in this `place` is joined to, and its numbers: those of the light pass, or of the camera path.
pub(super) fn start(
    (world, end): (&World, &CameraEnd),
    stream: &mut SampleStream,
    place: u32,
) -> (PathStart, SampleStream) {
    if let Some(Paired { sampler, number }) = end.paired {
        let stream = sampler.light_stream(number);
        return splat::start((world, end.camera), (number, place), stream);
    }
    let start = PathStart {
        path: place.into(),
        place,
        time: end.ray.ray.time,
        wavelength: 0.0,
    };
    (start, stream.fork())
}

/// Where a path's first and last vertex are, and where it begins.
#[derive(Clone, Copy)]
struct Ends {
    light: LightId,
    first: u32,
    last: u32,
    /// How many vertices.
    count: u32,
}

/// One of the [`LightPaths`], which may be empty.
#[derive(Clone, Copy, Default)]
pub(super) struct LightPath<'v, 'a> {
    vertices: &'v [Link<'a>],
    ends: Option<Ends>,
}

/// The memory of vertices between some samples and the next.
#[derive(Default)]
pub(in crate::integrators) struct SpareVertices {
    vertices: Vec<Link<'static>>,
    paths: Vec<Option<Ends>>,
}

impl<'a> LightPaths<'a> {
    /// None yet, in the memory of the last ones. Reserves room for `count` paths of up to `depth` vertices (16 at most), so that later waves allocate
    /// nothing.
    pub(super) fn in_spare(
        spare: &mut SpareVertices,
        (count, depth): (usize, u32),
    ) -> LightPaths<'a> {
        let mut vertices = recycled(std::mem::take(&mut spare.vertices));
        vertices.reserve(count * depth.min(INITIAL_CAPACITY) as usize);
        let mut paths = std::mem::take(&mut spare.paths);
        paths.clear();
        if count > 0 {
            paths.resize(WAVE, None);
        }
        LightPaths { vertices, paths }
    }

    /// Gives the memory back.
    pub(super) fn give_back(self, spare: &mut SpareVertices) {
        spare.vertices = recycled(self.vertices);
        spare.paths = self.paths;
    }

    /// Adds a vertex to the end of a path, which begins at this light.
    pub(super) fn push(&mut self, number: usize, light: LightId, vertex: &LightVertex<'_, 'a>) {
        let index = self.vertices.len() as u32;
        let ends = self.paths[number].get_or_insert(Ends {
            light,
            first: index,
            last: index,
            count: 0,
        });
        ends.count += 1;
        let before = std::mem::replace(&mut ends.last, index);
        if before != index {
            self.vertices[before as usize].next = Some(index);
        }
        let kept = vertex.keep();
        self.vertices.push(Link { kept, next: None });
    }

    /// The path with this number.
    pub(super) fn path(&self, number: usize) -> LightPath<'_, 'a> {
        LightPath {
            vertices: &self.vertices,
            ends: self.paths.get(number).copied().flatten(),
        }
    }
}

impl<'v, 'a> LightPath<'v, 'a> {
    /// Where it begins, if it does.
    pub(super) fn light(self) -> Option<LightId> {
        Some(self.ends?.light)
    }

    /// The number of [`LightPath::vertices`].
    pub(super) fn len(self) -> usize {
        self.ends.map_or(0, |ends| ends.count as usize)
    }

    /// From the light on; not the point on the light.
    pub(super) fn vertices(self) -> impl Iterator<Item = LightVertex<'v, 'a>> {
        let vertices = self.vertices;
        let link = move |index: u32| vertices.get(index as usize);
        let first = self.ends.and_then(|ends| link(ends.first));
        let links = std::iter::successors(first, move |last| link(last.next?));
        links.map(|link| link.kept.view())
    }
}

/// The memory of `vertices` for others, which may refer to another world. Elements of equal size are collected where they were: an optimization of the
/// standard library, without which each wave would allocate (tests/allocations.rs).
#[expect(
    clippy::unnecessary_filter_map,
    reason = "elements of another lifetime, of which there are none"
)]
fn recycled<'b>(mut vertices: Vec<Link<'_>>) -> Vec<Link<'b>> {
    vertices.clear();
    vertices.into_iter().filter_map(|_| None).collect()
}
