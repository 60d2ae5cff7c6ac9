//! The `disney` material.

use super::inputs::{float_within, given_refractive_index, unit_input};
use super::lobes::{diffuse_transmission, glossy, refraction, rough_refraction};
use super::{Place, Scattering, may_scatter};
use crate::bsdf::clearcoat::Clearcoat;
use crate::bsdf::disney_diffuse::DisneyDiffuse;
use crate::bsdf::fresnel::Fresnel;
use crate::bsdf::trowbridge_reitz::TrowbridgeReitz;
use crate::bsdf::{Bsdf, Lobe};
use crate::bssrdf::Bssrdf;
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::Rgb;
use crate::math::color::{is_black, luminance};
use crate::params::ParamReader;
use crate::surface::SurfaceHit;

/// Widths of the clearcoat at gloss 0 and 1 (Burley 2012, appendix B.2).
const CLEARCOAT_ALPHA: [f32; 2] = [0.1, 0.001];

/// Maximum roughness, whose square is the widest distribution.
const MAX_ROUGHNESS: f32 = 1e3;

/// Maximum number of lobes at a point: diffuse, glossy, coat, rough refraction, diffuse transmission.
pub(super) const MAX_LOBES: usize = 5;

/// The Disney BSDF (Burley, "Physically Based Shading at Disney", 2012; "Extending the Disney BRDF to a BSDF", 2015),
/// as in pbrt-v3. Parameters, floats from 0 to 1 unless noted otherwise:
///
/// - spectrum `color` (0.5);
/// - `metallic` (0), and `spectrans` (0): fraction of metal, and fraction of glass in the remainder;
/// - `eta` (1.5): refractive index;
/// - `roughness` (0.5), 0 or more: the facet distribution's width is its square;
/// - `speculartint` (0): tint of the reflection at normal incidence with the color's hue, to the extent that the
///   surface is metallic: in pbrt-v3 the non-metallic part reflects by Fresnel's equations, untinted;
/// - `anisotropic` (0), at most 1: stretches the highlight along u;
/// - `sheen` (0), 0 or more, and its tint `sheentint` (0.5);
/// - `clearcoat` (0), 0 or more, and `clearcoatgloss` (1);
/// - constant bool `thin` (false): a thin sheet without interior, for which `flatness` (0) blends the diffuse
///   reflection into approximate subsurface scattering, and `difftrans` (1), 0 to 2, transmits half its value of the
///   diffuse light;
/// - spectrum `scatterdistance` (0): distance that light travels inside; if it is not black, subsurface scattering
///   ([`crate::bssrdf`]) replaces the diffuse reflection.
///
/// In pbrt-v3's thin sheets, diffuse transmission is not taken from what metal and glass leave over, and
/// retro-reflection is not reduced by it: they can return more energy than they receive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disney {
    /// Base color.
    pub color: SpectrumInput,
    /// Fraction of metal.
    pub metallic: FloatInput,
    /// Refractive index of the inside.
    pub eta: FloatInput,
    /// Roughness.
    pub roughness: FloatInput,
    /// Tint of the specular reflection.
    pub specular_tint: FloatInput,
    /// Stretch of the highlight.
    pub anisotropic: FloatInput,
    /// Sheen: reflectance at grazing angles, as of cloth.
    pub sheen: FloatInput,
    /// Tint of the sheen.
    pub sheen_tint: FloatInput,
    /// Strength of the clearcoat.
    pub clearcoat: FloatInput,
    /// Gloss of the clearcoat.
    pub clearcoat_gloss: FloatInput,
    /// Fraction of glass in the non-metallic part.
    pub spec_trans: FloatInput,
    /// `true` if the surface is a thin sheet without interior.
    pub thin: bool,
    /// For a thin sheet: fraction of approximate subsurface scattering.
    pub flatness: FloatInput,
    /// For a thin sheet: twice the fraction of diffuse light that is transmitted.
    pub diff_trans: FloatInput,
    /// For a solid: how far light travels inside, in scene units; black for a diffuse surface.
    pub scatter_distance: SpectrumInput,
}

/// The parameters evaluated at a point.
struct Point {
    color: Rgb,
    /// The color's hue at luminance 1.
    tint: Rgb,
    metallic: f32,
    eta: f32,
    roughness: f32,
    spec_trans: f32,
    /// Fraction of diffuse light that a thin sheet transmits; 0 for a solid.
    diff_trans: f32,
    /// Square root of the ratio of the highlight's widths.
    aspect: f32,
}

impl Point {
    /// Fraction that is neither metal nor glass.
    fn diffuse_weight(&self) -> f32 {
        (1.0 - self.metallic) * (1.0 - self.spec_trans)
    }

    fn distribution(&self, roughness: f32) -> TrowbridgeReitz {
        let alpha = roughness * roughness;
        TrowbridgeReitz::new(alpha / self.aspect, alpha * self.aspect)
    }
}

impl Disney {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Disney {
        let unit = |name, default| unit_input(reader, name, default);
        let positive = |name, default| float_within(reader, name, default, 0.0..=f32::MAX);
        Disney {
            color: reader.spectrum_input("color", Rgb::splat(0.5)),
            metallic: unit("metallic", 0.0),
            eta: given_refractive_index(reader, "eta").unwrap_or(FloatInput::Constant(1.5)),
            roughness: positive("roughness", 0.5),
            specular_tint: unit("speculartint", 0.0),
            anisotropic: float_within(reader, "anisotropic", 0.0, f32::MIN..=1.0),
            sheen: positive("sheen", 0.0),
            sheen_tint: unit("sheentint", 0.5),
            clearcoat: positive("clearcoat", 0.0),
            clearcoat_gloss: unit("clearcoatgloss", 1.0),
            spec_trans: unit("spectrans", 0.0),
            thin: reader.boolean("thin", false),
            flatness: unit("flatness", 0.0),
            diff_trans: float_within(reader, "difftrans", 1.0, 0.0..=2.0),
            scatter_distance: reader.spectrum_input("scatterdistance", Rgb::ZERO),
        }
    }

