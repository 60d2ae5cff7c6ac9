//! Materials: the BSDF of a surface at each of its points (docs/scene-language.md §3.8).
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
mod kinds;
mod lobes;
mod matte;
mod measured;
mod metal;
mod mirror;
mod mix;
mod place;
mod plastic;
mod prepare;
#[cfg(test)]
mod robustness;
mod roughness;
mod scattering;
mod shinymetal;
mod substrate;
mod subsurface;
pub mod subsurface_transport;
mod translucent;
mod uber;

pub use bump::Bump;
pub use disney::Disney;
pub use fourier::Fourier;
pub use glass::Glass;
pub use hair::Hair;
pub use kdsubsurface::KdSubsurface;
pub use kinds::MaterialKind;
pub use matte::Matte;
pub use measured::Measured;
pub use metal::Metal;
pub use mirror::Mirror;
pub use mix::{Mix, Named, NamedMaterials};
use place::Place;
pub use plastic::Plastic;
pub use prepare::{BsdfFiles, prepare};
use scattering::Scattering;
pub use shinymetal::ShinyMetal;
pub use substrate::Substrate;
pub use subsurface::Subsurface;
pub use translucent::Translucent;
pub use uber::Uber;

use crate::bsdf::{Boundary, Bsdf, CoatedLobes};
use crate::handles::MaterialId;
use crate::inputs::{SpectrumInput, TexturesRead};
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::params::{Dialect, ParamReader};
use crate::surface::{Footprint, SurfaceHit};
use crate::textures::{TextureUsage, Textures};

/// A material: a kind of scattering, and a bump map that tilts the shading normal. Common parameter: float texture
/// `bumpmap` (none), displacement in scene units.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The kind of scattering.
    pub kind: MaterialKind,
    /// The bump map, `bumpmap`.
    pub bump: Option<Bump>,
    /// The textures that its parameters name.
    pub(crate) textures: TexturesRead,
}

/// Returns `true` if this type string means a boundary that does not scatter at all.
pub fn is_none(kind: &str) -> bool {
    matches!(kind, "" | "none")
}

impl Material {
    /// Returns `true` if the material may reflect or transmit light in a single direction somewhere (caustics), besides any
    /// other scattering; `materials` are those of the scene, for the handles of mixes. Subsurface scattering does not count:
    /// light that enters exits scattered.
    pub fn is_smooth(&self, materials: &[Material]) -> bool {
        self.kind.scattering().is_smooth(materials)
    }

    /// Returns `true` if light that it scatters may gather in a caustic: not where all scattering is diffuse.
    pub fn may_focus(&self) -> bool {
        !matches!(self.kind, MaterialKind::Matte(_) | MaterialKind::Hair(_))
    }

    /// Returns `true` if light from a single direction may be scattered into others.
    pub fn scatters_widely(&self) -> bool {
        self.kind.scattering().scatters_widely()
    }

    /// The material described by `Material "type"`, or by `MakeNamedMaterial` with that `"string type"` as the reader's
    /// kind; `None` for [no material](is_none). Unknown and unsupported types give a warning and `matte` from the same
    /// parameters. `named` are the materials that a mix can name.
    pub fn from_params(reader: &ParamReader, named: &dyn NamedMaterials) -> Option<Material> {
        if is_none(reader.kind()) {
            return None;
        }
        let first_texture = reader.textures_read();
        let (kind, bump) = match reader.kind() {
            "mix" => Mix::from_params(reader, named)
                .map(|(mix, bump)| (MaterialKind::Mix(mix), bump))
                .unwrap_or_else(|| Material::stand_in(reader)),
            _ => MaterialKind::from_params(reader).unwrap_or_else(|| {
                Material::report_kind(reader);
                Material::stand_in(reader)
            }),
        };
        Some(Material {
            kind,
            bump,
            textures: reader.textures_since(first_texture),
        })
    }

    /// The replacement for a material that cannot be made.
    fn stand_in(reader: &ParamReader) -> (MaterialKind, Option<Bump>) {
        let matte = MaterialKind::Matte(Matte::from_params(reader));
        (matte, Bump::from_params(reader))
    }

    /// Warns about unknown and unsupported types.
    fn report_kind(reader: &ParamReader) {
        const DONE: &str = "a matte of the same parameters is used";
        const TABLES: &str = "tables of measured reflectance are not read, and a matte of the same parameters is used";
        match reader.kind() {
            "measured" => reader.unsupported_kind(TABLES),
            _ => reader.unknown_kind_replaced(Material::KINDS, DONE),
        }
    }

