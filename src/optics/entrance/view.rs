//! The lens as a point of the scene sees it.

use crate::math::{DVec2, DVec3};

/// A point x in front of the lens, and the plane through C across the line to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// From x to C, mm.
    pub distance: f64,
    /// Tangent of half the angle between the axis and the line to x: 0 in front of the lens, 1 beside C.
    pub t: f64,
    /// Cosine and sine of x's azimuth.
    pub azimuth: DVec2,
    /// Unit vectors: from x to C, in the plane away from the axis in the meridional plane, and across it.
    ahead: DVec3,
    along: DVec3,
    across: DVec3,
}

impl View {
    /// From `x`; `None` at C itself and where something is not a number.
    pub(super) fn new(x: DVec3, center_z: f64) -> Option<View> {
        let w = x - DVec3::new(0.0, 0.0, center_z);
        let distance = w.length();
        let from_axis = w.x.hypot(w.y);
        let azimuth = match from_axis > 0.0 {
            true => DVec2::new(w.x, w.y) / from_axis,
            false => DVec2::X,
        };
        let (sin, cos) = (from_axis / distance, -w.z / distance);
        let t = sin / (1.0 + cos);
        (t.is_finite() && distance > 0.0).then(|| View {
            distance,
            t,
            azimuth,
            ahead: -w / distance,
            along: (azimuth * cos).extend(sin),
            across: azimuth.perp().extend(0.0),
        })
    }

    /// The unit direction to the point `p` of the plane, along and across the meridional plane.
    pub(super) fn toward(&self, p: DVec2) -> DVec3 {
        (self.distance * self.ahead + p.x * self.along + p.y * self.across).normalize()
    }

    /// Where the line in direction `d` meets the plane; `None` where it does not ahead of x.
    pub(super) fn point(&self, d: DVec3) -> Option<DVec2> {
        let s = self.distance / d.dot(self.ahead);
        (s > 0.0).then(|| s * DVec2::new(d.dot(self.along), d.dot(self.across)))
    }

    /// Solid angle at x to area of the plane, for the unit direction `d`: r²/cos³, with r from x to C.
    pub(super) fn density(&self, d: DVec3) -> f64 {
        let cos = d.dot(self.ahead);
        self.distance * self.distance / (cos * cos * cos)
    }
}
