//! `Shape "cone"`: the side of a cone with its base circle at z = 0 and its apex above it.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | `float radius` | 1 | of the base circle |
//! | `float height` | 1 | z of the apex |
//! | `float phimax` | 360 | degrees swept from +x toward +y, clamped to 0…360 |
//!
//! u = φ/φmax; v = z/height; the normal points outward and up
//! (docs/scene-language.md §3.7; Pharr, Jakob and Humphreys 2016, §3.5).

use super::positive;
use super::quadric::{ObjectPoint, ObjectSurface, Swept, azimuth, roots};
use crate::math::{DVec2, DVec3, Vec2};
use crate::params::ParamReader;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Radius of the base circle, object units.
    pub radius: f64,
    /// Height of the apex.
    pub height: f64,
    /// From the base to the apex.
    pub swept: Swept,
}

impl Cone {
    /// A cone, swept `phi_max` degrees.
    pub fn new(radius: f64, height: f64, phi_max: f64) -> Cone {
        Cone {
            radius,
            height,
            swept: Swept::new(0.0, height, phi_max),
        }
    }

    /// Reads the parameters; `None` where radius or height is not positive (reported).
    pub fn from_params(reader: &ParamReader) -> Option<Cone> {
        let radius = reader.float("radius", 1.0);
        let height = reader.float("height", 1.0);
        let phi_max = reader.float("phimax", 360.0);
        positive(reader, "radius", radius)?;
        positive(reader, "height", height)?;
        Some(Cone::new(radius, height, phi_max))
    }

    /// The point of the surface nearest to `p` at its height.
    fn onto_surface(&self, p: DVec3) -> DVec3 {
        let rho = self.radius * (1.0 - p.z / self.height);
        let length = p.truncate().length();
        if length > 0.0 {
            (p.truncate() * (rho / length)).extend(p.z)
        } else {
            p
        }
    }
}

impl ObjectSurface for Cone {
    fn intersect(&self, o: DVec3, d: DVec3) -> Option<(f64, DVec3)> {
        // x² + y² = (s z')² with slope s and z' measured from the apex, downward or upward.
        let slope = self.radius / self.height;
        let (o2, d2) = (o.truncate(), d.truncate());
        let (oz, dz) = (slope * (o.z - self.height), slope * d.z);
        let a = d2.length_squared() - dz * dz;
        let b = o2.dot(d2) - oz * dz;
        let distance = o2.length();
        let c = (distance - oz) * (distance + oz);
        // b² − a c, written as Lagrange's identity so that nothing large cancels:
        // |o2 dz − d2 oz|² − (o2 × d2)².
        let turn = o2.perp_dot(d2);
        let discriminant = (o2 * dz - d2 * oz).length_squared() - turn * turn;
        let roots = roots(a, b, c, discriminant)?.into_iter();
        roots
            .map(|t| (t, self.onto_surface(o + d * t)))
            .find(|&(t, p)| t > 0.0 && self.swept.contains(p))
    }

    fn approximate_uv(&self, p: DVec3) -> Vec2 {
        self.swept.approximate_uv(p)
    }

    fn at(&self, p: DVec3) -> ObjectPoint {
        let (sin, cos) = azimuth(p).sin_cos();
        let side = self.height.hypot(self.radius);
        // Cosine and sine of the normal's elevation.
        let (level, up) = (self.height / side, self.radius / side);
        ObjectPoint {
            uv: self.swept.uv(p),
            n: DVec3::new(level * cos, level * sin, up),
            dpdu: self.swept.dpdu(p),
            dpdv: DVec3::new(-self.radius * cos, -self.radius * sin, self.height),
            dndu: self.swept.phi_max * level * DVec3::new(-sin, cos, 0.0),
            dndv: DVec3::ZERO,
        }
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        self.swept.bounds(self.radius)
    }

    fn sample(&self, u: DVec2) -> DVec3 {
        // Circumference grows linearly from the apex.
        let from_apex = u.x.sqrt();
        let z = self.height * (1.0 - from_apex);
        self.swept.point(self.radius * from_apex, u.y, z)
    }

    fn area(&self) -> f64 {
        0.5 * self.swept.phi_max * self.radius * self.height.hypot(self.radius)
    }
}

#[cfg(test)]
mod tests {
    use super::super::quadric::tests::{check_derivatives, check_hits, check_uniform};
    use super::*;

    #[test]
    fn the_mirrored_half_above_the_apex_is_not_there() {
        let cone = Cone::new(1.0, 2.0, 360.0);
        assert!(
            cone.intersect(DVec3::new(-5.0, 0.0, 3.0), DVec3::X)
                .is_none()
        );
        // At half height the radius is half.
        let (t, p) = cone
            .intersect(DVec3::new(-5.0, 0.0, 1.0), DVec3::X)
            .unwrap();
        assert!((t - 4.5).abs() < 1e-14 && (p - DVec3::new(-0.5, 0.0, 1.0)).length() < 1e-14);
        // Parallel to the side: one meeting only.
        let along = DVec3::new(1.0, 0.0, -2.0);
        let (_, p) = cone.intersect(DVec3::new(-1.0, 0.0, 3.0), along).unwrap();
        assert!((p.x - 0.0).abs() < 1.0 && p.z >= 0.0);
        // No base cap.
        let (_, p) = cone
            .intersect(DVec3::new(0.5, 0.0, -1.0), DVec3::Z)
            .unwrap();
        assert!((p.z - 1.0).abs() < 1e-14);
    }

    #[test]
    fn partial_cones_have_the_stated_parameters() {
        for cone in [Cone::new(0.8, 1.7, 360.0), Cone::new(1.3, 0.4, 250.0)] {
            check_derivatives(&cone);
            check_hits(&cone);
            check_uniform(&cone);
        }
    }
}
