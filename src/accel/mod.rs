//! Finding what a ray meets: 8-wide bounding volume hierarchies over triangles, quadrics, curves
//! and instances.
//!
//! A [`Geometry`] has two levels. The top one is in render space and holds shapes and instances;
//! each instance refers to an object with a tree of its own, stored about the object's own center
//! (its anchor) so that single precision is spent on the object and not on where it stands. What
//! moves is a kind of its own beside instances, and may also be in an object.

mod aabb;
mod box_test;
mod builder;
mod collapse;
mod curves;
mod face_ids;
mod groups;
mod instance;
mod level;
mod moving;
mod node;
mod packet;
mod pages;
mod primitive;
mod ray;
mod search;
mod stack;
mod tree;
mod validate;

pub use aabb::Aabb;

use crate::handles::{InterfaceId, LightId, MaterialId, ObjectId};
use crate::inputs::FloatInput;
use crate::math::DVec3;
use crate::math::motion::Motion;
use crate::math::ray::Ray;
use crate::math::transform::Transform;
use crate::shapes::CompiledShape;
use crate::shapes::local::LocalSurface;
use crate::surface::{SurfaceHit, TexturePoint};
use instance::{Instance, Place};
use level::{Level, LevelBuilder};
use moving::{Inner, Moving};
use primitive::{OtherKind, PrimitiveId};
use search::{ClosestHit, Search};

/// What a shape carries besides its geometry.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PrimitiveAttributes {
    /// `None` for a surface that rays pass through (media boundaries).
    pub material: Option<MaterialId>,
    /// First light of the shape: triangle i of a mesh is light `LightId(first.0 + i)`, or i/2 where
    /// `paired_lights`.
    pub light: Option<LightId>,
    /// Is every two triangles of the mesh one light? See [`crate::shapes::emitter::Emitter::faces_per_piece`].
    pub paired_lights: bool,
    /// Hits count only where this is not exactly 0. Quadrics ignore it, as pbrt-v3.
    pub alpha: Option<FloatInput>,
    /// The same, for [`Geometry::occluded`] only.
    pub shadow_alpha: Option<FloatInput>,
    /// The border it makes between media.
    pub interface: Option<InterfaceId>,
}

/// The closest hit of a ray.
#[derive(Clone, Copy, Debug)]
pub struct GeometryHit {
    /// The point and its surroundings, render space.
    pub surface: SurfaceHit,
    /// The material there; `None` for a surface that rays pass through.
    pub material: Option<MaterialId>,
    /// The light that shines from there.
    pub light: Option<LightId>,
    /// The border between media there; `None` where both sides are the same.
    pub interface: Option<InterfaceId>,
    /// Distance along the ray.
    pub t: f32,
}

/// What a ray meets that looks for light.
#[derive(Clone, Copy, Debug)]
pub enum EmitterHit {
    /// Nothing: it leaves the scene.
    Escaped,
    /// A surface that does not shine.
    NotEmissive,
    /// A surface with a light.
    Emitter(GeometryHit),
}

/// Why geometry cannot be built.
#[derive(Debug, thiserror::Error)]
pub enum GeometryError {
    /// Numbers of primitives of a kind have 28 bits, and places in a tree (of 32 bytes) 30.
    #[error("too many primitives for one tree: {0}")]
    TooMany(usize),
}

/// Collects the shapes of one named object (`ObjectBegin`), placed by the transformation they
/// had there.
#[derive(Default)]
pub struct ObjectBuilder {
    level: LevelBuilder,
}

impl ObjectBuilder {
    /// Adds a shape compiled with its object-to-world transformation.
    pub fn add(&mut self, shape: CompiledShape, attributes: PrimitiveAttributes) {
        self.level.add(shape, attributes);
    }

    /// Adds a shape that moves: compiled without a transformation, and taken to the object's space
    /// by `motion`.
    pub fn add_moving(
        &mut self,
        shape: CompiledShape,
        attributes: PrimitiveAttributes,
        motion: Motion,
    ) {
        self.level.add_moving(shape, attributes, motion);
    }
}

/// Collects the top level: shapes in render space, and instances.
pub struct GeometryBuilder {
    level: LevelBuilder,
    instances: Vec<(ObjectId, Transform)>,
    moving: Vec<(ObjectId, Motion)>,
}

impl Default for GeometryBuilder {
    fn default() -> GeometryBuilder {
        GeometryBuilder {
            level: LevelBuilder::at_origin(),
            instances: Vec::new(),
            moving: Vec::new(),
        }
    }
}

impl GeometryBuilder {
    /// Adds a shape compiled with its object-to-render transformation.
    pub fn add(&mut self, shape: CompiledShape, attributes: PrimitiveAttributes) {
        self.level.add(shape, attributes);
    }

    /// Adds a shape that moves: compiled without a transformation, and taken to render space by
    /// `motion`.
    pub fn add_moving(
        &mut self,
        shape: CompiledShape,
        attributes: PrimitiveAttributes,
        motion: Motion,
    ) {
        self.level.add_moving(shape, attributes, motion);
    }

