//! The rear element as the film sees it: what light could at most come through.

use super::region::Region;
use crate::optics::lens::Lens;

/// The cap of the rear element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rear {
    radius: f64,
    /// z of vertex and rim.
    ends: [f64; 2],
    curvature: f64,
}

impl Rear {
    pub(super) fn new(lens: &Lens) -> Rear {
        let rear = lens.rear();
        let radius = rear.clear_radius();
        Rear {
            radius,
            ends: [lens.length(), lens.length() + rear.sag(radius)],
            curvature: rear.curvature(),
        }
    }

    /// Of its rim, mm.
    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// A circle on the plane `plane_z` around all lines from the film point through the element's
    /// cap, which lies in a cylinder between vertex and rim. `None` for a film inside the cap.
    pub(super) fn region(&self, film_radius: f64, plane_z: f64, film_z: f64) -> Option<Region> {
        // A disk at z is seen on the plane enlarged by k about the film point.
        let disk = |z: f64| {
            let k = (plane_z - film_z) / (z - film_z);
            (film_radius * (1.0 - k), self.radius * k.abs())
        };
        let ((c0, r0), (c1, r1)) = (disk(self.ends[0]), disk(self.ends[1]));
        let (low, high) = ((c0 - r0).min(c1 - r1), (c0 + r0).max(c1 + r1));
        let radius = 0.5 * (high - low).max(2.0 * r0).max(2.0 * r1);
        let circle = Region::ellipse(0.5 * (low + high), radius, radius);
        (radius.is_finite() && radius > 0.0).then_some(circle)
    }

    /// The point of the cap above (x, y).
    pub(super) fn point(&self, x: f64, y: f64) -> [f64; 3] {
        let r2 = x * x + y * y;
        let c = self.curvature;
        [
            x,
            y,
            self.ends[0] + c * r2 / (1.0 + (1.0 - c * c * r2).max(0.0).sqrt()),
        ]
    }

    /// Points all over the half with y ≥ 0, in sunflower order.
    pub(super) fn probes(&self, count: usize) -> impl Iterator<Item = [f64; 3]> {
        let rear = *self;
        (0..count).map(move |i| {
            let r = rear.radius * ((i as f64 + 0.5) / count as f64).sqrt();
            let (sin, cos) = (2.399_963_229_728_653 * i as f64).sin_cos();
            rear.point(r * cos, r * sin.abs())
        })
    }
}
