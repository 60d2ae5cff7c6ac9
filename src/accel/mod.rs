//! Ray intersection: 8-wide bounding volume hierarchies (BVH) over triangles, quadrics, curves and instances.
//!
//! A [`Geometry`] has two levels. The top one is in render space and holds shapes and instances; each instance refers
//! to an object with a tree of its own, stored relative to the object's own center (its anchor), so that single
//! precision is spent on the object and not on its position. Instances may move; a moving shape is an instance of a tree
//! of its own, and may also be part of an object.

mod aabb;
mod bare;
mod box_test;
mod builder;
mod chunks;
mod collapse;
mod collect;
mod curves;
mod face_ids;
mod few;
mod flat;
mod groups;
mod instance;
mod level;
pub mod memory;
mod node;
mod packet;
mod passage;
mod places;
mod primitive;
mod ray;
mod resolve;
mod search;
mod smooth;
mod stack;
mod thing;
mod tree;
mod validate;
mod watertight;

pub use aabb::Aabb;
pub(crate) use bare::{BareHits, BareTriangle};
pub use collect::GeometryBuilder;
pub(crate) use flat::FlatHits;
pub(crate) use passage::{Crossing, Passage};
pub use search::ClosestHit;
pub(crate) use smooth::SmoothHits;
pub use thing::{Standing, Thing};

use crate::handles::{InterfaceId, LightId, MaterialId};
use crate::inputs::FloatInput;
use crate::math::DVec3;
use crate::math::ray::Ray;
use crate::surface::{SurfaceHit, TexturePoint};
use arrayvec::ArrayVec;
use instance::{Inner, Instance};
use level::Level;
use primitive::PrimitiveId;
use search::Search;

/// The attributes of a shape besides its geometry.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PrimitiveAttributes {
    /// `None` for a surface that rays pass through (media boundaries).
    pub material: Option<MaterialId>,
    /// First light of the shape: triangle i of a mesh is light `LightId(first.0 + i)`, or i/2 where
    /// `paired_lights`.
    pub light: Option<LightId>,
    /// Every two triangles of the mesh are one light; see [`crate::shapes::emitter::Emitter::is_pair`].
    pub paired_lights: bool,
    /// Nothing asks for (u, v) and the derivatives by them at its hits, which are zero there.
    pub bare: bool,
    /// Hits count only where this is not exactly 0. Quadrics ignore it, as in pbrt-v3.
    pub alpha: Option<FloatInput>,
    /// Like `alpha`, for [`Geometry::occluded`] only.
    pub shadow_alpha: Option<FloatInput>,
    /// The interface it forms between media.
    pub interface: Option<InterfaceId>,
    /// Its number among the shapes of the scene, or of its object.
    pub shape: u32,
}

/// The closest hit of a ray.
#[derive(Clone, Copy, Debug)]
pub struct GeometryHit {
    /// The hit point and its local geometry, in render space.
    pub surface: SurfaceHit,
    /// The material there; `None` for a surface that rays pass through.
    pub material: Option<MaterialId>,
    /// The light that emits there.
    pub light: Option<LightId>,
    /// The interface between media there; `None` if both sides are the same.
    pub interface: Option<InterfaceId>,
    /// Distance along the ray.
    pub t: f32,
    /// The shape: see [`PrimitiveAttributes::shape`].
    pub shape: u32,
    /// What was hit, for those who ask more.
    pub found: ClosestHit,
}

/// What a ray that looks for emitters hits.
#[derive(Clone, Copy, Debug)]
pub enum EmitterHit {
    /// Nothing: the ray leaves the scene.
    Escaped,
    /// A surface that does not emit.
    NotEmissive,
    /// A surface that emits.
    Emitter(GeometryHit),
}

/// Why geometry cannot be built.
#[derive(Debug, thiserror::Error)]
pub enum GeometryError {
    /// Primitive indices of each kind have 28 bits, and cell indices of a tree (32 bytes each) 30.
    #[error("too many primitives for one tree: {0}")]
    TooMany(usize),
}

