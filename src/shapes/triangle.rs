//! One triangle of a mesh: where exactly a ray meets it, and the surface there.

use super::local::LocalSurface;
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
    /// Texture coordinates; [`DEFAULT_UV`] where the mesh has none.
    pub uv: [DVec2; 3],
    /// Turns.
    pub orientation: Orientation,
}

/// Which way a mesh's normals point (scene-language 4.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Orientation {
    /// Negate the normal of the corners' order: ReverseOrientation XOR a mirroring transformation.
    pub flip_geometric: bool,
    /// Negate interpolated normals: ReverseOrientation alone.
    pub flip_shading: bool,
}

/// Corner parameters of a triangle without texture coordinates.
pub const DEFAULT_UV: [Vec2; 3] = [Vec2::ZERO, Vec2::X, Vec2::ONE];

/// ∂p/∂u and ∂p/∂v are taken from the texture coordinates where their determinant is at least this.
const SMALLEST_UV_DETERMINANT: f64 = 1e-8;

#[inline]
fn interpolate(v: &[DVec3; 3], b: [f64; 3]) -> DVec3 {
    v[0] * b[0] + v[1] * b[1] + v[2] * b[2]
}

impl Triangle {
    /// Barycentric coordinates of the point where the line `o + t d` meets the plane, moved into
    /// the triangle where rounding left them outside (Möller and Trumbore 1997, in double
    /// precision). `None` where the line lies in the plane.
    #[inline]
    pub fn barycentrics(&self, o: DVec3, d: DVec3) -> Option<[f64; 3]> {
        let (e1, e2) = (self.p[1] - self.p[0], self.p[2] - self.p[0]);
        let across = d.cross(e2);
        let determinant = e1.dot(across);
        let from = o - self.p[0];
        let scale = determinant.recip();
        let b1 = from.dot(across) * scale;
        let b2 = d.dot(from.cross(e1)) * scale;
        if !(b1.is_finite() && b2.is_finite()) {
            return None;
        }
        let b = [(1.0 - b1 - b2).max(0.0), b1.max(0.0), b2.max(0.0)];
        let scale = (b[0] + b[1] + b[2]).recip();
        Some(b.map(|b| b * scale))
    }

    /// The unit geometric normal at `b`: the corners' order and the orientation decide its side,
    /// or else the interpolated normal does.
    pub fn geometric_normal(&self, b: [f64; 3]) -> DVec3 {
        self.normal_beside(self.interpolated_normal(b))
    }

    /// The same, where the interpolated normal is known.
    #[inline]
    fn normal_beside(&self, interpolated: Option<DVec3>) -> DVec3 {
        let n = (self.p[1] - self.p[0])
            .cross(self.p[2] - self.p[0])
            .normalize_or(DVec3::Z);
        let n = if self.orientation.flip_geometric {
            -n
        } else {
            n
        };
        match interpolated {
            Some(ns) if ns.dot(n) < 0.0 => -n,
            _ => n,
        }
    }

    /// The unit shading normal at `b`; `None` without normals, or where they cancel.
    #[inline]
    fn interpolated_normal(&self, b: [f64; 3]) -> Option<DVec3> {
        let n = interpolate(self.normals.as_ref()?, b).try_normalize()?;
        Some(if self.orientation.flip_shading { -n } else { n })
    }

    /// The surface at `b`.
    #[inline]
    pub fn surface(&self, b: [f64; 3]) -> LocalSurface {
        let interpolated = self.interpolated_normal(b);
        let n = self.normal_beside(interpolated);
        let (dpdu, dpdv) = self.position_derivatives(n);
        let shading_n = interpolated.unwrap_or(n);
        let (mut shading_dpdu, mut shading_dpdv) = (dpdu, dpdv);
        if self.normals.is_some() || self.tangents.is_some() {
            (shading_dpdu, shading_dpdv) = self.shading_frame(b, shading_n, dpdu);
        }
        let (dndu, dndv) = self.normal_derivatives();
        let uv = self.uv[0] * b[0] + self.uv[1] * b[1] + self.uv[2] * b[2];
        let largest = self.p[0].abs().max(self.p[1].abs()).max(self.p[2].abs());
        LocalSurface {
            p: interpolate(&self.p, b),
            // Three products and two sums, and as much again for the coordinates' own rounding.
            p_error: largest * (8.0 * f64::EPSILON),
            n,
            uv: uv.as_vec2(),
            dpdu,
            dpdv,
            shading_n,
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
        let (uv02, uv12) = (self.uv[0] - self.uv[2], self.uv[1] - self.uv[2]);
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
            return (DVec3::ZERO, DVec3::ZERO);
        };
        let side = if self.orientation.flip_shading {
            -1.0
        } else {
            1.0
        };
        let (du, dv) = self
            .solve(n0 - n2, n1 - n2)
            .unwrap_or((DVec3::ZERO, DVec3::ZERO));
        (du * side, dv * side)
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

    fn triangle() -> Triangle {
        Triangle {
            p: [
                DVec3::ZERO,
                DVec3::new(2.0, 0.0, 0.0),
                DVec3::new(2.0, 3.0, 0.0),
            ],
            normals: None,
            tangents: None,
            uv: DEFAULT_UV.map(Vec2::as_dvec2),
            orientation: Orientation::default(),
        }
    }

    #[test]
    fn derivatives_reproduce_the_corners() {
        let t = triangle();
        let s = t.surface([0.2, 0.3, 0.5]);
        assert_eq!(s.n, DVec3::Z);
        for (p, uv) in t.p.iter().zip(t.uv) {
            let moved =
                s.p + s.dpdu * (uv.x - f64::from(s.uv.x)) + s.dpdv * (uv.y - f64::from(s.uv.y));
            assert!((*p - moved).length() < 1e-6); // uv are single precision
        }
    }

    #[test]
    fn degenerate_parameters_give_some_frame() {
        let t = Triangle {
            uv: [DVec2::ONE; 3],
            ..triangle()
        };
        let s = t.surface([0.2, 0.3, 0.5]);
        assert!(s.dpdu.cross(s.dpdv).dot(s.n) > 0.5);
    }

    #[test]
    #[inline]
    fn interpolated_normals_decide_the_side() {
        let down = Triangle {
            normals: Some([-DVec3::Z; 3]),
            ..triangle()
        };
        assert_eq!(down.surface([0.2, 0.3, 0.5]).n, -DVec3::Z);
        let orientation = Orientation {
            flip_geometric: true,
            flip_shading: true,
        };
        assert_eq!(
            Triangle {
                orientation,
                ..down
            }
            .surface([0.2, 0.3, 0.5])
            .n,
            DVec3::Z
        );
        // Cancelling normals leave the geometric one.
        let none = Triangle {
            normals: Some([DVec3::Z, -DVec3::Z, DVec3::ZERO]),
            ..triangle()
        };
        assert_eq!(none.surface([0.5, 0.5, 0.0]).shading_n, DVec3::Z);
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
