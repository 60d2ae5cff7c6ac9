//! The shapes of one tree, stored relative to the tree's anchor.

use super::aabb::Aabb;
use super::builder;
use super::curves::CurveStore;
use super::face_ids::FaceIds;
use super::few::Few;
use super::instance::{Inner, Instance};
use super::node::Child;
use super::primitive::{Item, OtherKind, PrimitiveId};
use super::tree::Tree;
use super::{GeometryError, PrimitiveAttributes};
use crate::math::{DVec3, Vec2, Vec3};
use crate::shapes::ball::Ball;
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
pub(super) const PARALLEL: usize = 1 << 12;

/// Triangles for each entry of [`Level::mesh_at`]: half a byte a triangle, and few steps to the mesh of any.
const STRIDE: usize = 8;

/// A mesh rounded to single precision.
pub(super) struct StoredMesh {
    /// Index of its first triangle within the level.
    pub first: u32,
    pub indices: Box<[[u32; 3]]>,
    pub positions: Box<[Vec3]>,
    pub normals: Box<[Vec3]>,
    pub tangents: Box<[Vec3]>,
    pub uv: Box<[Vec2]>,
    pub orientation: Orientation,
    pub attributes: PrimitiveAttributes,
}

impl StoredMesh {
    /// The corners of triangle `i`.
    #[inline]
    pub(super) fn corners(&self, i: usize) -> [Vec3; 3] {
        self.indices[i].map(|v| self.positions[v as usize])
    }

    /// What of a list for vertices is at the corners of triangle `i`; `None` if there is no list.
    #[inline(always)]
    fn at_corners(&self, i: usize, values: &[Vec3]) -> Option<[DVec3; 3]> {
        let [a, b, c] = self.indices[i].map(|v| v as usize);
        (!values.is_empty()).then(|| [values[a], values[b], values[c]].map(Vec3::as_dvec3))
    }

    /// Triangle `i` with its normals alone.
    #[inline(always)]
    pub(super) fn bare_triangle(&self, i: usize) -> Triangle {
        Triangle {
            p: self.corners(i).map(Vec3::as_dvec3),
            normals: self.at_corners(i, &self.normals),
            tangents: None,
            uv: None,
            orientation: self.orientation,
        }
    }

    /// Triangle `i` with its normals and its parameters (u, v).
    #[inline(always)]
    pub(super) fn parametric_triangle(&self, i: usize) -> Triangle {
        let corners = self.indices[i];
        Triangle {
            uv: (!self.uv.is_empty()).then(|| corners.map(|v| self.uv[v as usize].as_dvec2())),
            ..self.bare_triangle(i)
        }
    }

    /// Triangle `i` with its attributes.
    #[inline]
    pub(super) fn triangle(&self, i: usize) -> Triangle {
        Triangle {
            tangents: self.at_corners(i, &self.tangents),
            ..self.parametric_triangle(i)
        }
    }

