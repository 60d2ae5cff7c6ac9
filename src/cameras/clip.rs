//! The planes before and behind which a camera sees nothing.

use crate::params::ParamReader;

/// Clip planes at camera-space z = `hither` and z = `yon`, in the camera's units. pbrt-v1 and the
/// course kits had them; pbrt-v3 has none. A ray that does not run forward (a fisheye's, beyond a
/// right angle) is not clipped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip {
    /// Nothing with a smaller z is seen.
    pub hither: f64,
    /// Nothing with a larger z is seen.
    pub yon: f64,
}

impl Default for Clip {
    fn default() -> Clip {
        Clip::NONE
    }
}

impl Clip {
    /// Clips nothing.
    pub const NONE: Clip = Clip {
        hither: f64::NEG_INFINITY,
        yon: f64::INFINITY,
    };

    /// Reads `hither` and `yon`; each is optional.
    pub fn from_params(params: &ParamReader) -> Clip {
        let clip = Clip {
            hither: params.float("hither", f64::NEG_INFINITY),
            yon: params.float("yon", f64::INFINITY),
        };
        let between = clip.hither < clip.yon;
        if !between {
            params.error(
                "yon",
                format!(
                    "nothing lies between hither = {} and yon = {}; expected yon > hither",
                    clip.hither, clip.yon
                ),
            );
            return Clip::NONE;
        }
        clip
    }

    /// The part of the ray from height `z` with z-direction `dz` between the planes, as
    /// parameters (start, end): start ≥ 0, end may lie before start.
    pub fn interval(&self, z: f64, dz: f64) -> (f64, f64) {
        if dz <= 0.0 || *self == Clip::NONE {
            return (0.0, f64::INFINITY);
        }
        (((self.hither - z) / dz).max(0.0), (self.yon - z) / dz)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interval_lies_between_the_planes() {
        let clip = Clip {
            hither: 2.0,
            yon: 6.0,
        };
        assert_eq!(clip.interval(0.0, 0.5), (4.0, 12.0));
        assert_eq!(clip.interval(3.0, 1.0), (0.0, 3.0));
        assert_eq!(clip.interval(0.0, -1.0), (0.0, f64::INFINITY));
        assert_eq!(Clip::NONE.interval(0.0, 1.0), (0.0, f64::INFINITY));
    }
}
