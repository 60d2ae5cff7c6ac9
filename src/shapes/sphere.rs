//! `Shape "sphere"`: a sphere about the origin, or the part of it between two heights and within
//! an angle.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | `float radius` | 1 | |
//! | `float zmin`, `float zmax` | ∓radius | heights of the cuts, sorted and clamped to ±radius |
//! | `float phimax` | 360 | degrees swept from +x toward +y, clamped to 0…360 |
//!
//! u = φ/φmax; v runs with the polar angle from the zmin end (0) to the zmax end (1)
//! (docs/scene-language.md §3.7; Pharr, Jakob and Humphreys 2016, §3.2).

use super::positive;
use super::quadric::{ObjectPoint, ObjectSurface, Swept, azimuth, outward, roots};
use crate::math::angle::turns;
use crate::math::{DVec2, DVec3, Vec2, Vec3};
use crate::params::ParamReader;
use std::f64::consts::TAU;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Radius, object units.
    pub radius: f64,
    /// Cut at ∓radius, which is nowhere, for a whole one.
    pub swept: Swept,
    /// Polar angles of the cuts: v = 0 at the first, 1 at the second.
    polar_range: [f64; 2],
}

impl Sphere {
    /// A sphere between the heights `z0` and `z1` (in either order), swept `phi_max` degrees.
    pub fn new(radius: f64, z0: f64, z1: f64, phi_max: f64) -> Sphere {
        let [z0, z1] = [z0, z1].map(|z| z.clamp(-radius, radius));
        let swept = Swept::new(z0, z1, phi_max);
        Sphere {
            radius,
            swept,
            polar_range: [swept.z_min, swept.z_max].map(|z| polar(z, radius)),
        }
    }

    /// Reads the parameters; `None` where the radius is not positive (reported).
    pub fn from_params(reader: &ParamReader) -> Option<Sphere> {
        let radius = reader.float("radius", 1.0);
        let (z0, z1) = (reader.float("zmin", -radius), reader.float("zmax", radius));
        let phi_max = reader.float("phimax", 360.0);
        positive(reader, "radius", radius)?;
        Some(Sphere::new(radius, z0, z1, phi_max))
    }

    /// Nothing is cut off.
    pub fn is_full(&self) -> bool {
        let Swept {
            z_min,
            z_max,
            phi_max,
        } = self.swept;
        z_min <= -self.radius && z_max >= self.radius && phi_max >= TAU
    }

    /// Rounding may move poles out of a sphere that has both.
    fn contains(&self, p: DVec3) -> bool {
        let Swept { z_min, z_max, .. } = self.swept;
        (z_min <= -self.radius || p.z >= z_min)
            && (z_max >= self.radius || p.z <= z_max)
            && self.swept.sweeps(|| azimuth(p))
    }

    /// The parameter v at a polar angle.
    fn v(&self, polar: f64) -> f64 {
        let [first, last] = self.polar_range;
        let range = last - first;
        match range {
            0.0 => 0.0,
            _ => (polar - first) / range,
        }
    }
}

/// The polar angle at a height of a sphere.
fn polar(z: f64, radius: f64) -> f64 {
    (z / radius).clamp(-1.0, 1.0).acos()
}

impl ObjectSurface for Sphere {
    fn intersect(&self, o: DVec3, d: DVec3) -> Option<(f64, DVec3)> {
        let r = self.radius;
        let (a, b) = (d.length_squared(), o.dot(d));
        let distance = o.length();
        let c = (distance - r) * (distance + r);
        // a (r² − |o⊥|²) with o⊥ the part of o across the ray: b² − a c cancels badly for
        // distant origins (Hearn and Baker; Haines et al., Ray Tracing Gems 2019, ch. 7).
        let across = o - d * (b / a);
        let discriminant = a * (r * r - across.length_squared());
        let roots = roots(a, b, c, discriminant)?.into_iter();
        let onto_surface = |p: DVec3| p * (r / p.length());
        roots
            .filter(|&t| t > 0.0)
            .map(|t| (t, onto_surface(o + d * t)))
            .find(|&(_, p)| self.contains(p))
    }

