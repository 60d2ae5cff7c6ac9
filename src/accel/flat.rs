//! Hits of flat triangles, resolved side by side: most hits, in most scenes, where nothing asks for (u, v).
//!
//! The function that serves a single hit is run in a loop over rows of numbers that has no branch, so that it is compiled to vector
//! instructions ([`crate::math::instruction_set`]). Bits are those of one at a time.

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

/// Where up to `N` rays meet flat triangles.
pub(crate) struct FlatHits<const N: usize> {
    pub(crate) bare: BareHits<N>,
    /// Below 0 where the normal of the corners' order is to be turned.
    side: [f32; N],
    p: Rows3<N>,
    p_error: Rows3<N>,
    n: Rows3<N>,
    is_grazing: [u32; N],
}

impl<const N: usize> Default for FlatHits<N> {
    fn default() -> Self {
        FlatHits {
            bare: BareHits::default(),
            side: [0.0; N],
            p: Rows3::default(),
            p_error: Rows3::default(),
            n: Rows3::default(),
            is_grazing: [0; N],
        }
    }
}

impl<const N: usize> FlatHits<N> {
    /// The hit at `i` is that of `ray` with `triangle`, which a search `found`.
    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, ray: &Ray, hit: (&BareTriangle, &ClosestHit)) {
        self.bare.set(i, ray, hit);
        let turned = hit.0.mesh.orientation.flip_geometric;
        self.side[i] = if turned { -1.0 } else { 1.0 };
    }

    /// Finds the first `count` points, normals and error boxes, and (u, v) where they are wanted.
    pub(crate) fn resolve(&mut self, count: usize, wants_uv: bool) {
        match wants_uv {
            false => vectorize::<N, _>(SideBySide::<N, false> { hits: self, count }),
            true => vectorize::<N, _>(SideBySide::<N, true> { hits: self, count }),
        }
    }

    /// The same with these instructions, and with (u, v).
    #[cfg(test)]
    pub(crate) fn resolve_with(&mut self, set: InstructionSet, count: usize) {
        set.run(SideBySide::<N, true> { hits: self, count });
    }

    /// Position, half-widths of the error box, and unit geometric normal of a hit, and the direction back along its ray.
    #[inline(always)]
    pub(crate) fn point(&self, i: usize) -> ((Vec3, Vec3, Vec3), Vec3) {
        let point = (self.p.get(i), self.p_error.get(i), self.n.get(i));
        (point, -self.bare.ray(i).d)
    }

    /// What was found, where the ray grazes the triangle: then the point means nothing, and must be found with more care.
    #[inline(always)]
    pub(crate) fn grazing(&self, i: usize) -> Option<ClosestHit> {
        self.bare.found(i).filter(|_| self.is_grazing[i] != 0)
    }

    #[inline(always)]
    fn compute<const UV: bool>(&mut self, i: usize) {
        let orientation = Orientation {
            flip_geometric: self.side[i] < 0.0,
            flip_shading: false,
        };
        let triangle = self.bare.triangle(i, None, orientation);
        let ray = self.bare.ray(i);
        let (o, d) = (ray.o.as_dvec3(), ray.d.as_dvec3());
        let (point, is_grazing) = triangle.crossing(o, d);
        let hit = point.hit(&ray);
        self.p.set(i, hit.p);
        self.p_error.set(i, hit.p_error);
        self.n.set(i, hit.n);
        self.is_grazing[i] = is_grazing.into();
        if UV {
            // As the whole surface has them, whose point is in the triangle for certain.
            self.bare
                .set_parameters(i, &triangle, triangle.nearest(o, d));
        }
    }
}

/// The loop. `UV`: with the parameters (u, v), a constant, so that nothing is paid for them without layers.
struct SideBySide<'a, const N: usize, const UV: bool> {
    hits: &'a mut FlatHits<N>,
    count: usize,
}

impl<const N: usize, const UV: bool> Kernel for SideBySide<'_, N, UV> {
    type Output = ();

    #[inline(always)]
    fn run(self, _: impl Instructions) {
        for i in 0..self.count.next_multiple_of(WIDEST).min(N) {
            self.hits.compute::<UV>(i);
        }
    }
}
