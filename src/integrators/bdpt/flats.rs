//! Vertices on flat triangles that are matte everywhere, the commonest: their points are found, and directions chosen, side by side.

use super::vertex::FlatVertex;
use super::walk::Walk;
use super::weights::History;
use crate::accel::{ClosestHit, FlatHits};
use crate::bsdf::Matte;
use crate::handles::MediumId;
use crate::integrators::context::WAVE;
use crate::integrators::vertices::{Next, Vertices};
use crate::math::ray::Ray;
use crate::math::{Rgb, Vec2};
use crate::world::World;
use arrayvec::ArrayVec;

/// See above.
#[derive(Default)]
pub(super) struct Flats {
    hits: FlatHits<WAVE>,
    vertices: Vertices<Matte, WAVE>,
    /// The rays, and the media along them.
    arriving: ArrayVec<(Ray, Option<MediumId>), WAVE>,
    /// Of each vertex; `None` where the path ends.
    histories: ArrayVec<Option<History>, WAVE>,
}

impl Flats {
    pub(super) fn clear(&mut self) {
        self.vertices.clear();
        self.arriving.clear();
        self.histories.clear();
    }

    pub(super) fn count(&self) -> usize {
        self.vertices.count()
    }

    /// Takes up what a path's ray has hit if it is of a flat triangle that is matte everywhere, emits nothing, and has the same medium on both
    /// sides.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        world: &World,
        (path, walk): (u32, &Walk),
        found: &ClosestHit,
        throughput: Rgb,
    ) -> bool {
        let Some(triangle) = world.geometry.bare_triangle(found) else {
            return false;
        };
        let attributes = triangle.attributes();
        let may_be_interface = attributes.interface.is_some() && !world.media.is_empty();
        // What is not finite goes by itself, and is counted.
        let is_finite = walk.throughput.is_finite();
        if attributes.light.is_some() || may_be_interface || !triangle.is_flat() || !is_finite {
            return false;
        }
        let Some(reflectance) = world.even_reflectance(attributes.material) else {
            return false;
        };
        self.hits.set(self.count(), &walk.ray, (&triangle, found));
        self.vertices.add_flat(path, reflectance, throughput);
        self.arriving.push((walk.ray, walk.medium));
        true
    }

    /// Finds all points.
    pub(super) fn resolve(&mut self, world: &World) {
        let count = self.count();
        self.hits.resolve(count, false);
        self.vertices.place(&self.hits);
        for i in 0..count {
            if let Some(found) = self.hits.grazing(i)
                && let Some(hit) = world.surface(&self.arriving[i].0, &found)
            {
                self.vertices.place_alone(i, &hit.surface);
            }
        }
    }

    /// The path that vertex `i` is of.
    pub(super) fn path(&self, i: usize) -> usize {
        self.vertices.path(i)
    }

    /// Vertex `i`.
    #[inline(always)]
    pub(super) fn vertex(&self, i: usize) -> FlatVertex {
        let (ray, medium) = &self.arriving[i];
        let vertex = self.vertices.vertex(i, ray.time);
        // Here, while both are in registers.
        let cosine = vertex.from.n.dot(ray.d).abs();
        FlatVertex {
            from: vertex.from,
            matte: vertex.scatterer,
            wo: -ray.d,
            cosine,
            medium: *medium,
        }
    }

    /// Sets the history and the 2-D sample of the next vertex's direction; `None` where its path ends.
    pub(super) fn set_next(&mut self, onward: Option<(History, Vec2)>) {
        if let Some((_, u)) = onward {
            self.vertices.set_number(self.histories.len(), u);
        }
        self.histories.push(onward.map(|(history, _)| history));
    }

    /// Chooses all directions.
    pub(super) fn sample(&mut self) {
        self.vertices.sample();
    }

    /// The history of vertex `i`, if its path was to continue.
    pub(super) fn history(&self, i: usize) -> Option<&History> {
        self.histories[i].as_ref()
    }

    /// How the path of vertex `i` continues, and what its throughput was multiplied by.
    pub(super) fn next(&self, i: usize) -> Option<(Next, Rgb)> {
        Some((self.vertices.next(i)?, self.vertices.weight(i)?))
    }
}
