//! What a panic, which is a bug in fstop, looks like from outside: a request for a report, and an exit code of its own.

use super::codes::BUG;
use crate::console::{self, Level};
use std::panic::{self, AssertUnwindSafe};

/// Runs `work`; where it panics, on whichever thread, that is the end of it. Threads of a pool hand their panics on to
/// whom they work for. What is no panic, such as a stack overflow, still ends the process by a signal.
pub(super) fn caught(work: impl FnOnce() -> u8) -> u8 {
    let usual = panic::take_hook();
    panic::set_hook(Box::new(move |panicked| {
        match console::is_json() {
            true => console::say_json(Level::Error, &panicked.to_string()),
            false => usual(panicked),
        }
        let place = panicked.location().map(ToString::to_string);
        let message = format!(
            "this is a bug in fstop {}, at {}: please report it, with the scene and the message above",
            env!("CARGO_PKG_VERSION"),
            place.as_deref().unwrap_or("an unknown place")
        );
        console::say_trouble(Level::Error, message);
    }));
    // Nothing of what `work` has left half done is used again.
    panic::catch_unwind(AssertUnwindSafe(work)).unwrap_or(BUG)
}

/// Panics where the environment says so, for the test of what a panic looks like: `main`, or `worker` for a thread of
/// a pool.
#[cfg(feature = "internals")]
#[expect(clippy::panic, reason = "that is what it is for")]
pub(super) fn rehearse() {
    match std::env::var("FSTOP_PANIC").as_deref() {
        Ok("main") => panic!("a rehearsal"),
        Ok("worker") => {
            let _ = crate::session::on_threads(2, || rayon::join(|| (), || panic!("a rehearsal")));
        }
        _ => (),
    }
}

/// Only builds for tests have it.
#[cfg(not(feature = "internals"))]
pub(super) fn rehearse() {}
