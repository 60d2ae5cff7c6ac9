//! Materials: what a surface's BSDF is at each of its points (scene-language 3.8).
//!
//! Every parameter may be a constant or a texture unless its doc comment says otherwise;
//! reflectances below 0 count as 0.

mod bump;
mod disney;
mod fourier;
mod glass;
mod hair;
mod inputs;
mod interior;
mod kdsubsurface;
mod matte;
mod metal;
mod mirror;
mod mix;
mod plastic;
mod prepare;
mod roughness;
mod shinymetal;
mod substrate;
mod subsurface;
mod translucent;
mod uber;
#[cfg(test)]
mod wild;

pub use bump::Bump;
pub use disney::Disney;
pub use fourier::Fourier;
pub use glass::Glass;
pub use hair::{Hair, Pigment};
pub use interior::Interior;
pub use kdsubsurface::{KdSubsurface, MeanFreePath};
pub use matte::Matte;
pub use metal::Metal;
pub use mirror::Mirror;
pub use mix::{Mix, Named, NamedMaterials};
pub use plastic::Plastic;
pub use prepare::{BsdfFiles, prepare};
pub use roughness::RoughnessMeaning;
pub use shinymetal::ShinyMetal;
pub use substrate::Substrate;
pub use subsurface::Subsurface;
pub use translucent::Translucent;
pub use uber::Uber;

use crate::bsdf::Bsdf;
use crate::bssrdf::Bssrdf;
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::math::float::within;
use crate::params::{Dialect, FloatInput, ParamReader, SpectrumInput};
use crate::surface::{Footprint, SurfaceHit, TexturePoint};
use crate::textures::{TextureUsage, Textures};

/// A material: kinds of scattering, and bumps that tilt the shading normal.
/// Common parameter: float texture `bumpmap` (none), displacement in scene units.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// How light is scattered.
    pub kind: MaterialKind,
    /// `bumpmap`.
    pub bump: Option<Bump>,
}

/// The kinds of materials.
#[derive(Clone, Debug, PartialEq)]
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
    /// `substrate`
    Substrate(Substrate),
    /// `translucent`
    Translucent(Translucent),
    /// `mix`
    Mix(Mix),
    /// `disney`
    Disney(Disney),
    /// `hair`
    Hair(Hair),
    /// `shinymetal`, of pbrt-v2
    ShinyMetal(ShinyMetal),
    /// `subsurface`
    Subsurface(Subsurface),
    /// `kdsubsurface`
    KdSubsurface(KdSubsurface),
    /// `fourier`
    Fourier(Fourier),
}

/// Does this type string mean a boundary that does not scatter at all?
pub fn is_none(kind: &str) -> bool {
    matches!(kind, "" | "none")
}

impl Material {
    /// The types that are modelled.
    pub const KINDS: [&'static str; 14] = [
        "matte",
        "mirror",
        "glass",
        "plastic",
        "metal",
        "uber",
        "substrate",
        "translucent",
        "mix",
        "disney",
        "hair",
        "subsurface",
        "kdsubsurface",
        "fourier",
    ];

    /// Is this a type that is modelled? Some exist in pbrt-v2 only.
    pub fn is_modelled(kind: &str, dialect: Dialect) -> bool {
        Material::KINDS.contains(&kind) || (dialect == Dialect::V2 && kind == "shinymetal")
    }

