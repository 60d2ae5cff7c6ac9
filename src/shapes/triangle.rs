//! One triangle of a mesh: where exactly a ray meets it, and the surface there.

use super::local::{LocalPoint, LocalSurface};
use crate::math::{DVec2, DVec3, Vec2};

/// A triangle with its corners' attributes, widened from the mesh's single precision.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Corners.
    pub p: [DVec3; 3],
    /// Normals at the corners, if the mesh has them.
    pub normals: Option<[DVec3; 3]>,
    /// Tangents at the corners, if the mesh has them.
    pub tangents: Option<[DVec3; 3]>,
    /// Texture coordinates, if the mesh has them; else (0, 0), (1, 0) and (1, 1).
    pub uv: Option<[DVec2; 3]>,
    /// Turns.
    pub orientation: Orientation,
}

/// Which way a mesh's normals point (docs/scene-language.md §4.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Orientation {
    /// Negate the normal of the corners' order: ReverseOrientation XOR a mirroring transformation.
    pub flip_geometric: bool,
    /// Negate interpolated normals: ReverseOrientation alone.
    pub flip_shading: bool,
}

impl Orientation {
    /// A normal by the corners' order, turned.
    #[inline(always)]
    pub(super) fn geometric(self, n: DVec3) -> DVec3 {
        if self.flip_geometric { -n } else { n }
    }

    /// An interpolated normal or its derivative, turned.
    #[inline(always)]
    pub(super) fn shading(self, n: DVec3) -> DVec3 {
        if self.flip_shading { -n } else { n }
    }
}

/// Where the sine of the ray's angle with the plane times that of the angle between the edges is at least this, the point
/// is where the ray crosses the plane: rounding then moves that off the triangle by no more than a hundred times what
/// single precision has lost before.
const PLAIN_SINE: f64 = 1e-2;

/// ∂p/∂u and ∂p/∂v are taken from the texture coordinates where their determinant is at least this.
const SMALLEST_UV_DETERMINANT: f64 = 1e-8;

/// The unit vector along `v`, and whether there is one: `DVec3::try_normalize` without a branch.
#[inline(always)]
fn unit(v: DVec3) -> (DVec3, bool) {
    let reciprocal = v.length_recip();
    (v * reciprocal, reciprocal.is_finite() & (reciprocal > 0.0))
}

#[inline(always)]
fn interpolate(v: &[DVec3; 3], b: [f64; 3]) -> DVec3 {
    v[0] * b[0] + v[1] * b[1] + v[2] * b[2]
}

impl Triangle {
    /// The edges from the first corner, and their cross product.
    #[inline(always)]
    fn edges(&self) -> (DVec3, DVec3, DVec3) {
        let (e1, e2) = (self.p[1] - self.p[0], self.p[2] - self.p[0]);
        (e1, e2, e1.cross(e2))
    }

    /// Barycentric coordinates of the point where the line `o + t d` meets the plane, moved into
    /// the triangle where rounding left them outside (Möller and Trumbore 1997, in double
    /// precision, their determinants written with the normal, which the surface needs too).
    /// `None` where the line lies in the plane.
    #[inline(always)]
    pub fn barycentrics(&self, o: DVec3, d: DVec3) -> Option<[f64; 3]> {
        let (b, meets) = self.meeting(o, d);
        meets.then_some(b)
    }

    /// The same without a branch, and whether the line meets the plane.
    #[inline(always)]
    fn meeting(&self, o: DVec3, d: DVec3) -> ([f64; 3], bool) {
        let (e1, e2, across) = self.edges();
        let scale = d.dot(across).recip();
        let q = d.cross(o - self.p[0]);
        let (b1, b2) = (e2.dot(q) * scale, -e1.dot(q) * scale);
        let b0 = 1.0 - b1 - b2;
        // The rule; their sum is 1 but for a rounding.
        let is_inside = (b0 >= 0.0) & (b1 >= 0.0) & (b2 >= 0.0);
        // Not `max`, to which zeros of either sign are equal.
        let at_least_0 = |b: f64| if b > 0.0 { b } else { 0.0 };
        let moved = [at_least_0(b0), at_least_0(b1), at_least_0(b2)];
        let scale = (moved[0] + moved[1] + moved[2]).recip();
        let scale = if is_inside { 1.0 } else { scale };
        let b = [moved[0] * scale, moved[1] * scale, moved[2] * scale];
        (b, b1.is_finite() & b2.is_finite())
    }

