//! When an image is finished.

use std::time::Duration;

/// What to render until; whichever is reached first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// The image's relative error: see `Progressive::error`.
    pub error: Option<f64>,
    /// Time since the first sample: no tile is begun later.
    pub time: Option<Duration>,
    /// The most samples a pixel, at least [`Goal::PILOT`].
    pub max_spp: u32,
}

impl Goal {
    /// Samples a pixel in the first pass, where the time allows it: enough that a tile of 16 × 16 pixels knows its noise to
    /// about a tenth.
    pub const PILOT: u32 = 8;
    /// The most samples a pixel where nobody names a number. An image that is not good by then has
    /// something in it that sampling does not find.
    pub const MAX_SPP: u32 = 1 << 20;
}

/// Why rendering ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The error is small enough.
    Error,
    /// The time is up.
    Time,
    /// Every pixel has its most samples.
    Samples,
}