    /// The material that `Material "type"` describes, or `MakeNamedMaterial` with that
    /// `"string type"` as the reader's kind; `None` for [no material](is_none). Types that are
    /// unknown, or not supported yet, give a warning and `matte` from the same parameters. `named`
    /// are those that a mix can name.
    pub fn from_params(reader: &ParamReader, named: &dyn NamedMaterials) -> Option<Material> {
        let kind = match reader.kind() {
            kind if is_none(kind) => return None,
            "matte" => MaterialKind::Matte(Matte::from_params(reader)),
            "mirror" => MaterialKind::Mirror(Mirror::from_params(reader)),
            "glass" => MaterialKind::Glass(Glass::from_params(reader)),
            "plastic" => MaterialKind::Plastic(Plastic::from_params(reader)),
            "metal" => MaterialKind::Metal(Metal::from_params(reader)),
            "uber" => MaterialKind::Uber(Uber::from_params(reader)),
            "substrate" => MaterialKind::Substrate(Substrate::from_params(reader)),
            "translucent" => MaterialKind::Translucent(Translucent::from_params(reader)),
            "mix" => match Mix::from_params(reader, named) {
                Some((mix, bump)) => {
                    let kind = MaterialKind::Mix(mix);
                    return Some(Material { kind, bump });
                }
                None => MaterialKind::Matte(Matte::from_params(reader)),
            },
            "disney" => MaterialKind::Disney(Disney::from_params(reader)),
            "hair" => {
                // Without bumps, as in pbrt.
                let kind = MaterialKind::Hair(Hair::from_params(reader));
                return Some(Material { kind, bump: None });
            }
            "shinymetal" if reader.dialect() == Dialect::V2 => {
                MaterialKind::ShinyMetal(ShinyMetal::from_params(reader))
            }
            "subsurface" => MaterialKind::Subsurface(Subsurface::from_params(reader)),
            "kdsubsurface" => MaterialKind::KdSubsurface(KdSubsurface::from_params(reader)),
            "fourier" => MaterialKind::Fourier(Fourier::from_params(reader)),
            kind => {
                const DONE: &str = "a matte of the same parameters is used";
                const TABLES: &str = "tables of measured reflectance are not read, \
                    and a matte of the same parameters is used";
                match kind {
                    "measured" => reader.unsupported_kind(TABLES),
                    _ => reader.unknown_kind_replaced(&Material::KINDS, DONE),
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

    /// The BSDF at a point; `materials` are the scene's, for the handles of mixes.
    pub fn bsdf<'a>(
        &'a self,
        hit: &SurfaceHit,
        footprint: &Footprint,
        textures: &Textures,
        materials: &'a [Material],
    ) -> Bsdf<'a> {
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
        self.add_lobes(&at, textures, materials, &mut bsdf);
        bsdf
    }

    fn add_lobes<'a>(
        &'a self,
        at: &TexturePoint,
        textures: &Textures,
        materials: &'a [Material],
        bsdf: &mut Bsdf<'a>,
    ) {
        match &self.kind {
            MaterialKind::Matte(m) => m.add_lobes(at, textures, bsdf),
            MaterialKind::Mirror(m) => m.add_lobes(at, textures, bsdf),
            MaterialKind::Glass(m) => m.add_lobes(at, textures, bsdf),
            MaterialKind::Plastic(m) => m.add_lobes(at, textures, bsdf),
            MaterialKind::Metal(m) => m.add_lobes(at, textures, bsdf),
            MaterialKind::Uber(m) => m.add_lobes(at, textures, bsdf),
            MaterialKind::Substrate(m) => m.add_lobes(at, textures, bsdf),
            MaterialKind::Translucent(m) => m.add_lobes(at, textures, bsdf),
            MaterialKind::Mix(m) => m.add_lobes(at, textures, materials, bsdf),
            MaterialKind::Disney(m) => m.add_lobes(at, textures, bsdf),
            MaterialKind::Hair(m) => m.add_lobes(at, textures, bsdf),
            MaterialKind::ShinyMetal(m) => m.add_lobes(at, textures, bsdf),
            MaterialKind::Subsurface(m) => m.interior.boundary.add_lobes(at, textures, bsdf),
            MaterialKind::KdSubsurface(m) => m.interior.boundary.add_lobes(at, textures, bsdf),
            MaterialKind::Fourier(m) => m.add_lobes(bsdf),
        }
    }

    /// Most lobes that the material can have at a point, at least 1.
    fn most_lobes(&self) -> usize {
        match &self.kind {
            MaterialKind::Matte(_)
            | MaterialKind::Mirror(_)
            | MaterialKind::Metal(_)
            | MaterialKind::Substrate(_)
            | MaterialKind::Hair(_)
            | MaterialKind::Fourier(_) => 1,
            MaterialKind::Glass(_) | MaterialKind::Plastic(_) | MaterialKind::ShinyMetal(_) => 2,
            MaterialKind::Uber(m) => m.most_lobes(),
            MaterialKind::Translucent(m) => m.most_lobes(),
            MaterialKind::Mix(m) => m.most_lobes,
            MaterialKind::Disney(_) => disney::MOST_LOBES,
            MaterialKind::Subsurface(_) | MaterialKind::KdSubsurface(_) => 2,
        }
    }

    /// How light that its `bsdf` transmits at a point wanders below the surface; `None` where it
    /// goes straight on.
    pub fn bssrdf(
        &self,
        hit: &SurfaceHit,
        bsdf: &Bsdf,
        footprint: &Footprint,
        textures: &Textures,
    ) -> Option<Bssrdf<'_>> {
        let at = TexturePoint {
            p: hit.p,
            uv: hit.uv,
            footprint: *footprint,
        };
        let (interior, medium) = match &self.kind {
            MaterialKind::Disney(m) => return m.bssrdf(hit, bsdf, &at, textures),
            MaterialKind::Subsurface(m) => (&m.interior, m.medium(&at, textures)),
            MaterialKind::KdSubsurface(m) => (&m.interior, m.medium(&at, textures)?),
            _ => return None,
        };
        interior.bssrdf(&medium, hit, bsdf)
    }

