//! Subsurface scattering media, shared by `subsurface` and `kdsubsurface`.

use super::prepare::Tables;
use super::roughness::{Roughness, find_roughness};
use super::{Glass, Material, Place, Scattering};
use crate::bsdf::Bsdf;
use crate::bssrdf::{Bssrdf, Profile, ProfileTable, TabulatedChannel, finest_length};
use crate::inputs::FloatInput;
use crate::math::Rgb;
use crate::params::ParamReader;
use crate::surface::SurfaceHit;
use std::sync::Arc;

/// A dielectric boundary with a scattering medium below it. Parameters: spectrum `Kr` (1), `Kt` (1); float
/// `uroughness`, `vroughness` (0): smooth if both are 0; constant bool `remaproughness` (true); constant float `eta`
/// (1.33), `g` (0), `scale` (1). In pbrt-v2's language the boundary is always smooth, `index` (1.3) replaces `eta`, and
/// there is no `Kt` and no `g`.
#[derive(Clone, Debug, PartialEq)]
pub struct Interior {
    /// The boundary.
    pub boundary: Glass,
    /// Refractive index of the medium relative to the outside.
    pub eta: f32,
    /// Mean scattering cosine, -1…1.
    pub g: f32,
    /// Scale of the coefficients or lengths, 0 or more.
    pub scale: f32,
    /// Profiles for `g` and `eta`, once they have been [computed](Interior::prepare).
    table: Option<Arc<ProfileTable>>,
}

/// A medium below a surface, and what its boundary is.
pub(super) trait Inside {
    /// The boundary and other properties.
    fn interior(&self) -> &Interior;

    /// The same, to be changed.
    fn interior_mut(&mut self) -> &mut Interior;

    /// The medium at a point; `None` before the profiles have been computed.
    fn medium(&self, at: &Place) -> Option<Extinction>;
}

impl<M: Inside> Scattering for M {
    fn is_isotropic(&self) -> bool {
        self.interior().boundary.is_isotropic()
    }

    fn add_lobes<'a>(&'a self, at: &Place<'_, 'a>, bsdf: &mut Bsdf<'a>) {
        self.interior().boundary.add_lobes(at, bsdf);
    }

    fn max_lobes(&self) -> usize {
        self.interior().boundary.max_lobes()
    }

    fn has_interior(&self) -> bool {
        true
    }

    fn bssrdf(&self, hit: &SurfaceHit, bsdf: &Bsdf, at: &Place) -> Option<Bssrdf<'_>> {
        let medium = self.medium(at)?;
        self.interior().bssrdf(&medium, hit, bsdf)
    }

    fn prepare(&mut self, tables: &mut Tables) {
        self.interior_mut().prepare(tables);
    }

    fn is_smooth(&self, materials: &[Material]) -> bool {
        self.interior().boundary.is_smooth(materials)
    }
}

/// The albedo and the mean free path, in scene units, of a medium; the latter is infinite if the medium does nothing.
#[derive(Clone, Copy, Debug)]
pub struct Extinction {
    /// Single-scattering albedo.
    pub albedo: Rgb,
    /// Mean free path.
    pub mean_free_path: Rgb,
}

impl Interior {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Interior {
        let smooth = FloatInput::Constant(0.0);
        let roughness =
            ["uroughness", "vroughness"].map(|name| find_roughness(reader, name).unwrap_or(smooth));
        let g = within(reader, "g", 0.0, |g| (-1.0..=1.0).contains(&g));
        let eta = within(reader, reader.spelling("eta"), 1.33, |eta| eta > 0.0);
        let boundary = Glass {
            kr: reader.spectrum_input("Kr", Rgb::ONE),
            kt: reader.spectrum_input("Kt", Rgb::ONE),
            eta: FloatInput::Constant(eta),
            roughness: Roughness::new(reader, roughness),
        };
        let scale = within(reader, "scale", 1.0, |scale| scale >= 0.0);
        Interior {
            boundary,
            eta,
            g,
            scale,
            table: None,
        }
    }

    /// Gets its table of profiles.
    pub(super) fn prepare(&mut self, tables: &mut Tables) {
        self.table = Some(tables.profiles(self.g, self.eta));
    }

    /// The profiles, if they have been computed.
    pub fn table(&self) -> Option<&ProfileTable> {
        self.table.as_deref()
    }

    /// The BSSRDF of a medium at `surface`, in the shading frame of `bsdf`.
    pub fn bssrdf(
        &self,
        medium: &Extinction,
        surface: &SurfaceHit,
        bsdf: &Bsdf,
    ) -> Option<Bssrdf<'_>> {
        let table = self.table()?;
        let finest = finest_length(surface);
        let channels = std::array::from_fn(|c| {
            let row = table.row(medium.albedo[c]);
            TabulatedChannel::new(row, medium.mean_free_path[c], finest)
        });
        let profile = Profile::Tabulated(channels);
        Some(Bssrdf::new(surface, *bsdf.frame(), profile, table.exit()))
    }
}

/// A constant number; if it is not `good`, or not finite, a warning is given and the usual one is used.
fn within(reader: &ParamReader, name: &str, usual: f32, good: impl Fn(f32) -> bool) -> f32 {
    let usual = reader.default_of(name, f64::from(usual)) as f32;
    let given = reader.float(name, f64::from(usual)) as f32;
    if good(given) && given.is_finite() {
        return given;
    }
    reader.warn(
        name,
        format!("`{name}` is {given}, out of range: {usual} is used"),
    );
    usual
}
