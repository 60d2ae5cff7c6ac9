//! Materials: what a surface's BSDF is at each of its points (scene-language 3.8).
//!
//! Every parameter may be a constant or a texture unless its doc comment says otherwise;
//! reflectances below 0 count as 0.

mod bump;
mod glass;
mod matte;
mod mirror;
mod plastic;
mod roughness;
mod uber;

pub use bump::Bump;
pub use glass::Glass;
pub use matte::Matte;
pub use mirror::Mirror;
pub use plastic::Plastic;
pub use roughness::RoughnessMeaning;
pub use uber::Uber;

use crate::bsdf::Bsdf;
use crate::math::Rgb;
use crate::params::{ParamReader, SpectrumInput};
use crate::surface::{Footprint, SurfaceHit, TexturePoint};
use crate::textures::Textures;

/// A material: kinds of scattering, and bumps that tilt the shading normal.
/// Common parameter: float texture `bumpmap` (none), displacement in scene units.
#[derive(Clone, Copy, Debug)]
pub struct Material {
    /// How light is scattered.
    pub kind: MaterialKind,
    /// `bumpmap`.
    pub bump: Option<Bump>,
}

/// The kinds of materials.
#[derive(Clone, Copy, Debug)]
pub enum MaterialKind {
    /// `matte`
    Matte(Matte),
    /// `mirror`
    Mirror(Mirror),
    /// `glass`
    Glass(Glass),
    /// `plastic`
    Plastic(Plastic),
    /// `uber`
    Uber(Uber),
}

/// Does this type string mean a boundary that does not scatter at all?
pub fn is_none(kind: &str) -> bool {
    matches!(kind, "" | "none")
}

impl Material {
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
            "uber" => MaterialKind::Uber(Uber::from_params(reader)),
            kind => {
                let why = if PLANNED.contains(&kind) {
                    "is not supported yet"
                } else {
                    "does not exist"
                };
                reader.warn(
                    "",
                    format!("material '{kind}' {why}: a matte of the same parameters is used"),
                );
                MaterialKind::Matte(Matte::from_params(reader))
            }
        };
        Some(Material {
            kind,
            bump: Bump::from_params(reader),
        })
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
            MaterialKind::Uber(m) => m.add_lobes(&at, textures, &mut bsdf),
        }
        bsdf
    }

    /// Does the material itself use the footprint, apart from its textures?
    pub fn needs_footprint(&self) -> bool {
        self.bump.is_some()
    }
}

/// Types of pbrt-v3 and pbrt-v2 that are known but not made yet.
const PLANNED: [&str; 11] = [
    "metal",
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

/// A reflectance at a point: negative values count as 0.
fn reflectance(input: &SpectrumInput, at: &TexturePoint, textures: &Textures) -> Rgb {
    textures.spectrum(input, at).max(Rgb::ZERO)
}
