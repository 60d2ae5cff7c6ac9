//! `Shape "hyperboloid"`: what a segment leaves behind that is turned about the z axis.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | `point3 p1`, `point3 p2` | (0,0,0), (1,1,1) | the ends of the segment; at different heights |
//! | `float phimax` | 360 | degrees turned from +x toward +y, clamped to 0…360 |
//!
//! u = φ/φmax with φ counted from the segment; v = (z − z₁)/(z₂ − z₁); the normal points away from
//! the axis where the segment rises from p1 to p2 and toward it where it falls (docs/scene-language.md §3.7;
//! Pharr, Jakob and Humphreys 2016, §3.6). The ends are exchanged where p2 is at z = 0.
//!
//! **The surface is pbrt-v3's.** A line turned about the axis sweeps the quadric ρ² = α + β z + γ z²;
//! pbrt-v3 leaves β out and fits α and γ to p2 and to p2 + (p2 − p1), so that the surface has its
//! waist at z = 0. Where the line is nearest to the axis there, as in (a, 0, 0) (a, b, c), that is the
//! swept surface. Elsewhere it is not, and does not go through p1; scenes were made to look right
//! with it, so it is followed. The normal that pbrt-v3 shades with is that of the sweep; here it
//! is the shading normal, while the geometric one stands on the surface.

use super::quadric::{
    ObjectPoint, ObjectSurface, ShadingFrame, Swept, full_turn, nearest_approach, roots,
};
use crate::math::{DVec2, DVec3};
use crate::params::ParamReader;

/// How many points of the line beyond p2 are tried for the fit. The first one serves unless it
/// is on the axis or as high as p2 on the other side of z = 0.
const FIT_ATTEMPTS: usize = 4;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hyperboloid {
    /// Start of the segment, object units.
    pub p1: DVec3,
    /// Its end.
    pub p2: DVec3,
    /// From end to end; the angle counts from the segment.
    pub swept: Swept,
    /// α of ρ² = α + γ z².
    alpha: f64,
    /// γ of ρ² = α + γ z².
    gamma: f64,
}

impl Hyperboloid {
    /// The surface of the segment from `p1` to `p2`, turned `phi_max` degrees. `None` where the
    /// segment is level or an end is not finite.
    pub fn new(p1: DVec3, p2: DVec3, phi_max: f64) -> Option<Hyperboloid> {
        let (p1, p2) = if p2.z == 0.0 { (p2, p1) } else { (p1, p2) };
        if p1.z == p2.z || !(p1.is_finite() && p2.is_finite()) {
            return None;
        }
        let (alpha, gamma) = fit(p1, p2)?;
        Some(Hyperboloid {
            p1,
            p2,
            swept: Swept::new(p1.z, p2.z, phi_max),
            alpha,
            gamma,
        })
    }

    /// Reads the parameters; `None` where the segment is level (reported; pbrt-v3 hangs).
    pub fn from_params(reader: &ParamReader) -> Option<Hyperboloid> {
        let p1 = reader.point3("p1", DVec3::ZERO);
        let p2 = reader.point3("p2", DVec3::ONE);
        let phi_max = reader.float("phimax", 360.0);
        let made = Hyperboloid::new(p1, p2, phi_max);
        if made.is_none() {
            let message = "the segment of this hyperboloid is level, so that it sweeps a flat ring: \
                           the shape is left out (a disk with innerradius is one)";
            reader.error("p2", message);
        }
        made
    }

    /// Distance from the axis at a height; 0 where the surface does not reach it.
    fn rho(&self, z: f64) -> f64 {
        (self.alpha + self.gamma * z * z).max(0.0).sqrt()
    }

    /// The point of the segment's line at the height of `p`.
    fn on_segment(&self, z: f64) -> DVec2 {
        let v = (z - self.p1.z) / (self.p2.z - self.p1.z);
        (self.p1 * (1.0 - v) + self.p2 * v).truncate()
    }

    /// The angle of `p` from the segment's point at its height, in [0, 2π).
    fn phi(&self, p: DVec3) -> f64 {
        let (from, to) = (self.on_segment(p.z), p.truncate());
        full_turn(from.perp_dot(to).atan2(from.dot(to)))
    }

    /// The point moved onto the surface: across the axis where the surface is steep, and along it
    /// where it is flat.
    fn onto_surface(&self, p: DVec3) -> DVec3 {
        let rho = p.truncate().length();
        let height2 = (rho * rho - self.alpha) / self.gamma;
        if (self.gamma * p.z).abs() > rho && height2 > 0.0 {
            p.truncate().extend(height2.sqrt().copysign(p.z))
        } else if rho > 0.0 {
            (p.truncate() * (self.rho(p.z) / rho)).extend(p.z)
        } else {
            p
        }
    }

