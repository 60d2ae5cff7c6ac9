//! The `kdsubsurface` material.

use super::Place;
use super::interior::{Extinction, Inside, Interior};
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::Rgb;
use crate::params::ParamReader;

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
}

impl Inside for KdSubsurface {
    fn interior(&self) -> &Interior {
        &self.interior
    }

    fn interior_mut(&mut self) -> &mut Interior {
        &mut self.interior
    }

    /// Negative values count as 0.
    fn medium(&self, at: &Place) -> Option<Extinction> {
        let table = self.interior.table()?;
        let kd = at.reflectance(&self.kd);
        let mean_free_path = match &self.mean_free_path {
            MeanFreePath::Spectrum(mfp) => at.reflectance(mfp),
            MeanFreePath::Float(mfp) => Rgb::splat(at.float(mfp).max(0.0)),
        };
        Some(Extinction {
            albedo: kd.map(|kd| table.invert(kd)),
            mean_free_path: self.interior.scale * mean_free_path,
        })
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
