//! Hits of flat triangles, resolved side by side: most hits, in most scenes, where nothing asks for (u, v).
//!
//! The function that serves a single hit is run in a loop over rows of numbers that has no branch, so that it is compiled to vector
//! instructions ([`crate::math::instruction_set`]). Bits are those of one at a time.

use super::level::StoredMesh;
use super::primitive::PrimitiveId;
use super::search::ClosestHit;
use super::{Geometry, PrimitiveAttributes, Standing};
use crate::handles::MaterialId;
#[cfg(test)]
use crate::math::instruction_set::InstructionSet;
use crate::math::instruction_set::{Instructions, Kernel, vectorize};
use crate::math::ray::Ray;
use crate::math::rows::Rows3;
use crate::math::{Vec2, Vec3};
use crate::shapes::local::Local;
use crate::shapes::triangle::{Orientation, Triangle};

/// Loops run over whole vectors of the widest kind.
const WHOLE: usize = 16;

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

    /// The parameters (u, v) of where `ray` meets it, those of its whole [`crate::surface::SurfaceHit`].
    pub(crate) fn parameters(&self, ray: &Ray) -> Vec2 {
        let triangle = self.mesh.triangle(self.i);
        let b = triangle.nearest(ray.o.as_dvec3(), ray.d.as_dvec3());
        triangle.uv_at(b).as_vec2()
    }
}

impl Geometry {
    /// The triangle that was hit, if it is flat, and nothing but the point is asked.
    #[inline]
    pub(crate) fn flat(&self, found: &ClosestHit) -> Option<BareTriangle<'_>> {
        self.bare_triangle(found).filter(BareTriangle::is_flat)
    }

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

/// Where up to `N` rays meet flat triangles.
pub(crate) struct FlatHits<const N: usize> {
    corners: [Rows3<N>; 3],
    o: Rows3<N>,
    d: Rows3<N>,
    found: [Option<ClosestHit>; N],
    /// Below 0 where the normal of the corners' order is to be turned.
    side: [f32; N],
    p: Rows3<N>,
    p_error: Rows3<N>,
    n: Rows3<N>,
    is_grazing: [u32; N],
    /// For layers: materials, whether the mesh has no (u, v) of its own, and those that there are then.
    materials: [Option<MaterialId>; N],
    shapes: [u32; N],
    is_plain: [bool; N],
    uv: [[f32; N]; 2],
}

impl<const N: usize> Default for FlatHits<N> {
    fn default() -> Self {
        FlatHits {
            corners: Default::default(),
            o: Rows3::default(),
            d: Rows3::default(),
            found: [None; N],
            side: [0.0; N],
            p: Rows3::default(),
            p_error: Rows3::default(),
            n: Rows3::default(),
            is_grazing: [0; N],
            materials: [None; N],
            shapes: [0; N],
            is_plain: [false; N],
            uv: [[0.0; N]; 2],
        }
    }
}

impl<const N: usize> FlatHits<N> {
    /// The hit at `i` is that of `ray` with `triangle`, which a search `found`.
    #[inline(always)]
    pub(crate) fn set(
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
        let turned = triangle.mesh.orientation.flip_geometric;
        self.side[i] = if turned { -1.0 } else { 1.0 };
    }

    /// Notes what layers ask of the triangle at `i`.
    #[inline(always)]
    pub(crate) fn note(&mut self, i: usize, triangle: &BareTriangle) {
        self.materials[i] = triangle.mesh.attributes.material;
        self.shapes[i] = triangle.mesh.attributes.shape;
        self.is_plain[i] = triangle.mesh.uv.is_empty();
    }

    /// The material and the shape of a triangle that has been [noted](FlatHits::note): flat ones are in no instance.
    #[inline(always)]
    pub(crate) fn noted(&self, i: usize) -> (Option<MaterialId>, Standing) {
        (self.materials[i], Standing::Shape(self.shapes[i]))
    }

