//! The shapes of one tree, stored relative to the tree's anchor.

use super::aabb::Aabb;
use super::builder;
use super::curves::CurveStore;
use super::face_ids::FaceIds;
use super::instance::Instance;
use super::moving::{Inner, Moving};
use super::node::Child;
use super::primitive::{Item, OtherKind, PrimitiveId};
use super::tree::Tree;
use super::{GeometryError, PrimitiveAttributes};
use crate::inputs::FloatInput;
use crate::math::motion::Motion;
use crate::math::{DVec3, Vec2, Vec3};
use crate::shapes::CompiledShape;
use crate::shapes::mesh::TriangleMesh;
use crate::shapes::quadric::Quadric;
use crate::shapes::triangle::{Orientation, Triangle};
use rayon::prelude::*;

/// Anything farther out, infinite or NaN is left out: box areas, which the builder compares, would overflow.
const LARGEST_COORDINATE: f32 = 1e18;

/// Returns `true` if every coordinate is within [`LARGEST_COORDINATE`]. A maximum of the coordinates would not do: it
/// ignores NaN.
fn is_place(p: Vec3) -> bool {
    p.abs().cmple(Vec3::splat(LARGEST_COORDINATE)).all()
}

/// Fewer vertices or triangles than this are not worth splitting between threads.
const PARALLEL: usize = 1 << 12;

/// A mesh rounded to single precision.
pub(super) struct StoredMesh {
    /// Index of its first triangle within the level.
    pub first: u32,
    indices: Box<[[u32; 3]]>,
    positions: Box<[Vec3]>,
    normals: Box<[Vec3]>,
    tangents: Box<[Vec3]>,
    uv: Box<[Vec2]>,
    orientation: Orientation,
    pub attributes: PrimitiveAttributes,
}

impl StoredMesh {
    /// The corners of triangle `i`.
    #[inline]
    fn corners(&self, i: usize) -> [Vec3; 3] {
        self.indices[i].map(|v| self.positions[v as usize])
    }

    /// Triangle `i` with its attributes.
    #[inline]
    pub(super) fn triangle(&self, i: usize) -> Triangle {
        let corners = self.indices[i];
        let at = |values: &[Vec3]| {
            (!values.is_empty()).then(|| corners.map(|v| values[v as usize].as_dvec3()))
        };
        let uv = (!self.uv.is_empty()).then(|| corners.map(|v| self.uv[v as usize].as_dvec2()));
        Triangle {
            p: self.corners(i).map(Vec3::as_dvec3),
            normals: at(&self.normals),
            tangents: at(&self.tangents),
            uv,
            orientation: self.orientation,
        }
    }

    /// Triangle `i` for the builder. The box is empty if the triangle has no area or unusable corners.
    fn item(&self, i: usize) -> Item {
        let corners = self.corners(i);
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let area = (b - a).cross(c - a).length_squared();
        let usable = corners.iter().all(|&p| is_place(p));
        let bounds = if usable && area != 0.0 {
            corners
                .iter()
                .fold(Aabb::EMPTY, |bounds, &p| bounds.with_point(p))
        } else {
            Aabb::EMPTY
        };
        let cut_out = self.attributes.alpha.is_some() || self.attributes.shadow_alpha.is_some();
        Item {
            id: PrimitiveId::triangle(self.first + i as u32, cut_out),
            bounds,
        }
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.indices[..])
            + size_of_val(&self.positions[..])
            + size_of_val(&self.normals[..])
            + size_of_val(&self.tangents[..])
            + size_of_val(&self.uv[..])
    }
}

/// A quadric with its attributes.
pub(super) struct StoredQuadric {
    pub quadric: Quadric,
    pub attributes: PrimitiveAttributes,
}

/// Collects the shapes of a level.
#[derive(Default)]
pub(super) struct LevelBuilder {
    /// Origin of single-precision coordinates; set by the first shape unless given. Any point of the object will do: no
    /// coordinate is then larger than the object.
    anchor: Option<DVec3>,
    meshes: Vec<StoredMesh>,
    face_ids: FaceIds,
    quadrics: Vec<StoredQuadric>,
    curves: CurveStore,
    /// Moving shapes, each with a level of its own.
    moving: Vec<(LevelBuilder, Motion)>,
    triangles: usize,
    has_recoverable: bool,
}

impl LevelBuilder {
    /// A level whose coordinates are relative to the origin.
    pub(super) fn at_origin() -> LevelBuilder {
        LevelBuilder {
            anchor: Some(DVec3::ZERO),
            ..LevelBuilder::default()
        }
    }