    /// The unit geometric normal where the interpolated one is as given: the corners' order and the orientation decide
    /// its side, or else the interpolated normal does.
    #[inline(always)]
    fn normal_beside(&self, (interpolated, is_interpolated): (DVec3, bool)) -> DVec3 {
        let (n, has_area) = unit(self.edges().2);
        let n = self
            .orientation
            .geometric(if has_area { n } else { DVec3::Z });
        let turns = is_interpolated & (interpolated.dot(n) < 0.0);
        if turns { -n } else { n }
    }

    /// The unit shading normal at `b`, and whether there is one: not without normals, nor where they cancel.
    #[inline(always)]
    fn interpolated_normal(&self, b: [f64; 3]) -> (DVec3, bool) {
        let Some(normals) = &self.normals else {
            return (DVec3::ZERO, false);
        };
        let (n, is_unit) = unit(interpolate(normals, b));
        (self.orientation.shading(n), is_unit)
    }

    /// The point at `b`.
    #[inline(always)]
    pub fn point(&self, b: [f64; 3]) -> DVec3 {
        interpolate(&self.p, b)
    }

    /// (u, v) at `b`.
    #[inline]
    pub fn uv_at(&self, b: [f64; 3]) -> DVec2 {
        match &self.uv {
            Some(uv) => uv[0] * b[0] + uv[1] * b[1] + uv[2] * b[2],
            None => DVec2::new(b[1] + b[2], b[2]),
        }
    }

    /// The point where the ray `o + t d`, which is known to hit, meets the triangle, with its normals.
    ///
    /// Without normals to interpolate, and for most rays, that is where it crosses the plane: t = n·(p₀ − o) / n·d. Off
    /// the plane that is by what cancels in n·(p₀ − o) and what o + t d is rounded by, about 24 roundings of the largest
    /// coordinates, whatever the angle.
    #[inline(always)]
    pub fn crossed(&self, o: DVec3, d: DVec3) -> LocalPoint {
        match self.crossing(o, d) {
            (point, false) if self.normals.is_none() => point,
            _ => self.nearest_point(o, d),
        }
    }

    /// The same point, with its parameters (u, v).
    #[inline]
    pub fn crossed_with_parameters(&self, o: DVec3, d: DVec3) -> (LocalPoint, Vec2) {
        let b = self.nearest(o, d);
        let uv = self.uv_at(b).as_vec2();
        if self.normals.is_none()
            && let (point, false) = self.crossing(o, d)
        {
            return (point, uv);
        }
        (self.local_point(b), uv)
    }

    /// Where the line `o + t d` crosses the plane, and whether it does so at too small an angle for that to be in the triangle. Without
    /// a branch.
    #[inline(always)]
    pub(crate) fn crossing(&self, o: DVec3, d: DVec3) -> (LocalPoint, bool) {
        let (e1, e2, across) = self.edges();
        let slope = across.dot(d);
        let sides = e1.length_squared() * e2.length_squared();
        let is_grazing = slope * slope < PLAIN_SINE * PLAIN_SINE * sides;
        let t = across.dot(self.p[0] - o) / slope;
        let p = o + d * t;
        let largest = self.p[0].abs().max_element() + o.abs().max_element() + t;
        let n = self.orientation.geometric(across * across.length_recip());
        let point = LocalPoint {
            p,
            p_error: DVec3::splat(largest * (32.0 * f64::EPSILON)),
            n,
            shading_n: n,
        };
        (point, is_grazing)
    }

    /// The same by barycentric coordinates, in the triangle for certain.
    #[inline(never)]
    fn nearest_point(&self, o: DVec3, d: DVec3) -> LocalPoint {
        self.local_point(self.nearest(o, d))
    }

    /// Barycentric coordinates of where the line `o + t d` meets the triangle; of its middle if the line lies in its
    /// plane, where any point will do.
    #[inline(always)]
    pub(crate) fn nearest(&self, o: DVec3, d: DVec3) -> [f64; 3] {
        let (b, meets) = self.meeting(o, d);
        if meets { b } else { [1.0 / 3.0; 3] }
    }

