//! Glossy coat over a diffuse base, blended by Fresnel reflectance (Ashikhmin and Shirley 2000; Pharr, Jakob and
//! Humphreys 2016, §8.5 and §14.1.3). Directions are local.

use super::fresnel::schlick_weight;
use super::lobe::reflecting_facet;
use super::lobe_choice::rescaled;
use super::lobe_sample::LobeSample;
use super::trowbridge_reitz::TrowbridgeReitz;
use crate::math::sampling::{cosine_hemisphere, cosine_hemisphere_pdf};
use crate::math::{Rgb, Vec2, Vec3};
use std::f32::consts::PI;

/// Diffuse under glossy: the more the coat reflects at grazing angles, the less is left for the base. The glossy part
/// has no masking term, as published.
#[derive(Clone, Copy, Debug)]
pub struct FresnelBlend {
    /// Reflectance of the base.
    pub diffuse: Rgb,
    /// Reflectance of the coat at normal incidence. Above 1 the base gets nothing: pbrt-v3 would make it negative.
    pub specular: Rgb,
    /// Distribution of the coat's facet normals.
    pub distribution: TrowbridgeReitz,
    /// Scale of the whole. The two reflectances cannot include it, since the base depends on both.
    pub scale: Rgb,
}

impl FresnelBlend {
    /// The BRDF, in 1/sr (§8.5, the two terms of the model).
    pub fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        let (cos_o, cos_i) = (wo.z.abs(), wi.z.abs());
        let under = |cos: f32| 1.0 - (1.0 - 0.5 * cos).powi(5);
        let rest = (Rgb::ONE - self.specular).max(Rgb::ZERO);
        let diffuse = self.diffuse * rest * (28.0 / (23.0 * PI) * under(cos_o) * under(cos_i));
        let Some(h) = (wo + wi).try_normalize() else {
            return self.scale * diffuse;
        };
        let cos_h = wi.dot(h);
        let schlick = self.specular + (Rgb::ONE - self.specular) * schlick_weight(cos_h);
        let shape = self.distribution.d(h) / (4.0 * cos_h.abs() * cos_o.max(cos_i));
        // Directions on opposite sides, possible with perturbed normals, may be perpendicular to the facet's normal.
        let shape = if shape.is_finite() { shape } else { 0.0 };
        self.scale * (diffuse + schlick * shape)
    }

    /// Density of [`FresnelBlend::sample`].
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        reflecting_facet(wo, wi).map_or(0.0, |h| {
            let glossy = self.distribution.pdf(wo, h) / (4.0 * wo.dot(h).abs());
            0.5 * (cosine_hemisphere_pdf(wi.z.abs()) + glossy)
        })
    }

    /// Samples a cosine-distributed direction for `u.x` below ½, otherwise one reflected about a facet; `None` if that
    /// would leave below the surface.
    pub fn sample(&self, wo: Vec3, u: Vec2) -> Option<LobeSample> {
        let wi = if u.x < 0.5 {
            let wi = cosine_hemisphere(rescaled(u, 0.5));
            wi.with_z(wi.z.copysign(wo.z))
        } else {
            let u = rescaled(u - Vec2::new(0.5, 0.0), 0.5);
            let h = self.distribution.sample(wo, u);
            2.0 * wo.dot(h) * h - wo
        };
        LobeSample::evaluated(wi, self.pdf(wo, wi), || self.f(wo, wi))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::testing::direction;

    fn blend(diffuse: f32, specular: f32) -> FresnelBlend {
        FresnelBlend {
            diffuse: Rgb::splat(diffuse),
            specular: Rgb::splat(specular),
            distribution: TrowbridgeReitz::new(0.3, 0.3),
            scale: Rgb::ONE,
        }
    }

    #[test]
    fn the_parts_have_their_published_values_head_on() {
        // Base: 28/(23π) · ½ · (1 − 0.2) · (1 − ½⁵)²; coat: D(0)/4 · 0.2 with D(0) = 1/(π 0.09).
        let base = 28.0 / (23.0 * PI) * 0.5 * 0.8 * (31.0f32 / 32.0).powi(2);
        let coat = 0.2 / (4.0 * PI * 0.09);
        let f = blend(0.5, 0.2).f(Vec3::Z, Vec3::Z).x;
        // Rounding.
        assert!((f - base - coat).abs() < 1e-5, "{f}");
    }

    #[test]
    fn a_full_coat_leaves_the_base_nothing() {
        let (wo, wi) = (direction(20.0, 0.0), direction(50.0, 100.0));
        for specular in [1.0, 2.0] {
            assert_eq!(
                blend(0.8, specular).f(wo, wi),
                blend(0.0, specular).f(wo, wi)
            );
        }
    }
}
