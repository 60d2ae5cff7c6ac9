//! Materials: what a surface's BSDF is at each of its points (scene-language 3.8).
//!
//! Every parameter may be a constant or a texture unless its doc comment says otherwise;
//! reflectances below 0 count as 0.

mod bump;
mod glass;
mod matte;
mod metal;
mod mirror;
mod plastic;
mod roughness;
mod uber;

pub use bump::Bump;
pub use glass::Glass;
pub use matte::Matte;
pub use metal::Metal;
pub use mirror::Mirror;
pub use plastic::Plastic;
pub use roughness::RoughnessMeaning;
pub use uber::Uber;

use crate::bsdf::Bsdf;
use crate::math::Rgb;
use crate::params::{Dialect, FloatInput, ParamReader, SpectrumInput};
use crate::surface::{Footprint, SurfaceHit, TexturePoint};
use crate::textures::{TextureUsage, Textures};

/// A material: kinds of scattering, and bumps that tilt the shading normal.
/// Common parameter: float texture `bumpmap` (none), displacement in scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// How light is scattered.
    pub kind: MaterialKind,
    /// `bumpmap`.
    pub bump: Option<Bump>,
}

/// The kinds of materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MaterialKind {
    /// `matte`
    Matte(Matte),
    /// `mirror`
    Mirror(Mirror),
    /// `glass`
    Glass(Glass),
    /// `plastic`
    Plastic(Plastic),
    /// `metal`
    Metal(Metal),
    /// `uber`
    Uber(Uber),
}

/// Does this type string mean a boundary that does not scatter at all?
pub fn is_none(kind: &str) -> bool {
    matches!(kind, "" | "none")
}