    /// The point at `b`, with its normals.
    #[inline(always)]
    pub fn local_point(&self, b: [f64; 3]) -> LocalPoint {
        let interpolated = self.interpolated_normal(b);
        let n = self.normal_beside(interpolated);
        let largest = self.p[0].abs().max(self.p[1].abs()).max(self.p[2].abs());
        LocalPoint {
            p: self.point(b),
            // Three products and two sums, and as much again for the coordinates' own rounding.
            p_error: largest * (8.0 * f64::EPSILON),
            n,
            shading_n: if interpolated.1 { interpolated.0 } else { n },
        }
    }

    /// The surface at `b`.
    pub fn surface(&self, b: [f64; 3]) -> LocalSurface {
        let point = self.local_point(b);
        let (dpdu, dpdv) = self.position_derivatives(point.n);
        let (mut shading_dpdu, mut shading_dpdv) = (dpdu, dpdv);
        if self.normals.is_some() || self.tangents.is_some() {
            (shading_dpdu, shading_dpdv) = self.shading_frame(b, point.shading_n, dpdu);
        }
        let (dndu, dndv) = self.normal_derivatives();
        LocalSurface {
            point,
            uv: self.uv_at(b).as_vec2(),
            dpdu,
            dpdv,
            shading_dpdu,
            shading_dpdv,
            dndu,
            dndv,
            face: 0,
        }
    }

    /// Solves for the derivatives by (u, v) of something that is linear over the triangle, from
    /// its differences to the third corner. `None` where (u, v) hardly vary.
    #[inline]
    fn solve(&self, d02: DVec3, d12: DVec3) -> Option<(DVec3, DVec3)> {
        let Some(uv) = &self.uv else {
            // u grows from the first corner to the second, v from there to the third.
            return Some((d12 - d02, -d12));
        };
        let (uv02, uv12) = (uv[0] - uv[2], uv[1] - uv[2]);
        let determinant = uv02.x * uv12.y - uv02.y * uv12.x;
        if determinant.abs() < SMALLEST_UV_DETERMINANT {
            return None;
        }
        let scale = determinant.recip();
        let du = (d02 * uv12.y - d12 * uv02.y) * scale;
        let dv = (d12 * uv02.x - d02 * uv12.x) * scale;
        (du.is_finite() && dv.is_finite()).then_some((du, dv))
    }

    /// ∂p/∂u and ∂p/∂v; any frame around the normal where the parameters are degenerate.
    #[inline]
    fn position_derivatives(&self, n: DVec3) -> (DVec3, DVec3) {
        self.solve(self.p[0] - self.p[2], self.p[1] - self.p[2])
            .filter(|(u, v)| u.cross(*v).length_squared() > 0.0)
            .unwrap_or_else(|| n.any_orthonormal_pair())
    }

    /// ∂n/∂u and ∂n/∂v of the interpolated normals; zero without.
    #[inline]
    fn normal_derivatives(&self) -> (DVec3, DVec3) {
        let Some([n0, n1, n2]) = self.normals else {
            return Default::default();
        };
        let (du, dv) = self.solve(n0 - n2, n1 - n2).unwrap_or_default();
        (self.orientation.shading(du), self.orientation.shading(dv))
    }

