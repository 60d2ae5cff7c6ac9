//! Sums of splats in a checkpoint: all of them at a time, which is much for a large image, so not too often.

use super::{Journal, Record};
use crate::film::{STORED_PIXEL, Splats};
use std::sync::{MutexGuard, PoisonError};
use std::time::Duration;

/// Bytes a second that a checkpoint grows by on account of splats, at most, and but for what is kept at the end.
const RATE: f64 = (1 << 20) as f64;

/// What a checkpoint has of splats.
#[derive(Debug, Default)]
pub(super) struct KeptSplats {
    /// Paths of each half.
    paths: [u64; 2],
    /// When they were kept by this process, since it opened the checkpoint.
    at: Option<Duration>,
}

impl Journal {
    /// The splats of a half that the file held when it was opened, added to `blank`; `None` if they cannot be.
    pub fn restore_splats(&self, half: u8, mut blank: Splats) -> Option<Splats> {
        let mut appended = self.lock();
        let Some(file) = appended.file.as_mut() else {
            return Some(blank);
        };
        let restored = self.contents.add_splats(half, file, &mut blank);
        drop(appended);
        restored.ok()??;
        if let Some(paths) = self.kept_splats().paths.get_mut(usize::from(half)) {
            *paths = blank.paths().count();
        }
        Some(blank)
    }

    /// Returns `true` if sums of so many pixels may be kept: no more often than work is at all, and not so often that the file grows
    /// faster than `RATE`; but once by every process that lives long enough, or those of a large image would never be.
    pub fn is_time_for_splats(&self, pixels: usize) -> bool {
        let now = self.opened.elapsed();
        let pause = Duration::from_secs_f64(pixels as f64 * STORED_PIXEL as f64 / RATE);
        match self.kept_splats().at {
            Some(at) => now.saturating_sub(at) >= pause.max(self.every),
            None => now >= self.every,
        }
    }

    /// Keeps all splats of a half so far, unless the file has them.
    pub fn keep_splats(&self, half: u8, splats: &Splats) {
        let mut kept = self.kept_splats();
        kept.at = Some(self.opened.elapsed());
        let paths = splats.paths().count();
        match kept.paths.get_mut(usize::from(half)) {
            Some(known) if *known != paths => *known = paths,
            _ => return,
        }
        let parts = splats.parts();
        for part in 0..parts {
            let mut body = Record::Splats { half, part, parts }.store(&[]);
            splats.store(part, &mut body);
            self.append(&body, part + 1 == parts);
        }
    }

    fn kept_splats(&self) -> MutexGuard<'_, KeptSplats> {
        self.splats.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
