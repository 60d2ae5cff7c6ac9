//! Diffuse lobes of the Disney BRDF: base, approximate (thin-surface) subsurface scattering, retro-reflection and sheen
//! (Burley, "Physically Based Shading at Disney", 2012, §5.3 and §5.5; "Extending the Disney BRDF to a BSDF", 2015, §5
//! and §6.2). Directions are local.

use super::fresnel::schlick_weight;
use crate::math::{Rgb, Vec3};
use std::f32::consts::FRAC_1_PI;

/// All cosine-sampled terms in one lobe; pbrt-v3 has a lobe for each term.
#[derive(Clone, Copy, Debug)]
pub struct DisneyDiffuse {
    /// Reflectance, which `base` and `flat` scale; retro-reflection uses all of it.
    pub reflectance: Rgb,
    /// Fraction of the base.
    pub base: f32,
    /// Fraction of the approximate subsurface scattering.
    pub flat: f32,
    /// Reflectance of the sheen.
    pub sheen: Rgb,
    /// Roughness, as given in the scene, 0 or more.
    pub roughness: f32,
}

impl DisneyDiffuse {
    /// The BRDF, in 1/sr: f_base of Burley 2015, equation 4, with f_lambert and f_retro weighted separately, the
    /// Hanrahan–Krueger approximation of subsurface scattering of Burley 2012, §5.3, and the sheen of §5.5.
    pub fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        let Some(h) = (wo + wi).try_normalize() else {
            return Rgb::ZERO;
        };
        let cos_d = wi.dot(h);
        let (cos_o, cos_i) = (wo.z.abs(), wi.z.abs());
        let (fo, fi) = (schlick_weight(cos_o), schlick_weight(cos_i));
        let base = (1.0 - 0.5 * fo) * (1.0 - 0.5 * fi);
        let rr = 2.0 * self.roughness * cos_d * cos_d;
        let retro = rr * (fo + fi + fo * fi * (rr - 1.0));
        let mut diffuse = self.base * base + retro;
        if self.flat > 0.0 {
            let f90 = 0.5 * rr;
            let lerp = |weight: f32| 1.0 + weight * (f90 - 1.0);
            let shape = lerp(fo) * lerp(fi);
            diffuse += self.flat * 1.25 * (shape * (1.0 / (cos_o + cos_i) - 0.5) + 0.5);
        }
        self.reflectance * (FRAC_1_PI * diffuse) + self.sheen * schlick_weight(cos_d)
    }
}
