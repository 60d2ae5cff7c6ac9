//! Pupil footprints: which part of the stop the beam of a field point goes through.
//!
//! Rims in front of the stop and behind it cut the beams of the field's edge to a cat's eye (Ray, *Applied Photographic Optics*, 3rd
//! edition, §13.2); its outline in the stop is the shape of far highlights that are out of focus.

use super::beam::Beam;
use crate::optics::bisection::bisect;
use crate::optics::lens::Lens;
use serde::Serialize;
use std::f64::consts::TAU;

/// The outline of one beam.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Footprint {
    /// Film height of the chief ray, mm.
    pub height: f64,
    /// Points (x, y) in the stop in radii of it, around; empty where nothing passes. The meridional plane is x = 0.
    pub outline: Vec<[f64; 2]>,
}

/// Directions around a beam.
const AROUND: u32 = 96;

impl Footprint {
    /// Of a beam.
    pub fn new(lens: &Lens, beam: &Beam) -> Footprint {
        let passing: Vec<[f64; 2]> = beam.grid(lens, 24).into_iter().map(|(p, _)| p).collect();
        let n = passing.len().max(1) as f64;
        let mean = |axis: usize| passing.iter().map(|p| p[axis]).sum::<f64>() / n;
        let middle = [mean(0), mean(1)];
        // Beyond every edge of the rectangle.
        let reach: f64 = beam.extent.iter().map(|[low, high]| high - low).sum();
        let radius = lens.surfaces()[lens.paraxial().stop].clear_radius();
        let point = |i: u32| {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(AROUND)).sin_cos();
            let at = |r: f64| [middle[0] + r * sin, middle[1] + r * cos];
            let passes = |r: f64| beam.on_film(lens, at(r)).is_some();
            // A grid of 24 leaves no doubt that the middle of a beam is within it, but for crescents: those have no outline.
            let [edge, _] = passes(0.0).then(|| bisect([0.0, reach], 40, passes))?;
            Some(in_stop(lens, beam, at(edge))?.map(|x| x / radius))
        };
        Footprint {
            height: beam.chief.height,
            outline: (0..AROUND).filter_map(point).collect(),
        }
    }

    /// Its area as a part of the stop's.
    pub fn area(&self) -> f64 {
        let next = self.outline.iter().cycle().skip(1);
        let cross = self
            .outline
            .iter()
            .zip(next)
            .map(|(a, b)| a[0] * b[1] - a[1] * b[0]);
        0.5 * cross.sum::<f64>().abs() / std::f64::consts::PI
    }
}

fn in_stop(lens: &Lens, beam: &Beam, p: [f64; 2]) -> Option<[f64; 2]> {
    let mut met = None;
    let stop = lens.paraxial().stop;
    // A ray that passes does so to the end.
    let out = lens.tracer().visit_to_film(&beam.ray(p), |i, [x, y, _]| {
        if i == stop {
            met = Some([x, y]);
        }
    });
    out.ok().and(met)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::analysis::{ChiefFinder, ObjectPlane};
    use crate::optics::{ExitPupil, Prescription};

    #[test]
    fn a_rim_cuts_the_stop_to_two_arcs() {
        // A stop of radius 5 and a hole of radius 5 in front of it at 10 mm: a slope of 0.5 moves the hole's shadow by its radius, and what is
        // left of the stop is the lens of two such circles, 2/3 − √3/2π of it.
        let p = Prescription::parse("inf 10 1 10\n0 0 0 10\n").unwrap();
        let lens = Lens::new(&p, 20.0).unwrap();
        let pupil = ExitPupil::new(&lens, 12.0, 16);
        let footprint = |height: f64| {
            let chief = ChiefFinder::new(&lens).find(height).unwrap();
            let beam = Beam::new(&lens, &pupil, &chief, ObjectPlane::INFINITY).unwrap();
            Footprint::new(&lens, &beam)
        };
        // A polygon of 96 corners lacks 0.07 % of a circle, and cuts the eye's corners.
        assert!((footprint(0.0).area() - 1.0).abs() < 1e-3);
        let eye = 2.0 / 3.0 - 3f64.sqrt() / TAU;
        assert!(
            (footprint(10.0).area() / eye - 1.0).abs() < 5e-3,
            "{}",
            footprint(10.0).area()
        );
    }
}
