//! The interval during which the film sees light.

use crate::params::ParamReader;

/// Shutter times (`shutteropen`, `shutterclose`; default 0 and 1), in the units of
/// `TransformTimes` (docs/scene-language.md §3.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter {
    /// When the shutter opens.
    pub open: f64,
    /// When it closes; never before `open`.
    pub close: f64,
}

impl Default for Shutter {
    fn default() -> Shutter {
        Shutter {
            open: 0.0,
            close: 1.0,
        }
    }
}

impl Shutter {
    /// Reads both times; reversed ones are exchanged, with a warning.
    pub fn from_params(params: &ParamReader) -> Shutter {
        let open = params.float("shutteropen", 0.0);
        let close = params.float("shutterclose", 1.0);
        if close < open {
            params.warn(
                "shutterclose",
                format!("the shutter closes at {close}, before it opens at {open}: exchanged"),
            );
            return Shutter {
                open: close,
                close: open,
            };
        }
        Shutter { open, close }
    }

    /// The time at fraction `s` of the interval.
    pub fn time(&self, s: f32) -> f32 {
        (self.open + (self.close - self.open) * f64::from(s)) as f32
    }

    /// What the length of the interval does to the exposure: a factor of its length, and 1 for
    /// equal times (the original pbrt-v3 makes such an image black).
    pub fn exposure(&self) -> f64 {
        let length = self.close - self.open;
        if length > 0.0 { length } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_times_have_no_exposure_factor() {
        assert_eq!(
            Shutter {
                open: 0.0,
                close: 0.0
            }
            .exposure(),
            1.0
        );
        assert_eq!(
            Shutter {
                open: 1.0,
                close: 1.5
            }
            .exposure(),
            0.5
        );
    }

    #[test]
    fn time_runs_from_open_to_close() {
        let s = Shutter {
            open: 2.0,
            close: 4.0,
        };
        assert_eq!((s.time(0.0), s.time(0.5), s.time(1.0)), (2.0, 3.0, 4.0));
    }
}