    pub(super) fn add(&mut self, shape: CompiledShape, attributes: PrimitiveAttributes) {
        let (min, max) = match &shape {
            CompiledShape::Mesh(mesh) => mesh.bounds(),
            CompiledShape::Quadric(quadric) => quadric.bounds(),
            CompiledShape::Curves(curves) => curves.bounds(),
        };
        let center = (min + max) * 0.5;
        if self.anchor.is_none() && center.is_finite() {
            self.anchor = Some(center);
        }
        let anchor = self.anchor.unwrap_or_default();
        self.has_recoverable |= attributes.material.is_none() || attributes.shadow_alpha.is_some();
        match shape {
            CompiledShape::Mesh(mesh) => self.add_mesh(*mesh, attributes, anchor),
            CompiledShape::Quadric(quadric) => self.quadrics.push(StoredQuadric {
                quadric: quadric.relative_to(anchor),
                attributes,
            }),
            CompiledShape::Curves(curves) => {
                self.curves.add(&curves.relative_to(anchor), attributes);
            }
        }
    }

    /// Adds a shape, compiled in the space that `motion` maps to the level's.
    pub(super) fn add_moving(
        &mut self,
        shape: CompiledShape,
        attributes: PrimitiveAttributes,
        motion: Motion,
    ) {
        let mut level = LevelBuilder::default();
        level.add(shape, attributes);
        if let (None, Some(center)) = (self.anchor, level.anchor) {
            // Its position at the start of the motion.
            self.anchor = Some(motion.at(f64::NEG_INFINITY).transform_point3(center));
        }
        let motion = motion.shifted(-self.anchor.unwrap_or_default());
        self.moving.push((level, motion));
    }

    fn add_mesh(&mut self, mesh: TriangleMesh, attributes: PrimitiveAttributes, anchor: DVec3) {
        // A nonzero constant cuts nothing out, and need not be evaluated at every hit.
        let cuts =
            |alpha: &FloatInput| !matches!(alpha, FloatInput::Constant(value) if *value != 0.0);
        let attributes = PrimitiveAttributes {
            alpha: attributes.alpha.filter(cuts),
            shadow_alpha: attributes.shadow_alpha.filter(cuts),
            ..attributes
        };
        let first = self.triangles;
        self.face_ids.push(first as u32, mesh.face_ids);
        self.triangles += mesh.indices.len();
        self.meshes.push(StoredMesh {
            // Checked against the limit before use.
            first: first as u32,
            indices: mesh.indices.into(),
            positions: mesh
                .positions
                .par_iter()
                .with_min_len(PARALLEL)
                .map(|&p| (p - anchor).as_vec3())
                .collect(),
            normals: mesh.normals.into(),
            tangents: mesh.tangents.into(),
            uv: mesh.uv.into(),
            orientation: mesh.orientation,
            attributes,
        });
    }

    /// Builds the tree, including instances and moving objects, and the trees of moving shapes.
    pub(super) fn build(
        self,
        instances: Vec<(Instance, Aabb)>,
        moving: Vec<(Moving, Aabb)>,
    ) -> Result<Level, GeometryError> {
        let (mut moving, mut moving_boxes): (Vec<Moving>, Vec<Aabb>) = moving.into_iter().unzip();
        for (shape, motion) in self.moving {
            let shape = shape.build(Vec::new(), Vec::new())?;
            let (anchor, bounds) = (shape.anchor, shape.padded_bounds());
            let shape = Moving::new(Inner::Shape(Box::new(shape)), anchor, motion);
            moving_boxes.push(shape.bounds(bounds));
            moving.push(shape);
        }
        let (instances, boxes): (Vec<Instance>, Vec<Aabb>) = instances.into_iter().unzip();
        let others = self.quadrics.len().max(self.curves.piece_numbers());
        let placed = instances.len().max(moving.len());
        let largest = self.triangles.max(others).max(placed);
        if largest >= PrimitiveId::LIMIT {
            return Err(GeometryError::TooMany(largest));
        }
        let mut level = Level {
            anchor: self.anchor.unwrap_or_default(),
            radius: 0.0,
            meshes: self.meshes,
            face_ids: self.face_ids,
            quadrics: self.quadrics,
            curves: self.curves,
            instances,
            moving,
            bounds: Aabb::EMPTY,
            has_recoverable: self.has_recoverable,
            skipped: 0,
            tree: builder::build(&[], |_| [Vec3::ZERO; 3]),
        };
        let items = level.items(&boxes, &moving_boxes);
        level.bounds = items
            .par_iter()
            .with_min_len(PARALLEL)
            .map(|item| item.bounds)
            .reduce(|| Aabb::EMPTY, Aabb::union);
        if !level.bounds.is_empty() {
            level.radius = level
                .bounds
                .min
                .abs()
                .max(level.bounds.max.abs())
                .as_dvec3()
                .length();
        }
        level.tree = builder::build(&items, |id| level.corners(id.index()));
        if level.tree.cells.len() > Child::MAX_CELLS {
            return Err(GeometryError::TooMany(items.len()));
        }
        Ok(level)
    }
}

/// A tree with its shapes.
pub(super) struct Level {
    /// The origin of coordinates.
    pub anchor: DVec3,
    /// Everything is within this distance of the anchor.
    pub radius: f64,
    pub meshes: Vec<StoredMesh>,
    pub face_ids: FaceIds,
    pub quadrics: Vec<StoredQuadric>,
    pub curves: CurveStore,
    pub instances: Vec<Instance>,
    pub moving: Vec<Moving>,
    pub tree: Tree,
    /// Relative to the anchor.
    pub bounds: Aabb,
    /// See [`super::Geometry::has_recoverable_surfaces`].
    pub has_recoverable: bool,
    /// Triangles left out.
    pub skipped: usize,
}