    /// The name of the type in scene files.
    pub fn name(&self) -> &'static str {
        self.kind.name()
    }

    /// Fills the [empty](Bsdf::empty) `bsdf` for a point; `materials` are the scene's, for the handles of
    /// mixes.
    pub fn fill_bsdf<'a>(
        &'a self,
        hit: &SurfaceHit,
        footprint: &Footprint,
        textures: &Textures,
        materials: &'a [Material],
        bsdf: &mut Bsdf<'a>,
    ) {
        let at = Place {
            point: hit.texture_point(footprint),
            textures,
            materials,
        };
        match &self.bump {
            Some(bump) => bsdf.set_frame(hit.n, &bump.shading_geometry(hit, &at.point, textures)),
            None => bsdf.set_frame(hit.n, &hit.shading),
        }
        self.kind.add_lobes(&at, bsdf);
    }

    /// Its reflectance, if it is ideally diffuse, reflects alone, and is the same everywhere.
    pub fn even_reflectance(&self) -> Option<Rgb> {
        let even = self.kind.scattering().even_reflectance();
        even.filter(|_| self.bump.is_none())
    }

    /// Its lobes, if they are those of a [coated](CoatedLobes) surface, and the same everywhere.
    pub(crate) fn even_coat(&self) -> Option<CoatedLobes> {
        let even = self.kind.scattering().even_coat();
        even.filter(|_| self.bump.is_none())
    }

    /// Its lobe, if it is a perfectly specular [boundary](Boundary), and the same everywhere.
    pub(crate) fn even_boundary(&self) -> Option<Boundary> {
        let even = self.kind.scattering().even_boundary();
        even.filter(|_| self.bump.is_none() && !self.has_interior())
    }

    /// Of constants alone, without bumps.
    #[cfg(any(test, feature = "internals"))]
    pub fn without_textures(kind: MaterialKind) -> Material {
        Material {
            kind,
            bump: None,
            textures: Vec::new(),
        }
    }

    /// Like [`Material::fill_bsdf`], returning the BSDF.
    #[cfg(test)]
    pub(crate) fn bsdf<'a>(
        &'a self,
        hit: &SurfaceHit,
        footprint: &Footprint,
        textures: &Textures,
        materials: &'a [Material],
    ) -> Bsdf<'a> {
        let mut bsdf = Bsdf::empty();
        self.fill_bsdf(hit, footprint, textures, materials, &mut bsdf);
        bsdf
    }

    /// The number of lobes that the material adds at a point.
    fn lobe_count(&self, at: &Place) -> usize {
        // Lobes do not depend on their frame.
        let mut bsdf = Bsdf::empty();
        self.kind.add_lobes(at, &mut bsdf);
        bsdf.lobe_count()
    }

    /// Adds the textures that this material looks up, including those of the `materials` it mixes.
    pub fn add_usage(&self, materials: &[Material], usage: &mut TextureUsage) {
        usage.add(self.textures.iter().copied());
        if let MaterialKind::Mix(mix) = &self.kind {
            let parts = mix.parts.iter().flatten();
            parts
                .filter_map(|part| materials.get(part.index()))
                .for_each(|material| material.add_usage(materials, usage));
        }
    }

    /// Returns `true` if there is a medium inside that transmitted light may scatter in.
    pub fn has_interior(&self) -> bool {
        self.kind.scattering().has_interior()
    }

    /// Returns `true` if the material, or one of those it mixes, depends on the parameters of surfaces or on the
    /// derivatives by them: by textures, bumps, or lobes that are not the same all around the normal.
    pub fn needs_parameters(&self, materials: &[Material]) -> bool {
        let of_part = |part: &MaterialId| match materials.get(part.index()) {
            // The parts of a mix come before it.
            Some(part) => part.needs_parameters(materials),
            None => false,
        };
        !self.textures.is_empty()
            || self.bump.is_some()
            || match &self.kind {
                MaterialKind::Mix(mix) => mix.parts.iter().flatten().any(of_part),
                kind => !kind.scattering().is_isotropic(),
            }
    }

    /// Returns `true` if the material itself uses the footprint, apart from its textures.
    pub fn needs_footprint(&self) -> bool {
        self.bump.is_some()
    }
}

/// Returns `true` if the factor can be nonzero anywhere.
fn may_scatter(input: &SpectrumInput) -> bool {
    match input {
        SpectrumInput::Constant(factor) => !is_black(factor.max(Rgb::ZERO)),
        SpectrumInput::Texture(_) => true,
    }
}

#[cfg(test)]
mod tests;
