//! Checkpoints: what a render has done so far, in a file that survives it.
//!
//! A checkpoint (`.fsc`) is a journal: a header that says what it is [of](Identity), then records of finished
//! work, only ever appended. A process that is killed loses what it has not appended yet; a cut-off last record is
//! dropped when the file is opened again. The sums in it are nodes of the image's fixed tree
//! ([`crate::film`]), so that a resumed render ends in the bits of an undisturbed one.
//!
//! ```text
//! "fstop checkpoint 8\n"   length, header (JSON), CRC   length, record, CRC   ...
//! ```

mod contents;
mod facts;
mod identity;
mod plan;
mod record;
mod whole;

pub use contents::{Contents, restored};
pub use facts::{Facts, FilmFacts, GoalFacts, Shard};
pub use identity::Identity;
pub use plan::{Plan, PlanError};
pub use record::Unit;

use crate::film::Tile;
use crate::output::{self, OutputError};
use record::Record;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use whole::KeptWhole;

/// The first bytes of every checkpoint; the number is the format's.
const MAGIC: &[u8] = b"fstop checkpoint 8\n";

/// Longest record that is believed: a tile with all nodes that it can have.
const LONGEST: u32 = 1 << 28;

/// Finished tiles are buffered up to this many bytes.
const COLLECTED: usize = 1 << 20;

/// Why a checkpoint cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The file is something else.
    #[error("{}: this is no checkpoint of this version of fstop, and is not overwritten", .0.display())]
    Foreign(PathBuf),
    /// It is of another version, or the beginning is damaged.
    #[error("{}: this checkpoint is of another version of fstop, or damaged: remove it, or name another", .0.display())]
    OtherVersion(PathBuf),
    /// It is of another render.
    #[error("{}: this is a checkpoint of another render: {}; remove it, or name another", .path.display(), .differences.join("; "))]
    Differs {
        /// The file.
        path: PathBuf,
        /// In sentences.
        differences: Vec<String>,
    },
    /// Another process renders the same.
    #[error("{}: another render is writing this checkpoint", .0.display())]
    InUse(PathBuf),
    /// It cannot be made.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// It cannot be read or written.
    #[error("{}: {source}", .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The operating system's error.
        source: io::Error,
    },
}

impl CheckpointError {
    /// Returns `true` if it might be used on another machine or later.
    pub fn is_failure(&self) -> bool {
        match self {
            CheckpointError::Foreign(_)
            | CheckpointError::OtherVersion(_)
            | CheckpointError::Differs { .. } => false,
            CheckpointError::Output(error) => error.is_failure(),
            CheckpointError::InUse(_) | CheckpointError::Io { .. } => true,
        }
    }

    fn at(path: &Path, source: io::Error) -> CheckpointError {
        let path = path.to_owned();
        CheckpointError::Io { path, source }
    }
}

/// Returns the identity of the render.
pub type Identify<'a> = &'a Arc<dyn Fn() -> Identity + Send + Sync>;

/// A checkpoint, or why there is none.
pub type Opened = Result<Journal, CheckpointError>;

/// The first record.
#[derive(serde::Serialize, serde::Deserialize)]
struct Header {
    identity: Identity,
    /// Of a shard.
    image: Option<Facts>,
}

/// How a checkpoint is kept.
#[derive(Clone)]
pub struct Keep<'a> {
    /// Its file.
    pub path: &'a Path,
    /// What it is of: hashes the scene's files, and is called only if there is a checkpoint, or when one is created.
    pub identity: Identify<'a>,
    /// If it is a shard's, what is known of the image.
    pub facts: Option<&'a Facts>,
    /// Nothing is kept until then.
    pub after: Duration,
    /// After so long all finished work is written and flushed to the disk.
    pub every: Duration,
}

/// An open checkpoint. Shared by threads.
pub struct Journal {
    path: PathBuf,
    identity: Arc<dyn Fn() -> Identity + Send + Sync>,
    facts: Option<Facts>,
    after: Duration,
    every: Duration,
    /// `true` if a file of that name is replaced.
    replaces: bool,
    opened: Instant,
    /// What the file held when it was opened.
    contents: Contents,
    /// Intervals after which everything was written.
    synced: AtomicU64,
    file: Mutex<Appended>,
    kept_whole: Mutex<KeptWhole>,
}

#[derive(Debug)]
struct Appended {
    /// `None` until a render has taken long enough for one.
    file: Option<File>,
    waiting: Vec<u8>,
    /// After an error, until the next interval.
    blocked: bool,
    /// The first error.
    failed: Option<CheckpointError>,
}