    /// Adds the textures this material looks up, those of the `materials` it mixes included. Every
    /// field is named, so that one added to a material cannot be forgotten here.
    pub fn add_usage(&self, materials: &[Material], usage: &mut TextureUsage) {
        if let Some(Bump { displacement }) = self.bump {
            usage.float(displacement);
        }
        let (spectra, floats): (&[SpectrumInput], &[FloatInput]) = match &self.kind {
            MaterialKind::Matte(Matte { kd, sigma }) => (&[*kd], &[*sigma]),
            MaterialKind::Mirror(Mirror { kr }) => (&[*kr], &[]),
            MaterialKind::Glass(glass) => {
                glass.add_usage(usage);
                (&[], &[])
            }
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
            MaterialKind::Substrate(Substrate {
                kd,
                ks,
                roughness: [u, v],
                meaning: _,
            }) => (&[*kd, *ks], &[*u, *v]),
            MaterialKind::Translucent(Translucent {
                kd,
                ks,
                reflect,
                transmit,
                roughness,
                meaning: _,
                mirrored: _,
            }) => (&[*kd, *ks, *reflect, *transmit], &[*roughness]),
            MaterialKind::Mix(Mix {
                parts,
                amount,
                most_lobes: _,
            }) => {
                for part in parts.iter().flatten() {
                    if let Some(material) = materials.get(part.index()) {
                        material.add_usage(materials, usage);
                    }
                }
                (&[*amount], &[])
            }
            MaterialKind::Disney(Disney {
                color,
                metallic,
                eta,
                roughness,
                specular_tint,
                anisotropic,
                sheen,
                sheen_tint,
                clearcoat,
                clearcoat_gloss,
                spec_trans,
                thin: _,
                flatness,
                diff_trans,
                scatter_distance,
            }) => (
                &[*color, *scatter_distance],
                &[
                    *metallic,
                    *eta,
                    *roughness,
                    *specular_tint,
                    *anisotropic,
                    *sheen,
                    *sheen_tint,
                    *clearcoat,
                    *clearcoat_gloss,
                    *spec_trans,
                    *flatness,
                    *diff_trans,
                ],
            ),
            MaterialKind::Hair(Hair {
                pigment,
                eta,
                beta: [m, n],
                alpha,
            }) => {
                pigment.add_usage(usage);
                (&[], &[*eta, *m, *n, *alpha])
            }
            MaterialKind::ShinyMetal(ShinyMetal {
                ks,
                kr,
                roughness,
                meaning: _,
            }) => (&[*ks, *kr], &[*roughness]),
            MaterialKind::Subsurface(Subsurface {
                sigma_a,
                sigma_s,
                interior,
            }) => {
                interior.boundary.add_usage(usage);
                (&[*sigma_a, *sigma_s], &[])
            }
            MaterialKind::KdSubsurface(KdSubsurface {
                kd,
                mean_free_path,
                interior,
            }) => {
                interior.boundary.add_usage(usage);
                match mean_free_path {
                    MeanFreePath::Spectrum(mfp) => (&[*kd, *mfp], &[]),
                    MeanFreePath::Float(mfp) => (&[*kd], &[*mfp]),
                }
            }
            MaterialKind::Fourier(_) => (&[], &[]),
        };
        spectra.iter().for_each(|&input| usage.spectrum(input));
        floats.iter().for_each(|&input| usage.float(input));
    }

