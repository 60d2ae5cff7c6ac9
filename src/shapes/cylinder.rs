//! `Shape "cylinder"`: the side of a cylinder about the z axis, without caps.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | `float radius` | 1 | |
//! | `float zmin`, `float zmax` | −1, 1 | ends, sorted |
//! | `float phimax` | 360 | degrees swept from +x toward +y, clamped to 0…360 |
//!
//! u = φ/φmax; v = (z − zmin)/(zmax − zmin); the normal points outward
//! (docs/scene-language.md §3.7; Pharr, Jakob and Humphreys 2016, §3.3).

use super::positive;
use super::quadric::{ObjectPoint, ObjectSurface, Swept, roots};
use crate::math::{DVec2, DVec3, Vec2};
use crate::params::ParamReader;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Radius, object units.
    pub radius: f64,
    /// From end to end.
    pub swept: Swept,
}

impl Cylinder {
    /// A cylinder between the heights `z0` and `z1` (in either order), swept `phi_max` degrees.
    pub fn new(radius: f64, z0: f64, z1: f64, phi_max: f64) -> Cylinder {
        Cylinder {
            radius,
            swept: Swept::new(z0, z1, phi_max),
        }
    }

    /// Reads the parameters; `None` where the radius is not positive (reported).
    pub fn from_params(reader: &ParamReader) -> Option<Cylinder> {
        let radius = reader.float("radius", 1.0);
        let (z0, z1) = (reader.float("zmin", -1.0), reader.float("zmax", 1.0));
        let phi_max = reader.float("phimax", 360.0);
        positive(reader, "radius", radius)?;
        Some(Cylinder::new(radius, z0, z1, phi_max))
    }

    /// The nearest point with t > 0 on a ray, before it is put onto the surface.
    #[inline(always)]
    fn meet(&self, o: DVec3, d: DVec3) -> Option<(f64, DVec3)> {
        let r = self.radius;
        let (o2, d2) = (o.truncate(), d.truncate());
        let (a, b) = (d2.length_squared(), o2.dot(d2));
        if a == 0.0 || self.swept.is_left_by(o.z, d.z) {
            return None;
        }
        let distance = o2.length();
        let c = (distance - r) * (distance + r);
        // Away from the axis, and beyond the surface already.
        if c > 0.0 && b > 0.0 {
            return None;
        }
        // As for the sphere, in the plane across the axis.
        let across = o2 - d2 * (b / a);
        let discriminant = a * (r * r - across.length_squared());
        { roots(a, b, c, discriminant)?.into_iter() }
            .filter(|&t| t > 0.0)
            .map(|t| (t, o + d * t))
            .find(|&(_, p)| self.swept.contains(p))
    }
}

impl ObjectSurface for Cylinder {
    fn intersect(&self, o: DVec3, d: DVec3) -> Option<(f64, DVec3)> {
        let (t, p) = self.meet(o, d)?;
        // Onto the surface: that changes neither height nor angle.
        let across = p.truncate();
        Some((t, (across * (self.radius / across.length())).extend(p.z)))
    }

    fn distance(&self, o: DVec3, d: DVec3) -> Option<f64> {
        self.meet(o, d).map(|(t, _)| t)
    }

    fn approximate_uv(&self, p: DVec3) -> Vec2 {
        self.swept.approximate_uv(p)
    }

    fn at(&self, p: DVec3) -> ObjectPoint {
        let dpdu = self.swept.dpdu(p);
        ObjectPoint {
            uv: self.swept.uv(p),
            n: self.normal(p),
            dpdu,
            dpdv: DVec3::new(0.0, 0.0, self.swept.height()),
            dndu: dpdu / self.radius,
            dndv: DVec3::ZERO,
        }
    }

    fn normal(&self, p: DVec3) -> DVec3 {
        DVec3::new(p.x, p.y, 0.0) / self.radius
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        self.swept.bounds(self.radius)
    }

    fn sample(&self, u: DVec2) -> DVec3 {
        let z = self.swept.z_min + u.x * self.swept.height();
        self.swept.point(self.radius, u.y, z)
    }

    fn area(&self) -> f64 {
        self.swept.phi_max * self.radius * self.swept.height()
    }
}

#[cfg(test)]
mod tests {
    use super::super::quadric::tests::{check_derivatives, check_hits, check_uniform};
    use super::*;

    #[test]
    fn open_ends_let_rays_through() {
        let c = Cylinder::new(1.0, -1.0, 1.0, 360.0);
        assert!(c.intersect(DVec3::new(0.3, 0.0, -5.0), DVec3::Z).is_none());
        // In by the open end, out through the side: 1 to the right, 1 up.
        let (t, p) = c
            .intersect(DVec3::new(0.0, 0.0, -0.5), DVec3::new(1.0, 0.0, 1.0))
            .unwrap();
        assert_eq!((t, p), (1.0, DVec3::new(1.0, 0.0, 0.5)));
        let (t, _) = c.intersect(DVec3::new(-3.0, 0.0, 0.0), DVec3::X).unwrap();
        assert_eq!(t, 2.0);
    }

    /// Rays that are known to miss without a root, and those next to them, which hit.
    #[test]
    fn rays_that_leave_miss_and_their_neighbors_hit() {
        let c = Cylinder::new(1.0, -1.0, 1.0, 360.0);
        let distance = |o: [f64; 3], d: [f64; 3]| {
            let (o, d) = (DVec3::from(o), DVec3::from(d));
            assert_eq!(c.distance(o, d), c.intersect(o, d).map(|(t, _)| t));
            c.distance(o, d)
        };
        // Above and rising, or level; above and falling.
        assert_eq!(distance([0.0, 0.0, 1.5], [1.0, 0.0, 0.5]), None);
        assert_eq!(distance([0.0, 0.0, 1.5], [1.0, 0.0, 0.0]), None);
        assert_eq!(distance([0.0, 0.0, 1.5], [1.0, 0.0, -1.0]), Some(1.0));
        // Below and falling; below and rising. At the end's own height.
        assert_eq!(distance([0.0, 0.0, -1.5], [1.0, 0.0, -0.5]), None);
        assert_eq!(distance([0.0, 0.0, -1.5], [1.0, 0.0, 1.0]), Some(1.0));
        assert_eq!(distance([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]), Some(1.0));
        // Outside and away from the axis; inside and away from it; outside and toward it.
        assert_eq!(distance([1.5, 0.0, 0.0], [1.0, 0.0, 0.0]), None);
        assert_eq!(distance([0.5, 0.0, 0.0], [1.0, 0.0, 0.0]), Some(0.5));
        assert_eq!(distance([1.5, 0.0, 0.0], [-1.0, 0.0, 0.0]), Some(0.5));
        // From the surface itself inward, to its other side.
        assert_eq!(distance([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]), Some(2.0));
    }

    #[test]
    fn partial_cylinders_have_the_stated_parameters() {
        for c in [
            Cylinder::new(0.8, 2.0, -1.0, 360.0),
            Cylinder::new(0.8, 0.0, 1.0, 100.0),
        ] {
            check_derivatives(&c);
            check_hits(&c);
            check_uniform(&c);
        }
    }
}
