//! Transformations, composed in double precision (docs/scene-language.md §2.2).

use super::{DMat4, DVec3};
use glam::{DAffine3, DMat3, DVec4};

/// A 4×4 matrix with its inverse. Column vectors: `a * b` applies b first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// The matrix.
    pub m: DMat4,
    /// Its inverse; contains non-finite values if the matrix is singular.
    pub inverse: DMat4,
}

impl Transform {
    /// The identity.
    pub const IDENTITY: Transform = Transform {
        m: DMat4::IDENTITY,
        inverse: DMat4::IDENTITY,
    };

    /// The transformation by a matrix, which is inverted here.
    pub fn from_matrix(m: DMat4) -> Transform {
        Transform {
            m,
            inverse: m.inverse(),
        }
    }

    /// Translation by `t`.
    pub fn translate(t: DVec3) -> Transform {
        Transform {
            m: DMat4::from_translation(t),
            inverse: DMat4::from_translation(-t),
        }
    }

    /// Scaling along the axes; a zero component makes the inverse non-finite.
    pub fn scale(s: DVec3) -> Transform {
        Transform {
            m: DMat4::from_scale(s),
            inverse: DMat4::from_scale(s.recip()),
        }
    }

    /// Rotation by `degrees` about `axis` (not necessarily a unit vector); the identity for a zero axis.
    pub fn rotate(degrees: f64, axis: DVec3) -> Transform {
        let Some(axis) = axis.try_normalize() else {
            return Transform::IDENTITY;
        };
        let m = DMat4::from_axis_angle(axis, degrees.to_radians());
        Transform {
            m,
            inverse: m.transpose(),
        }
    }

    /// World to camera for a camera at `eye` looking at `look`, left-handed (x right, y up, z forward). `None` if `up`
    /// is parallel to the viewing direction or the points coincide.
    pub fn look_at(eye: DVec3, look: DVec3, up: DVec3) -> Option<Transform> {
        let d = (look - eye).try_normalize()?;
        let r = up.try_normalize()?.cross(d).try_normalize()?;
        let u = d.cross(r);
        let camera_to_world =
            DMat4::from_cols(r.extend(0.0), u.extend(0.0), d.extend(0.0), eye.extend(1.0));
        Some(Transform {
            m: camera_to_world.inverse(),
            inverse: camera_to_world,
        })
    }

    /// The inverse transformation.
    pub fn inverted(&self) -> Transform {
        Transform {
            m: self.inverse,
            inverse: self.m,
        }
    }

    /// Transforms a point, dividing by w if it is not 1.
    pub fn point(&self, p: DVec3) -> DVec3 {
        let q: DVec4 = self.m * p.extend(1.0);
        if q.w == 1.0 {
            q.truncate()
        } else {
            q.truncate() / q.w
        }
    }

    /// Transforms a vector (no translation).
    pub fn vector(&self, v: DVec3) -> DVec3 {
        self.m.transform_vector3(v)
    }

    /// Transforms a normal by the inverse transpose; the result is not normalized.
    pub fn normal(&self, n: DVec3) -> DVec3 {
        DMat3::from_mat4(self.inverse).transpose_mul_vec3(n)
    }

    /// Returns `true` if the transformation mirrors: the determinant of its upper 3×3 part is negative.
    pub fn swaps_handedness(&self) -> bool {
        DMat3::from_mat4(self.m).determinant() < 0.0
    }

    /// The same, with the inverse's translation computed from the matrix's. If a chain of large translations cancels,
    /// matrix and inverse round differently and stop being each other's inverse by units of what canceled; after this,
    /// only by units of what is left.
    pub fn with_translations_matched(mut self) -> Transform {
        let back = -self.inverse.transform_vector3(self.m.w_axis.truncate());
        self.inverse.w_axis = back.extend(1.0);
        self
    }

