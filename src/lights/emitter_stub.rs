//! Stand-in for `shapes::emitter` until it is there: one triangle, enough to test area lights.

use crate::math::float::gamma;
use crate::math::sampling::uniform_triangle;
use crate::math::{Vec2, Vec3};
use crate::surface::{ReferencePoint, SurfaceHit};

/// A point chosen on an emitter.
#[derive(Clone, Copy, Debug)]
pub struct EmitterSample {
    /// Position, render space.
    pub p: Vec3,
    /// Half-widths of the box around `p` that holds the exact point.
    pub p_error: Vec3,
    /// Unit normal, on the side that [`SurfaceHit::n`] has there.
    pub n: Vec3,
    /// Density per solid angle at the receiving point.
    pub pdf: f32,
}

/// A triangle.
#[derive(Clone, Debug)]
pub struct Emitter {
    corners: [Vec3; 3],
}

impl Emitter {
    /// The triangle with these corners.
    pub fn triangle(corners: [Vec3; 3]) -> Emitter {
        Emitter { corners }
    }

    fn cross(&self) -> Vec3 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a)
    }

    fn solid_angle_pdf(&self, from: &ReferencePoint, p: Vec3) -> f32 {
        let d = p - from.p;
        let cos = (self.cross().normalize_or_zero().dot(d) / d.length()).abs();
        d.length_squared() / (cos * self.area() as f32)
    }

    /// Chooses a point uniformly by area.
    pub fn sample(&self, from: &ReferencePoint, u: Vec2) -> Option<EmitterSample> {
        let [a, b, c] = self.corners;
        let w = uniform_triangle(u);
        let p = a * w.x + b * w.y + c * (1.0 - w.x - w.y);
        let p_error = gamma(6) * (a.abs() + b.abs() + c.abs());
        let pdf = self.solid_angle_pdf(from, p);
        pdf.is_finite().then_some(EmitterSample {
            p,
            p_error,
            n: self.cross().normalize_or_zero(),
            pdf,
        })
    }

    /// Density per solid angle at `from` of the point `hit`.
    pub fn pdf(&self, from: &ReferencePoint, _wi: Vec3, hit: &SurfaceHit) -> f32 {
        let pdf = self.solid_angle_pdf(from, hit.p);
        if pdf.is_finite() { pdf } else { 0.0 }
    }

    /// Surface area.
    pub fn area(&self) -> f64 {
        0.5 * self.cross().as_dvec3().length()
    }
}