impl Journal {
    /// Continues a checkpoint, or creates one.
    ///
    /// # Errors
    /// Fails if the file is not a checkpoint, is one of another render, or is in use; if none can be created.
    pub fn open(keep: &Keep) -> Opened {
        let path = keep.path;
        let mut journal = Journal::new(keep);
        if !path.exists() {
            output::check(path)?;
            if keep.after.is_zero() {
                journal.create(&mut journal.lock());
                let failed = journal.lock().failed.take();
                failed.map_or(Ok(()), Err)?;
            }
            return Ok(journal);
        }
        if !path.is_file() {
            return Err(CheckpointError::Foreign(path.to_owned()));
        }
        let failed = |source| CheckpointError::at(path, source);
        let mut file = locked(path)?;
        if file.metadata().map_err(failed)?.len() == 0 {
            // What a loss of power may leave: there is nothing in it to keep.
            file.write_all(&journal.beginning()?).map_err(failed)?;
            journal.lock().file = Some(file);
            return Ok(journal);
        }
        let found = Contents::read(BufReader::new(file.try_clone().map_err(failed)?));
        let found = found.map_err(failed)?;
        let Some(found) = found else {
            let path = path.to_owned();
            return Err(match begins_as_a_checkpoint(&file) {
                true => CheckpointError::OtherVersion(path),
                false => CheckpointError::Foreign(path),
            });
        };
        let differences = (keep.identity)().differences(&found.identity);
        if differences.is_empty() {
            // Only now: the file of another render stays as it is.
            file.set_len(found.end).map_err(failed)?;
            journal.lock().file = Some(file);
            journal.contents = found;
            return Ok(journal);
        }
        if found.holds_work() {
            let path = path.to_owned();
            return Err(CheckpointError::Differs { path, differences });
        }
        Ok(Journal::replacing(keep))
    }

    /// As [`Journal::open`], but a file there is replaced as soon as there is something to keep.
    pub fn replacing(keep: &Keep) -> Journal {
        Journal {
            replaces: true,
            ..Journal::new(keep)
        }
    }

    fn new(keep: &Keep) -> Journal {
        Journal {
            path: keep.path.to_owned(),
            identity: Arc::clone(keep.identity),
            facts: keep.facts.cloned(),
            after: keep.after,
            replaces: false,
            every: keep.every.max(Duration::from_millis(1)),
            opened: Instant::now(),
            contents: Contents::default(),
            synced: AtomicU64::new(0),
            file: Mutex::new(Appended {
                file: None,
                waiting: Vec::new(),
                blocked: false,
                failed: None,
            }),
            kept_whole: Mutex::default(),
        }
    }

    /// Returns `true` if the file held work when it was opened.
    pub fn resumes(&self) -> bool {
        self.contents.holds_work()
    }

    /// Bytes at the end of the file that could not be used: cut off, or damaged.
    pub fn lost(&self) -> u64 {
        self.contents.lost
    }

    /// Time spent by earlier processes.
    pub fn spent(&self) -> Duration {
        self.contents.spent
    }

    /// Returns `true` if the file holds samples of the unit.
    pub fn has(&self, unit: &Unit) -> bool {
        self.contents.has(unit)
    }

    /// Returns `true` if the file held all samples of the unit when it was opened.
    pub fn has_whole(&self, unit: &Unit) -> bool {
        self.contents.has_whole(unit)
    }

    /// Returns `true` if something could not be written.
    pub fn has_failed(&self) -> bool {
        self.lock().failed.is_some()
    }

    /// What the file has of a unit: the index after the last sample, and the subtrees before it.
    pub fn restore(&self, unit: &Unit, blank: impl Fn() -> Tile) -> Option<(u32, Vec<Tile>)> {
        let mut appended = self.lock();
        let body = self.contents.bytes(unit, appended.file.as_mut()?).ok()??;
        drop(appended);
        restored(unit, &body, blank)
    }

    /// How many intervals have passed.
    pub fn interval(&self) -> u64 {
        (self.opened.elapsed().as_nanos() / self.every.as_nanos().max(1)) as u64
    }

    /// Keeps a finished unit.
    pub fn finished(&self, unit: &Unit, tile: &Tile) {
        let done = unit.samples.end;
        self.work(unit, done, std::slice::from_ref(tile), false);
    }

    /// Keeps the part of a unit that is done; `at_once`, or with the next records.
    pub fn under_way(&self, unit: &Unit, done: u32, nodes: &[Tile], at_once: bool) {
        self.work(unit, done, nodes, at_once);
    }

    fn work(&self, unit: &Unit, done: u32, tiles: &[Tile], at_once: bool) {
        let unit = unit.clone();
        self.append(&Record::Work { unit, done }.store(tiles), at_once);
    }

    /// The counts planned for a pass by an earlier process.
    pub fn plan(&self, pass: u32) -> Option<&[Vec<u32>; 2]> {
        self.contents.plans.get(&pass)
    }

    /// Keeps the counts planned for a pass.
    pub fn planned(&self, pass: u32, counts: &[Vec<u32>; 2]) {
        let counts = counts.clone();
        self.append(&Record::Plan { pass, counts }.store(&[]), true);
    }

    /// Keeps that a shard has all it was told to do: so many passes, 1 of an image that is not rendered in passes.
    pub fn done(&self, passes: u32) {
        self.append(&Record::Done { passes }.store(&[]), true);
    }