impl Level {
    /// The primitives that the tree is built over. Triangles without area or with unusable corners are skipped and
    /// counted.
    fn items(&mut self, instances: &[Aabb], moving: &[Aabb]) -> Vec<Item> {
        let others = self.quadrics.len() + instances.len() + moving.len();
        let mut items = Vec::with_capacity(self.triangles() + others);
        for mesh in &self.meshes {
            let start = items.len();
            let triangles = 0..mesh.indices.len();
            if triangles.len() < PARALLEL {
                items.extend(triangles.map(|i| mesh.item(i)));
            } else {
                items.par_extend(triangles.into_par_iter().map(|i| mesh.item(i)));
            }
            let unusable = |item: &&Item| item.bounds.is_empty();
            let skipped = items[start..].iter().filter(unusable).count();
            if skipped > 0 {
                self.skipped += skipped;
                items.retain(|item| !item.bounds.is_empty());
            }
        }
        let usable = |b: &Aabb| is_place(b.min) && is_place(b.max);
        for (i, stored) in self.quadrics.iter().enumerate() {
            let (min, max) = stored.quadric.bounds();
            let bounds = Aabb::around(min, max);
            if usable(&bounds) {
                items.push(Item {
                    id: PrimitiveId::other(OtherKind::Quadric, i),
                    bounds,
                });
            }
        }
        for (i, bounds) in self.curves.pieces() {
            // A ray may see a curve outside its box by what both lose in single precision.
            let slack = bounds.min.abs().max(bounds.max.abs()) * (2.0 * f32::EPSILON);
            let bounds = Aabb {
                min: bounds.min - slack,
                max: bounds.max + slack,
            };
            if usable(&bounds) {
                items.push(Item {
                    id: PrimitiveId::other(OtherKind::Curve, i),
                    bounds,
                });
            }
        }
        let placed = [
            (OtherKind::Instance, instances),
            (OtherKind::Moving, moving),
        ];
        for (kind, boxes) in placed {
            for (i, &bounds) in boxes.iter().enumerate() {
                if usable(&bounds) {
                    items.push(Item {
                        id: PrimitiveId::other(kind, i),
                        bounds,
                    });
                }
            }
        }
        items
    }

    /// Corners of the level's box, padded for the rounding of rays that enter it to single precision, which may move
    /// them by that fraction of the distance from the anchor. `None` if the level is empty.
    pub(super) fn padded_bounds(&self) -> Option<(DVec3, DVec3)> {
        if self.bounds.is_empty() {
            return None;
        }
        Some(self.padded(self.bounds))
    }

    /// The padded boxes of the root's children, which together contain everything.
    pub(super) fn padded_parts(&self) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
        self.tree.parts().map(|bounds| self.padded(bounds))
    }

    fn padded(&self, bounds: Aabb) -> (DVec3, DVec3) {
        let margin = DVec3::splat(self.radius * 4.0 * f64::from(f32::EPSILON));
        let [low, high] = [bounds.min.as_dvec3(), bounds.max.as_dvec3()];
        (low - margin, high + margin)
    }

    /// The levels of moving shapes in this one.
    pub(super) fn moving_shapes(&self) -> impl Iterator<Item = &Level> {
        self.moving.iter().filter_map(|m| match &m.inner {
            Inner::Shape(level) => Some(&**level),
            Inner::Object(_) => None,
        })
    }

    /// The number of triangles, including those left out.
    pub(super) fn triangles(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.indices.len()).sum()
    }

    /// The mesh that triangle `id` of the level belongs to, and its index there.
    #[inline]
    pub(super) fn locate(&self, id: usize) -> (&StoredMesh, usize) {
        let after = self
            .meshes
            .partition_point(|mesh| mesh.first as usize <= id);
        // A mesh without triangles shares its first index with the next mesh, which comes after it.
        let mesh = &self.meshes[after - 1];
        (mesh, id - mesh.first as usize)
    }

    /// The attributes of the shape that `id`, a triangle, quadric or curve, belongs to.
    pub(super) fn attributes(&self, id: PrimitiveId) -> &PrimitiveAttributes {
        if id.is_triangle() {
            return &self.locate(id.index()).0.attributes;
        }
        match id.kind() {
            OtherKind::Curve => self.curves.attributes(id.index()),
            _ => &self.quadrics[id.index()].attributes,
        }
    }

    fn corners(&self, id: usize) -> [Vec3; 3] {
        let (mesh, i) = self.locate(id);
        mesh.corners(i)
    }

    /// Memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.tree.bytes()
            + self.meshes.iter().map(StoredMesh::bytes).sum::<usize>()
            + self.face_ids.bytes()
            + self.curves.bytes()
            + size_of_val(&self.meshes[..])
            + size_of_val(&self.quadrics[..])
            + size_of_val(&self.instances[..])
            + size_of_val(&self.moving[..])
    }
}