    /// The scale factor if the transformation is a similarity (rotation, reflection, uniform scale, translation).
    pub fn similarity(&self) -> Option<f64> {
        let m = DMat3::from_mat4(self.m);
        let product = m.transpose() * m;
        let scale2 = (product.x_axis.x + product.y_axis.y + product.z_axis.z) / 3.0;
        let off = product - DMat3::from_diagonal(DVec3::splat(scale2));
        // Rotations written with single-precision values are orthogonal to 1e-7.
        (largest_entry(&off) <= 1e-6 * scale2).then(|| scale2.sqrt())
    }

    /// Returns `true` if all matrix and inverse entries are finite.
    pub fn is_invertible(&self) -> bool {
        self.m.is_finite() && self.inverse.is_finite()
    }
}

impl std::ops::Mul for Transform {
    type Output = Transform;

    fn mul(self, b: Transform) -> Transform {
        Transform {
            m: self.m * b.m,
            inverse: b.inverse * self.inverse,
        }
    }
}

/// The placement of one space within another.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// From the inner space to the outer one.
    pub outer_from_inner: DAffine3,
    /// The inverse.
    pub inner_from_outer: DAffine3,
}

impl Place {
    /// By an affine transformation.
    pub fn new(outer_from_inner: &Transform) -> Place {
        Place {
            outer_from_inner: DAffine3::from_mat4(outer_from_inner.m),
            inner_from_outer: DAffine3::from_mat4(outer_from_inner.inverse),
        }
    }

    /// Origin and direction of a ray, in the inner space.
    #[inline]
    pub fn inward(&self, o: DVec3, d: DVec3) -> (DVec3, DVec3) {
        let inverse = &self.inner_from_outer;
        (inverse.transform_point3(o), inverse.transform_vector3(d))
    }
}

/// The largest absolute value of an entry.
pub(super) fn largest_entry(m: &DMat3) -> f64 {
    let entries = m.to_cols_array();
    entries.iter().fold(0.0, |largest, x| largest.max(x.abs()))
}

/// Corners of the smallest box that contains the points; `min > max` if there is none.
pub fn box_around(points: impl IntoIterator<Item = DVec3>) -> (DVec3, DVec3) {
    let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let extend = |(min, max): (DVec3, DVec3), p: DVec3| (min.min(p), max.max(p));
    points.into_iter().fold(nothing, extend)
}

/// The eight corners of the box from `low` to `high`.
pub fn box_corners(low: DVec3, high: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        let high_in = [0, 1, 2].map(|axis| i >> axis & 1 == 1);
        DVec3::select(high_in.into(), high, low)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotation_follows_the_ordinary_formula() {
        // A quarter turn about z takes x to y.
        let p = Transform::rotate(90.0, DVec3::Z).point(DVec3::X);
        assert!((p - DVec3::Y).length() < 1e-15);
    }

    #[test]
    fn look_at_is_left_handed() {
        let t = Transform::look_at(DVec3::new(0.0, 0.0, -5.0), DVec3::ZERO, DVec3::Y).unwrap();
        assert!((t.point(DVec3::new(1.0, 2.0, 0.0)) - DVec3::new(1.0, 2.0, 5.0)).length() < 1e-14);
        assert!(Transform::look_at(DVec3::ZERO, DVec3::Y, DVec3::Y).is_none());
    }

    #[test]
    fn product_applies_the_right_factor_first() {
        let t = Transform::translate(DVec3::X) * Transform::scale(DVec3::splat(2.0));
        assert_eq!(t.point(DVec3::ONE), DVec3::new(3.0, 2.0, 2.0));
        assert!((t.inverted().point(DVec3::new(3.0, 2.0, 2.0)) - DVec3::ONE).length() < 1e-15);
    }

    #[test]
    fn normals_stay_perpendicular_under_uneven_scale() {
        let t = Transform::scale(DVec3::new(1.0, 3.0, 0.5))
            * Transform::rotate(33.0, DVec3::new(1.0, 2.0, 3.0));
        let (v, n) = (DVec3::new(1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 0.3));
        assert!(v.dot(n).abs() < 1e-15);
        assert!(t.vector(v).dot(t.normal(n)).abs() < 1e-14);
    }
}