    fn at(&self, p: DVec3) -> ObjectPoint {
        let (rho, outward) = outward(p);
        let [first, last] = self.polar_range;
        let dpdu = self.swept.dpdu(p);
        let dpdv = (last - first) * (outward * p.z).extend(-rho);
        ObjectPoint {
            uv: DVec2::new(self.swept.uv(p).x, self.v(polar(p.z, self.radius))),
            n: self.normal(p),
            dpdu,
            dpdv,
            dndu: dpdu / self.radius,
            dndv: dpdv / self.radius,
        }
    }

    fn normal(&self, p: DVec3) -> DVec3 {
        p / self.radius
    }

    fn approximate_uv(&self, p: DVec3) -> Vec2 {
        let Vec3 { x, y, z } = (p * (1.0 / self.radius)).as_vec3();
        let [first, last] = self.polar_range;
        if (last - first).abs() < 1.0 {
            // The polar angle's error is more of the range of a narrow band.
            return self.at(p).uv.as_vec2();
        }
        let u = turns(x, y) * (TAU / self.swept.phi_max) as f32;
        let polar = turns(z, (x * x + y * y).sqrt());
        Vec2::new(u, self.v(TAU * f64::from(polar)) as f32)
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        self.swept.bounds(self.radius)
    }

    fn sample(&self, u: DVec2) -> DVec3 {
        // Archimedes: equal heights have equal areas.
        let z = self.swept.z_min + u.x * self.swept.height();
        let rho = ((self.radius - z) * (self.radius + z)).max(0.0).sqrt();
        self.swept.point(rho, u.y, z)
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
    fn first_hit_is_the_near_side_then_the_far_side() {
        let sphere = Sphere::new(2.0, -2.0, 2.0, 360.0);
        let (t, p) = sphere
            .intersect(DVec3::new(0.0, 0.0, -5.0), DVec3::Z)
            .unwrap();
        assert_eq!((t, p), (3.0, DVec3::new(0.0, 0.0, -2.0)));
        let (t, _) = sphere.intersect(DVec3::ZERO, DVec3::Z).unwrap();
        assert_eq!(t, 2.0);
        assert!(
            sphere
                .intersect(DVec3::new(0.0, 0.0, 2.1), DVec3::Z)
                .is_none()
        );
        // A tangent ray just inside meets it, just outside does not.
        assert!(
            sphere
                .intersect(DVec3::new(1.999_999_9, 0.0, -5.0), DVec3::Z)
                .is_some()
        );
        assert!(
            sphere
                .intersect(DVec3::new(2.000_000_1, 0.0, -5.0), DVec3::Z)
                .is_none()
        );
    }

    #[test]
    fn cuts_are_sorted_and_clamped() {
        let s = Sphere::new(1.0, 7.0, -0.5, 400.0);
        assert_eq!(s.swept, Swept::new(-0.5, 1.0, 360.0));
        assert!(!s.is_full());
        assert!(Sphere::new(1.0, -1.0, 1.0, 360.0).is_full());
    }

    #[test]
    fn partial_spheres_have_the_stated_parameters() {
        for s in [
            Sphere::new(1.5, -1.5, 1.5, 360.0),
            Sphere::new(1.5, -0.4, 1.1, 200.0),
        ] {
            check_derivatives(&s);
            check_hits(&s);
            check_uniform(&s);
        }
        let s = Sphere::new(1.0, -1.0, 1.0, 360.0);
        assert!((s.at(DVec3::new(0.0, 0.0, -1.0)).uv.y).abs() < 1e-15);
        assert!((s.at(DVec3::new(0.0, 1.0, 0.0)).uv - DVec2::new(0.25, 0.5)).length() < 1e-15);
    }
}
