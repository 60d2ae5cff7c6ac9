//! A surface point in double precision, in the space of the tree that holds the surface.

use super::quadric::Quadric;
use super::triangle::Triangle;
use crate::math::float::UNIT_ROUNDOFF;
use crate::math::ray::Ray;
use crate::math::transform::Place;
use crate::math::{DVec3, Vec2, Vec3};
use crate::surface::{ShadingGeometry, SurfaceHit};

/// A point of a surface with its normals: what a [`SurfaceHit`] is made from where nothing asks for more.
#[derive(Clone, Copy, Debug)]
pub struct LocalPoint {
    /// Position.
    pub p: DVec3,
    /// Half-widths of the box around `p` that holds the exact point, and outside which a ray that
    /// comes back into this space sees the surface on the right side.
    pub p_error: DVec3,
    /// Unit geometric normal.
    pub n: DVec3,
    /// Unit shading normal.
    pub shading_n: DVec3,
}

/// The same with its parameters and the derivatives by them.
#[derive(Clone, Copy, Debug)]
pub struct LocalSurface {
    /// The point.
    pub point: LocalPoint,
    /// Surface parameters.
    pub uv: Vec2,
    /// ∂p/∂u.
    pub dpdu: DVec3,
    /// ∂p/∂v.
    pub dpdv: DVec3,
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

/// A point of a surface with its normals and its parameters (u, v), for layers: those of quadrics are [approximate](super::quadric::ObjectSurface::approximate_uv).
#[derive(Clone, Copy, Debug)]
pub struct ParametricPoint {
    /// The point.
    pub point: LocalPoint,
    /// Surface parameters.
    pub uv: Vec2,
}

/// The parameters (u, v) of a surface point, alone; the same.
#[derive(Clone, Copy, Debug)]
pub struct Parameters(pub Vec2);

/// How much is worked out about the closest hit of a ray.
pub trait Local: From<LocalSurface> {
    /// Where the line `o + t d` meets a triangle, which [`TriangleSource`] gives.
    fn of_triangle(source: &impl TriangleSource, o: DVec3, d: DVec3) -> Self;
    /// Where it first meets a quadric.
    fn of_quadric(quadric: &Quadric, o: DVec3, d: DVec3) -> Option<Self>;
    /// As part of an instance at `place`.
    fn transformed(&self, place: &Place) -> Self;
}

/// What makes a hit.
pub trait LocalHit: Local {
    /// In single precision, as met by `ray`; the error box grows by the rounding.
    fn hit(&self, ray: &Ray) -> SurfaceHit;
}

/// A triangle in a mesh.
pub trait TriangleSource {
    /// Its corners and normals alone.
    fn bare(&self) -> Triangle;
    /// With its parameters (u, v), too.
    fn parametric(&self) -> Triangle;
    /// With all attributes.
    fn whole(&self) -> Triangle;
    /// See [`SurfaceHit::face`].
    fn face(&self) -> u32;
}

impl Local for LocalPoint {
    #[inline(always)]
    fn of_triangle(source: &impl TriangleSource, o: DVec3, d: DVec3) -> LocalPoint {
        source.bare().crossed(o, d)
    }

    fn of_quadric(quadric: &Quadric, o: DVec3, d: DVec3) -> Option<LocalPoint> {
        quadric.local_point(o, d)
    }

    /// Mirrored instances are not turned; the shading normal is, to the side of the geometric one
    /// (docs/scene-language.md §4.4).
    fn transformed(&self, place: &Place) -> LocalPoint {
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
        let shading_n = (normal_matrix * self.shading_n)
            .try_normalize()
            .unwrap_or(n);
        LocalPoint {
            p,
            p_error,
            n,
            shading_n: if shading_n.dot(n) < 0.0 {
                -shading_n
            } else {
                shading_n
            },
        }
    }
}

impl LocalHit for LocalPoint {
    #[inline(always)]
    fn hit(&self, ray: &Ray) -> SurfaceHit {
        let p = self.p.as_vec3();
        // Half an ulp each, and the rounding of the bound itself.
        let p_error =
            (self.p_error.as_vec3() + p.abs() * UNIT_ROUNDOFF) * (1.0 + 4.0 * UNIT_ROUNDOFF);
        SurfaceHit {
            p,
            p_error,
            n: self.n.as_vec3(),
            uv: Vec2::ZERO,
            dpdu: Vec3::ZERO,
            dpdv: Vec3::ZERO,
            shading: ShadingGeometry {
                n: self.shading_n.as_vec3(),
                dpdu: Vec3::ZERO,
                dpdv: Vec3::ZERO,
                dndu: Vec3::ZERO,
                dndv: Vec3::ZERO,
            },
            wo: -ray.d,
            time: ray.time,
            face: 0,
        }
    }
}

impl From<LocalSurface> for LocalPoint {
    fn from(surface: LocalSurface) -> LocalPoint {
        surface.point
    }
}

impl Local for LocalSurface {
    fn of_triangle(source: &impl TriangleSource, o: DVec3, d: DVec3) -> LocalSurface {
        let triangle = source.whole();
        LocalSurface {
            face: source.face(),
            ..triangle.surface(triangle.nearest(o, d))
        }
    }

