//! Folders that one process at a time writes to.

use std::fs::{File, TryLockError};
use std::path::Path;
use std::time::{Duration, Instant};

const BETWEEN_LOOKS: Duration = Duration::from_millis(5);

/// Another process holds the folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InUse;

/// Holds `folder` until what is returned is dropped, however the process ends. The lock is the folder's own: no file is left behind. Waits as long as
/// `patience` for others; where folders cannot be opened or locked nothing is held.
pub fn hold(folder: &Path, patience: Duration) -> Result<Option<File>, InUse> {
    let Ok(folder) = File::open(folder) else {
        return Ok(None);
    };
    let begun = Instant::now();
    loop {
        match folder.try_lock() {
            Ok(()) => return Ok(Some(folder)),
            Err(TryLockError::Error(_)) => return Ok(None),
            Err(TryLockError::WouldBlock) if begun.elapsed() >= patience => return Err(InUse),
            Err(TryLockError::WouldBlock) => std::thread::sleep(BETWEEN_LOOKS),
        }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn one_at_a_time() {
        let folder = tempfile::tempdir().expect("a folder");
        let hold = || hold(folder.path(), Duration::from_millis(20));
        let first = hold().expect("free");
        assert!(first.is_some());
        assert_eq!(hold().expect_err("held"), InUse);
        drop(first);
        assert!(hold().expect("free again").is_some());
    }
}
