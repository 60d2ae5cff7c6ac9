//! The trait that every type of material implements in its own file.

use super::prepare::Tables;
use super::{Material, Place};
use crate::bsdf::{Boundary, Bsdf, CoatedLobes};
use crate::bssrdf::Bssrdf;
use crate::math::Rgb;
use crate::params::NamedFile;
use crate::surface::SurfaceHit;

/// How a material scatters light. Types with subsurface scattering, or that need tables, implement more than
/// [`Scattering::add_lobes`].
pub(super) trait Scattering {
    /// Returns `true` if `bumpmap` is one of its parameters.
    fn bumps(&self) -> bool {
        true
    }

    /// Adds the material's lobes at a point to `bsdf`, which has the shading frame there.
    fn add_lobes<'a>(&'a self, at: &Place<'_, 'a>, bsdf: &mut Bsdf<'a>);

    /// Maximum number of lobes that it can have at a point, at least 1.
    fn max_lobes(&self) -> usize {
        1
    }

    /// Returns `true` if it may reflect or transmit light in a single direction somewhere, besides any other scattering.
    /// Subsurface scattering does not count: light that enters exits scattered. `materials` are those of the scene.
    fn is_smooth(&self, _materials: &[Material]) -> bool {
        false
    }

    /// Returns `true` if light from a single direction may be scattered into others.
    fn scatters_widely(&self) -> bool {
        true
    }

    /// Returns `true` if it scatters the same all around the normal and asks for no surface parameters, textures aside.
    fn is_isotropic(&self) -> bool {
        true
    }

    /// Its reflectance, if it is ideally diffuse, reflects alone, and is the same everywhere.
    fn even_reflectance(&self) -> Option<Rgb> {
        None
    }

    /// Its lobes, if they are those of a [coated](CoatedLobes) surface, and the same everywhere.
    fn even_coat(&self) -> Option<CoatedLobes> {
        None
    }

    /// Its lobe, if it is a perfectly specular [boundary](Boundary), and the same everywhere.
    fn even_boundary(&self) -> Option<Boundary> {
        None
    }

    /// Returns `true` if there is a medium inside that transmitted light may scatter in.
    fn has_interior(&self) -> bool {
        false
    }

    /// Subsurface scattering of light that its `bsdf` transmits at a point; `None` if the light continues straight.
    fn bssrdf(&self, _hit: &SurfaceHit, _bsdf: &Bsdf, _at: &Place) -> Option<Bssrdf<'_>> {
        None
    }

    /// The file that holds its table.
    fn file(&self) -> Option<&NamedFile> {
        None
    }

    /// Gets its tables, before rendering starts.
    fn prepare(&mut self, _tables: &mut Tables) {}
}
