//! Progress for people: on a terminal a bar with rate and time left; elsewhere, as in a log file, now and then a line.
//! For programs, see [`super::events`].

use crate::console;
use crate::session::Step;
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Between two lines of a log passes at least this, so that short renders print none …
const SHORTEST: Duration = Duration::from_secs(10);

/// … and at most this, however little is done meanwhile.
const LONGEST: Duration = Duration::from_secs(300);

/// Part of the work that is worth a line.
const STEP: f64 = 0.1;

/// How progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Form {
    /// Objects for programs, one a line on standard error, where nothing else is printed then
    Json,
    /// A bar with rate and time left; nothing where there is no terminal
    Bar,
    /// Lines now and then, few enough for a log file
    Log,
    /// Nothing
    None,
}

impl Form {
    /// For whoever seems to be there: a person, or a file.
    pub(super) fn suited() -> Form {
        match std::io::stderr().is_terminal() {
            true => Form::Bar,
            false => Form::Log,
        }
    }
}

/// The bar or the log of one render.
#[derive(Debug)]
pub(super) struct Bar {
    bar: ProgressBar,
    /// Where nobody watches, but somebody may read later.
    log: Option<Log>,
}

impl Bar {
    /// On standard error, with a rate and the time left, or, where it is rendered `in_passes`, with the last of them.
    pub(super) fn new(form: Form, in_passes: bool) -> Bar {
        let bar = match form == Form::Bar {
            true => ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr()),
            false => ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden()),
        };
        let template = match in_passes {
            true => "{elapsed_precise} {msg}",
            false => "{elapsed_precise} {wide_bar} {percent}% {per_sec} ETA {eta}",
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            let rate = |state: &indicatif::ProgressState, out: &mut dyn std::fmt::Write| {
                // A formatter has nowhere to report to; a missing rate is only missing.
                let _ = write!(out, "{:.2} M samples/s", state.per_sec() / 1e6);
            };
            bar.set_style(style.with_key("per_sec", rate));
        }
        let log = (form == Form::Log).then(Log::default);
        Bar { bar, log }
    }

    /// Shows a step.
    pub(super) fn show(&self, step: Step) {
        match step {
            Step::Samples { done, all } if all > 0 => self.samples(done, all),
            Step::Pass { number, spp, error } => self.pass(number, spp, error),
            _ => (),
        }
    }

    fn samples(&self, done: u64, all: u64) {
        if self.bar.length() != Some(all) {
            self.bar.set_length(all);
        }
        self.bar.set_position(done);
        let Some(log) = &self.log else { return };
        let elapsed = self.bar.elapsed();
        let share = done as f64 / all as f64;
        if share < 1.0 && log.is_due(elapsed, share) {
            let rate = done as f64 / elapsed.as_secs_f64() / 1e6;
            let left = elapsed.mul_f64((1.0 - share) / share.max(1e-9));
            let (percent, left) = (100.0 * share, clock(left));
            let message = format!("{percent:.0} %, {rate:.2} M samples/s, about {left} left");
            print(elapsed, &message);
        }
    }

    /// The image has so many samples a pixel on average, and this relative error, if it is known.
    fn pass(&self, number: u32, spp: f64, error: Option<f64>) {
        let error = error.map_or("unknown".into(), |e| format!("{:.3} %", 100.0 * e));
        let message = format!("pass {number}: {spp:.1} samples a pixel, error {error}");
        // Each pass takes longer than the one before.
        if let Some(log) = &self.log
            && log.is_due(self.bar.elapsed(), f64::from(number))
        {
            print(self.bar.elapsed(), &message);
        }
        self.bar.set_message(message);
        self.bar.tick();
    }

    /// Takes the bar away.
    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// When a log had its last line.
#[derive(Debug, Default)]
struct Log {
    /// Time since the start, and share of the work done.
    last: Mutex<(Duration, f64)>,
}

impl Log {
    /// Returns `true` if a line is due, and the next one then is due after this.
    fn is_due(&self, elapsed: Duration, share: f64) -> bool {
        // A panic elsewhere cannot have left these two numbers inconsistent.
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let (before, share_before) = *last;
        let passed = elapsed.saturating_sub(before);
        let due = passed >= SHORTEST && (share >= share_before + STEP || passed >= LONGEST);
        if due {
            *last = (elapsed, share);
        }
        due
    }
}

/// One line of a log.
fn print(elapsed: Duration, message: &str) {
    console::say(format!("{} {message}", clock(elapsed)));
}

/// `1:02:03`.
fn clock(time: Duration) -> String {
    let seconds = time.as_secs();
    let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    format!("{hours}:{minutes:02}:{seconds:02}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The shares at which lines are printed of a render that takes `seconds`, in `steps` tiles.
    fn lines(seconds: f64, steps: u32) -> Vec<f64> {
        let log = Log::default();
        let shares = (1..=steps).map(|i| f64::from(i) / f64::from(steps));
        shares
            .filter(|share| log.is_due(Duration::from_secs_f64(seconds * share), *share))
            .collect()
    }

    #[test]
    fn a_log_gets_a_line_every_tenth_but_neither_many_nor_none() {
        assert_eq!(lines(9.0, 1000).len(), 0);
        // Every 10 seconds.
        assert_eq!(lines(35.0, 3500).len(), 3);
        // Every tenth; rounding may shift the last one beyond the end.
        assert!((9..=10).contains(&lines(1000.0, 100_000).len()));
        // Every five minutes of ten hours.
        assert!((115..=120).contains(&lines(36_000.0, 100_000).len()));
    }

    #[test]
    fn clocks() {
        assert_eq!(clock(Duration::from_secs(3723)), "1:02:03");
        assert_eq!(clock(Duration::from_millis(59_900)), "0:00:59");
    }
}
