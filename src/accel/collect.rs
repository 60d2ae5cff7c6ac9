//! Collects what a scene has for its trees.

use super::aabb::Aabb;
use super::curves::CurveStore;
use super::face_ids::FaceIds;
use super::instance::{Inner, Instance};
use super::level::{Level, PARALLEL, StoredMesh, StoredQuadric};
use super::primitive::PrimitiveId;
use super::tree::Tree;
use super::{Geometry, GeometryError, PrimitiveAttributes};
use crate::handles::ObjectId;
use crate::inputs::FloatInput;
use crate::math::DVec3;
use crate::math::motion::Motion;
use crate::math::transform::Transform;
use crate::shapes::CompiledShape;
use crate::shapes::mesh::TriangleMesh;
use rayon::prelude::*;

/// Collects the shapes of a tree: those of the top level in render space, with instances, or those of a named object
/// (`ObjectBegin`), with the transformations that they have there.
#[derive(Default)]
pub struct GeometryBuilder {
    /// Origin of single-precision coordinates.
    anchor: DVec3,
    /// The first shape sets the anchor. Any point of the object will do: no coordinate is then larger than the object.
    needs_anchor: bool,
    meshes: Vec<StoredMesh>,
    face_ids: FaceIds,
    quadrics: Vec<StoredQuadric>,
    curves: CurveStore,
    /// Moving shapes, each with a level of its own.
    moving: Vec<(GeometryBuilder, Motion)>,
    instances: Vec<(ObjectId, u32, Transform)>,
    moving_instances: Vec<(ObjectId, u32, Motion)>,
    instance_count: u32,
    triangles: usize,
    has_recoverable: bool,
    /// See [`GeometryBuilder::of_world`].
    many_rays: bool,
}

impl GeometryBuilder {
    /// For the top level. `many_rays`: rays come mostly in batches, for which a small scene is searched faster without the tree; the hits are the same.
    pub fn of_world(many_rays: bool) -> GeometryBuilder {
        GeometryBuilder {
            many_rays,
            ..GeometryBuilder::default()
        }
    }

    /// For a named object, whose coordinates are relative to a point of its own.
    pub fn of_object() -> GeometryBuilder {
        GeometryBuilder {
            needs_anchor: true,
            ..GeometryBuilder::default()
        }
    }

    /// Adds a shape compiled with its transformation to render space, or to that of the object.
    pub fn add(&mut self, shape: CompiledShape, attributes: PrimitiveAttributes) {
        let (min, max) = match &shape {
            CompiledShape::Mesh(mesh) => mesh.bounds(),
            CompiledShape::Quadric(quadric) => quadric.bounds(),
            CompiledShape::Curves(curves) => curves.bounds(),
        };
        self.stand_at((min + max) * 0.5);
        self.has_recoverable |= attributes.material.is_none() || attributes.shadow_alpha.is_some();
        match shape {
            CompiledShape::Mesh(mesh) => self.add_mesh(*mesh, attributes),
            CompiledShape::Quadric(quadric) => self.quadrics.push(StoredQuadric {
                quadric: quadric.relative_to(self.anchor),
                attributes,
            }),
            CompiledShape::Curves(curves) => {
                self.curves
                    .add(&curves.relative_to(self.anchor), attributes);
            }
        }
    }

    /// Adds a moving shape: compiled without a transformation, and mapped to the space of the others by `motion`.
    pub fn add_moving(
        &mut self,
        shape: CompiledShape,
        attributes: PrimitiveAttributes,
        motion: Motion,
    ) {
        let mut level = GeometryBuilder::of_object();
        level.add(shape, attributes);
        if !level.needs_anchor {
            // Its position at the start of the motion.
            self.stand_at(motion.at(f64::NEG_INFINITY).transform_point3(level.anchor));
        }
        self.moving.push((level, motion.shifted(-self.anchor)));
    }

    /// Adds an instance of `object` (an index into `build`'s argument; others are ignored). `render_from_object` is
    /// render-from-world times the transformation at `ObjectInstance`; a singular one adds nothing.
    pub fn add_instance(&mut self, object: ObjectId, render_from_object: &Transform) {
        let number = self.next_instance();
        self.instances.push((object, number, *render_from_object));
    }

