//! CPU time: the cost of an image, unaffected by other work on the machine.

use std::time::Duration;

/// CPU time used by this process so far, by all its threads together: two threads that run for a second each use two
/// seconds. Waiting for other processes does not count.
///
/// Source: POSIX, `clock_gettime(CLOCK_PROCESS_CPUTIME_ID)`. If there is no such clock (Windows), the wall-clock time
/// since the first call.
#[cfg(unix)]
pub fn processor_time() -> Duration {
    use rustix::time::{ClockId, clock_gettime};
    let time = clock_gettime(ClockId::ProcessCPUTime);
    let seconds = u64::try_from(time.tv_sec).unwrap_or(0);
    Duration::new(seconds, u32::try_from(time.tv_nsec).unwrap_or(0))
}

/// The wall-clock time since the first call, where there is no clock of CPU time.
#[cfg(not(unix))]
pub fn processor_time() -> Duration {
    use std::sync::OnceLock;
    use std::time::Instant;
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    #[test]
    #[cfg(unix)]
    fn work_takes_processor_time() {
        // Other tests of this process run at the same time, so there is no upper bound.
        let (started, before) = (Instant::now(), processor_time());
        let mut x = 1u64;
        while started.elapsed() < Duration::from_millis(20) {
            x = std::hint::black_box(crate::math::hash::mix(x));
        }
        assert!(processor_time() > before, "{x}");
    }
}
