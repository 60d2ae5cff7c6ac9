//! One axis of a separable filter, prepared for sampling.

use crate::math::distribution::Distribution1D;

/// Constant pieces from a filter's center to its edge, as in pbrt-v3's film.
const PIECES: usize = 16;

/// The smallest |∫f| / ∫|f| of a valid filter: below it the weights, and with them the noise, would
/// exceed a thousand.
const MIN_RATIO: f64 = 1e-3;

/// The largest radius of [`Axis::integers`] in pixels.
const MAX_CENTERS: f64 = 4096.0;

/// A one-dimensional filter: a density proportional to its magnitude, and weights.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    /// Half width in pixels; for pixel centers the number of them on each side.
    radius: f32,
    cells: Cells,
}

#[derive(Clone, Debug)]
enum Cells {
    /// Constant from edge to edge.
    Uniform,
    /// Equal cells from edge to edge, each with its weight.
    Pieces(Distribution1D, Vec<f32>),
    /// One cell for each pixel center within the radius, each with its weight.
    Centers(Distribution1D, Vec<f32>),
}

impl Axis {
    /// A constant filter.
    pub(super) fn uniform(radius: f32) -> Axis {
        Axis {
            radius,
            cells: Cells::Uniform,
        }
    }

    /// The filter whose value at `distance` pixels from the center is `factor`(distance), as
    /// constant pieces. `None` where it cannot be normalized.
    pub(super) fn continuous(radius: f64, factor: impl Fn(f64) -> f64) -> Option<Axis> {
        let half: Vec<f64> = (0..PIECES)
            .map(|i| factor((i as f64 + 0.5) * radius / PIECES as f64))
            .collect();
        let values: Vec<f64> = half.iter().rev().chain(&half).copied().collect();
        let (distribution, weights) = normalize(&values)?;
        let cells = if values.iter().all(|&v| v == values[0]) {
            Cells::Uniform
        } else {
            Cells::Pieces(distribution, weights)
        };
        Some(Axis {
            radius: radius as f32,
            cells,
        })
    }

    /// The same constant pieces, looked up at whole distances only.
    pub(super) fn integers(radius: f64, factor: impl Fn(f64) -> f64) -> Option<Axis> {
        let reach = radius.clamp(0.0, MAX_CENTERS).floor() as i32;
        let values: Vec<f64> = (-reach..=reach)
            .map(|k| {
                let piece =
                    ((PIECES as f64 * f64::from(k.abs()) / radius) as usize).min(PIECES - 1);
                factor((piece as f64 + 0.5) * radius / PIECES as f64)
            })
            .collect();
        let (distribution, weights) = normalize(&values)?;
        Some(Axis {
            radius: reach as f32,
            cells: Cells::Centers(distribution, weights),
        })
    }

    /// Offset from the center in pixels, and weight, for `u` in [0, 1).
    pub(super) fn sample(&self, u: f32) -> (f32, f32) {
        match &self.cells {
            Cells::Uniform => ((2.0 * u - 1.0) * self.radius, 1.0),
            Cells::Pieces(distribution, weights) => {
                let (x, _, cell) = distribution.sample_continuous(u);
                ((2.0 * x - 1.0) * self.radius, weights[cell])
            }
            Cells::Centers(distribution, weights) => {
                let (cell, _, _) = distribution.sample_discrete(u);
                (cell as f32 - self.radius, weights[cell])
            }
        }
    }
}

impl Axis {
    /// Density per pixel with which [`Axis::sample`] chooses this offset, and its weight; 0 beyond the radius.
    pub(super) fn at(&self, offset: f32) -> (f32, f32) {
        // From 0 to 1 from edge to edge.
        let x = 0.5 * (offset / self.radius) + 0.5;
        if !(0.0..1.0).contains(&x) {
            return (0.0, 0.0);
        }
        let even = 0.5 / self.radius;
        match &self.cells {
            Cells::Uniform => (even, 1.0),
            Cells::Pieces(distribution, weights) => {
                let cell = ((x * weights.len() as f32) as usize).min(weights.len() - 1);
                (distribution.density(cell) * even, weights[cell])
            }
            // Of single points there is no density.
            Cells::Centers(..) => (0.0, 0.0),
        }
    }

    /// Returns `true` if offsets have a density: they are more than a few points.
    pub(super) fn is_continuous(&self) -> bool {
        self.radius > 0.0 && !matches!(self.cells, Cells::Centers(..))
    }
}

/// The density of |values| and the weight sign · ∑|f| / ∑f of each.
fn normalize(values: &[f64]) -> Option<(Distribution1D, Vec<f32>)> {
    let sum: f64 = values.iter().sum();
    let magnitude: f64 = values.iter().map(|v| v.abs()).sum();
    // Relative to the mean, so that single precision holds any filter; false for NaN.
    let normal = magnitude.is_finite() && magnitude > 0.0 && sum.abs() >= MIN_RATIO * magnitude;
    if !normal {
        return None;
    }
    let mean = magnitude / values.len() as f64;
    let distribution = Distribution1D::new(values.iter().map(|v| (v.abs() / mean) as f32));
    let weights = values
        .iter()
        .map(|v| (v.signum() * magnitude / sum) as f32)
        .collect();
    Some((distribution, weights))
}