    /// Adds a copy of `object` that moves, as [`GeometryBuilder::add_instance`] one that stands.
    pub fn add_moving_instance(&mut self, object: ObjectId, motion: Motion) {
        self.moving.push((object, motion));
    }

    /// Adds a copy of `object` (an index into `build`'s argument; others are ignored).
    /// `render_from_object` is render-from-world times the transformation at `ObjectInstance`;
    /// one that is singular makes nothing.
    pub fn add_instance(&mut self, object: ObjectId, render_from_object: &Transform) {
        self.instances.push((object, *render_from_object));
    }

    /// Builds all trees.
    pub fn build(self, objects: Vec<ObjectBuilder>) -> Result<Geometry, GeometryError> {
        let objects = objects
            .into_iter()
            .map(|object| object.level.build(Vec::new(), Vec::new()))
            .collect::<Result<Vec<Level>, _>>()?;
        let level = |id: &ObjectId| objects.get(id.index());
        let stand = |(id, transform): &(ObjectId, Transform)| {
            let level = level(id)?;
            let instance = Instance::new(*id, level, transform)?;
            let bounds = instance.bounds(level);
            Some((instance, bounds))
        };
        let instances = self.instances.iter().filter_map(stand).collect();
        let moves = |&(id, motion): &(ObjectId, Motion)| {
            let level = level(&id)?;
            let moving = Moving::new(Inner::Object(id), level.anchor, motion);
            let bounds = moving.bounds(level.padded_bounds());
            Some((moving, bounds))
        };
        let moving = self.moving.iter().filter_map(moves).collect();
        Ok(Geometry {
            top: self.level.build(instances, moving)?,
            objects,
        })
    }
}

/// What was built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GeometryStatistics {
    /// Triangles in trees; those of an object once, however often it is instanced.
    pub triangles: usize,
    /// Quadrics in trees.
    pub quadrics: usize,
    /// Segments of curves in trees.
    pub curve_segments: usize,
    /// Instances that stand.
    pub instances: usize,
    /// Instances and shapes that move.
    pub moving: usize,
    /// Triangles left out: zero area, or coordinates that are not finite or beyond 1e18.
    pub skipped: usize,
    /// 8-wide nodes.
    pub nodes: usize,
    /// Memory of trees and geometry in bytes.
    pub bytes: usize,
}

/// All surfaces of a scene, ready for rays.
pub struct Geometry {
    top: Level,
    objects: Vec<Level>,
}

impl Geometry {
    /// The closest hit nearer than `ray.t_max`. `alpha` evaluates a texture for cut-outs, at
    /// points in render space.
    pub fn intersect(
        &self,
        ray: &Ray,
        alpha: &impl Fn(&FloatInput, &TexturePoint) -> f32,
    ) -> Option<GeometryHit> {
        let found = Search::<_, false>::run(self, ray, alpha)?;
        self.resolve(ray, &found)
    }

    /// The closest hit, for someone who asks for nothing but its light: surfaces without one are not worked out.
    pub fn intersect_emitter(
        &self,
        ray: &Ray,
        alpha: &impl Fn(&FloatInput, &TexturePoint) -> f32,
    ) -> EmitterHit {
        let Some(found) = Search::<_, false>::run(self, ray, alpha) else {
            return EmitterHit::Escaped;
        };
        let innermost = found.path.into_iter().filter(|&id| id != PrimitiveId::NONE);
        let level = innermost.fold(&self.top, |level, id| self.inside(level, id));
        if level.attributes(found.id).light.is_none() {
            return EmitterHit::NotEmissive;
        }
        self.resolve(ray, &found)
            .map_or(EmitterHit::Escaped, EmitterHit::Emitter)
    }

    /// The level that an instance, or something that moves, of `level` holds.
    fn inside<'a>(&'a self, level: &'a Level, id: PrimitiveId) -> &'a Level {
        if id.kind() == OtherKind::Instance {
            return &self.objects[level.instances[id.index()].object.index()];
        }
        match &level.moving[id.index()].inner {
            Inner::Shape(level) => level,
            Inner::Object(object) => &self.objects[object.index()],
        }
    }

    /// How far along the ray that hit is, without the surface there.
    pub fn distance(
        &self,
        ray: &Ray,
        alpha: &impl Fn(&FloatInput, &TexturePoint) -> f32,
    ) -> Option<f32> {
        Search::<_, false>::run(self, ray, alpha).map(|found| found.t)
    }

    /// Is anything hit nearer than `ray.t_max`?
    pub fn occluded(&self, ray: &Ray, alpha: &impl Fn(&FloatInput, &TexturePoint) -> f32) -> bool {
        Search::<_, true>::run(self, ray, alpha).is_some()
    }

    /// Is there any surface without material, or with a cut-out for shadow rays only? Where there is
    /// none, [`Geometry::occluded`] answers for light that passes surfaces without material too.
    pub fn has_recoverable_surfaces(&self) -> bool {
        let mut levels = self.objects.iter().chain([&self.top]);
        levels.any(|level| level.has_recoverable)
    }

