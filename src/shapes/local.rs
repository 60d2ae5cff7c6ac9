//! A surface point in double precision, in the space of the tree that holds the surface.

use crate::math::float::UNIT_ROUNDOFF;
use crate::math::ray::Ray;
use crate::math::transform::Place;
use crate::math::{DVec3, Vec2};
use crate::surface::{ShadingGeometry, SurfaceHit};

/// What a [`SurfaceHit`] is made from. Evaluated once per ray, for the closest hit.
#[derive(Clone, Copy, Debug)]
pub struct LocalSurface {
    /// Position.
    pub p: DVec3,
    /// Half-widths of the box around `p` that holds the exact point, and outside which a ray that
    /// comes back into this space sees the surface on the right side.
    pub p_error: DVec3,
    /// Unit geometric normal.
    pub n: DVec3,
    /// Surface parameters.
    pub uv: Vec2,
    /// ∂p/∂u.
    pub dpdu: DVec3,
    /// ∂p/∂v.
    pub dpdv: DVec3,
    /// Unit shading normal.
    pub shading_n: DVec3,
    /// Shading ∂p/∂u.
    pub shading_dpdu: DVec3,
    /// Shading ∂p/∂v.
    pub shading_dpdv: DVec3,
    /// Change of the shading normal with u.
    pub dndu: DVec3,
    /// Change of the shading normal with v.
    pub dndv: DVec3,
    /// See [`SurfaceHit::face`].
    pub face: u32,
}

impl LocalSurface {
    /// The surface of an instance at `place`.
    /// Mirrored instances are not turned; the shading normal is, to the side of the geometric one
    /// (docs/scene-language.md §4.4).
    pub fn transformed(&self, place: &Place) -> LocalSurface {
        let Place {
            outer_from_inner,
            inner_from_outer,
        } = place;
        let m = &outer_from_inner.matrix3;
        let normal_matrix = inner_from_outer.matrix3.transpose();
        let p = outer_from_inner.transform_point3(self.p);
        let back = inner_from_outer.matrix3.abs() * p.abs() + inner_from_outer.translation.abs();
        // Rays enter an instance with an origin rounded to single precision there: half an ulp,
        // doubled to be strictly outside. The rest is what double precision loses both ways.
        let inner = self.p_error
            + self.p.abs() * f64::from(2.0 * UNIT_ROUNDOFF)
            + DVec3::splat(back.max_element() * (16.0 * f64::EPSILON));
        let moved = outer_from_inner.translation.abs().max_element() + p.abs().max_element();
        // The largest over all axes, as for quadrics.
        let p_error = m.abs() * inner + DVec3::splat(moved * (16.0 * f64::EPSILON));
        let n = (normal_matrix * self.n).normalize_or(DVec3::Z);
        let shading = normal_matrix * self.shading_n;
        let length = shading.length();
        let mut shading_n = shading / length;
        if !shading_n.is_finite() {
            shading_n = n;
        }
        let side = if shading_n.dot(n) < 0.0 { -1.0 } else { 1.0 };
        shading_n *= side;
        let change = |dn: DVec3| {
            let dn = normal_matrix * dn / length * side;
            let dn = dn - shading_n * shading_n.dot(dn);
            if dn.is_finite() { dn } else { DVec3::ZERO }
        };
        LocalSurface {
            p,
            p_error,
            n,
            uv: self.uv,
            dpdu: *m * self.dpdu,
            dpdv: *m * self.dpdv,
            shading_n,
            shading_dpdu: *m * self.shading_dpdu,
            shading_dpdv: *m * self.shading_dpdv,
            dndu: change(self.dndu),
            dndv: change(self.dndv),
            face: self.face,
        }
    }

    /// In single precision, as met by `ray`; the error box grows by the rounding.
    #[inline]
    pub fn hit(&self, ray: &Ray) -> SurfaceHit {
        let p = self.p.as_vec3();
        // Half an ulp each, and the rounding of the bound itself.
        let p_error =
            (self.p_error.as_vec3() + p.abs() * UNIT_ROUNDOFF) * (1.0 + 4.0 * UNIT_ROUNDOFF);
        SurfaceHit {
            p,
            p_error,
            n: self.n.as_vec3(),
            uv: self.uv,
            dpdu: self.dpdu.as_vec3(),
            dpdv: self.dpdv.as_vec3(),
            shading: ShadingGeometry {
                n: self.shading_n.as_vec3(),
                dpdu: self.shading_dpdu.as_vec3(),
                dpdv: self.shading_dpdv.as_vec3(),
                dndu: self.dndu.as_vec3(),
                dndv: self.dndv.as_vec3(),
            },
            wo: -ray.d,
            time: ray.time,
            face: self.face,
        }
    }
}