    /// The heights between which there is surface: two intervals where the waist is missing.
    fn pieces(&self) -> [[f64; 2]; 2] {
        let (low, high) = (self.swept.z_min, self.swept.z_max);
        let nothing = [high, high];
        let edge = -self.alpha / self.gamma;
        if self.alpha >= 0.0 && self.gamma >= 0.0 {
            return [[low, high], nothing];
        }
        if edge < 0.0 || edge.is_nan() {
            return [nothing, nothing];
        }
        let edge = edge.sqrt();
        if self.gamma < 0.0 {
            [[low.max(-edge), high.min(edge)], nothing]
        } else {
            [[low, high.min(-edge)], [low.max(edge), high]]
        }
        .map(|[a, b]| if a < b { [a, b] } else { nothing })
    }

    /// An antiderivative by z of √(ρ² + (ρ ρ')²) = √(α + κ z²), the area per height and angle,
    /// with κ = γ (1 + γ).
    fn area_below(&self, z: f64) -> f64 {
        let (alpha, kappa) = (self.alpha, self.gamma * (1.0 + self.gamma));
        let slant = (alpha + kappa * z * z).max(0.0).sqrt();
        let bent = kappa * z * z / alpha;
        // ∫ dz / √(α + κ z²)
        let inverse = if alpha == 0.0 {
            0.0
        } else if alpha < 0.0 {
            let cosh = (z.abs() * (kappa / -alpha).sqrt()).max(1.0);
            cosh.acosh().copysign(z) / kappa.sqrt()
        } else if bent.abs() < 1e-8 {
            // The next term of the series is of the order of `bent`², below rounding.
            z / alpha.sqrt() * (1.0 - bent / 6.0)
        } else if kappa > 0.0 {
            (z * (kappa / alpha).sqrt()).asinh() / kappa.sqrt()
        } else {
            (z * (-kappa / alpha).sqrt()).clamp(-1.0, 1.0).asin() / (-kappa).sqrt()
        };
        0.5 * (z * slant + alpha * inverse)
    }

    fn areas(&self) -> [f64; 2] {
        self.pieces()
            .map(|[a, b]| (self.area_below(b) - self.area_below(a)).max(0.0))
    }

    /// The height in `piece` below which its area is `area`: Newton's method, kept between
    /// bounds by bisection.
    fn height_of(&self, piece: [f64; 2], area: f64) -> f64 {
        let [mut low, mut high] = piece;
        let target = self.area_below(low) + area;
        let kappa = self.gamma * (1.0 + self.gamma);
        let mut z = 0.5 * (low + high);
        // Bisection alone needs as many steps as a number has bits.
        for _ in 0..64 {
            let miss = self.area_below(z) - target;
            if miss > 0.0 {
                high = z;
            } else {
                low = z;
            }
            let next = z - miss / (self.alpha + kappa * z * z).sqrt();
            let next = if next > low && next < high {
                next
            } else {
                0.5 * (low + high)
            };
            if (next - z).abs() <= 4.0 * f64::EPSILON * z.abs() {
                return next;
            }
            z = next;
        }
        z
    }
}

/// α and γ of the surface ρ² = α + γ z² through p2 and a point of the line beyond it. `None` for
/// numbers that are not finite.
fn fit(p1: DVec3, p2: DVec3) -> Option<(f64, f64)> {
    let rho2 = |p: DVec3| p.truncate().length_squared();
    let mut cone = None;
    for i in 1..=FIT_ATTEMPTS {
        let beyond = p1 + (p2 - p1) * (2 * i) as f64;
        let apart = (beyond.z - p2.z) * (beyond.z + p2.z);
        if rho2(beyond) == 0.0 || apart == 0.0 {
            continue;
        }
        let gamma = (rho2(beyond) - rho2(p2)) / apart;
        let alpha = rho2(p2) - gamma * p2.z * p2.z;
        if !(alpha.is_finite() && gamma.is_finite()) {
            continue;
        }
        // A cone may be one of rounding only: up to a few units of it.
        if alpha.abs() > 8.0 * f64::EPSILON * rho2(p2) {
            return Some((alpha, gamma));
        }
        cone = cone.or(Some((0.0, gamma)));
    }
    cone
}

