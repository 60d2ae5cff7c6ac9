//! The first surface as a point of the scene sees it: what it sends through the lens comes through here.

use crate::math::{DVec2, DVec3};
use crate::optics::lens::Lens;
use crate::optics::trace::{LensRay, LensTracer};
use std::f64::consts::PI;

/// The first surface within its aperture. (x, y) is drawn uniformly from the aperture's disk, seen along the axis.
#[derive(Clone, Debug)]
pub struct Cap {
    tracer: LensTracer<f64>,
    surface: crate::optics::Surface,
    radius: f64,
}

impl Cap {
    /// Of `lens`.
    pub fn new(lens: &Lens) -> Option<Cap> {
        let surface = *lens.surfaces().first()?;
        Some(Cap {
            tracer: LensTracer::new(&[surface]),
            radius: surface.clear_radius(),
            surface,
        })
    }

    /// Its point for `p` in the unit disk.
    fn at(&self, p: DVec2) -> DVec3 {
        let p = self.radius * p;
        p.extend(self.surface.sag(p.length()))
    }

    /// The unit direction from `x` to the point of the cap for `p` in the unit disk; `None` at that point itself.
    pub(super) fn direction(&self, x: DVec3, p: DVec2) -> Option<DVec3> {
        (self.at(p) - x).try_normalize()
    }

    /// The point of the cap for `p` in the unit disk, the surface's unit normal there, which leans toward the film, and the area of the
    /// surface, mm², for which points drawn evenly from the disk stand one by one: the inverse of their density.
    pub fn point(&self, p: DVec2) -> Option<(DVec3, DVec3, f64)> {
        let y = self.at(p);
        let n = DVec3::from(self.tracer.front_normal(y.to_array())?);
        let area = PI * self.radius * self.radius / n.z;
        (area > 0.0 && area.is_finite()).then_some((y, n, area))
    }

    /// Density per solid angle at `x` of the unit direction `d`; `None` where it does not meet the cap from in front.
    pub(super) fn density(&self, x: DVec3, d: DVec3) -> Option<f64> {
        let ray = LensRay {
            o: x.to_array(),
            d: d.to_array(),
        };
        let [y, normal] = self.tracer.front(&ray)?.map(DVec3::from);
        let cos = normal.dot(d);
        let density = x.distance_squared(y) * normal.z / (PI * self.radius * self.radius * cos);
        // The cap lies ahead.
        ((y - x).dot(d) > 0.0 && cos > 0.0 && density.is_finite()).then_some(density)
    }
}