/// Statistics of a built geometry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GeometryStatistics {
    /// Triangles in trees; those of an object count once, however often it is instanced.
    pub triangles: usize,
    /// Quadrics in trees.
    pub quadrics: usize,
    /// Segments of curves in trees.
    pub curve_segments: usize,
    /// Static instances.
    pub instances: usize,
    /// Moving instances and shapes.
    pub moving: usize,
    /// Triangles left out: zero area, or coordinates that are not finite or beyond 1e18.
    pub skipped: usize,
    /// 8-wide nodes.
    pub nodes: usize,
    /// Memory of trees and geometry in bytes.
    pub bytes: usize,
}

/// Evaluates a cut-out texture at a point in render space.
pub trait Alpha: Fn(&FloatInput, &TexturePoint) -> f32 {}

impl<F: Fn(&FloatInput, &TexturePoint) -> f32> Alpha for F {}

/// All surfaces of a scene, ready to be intersected.
pub struct Geometry {
    top: Level,
    objects: Vec<Level>,
}

impl Geometry {
    /// The closest hit nearer than `ray.t_max`.
    pub fn intersect(&self, ray: &Ray, alpha: &impl Alpha) -> Option<GeometryHit> {
        let found = self.closest(ray, alpha)?;
        self.surface(ray, &found, false)
    }

    /// What [`Geometry::intersect`] hits, without the surface there.
    pub fn closest(&self, ray: &Ray, alpha: &impl Alpha) -> Option<ClosestHit> {
        let mut found = [None];
        self.closest_of_all(std::slice::from_ref(ray), alpha, &mut found);
        found[0]
    }

    /// The same along each of the `rays`; `found` has as many places.
    pub fn closest_of_all(
        &self,
        rays: &[Ray],
        alpha: &impl Alpha,
        found: &mut [Option<ClosestHit>],
    ) {
        Search::<_, false>::run(self, rays, alpha, (found, &mut []));
    }

    /// The surface that this ray has hit; with the parameters (u, v) of what has a material, whether or not anything else asks for them, if they are
    /// `wanted`.
    #[inline]
    pub fn surface(&self, ray: &Ray, found: &ClosestHit, wanted: bool) -> Option<GeometryHit> {
        self.resolve(ray, found, wanted)
    }

    /// What was hit, as the scene has it: an instance, or a shape that is in none.
    pub fn standing(&self, hit: &GeometryHit) -> Standing {
        let first = hit.found.path[0];
        if first == PrimitiveId::NONE {
            return Standing::Shape(hit.shape);
        }
        match self
            .top
            .instances
            .get(first.index())
            .map(|instance| &instance.inner)
        {
            Some(Inner::Object { number, .. }) => Standing::Instance(*number),
            Some(Inner::Shape(_)) | None => Standing::Shape(hit.shape),
        }
    }

    /// Returns `true` if what was hit moves.
    pub fn moves_there(&self, found: &ClosestHit) -> bool {
        self.path(found).any(Instance::moves)
    }

    /// Where the point `p` of what was hit at `time`, both in render space, is at other times; `None` if it does not move.
    pub fn moved(
        &self,
        found: &ClosestHit,
        p: DVec3,
        time: f32,
        times: [f32; 2],
    ) -> Option<[DVec3; 2]> {
        let path: ArrayVec<&Instance, 2> = self.path(found).collect();
        if !path.iter().any(|instance| instance.moves()) {
            return None;
        }
        let inward =
            |p, instance: &&Instance| instance.place(time).inner_from_outer.transform_point3(p);
        let inside = path.iter().fold(p, inward);
        Some(times.map(|time| {
            let outward =
                |p, instance: &&Instance| instance.place(time).outer_from_inner.transform_point3(p);
            path.iter().rev().fold(inside, outward)
        }))
    }

