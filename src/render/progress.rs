//! A render as it goes: what is done is reported and kept, and whether it is to stop is asked.

use crate::checkpoint::Journal;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};

/// What is reported while an image is rendered.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Step {
    /// So many of all samples are done.
    Samples {
        /// Done.
        done: u64,
        /// In all.
        all: u64,
    },
    /// A pass is done, of a render whose length is not known in advance.
    Pass {
        /// Its number, from 1.
        number: u32,
        /// Samples a pixel so far, on average.
        spp: f64,
        /// Estimated relative error, if it is known.
        error: Option<f64>,
    },
}

/// Counts finished samples, and tells workers of checkpoint and stop. Shared by threads.
pub struct Progress<'a> {
    report: &'a (dyn Fn(Step) + Sync),
    done: AtomicU64,
    all: u64,
    journal: Option<&'a Journal>,
    stop: Option<&'a AtomicBool>,
}

impl<'a> Progress<'a> {
    /// Of `all` samples, told to `report`, which any thread may call.
    pub fn new(all: u64, report: &'a (dyn Fn(Step) + Sync)) -> Progress<'a> {
        Progress {
            report,
            done: AtomicU64::new(0),
            all,
            journal: None,
            stop: None,
        }
    }

    /// The same, kept in `journal` and stopped by `stop`, if there are any.
    pub fn kept(self, journal: Option<&'a Journal>, stop: Option<&'a AtomicBool>) -> Progress<'a> {
        Progress {
            journal,
            stop,
            ..self
        }
    }

    /// The checkpoint.
    pub fn journal(&self) -> Option<&'a Journal> {
        self.journal
    }

    /// Returns `true` if no more work is to be begun.
    pub fn is_stopped(&self) -> bool {
        self.stop.is_some_and(|stop| stop.load(Relaxed))
    }

    /// Told to nobody.
    pub fn hidden() -> Progress<'static> {
        Progress::new(0, &|_| ())
    }

    /// `samples` more are done.
    pub fn advance(&self, samples: u64) {
        if samples == 0 {
            return;
        }
        let done = self.done.fetch_add(samples, Relaxed) + samples;
        (self.report)(Step::Samples {
            done,
            all: self.all,
        });
    }

    /// A pass is done.
    pub fn pass_done(&self, number: u32, spp: f64, error: Option<f64>) {
        (self.report)(Step::Pass { number, spp, error });
    }
}