    /// Triangle `i` for the builder. The box is empty if the triangle has no area or unusable corners.
    fn item(&self, i: usize) -> Item {
        let corners = self.corners(i);
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let area = (b - a).cross(c - a).length_squared();
        let usable = corners.iter().all(|&p| is_place(p));
        let bounds = if usable && area != 0.0 {
            corners.into_iter().fold(Aabb::EMPTY, Aabb::with_point)
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

/// Those primitives of a kind, numbered and with their boxes, that are at a place.
fn usable(
    kind: OtherKind,
    boxes: impl Iterator<Item = (usize, Aabb)>,
) -> impl Iterator<Item = Item> {
    boxes
        .filter(|(_, bounds)| is_place(bounds.min) && is_place(bounds.max))
        .map(move |(i, bounds)| Item {
            id: PrimitiveId::other(kind, i),
            bounds,
        })
}

/// A tree with its shapes.
pub(super) struct Level {
    /// The origin of coordinates.
    pub anchor: DVec3,
    /// Everything is within this distance of the anchor.
    pub radius: f64,
    pub meshes: Vec<StoredMesh>,
    /// The mesh of every [`STRIDE`]th triangle.
    pub mesh_at: Box<[u32]>,
    pub face_ids: FaceIds,
    pub quadrics: Vec<StoredQuadric>,
    pub curves: CurveStore,
    pub instances: Vec<Instance>,
    pub tree: Tree,
    /// All that there is, if it is little and this is the top level: then rays do not walk the tree.
    pub few: Option<Few>,
    /// Relative to the anchor.
    pub bounds: Aabb,
    /// See [`super::Geometry::has_recoverable_surfaces`].
    pub has_recoverable: bool,
    /// Triangles left out.
    pub skipped: usize,
}

impl Level {
    /// The level with its tree, in which its instances have the given boxes.
    pub(super) fn with_tree(mut self, instances: &[Aabb]) -> Result<Level, GeometryError> {
        self.mesh_at = self.meshes_by_triangle();
        let items = self.items(instances);
        let bounds = items.par_iter().with_min_len(PARALLEL);
        self.bounds = bounds
            .map(|item| item.bounds)
            .reduce(|| Aabb::EMPTY, Aabb::union);
        if !self.bounds.is_empty() {
            let farthest = self.bounds.min.abs().max(self.bounds.max.abs());
            self.radius = farthest.as_dvec3().length();
        }
        let count = items.len();
        self.tree = builder::build(items, |id| self.corners(id.index()));
        if self.tree.cells.len() > Child::MAX_CELLS {
            return Err(GeometryError::TooMany(count));
        }
        Ok(self)
    }

    /// The level with what spares rays its tree, if there is little in it: with quadrics only where rays are asked many at a time, as one ray is
    /// better off with the tree.
    pub(super) fn with_few(mut self, many_rays: bool) -> Level {
        let may_be = self.instances.is_empty() && (many_rays || self.quadrics.is_empty());
        if may_be && self.triangles() <= Few::MOST {
            let items = self.items(&[]);
            let quadric = |id: PrimitiveId| &self.quadrics[id.index()].quadric;
            self.few = Few::of(&items, |id| self.corners(id.index()), quadric);
        }
        self
    }

    /// The primitives that the tree is built over. Triangles without area or with unusable corners are skipped and
    /// counted.
    fn items(&mut self, instances: &[Aabb]) -> Vec<Item> {
        let others = self.quadrics.len() + instances.len();
        let mut items = Vec::with_capacity(self.triangles() + others);
        for mesh in &self.meshes {
            let triangles = 0..mesh.indices.len();
            if triangles.len() < PARALLEL {
                items.extend(triangles.map(|i| mesh.item(i)));
            } else {
                items.par_extend(triangles.into_par_iter().map(|i| mesh.item(i)));
            }
        }
        items.retain(|item| !item.bounds.is_empty());
        self.skipped = self.triangles() - items.len();
        let quadrics = self.quadrics.iter().map(|stored| stored.quadric.bounds());
        let quadrics = quadrics
            .map(|(min, max)| Aabb::around(min, max))
            .enumerate();
        items.extend(usable(OtherKind::Quadric, quadrics));
        items.extend(usable(OtherKind::Curve, self.curves.pieces()));
        let instances = instances.iter().copied().enumerate();
        items.extend(usable(OtherKind::Instance, instances));
        items
    }

    /// Corners of the level's box, padded for the rounding of rays that enter it to single precision, which may move
    /// them by that fraction of the distance from the anchor. `None` if the level is empty.
    pub(super) fn padded_bounds(&self) -> Option<(DVec3, DVec3)> {
        (!self.bounds.is_empty()).then(|| self.padded(self.bounds))
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
        self.instances.iter().filter_map(|i| match &i.inner {
            Inner::Shape(level) => Some(&**level),
            Inner::Object { .. } => None,
        })
    }

    /// The number of triangles, including those left out.
    pub(super) fn triangles(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.indices.len()).sum()
    }

    fn meshes_by_triangle(&self) -> Box<[u32]> {
        let mesh_of = |id: usize| {
            self.meshes
                .partition_point(|mesh| mesh.first as usize <= id)
                - 1
        };
        let ids = (0..self.triangles()).step_by(STRIDE);
        ids.map(|id| mesh_of(id) as u32).collect()
    }

    /// The mesh that triangle `id` of the level belongs to, and its index there.
    #[inline]
    pub(super) fn locate(&self, id: usize) -> (&StoredMesh, usize) {
        let mut at = self.mesh_at[id / STRIDE] as usize;
        // A mesh without triangles shares its first index with the next mesh, which comes after it.
        while let Some(next) = self.meshes.get(at + 1)
            && next.first as usize <= id
        {
            at += 1;
        }
        let mesh = &self.meshes[at];
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

    /// The quadric `id`, if it is a whole sphere.
    pub(super) fn ball(&self, id: PrimitiveId) -> Option<&Ball> {
        let is_quadric = id.is_other() && id.kind() == OtherKind::Quadric;
        is_quadric.then(|| self.quadrics[id.index()].quadric.ball())?
    }

    fn corners(&self, id: usize) -> [Vec3; 3] {
        let (mesh, i) = self.locate(id);
        mesh.corners(i)
    }

    /// Memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.tree.bytes()
            + self.few.as_ref().map_or(0, Few::bytes)
            + self.meshes.iter().map(StoredMesh::bytes).sum::<usize>()
            + self.face_ids.bytes()
            + size_of_val(&self.mesh_at[..])
            + self.curves.bytes()
            + size_of_val(&self.meshes[..])
            + size_of_val(&self.quadrics[..])
            + size_of_val(&self.instances[..])
    }
}
