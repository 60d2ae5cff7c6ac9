//! Progress on a terminal: a bar with rate and time left; silent where nobody watches.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Counts finished pixels. May be shared by threads.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar on standard error for `pixels` pixels of `spp` samples; hidden where standard error
    /// is not a terminal or `quiet` is asked for.
    pub fn new(pixels: u64, spp: u32, quiet: bool) -> Progress {
        if quiet {
            return Progress::hidden();
        }
        let bar = ProgressBar::with_draw_target(
            Some(pixels * u64::from(spp)),
            ProgressDrawTarget::stderr(),
        );
        let template = "{elapsed_precise} {wide_bar} {percent}% {per_sec} ETA {eta}";
        if let Ok(style) = ProgressStyle::with_template(template) {
            let rate = |state: &indicatif::ProgressState, out: &mut dyn std::fmt::Write| {
                // A formatter has nowhere to report to; a missing rate is only missing.
                let _ = write!(out, "{:.2} M samples/s", state.per_sec() / 1e6);
            };
            bar.set_style(style.with_key("per_sec", rate));
        }
        Progress { bar }
    }

    /// The state of a render in passes, whose length nobody knows beforehand.
    pub fn of_passes(quiet: bool) -> Progress {
        if quiet {
            return Progress::hidden();
        }
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        if let Ok(style) = ProgressStyle::with_template("{elapsed_precise} {msg}") {
            bar.set_style(style);
        }
        Progress { bar }
    }

    /// No bar at all.
    pub fn hidden() -> Progress {
        Progress {
            bar: ProgressBar::hidden(),
        }
    }

    /// `samples` more are done.
    pub fn advance(&self, samples: u64) {
        self.bar.inc(samples);
    }

    /// A pass is done: the picture has so many samples a pixel on average, and this relative error, if it is known.
    pub fn pass_done(&self, pass: u32, spp: f64, error: Option<f64>) {
        let error = error.map_or("unknown".into(), |e| format!("{:.3} %", 100.0 * e));
        self.bar.set_message(format!(
            "pass {pass}: {spp:.1} samples a pixel, error {error}"
        ));
        self.bar.tick();
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
