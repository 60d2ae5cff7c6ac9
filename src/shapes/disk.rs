//! `Shape "disk"`: a flat disk or ring at a height above the xy plane.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | `float height` | 0 | z of the plane |
//! | `float radius` | 1 | outer radius |
//! | `float innerradius` | 0 | radius of the hole |
//! | `float phimax` | 360 | degrees swept from +x toward +y, clamped to 0…360 |
//!
//! u = φ/φmax; v = 0 at the rim, 1 at the inner edge; the normal is +z
//! (docs/scene-language.md §3.7; Pharr, Jakob and Humphreys 2016, §3.4).

use super::positive;
use super::quadric::{ObjectPoint, ObjectSurface, Swept, outward};
use crate::math::{DVec2, DVec3, Vec2};
use crate::params::ParamReader;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disk {
    /// Outer radius, object units.
    pub radius: f64,
    /// Radius of the hole, from 0 to `radius`.
    pub inner_radius: f64,
    /// Both ends are the plane.
    pub swept: Swept,
}

impl Disk {
    /// A ring at `height`, swept `phi_max` degrees.
    pub fn new(height: f64, radius: f64, inner_radius: f64, phi_max: f64) -> Disk {
        Disk {
            radius,
            inner_radius: inner_radius.clamp(0.0, radius),
            swept: Swept::new(height, height, phi_max),
        }
    }

    /// Reads the parameters; `None` where the radius is not positive (reported).
    pub fn from_params(reader: &ParamReader) -> Option<Disk> {
        let height = reader.float("height", 0.0);
        let radius = reader.float("radius", 1.0);
        let inner_radius = reader.float("innerradius", 0.0);
        let phi_max = reader.float("phimax", 360.0);
        positive(reader, "radius", radius)?;
        if inner_radius >= radius {
            reader.warn(
                "innerradius",
                "the hole is as large as the disk: nothing is left of it",
            );
        }
        Some(Disk::new(height, radius, inner_radius, phi_max))
    }
}

impl ObjectSurface for Disk {
    fn intersect(&self, o: DVec3, d: DVec3) -> Option<(f64, DVec3)> {
        let height = self.swept.z_min;
        let t = (height - o.z) / d.z;
        if !(t > 0.0 && t.is_finite()) {
            return None;
        }
        let p = DVec3::new(o.x + t * d.x, o.y + t * d.y, height);
        let rho2 = p.x * p.x + p.y * p.y;
        let inside = rho2 <= self.radius * self.radius
            && rho2 >= self.inner_radius * self.inner_radius
            && self.swept.contains(p);
        inside.then_some((t, p))
    }

    fn approximate_uv(&self, p: DVec3) -> Vec2 {
        let v = (self.radius - p.truncate().length()) / (self.radius - self.inner_radius);
        Vec2::new(self.swept.approximate_uv(p).x, v as f32)
    }

    fn at(&self, p: DVec3) -> ObjectPoint {
        let (rho, outward) = outward(p);
        let width = self.radius - self.inner_radius;
        ObjectPoint {
            uv: DVec2::new(self.swept.uv(p).x, (self.radius - rho) / width),
            n: DVec3::Z,
            dpdu: self.swept.dpdu(p),
            dpdv: -width * outward.extend(0.0),
            dndu: DVec3::ZERO,
            dndv: DVec3::ZERO,
        }
    }

    fn normal(&self, _: DVec3) -> DVec3 {
        DVec3::Z
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        self.swept.bounds(self.radius)
    }

    fn sample(&self, u: DVec2) -> DVec3 {
        let [inner2, outer2] = [self.inner_radius, self.radius].map(|r| r * r);
        let rho = (inner2 + u.x * (outer2 - inner2)).sqrt();
        self.swept.point(rho, u.y, self.swept.z_min)
    }

    fn area(&self) -> f64 {
        let (outer, inner) = (self.radius, self.inner_radius);
        0.5 * self.swept.phi_max * (outer - inner) * (outer + inner)
    }
}

#[cfg(test)]
mod tests {
    use super::super::quadric::tests::{check_derivatives, check_hits, check_uniform};
    use super::*;

    #[test]
    fn a_ring_has_a_hole_and_a_rim() {
        let disk = Disk::new(3.0, 2.0, 1.0, 360.0);
        let hit = |x: f64| disk.intersect(DVec3::new(x, 0.0, 0.0), DVec3::Z);
        assert!(hit(0.99).is_none() && hit(2.01).is_none());
        assert_eq!(hit(1.5).unwrap(), (3.0, DVec3::new(1.5, 0.0, 3.0)));
        assert_eq!(disk.at(DVec3::new(2.0, 0.0, 3.0)).uv, DVec2::ZERO);
        assert_eq!(disk.at(DVec3::new(0.0, 1.0, 3.0)).uv, DVec2::new(0.25, 1.0));
        // A ray in the plane of the disk misses it.
        assert!(
            disk.intersect(DVec3::new(-5.0, 0.0, 3.0), DVec3::X)
                .is_none()
        );
    }

    #[test]
    fn rings_have_the_stated_parameters() {
        for disk in [
            Disk::new(0.5, 1.5, 0.0, 360.0),
            Disk::new(-1.0, 1.5, 0.7, 130.0),
        ] {
            check_derivatives(&disk);
            check_hits(&disk);
            check_uniform(&disk);
        }
    }
}