    /// Is there a medium inside that light wanders through?
    pub fn has_interior(&self) -> bool {
        match &self.kind {
            MaterialKind::Subsurface(_) | MaterialKind::KdSubsurface(_) => true,
            MaterialKind::Disney(m) => m.has_interior(),
            _ => false,
        }
    }

    /// Does the material itself use the footprint, apart from its textures?
    pub fn needs_footprint(&self) -> bool {
        self.bump.is_some()
    }
}

/// Can the factor be other than black anywhere?
fn may_scatter(input: &SpectrumInput) -> bool {
    match input {
        SpectrumInput::Constant(factor) => !is_black(factor.max(Rgb::ZERO)),
        SpectrumInput::Texture(_) => true,
    }
}

/// Largest reflectance that is told apart: sums and products of what is far beyond all use stay
/// finite.
const MAX_REFLECTANCE: f32 = 1e6;

/// A reflectance at a point: negative values, and those that are no numbers, count as 0.
fn reflectance(input: &SpectrumInput, at: &TexturePoint, textures: &Textures) -> Rgb {
    let given = textures.spectrum(input, at);
    given.map(|x| within(x, 0.0, MAX_REFLECTANCE))
}

#[cfg(test)]
mod tests {
    use super::inputs::refractive_index;
    use super::*;
    use crate::bsdf::testing::{direction, flat_hit, sky_by_sampling, sky_by_value};
    use crate::params::testing::read;

    /// No named materials.
    struct NoneNamed;

    impl NamedMaterials for NoneNamed {
        fn find(&self, _: &str) -> Option<Option<Named>> {
            None
        }

        fn names(&self) -> Vec<&str> {
            Vec::new()
        }

        fn defining(&self) -> Option<&str> {
            None
        }
    }

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

    fn substrate(kd: f32, ks: f32, roughness: f32) -> MaterialKind {
        MaterialKind::Substrate(Substrate {
            kd: grey(kd),
            ks: grey(ks),
            roughness: [float(roughness); 2],
            meaning: RoughnessMeaning::Remapped,
        })
    }

    fn translucent(kd: f32, ks: f32) -> MaterialKind {
        MaterialKind::Translucent(Translucent {
            kd: grey(kd),
            ks: grey(ks),
            reflect: grey(0.5),
            transmit: grey(0.5),
            roughness: float(0.1),
            meaning: RoughnessMeaning::Remapped,
            mirrored: false,
        })
    }

    /// With its defaults.
    fn disney() -> MaterialKind {
        MaterialKind::Disney(read("disney", "", Disney::from_params).value)
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

    // The few materials of these tests are never freed, so that their BSDFs stand alone.
    fn bsdf(kind: MaterialKind, wo: crate::math::Vec3) -> Bsdf<'static> {
        let material = Box::leak(Box::new(Material { kind, bump: None }));
        material.bsdf(
            &flat_hit(wo),
            &Footprint::default(),
            &Textures::default(),
            &[],
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
            (
                "substrate",
                substrate(0.5, 0.5, 0.1),
                [0.5360, 0.5069, 0.4492],
            ),
            (
                "translucent",
                translucent(0.25, 0.25),
                [0.3061, 0.3032, 0.3040],
            ),
            ("disney", disney(), [0.5400, 0.5708, 0.6496]),
            ("glass", glass(0.0), [0.4667, 0.4940, 0.6598]),
            ("glass roughness 0.1", glass(0.1), [0.4487, 0.4290, 0.4302]),
        ];
        for (name, kind, expected) in table {
            for (degrees, expected) in [0.0, 60.0, 80.0].into_iter().zip(expected) {
                let wo = direction(degrees, 20.0);
                let shown = sky_by_value(&bsdf(kind.clone(), wo), wo, 500).x;
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
                let shown = sky_by_sampling(&bsdf(kind.clone(), wo), wo, 40).x;
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
            let outcome = read(kind, &params, |r| Material::from_params(r, &NoneNamed));
            assert_eq!(outcome.warnings, 1, "{}", outcome.text);
            let least = read(kind, &params.replace("-1", ".001"), |r| {
                Material::from_params(r, &NoneNamed)
            });
            assert_eq!((outcome.value, least.warnings), (least.value, 0));
        }
    }
}
