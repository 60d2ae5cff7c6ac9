//! `Shape "paraboloid"`: the bowl z = zmax ρ²/radius² about the z axis, between two heights.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | `float radius` | 1 | distance from the axis at the height zmax |
//! | `float zmin`, `float zmax` | 0, 1 | ends, sorted; zmax also shapes the bowl |
//! | `float phimax` | 360 | degrees swept from +x toward +y, clamped to 0…360 |
//!
//! u = φ/φmax; v = (z − zmin)/(zmax − zmin); the normal points away from the axis
//! (docs/scene-language.md §3.7; Pharr, Jakob and Humphreys 2016, §3.6). Where zmax is negative the bowl
//! opens downward and `radius` is that of the upper, narrower end.

use super::quadric::{ObjectPoint, ObjectSurface, Swept, azimuth, nearest_approach, roots};
use super::{left_out, positive};
use crate::math::{DVec2, DVec3, Vec2};
use crate::params::ParamReader;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paraboloid {
    /// Radius at the upper end, object units.
    pub radius: f64,
    /// From end to end; the upper one is not at 0.
    pub swept: Swept,
}

impl Paraboloid {
    /// The part between the heights `z0` and `z1` (in either order), swept `phi_max` degrees. The
    /// larger height must not be 0.
    pub fn new(radius: f64, z0: f64, z1: f64, phi_max: f64) -> Paraboloid {
        Paraboloid {
            radius,
            swept: Swept::new(z0, z1, phi_max),
        }
    }

    /// Reads the parameters; `None` where the radius is not positive or the bowl has no shape
    /// (reported).
    pub fn from_params(reader: &ParamReader) -> Option<Paraboloid> {
        let radius = reader.float("radius", 1.0);
        let (z0, z1) = (reader.float("zmin", 0.0), reader.float("zmax", 1.0));
        let phi_max = reader.float("phimax", 360.0);
        positive(reader, "radius", radius)?;
        if z0.max(z1) == 0.0 || !(z0.is_finite() && z1.is_finite()) {
            let why = "z = zmax ρ²/radius² has no shape where the upper end is at 0 or an end at no height";
            return left_out(reader, "zmax", why);
        }
        if z0 == z1 {
            reader.warn("zmax", "both ends are at one height: nothing is left of it");
        }
        Some(Paraboloid::new(radius, z0, z1, phi_max))
    }

    /// 1/k of z = k ρ².
    fn span(&self) -> f64 {
        self.radius * (self.radius / self.swept.z_max)
    }

    /// Distances from the axis at the ends, zmin's first; there is nothing beyond the apex.
    fn radii(&self) -> [f64; 2] {
        [self.swept.z_min, self.swept.z_max].map(|z| (z * self.span()).max(0.0).sqrt())
    }

    /// The point moved onto the surface: along the axis where the bowl is flat, and across it
    /// where it is steep. (Across it alone the apex would be out of reach.)
    fn onto_surface(&self, p: DVec3) -> DVec3 {
        let (rho, span) = (p.truncate().length(), self.span());
        if 2.0 * rho < span.abs() {
            p.truncate().extend(rho * (rho / span))
        } else {
            let exact = (p.z * span).max(0.0).sqrt();
            (p.truncate() * (exact / rho)).extend(p.z)
        }
    }

    /// A number that grows from 0 at the apex as the area within the distance `rho` of the axis:
    /// (1 + 4k²ρ²)^(3/2) − 1, without cancellation where the bowl is flat.
    fn area_within(&self, rho: f64) -> f64 {
        let slope = 2.0 * rho / self.span();
        (1.5 * (slope * slope).ln_1p()).exp_m1()
    }

    /// The distance from the axis within which [`Paraboloid::area_within`] is `area`.
    fn radius_of(&self, area: f64) -> f64 {
        let slope2 = (area.ln_1p() / 1.5).exp_m1();
        0.5 * self.span().abs() * slope2.sqrt()
    }
}

impl ObjectSurface for Paraboloid {
    fn intersect(&self, o: DVec3, d: DVec3) -> Option<(f64, DVec3)> {
        // ρ² = s z, from where the ray is nearest to the shape.
        let (start, o) = nearest_approach(o, d, self.swept.center());
        let (o2, d2, s) = (o.truncate(), d.truncate(), self.span());
        let a = d2.length_squared();
        let b = o2.dot(d2) - 0.5 * s * d.z;
        let c = o2.length_squared() - s * o.z;
        // b² − a c, with Lagrange's identity for the part that cancels for rays across the axis.
        let turn = o2.perp_dot(d2);
        let discriminant = s * (0.25 * s * d.z * d.z - o2.dot(d2) * d.z + a * o.z) - turn * turn;
        let roots = roots(a, b, c, discriminant)?.into_iter();
        roots
            .map(|t| (start + t, self.onto_surface(o + d * t)))
            .find(|&(t, p)| t > 0.0 && self.swept.contains(p))
    }

    fn approximate_uv(&self, p: DVec3) -> Vec2 {
        self.swept.approximate_uv(p)
    }

