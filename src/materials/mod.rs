//! Materials: what a surface's BSDF is at each of its points (docs/scene-language.md §3.8).
//!
//! Every parameter may be a constant or a texture unless its doc comment says otherwise;
//! reflectances below 0 count as 0.

pub mod beneath;
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
use crate::math::color::is_black;
use crate::math::float::within;
use crate::math::{Rgb, Vec3};
use crate::params::{Dialect, FloatInput, ParamReader, SpectrumInput};
use crate::surface::{Footprint, ShadingGeometry, SurfaceHit, TexturePoint};
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

    /// Fills the [empty](Bsdf::nowhere) `bsdf` for a point; `materials` are the scene's, for the handles of
    /// mixes.
    pub fn fill_bsdf<'a>(
        &'a self,
        hit: &SurfaceHit,
        footprint: &Footprint,
        textures: &Textures,
        materials: &'a [Material],
        bsdf: &mut Bsdf<'a>,
    ) {
        let at = hit.texture_point(footprint);
        match &self.bump {
            Some(bump) => bsdf.place(hit.n, &bump.shading_geometry(hit, &at, textures)),
            None => bsdf.place(hit.n, &hit.shading),
        }
        self.add_lobes(&at, textures, materials, bsdf);
    }

    /// [`Material::fill_bsdf`] as an answer.
    #[cfg(test)]
    pub(crate) fn bsdf<'a>(
        &'a self,
        hit: &SurfaceHit,
        footprint: &Footprint,
        textures: &Textures,
        materials: &'a [Material],
    ) -> Bsdf<'a> {
        let mut bsdf = Bsdf::nowhere();
        self.fill_bsdf(hit, footprint, textures, materials, &mut bsdf);
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

    /// How many lobes the material adds at a point.
    fn lobe_count(&self, at: &TexturePoint, textures: &Textures, materials: &[Material]) -> usize {
        // Lobes do not depend on the frame that they stand in.
        let mut bsdf = Bsdf::new(
            Vec3::Z,
            &ShadingGeometry {
                n: Vec3::Z,
                dpdu: Vec3::X,
                dpdv: Vec3::Y,
                dndu: Vec3::ZERO,
                dndv: Vec3::ZERO,
            },
        );
        self.add_lobes(at, textures, materials, &mut bsdf);
        bsdf.lobe_count()
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
    /// goes straight on. Of mixes [`Material::beneath`] knows.
    fn bssrdf(
        &self,
        hit: &SurfaceHit,
        bsdf: &Bsdf,
        footprint: &Footprint,
        textures: &Textures,
    ) -> Option<Bssrdf<'_>> {
        let at = hit.texture_point(footprint);
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
                has_interior: _,
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
            MaterialKind::Mix(m) => m.has_interior,
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
mod tests;
