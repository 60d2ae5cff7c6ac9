//! Vertices on flat triangles that are matte everywhere, the commonest: their points are found, and directions chosen, side by side.

use super::vertex::FlatVertex;
use super::weights::History;
use crate::accel::{ClosestHit, FlatHits};
use crate::bsdf::Matte;
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
    rays: ArrayVec<Ray, WAVE>,
    /// What is known of each before a direction is chosen: `None` where the path ends.
    known: ArrayVec<Option<History>, WAVE>,
}

impl Flats {
    pub(super) fn clear(&mut self) {
        self.vertices.clear();
        self.rays.clear();
        self.known.clear();
    }

    pub(super) fn count(&self) -> usize {
        self.vertices.count()
    }

    /// Takes up what a path's ray has hit if it is of a flat triangle that is matte everywhere, and emits nothing.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        world: &World,
        (path, ray): (u32, &Ray),
        found: &ClosestHit,
        throughput: Rgb,
    ) -> bool {
        let Some(triangle) = world.geometry.bare_triangle(found) else {
            return false;
        };
        let attributes = triangle.attributes();
        if attributes.light.is_some() || !triangle.is_flat() {
            return false;
        }
        let Some(reflectance) = world.even_reflectance(attributes.material) else {
            return false;
        };
        self.hits.set(self.count(), ray, (&triangle, found));
        self.vertices.add_flat(path, reflectance, throughput);
        self.rays.push(*ray);
        true
    }

    /// Finds all points.
    pub(super) fn resolve(&mut self, world: &World) {
        let count = self.count();
        self.hits.resolve(count);
        self.vertices.place(&self.hits);
        for i in 0..count {
            if let Some(found) = self.hits.grazing(i)
                && let Some(hit) = world.surface(&self.rays[i], &found)
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
        let ray = &self.rays[i];
        let vertex = self.vertices.vertex(i, ray.time);
        FlatVertex {
            from: vertex.from,
            matte: vertex.scatterer,
            wo: -ray.d,
        }
    }

    /// What is known of the next vertex: its path continues in a direction that these numbers choose, or ends.
    pub(super) fn know(&mut self, onward: Option<(History, Vec2)>) {
        if let Some((_, u)) = onward {
            self.vertices.set_number(self.known.len(), u);
        }
        self.known.push(onward.map(|(history, _)| history));
    }

    /// Chooses all directions.
    pub(super) fn sample(&mut self) {
        self.vertices.sample();
    }

    /// What was known of vertex `i`, if its path was to continue.
    pub(super) fn history(&self, i: usize) -> Option<&History> {
        self.known[i].as_ref()
    }

    /// How the path of vertex `i` continues, and what its throughput was multiplied by.
    pub(super) fn next(&self, i: usize) -> Option<(Next, Rgb)> {
        Some((self.vertices.next(i)?, self.vertices.weight(i)?))
    }
}