    fn at(&self, p: DVec3) -> ObjectPoint {
        let (sin, cos) = azimuth(p).sin_cos();
        let height = self.swept.height();
        let rho = p.truncate().length();
        // The gradient of k ρ² − z over 2k.
        let half = 0.5 * self.span();
        let side = rho.hypot(half);
        let (level, down) = (rho / side, half / side);
        // At the apex the meridian runs level and ∂p/∂v is infinite; short of that it is long.
        let along = height * half / rho.max(1e-9 * self.radius);
        let turn = half * half / (side * side * side);
        ObjectPoint {
            uv: self.swept.uv(p),
            n: DVec3::new(level * cos, level * sin, -down),
            dpdu: self.swept.dpdu(p),
            dpdv: DVec3::new(along * cos, along * sin, height),
            dndu: self.swept.phi_max * level * DVec3::new(-sin, cos, 0.0),
            dndv: along * turn * DVec3::new(cos, sin, rho / half),
        }
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        let [r0, r1] = self.radii();
        self.swept.bounds(r0.max(r1))
    }

    fn sample(&self, u: DVec2) -> DVec3 {
        let [inner, outer] = self.radii().map(|rho| self.area_within(rho));
        let rho = self.radius_of(inner + u.x * (outer - inner));
        let z = rho * (rho / self.span());
        let z = z.clamp(self.swept.z_min, self.swept.z_max);
        self.swept.point(rho, u.y, z)
    }

    fn area(&self) -> f64 {
        // ∫ ρ √(1 + 4k²ρ²) dρ = (1 + 4k²ρ²)^(3/2) / (12 k²).
        let [a0, a1] = self.radii().map(|rho| self.area_within(rho));
        self.swept.phi_max * self.span() * self.span() / 12.0 * (a1 - a0).abs()
    }
}

#[cfg(test)]
mod tests {
    use super::super::quadric::tests::{check_derivatives, check_hits, check_uniform};
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn heights_follow_the_square_of_the_radius() {
        let bowl = Paraboloid::new(2.0, 0.0, 3.0, 360.0);
        // z = 3/4 ρ²: at ρ = 1 the ray up the axis' side meets z = 0.75.
        let (t, p) = bowl
            .intersect(DVec3::new(1.0, 0.0, -1.0), DVec3::Z)
            .unwrap();
        assert!((t - 1.75).abs() < 1e-14 && (p - DVec3::new(1.0, 0.0, 0.75)).length() < 1e-14);
        // Across at that height: both sides, one after the other.
        let o = DVec3::new(-5.0, 0.0, 0.75);
        let (t, p) = bowl.intersect(o, DVec3::X).unwrap();
        assert!((t - 4.0).abs() < 1e-14 && (p.x + 1.0).abs() < 1e-14);
        let (t, _) = bowl
            .intersect(DVec3::new(0.0, 0.0, 0.75), DVec3::X)
            .unwrap();
        assert!((t - 1.0).abs() < 1e-14);
        // Above the rim there is nothing, and below the apex neither.
        assert!(
            bowl.intersect(DVec3::new(-5.0, 0.0, 3.1), DVec3::X)
                .is_none()
        );
        assert!(
            bowl.intersect(DVec3::new(-5.0, 0.0, -0.1), DVec3::X)
                .is_none()
        );
        // The apex itself.
        let (_, p) = bowl
            .intersect(DVec3::new(0.0, 0.0, 9.0), -DVec3::Z)
            .unwrap();
        assert_eq!(p, DVec3::ZERO);
        assert!((bowl.at(p).n + DVec3::Z).length() < 1e-15 && bowl.at(p).dpdv.is_finite());
    }

    #[test]
    fn partial_paraboloids_have_the_stated_parameters() {
        for bowl in [
            Paraboloid::new(0.8, 0.3, 1.2, 360.0),
            Paraboloid::new(1.4, 0.5, 0.1, 200.0),
            // Opens downward.
            Paraboloid::new(0.6, -1.5, -0.4, 300.0),
        ] {
            check_derivatives(&bowl);
            check_hits(&bowl);
            check_uniform(&bowl);
        }
        // To the apex and, with nothing there, beyond it: derivatives are steep near the apex.
        for bowl in [
            Paraboloid::new(0.8, 0.0, 1.2, 360.0),
            Paraboloid::new(0.8, -1.0, 1.2, 100.0),
        ] {
            check_hits(&bowl);
        }
        check_uniform(&Paraboloid::new(0.8, 0.0, 1.2, 360.0));
    }

    #[test]
    fn areas_are_those_of_disks_and_cylinders_in_the_limits() {
        // A bowl of no depth is a disk, to second order in the slope; one cut out of a very steep
        // bowl is nearly a cylinder.
        let flat = Paraboloid::new(2.0, 0.0, 1e-7, 360.0);
        assert!((flat.area() / (2.0 * TAU) - 1.0).abs() < 1e-12);
        let steep = Paraboloid::new(1.0, 1e6 - 1.0, 1e6, 360.0);
        assert!((steep.area() / TAU - 1.0).abs() < 1e-6);
    }
}
