//! The types of materials: a single table for names, reading and dispatch.

use super::prepare::Tables;
use super::*;
use crate::bssrdf::Bssrdf;

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
                let kind = match reader.kind() {
                    $($name => MaterialKind::$Type($Type::from_params(reader)),)*
                    $($v2_name if reader.dialect() == Dialect::V2 => {
                        MaterialKind::$V2Type($V2Type::from_params(reader))
                    })*
                    _ => return None,
                };
                let bumps = kind.scattering().bumps();
                let bump = bumps.then(|| Bump::from_params(reader)).flatten();
                Some((kind, bump))
            }

            /// The name of the type in scene files.
            pub fn name(&self) -> &'static str {
                match self {
                    $(MaterialKind::$Type(_) => $name,)*
                    $(MaterialKind::$V2Type(_) => $v2_name,)*
                    $(MaterialKind::$Mix(_) => $mix_name,)*
                }
            }

            /// Adds the lobes at a point.
            pub(super) fn add_lobes<'a>(&'a self, at: &Place<'_, 'a>, bsdf: &mut Bsdf<'a>) {
                match self {
                    $(MaterialKind::$Type(m) => m.add_lobes(at, bsdf),)*
                    $(MaterialKind::$V2Type(m) => m.add_lobes(at, bsdf),)*
                    $(MaterialKind::$Mix(m) => m.add_lobes(at, bsdf),)*
                }
            }

            /// Subsurface scattering of light that `bsdf` transmits. [`Material::subsurface_transport`] handles mixes.
            pub(super) fn bssrdf(
                &self,
                hit: &SurfaceHit,
                bsdf: &Bsdf,
                at: &Place,
            ) -> Option<Bssrdf<'_>> {
                match self {
                    $(MaterialKind::$Type(m) => m.bssrdf(hit, bsdf, at),)*
                    $(MaterialKind::$V2Type(m) => m.bssrdf(hit, bsdf, at),)*
                    $(MaterialKind::$Mix(m) => m.bssrdf(hit, bsdf, at),)*
                }
            }

            /// What is asked about a material before rendering.
            pub(super) fn scattering(&self) -> &dyn Scattering {
                match self {
                    $(MaterialKind::$Type(m) => m,)*
                    $(MaterialKind::$V2Type(m) => m,)*
                    $(MaterialKind::$Mix(m) => m,)*
                }
            }

            /// Gets its tables.
            pub(super) fn prepare(&mut self, tables: &mut Tables) {
                match self {
                    $(MaterialKind::$Type(m) => m.prepare(tables),)*
                    $(MaterialKind::$V2Type(m) => m.prepare(tables),)*
                    $(MaterialKind::$Mix(m) => m.prepare(tables),)*
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