    fn append(&self, body: &[u8], at_once: bool) {
        if body.len() > LONGEST as usize {
            return;
        }
        let mut appended = self.lock();
        if appended.file.is_none() {
            if appended.failed.is_some() {
                return;
            }
            if self.opened.elapsed() < self.after {
                return;
            }
            self.create(&mut appended);
        }
        appended.waiting.extend(record::framed(body));
        let interval = self.interval();
        let is_due = self.synced.fetch_max(interval, Relaxed) < interval;
        // A disk that was full may have room again.
        appended.blocked &= !is_due;
        if at_once || is_due {
            self.sync(&mut appended);
        } else if appended.waiting.len() > COLLECTED {
            appended.write(&self.path);
        }
    }

    fn create(&self, appended: &mut Appended) {
        match self.created() {
            Ok(file) => appended.file = Some(file),
            Err(error) => appended.failed = appended.failed.take().or(Some(error)),
        }
    }

    /// What a file begins with.
    fn beginning(&self) -> Result<Vec<u8>, CheckpointError> {
        let header = Header {
            identity: (self.identity)(),
            image: self.facts.clone(),
        };
        let header = serde_json::to_vec(&header);
        let header = header.map_err(|error| CheckpointError::at(&self.path, error.into()))?;
        Ok([MAGIC, &record::framed(&header)].concat())
    }

    fn created(&self) -> Result<File, CheckpointError> {
        let bytes = self.beginning()?;
        let written = match self.replaces {
            true => output::write(&self.path, &bytes),
            false => output::create(&self.path, &bytes),
        };
        match written {
            // By another process, meanwhile.
            Err(OutputError::Io { source, .. })
                if source.kind() == io::ErrorKind::AlreadyExists =>
            {
                Err(CheckpointError::InUse(self.path.clone()))
            }
            written => {
                written?;
                locked(&self.path)
            }
        }
    }

    /// Writes all that is waiting, and waits until the disk has it.
    fn sync(&self, appended: &mut Appended) {
        let spent = self.spent() + self.opened.elapsed();
        let spent = Record::Spent(spent.as_millis() as u64).store(&[]);
        appended.waiting.extend(record::framed(&spent));
        appended.write(&self.path);
        if let Some(file) = &appended.file
            && let Err(error) = file.sync_data()
        {
            let error = CheckpointError::at(&self.path, error);
            appended.failed = appended.failed.take().or(Some(error));
        }
    }

    /// Writes all that is waiting. Returns whether there is a file (there is none while nothing has taken long enough for
    /// one), and the first error of all writing so far: what came after it is not in the file.
    pub fn flush(&self) -> (bool, Option<CheckpointError>) {
        let mut appended = self.lock();
        self.sync(&mut appended);
        (appended.file.is_some(), appended.failed.take())
    }

    /// Removes the file, once the image has been written.
    ///
    /// # Errors
    /// Fails if the folder is not writable.
    pub fn remove(&self) -> Result<(), CheckpointError> {
        match self.lock().file {
            Some(_) => {
                std::fs::remove_file(&self.path).map_err(|e| CheckpointError::at(&self.path, e))
            }
            None => Ok(()),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Appended> {
        // A panic elsewhere leaves at most a record without its end, which is dropped when it is read.
        self.file.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Appended {
    fn write(&mut self, path: &Path) {
        if let (false, Some(file)) = (self.blocked, &mut self.file)
            && let Err(error) = append_whole(file, &self.waiting)
        {
            self.blocked = true;
            let error = CheckpointError::at(path, error);
            self.failed = self.failed.take().or(Some(error));
        }
        self.waiting.clear();
    }
}

/// Appends all of `bytes`, or nothing.
fn append_whole(file: &mut File, bytes: &[u8]) -> io::Result<()> {
    let end = file.seek(SeekFrom::End(0))?;
    file.write_all(bytes).or_else(|error| {
        file.set_len(end)?;
        Err(error)
    })
}

/// Returns `true` if a file begins as those of all versions do.
fn begins_as_a_checkpoint(mut file: &File) -> bool {
    const COMMON: &[u8; 17] = b"fstop checkpoint ";
    let mut begin = [0; COMMON.len()];
    let read = file.rewind().and_then(|()| file.read_exact(&mut begin));
    read.is_ok() && begin == *COMMON
}

/// How often a file is asked for that another holds, and how long after each time: a process that this one just starts holds its files
/// until it runs.
const TRIES: u32 = 20;
const BETWEEN_TRIES: Duration = Duration::from_millis(10);

/// An existing file, for this process alone where the file system can tell.
fn locked(path: &Path) -> Result<File, CheckpointError> {
    let file = { OpenOptions::new() }.read(true).write(true).open(path);
    let file = file.map_err(|source| CheckpointError::at(path, source))?;
    let mut lock = file.try_lock();
    for _ in 0..TRIES {
        if !matches!(lock, Err(TryLockError::WouldBlock)) {
            break;
        }
        std::thread::sleep(BETWEEN_TRIES);
        lock = file.try_lock();
    }
    match lock {
        Ok(()) => Ok(file),
        Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => Ok(file),
        Err(TryLockError::WouldBlock) => Err(CheckpointError::InUse(path.to_owned())),
        Err(TryLockError::Error(source)) => Err(CheckpointError::at(path, source)),
    }
}