    /// The instances that a hit is in, outermost first.
    fn path(&self, found: &ClosestHit) -> impl Iterator<Item = &Instance> {
        let ids = found
            .path
            .into_iter()
            .take_while(|&id| id != PrimitiveId::NONE);
        ids.scan(&self.top, |level, id| {
            let instance = level.instances.get(id.index())?;
            *level = instance.level(&self.objects);
            Some(instance)
        })
    }

    /// Closest hit; the surface is computed only if it emits.
    pub fn intersect_emitter(&self, ray: &Ray, alpha: &impl Alpha) -> EmitterHit {
        let Some(found) = self.closest(ray, alpha) else {
            return EmitterHit::Escaped;
        };
        if self.attributes(&found).light.is_none() {
            return EmitterHit::NotEmissive;
        }
        self.resolve(ray, &found, false)
            .map_or(EmitterHit::Escaped, EmitterHit::Emitter)
    }

    /// Distance to the closest hit, without computing the surface there.
    #[cfg(any(test, feature = "internals"))]
    pub fn distance(&self, ray: &Ray, alpha: &impl Alpha) -> Option<f32> {
        self.closest(ray, alpha).map(|found| found.t)
    }

    /// Returns `true` if anything is hit nearer than `ray.t_max`.
    pub fn occluded(&self, ray: &Ray, alpha: &impl Alpha) -> bool {
        let mut found = [None];
        self.occluders(std::slice::from_ref(ray), alpha, &mut found);
        found[0].is_some()
    }

    /// Something on each of the `rays` nearer than its end, if there is anything; `found` has as many places.
    pub fn occluders(&self, rays: &[Ray], alpha: &impl Alpha, found: &mut [Option<ClosestHit>]) {
        Search::<_, true>::run(self, rays, alpha, (found, &mut []));
    }

    /// As [`Geometry::occluders`], but surfaces without material block nothing: `passages`, of which there are as many, tell of those where media
    /// may change. Cut-outs for shadow rays only do not count.
    pub(crate) fn passages(
        &self,
        rays: &[Ray],
        alpha: &impl Alpha,
        (found, passages): (&mut [Option<ClosestHit>], &mut [Passage]),
    ) {
        Search::<_, true>::run(self, rays, alpha, (found, passages));
    }

    /// Returns `true` if there is any surface without material, or with a cut-out for shadow rays only. If not,
    /// [`Geometry::occluded`] is also right for light that passes through surfaces without material.
    pub fn has_recoverable_surfaces(&self) -> bool {
        self.levels().any(|level| level.has_recoverable)
    }

    /// Returns `true` if there are curves, whose normals turn with the rays that meet them.
    pub fn has_curves(&self) -> bool {
        self.levels().any(|level| level.curves.segments() > 0)
    }

    /// All levels: those of shapes that move by themselves among them.
    fn levels(&self) -> impl Iterator<Item = &Level> {
        let levels = self.objects.iter().chain([&self.top]);
        levels.flat_map(|level| level.moving_shapes().chain([level]))
    }

    /// Returns `true` if anything moves.
    pub fn moves(&self) -> bool {
        let mut levels = self.objects.iter().chain([&self.top]);
        levels.any(|level| level.instances.iter().any(Instance::moves))
    }

    /// Bounding box of the scene, in render space; empty for an empty scene.
    pub fn bounds(&self) -> Aabb {
        self.top.bounds
    }

    /// Counts and memory.
    pub fn statistics(&self) -> GeometryStatistics {
        let mut statistics = GeometryStatistics::default();
        for level in self.levels() {
            statistics.triangles += level.triangles() - level.skipped;
            statistics.quadrics += level.quadrics.len();
            statistics.curve_segments += level.curves.segments();
            let moving = level.instances.iter().filter(|i| i.moves()).count();
            statistics.moving += moving;
            statistics.instances += level.instances.len() - moving;
            statistics.skipped += level.skipped;
            statistics.nodes += level.tree.nodes;
            statistics.bytes += level.bytes();
        }
        statistics
    }
}

#[cfg(test)]
mod tests;