    /// Unit shading ∂p/∂u and ∂p/∂v: s is the interpolated tangent or ∂p/∂u, t = s × n, then
    /// s = t × n, as pbrt-v3 has it; any frame where s is along n.
    fn shading_frame(&self, b: [f64; 3], n: DVec3, dpdu: DVec3) -> (DVec3, DVec3) {
        let tangent = self
            .tangents
            .as_ref()
            .and_then(|s| interpolate(s, b).try_normalize());
        let s = tangent.unwrap_or_else(|| dpdu.normalize_or_zero());
        match s.cross(n).try_normalize() {
            Some(t) => (t.cross(n), t),
            None => n.any_orthonormal_pair(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corner parameters of a triangle without texture coordinates.
    const DEFAULT_UV: [DVec2; 3] = [DVec2::ZERO, DVec2::X, DVec2::ONE];

    fn triangle() -> Triangle {
        Triangle {
            p: [
                DVec3::ZERO,
                DVec3::new(2.0, 0.0, 0.0),
                DVec3::new(2.0, 3.0, 0.0),
            ],
            normals: None,
            tangents: None,
            uv: None,
            orientation: Orientation::default(),
        }
    }

    #[test]
    fn derivatives_reproduce_the_corners() {
        let t = triangle();
        let s = t.surface([0.2, 0.3, 0.5]);
        assert_eq!(s.point.n, DVec3::Z);
        for (p, uv) in t.p.iter().zip(DEFAULT_UV) {
            let moved = s.point.p
                + s.dpdu * (uv.x - f64::from(s.uv.x))
                + s.dpdv * (uv.y - f64::from(s.uv.y));
            assert!((*p - moved).length() < 1e-6); // uv are single precision
        }
    }

    #[test]
    fn without_parameters_a_triangle_is_as_with_the_default_ones() {
        let normals = [DVec3::Z, DVec3::X, DVec3::new(0.3, 0.1, 1.0).normalize()];
        for normals in [None, Some(normals)] {
            let without = Triangle {
                normals,
                p: [
                    DVec3::new(0.1, 0.2, 0.3),
                    DVec3::new(2.0, 0.5, -0.3),
                    DVec3::new(2.2, 3.0, 0.7),
                ],
                ..triangle()
            };
            let with = Triangle {
                uv: Some(DEFAULT_UV),
                ..without
            };
            let b = [0.2, 0.3, 0.5];
            let (s, t) = (without.surface(b), with.surface(b));
            assert_eq!(s.uv, t.uv);
            for (x, y) in [
                (s.dpdu, t.dpdu),
                (s.dpdv, t.dpdv),
                (s.dndu, t.dndu),
                (s.dndv, t.dndv),
                (s.shading_dpdu, t.shading_dpdu),
            ] {
                // A rounding or two of numbers around 1.
                assert!((x - y).length() < 1e-15, "{x} {y}");
            }
        }
    }

    #[test]
    fn points_outside_are_moved_in() {
        let t = triangle();
        for o in [
            DVec3::new(-0.5, -0.1, 2.0),
            DVec3::new(2.5, 1.0, 2.0),
            DVec3::new(2.5, 3.5, 2.0),
        ] {
            let b = t.barycentrics(o, -DVec3::Z).unwrap();
            assert!(b.iter().all(|b| (0.0..=1.0).contains(b)), "{b:?}");
            assert!((b.iter().sum::<f64>() - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn degenerate_parameters_give_some_frame() {
        let t = Triangle {
            uv: Some([DVec2::ONE; 3]),
            ..triangle()
        };
        let s = t.surface([0.2, 0.3, 0.5]);
        assert!(s.dpdu.cross(s.dpdv).dot(s.point.n) > 0.5);
    }

    #[test]
    #[inline]
    fn interpolated_normals_decide_the_side() {
        let down = Triangle {
            normals: Some([-DVec3::Z; 3]),
            ..triangle()
        };
        assert_eq!(down.local_point([0.2, 0.3, 0.5]).n, -DVec3::Z);
        let orientation = Orientation {
            flip_geometric: true,
            flip_shading: true,
        };
        assert_eq!(
            Triangle {
                orientation,
                ..down
            }
            .local_point([0.2, 0.3, 0.5])
            .n,
            DVec3::Z
        );
        // Cancelling normals leave the geometric one.
        let none = Triangle {
            normals: Some([DVec3::Z, -DVec3::Z, DVec3::ZERO]),
            ..triangle()
        };
        assert_eq!(none.local_point([0.5, 0.5, 0.0]).shading_n, DVec3::Z);
    }

    #[test]
    fn shading_frames_are_orthonormal_and_keep_the_normal() {
        let tilted = DVec3::new(0.3, 0.1, 1.0).normalize();
        let t = Triangle {
            normals: Some([tilted; 3]),
            tangents: Some([DVec3::new(0.0, 1.0, 0.2); 3]),
            ..triangle()
        };
        let s = t.surface([0.2, 0.3, 0.5]);
        assert!((s.shading_dpdu.cross(s.shading_dpdv) - tilted).length() < 1e-15);
        assert!(s.shading_dpdu.dot(s.shading_dpdv).abs() < 1e-15);
    }

    #[test]
    fn barycentrics_locate_the_point() {
        let t = triangle();
        let b = t
            .barycentrics(DVec3::new(1.5, 1.0, 7.0), DVec3::new(0.0, 0.0, -1.0))
            .unwrap();
        assert!((interpolate(&t.p, b) - DVec3::new(1.5, 1.0, 0.0)).length() < 1e-15);
        assert!(
            t.barycentrics(DVec3::new(1.5, 1.0, 7.0), DVec3::X)
                .is_none()
        );
    }
}
