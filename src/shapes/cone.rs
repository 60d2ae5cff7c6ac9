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
use super::quadric::{ObjectPoint, ObjectSurface, azimuth, roots, sweep};
use crate::math::{DVec2, DVec3};
use crate::params::ParamReader;
use std::f64::consts::TAU;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Radius of the base circle, object units.
    pub radius: f64,
    /// Height of the apex.
    pub height: f64,
    /// Angle swept, radians.
    pub phi_max: f64,
}

impl Cone {
    /// A cone, swept `phi_max` degrees.
    pub fn new(radius: f64, height: f64, phi_max: f64) -> Cone {
        Cone {
            radius,
            height,
            phi_max: sweep(phi_max),
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
        for t in roots(a, b, c, discriminant)? {
            let p = self.onto_surface(o + d * t);
            let inside = p.z >= 0.0
                && p.z <= self.height
                && (self.phi_max >= TAU || azimuth(p) <= self.phi_max);
            if t > 0.0 && inside {
                return Some((t, p));
            }
        }
        None
    }

    fn at(&self, p: DVec3) -> ObjectPoint {
        let phi = azimuth(p);
        let (sin, cos) = phi.sin_cos();
        let side = self.height.hypot(self.radius);
        // Cosine and sine of the normal's elevation.
        let (level, up) = (self.height / side, self.radius / side);
        ObjectPoint {
            uv: DVec2::new(phi / self.phi_max, p.z / self.height),
            n: DVec3::new(level * cos, level * sin, up),
            dpdu: self.phi_max * DVec3::new(-p.y, p.x, 0.0),
            dpdv: DVec3::new(-self.radius * cos, -self.radius * sin, self.height),
            dndu: self.phi_max * level * DVec3::new(-sin, cos, 0.0),
            dndv: DVec3::ZERO,
        }
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        let r = self.radius;
        (DVec3::new(-r, -r, 0.0), DVec3::new(r, r, self.height))
    }

    fn sample(&self, u: DVec2) -> DVec3 {
        // Circumference grows linearly from the apex.
        let from_apex = u.x.sqrt();
        let rho = self.radius * from_apex;
        let (sin, cos) = (u.y * self.phi_max).sin_cos();
        DVec3::new(rho * cos, rho * sin, self.height * (1.0 - from_apex))
    }

    fn area(&self) -> f64 {
        0.5 * self.phi_max * self.radius * self.height.hypot(self.radius)
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
