//! Spot diagrams: where the rays of one object point meet the film.

use super::beam::Beam;
use crate::optics::lens::Lens;
use serde::Serialize;
use std::f64::consts::TAU;

/// A spot. Rays are spread evenly over the beam's cross-section, so every point carries the same light.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spot {
    /// Film height of the chief ray, mm.
    pub height: f64,
    /// Points (x, y) on the film relative to the chief ray's, mm; y away from the axis.
    pub points: Vec<[f64; 2]>,
}

impl Spot {
    /// With `across`² rays over the rectangle around the beam.
    pub fn trace(lens: &Lens, beam: &Beam, across: usize) -> Spot {
        let height = beam.chief.height;
        let points = beam.grid(lens, across);
        Spot {
            height,
            points: points.iter().map(|(_, p)| [p[0], p[1] - height]).collect(),
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
    /// Fourier transform of the spot across and along the meridional plane (Smith §15.8, without diffraction). 0 for
    /// an empty spot.
    pub fn mtf(&self, frequency: f64) -> [f64; 2] {
        let n = self.points.len().max(1) as f64;
        [0, 1].map(|axis| {
            let (mut re, mut im) = (0.0, 0.0);
            for p in &self.points {
                let (sin, cos) = (TAU * frequency * p[axis]).sin_cos();
                re += cos;
                im += sin;
            }
            f64::hypot(re, im) / n
        })
    }
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
        };
        // The edge of the grid: 1/401 of the radius.
        assert!((spot.rms_radius() / (r / 2f64.sqrt()) - 1.0).abs() < 2e-3);
        // At 20 lp/mm x = 2.5133, where J1 = 0.49595 (Abramowitz and Stegun, table 9.1): 0.3947.
        for m in spot.mtf(20.0) {
            assert!((m - 0.3947).abs() < 2e-3, "{m}");
        }
        assert!((spot.mtf(0.0)[0] - 1.0).abs() < 1e-12);
    }
}
