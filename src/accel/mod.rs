//! Finding what a ray meets: 8-wide bounding volume hierarchies over triangles, quadrics and
//! instances.
//!
//! A [`Geometry`] has two levels. The top one is in render space and holds shapes and instances;
//! each instance refers to an object with a tree of its own, stored about the object's own centre
//! (its anchor) so that single precision is spent on the object and not on where it stands.

mod aabb;

pub use aabb::Aabb;

use crate::handles::{LightId, MaterialId, ObjectId};
use crate::math::ray::Ray;
use crate::math::transform::Transform;
use crate::params::FloatInput;
use crate::shapes::CompiledShape;
use crate::surface::{SurfaceHit, TexturePoint};

/// What a shape carries besides its geometry.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PrimitiveAttributes {
    /// `None` for a surface that rays pass through (media boundaries).
    pub material: Option<MaterialId>,
    /// First light of the shape: triangle i of a mesh is light `LightId(first.0 + i)`.
    pub light: Option<LightId>,
    /// Hits count only where this is not exactly 0. Quadrics ignore it, as pbrt-v3.
    pub alpha: Option<FloatInput>,
    /// The same, for [`Geometry::occluded`] only.
    pub shadow_alpha: Option<FloatInput>,
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
    /// Distance along the ray.
    pub t: f32,
}

/// Why geometry cannot be built.
#[derive(Debug, thiserror::Error)]
pub enum GeometryError {
    /// Indices have 31 bits, references to leaves 27.
    #[error("too many primitives for one tree: {0}")]
    TooMany(usize),
}

/// Collects the shapes of one named object (`ObjectBegin`), placed by the transformation they
/// had there.
#[derive(Default)]
pub struct ObjectBuilder {}

impl ObjectBuilder {
    /// Adds a shape compiled with its object-to-world transformation.
    pub fn add(&mut self, _shape: CompiledShape, _attributes: PrimitiveAttributes) {
        todo!()
    }
}

/// Collects the top level: shapes in render space, and instances.
#[derive(Default)]
pub struct GeometryBuilder {}

impl GeometryBuilder {
    /// Adds a shape compiled with its object-to-render transformation.
    pub fn add(&mut self, _shape: CompiledShape, _attributes: PrimitiveAttributes) {
        todo!()
    }

    /// Adds a copy of `object` (an index into `build`'s argument). `render_from_object` is
    /// render-from-world times the transformation at `ObjectInstance`.
    pub fn add_instance(&mut self, _object: ObjectId, _render_from_object: &Transform) {
        todo!()
    }

    /// Builds all trees.
    pub fn build(self, _objects: Vec<ObjectBuilder>) -> Result<Geometry, GeometryError> {
        todo!()
    }
}

/// What was built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GeometryStatistics {
    /// Triangles in trees; an object's count once.
    pub triangles: usize,
    /// Quadrics in trees.
    pub quadrics: usize,
    /// Instances.
    pub instances: usize,
    /// Triangles left out: zero area or coordinates that are not finite.
    pub skipped: usize,
    /// 8-wide nodes.
    pub nodes: usize,
    /// Memory of trees and geometry in bytes.
    pub bytes: usize,
}

/// All surfaces of a scene, ready for rays.
pub struct Geometry {}

impl Geometry {
    /// The closest hit nearer than `ray.t_max`. `alpha` evaluates a texture for cut-outs.
    pub fn intersect(
        &self,
        _ray: &Ray,
        _alpha: &impl Fn(&FloatInput, &TexturePoint) -> f32,
    ) -> Option<GeometryHit> {
        todo!()
    }

    /// Is anything hit nearer than `ray.t_max`?
    pub fn occluded(
        &self,
        _ray: &Ray,
        _alpha: &impl Fn(&FloatInput, &TexturePoint) -> f32,
    ) -> bool {
        todo!()
    }

    /// The box around everything, render space; empty for an empty scene.
    pub fn bounds(&self) -> Aabb {
        todo!()
    }

    /// Counts and sizes.
    pub fn statistics(&self) -> GeometryStatistics {
        todo!()
    }
}
