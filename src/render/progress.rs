//! A render as it goes: what is done is reported and kept, and whether it is to stop is asked.

use super::Live;
use crate::checkpoint::Journal;
use crate::film::Tile;
use crate::integrators::Counts;
use crate::integrators::witness::Watch;
use crate::world::World;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

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
    live: Option<&'a Live>,
    statistics: Option<&'a Statistics>,
}

/// What all workers have counted, of the blocks of samples that are done.
#[derive(Debug)]
pub struct Statistics {
    none: Counts,
    sum: Mutex<Counts>,
}

impl Statistics {
    /// Nothing yet, of a world.
    pub fn new(world: &World) -> Statistics {
        let none = Counts::new(world);
        Statistics {
            sum: Mutex::new(none.clone()),
            none,
        }
    }

    /// All so far.
    pub fn counts(&self) -> Counts {
        // Numbers, of which a panic elsewhere leaves some without a worker's.
        self.sum
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    fn add(&self, counts: &Counts) {
        let mut sum = self.sum.lock().unwrap_or_else(PoisonError::into_inner);
        sum.add(counts);
    }
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
            live: None,
            statistics: None,
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

    /// The same, shown and counted as it goes, if that is asked for.
    pub fn shown(self, live: Option<&'a Live>, statistics: Option<&'a Statistics>) -> Progress<'a> {
        Progress {
            live,
            statistics,
            ..self
        }
    }

    /// Where the image is shown as it grows.
    pub fn live(&self) -> Option<&'a Live> {
        self.live
    }

    /// Shows more samples of a half, if anybody looks.
    pub fn show(&self, half: u8, tile: &Tile) {
        if let Some(live) = self.live {
            live.add(half, tile);
        }
    }

    /// Lets `work` count what it does, if that is asked for.
    pub fn counted(&self, work: impl FnOnce(Option<&mut Watch>)) {
        let Some(statistics) = self.statistics else {
            return work(None);
        };
        let mut watch = Watch::counting(statistics.none.clone());
        work(Some(&mut watch));
        if let Some(counts) = watch.counts() {
            statistics.add(counts);
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
