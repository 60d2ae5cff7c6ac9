//! Processor time of the thread.

use std::time::{Duration, Instant};

/// Seconds that `work` takes and what it gives.
pub(crate) fn seconds<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let (wall, processor) = (Instant::now(), processor_time());
    let result = work();
    let took = match (processor, processor_time()) {
        (Some(before), Some(after)) => after - before,
        // Not Linux: right only on an idle machine.
        _ => wall.elapsed(),
    };
    (took.as_secs_f64(), result)
}

/// What Linux has charged to this thread so far. The file is brought up to date by the scheduler,
/// which yielding calls.
fn processor_time() -> Option<Duration> {
    std::thread::yield_now();
    let line = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds = line.split(' ').next()?.parse().ok()?;
    Some(Duration::from_nanos(nanoseconds))
}
