//! Stopping criteria of a render.

use std::time::Duration;

/// When to stop rendering: at the criterion that is met first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// The image's relative error: see `Progressive::error`.
    pub error: Option<f64>,
    /// Stop at an error only when the true one is as small with this confidence.
    pub confidence: Option<f64>,
    /// Time since the first sample: no tile is started later.
    pub time: Option<Duration>,
    /// Maximum samples per pixel, at least [`Goal::PILOT`].
    pub max_spp: u32,
}

impl Goal {
    /// Samples per pixel in the first pass, if time allows: enough to estimate the noise of a tile of 16 × 16 pixels to
    /// about a tenth.
    pub const PILOT: u32 = 8;
    /// The same in each of two halves.
    pub(super) const PILOT_OF_HALF: u32 = Goal::PILOT / 2;
    /// Default maximum of samples per pixel. If an image has not converged by then, sampling fails to find something in
    /// it.
    pub const MAX_SPP: u32 = 1 << 20;

    /// Maximum samples per pixel in each of two halves.
    pub(super) fn most_of_half(&self) -> u32 {
        self.max_spp.max(Goal::PILOT) / 2
    }
}

/// Why rendering stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The error goal was reached.
    Error,
    /// The time was up.
    Time,
    /// Every pixel has its most samples.
    Samples,
    /// It was stopped before its goal.
    Stopped,
}