    /// Works out the surface that a search found.
    #[inline]
    fn resolve(&self, ray: &Ray, found: &ClosestHit) -> Option<GeometryHit> {
        let (o, d) = (ray.o.as_dvec3(), ray.d.as_dvec3());
        if found.path[0] == PrimitiveId::NONE && found.id.is_triangle() {
            // What most rays meet; nothing is copied on its way to the answer.
            let (local, attributes, light) = resolve_triangle(&self.top, o, d, found);
            return Some(hit(&local, attributes, light, ray, found));
        }
        let (local, attributes, light) = self.resolve_along(&self.top, o, d, found, ray.time)?;
        Some(hit(&local, attributes, light, ray, found))
    }

    /// The same in the space of `level`, from where the path of `found` starts.
    fn resolve_along<'a>(
        &'a self,
        level: &'a Level,
        o: DVec3,
        d: DVec3,
        found: &ClosestHit,
        time: f32,
    ) -> Option<Resolved<'a>> {
        let [next, rest] = found.path;
        if next == PrimitiveId::NONE {
            return resolve_in(level, o, d, found);
        }
        let place: Place = match next.kind() {
            OtherKind::Instance => level.instances[next.index()].place,
            _ => level.moving[next.index()].place(time),
        };
        let inside = self.inside(level, next);
        let inner = place.enter(o, d, inside);
        let found = ClosestHit {
            path: [rest, PrimitiveId::NONE],
            ..*found
        };
        // Further in, the ray as the search had it.
        let (o, d) = if rest == PrimitiveId::NONE {
            (inner.o, inner.d)
        } else {
            (inner.o.as_vec3().as_dvec3(), inner.d.as_vec3().as_dvec3())
        };
        let (local, attributes, light) = self.resolve_along(inside, o, d, &found, time)?;
        let outer = local.transformed(&place.outer_from_inner, &place.inner_from_outer);
        Some((outer, attributes, light))
    }

    /// The box around everything, render space; empty for an empty scene.
    pub fn bounds(&self) -> Aabb {
        self.top.bounds
    }

    /// Counts and sizes.
    pub fn statistics(&self) -> GeometryStatistics {
        let mut statistics = GeometryStatistics {
            instances: self.top.instances.len(),
            ..GeometryStatistics::default()
        };
        let levels = self.objects.iter().chain([&self.top]);
        for level in levels.flat_map(|level| level.moving_shapes().chain([level])) {
            statistics.triangles += level.triangles() - level.skipped;
            statistics.quadrics += level.quadrics.len();
            statistics.curve_segments += level.curves.segments();
            statistics.moving += level.moving.len();
            statistics.skipped += level.skipped;
            statistics.nodes += level.tree.nodes;
            statistics.bytes += level.bytes();
        }
        statistics
    }
}

/// A surface, what it carries and the light that shines from it.
type Resolved<'a> = (LocalSurface, &'a PrimitiveAttributes, Option<LightId>);

/// The hit of `ray` that a resolved surface makes.
#[inline]
fn hit(
    local: &LocalSurface,
    attributes: &PrimitiveAttributes,
    light: Option<LightId>,
    ray: &Ray,
    found: &ClosestHit,
) -> GeometryHit {
    GeometryHit {
        surface: local.hit(ray),
        material: attributes.material,
        light,
        interface: attributes.interface,
        t: found.t,
    }
}

/// The surface in the space of `level` where the line `o + t d` meets the triangle that was found.
#[inline(always)]
fn resolve_triangle<'a>(level: &'a Level, o: DVec3, d: DVec3, found: &ClosestHit) -> Resolved<'a> {
    let (mesh, i) = level.locate(found.id.index());
    let triangle = mesh.triangle(i);
    // A ray within the plane of the triangle: any point of it is as good.
    let b = triangle.barycentrics(o, d).unwrap_or([1.0 / 3.0; 3]);
    let light = mesh
        .attributes
        .light
        .map(|first| LightId(first.0 + (i as u32 >> u32::from(mesh.attributes.paired_lights))));
    let mut surface = triangle.surface(b);
    surface.face = level.face_ids.of(mesh.first, i);
    (surface, &mesh.attributes, light)
}

/// The surface in the space of `level` where the line `o + t d` meets what was found.
fn resolve_in<'a>(
    level: &'a Level,
    o: DVec3,
    d: DVec3,
    found: &ClosestHit,
) -> Option<Resolved<'a>> {
    if found.id.is_triangle() {
        return Some(resolve_triangle(level, o, d, found));
    }
    let i = found.id.index();
    // The ray as the search had it, so that the same point is found again.
    let (o, d) = (o.as_vec3().as_dvec3(), d.as_vec3().as_dvec3());
    if found.id.kind() == OtherKind::Curve {
        return level.curves.surface(i, o, d);
    }
    let stored = &level.quadrics[i];
    let (_, p) = stored.quadric.intersect(o, d)?;
    Some((
        stored.quadric.surface(p),
        &stored.attributes,
        stored.attributes.light,
    ))
}

#[cfg(test)]
mod tests;