    fn of_quadric(quadric: &Quadric, o: DVec3, d: DVec3) -> Option<LocalSurface> {
        Some(quadric.surface(quadric.object_point(o, d)?))
    }

    fn transformed(&self, place: &Place) -> LocalSurface {
        let m = &place.outer_from_inner.matrix3;
        let normal_matrix = place.inner_from_outer.matrix3.transpose();
        let point = self.point.transformed(place);
        let (n, shading) = (point.shading_n, normal_matrix * self.point.shading_n);
        let side = if shading.dot(n) < 0.0 { -1.0 } else { 1.0 };
        let scale = side / shading.length();
        let change = |dn: DVec3| {
            let dn = normal_matrix * dn * scale;
            let dn = dn - n * n.dot(dn);
            if dn.is_finite() { dn } else { DVec3::ZERO }
        };
        LocalSurface {
            point,
            dpdu: *m * self.dpdu,
            dpdv: *m * self.dpdv,
            shading_dpdu: *m * self.shading_dpdu,
            shading_dpdv: *m * self.shading_dpdv,
            dndu: change(self.dndu),
            dndv: change(self.dndv),
            ..*self
        }
    }
}

impl LocalHit for LocalSurface {
    fn hit(&self, ray: &Ray) -> SurfaceHit {
        let hit = self.point.hit(ray);
        SurfaceHit {
            uv: self.uv,
            dpdu: self.dpdu.as_vec3(),
            dpdv: self.dpdv.as_vec3(),
            shading: ShadingGeometry {
                n: hit.shading.n,
                dpdu: self.shading_dpdu.as_vec3(),
                dpdv: self.shading_dpdv.as_vec3(),
                dndu: self.dndu.as_vec3(),
                dndv: self.dndv.as_vec3(),
            },
            face: self.face,
            ..hit
        }
    }
}

impl From<LocalSurface> for ParametricPoint {
    fn from(LocalSurface { point, uv, .. }: LocalSurface) -> ParametricPoint {
        ParametricPoint { point, uv }
    }
}

impl Local for ParametricPoint {
    fn of_triangle(source: &impl TriangleSource, o: DVec3, d: DVec3) -> ParametricPoint {
        let (point, uv) = source.parametric().crossed_with_parameters(o, d);
        ParametricPoint { point, uv }
    }

    fn of_quadric(quadric: &Quadric, o: DVec3, d: DVec3) -> Option<ParametricPoint> {
        let (point, uv) = quadric.parametric_point(o, d)?;
        Some(ParametricPoint { point, uv })
    }

    fn transformed(&self, place: &Place) -> ParametricPoint {
        ParametricPoint {
            point: self.point.transformed(place),
            uv: self.uv,
        }
    }
}

impl LocalHit for ParametricPoint {
    fn hit(&self, ray: &Ray) -> SurfaceHit {
        SurfaceHit {
            uv: self.uv,
            ..self.point.hit(ray)
        }
    }
}

impl From<LocalSurface> for Parameters {
    fn from(surface: LocalSurface) -> Parameters {
        Parameters(surface.uv)
    }
}

impl Local for Parameters {
    fn of_triangle(source: &impl TriangleSource, o: DVec3, d: DVec3) -> Parameters {
        let triangle = source.parametric();
        let b = triangle.nearest(o, d);
        Parameters(triangle.uv_at(b).as_vec2())
    }

    fn of_quadric(quadric: &Quadric, o: DVec3, d: DVec3) -> Option<Parameters> {
        let (_, uv) = quadric.parametric_point(o, d)?;
        Some(Parameters(uv))
    }

    /// Moving a surface does not change them.
    fn transformed(&self, _: &Place) -> Parameters {
        *self
    }
}
