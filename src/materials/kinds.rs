//! The types of materials: a single table for names, reading and dispatch.

use super::prepare::Tables;
use super::*;
use crate::params::NamedFile;

macro_rules! material_types {
    (
        all { $($name:literal => $Type:ident,)* }
        v2 { $($v2_name:literal => $V2Type:ident,)* }
        of_materials { $($mix_name:literal => $Mix:ident,)* }
    ) => {
        /// The types of materials.
        #[derive(Clone, Debug, PartialEq)]
        pub enum MaterialKind {
            $(#[doc = concat!("`", $name, "`")] $Type($Type),)*
            $(#[doc = concat!("`", $v2_name, "`, of pbrt-v2")] $V2Type($V2Type),)*
            $(#[doc = concat!("`", $mix_name, "`")] $Mix($Mix),)*
        }

        impl Material {
            /// The types of pbrt-v3's language.
            pub const KINDS: &'static [&'static str] = &[$($name,)* $($mix_name,)*];

            /// Returns `true` if the type is modeled. Some exist in pbrt-v2 only.
            pub fn is_modeled(kind: &str, dialect: Dialect) -> bool {
                Material::KINDS.contains(&kind)
                    || (dialect == Dialect::V2 && [$($v2_name,)*].contains(&kind))
            }
        }

        impl MaterialKind {
            /// Creates a material that needs only parameters, and its bump map; `None` for other types.
            pub(super) fn from_params(reader: &ParamReader) -> Option<(MaterialKind, Option<Bump>)> {
                let bump = |has_one: bool| has_one.then(|| Bump::from_params(reader)).flatten();
                match reader.kind() {
                    $($name => {
                        let kind = MaterialKind::$Type($Type::from_params(reader));
                        Some((kind, bump(<$Type as Scattering>::BUMPS)))
                    })*
                    $($v2_name if reader.dialect() == Dialect::V2 => {
                        let kind = MaterialKind::$V2Type($V2Type::from_params(reader));
                        Some((kind, bump(<$V2Type as Scattering>::BUMPS)))
                    })*
                    _ => None,
                }
            }

            /// The name of the type in scene files.
            pub fn name(&self) -> &'static str {
                match self {
                    $(MaterialKind::$Type(_) => $name,)*
                    $(MaterialKind::$V2Type(_) => $v2_name,)*
                    $(MaterialKind::$Mix(_) => $mix_name,)*
                }
            }

            /// Adds the lobes at a point; `materials` are those of the scene, for the handles of mixes.
            pub(super) fn add_lobes<'a>(
                &'a self,
                at: &TexturePoint,
                textures: &Textures,
                materials: &'a [Material],
                bsdf: &mut Bsdf<'a>,
            ) {
                match self {
                    $(MaterialKind::$Type(m) => m.add_lobes(at, textures, bsdf),)*
                    $(MaterialKind::$V2Type(m) => m.add_lobes(at, textures, bsdf),)*
                    $(MaterialKind::$Mix(m) => m.add_lobes(at, textures, materials, bsdf),)*
                }
            }

            /// Maximum number of lobes that the material can have at a point, at least 1.
            pub(super) fn max_lobes(&self) -> usize {
                match self {
                    $(MaterialKind::$Type(m) => m.max_lobes(),)*
                    $(MaterialKind::$V2Type(m) => m.max_lobes(),)*
                    $(MaterialKind::$Mix(m) => m.max_lobes,)*
                }
            }

            /// Returns `true` if it may scatter light in a single direction somewhere; `materials` as above.
            pub(super) fn is_smooth(&self, materials: &[Material]) -> bool {
                match self {
                    $(MaterialKind::$Type(m) => m.is_smooth(),)*
                    $(MaterialKind::$V2Type(m) => m.is_smooth(),)*
                    $(MaterialKind::$Mix(m) => m.is_smooth(materials),)*
                }
            }

            /// Returns `true` if it may scatter light into several directions. Mixes, rarely of mirrors alone, count as such.
            pub(super) fn scatters_widely(&self) -> bool {
                match self {
                    $(MaterialKind::$Type(m) => m.scatters_widely(),)*
                    $(MaterialKind::$V2Type(m) => m.scatters_widely(),)*
                    $(MaterialKind::$Mix(_) => true,)*
                }
            }

            /// Returns `true` if there is a medium inside that transmitted light may scatter in.
            pub(super) fn has_interior(&self) -> bool {
                match self {
                    $(MaterialKind::$Type(m) => m.has_interior(),)*
                    $(MaterialKind::$V2Type(m) => m.has_interior(),)*
                    $(MaterialKind::$Mix(m) => m.has_interior,)*
                }
            }

            /// Subsurface scattering of light that `bsdf` transmits. [`Material::subsurface_transport`] handles mixes.
            pub(super) fn bssrdf(
                &self,
                hit: &SurfaceHit,
                bsdf: &Bsdf,
                at: &TexturePoint,
                textures: &Textures,
            ) -> Option<Bssrdf<'_>> {
                match self {
                    $(MaterialKind::$Type(m) => m.bssrdf(hit, bsdf, at, textures),)*
                    $(MaterialKind::$V2Type(m) => m.bssrdf(hit, bsdf, at, textures),)*
                    $(MaterialKind::$Mix(_) => None,)*
                }
            }

            /// The file that holds its table.
            pub(super) fn file(&self) -> Option<&NamedFile> {
                match self {
                    $(MaterialKind::$Type(m) => m.file(),)*
                    $(MaterialKind::$V2Type(m) => m.file(),)*
                    $(MaterialKind::$Mix(_) => None,)*
                }
            }

            /// Gets its tables.
            pub(super) fn prepare(&mut self, tables: &mut Tables) {
                match self {
                    $(MaterialKind::$Type(m) => m.prepare(tables),)*
                    $(MaterialKind::$V2Type(m) => m.prepare(tables),)*
                    $(MaterialKind::$Mix(_) => {})*
                }
            }
        }
    };
}

// To add a type: write its file, which implements `from_params` and `Scattering`, and add a line here.
material_types! {
    all {
        "matte" => Matte,
        "mirror" => Mirror,
        "glass" => Glass,
        "plastic" => Plastic,
        "metal" => Metal,
        "uber" => Uber,
        "substrate" => Substrate,
        "translucent" => Translucent,
        "disney" => Disney,
        "hair" => Hair,
        "subsurface" => Subsurface,
        "kdsubsurface" => KdSubsurface,
        "fourier" => Fourier,
    }
    v2 {
        "shinymetal" => ShinyMetal,
        "measured" => Measured,
    }
    of_materials {
        "mix" => Mix,
    }
}