    /// The scatter distance, if it is not black and there is an interior.
    fn scatter_distance(&self, at: &Place) -> Option<Rgb> {
        if !self.has_interior() {
            return None;
        }
        let distance = at.reflectance(&self.scatter_distance);
        (!is_black(distance)).then_some(distance)
    }

    fn at(&self, at: &Place) -> Point {
        let color = at.reflectance(&self.color);
        let brightness = luminance(color);
        let anisotropic = at.float(&self.anisotropic);
        let anisotropic = if anisotropic.is_nan() {
            0.0
        } else {
            anisotropic.min(1.0)
        };
        let diff_trans = at.within(&self.diff_trans, 0.0, 2.0);
        Point {
            color,
            tint: if brightness > 0.0 {
                color / brightness
            } else {
                Rgb::ONE
            },
            metallic: at.unit(&self.metallic),
            eta: at.refractive_index(&self.eta),
            roughness: at.within(&self.roughness, 0.0, MAX_ROUGHNESS),
            spec_trans: at.unit(&self.spec_trans),
            diff_trans: if self.thin { 0.5 * diff_trans } else { 0.0 },
            // Burley 2012, appendix B.2.
            aspect: (1.0 - 0.9 * anisotropic).sqrt(),
        }
    }

    fn add_diffuse(&self, point: &Point, weight: f32, at: &Place, bsdf: &mut Bsdf) {
        let sheen = at.strength(&self.sheen);
        let sheen_tint = at.unit(&self.sheen_tint);
        let flat = if self.thin {
            at.unit(&self.flatness)
        } else {
            0.0
        };
        let mut stays = 1.0 - point.diff_trans;
        if self.scatter_distance(at).is_some() {
            // The base becomes light that enters, to exit somewhere else.
            stays = 0.0;
            bsdf.extend(refraction(Rgb::ONE, 1.0, point.eta));
        }
        let lobe = DisneyDiffuse {
            reflectance: weight * point.color,
            base: (1.0 - flat) * stays,
            flat: flat * stays,
            sheen: weight * sheen * Rgb::ONE.lerp(point.tint, sheen_tint),
            roughness: point.roughness,
        };
        if !is_black(lobe.reflectance) || !is_black(lobe.sheen) {
            bsdf.add(Lobe::DisneyDiffuse(lobe));
        }
    }

    /// Rough refraction, tinted so that light that has entered and left has the color (Burley 2015, §4); for a thin
    /// sheet diffuse transmission, and a roughness that approximates a thin plate's (figure 15).
    fn add_transmission(&self, point: &Point, solid: TrowbridgeReitz, bsdf: &mut Bsdf) {
        let distribution = if self.thin {
            point.distribution((0.65 * point.eta - 0.35) * point.roughness)
        } else {
            solid
        };
        let transmittance = point.spec_trans * point.color.map(f32::sqrt);
        bsdf.extend(rough_refraction(transmittance, distribution, point.eta));
        bsdf.extend(diffuse_transmission(point.diff_trans * point.color));
    }
}

impl Scattering for Disney {
    fn is_isotropic(&self) -> bool {
        self.anisotropic == FloatInput::Constant(0.0)
    }

    fn add_lobes(&self, at: &Place, bsdf: &mut Bsdf) {
        let point = self.at(at);
        let diffuse_weight = point.diffuse_weight();
        if diffuse_weight > 0.0 {
            self.add_diffuse(&point, diffuse_weight, at, bsdf);
        }
        let distribution = point.distribution(point.roughness).separable();
        let glass = ((point.eta - 1.0) / (point.eta + 1.0)).powi(2);
        let glass = glass * Rgb::ONE.lerp(point.tint, at.unit(&self.specular_tint));
        let fresnel = Fresnel::Disney {
            r0: glass.lerp(point.color, point.metallic),
            metallic: point.metallic,
            eta: point.eta,
        };
        bsdf.extend(glossy(Rgb::ONE, distribution, fresnel));
        let clearcoat = at.strength(&self.clearcoat);
        if clearcoat > 0.0 {
            let [dull, glossy] = CLEARCOAT_ALPHA;
            bsdf.add(Lobe::Clearcoat(Clearcoat {
                weight: Rgb::splat(clearcoat),
                alpha: dull + at.unit(&self.clearcoat_gloss) * (glossy - dull),
            }));
        }
        self.add_transmission(&point, distribution, bsdf);
    }

    fn has_interior(&self) -> bool {
        !self.thin && may_scatter(&self.scatter_distance)
    }

    /// Subsurface scattering at a point: Burley's normalized diffusion, with a fifth of `scatterdistance` as in pbrt-v3
    /// (Christensen and Burley 2015). `None` if the diffuse reflection is at the surface.
    fn bssrdf(&self, hit: &SurfaceHit, bsdf: &Bsdf, at: &Place) -> Option<Bssrdf<'static>> {
        let distance = self.scatter_distance(at)?;
        let point = self.at(at);
        let weight = point.diffuse_weight();
        (weight > 0.0).then(|| {
            let albedo = weight * point.color;
            Bssrdf::normalized(hit, *bsdf.frame(), albedo, 0.2 * distance, point.eta)
        })
    }

    fn max_lobes(&self) -> usize {
        MAX_LOBES
    }
}