    /// The parameters (u, v) of a hit, if they have been [found](FlatHits::find_parameters) and the mesh has no others.
    #[inline(always)]
    pub(crate) fn parameters(&self, i: usize) -> Option<Vec2> {
        self.is_plain[i].then(|| Vec2::new(self.uv[0][i], self.uv[1][i]))
    }

    /// Finds the first `count` parameters (u, v), as a mesh has them that does not say: see [`BareTriangle::parameters`].
    pub(crate) fn find_parameters(&mut self, count: usize) {
        vectorize::<N, _>(Parameters { hits: self, count });
    }

    /// Finds the first `count` points, normals and error boxes.
    pub(crate) fn resolve(&mut self, count: usize) {
        vectorize::<N, _>(SideBySide { hits: self, count });
    }

    /// The same with these instructions.
    #[cfg(test)]
    pub(crate) fn resolve_with(&mut self, set: InstructionSet, count: usize) {
        set.run(SideBySide { hits: self, count });
        set.run(Parameters { hits: self, count });
    }

    /// Position, half-widths of the error box, and unit geometric normal of a hit, and the direction back along its ray.
    #[inline(always)]
    pub(crate) fn point(&self, i: usize) -> ((Vec3, Vec3, Vec3), Vec3) {
        let point = (self.p.get(i), self.p_error.get(i), self.n.get(i));
        (point, -self.d.get(i))
    }

    /// What was found.
    #[inline(always)]
    pub(crate) fn found(&self, i: usize) -> Option<ClosestHit> {
        self.found[i]
    }

    /// What was found, where the ray grazes the triangle: then the point means nothing, and must be found with more care.
    #[inline(always)]
    pub(crate) fn grazing(&self, i: usize) -> Option<ClosestHit> {
        self.found[i].filter(|_| self.is_grazing[i] != 0)
    }

    #[inline(always)]
    fn triangle(&self, i: usize) -> Triangle {
        let [a, b, c] = &self.corners;
        // Written out: `array::map` is not always inlined.
        let [a, b, c] = [a.get(i), b.get(i), c.get(i)];
        Triangle {
            p: [a.as_dvec3(), b.as_dvec3(), c.as_dvec3()],
            normals: None,
            tangents: None,
            uv: None,
            orientation: Orientation {
                flip_geometric: self.side[i] < 0.0,
                flip_shading: false,
            },
        }
    }

    #[inline(always)]
    fn compute_parameters(&mut self, i: usize) {
        let triangle = self.triangle(i);
        let b = triangle.nearest(self.o.get(i).as_dvec3(), self.d.get(i).as_dvec3());
        let uv = triangle.uv_at(b).as_vec2();
        (self.uv[0][i], self.uv[1][i]) = (uv.x, uv.y);
    }

    #[inline(always)]
    fn compute(&mut self, i: usize) {
        let triangle = self.triangle(i);
        let ray = Ray::new(self.o.get(i), self.d.get(i), 0.0);
        let (point, is_grazing) = triangle.crossing(ray.o.as_dvec3(), ray.d.as_dvec3());
        let hit = point.hit(&ray);
        self.p.set(i, hit.p);
        self.p_error.set(i, hit.p_error);
        self.n.set(i, hit.n);
        self.is_grazing[i] = is_grazing.into();
    }
}

/// The loop.
struct SideBySide<'a, const N: usize> {
    hits: &'a mut FlatHits<N>,
    count: usize,
}

impl<const N: usize> Kernel for SideBySide<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run(self, _: impl Instructions) {
        for i in 0..self.count.next_multiple_of(WHOLE).min(N) {
            self.hits.compute(i);
        }
    }
}

/// The loop that finds (u, v).
struct Parameters<'a, const N: usize> {
    hits: &'a mut FlatHits<N>,
    count: usize,
}

impl<const N: usize> Kernel for Parameters<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run(self, _: impl Instructions) {
        for i in 0..self.count.next_multiple_of(WHOLE).min(N) {
            self.hits.compute_parameters(i);
        }
    }
}
