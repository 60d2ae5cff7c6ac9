//! The Trowbridge–Reitz (GGX) distribution of microfacet normals, anisotropic
//! (Pharr, Jakob and Humphreys 2016, §8.4). Directions are local: z along the shading normal.

use crate::math::float::clamp_nan_low;
use crate::math::sampling::sin_cos_turn;
use crate::math::{Vec2, Vec3};
use std::f32::consts::PI;

/// Minimum width: narrower lobes exceed single precision.
const MIN_ALPHA: f32 = 0.001;

/// Maximum width: far beyond practical use, and its powers are finite.
const MAX_ALPHA: f32 = 1e6;

/// Widths α of the distribution of slopes along the frame's s and t (x and y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrowbridgeReitz {
    alpha_x: f32,
    alpha_y: f32,
    /// Uncorrelated Smith masking: G1(wo)·G1(wi).
    separable: bool,
}

impl TrowbridgeReitz {
    /// Widths below 0.001, and NaN, are raised to it.
    pub fn new(alpha_x: f32, alpha_y: f32) -> TrowbridgeReitz {
        TrowbridgeReitz {
            alpha_x: clamp_nan_low(alpha_x, MIN_ALPHA, MAX_ALPHA),
            alpha_y: clamp_nan_low(alpha_y, MIN_ALPHA, MAX_ALPHA),
            separable: false,
        }
    }

    /// One of these [widths](TrowbridgeReitz::widths), with correlated masking.
    #[inline(always)]
    pub(super) fn of_widths(alpha_x: f32, alpha_y: f32) -> TrowbridgeReitz {
        TrowbridgeReitz {
            alpha_x,
            alpha_y,
            separable: false,
        }
    }

    #[inline(always)]
    pub(super) fn widths(&self) -> (f32, f32) {
        (self.alpha_x, self.alpha_y)
    }

    pub(super) fn is_separable(&self) -> bool {
        self.separable
    }

    /// The same distribution with uncorrelated masking and shadowing, as in the Disney model.
    pub fn separable(self) -> TrowbridgeReitz {
        TrowbridgeReitz {
            separable: true,
            ..self
        }
    }

    /// Differential area of facets with normal `h`, per area of surface and solid angle: equation 8.10, written without
    /// the tangent so that narrow lobes keep their precision near the pole.
    #[inline(always)]
    pub fn d(&self, h: Vec3) -> f32 {
        let (x, y) = (h.x / self.alpha_x, h.y / self.alpha_y);
        let e = x * x + y * y + h.z * h.z;
        1.0 / (PI * self.alpha_x * self.alpha_y * e * e)
    }

    /// Smith's Λ: the ratio of masked to visible facet area seen from `w` (§8.4.3); infinite at grazing directions.
    #[inline(always)]
    pub fn lambda(&self, w: Vec3) -> f32 {
        let (x, y) = (w.x * self.alpha_x, w.y * self.alpha_y);
        0.5 * ((1.0 + (x * x + y * y) / (w.z * w.z)).sqrt() - 1.0)
    }

    /// Smith masking G1: the fraction of facets visible from `w`.
    #[inline(always)]
    pub fn g1(&self, w: Vec3) -> f32 {
        1.0 / (1.0 + self.lambda(w))
    }

    /// Smith masking-shadowing G: the fraction of facets visible from both directions, height-correlated (§8.4.3) or
    /// uncorrelated.
    #[inline(always)]
    pub fn g(&self, wo: Vec3, wi: Vec3) -> f32 {
        if self.separable {
            return self.g1(wo) * self.g1(wi);
        }
        1.0 / (1.0 + self.lambda(wo) + self.lambda(wi))
    }

    /// [`TrowbridgeReitz::g`], and [`TrowbridgeReitz::g1`] from `wo`.
    #[inline(always)]
    pub fn g_and_g1(&self, wo: Vec3, wi: Vec3) -> (f32, f32) {
        let (hidden_o, hidden_i) = (self.lambda(wo), self.lambda(wi));
        let g1 = 1.0 / (1.0 + hidden_o);
        let g = if self.separable {
            g1 / (1.0 + hidden_i)
        } else {
            1.0 / (1.0 + hidden_o + hidden_i)
        };
        (g, g1)
    }