impl ObjectSurface for Hyperboloid {
    fn intersect(&self, o: DVec3, d: DVec3) -> Option<(f64, DVec3)> {
        let Swept { z_min, z_max, .. } = self.swept;
        let (start, o) = nearest_approach(o, d, self.swept.center());
        let (o2, d2, gamma) = (o.truncate(), d.truncate(), self.gamma);
        let a = d2.length_squared() - gamma * d.z * d.z;
        let b = o2.dot(d2) - gamma * o.z * d.z;
        let c = o2.length_squared() - gamma * o.z * o.z - self.alpha;
        // b² − a c with Lagrange's identity, as for the cone.
        let turn = o2.perp_dot(d2);
        let discriminant =
            gamma * (o2 * d.z - d2 * o.z).length_squared() + self.alpha * a - turn * turn;
        let inside = |p: DVec3| p.z >= z_min && p.z <= z_max && self.swept.sweeps(|| self.phi(p));
        let roots = roots(a, b, c, discriminant)?.into_iter();
        roots
            .map(|t| (start + t, self.onto_surface(o + d * t)))
            .find(|&(t, p)| t > 0.0 && inside(p))
    }

    fn at(&self, p: DVec3) -> ObjectPoint {
        let segment = self.p2 - self.p1;
        let rho = p.truncate().length();
        let outward = p.truncate().try_normalize().unwrap_or(DVec2::X);
        let around = outward.perp();
        // ρ' by z, and how fast the segment's own azimuth turns with v.
        let slope = self.gamma * p.z / rho.max(f64::MIN_POSITIVE);
        let from = self.on_segment(p.z);
        let turn = from.perp_dot(segment.truncate()) / from.length_squared();
        let turn = if turn.is_finite() { turn } else { 0.0 };
        let side = segment.z.signum() / slope.hypot(1.0);
        let n = (outward * side).extend(-slope * side);
        let bend = segment.z * self.gamma * self.alpha / (rho * rho * rho);
        let bend = if bend.is_finite() { bend } else { 0.0 };
        // d n / d slope, with |(1, slope)|³ below.
        let tilt = -bend * side / (1.0 + slope * slope);
        ObjectPoint {
            uv: DVec2::new(
                self.phi(p) / self.swept.phi_max,
                (p.z - self.p1.z) / (self.p2.z - self.p1.z),
            ),
            n,
            dpdu: self.swept.dpdu(p),
            dpdv: (outward * (slope * segment.z) + around * (rho * turn)).extend(segment.z),
            dndu: (around * (self.swept.phi_max * side)).extend(0.0),
            dndv: (around * (turn * side) + outward * (tilt * slope)).extend(tilt),
        }
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        let Swept { z_min, z_max, .. } = self.swept;
        // ρ² is largest at an end, or at z = 0.
        let heights = [z_min, z_max, 0.0f64.clamp(z_min, z_max)];
        self.swept
            .bounds(heights.map(|z| self.rho(z)).into_iter().fold(0.0, f64::max))
    }

    fn sample(&self, u: DVec2) -> DVec3 {
        let [first, second] = self.areas();
        let chosen = u.x * (first + second);
        let z = if chosen < first || second == 0.0 {
            self.height_of(self.pieces()[0], chosen)
        } else {
            self.height_of(self.pieces()[1], chosen - first)
        };
        let from = self.on_segment(z).try_normalize().unwrap_or(DVec2::X);
        let turned = DVec2::from_angle(u.y * self.swept.phi_max).rotate(from);
        (turned * self.rho(z)).extend(z)
    }

    fn area(&self) -> f64 {
        let [first, second] = self.areas();
        self.swept.phi_max * (first + second)
    }

