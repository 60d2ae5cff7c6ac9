//! How long and how sensitively the film is exposed: `"float exposuretime"` and `"float iso"`.
//!
//! Both are apart from the time of the animation: `shutteropen` and `shutterclose` say what moves how far. Where one of the two is given,
//! the image is as in pbrt-v4, whose `imagingratio` is seconds times ISO over 100: 1 s at ISO 100 leave it as it is.

use crate::cameras::Shutter;
use crate::cameras::realistic::Weighting;
use crate::params::ParamReader;

/// Exposure time and sensitivity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exposure {
    /// Seconds that the film sees light; `None`: as long as the shutter is open, where the weight knows of that.
    pub time: Option<f64>,
    /// Sensitivity, ISO; `None`: 100.
    pub iso: Option<f64>,
}

impl Exposure {
    pub(super) fn from_params(params: &ParamReader) -> Exposure {
        Exposure {
            time: positive(params, "exposuretime"),
            iso: positive(params, "iso"),
        }
    }

    /// What the light of the open shutter counts for.
    pub(super) fn factor(&self, shutter: &Shutter, weighting: Weighting) -> f64 {
        let time = self.time.unwrap_or(match weighting {
            Weighting::Physical => shutter.exposure(),
            Weighting::Simple => 1.0,
        });
        time * (self.iso.unwrap_or(100.0) / 100.0)
    }

    /// Seconds of exposure, as far as there are any: those that are given, or the shutter's.
    pub(super) fn seconds(&self, shutter: &Shutter) -> Option<f64> {
        let open = shutter.close - shutter.open;
        self.time.or_else(|| (open > 0.0).then_some(open))
    }
}

/// The parameter `name` if it is given; anything but a positive number is an error.
fn positive(params: &ParamReader, name: &str) -> Option<f64> {
    let value = params.find_float(name)?;
    if value > 0.0 && value.is_finite() {
        return Some(value);
    }
    params.error(
        name,
        format!("{name} is {value}; expected a positive number"),
    );
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// pbrt-v4's imaging ratio; and without the parameters, what images were before there were any.
    #[test]
    fn exposure_is_seconds_times_sensitivity() {
        let shutter = Shutter {
            open: 2.0,
            close: 5.0,
        };
        let factor = |time, iso, weighting| Exposure { time, iso }.factor(&shutter, weighting);
        assert_eq!(factor(None, None, Weighting::Physical), 3.0);
        assert_eq!(factor(None, None, Weighting::Simple), 1.0);
        for weighting in [Weighting::Physical, Weighting::Simple] {
            assert_eq!(factor(Some(0.25), Some(800.0), weighting), 2.0);
        }
        assert_eq!(factor(None, Some(50.0), Weighting::Physical), 1.5);
    }
}
