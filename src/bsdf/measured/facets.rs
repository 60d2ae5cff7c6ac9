//! Distribution of facet normals that approximates a measured BRDF, for importance sampling.

use super::half_angle::{bin, half_angle};
use crate::math::color::luminance;
use crate::math::distribution::Distribution1D;
use crate::math::sampling::sin_cos_turns;
use crate::math::{Rgb, Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, PI};

/// Normals whose density over their angle θh to the surface's normal is cos θh times a constant in each bin. Bins are
/// equal in √θh, like those of MERL tables: narrow around highlights.
#[derive(Clone, PartialEq)]
pub(super) struct Facets {
    /// Probabilities of the bins.
    bins: Distribution1D,
}

impl Facets {
    /// Treats the BRDF `f` as if it were purely a distribution of facets, averaging over difference angles.
    pub(super) fn new(bins: usize, f: impl Fn(Vec3, Vec3) -> Rgb) -> Facets {
        let share = |i: usize| {
            let (low, high) = (squared_sine(i, bins), squared_sine(i + 1, bins));
            let middle = FRAC_PI_2 * ((i as f32 + 0.5) / bins as f32).powi(2);
            mean(middle, &f) * (high - low)
        };
        Facets {
            bins: Distribution1D::new((0..bins).map(share)),
        }
    }

    /// Samples a normal above the surface.
    pub(super) fn sample(&self, u: Vec2) -> Vec3 {
        let (i, _, inside) = self.bins.sample_discrete(u.x);
        let low = squared_sine(i, self.bins.cells());
        let high = squared_sine(i + 1, self.bins.cells());
        let squared_sine = low + inside * (high - low);
        let (sin_phi, cos_phi) = sin_cos_turns(u.y);
        let across = squared_sine.sqrt() * Vec2::new(cos_phi, sin_phi);
        across.extend((1.0 - squared_sine).max(0.0).sqrt())
    }

    /// Density per solid angle of the direction to which `wo` is reflected; both are on the same side.
    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let h = wo + wi;
        let count = self.bins.cells();
        let i = bin((half_angle(h) / FRAC_PI_2).sqrt(), count);
        let width = squared_sine(i + 1, count) - squared_sine(i, count);
        // cos θh / (4 wo·h) with unit h, as wo·h is half the length of wo + wi.
        let pdf =
            self.bins.probability(i) * FRAC_1_PI / width * h.z.abs() / (2.0 * h.length_squared());
        if pdf.is_finite() { pdf } else { 0.0 }
    }
}

/// sin² θh where bin `i` of `bins` starts.
fn squared_sine(i: usize, bins: usize) -> f32 {
    let root = i as f32 / bins as f32;
    (FRAC_PI_2 * root * root).sin().powi(2)
}

/// Mean luminance over pairs of directions above the surface with this half angle; 0 if there are none.
fn mean(theta_h: f32, f: &impl Fn(Vec3, Vec3) -> Rgb) -> f32 {
    const DIFFERENCES: usize = 8;
    const AZIMUTHS: usize = 4;
    let (sin_h, cos_h) = theta_h.sin_cos();
    let h = Vec3::new(sin_h, 0.0, cos_h);
    let (mut sum, mut count) = (0.0f64, 0.0);
    for k in 0..DIFFERENCES * AZIMUTHS {
        let d = (k / AZIMUTHS) as f32 + 0.5;
        let squared = d / DIFFERENCES as f32;
        let (sin_d, cos_d) = (squared.sqrt(), (1.0 - squared).sqrt());
        let phi = PI * ((k % AZIMUTHS) as f32 + 0.5) / AZIMUTHS as f32;
        let (x, y) = (sin_d * phi.cos(), sin_d * phi.sin());
        let wi = Vec3::new(cos_h * x + sin_h * cos_d, y, cos_h * cos_d - sin_h * x);
        let wo = 2.0 * wi.dot(h) * h - wi;
        if wi.z > 0.0 && wo.z > 0.0 {
            sum += f64::from(luminance(f(wo, wi)));
            count += 1.0;
        }
    }
    if count > 0.0 {
        (sum / count) as f32
    } else {
        0.0
    }
}
