//! Spot diagrams: where the rays of one object point meet the film.

use super::beam::Beam;
use super::contrast::{Follower, STEP, times};
use crate::optics::dispersion::LINE_D;
use crate::optics::lens::Lens;
use crate::optics::trace::LensRay;
use serde::Serialize;
use std::f64::consts::TAU;

/// A spot. Rays are spread evenly over the beam's cross-section, so every point carries the same light.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spot {
    /// Film height of the chief ray, mm.
    pub height: f64,
    /// Points (x, y) on the film relative to the chief ray's, mm; y away from the axis.
    pub points: Vec<[f64; 2]>,
    /// Half widths across and along the meridional plane of the diffraction pattern's middle, Airy's disc, at the d line: 1.22 λ over
    /// the width of the cone of rays in direction cosines times the index at the film (Goodman, *Introduction to Fourier Optics*, §4.4.2; exact for
    /// round cones). mm; `None` without rays.
    pub airy: Option<[f64; 2]>,
}

/// The first zero of Airy's pattern: that of J₁ over π.
const AIRY: f64 = 1.219_669_891;

impl Spot {
    /// With `across`² rays, spread over the rectangle around the beam.
    pub fn trace(lens: &Lens, beam: &Beam, across: usize) -> Spot {
        let height = beam.chief.height;
        let rays = beam.rays_at_film(lens, across);
        Spot {
            height,
            points: rays.iter().map(|r| [r.o[0], r.o[1] - height]).collect(),
            airy: airy(&rays, lens.rear().index),
        }
    }

    /// The same rays `shift` mm behind the film, `rays` being those at it.
    pub(super) fn behind(rays: &[LensRay<f64>], shift: f64) -> Spot {
        let at = |r: &LensRay<f64>| {
            let t = shift / r.d[2];
            [r.o[0] + t * r.d[0], r.o[1] + t * r.d[1]]
        };
        Spot {
            height: 0.0,
            points: rays.iter().map(at).collect(),
            airy: None,
        }
    }

    /// The mean of its points, mm; 0 without any.
    pub fn centroid(&self) -> [f64; 2] {
        let n = self.points.len().max(1) as f64;
        let sum = |i: usize| self.points.iter().map(|p| p[i]).sum::<f64>();
        [sum(0) / n, sum(1) / n]
    }

    /// Root mean square distance of its points from the centroid, mm.
    pub fn rms_radius(&self) -> f64 {
        let c = self.centroid();
        let n = self.points.len().max(1) as f64;
        let sum: f64 = self
            .points
            .iter()
            .map(|p| (p[0] - c[0]).powi(2) + (p[1] - c[1]).powi(2))
            .sum();
        (sum / n).sqrt()
    }

    /// Geometric modulation transfer at `frequency` line pairs per mm, \[sagittal, tangential\]: the modulus of the
    /// Fourier transform of the spot across and along the meridional plane (Smith §15.8, without diffraction), negative where
    /// contrast is reversed, which is spurious resolution. 0 for an empty spot.
    pub fn mtf(&self, frequency: f64) -> [f64; 2] {
        let steps = (frequency / STEP).ceil().clamp(1.0, 1e4);
        let found = self.contrasts(frequency / steps, steps as usize).pop();
        found.unwrap_or_default()
    }

    /// The Fourier transform about the centroid that [`Spot::mtf`] is the modulus of: \[real, imaginary\] for each direction.
    pub(super) fn transfer(&self, frequency: f64) -> [[f64; 2]; 2] {
        let n = self.points.len().max(1) as f64;
        let middle = self.centroid();
        [0, 1].map(|axis| {
            let phases = { self.points.iter() }.map(|p| TAU * frequency * (p[axis] - middle[axis]));
            let turns = phases.map(f64::sin_cos);
            let sum = turns.fold([0.0; 2], |sum, (sin, cos)| [sum[0] + cos, sum[1] + sin]);
            sum.map(|x| x / n)
        })
    }

    /// [`Spot::mtf`] at so many multiples of `step` line pairs per mm, which is [`STEP`] at most, from none on.
    pub(super) fn contrasts(&self, step: f64, count: usize) -> Vec<[f64; 2]> {
        let n = self.points.len().max(1) as f64;
        let middle = self.centroid();
        let curve = |axis: usize| -> Vec<f64> {
            let phases = { self.points.iter() }.map(|p| TAU * step * (p[axis] - middle[axis]));
            let turns: Vec<[f64; 2]> = phases.map(|phase| [phase.cos(), phase.sin()]).collect();
            let mut values = vec![[1.0, 0.0]; turns.len()];
            let mut follower = Follower::default();
            let value = |_| {
                let mean = |k: usize| values.iter().map(|v| v[k]).sum::<f64>() / n;
                let contrast = follower.next([mean(0), mean(1)]);
                for (value, turn) in values.iter_mut().zip(&turns) {
                    *value = times(*value, *turn);
                }
                contrast
            };
            (0..=count).map(value).collect()
        };
        let [sagittal, tangential] = [curve(0), curve(1)];
        { sagittal.into_iter().zip(tangential) }
            .map(|(s, t)| [s, t])
            .collect()
    }
}

fn airy(rays: &[LensRay<f64>], index: f64) -> Option<[f64; 2]> {
    let radius = |axis: usize| {
        let cosines = rays.iter().map(|r| r.d[axis]);
        let (low, high) = cosines.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
            (l.min(x), h.max(x))
        });
        let radius = AIRY * 1e-3 * LINE_D / (index * (high - low));
        Some(radius).filter(|r| r.is_finite() && *r > 0.0)
    };
    Some([radius(0)?, radius(1)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_uniform_disk_has_its_known_radius_and_transfer() {
        // Points of a disk of radius 0.02 mm: rms r/√2, transfer 2 J1(x)/x with x = 2πνr.
        let n = 401;
        let r = 0.02;
        let at = |i: usize| r * (2.0 * (i as f64 + 0.5) / n as f64 - 1.0);
        let points: Vec<[f64; 2]> = (0..n * n)
            .map(|i| [at(i % n), at(i / n)])
            .filter(|p| p[0].hypot(p[1]) <= r)
            .collect();
        let spot = Spot {
            height: 0.0,
            points,
            airy: None,
        };
        // The edge of the grid: 1/401 of the radius.
        assert!((spot.rms_radius() / (r / 2f64.sqrt()) - 1.0).abs() < 2e-3);
        // At 20 lp/mm x = 2.5133, where J1 = 0.49595 (Abramowitz and Stegun, table 9.1): 0.3947.
        for m in spot.mtf(20.0) {
            assert!((m - 0.3947).abs() < 2e-3, "{m}");
        }
        assert!((spot.mtf(0.0)[0] - 1.0).abs() < 1e-12);
        // Beyond the first zero at x = 3.8317, 30.5 lp/mm, black and white change places: at 40 lp/mm x = 5.0265, J1 = −0.3290.
        for m in spot.mtf(40.0) {
            assert!((m + 0.1309).abs() < 2e-3, "{m}");
        }
    }
}
