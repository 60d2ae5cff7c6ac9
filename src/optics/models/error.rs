//! How far a model is off, measured against exact rays.

use super::{LensModel, Models};
use crate::math::Vec2;
use crate::optics::trace::LensRay;

/// Errors of a model over the whole image circle and the whole pupil.
///
/// A ray's error is the angle between where it and the exact ray point, as seen from the lens toward the
/// plane of focus, times the focal length: how far off it is in the picture, in pixels. For fisheyes too,
/// whose middle has that scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelError {
    /// Root mean square, pixels.
    pub rms: f64,
    /// Half the rays are off by less, pixels.
    pub p50: f64,
    /// 99 of 100 rays are off by less, pixels.
    pub p99: f64,
    /// The largest met, pixels.
    pub max: f64,
    /// Rays that pass the model and not the lens, or the other way round, over those that pass the lens.
    pub wrong_outcome: f64,
    /// Rays measured.
    pub rays: usize,
}

/// Rays tried: the 99th percentile of 8000 is that of the lens to a few hundredths of itself.
const RAYS: usize = 8192;

impl Models<'_> {
    /// Measures `model`, for pixels of `pixel` mm. `None` where no ray passes.
    pub fn error(&self, model: &LensModel, pixel: f64) -> Option<ModelError> {
        let mut errors = Vec::with_capacity(RAYS);
        let (mut passed, mut wrong) = (0usize, 0usize);
        for i in 0..RAYS {
            let (film, u) = self.sample(i);
            let Some(aim) = self.pupil.sample(film, u) else {
                continue;
            };
            let exact = self.lens.trace_from_film(film, aim.point);
            let ray = model.trace_from_film(film, aim.point);
            passed += usize::from(exact.is_ok());
            match (exact, ray) {
                (Ok(exact), Ok(ray)) => errors.push(self.ray_error(&exact, &ray) / pixel),
                (Err(_), Err(_)) => {}
                _ => wrong += 1,
            }
        }
        errors.sort_by(f64::total_cmp);
        let max = *errors.last()?;
        let mean_square = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
        Some(ModelError {
            rms: mean_square.sqrt(),
            p50: errors[errors.len() / 2],
            p99: errors[(errors.len() * 99 / 100).min(errors.len() - 1)],
            max,
            wrong_outcome: wrong as f64 / passed.max(1) as f64,
            rays: errors.len(),
        })
    }

    /// Film points evenly over the image circle, and numbers for the pupil (Roberts' R sequence in
    /// four dimensions, 2018).
    pub fn sample(&self, i: usize) -> ([f64; 2], Vec2) {
        let r = |k: i32| (0.5 + (i + 1) as f64 / 1.167_303_978_261_418_7f64.powi(k)).fract();
        let radius = self.film_radius * r(1).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * r(2)).sin_cos();
        let u = Vec2::new(r(3) as f32, r(4) as f32);
        ([radius * cos, radius * sin], u)
    }

    /// How far apart two rays are in the picture, mm.
    pub fn ray_error(&self, exact: &LensRay<f64>, ray: &LensRay<f64>) -> f64 {
        let cardinals = self.lens.paraxial().cardinals;
        let focal_length = cardinals.map_or(self.lens.film_distance(), |c| c.focal_length.abs());
        // How far in front of the lens things are sharp.
        let distance = self.lens.plane_of_focus().map_or(f64::INFINITY, f64::abs);
        let angle = if distance.is_finite() && distance > 0.0 {
            // From the point of the exact ray there to the other ray.
            let v: [f64; 3] =
                std::array::from_fn(|i| exact.o[i] + distance * exact.d[i] - ray.o[i]);
            length(cross(v, ray.d)) / distance
        } else {
            length(std::array::from_fn(|i| exact.d[i] - ray.d[i]))
        };
        focal_length * angle
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
