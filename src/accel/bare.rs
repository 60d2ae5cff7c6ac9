//! Triangles of which nothing but the point and the normals are asked, and rays that meet them, side by side.
//!
//! [Flat](super::flat) and [smooth](super::smooth) ones have this in common; and what layers ask of them besides.

use super::level::StoredMesh;
use super::primitive::PrimitiveId;
use super::search::ClosestHit;
use super::{Geometry, PrimitiveAttributes, Standing, Thing};
use crate::math::ray::Ray;
use crate::math::rows::Rows3;
use crate::math::{DVec3, Vec2};
use crate::shapes::triangle::{Orientation, Triangle};

/// A triangle of which nothing but the point is asked, and the normals there.
#[derive(Clone, Copy)]
pub(crate) struct BareTriangle<'a> {
    pub(super) mesh: &'a StoredMesh,
    pub(super) i: usize,
}

impl BareTriangle<'_> {
    /// Returns `true` if there are no normals at its corners.
    #[inline(always)]
    pub(crate) fn is_flat(&self) -> bool {
        self.mesh.normals.is_empty()
    }

    /// Those of its mesh.
    pub(crate) fn attributes(&self) -> &PrimitiveAttributes {
        &self.mesh.attributes
    }
}

impl Geometry {
    /// The triangle that was hit, if nothing but the point and the normals are asked.
    #[inline]
    pub(crate) fn bare_triangle(&self, found: &ClosestHit) -> Option<BareTriangle<'_>> {
        if found.path[0] != PrimitiveId::NONE || !found.id.is_triangle() {
            return None;
        }
        let (mesh, i) = self.top.locate(found.id.index());
        mesh.attributes.bare.then_some(BareTriangle { mesh, i })
    }
}

/// Up to `N` rays, and the triangles that they meet.
pub(crate) struct BareHits<const N: usize> {
    corners: [Rows3<N>; 3],
    o: Rows3<N>,
    d: Rows3<N>,
    found: [Option<ClosestHit>; N],
    /// For layers: what they are of, whether the mesh has no (u, v) of its own, and those that there are then.
    things: [Thing; N],
    is_plain: [bool; N],
    uv: [[f32; N]; 2],
}

impl<const N: usize> Default for BareHits<N> {
    fn default() -> Self {
        BareHits {
            corners: Default::default(),
            o: Rows3::default(),
            d: Rows3::default(),
            found: [None; N],
            things: [Thing::default(); N],
            is_plain: [false; N],
            uv: [[0.0; N]; 2],
        }
    }
}

impl<const N: usize> BareHits<N> {
    /// The hit at `i` is that of `ray` with `triangle`, which a search `found`.
    #[inline(always)]
    pub(super) fn set(
        &mut self,
        i: usize,
        ray: &Ray,
        (triangle, found): (&BareTriangle, &ClosestHit),
    ) {
        self.found[i] = Some(*found);
        let corners = triangle.mesh.corners(triangle.i);
        for (rows, p) in self.corners.iter_mut().zip(corners) {
            rows.set(i, p);
        }
        self.o.set(i, ray.o);
        self.d.set(i, ray.d);
    }

    /// Notes what layers ask of the triangle at `i`.
    #[inline(always)]
    pub(crate) fn note(&mut self, i: usize, triangle: &BareTriangle) {
        let attributes = &triangle.mesh.attributes;
        // Bare triangles are in no instance.
        self.things[i] = Thing::new(attributes.material, Standing::Shape(attributes.shape));
        self.is_plain[i] = triangle.mesh.uv.is_empty();
    }

    /// What a triangle is of that has been [noted](BareHits::note).
    #[inline(always)]
    pub(crate) fn noted(&self, i: usize) -> Thing {
        self.things[i]
    }

    /// The parameters (u, v) of a hit that have been found beside its point; `None` if the mesh has others.
    #[inline(always)]
    pub(crate) fn parameters(&self, i: usize) -> Option<Vec2> {
        self.is_plain[i].then(|| Vec2::new(self.uv[0][i], self.uv[1][i]))
    }

    /// What was found.
    #[inline(always)]
    pub(crate) fn found(&self, i: usize) -> Option<ClosestHit> {
        self.found[i]
    }

    /// The ray at `i`, of no moment.
    #[inline(always)]
    pub(super) fn ray(&self, i: usize) -> Ray {
        Ray::new(self.o.get(i), self.d.get(i), 0.0)
    }

    /// The triangle at `i`, with these normals.
    #[inline(always)]
    pub(super) fn triangle(
        &self,
        i: usize,
        normals: Option<[DVec3; 3]>,
        orientation: Orientation,
    ) -> Triangle {
        let [a, b, c] = &self.corners;
        // Written out: `array::map` is not always inlined.
        let [a, b, c] = [a.get(i), b.get(i), c.get(i)];
        Triangle {
            p: [a.as_dvec3(), b.as_dvec3(), c.as_dvec3()],
            normals,
            tangents: None,
            uv: None,
            orientation,
        }
    }

    /// Sets the parameters (u, v) of a hit at these barycentric coordinates of the [triangle](BareHits::triangle).
    #[inline(always)]
    pub(super) fn set_parameters(&mut self, i: usize, triangle: &Triangle, b: [f64; 3]) {
        let uv = triangle.uv_at(b).as_vec2();
        (self.uv[0][i], self.uv[1][i]) = (uv.x, uv.y);
    }
}
