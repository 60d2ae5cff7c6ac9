//! How many threads work.

/// Maximum number of threads for each processor: more only cost memory and time.
pub(crate) const THREADS_PER_PROCESSOR: usize = 8;

/// Bytes of a thread's stack, as many as a program's first thread mostly has; only what is used takes memory. A tile of the Cornell box takes
/// between a quarter and half a megabyte, and a thread that waits takes up other work on top of what it waits for: 2 megabytes, the
/// default, were too few for 8 threads on 16 processors when each level of that held a tile's arrays.
const STACK: usize = 8 << 20;

/// The number of threads that are started where so many are requested; 0 requests one for each processor.
pub(crate) fn threads_started(requested: usize) -> usize {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    match requested {
        // Not left to rayon, which would take any number from RAYON_NUM_THREADS.
        0 => processors,
        requested => requested.min(THREADS_PER_PROCESSOR * processors),
    }
}

/// Runs `work` on a pool of its own with [`threads_started`] threads.
pub(crate) fn on_threads<T: Send>(
    requested: usize,
    work: impl FnOnce() -> T + Send,
) -> Result<T, String> {
    let threads = threads_started(requested);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .stack_size(STACK)
        .build();
    let pool = pool.map_err(|error| format!("cannot start {threads} threads: {error}"))?;
    Ok(pool.install(work))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_request_starts_threads_without_end() {
        let one_each = threads_started(0);
        assert!(one_each >= 1);
        assert_eq!(threads_started(1), 1);
        let most = THREADS_PER_PROCESSOR * one_each;
        assert_eq!(threads_started(usize::MAX), most);
        assert_eq!(on_threads(usize::MAX, rayon::current_num_threads), Ok(most));
    }
}
