//! Hits of triangles with normals at their corners, resolved side by side as those of [flat ones](super::flat).

use super::bare::{BareHits, BareTriangle};
use super::search::ClosestHit;
use crate::math::Vec3;
#[cfg(test)]
use crate::math::instruction_set::InstructionSet;
use crate::math::instruction_set::{Instructions, Kernel, WIDEST, vectorize};
use crate::math::ray::Ray;
use crate::math::rows::Rows3;
use crate::shapes::local::LocalHit;
use crate::shapes::triangle::Orientation;

/// Where up to `N` rays meet such triangles.
pub(crate) struct SmoothHits<const N: usize> {
    pub(crate) bare: BareHits<N>,
    normals: [Rows3<N>; 3],
    /// Below 0 where the normal of the corners' order is to be turned, and where interpolated ones are.
    sides: [[f32; N]; 2],
    p: Rows3<N>,
    p_error: Rows3<N>,
    n: Rows3<N>,
    shading_n: Rows3<N>,
}

impl<const N: usize> Default for SmoothHits<N> {
    fn default() -> Self {
        SmoothHits {
            bare: BareHits::default(),
            normals: Default::default(),
            sides: [[0.0; N]; 2],
            p: Rows3::default(),
            p_error: Rows3::default(),
            n: Rows3::default(),
            shading_n: Rows3::default(),
        }
    }
}

/// A point on one, as of [`crate::surface::SurfaceHit`].
pub(crate) struct SmoothPoint {
    pub p: Vec3,
    pub p_error: Vec3,
    pub n: Vec3,
    pub shading_n: Vec3,
    pub wo: Vec3,
}

impl<const N: usize> SmoothHits<N> {
    /// The hit at `i` is that of `ray` with `triangle`, which has normals and which a search `found`.
    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, ray: &Ray, hit: (&BareTriangle, &ClosestHit)) {
        self.bare.set(i, ray, hit);
        let mesh = hit.0.mesh;
        for (rows, vertex) in self.normals.iter_mut().zip(mesh.indices[hit.0.i]) {
            rows.set(i, mesh.normals[vertex as usize]);
        }
        let side = |turned: bool| if turned { -1.0 } else { 1.0 };
        self.sides[0][i] = side(mesh.orientation.flip_geometric);
        self.sides[1][i] = side(mesh.orientation.flip_shading);
    }

    /// Finds the first `count` points, normals and error boxes; and (u, v), of which there is next to nothing left to compute.
    pub(crate) fn resolve(&mut self, count: usize) {
        vectorize::<N, _>(SideBySide { hits: self, count });
    }

    /// The same with these instructions.
    #[cfg(test)]
    pub(crate) fn resolve_with(&mut self, set: InstructionSet, count: usize) {
        set.run(SideBySide { hits: self, count });
    }

    /// What has been found at `i`.
    #[inline(always)]
    pub(crate) fn point(&self, i: usize) -> SmoothPoint {
        SmoothPoint {
            p: self.p.get(i),
            p_error: self.p_error.get(i),
            n: self.n.get(i),
            shading_n: self.shading_n.get(i),
            wo: -self.bare.ray(i).d,
        }
    }

    #[inline(always)]
    fn compute(&mut self, i: usize) {
        // Written out: `array::map` is not always inlined.
        let [a, b, c] = &self.normals;
        let (a, b, c) = (a.get(i), b.get(i), c.get(i));
        let normals = [a.as_dvec3(), b.as_dvec3(), c.as_dvec3()];
        let orientation = Orientation {
            flip_geometric: self.sides[0][i] < 0.0,
            flip_shading: self.sides[1][i] < 0.0,
        };
        let triangle = self.bare.triangle(i, Some(normals), orientation);
        let ray = self.bare.ray(i);
        let b = triangle.nearest(ray.o.as_dvec3(), ray.d.as_dvec3());
        let hit = triangle.local_point(b).hit(&ray);
        self.bare.set_parameters(i, &triangle, b);
        self.p.set(i, hit.p);
        self.p_error.set(i, hit.p_error);
        self.n.set(i, hit.n);
        self.shading_n.set(i, hit.shading.n);
    }
}

/// The loop.
struct SideBySide<'a, const N: usize> {
    hits: &'a mut SmoothHits<N>,
    count: usize,
}

impl<const N: usize> Kernel for SideBySide<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run(self, _: impl Instructions) {
        for i in 0..self.count.next_multiple_of(WIDEST).min(N) {
            self.hits.compute(i);
        }
    }
}