    fn shading(&self, p: DVec3) -> Option<ShadingFrame> {
        let segment = self.p2 - self.p1;
        let outward = p.truncate().try_normalize()?;
        let from = self.on_segment(p.z).try_normalize()?;
        let across = segment.truncate();
        let (radial, around) = (from.dot(across), from.perp_dot(across));
        let n = (outward * segment.z).extend(-radial).try_normalize()?;
        Some(ShadingFrame {
            n,
            dpdv: (outward * radial + outward.perp() * around).extend(segment.z),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::quadric::tests::{check_derivatives, check_hits, check_uniform};
    use super::*;

    fn hyperboloid(p1: [f64; 3], p2: [f64; 3], phi_max: f64) -> Hyperboloid {
        Hyperboloid::new(p1.into(), p2.into(), phi_max).unwrap()
    }

    #[test]
    fn with_its_waist_at_the_origin_it_is_the_swept_segment() {
        let h = hyperboloid([0.5, -0.8, -1.6], [0.5, 0.4, 0.8], 360.0);
        for i in 0..=10 {
            let v = f64::from(i) / 10.0;
            let on = h.p1.lerp(h.p2, v);
            // Seen from far outside, along the normal.
            let at = h.at(on);
            let (t, p) = h.intersect(on + at.n * 5.0, -at.n).unwrap();
            assert!(
                (t - 5.0).abs() < 1e-12 && (p - on).length() < 1e-12,
                "{p} {on}"
            );
            assert!((at.uv - DVec2::new(0.0, v)).length() < 1e-12 || at.uv.x > 1.0 - 1e-12);
            // The segment lies in the surface, and both normals are one.
            assert!((at.dpdv - (h.p2 - h.p1)).length() < 1e-12);
            assert!((h.shading(on).unwrap().n - at.n).length() < 1e-12);
        }
    }

    #[test]
    fn elsewhere_it_is_the_surface_of_pbrt_v3() {
        // p2 + (p2 − p1) = (−0.2, 1, 2.6): α + 6.76 γ = 1.04 and α + 1.69 γ = 0.29.
        let h = hyperboloid([0.6, 0.0, 0.0], [0.2, 0.5, 1.3], 360.0);
        let gamma = 0.75 / 5.07;
        assert!((h.gamma - gamma).abs() < 1e-15 && (h.alpha - (0.29 - 1.69 * gamma)).abs() < 1e-15);
        // Its waist is not the segment's.
        assert!((h.rho(0.0) - 0.2).abs() < 1e-12);
        // At p2 the surface's slope by z is ρ' = γ z/ρ, and the sweep's is that of the segment,
        // (0.2, 0.5)·(−0.4, 0.5)/ρ over 1.3.
        let p = DVec3::new(0.2, 0.5, 1.3);
        let slope = |n: DVec3| -n.z / n.truncate().length();
        assert!((slope(h.at(p).n) - gamma * 1.3 / 0.29f64.sqrt()).abs() < 1e-12);
        let sweep = 0.17 / 0.29f64.sqrt() / 1.3;
        assert!((slope(h.shading(p).unwrap().n) - sweep).abs() < 1e-12);
    }

    #[test]
    fn the_default_is_a_cone_and_level_segments_are_none() {
        // (pbrt-v3 never returns from either.)
        let cone = hyperboloid([0.0; 3], [1.0; 3], 360.0);
        assert_eq!((cone.alpha, cone.gamma), (0.0, 2.0));
        let (_, p) = cone
            .intersect(DVec3::new(-5.0, 0.0, 0.5), DVec3::X)
            .unwrap();
        assert!((p.x + 0.5f64.sqrt()).abs() < 1e-14);
        assert!(Hyperboloid::new(DVec3::X, DVec3::Y, 360.0).is_none());
        assert!(Hyperboloid::new(DVec3::NAN, DVec3::Z, 360.0).is_none());
    }

    #[test]
    fn falling_segments_and_ends_at_zero_decide_the_side() {
        let outward = |p1, p2| {
            let h = hyperboloid(p1, p2, 360.0);
            let p = h.sample(DVec2::splat(0.5));
            h.at(p).n.truncate().dot(p.truncate()) > 0.0
        };
        assert!(outward([0.5, 0.0, 1.0], [0.5, 1.0, 2.0]));
        assert!(!outward([0.5, 1.0, 2.0], [0.5, 0.0, 1.0]));
        // Exchanged, since p2 is at z = 0.
        assert!(outward([0.5, 1.0, 2.0], [0.5, 0.0, 0.0]));
    }

    #[test]
    fn partial_hyperboloids_have_the_stated_parameters() {
        for h in [
            hyperboloid([0.6, 0.0, 0.0], [0.2, 0.5, 1.3], 360.0),
            hyperboloid([0.5, -0.8, -1.6], [0.5, 0.4, 0.8], 250.0),
            // A cylinder, a cone without its tip, a falling segment, part of an ellipsoid.
            hyperboloid([0.7, 0.0, -1.0], [0.7, 0.0, 1.0], 200.0),
            hyperboloid([0.3, 0.3, 0.3], [1.0, 1.0, 1.0], 360.0),
            hyperboloid([0.6, 0.5, 1.2], [0.6, 0.0, 0.1], 300.0),
            hyperboloid([1.0, 0.0, 0.1], [0.6, 0.0, 0.5], 360.0),
        ] {
            check_derivatives(&h);
            check_hits(&h);
            check_uniform(&h);
        }
    }

    #[test]
    fn heights_invert_areas() {
        for h in [
            hyperboloid([0.6, 0.0, 0.0], [0.2, 0.5, 1.3], 360.0),
            // Two sheets, with nothing between z = −√(α/γ) and its opposite.
            Hyperboloid {
                alpha: -0.5,
                gamma: 2.0,
                ..hyperboloid([0.5, -1.0, -2.0], [0.5, 1.0, 2.0], 360.0)
            },
        ] {
            for i in 0..=100 {
                let p = h.sample(DVec2::new(f64::from(i) / 100.0, 0.3));
                assert!(
                    (p.truncate().length_squared() - h.alpha - h.gamma * p.z * p.z).abs() < 1e-9
                );
            }
            check_hits(&h);
        }
    }
}