impl Material {
    /// The types that are modelled.
    pub const KINDS: [&'static str; 6] = ["matte", "mirror", "glass", "plastic", "metal", "uber"];

    /// The material that `Material "type"` describes, or `MakeNamedMaterial` with that
    /// `"string type"` as the reader's kind; `None` for [no material](is_none). Types that are
    /// unknown, or not supported yet, give a warning and `matte` from the same parameters.
    pub fn from_params(reader: &ParamReader) -> Option<Material> {
        let kind = match reader.kind() {
            kind if is_none(kind) => return None,
            "matte" => MaterialKind::Matte(Matte::from_params(reader)),
            "mirror" => MaterialKind::Mirror(Mirror::from_params(reader)),
            "glass" => MaterialKind::Glass(Glass::from_params(reader)),
            "plastic" => MaterialKind::Plastic(Plastic::from_params(reader)),
            "metal" => MaterialKind::Metal(Metal::from_params(reader)),
            "uber" => MaterialKind::Uber(Uber::from_params(reader)),
            kind => {
                const DONE: &str = "a matte of the same parameters is used";
                match PLANNED.contains(&kind) {
                    true => reader.unsupported_kind(DONE),
                    false => reader.unknown_kind_replaced(&Material::KINDS, DONE),
                }
                MaterialKind::Matte(Matte::from_params(reader))
            }
        };
        Some(Material {
            kind,
            bump: Bump::from_params(reader),
        })
    }

    /// The type's name, for messages: that of the variant, which is the scene file's.
    pub fn name(&self) -> String {
        let text = format!("{:?}", self.kind);
        let name = text.split(['(', ' ', '{']).next().unwrap_or_default();
        name.to_lowercase()
    }

    /// The BSDF at a point.
    pub fn bsdf(&self, hit: &SurfaceHit, footprint: &Footprint, textures: &Textures) -> Bsdf {
        let at = TexturePoint {
            p: hit.p,
            uv: hit.uv,
            footprint: *footprint,
        };
        let shading = match &self.bump {
            Some(bump) => bump.shading_geometry(hit, &at, textures),
            None => hit.shading,
        };
        let mut bsdf = Bsdf::new(hit.n, &shading);
        match &self.kind {
            MaterialKind::Matte(m) => m.add_lobes(&at, textures, &mut bsdf),
            MaterialKind::Mirror(m) => m.add_lobes(&at, textures, &mut bsdf),
            MaterialKind::Glass(m) => m.add_lobes(&at, textures, &mut bsdf),
            MaterialKind::Plastic(m) => m.add_lobes(&at, textures, &mut bsdf),
            MaterialKind::Metal(m) => m.add_lobes(&at, textures, &mut bsdf),
            MaterialKind::Uber(m) => m.add_lobes(&at, textures, &mut bsdf),
        }
        bsdf
    }

    /// Adds the textures this material looks up. Every field is named, so that one added to a
    /// material cannot be forgotten here.
    pub fn add_usage(&self, usage: &mut TextureUsage) {
        if let Some(Bump { displacement }) = self.bump {
            usage.float(displacement);
        }
        let (spectra, floats): (&[SpectrumInput], &[FloatInput]) = match &self.kind {
            MaterialKind::Matte(Matte { kd, sigma }) => (&[*kd], &[*sigma]),
            MaterialKind::Mirror(Mirror { kr }) => (&[*kr], &[]),
            MaterialKind::Glass(Glass {
                kr,
                kt,
                eta,
                roughness: [u, v],
                meaning: _,
            }) => (&[*kr, *kt], &[*eta, *u, *v]),
            MaterialKind::Plastic(Plastic {
                kd,
                ks,
                roughness,
                meaning: _,
            }) => (&[*kd, *ks], &[*roughness]),
            MaterialKind::Metal(Metal {
                eta,
                k,
                roughness: [u, v],
                meaning: _,
            }) => (&[*eta, *k], &[*u, *v]),
            MaterialKind::Uber(Uber {
                kd,
                ks,
                kr,
                kt,
                opacity,
                roughness: [u, v],
                meaning: _,
                eta,
                swapped: _,
            }) => (&[*kd, *ks, *kr, *kt, *opacity], &[*u, *v, *eta]),
        };
        spectra.iter().for_each(|&input| usage.spectrum(input));
        floats.iter().for_each(|&input| usage.float(input));
    }

    /// Does the material itself use the footprint, apart from its textures?
    pub fn needs_footprint(&self) -> bool {
        self.bump.is_some()
    }
}

/// Types of pbrt-v3 and pbrt-v2 that are known but not made yet.
const PLANNED: [&str; 10] = [
    "substrate",
    "translucent",
    "mix",
    "disney",
    "subsurface",
    "kdsubsurface",
    "fourier",
    "hair",
    "shinymetal",
    "measured",
];

/// `eta`, else its older name `index` (the only one in pbrt-v2), 1.5 by default. Constants that are
/// no refractive index are warned of, and the default is used.
fn refractive_index(reader: &ParamReader) -> FloatInput {
    let eta = match reader.dialect() {
        Dialect::V2 => None,
        Dialect::V3 => reader.find_float_input("eta").map(|eta| ("eta", eta)),
    };
    let index = || Some(("index", reader.find_float_input("index")?));
    let usual = FloatInput::Constant(1.5);
    match eta.or_else(index) {
        Some((name, FloatInput::Constant(x))) if x <= 0.0 || !x.is_finite() => {
            reader.warn(
                name,
                format!("`{name}` is {x}, no refractive index: 1.5 is used"),
            );
            usual
        }
        Some((_, given)) => given,
        None => usual,
    }
}

/// A reflectance at a point: negative values count as 0.
fn reflectance(input: &SpectrumInput, at: &TexturePoint, textures: &Textures) -> Rgb {
    textures.spectrum(input, at).max(Rgb::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::testing::{direction, flat_hit, sky_by_sampling, sky_by_value};
    use crate::params::testing::read;

    const fn grey(v: f32) -> SpectrumInput {
        SpectrumInput::Constant(Rgb::splat(v))
    }

    const fn float(v: f32) -> FloatInput {
        FloatInput::Constant(v)
    }

    fn matte(kd: f32, sigma: f32) -> MaterialKind {
        MaterialKind::Matte(Matte {
            kd: grey(kd),
            sigma: float(sigma),
        })
    }

    fn plastic(kd: f32, ks: f32, meaning: RoughnessMeaning) -> MaterialKind {
        MaterialKind::Plastic(Plastic {
            kd: grey(kd),
            ks: grey(ks),
            roughness: float(0.1),
            meaning,
        })
    }

    fn uber(kd: f32, ks: f32, kr: f32, kt: f32, opacity: f32) -> MaterialKind {
        MaterialKind::Uber(Uber {
            kd: grey(kd),
            ks: grey(ks),
            kr: grey(kr),
            kt: grey(kt),
            opacity: grey(opacity),
            roughness: [float(0.1); 2],
            meaning: RoughnessMeaning::Remapped,
            eta: float(1.5),
            swapped: false,
        })
    }

    fn glass(roughness: f32) -> MaterialKind {
        MaterialKind::Glass(Glass {
            kr: grey(1.0),
            kt: grey(1.0),
            eta: float(1.5),
            roughness: [float(roughness); 2],
            meaning: RoughnessMeaning::Remapped,
        })
    }

    fn bsdf(kind: MaterialKind, wo: crate::math::Vec3) -> Bsdf {
        Material { kind, bump: None }.bsdf(
            &flat_hit(wo),
            &Footprint::default(),
            &Textures::default(),
        )
    }

    /// Radiance under a white sky at 0°, 60° and 80°, as measured with pbrt-v3 (scene-language 6.5).
    #[test]
    fn materials_reflect_as_much_as_pbrts() {
        let table = [
            ("matte", matte(0.5, 0.0), [0.5, 0.5, 0.5]),
            ("matte Kd 1", matte(1.0, 0.0), [1.0, 1.0, 1.0]),
            (
                "matte Kd 1 sigma 20",
                matte(1.0, 20.0),
                [0.8652, 0.9423, 0.9786],
            ),
            (
                "matte Kd 1 sigma 90",
                matte(1.0, 90.0),
                [0.5590, 0.6884, 0.7492],
            ),
            (
                "plastic",
                plastic(0.25, 0.25, RoughnessMeaning::Remapped),
                [0.2618, 0.3672, 0.4058],
            ),
            (
                "plastic Kd 0 Ks 1",
                plastic(0.0, 1.0, RoughnessMeaning::Remapped),
                [0.0473, 0.4691, 0.6233],
            ),
            (
                "plastic Kd 0 Ks 1 unmapped",
                plastic(0.0, 1.0, RoughnessMeaning::Alpha),
                [0.0425, 0.9402, 0.8751],
            ),
            (
                "uber",
                uber(0.25, 0.25, 0.0, 0.0, 1.0),
                [0.2574, 0.2616, 0.2721],
            ),
            (
                "uber Kd 0 Ks 1",
                uber(0.0, 1.0, 0.0, 0.0, 1.0),
                [0.0297, 0.0465, 0.0884],
            ),
            ("glass", glass(0.0), [0.4667, 0.4940, 0.6598]),
            ("glass roughness 0.1", glass(0.1), [0.4487, 0.4290, 0.4302]),
        ];
        for (name, kind, expected) in table {
            for (degrees, expected) in [0.0, 60.0, 80.0].into_iter().zip(expected) {
                let wo = direction(degrees, 20.0);
                let shown = sky_by_value(&bsdf(kind, wo), wo, 500).x;
                // The table's noise: a standard deviation of at most 0.5 over √260 000 samples is
                // 0.001; three of them for 33 comparisons.
                assert!(
                    (shown - expected).abs() < 0.003,
                    "{name} at {degrees}°: {shown}, pbrt shows {expected}"
                );
            }
        }
    }

    #[test]
    fn opacity_lets_the_rest_straight_through() {
        // With reflectance 1 the surface and its holes share a white sky exactly.
        let wo = direction(35.0, 0.0);
        let half = bsdf(uber(1.0, 0.0, 0.0, 0.0, 0.3), wo);
        assert!((sky_by_value(&half, wo, 200).x - 1.0).abs() < 1e-4);
        assert!((sky_by_sampling(&half, wo, 16).x - 1.0).abs() < 1e-4);
        let through = half.sample_specular(wo, true, 0.5).unwrap();
        assert!((through.wi + wo).length() < 1e-6 && through.eta == 1.0);
    }

    fn metal(roughness: f32) -> MaterialKind {
        MaterialKind::Metal(Metal {
            eta: grey(0.2),
            k: grey(4.0),
            roughness: [FloatInput::Constant(roughness); 2],
            meaning: RoughnessMeaning::Remapped,
        })
    }

    #[test]
    fn materials_keep_energy() {
        for kind in [
            matte(1.0, 45.0),
            uber(0.0, 1.0, 0.0, 0.0, 1.0),
            uber(0.0, 0.0, 1.0, 1.0, 1.0),
            glass(0.3),
            metal(0.2),
        ] {
            for degrees in [0.0, 45.0, 85.0] {
                let wo = direction(degrees, 0.0);
                let shown = sky_by_sampling(&bsdf(kind, wo), wo, 40).x;
                // Standard error of 40³ stratified samples.
                assert!(shown <= 1.005, "{kind:?} at {degrees}° shows {shown}");
            }
        }
    }

    #[test]
    fn black_and_negative_reflectances_leave_no_lobe() {
        let wo = direction(10.0, 0.0);
        assert!(bsdf(matte(-1.0, 0.0), wo).is_black());
        assert!(bsdf(uber(0.0, 0.0, 0.0, 0.0, 1.0), wo).is_black());
        assert!(bsdf(MaterialKind::Mirror(Mirror { kr: grey(0.0) }), wo).is_black());
    }

    #[test]
    fn a_mirror_reflects_its_kr_at_every_angle() {
        for degrees in [0.0, 60.0, 89.0] {
            let wo = direction(degrees, 5.0);
            let shown = sky_by_sampling(
                &bsdf(MaterialKind::Mirror(Mirror { kr: grey(0.9) }), wo),
                wo,
                2,
            )
            .x;
            assert!((shown - 0.9).abs() < 1e-5);
        }
    }

    #[test]
    fn numbers_out_of_range_are_replaced_with_a_warning() {
        for kind in ["glass", "uber"] {
            for (index, used, warnings) in [
                ("0", 1.5, 1),
                ("-1", 1.5, 1),
                ("inf", 1.5, 1),
                ("1", 1.0, 0),
            ] {
                for name in ["eta", "index"] {
                    let params = format!("\"float {name}\" {index}");
                    let outcome = read(kind, &params, refractive_index);
                    assert_eq!((outcome.value, outcome.warnings), (float(used), warnings));
                }
            }
        }
        for (kind, name) in [
            ("plastic", "roughness"),
            ("glass", "uroughness"),
            ("uber", "vroughness"),
        ] {
            let params = format!("\"float {name}\" -1");
            let outcome = read(kind, &params, Material::from_params);
            assert_eq!(outcome.warnings, 1, "{}", outcome.text);
            let least = read(kind, &params.replace("-1", ".001"), Material::from_params);
            assert_eq!((outcome.value, least.warnings), (least.value, 0));
        }
    }
}
