//! What every type of material implements in its own file.

use super::prepare::Tables;
use crate::bsdf::Bsdf;
use crate::bssrdf::Bssrdf;
use crate::params::NamedFile;
use crate::surface::{SurfaceHit, TexturePoint};
use crate::textures::Textures;

/// How a material scatters light. Types that scatter below their surface, or that need tables, implement more than
/// [`Scattering::add_lobes`].
pub(super) trait Scattering {
    /// Whether `bumpmap` is one of its parameters.
    const BUMPS: bool = true;

    /// Adds the lobes that the material has at a point to `bsdf`, which stands in the shading frame there.
    fn add_lobes<'a>(&'a self, at: &TexturePoint, textures: &Textures, bsdf: &mut Bsdf<'a>);

    /// Most lobes that it can have at a point, at least 1.
    fn max_lobes(&self) -> usize {
        1
    }

    /// Returns `true` if there is a medium inside that transmitted light may scatter in.
    fn has_interior(&self) -> bool {
        false
    }

    /// How light that its `bsdf` transmits at a point scatters below the surface; `None` where it goes straight on.
    fn bssrdf(
        &self,
        _hit: &SurfaceHit,
        _bsdf: &Bsdf,
        _at: &TexturePoint,
        _textures: &Textures,
    ) -> Option<Bssrdf<'_>> {
        None
    }

    /// The file that it is tabulated in.
    fn file(&self) -> Option<&NamedFile> {
        None
    }

    /// Takes its tables, once for all rays.
    fn prepare(&mut self, _tables: &mut Tables) {}
}
