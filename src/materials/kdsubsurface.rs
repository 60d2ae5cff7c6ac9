//! The `kdsubsurface` material.

use super::interior::{Extinction, Interior};
use super::prepare::Tables;
use super::{Scattering, reflectance};
use crate::bsdf::Bsdf;
use crate::bssrdf::Bssrdf;
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::Rgb;
use crate::params::ParamReader;
use crate::surface::{SurfaceHit, TexturePoint};
use crate::textures::Textures;

/// A medium below a dielectric boundary, parameterized by its appearance (docs/scene-language.md §3.8).
/// Parameters: spectrum `Kd` (0.5), the share of entering light that comes out again; spectrum `mfp`
/// (1), the mean free path in scene units once it is multiplied with `scale`; and those of
/// `Interior`. In pbrt-v2's language float `meanfreepath` replaces `mfp`.
#[derive(Clone, Debug, PartialEq)]
pub struct KdSubsurface {
    /// Diffuse reflectance of the medium.
    pub kd: SpectrumInput,
    /// Mean free path.
    pub mean_free_path: MeanFreePath,
    /// Boundary and other properties.
    pub interior: Interior,
}

/// A mean free path before scaling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MeanFreePath {
    /// One for each channel.
    Spectrum(SpectrumInput),
    /// One for all channels.
    Float(FloatInput),
}

impl KdSubsurface {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> KdSubsurface {
        let mean_free_path = match reader.find_float_input("meanfreepath") {
            Some(length) => MeanFreePath::Float(length),
            None => MeanFreePath::Spectrum(reader.spectrum_input("mfp", Rgb::ONE)),
        };
        KdSubsurface {
            kd: reader.spectrum_input("Kd", Rgb::splat(0.5)),
            mean_free_path,
            interior: Interior::from_params(reader),
        }
    }

    /// The medium at a point; negative values count as 0. `None` before the profiles have been computed.
    fn medium(&self, at: &TexturePoint, textures: &Textures) -> Option<Extinction> {
        let table = self.interior.table()?;
        let kd = reflectance(&self.kd, at, textures);
        let mean_free_path = match &self.mean_free_path {
            MeanFreePath::Spectrum(mfp) => reflectance(mfp, at, textures),
            MeanFreePath::Float(mfp) => Rgb::splat(textures.float(mfp, at).max(0.0)),
        };
        Some(Extinction {
            albedo: kd.map(|kd| table.invert(kd)),
            mean_free_path: self.interior.scale * mean_free_path,
        })
    }
}

impl Scattering for KdSubsurface {
    fn add_lobes<'a>(&'a self, at: &TexturePoint, textures: &Textures, bsdf: &mut Bsdf<'a>) {
        self.interior.boundary.add_lobes(at, textures, bsdf);
    }

    fn max_lobes(&self) -> usize {
        self.interior.boundary.max_lobes()
    }

    fn has_interior(&self) -> bool {
        true
    }

    fn bssrdf(
        &self,
        hit: &SurfaceHit,
        bsdf: &Bsdf,
        at: &TexturePoint,
        textures: &Textures,
    ) -> Option<Bssrdf<'_>> {
        let medium = self.medium(at, textures)?;
        self.interior.bssrdf(&medium, hit, bsdf)
    }

    fn prepare(&mut self, tables: &mut Tables) {
        self.interior.prepare(tables);
    }

    fn is_smooth(&self) -> bool {
        self.interior.boundary.is_smooth()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::Dialect;
    use crate::params::testing::{Surroundings, read, read_in};

    #[test]
    fn parameters_are_read_in_both_dialects() {
        let params =
            "\"rgb Kd\" [.1 .2 .3] \"rgb mfp\" [1 2 3] \"float eta\" 1.5 \"rgb Kt\" [0 0 0]";
        let v3 = read("kdsubsurface", params, KdSubsurface::from_params);
        assert_eq!(v3.warnings, 0, "{}", v3.text);
        let mfp = SpectrumInput::Constant(Rgb::new(1.0, 2.0, 3.0));
        assert_eq!(v3.value.mean_free_path, MeanFreePath::Spectrum(mfp));
        assert_eq!(v3.value.interior.eta, 1.5);
        let v2 = Surroundings {
            dialect: Dialect::V2,
            word: "Material",
            ..Surroundings::default()
        };
        let params = "\"rgb Kd\" [.1 .2 .3] \"float meanfreepath\" 2 \"float index\" 1.5";
        let v2 = read_in(&v2, "kdsubsurface", params, KdSubsurface::from_params);
        assert_eq!(v2.warnings, 0, "{}", v2.text);
        let mfp = MeanFreePath::Float(FloatInput::Constant(2.0));
        assert_eq!((v2.value.mean_free_path, v2.value.interior.eta), (mfp, 1.5));
    }
}
