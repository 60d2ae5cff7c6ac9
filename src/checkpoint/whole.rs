//! What a checkpoint has of all pixels at a time, which is much for a large image, so not too often: sums of splats, and the
//! tiles of photon mapping.

use super::{Journal, Record};
use crate::film::{STORED_PIXEL, Splats};
use std::sync::{MutexGuard, PoisonError};
use std::time::Duration;

/// Bytes a second that a checkpoint grows by on account of these, at most, and but for what is kept at the end.
const RATE: f64 = (1 << 20) as f64;

/// What a checkpoint has of all pixels.
#[derive(Debug, Default)]
pub(super) struct KeptWhole {
    /// The light paths of each half whose splats it has.
    paths: [u64; 2],
    /// When all pixels were kept by this process, since it opened the checkpoint.
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
        if let Some(paths) = self.kept_whole().paths.get_mut(usize::from(half)) {
            *paths = blank.paths().count();
        }
        Some(blank)
    }

    /// Returns `true` if sums of so many pixels may be kept.
    pub fn is_time_for_splats(&self, pixels: usize) -> bool {
        self.is_time_for(pixels as u64 * STORED_PIXEL)
    }

    /// Returns `true` if so many bytes may be kept: no more often than work is at all, and not so often that the file grows
    /// faster than `RATE`; but once by every process that lives long enough, or those of a large image would never be.
    pub fn is_time_for(&self, bytes: u64) -> bool {
        let now = self.opened.elapsed();
        let pause = Duration::from_secs_f64(bytes as f64 / RATE);
        match self.kept_whole().at {
            Some(at) => now.saturating_sub(at) >= pause.max(self.every),
            None => now >= self.every,
        }
    }

    /// Keeps all splats of a half so far, unless the file has them.
    pub fn keep_splats(&self, half: u8, splats: &Splats) {
        let mut kept = self.kept_whole();
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

    /// The tiles of photon mapping that the file held when it was opened: what `read` makes of a tile's number, its iterations and
    /// its bytes. `None` if there are not so many, or one of them cannot be read.
    pub fn restore_iterated<T>(
        &self,
        tiles: usize,
        read: impl Fn(usize, u32, &[u8]) -> Option<T>,
    ) -> Option<Vec<T>> {
        let mut appended = self.lock();
        let file = appended.file.as_mut()?;
        let restored = |tile| {
            let (done, bytes) = self.contents.iterated(tile, file).ok()??;
            read(tile, done, &bytes)
        };
        let is_whole = self.contents.iterated_tiles() == tiles;
        is_whole.then(|| (0..tiles).map(restored).collect())?
    }

    /// Keeps all tiles of photon mapping, each with its number of iterations, as `store` makes bytes of them.
    pub fn keep_iterated<T>(
        &self,
        tiles: &[T],
        done: impl Fn(&T) -> u32,
        store: impl Fn(&T, &mut Vec<u8>),
    ) {
        self.kept_whole().at = Some(self.opened.elapsed());
        let parts = tiles.len() as u32;
        for (part, tile) in (0..).zip(tiles) {
            let done = done(tile);
            let mut body = Record::Iterated { done, part, parts }.store(&[]);
            store(tile, &mut body);
            self.append(&body, part + 1 == parts);
        }
    }

    fn kept_whole(&self) -> MutexGuard<'_, KeptWhole> {
        self.kept_whole
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Identity, Journal, Keep};
    use std::path::Path;
    use std::sync::Arc;
    use std::time::Duration;

    fn open(path: &Path) -> Journal {
        let identity: Arc<dyn Fn() -> Identity + Send + Sync> = Arc::new(Identity::default);
        let keep = Keep {
            path,
            identity: &identity,
            facts: None,
            after: Duration::ZERO,
            every: Duration::from_secs(3600),
        };
        Journal::open(&keep).expect("a checkpoint")
    }

    /// Three tiles of these iterations, in a file that was cut off so many bytes before its end.
    fn kept(path: &Path, iterations: [u32; 3], cut: u64) {
        let journal = open(path);
        let store = |done: &u32, out: &mut Vec<u8>| out.extend([*done as u8; 100]);
        journal.keep_iterated(&iterations, |done| *done, store);
        drop(journal);
        let file = std::fs::OpenOptions::new().write(true).open(path).unwrap();
        file.set_len(file.metadata().unwrap().len() - cut).unwrap();
    }

    fn restored(path: &Path, tiles: usize) -> Option<Vec<u32>> {
        let read = |_, done: u32, bytes: &[u8]| (bytes == [done as u8; 100]).then_some(done);
        open(path).restore_iterated(tiles, read)
    }

    #[test]
    fn the_last_whole_set_of_tiles_counts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.fsc");
        kept(&path, [7, 8, 7], 0);
        assert_eq!(restored(&path, 3), Some(vec![7, 8, 7]));
        // Without the time behind them, 17 bytes, they are whole; without more, the last tile is not.
        kept(&path, [9, 9, 9], 17);
        assert_eq!(restored(&path, 3), Some(vec![9, 9, 9]));
        for cut in [18, 17 + 121, 17 + 2 * 121, 17 + 3 * 121] {
            kept(&path, [10, 10, 10], cut);
            assert_eq!(restored(&path, 3), Some(vec![9, 9, 9]), "{cut}");
        }
        kept(&path, [11, 12, 12], 0);
        assert_eq!(restored(&path, 3), Some(vec![11, 12, 12]));
        assert!(open(&path).resumes());
        assert_eq!(restored(&path, 2), None);
        assert_eq!(restored(&path, 4), None);
        let nothing = |_, _, _: &[u8]| None::<()>;
        assert_eq!(open(&path).restore_iterated(3, nothing), None);
    }
}