    /// Samples a facet normal (z ≥ 0 if `wo` is above the surface) from those visible from `wo` (Heitz, "Sampling the
    /// GGX Distribution of Visible Normals", JCGT 7(4), 2018). Without a branch.
    #[inline(always)]
    pub fn sample(&self, wo: Vec3, u: Vec2) -> Vec3 {
        let side = 1.0f32.copysign(wo.z);
        let wo = wo * side;
        // In the space where the distribution is a hemisphere:
        let view = Vec3::new(self.alpha_x * wo.x, self.alpha_y * wo.y, wo.z).normalize();
        let (t1, has_side) = unit(Vec3::new(-view.y, view.x, 0.0));
        let t1 = if has_side { t1 } else { Vec3::X };
        let t2 = view.cross(t1);
        // a point of the hemisphere's projection along the view, a half disk and half an ellipse.
        let (r, (sin, cos)) = (u.x.sqrt(), sin_cos_turn(u.y));
        let p1 = r * cos;
        let blend = 0.5 * (1.0 + view.z);
        let p2 = (1.0 - blend) * (1.0 - p1 * p1).max(0.0).sqrt() + blend * r * sin;
        let p3 = (1.0 - p1 * p1 - p2 * p2).max(0.0).sqrt();
        let n = p1 * t1 + p2 * t2 + p3 * view;
        side * Vec3::new(self.alpha_x * n.x, self.alpha_y * n.y, n.z.max(1e-6)).normalize()
    }

    /// A direction that a facet reflects to `wo`, and whether it is above the surface, where it counts: see [`TrowbridgeReitz::sample`].
    #[inline(always)]
    pub(super) fn sample_reflection(&self, wo: Vec3, u: Vec2) -> (Vec3, bool) {
        let h = self.sample(wo, u);
        let wi = 2.0 * wo.dot(h) * h - wo;
        (wi, (wo.dot(h) > 0.0) & (wo.z * wi.z > 0.0))
    }

    /// What facets that are perfect mirrors reflect, without a branch.
    #[inline(always)]
    pub(super) fn reflection(&self, wo: Vec3, wi: Vec3) -> FacetReflection {
        let cosines = wo.z * wi.z;
        let (h, has_facet) = unit(wo + wi);
        let may = has_facet & (cosines != 0.0);
        let d = self.d(h);
        let (g, g1) = self.g_and_g1(wo, wi);
        let cosine = wi.dot(if h.z < 0.0 { -h } else { h });
        let f = d * g / (4.0 * cosines.abs());
        // The cosine in the density of facets cancels with that of the reflection's Jacobian.
        let pdf = d * g1 / (4.0 * wo.z.abs());
        FacetReflection {
            cosine: if may { cosine } else { 0.0 },
            f: if may { f } else { 0.0 },
            pdf: if may & (cosines > 0.0) { pdf } else { 0.0 },
        }
    }

    /// Density of [`TrowbridgeReitz::sample`] per solid angle of facet normals.
    #[inline(always)]
    pub fn pdf(&self, wo: Vec3, h: Vec3) -> f32 {
        self.d(h) * self.g1(wo) * wo.dot(h).abs() / wo.z.abs()
    }
}

/// What facets reflect from one direction to another.
#[derive(Clone, Copy, Debug)]
pub(super) struct FacetReflection {
    /// Of the incident direction to the facet's normal, which is taken on the side of the surface normal.
    pub cosine: f32,
    /// The BRDF of mirrors, in 1/sr (equation 8.19): 0 where no facet reflects.
    pub f: f32,
    /// Density of [`TrowbridgeReitz::sample_reflection`], per steradian.
    pub pdf: f32,
}

/// The unit vector along `v`, and whether there is one: `Vec3::try_normalize` without a branch.
#[inline(always)]
fn unit(v: Vec3) -> (Vec3, bool) {
    let reciprocal = v.length_recip();
    (v * reciprocal, reciprocal.is_finite() & (reciprocal > 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facets_cover_the_surface_exactly_once() {
        // ∫ D(h) cos θ dh = 1 (equation 8.7), by the midpoint rule in slope-adapted angles.
        for (ax, ay) in [(0.1, 0.1), (0.5, 0.1), (1.6, 0.3)] {
            let d = TrowbridgeReitz::new(ax, ay);
            let (n, m) = (2000, 400);
            let mut sum = 0.0f64;
            for i in 0..n {
                let theta = (i as f64 + 0.5) / n as f64 * std::f64::consts::FRAC_PI_2;
                for j in 0..m {
                    let phi = (j as f64 + 0.5) / m as f64 * std::f64::consts::TAU;
                    let h = Vec3::new(
                        (theta.sin() * phi.cos()) as f32,
                        (theta.sin() * phi.sin()) as f32,
                        theta.cos() as f32,
                    );
                    sum += d.d(h) as f64 * theta.cos() * theta.sin();
                }
            }
            let integral =
                sum * std::f64::consts::FRAC_PI_2 / n as f64 * std::f64::consts::TAU / m as f64;
            // The midpoint rule's error falls with 1/n²; single-precision D adds 1e-6.
            assert!((integral - 1.0).abs() < 1e-4, "{ax} {ay}: {integral}");
        }
    }

    #[test]
    fn narrow_lobes_keep_their_shape() {
        // At α = 0.001, half a lobe width off the pole: D falls to 1/(1 + ¼)² of its peak.
        let d = TrowbridgeReitz::new(0.0, 0.0);
        let off = Vec3::new(0.0005, 0.0, 1.0).normalize();
        assert!((d.d(off) / d.d(Vec3::Z) - 1.0 / 1.5625).abs() < 1e-4);
    }
}