    /// Adds a moving copy of `object`, as [`GeometryBuilder::add_instance`] adds a static one.
    pub fn add_moving_instance(&mut self, object: ObjectId, motion: Motion) {
        let number = self.next_instance();
        self.moving_instances.push((object, number, motion));
    }

    /// Numbers one that is left out.
    pub fn skip_instance(&mut self) {
        self.next_instance();
    }

    /// The number of the next instance.
    fn next_instance(&mut self) -> u32 {
        self.instance_count += 1;
        self.instance_count - 1
    }

    /// Makes `point` the anchor where there is none yet.
    fn stand_at(&mut self, point: DVec3) {
        if self.needs_anchor && point.is_finite() {
            (self.anchor, self.needs_anchor) = (point, false);
        }
    }

    fn add_mesh(&mut self, mesh: TriangleMesh, attributes: PrimitiveAttributes) {
        // A nonzero constant cuts nothing out, and need not be evaluated at every hit.
        let cuts =
            |alpha: &FloatInput| !matches!(alpha, FloatInput::Constant(value) if *value != 0.0);
        let attributes = PrimitiveAttributes {
            alpha: attributes.alpha.filter(cuts),
            shadow_alpha: attributes.shadow_alpha.filter(cuts),
            ..attributes
        };
        let TriangleMesh { data, orientation } = mesh;
        // Checked against the limit before use.
        let first = self.triangles as u32;
        self.triangles += data.indices.len();
        self.face_ids.push(first, data.face_ids);
        let positions = data.positions.par_iter().with_min_len(PARALLEL);
        self.meshes.push(StoredMesh {
            first,
            indices: data.indices.into(),
            positions: positions.map(|&p| (p - self.anchor).as_vec3()).collect(),
            normals: data.normals.into(),
            tangents: data.tangents.into(),
            uv: data.uv.into(),
            orientation,
            attributes,
        });
    }

    /// Builds all trees: this is the top level, which has instances of `objects`.
    pub fn build(self, objects: Vec<GeometryBuilder>) -> Result<Geometry, GeometryError> {
        let objects = objects.into_iter().map(|object| object.level(&[]));
        let objects = objects.collect::<Result<Vec<Level>, _>>()?;
        let many_rays = self.many_rays;
        Ok(Geometry {
            top: self.level(&objects)?.with_few(many_rays),
            objects,
        })
    }

    /// Builds the tree with its instances of `objects`, and the trees of moving shapes.
    pub(super) fn level(self, objects: &[Level]) -> Result<Level, GeometryError> {
        let at_rest = self
            .instances
            .iter()
            .filter_map(|&(object, number, ref transform)| {
                let inner = Inner::Object { object, number };
                Instance::at_rest(inner, objects.get(object.index())?, transform)
            });
        let moving = self
            .moving_instances
            .iter()
            .filter_map(|&(object, number, motion)| {
                let anchor = objects.get(object.index())?.anchor;
                Some(Instance::moving(
                    Inner::Object { object, number },
                    anchor,
                    motion,
                ))
            });
        let mut instances: Vec<Instance> = at_rest.chain(moving).collect();
        for (shape, motion) in self.moving {
            let level = shape.level(&[])?;
            let (anchor, inner) = (level.anchor, Inner::Shape(Box::new(level)));
            instances.push(Instance::moving(inner, anchor, motion));
        }
        let others = self.quadrics.len().max(self.curves.piece_numbers());
        let largest = self.triangles.max(others).max(instances.len());
        if largest >= PrimitiveId::LIMIT {
            return Err(GeometryError::TooMany(largest));
        }
        let boxes: Vec<Aabb> = instances
            .iter()
            .map(|instance| instance.bounds(instance.level(objects)))
            .collect();
        let level = Level {
            anchor: self.anchor,
            meshes: self.meshes,
            mesh_at: Default::default(),
            face_ids: self.face_ids,
            quadrics: self.quadrics,
            curves: self.curves,
            instances,
            has_recoverable: self.has_recoverable,
            radius: 0.0,
            bounds: Aabb::EMPTY,
            skipped: 0,
            few: None,
            tree: Tree::default(),
        };
        level.with_tree(&boxes)
    }
}
