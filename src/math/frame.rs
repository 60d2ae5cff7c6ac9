//! Orthonormal frames.

use super::Vec3;

/// Two unit vectors that complete the unit vector `n` to a right-handed orthonormal basis
/// (s, t, n), without branches or loss of precision near the pole
/// (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017).
#[inline(always)]
pub fn coordinate_system(n: Vec3) -> (Vec3, Vec3) {
    let sign = 1.0f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (
        Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        Vec3::new(b, sign + n.y * n.y * a, -n.y),
    )
}

/// An orthonormal frame; local z is the normal.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Local x axis.
    pub s: Vec3,
    /// Local y axis.
    pub t: Vec3,
    /// Local z axis.
    pub n: Vec3,
}

impl Frame {
    /// The frame with local x along `dpdu`, made perpendicular to the unit normal `n`; any frame around `n` if the two
    /// are parallel or `dpdu` is degenerate.
    #[inline]
    pub fn from_normal_and_tangent(n: Vec3, dpdu: Vec3) -> Frame {
        if dpdu == Vec3::ZERO {
            return Frame::from_normal(n);
        }
        let s = dpdu - n * n.dot(dpdu);
        let len2 = s.length_squared();
        if len2 > 1e-14 * dpdu.length_squared() && len2.is_finite() {
            let s = s / len2.sqrt();
            return Frame {
                s,
                t: n.cross(s),
                n,
            };
        }
        Frame::from_normal(n)
    }

    /// Any frame around the unit normal `n`.
    #[inline(always)]
    pub fn from_normal(n: Vec3) -> Frame {
        let (s, t) = coordinate_system(n);
        Frame { s, t, n }
    }

    /// World to local.
    #[inline(always)]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.s), v.dot(self.t), v.dot(self.n))
    }

    /// Local to world.
    #[inline(always)]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.s * v.x + self.t * v.y + self.n * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_everywhere() {
        for i in 0..2000 {
            let z = -1.0 + 2.0 * (i as f32) / 1999.0;
            let phi = i as f32 * 2.4;
            let r = (1.0 - z * z).max(0.0).sqrt();
            let n = Vec3::new(r * phi.cos(), r * phi.sin(), z).normalize();
            let f = Frame::from_normal(n);
            // Single-precision products of unit vectors.
            assert!(
                f.s.dot(f.t).abs() < 1e-6 && f.s.dot(n).abs() < 1e-6 && f.t.dot(n).abs() < 1e-6
            );
            assert!((f.s.cross(f.t) - n).length() < 1e-6);
        }
    }
}
