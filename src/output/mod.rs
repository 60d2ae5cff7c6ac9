//! Output files, written atomically: completely or not at all.
//!
//! A file appears under its name only when it is complete. On Linux it has no name until then, so that nothing is left
//! behind however the program ends; elsewhere, and on file systems that do not support that, it is written under a
//! temporary name in the same folder and renamed.

mod hold;
mod temporary;

pub use hold::{InUse, hold};

use std::collections::BTreeSet;
use std::fs::OpenOptions;
use std::io::{self, Cursor, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use temporary::{Temporary, clear, named, sync};

/// Why a file cannot be written; always names the file.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// A folder has that name.
    #[error("{}: is a folder", .0.display())]
    IsFolder(PathBuf),
    /// The name ends like a folder's, such as `image.exr/`.
    #[error("{}: cannot write: this is the name of a folder", .0.display())]
    NamesFolder(PathBuf),
    /// A read-only file has that name.
    #[error("{}: cannot write: the file there is read-only", .0.display())]
    ReadOnly(PathBuf),
    /// A file that is read has that name.
    #[error("{}: is not overwritten: this is one of the files that are read", .0.display())]
    IsRead(PathBuf),
    /// Another file that is written has that name.
    #[error("{}: cannot write: another output has this name", .0.display())]
    Twice(PathBuf),
    /// The folder of the file does not exist.
    #[error("{}: cannot write: there is no folder `{}`", .path.display(), .folder.display())]
    NoFolder {
        /// The file's path.
        path: PathBuf,
        /// The missing folder.
        folder: PathBuf,
    },
    /// The disk is nearly full.
    #[error("{}: cannot write: {} KiB are free there, the file needs about {}", .path.display(), .free >> 10, .needed >> 10)]
    NoRoom {
        /// The file's path.
        path: PathBuf,
        /// Bytes that are free.
        free: u64,
        /// Bytes that are needed, roughly.
        needed: u64,
    },
    /// The folder is read-only or full, or another error occurred.
    #[error("{}: cannot write: {source}", .path.display())]
    Io {
        /// The file's path.
        path: PathBuf,
        /// The operating system's error.
        source: io::Error,
    },
}

impl OutputError {
    /// Returns `true` if the file might be written on another machine or later. A name that no file can have there, or that is a
    /// folder's, is a mistake everywhere.
    pub fn is_failure(&self) -> bool {
        match self {
            OutputError::IsFolder(_)
            | OutputError::NamesFolder(_)
            | OutputError::IsRead(_)
            | OutputError::Twice(_) => false,
            // Rights differ from machine to machine, and a missing folder may be a disk that is not mounted.
            OutputError::ReadOnly(_)
            | OutputError::NoFolder { .. }
            | OutputError::NoRoom { .. } => true,
            OutputError::Io { source, .. } => !matches!(
                source.kind(),
                ErrorKind::InvalidInput | ErrorKind::InvalidFilename
            ),
        }
    }
}

/// Checks that [`write()`] to this path will work, as far as can be known beforehand. Leaves no trace, and removes those of
/// processes that were killed while they wrote.
///
/// # Errors
/// Fails for a folder of that name, an invalid file name, a read-only file, or a folder that is missing or not
/// writable.
pub fn check(path: &Path) -> Result<(), OutputError> {
    match Target::of(path)? {
        Target::Stream => Ok(()),
        Target::File(target) => {
            let folder = folder_of(&target, path)?;
            clear(folder);
            let file = Temporary::new(folder);
            file.map(drop).map_err(|source| io_error(path, source))
        }
    }
}

/// Checks that files that are to be written are none of those that are `read`, and that no two are the same. Pipes and devices may be.
///
/// # Errors
/// Fails if they are.
pub fn check_apart(
    written: &[impl AsRef<Path>],
    read: &[impl AsRef<Path>],
) -> Result<(), OutputError> {
    let place = |path: &Path| match Target::of(path) {
        Ok(Target::Stream) => None,
        Ok(Target::File(target)) => resolved(&target),
        // Not writable, which is told elsewhere, or read-only.
        Err(_) => path.canonicalize().ok(),
    };
    let read: BTreeSet<PathBuf> = read
        .iter()
        .filter_map(|path| found(path.as_ref()))
        .collect();
    let mut before = Vec::new();
    for path in written.iter().map(AsRef::as_ref) {
        let Some(target) = place(path) else { continue };
        if read.contains(&target) {
            return Err(OutputError::IsRead(path.to_path_buf()));
        }
        if before.contains(&target) {
            return Err(OutputError::Twice(path.to_path_buf()));
        }
        before.push(target);
    }
    Ok(())
}

/// The place of a file that may not exist yet, however its folder is spelled.
pub fn resolved(path: &Path) -> Option<PathBuf> {
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    Some(settled(folder.unwrap_or(Path::new("."))).join(path.file_name()?))
}

/// A place as it is without links and `..`, as far as it exists.
pub fn settled(path: &Path) -> PathBuf {
    let mut there = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut missing = Vec::new();
    loop {
        if let Ok(found) = there.canonicalize() {
            return missing
                .iter()
                .rev()
                .fold(found, |path, name| path.join(name));
        }
        let name = there.file_name().map(ToOwned::to_owned);
        let Some(name) = name.filter(|_| there.pop()) else {
            return path.to_owned();
        };
        missing.push(name);
    }
}

/// Returns `true` if two names, which may be of files that do not exist yet, mean one file.
pub fn same_file(a: &Path, b: &Path) -> bool {
    a == b || (resolved(a).is_some() && resolved(a) == resolved(b))
}

/// The place of a file that is read, which is not opened for that.
fn found(path: &Path) -> Option<PathBuf> {
    let place = path.canonicalize().or_else(|_| std::path::absolute(path));
    place.ok()
}

/// Checks that the disk of `path` has room for `needed` bytes, as far as that is known beforehand.
///
/// # Errors
/// Fails if it has not.
#[cfg(unix)]
pub fn check_room(path: &Path, needed: u64) -> Result<(), OutputError> {
    let Ok(Target::File(target)) = Target::of(path) else {
        return Ok(());
    };
    let Ok(found) = rustix::fs::statvfs(folder_of(&target, path)?) else {
        return Ok(());
    };
    let free = found.f_bavail.saturating_mul(found.f_frsize);
    if free >= needed {
        return Ok(());
    }
    let path = path.to_owned();
    Err(OutputError::NoRoom { path, free, needed })
}

/// Unknown here.
#[cfg(not(unix))]
pub fn check_room(_path: &Path, _needed: u64) -> Result<(), OutputError> {
    Ok(())
}

/// Writes a file. An existing one is replaced and keeps its permissions; the target of a symbolic link is replaced, not
/// the link. Pipes and devices are written to directly.
///
/// # Errors
/// See [`check`]; also a full disk.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let mut file = Draft::begin(path)?;
    let written = file.write_all(bytes);
    written.map_err(|source| io_error(path, source))?;
    file.finish()
}

/// A file that is being written, in any order. Nothing is seen of it until it is finished, and nothing stays of it if it never is.
pub struct Draft {
    path: PathBuf,
    place: Place,
}

/// Where the bytes are until then.
enum Place {
    /// On the disk of the target.
    Disk(Temporary, PathBuf),
    /// In memory, for pipes and devices, in which one cannot go back.
    Memory(Cursor<Vec<u8>>),
}

impl Draft {
    /// An empty file, which is to be what [`write()`] makes.
    ///
    /// # Errors
    /// See [`check`].
    pub fn begin(path: &Path) -> Result<Draft, OutputError> {
        let place = match Target::of(path)? {
            Target::Stream => Place::Memory(Cursor::default()),
            Target::File(target) => {
                let folder = folder_of(&target, path)?;
                let file = Temporary::new(folder);
                let file = file.and_then(|file| file.with_permissions_of(&target));
                Place::Disk(file.map_err(|source| io_error(path, source))?, target)
            }
        };
        let path = path.to_owned();
        Ok(Draft { path, place })
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// See [`write()`].
    pub fn finish(self) -> Result<(), OutputError> {
        let done = match self.place {
            Place::Memory(bytes) => {
                let stream = OpenOptions::new().write(true).open(&self.path);
                stream.and_then(|mut stream| stream.write_all(bytes.get_ref()))
            }
            Place::Disk(file, target) => file.persist(&target, folder_of(&target, &self.path)?),
        };
        done.map_err(|source| io_error(&self.path, source))
    }

    fn bytes(&mut self) -> &mut dyn WriteAnywhere {
        match &mut self.place {
            Place::Disk(file, _) => file.file_mut(),
            Place::Memory(bytes) => bytes,
        }
    }
}

impl Write for Draft {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.bytes().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.bytes().flush()
    }
}

impl Seek for Draft {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.bytes().seek(to)
    }
}

trait WriteAnywhere: Write + Seek {}

impl<W: Write + Seek> WriteAnywhere for W {}

/// As [`write()`], but an existing file is not replaced.
///
/// # Errors
/// See [`check`]; a file of that name.
pub fn create(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let Target::File(target) = Target::of(path)? else {
        return write(path, bytes);
    };
    let folder = folder_of(&target, path)?;
    let created = named(folder).and_then(|file| {
        file.as_file().write_all(bytes)?;
        file.as_file().sync_all()?;
        file.persist_noclobber(&target).map_err(|e| e.error)
    });
    created.map_err(|source| io_error(path, source))?;
    sync(folder);
    Ok(())
}

/// Writes a file that could not be written to `path` to the current folder instead, or to the folder for temporary
/// files; if a file of its name exists there, a number is appended. `write` writes to a path and tells whether it could. Returns the new path.
pub fn rescue(path: &Path, write: impl Fn(&Path) -> bool) -> Option<PathBuf> {
    const MAX_NAMES: usize = 1000;
    let name = Path::new(path.file_name()?);
    let folders = [std::env::current_dir().ok(), Some(std::env::temp_dir())];
    folders.into_iter().flatten().find_map(|folder| {
        let places = (1..=MAX_NAMES).map(|number| folder.join(numbered(name, number)));
        let free = { places }.find(|place| place.symlink_metadata().is_err())?;
        write(&free).then_some(free)
    })
}

/// The name of one of several files: `a.exr` for the first, `a.2.exr` for the second.
pub fn numbered(path: &Path, number: usize) -> PathBuf {
    if number == 1 {
        return path.to_path_buf();
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}.{number}.{ending}"))
}

fn io_error(path: &Path, source: io::Error) -> OutputError {
    OutputError::Io {
        path: path.to_owned(),
        source,
    }
}

/// The actual target of a write.
enum Target {
    /// A regular file, existing or not, with symbolic links resolved.
    File(PathBuf),
    /// A pipe or a device, which cannot be replaced.
    Stream,
}

impl Target {
    fn of(path: &Path) -> Result<Target, OutputError> {
        let found = path.metadata();
        // The standard library considers `a.exr/` and `a.exr/.` to have a file name.
        let name = path.file_name().map(|name| name.as_encoded_bytes());
        let is_file_name =
            name.is_some_and(|name| path.as_os_str().as_encoded_bytes().ends_with(name));
        match found {
            Ok(found) if found.is_dir() => Err(OutputError::IsFolder(path.to_owned())),
            _ if !is_file_name => Err(OutputError::NamesFolder(path.to_owned())),
            Ok(found) if !found.is_file() => Ok(Target::Stream),
            Ok(found) => {
                let writable = OpenOptions::new().append(true).open(path);
                if found.permissions().readonly() || writable.is_err() {
                    return Err(OutputError::ReadOnly(path.to_owned()));
                }
                let target = path.canonicalize().map_err(|e| io_error(path, e))?;
                Ok(Target::File(target))
            }
            Err(error) if is_missing(&error) => Ok(Target::File(followed(path))),
            Err(error) => Err(io_error(path, error)),
        }
    }
}

fn is_missing(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory)
}

/// The target of a symbolic link to a file that does not exist yet.
fn followed(path: &Path) -> PathBuf {
    // The operating system has found neither a file nor a cycle.
    match path.read_link() {
        Ok(next) => followed(&path.parent().unwrap_or(Path::new("")).join(next)),
        Err(_) => path.to_owned(),
    }
}

/// The folder of `target`, which must exist; `path` is the path that was requested.
fn folder_of<'a>(target: &'a Path, path: &Path) -> Result<&'a Path, OutputError> {
    let folder = target.parent().filter(|f| !f.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    if folder.is_dir() {
        Ok(folder)
    } else {
        Err(OutputError::NoFolder {
            path: path.to_owned(),
            folder: folder.to_owned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::temporary::ABANDONED;
    use super::*;
    use std::fs::File;

    pub(super) fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).expect("a folder");
        let name = |entry: io::Result<std::fs::DirEntry>| entry.expect("an entry").file_name();
        let mut names: Vec<String> = entries
            .map(|entry| name(entry).to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    /// On file systems without files that have no name, a killed process leaves one behind.
    #[test]
    fn what_killed_processes_left_is_removed() {
        let folder = tempfile::tempdir().expect("a folder");
        let old = std::time::SystemTime::now() - 2 * ABANDONED;
        let files = [".fstop-left", ".fstop-new", ".fstop-used", "fstop-mine"].map(|name| {
            let file = File::create(folder.path().join(name)).expect("a file");
            let time = if name == ".fstop-new" {
                old + 2 * ABANDONED
            } else {
                old
            };
            file.set_modified(time).expect("a time");
            file
        });
        files[2].lock().expect("a lock");
        check(&folder.path().join("a.exr")).expect("a good name");
        assert_eq!(
            names(folder.path()),
            [".fstop-new", ".fstop-used", "fstop-mine"]
        );
    }

    #[test]
    fn files_are_made_and_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.html");
        for text in ["first", "second"] {
            check(&path).expect("a good name");
            write(&path, text.as_bytes()).expect("a writable folder");
            assert_eq!(std::fs::read_to_string(&path).expect("the file"), text);
            assert_eq!(names(folder.path()), ["a.html"]);
        }
    }

    #[test]
    fn what_is_read_is_not_overwritten() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("scene"), "scene").expect("a file");
        let check = |written: [&str; 2]| {
            let written = written.map(path);
            check_apart(&written.each_ref().map(PathBuf::as_path), &[&path("scene")])
        };
        check(["page", "text"]).expect("three files");
        check(["page", "../scene"]).expect("another folder's");
        std::fs::create_dir(path("in")).expect("a folder");
        assert!(matches!(
            check(["page", "in/../scene"]),
            Err(OutputError::IsRead(_))
        ));
        assert!(matches!(
            check(["page", "page"]),
            Err(OutputError::Twice(_))
        ));
        let null = Path::new("/dev/null");
        check_apart(&[null, null], &[null]).expect("a device");
        // A file that will have been made, under the name that it is written by.
        assert_eq!(found(&path("in/../new")), Some(path("in/../new")));
    }

    /// Another program may wait for nobody to write to them.
    #[cfg(target_os = "linux")]
    #[test]
    fn what_is_read_is_not_opened() {
        use rustix::fs::inotify::{self, CreateFlags, WatchFlags};
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("scene"), "scene").expect("a file");
        let watch = inotify::init(CreateFlags::NONBLOCK).expect("a watch");
        inotify::add_watch(&watch, path("scene"), WatchFlags::OPEN).expect("a watch");
        check_apart(&[path("page")], &[path("scene")]).expect("two files");
        let mut told = [0_u8; 256];
        assert!(rustix::io::read(&watch, &mut told).is_err(), "opened");
    }

    /// Until it is finished nothing is seen of it, and what was there stays.
    #[test]
    fn files_are_written_in_any_order() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a");
        let text = || std::fs::read_to_string(&path).unwrap_or_default();
        for before in ["", "begin, end"] {
            let mut file = Draft::begin(&path).expect("a good name");
            file.write_all(b"....., end").expect("room");
            file.rewind().expect("a file");
            file.write_all(b"begin").expect("room");
            assert_eq!(text(), before);
            file.finish().expect("a writable folder");
            assert_eq!(text(), "begin, end");
        }
        let mut file = Draft::begin(&path).expect("a good name");
        file.write_all(b"half").expect("room");
        drop(file);
        assert_eq!(text(), "begin, end");
        assert_eq!(names(folder.path()), ["a"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_links_and_permissions_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        std::fs::create_dir(path("there")).expect("a folder");
        std::fs::write(path("there/old"), "old").expect("a file");
        let mode = PermissionsExt::from_mode(0o600);
        std::fs::set_permissions(path("there/old"), mode).expect("permissions");
        symlink("there/old", path("to_old")).expect("a link");
        symlink("there/new", path("to_new")).expect("a link");
        symlink("to_new", path("to_to_new")).expect("a link");
        symlink("round", path("round")).expect("a link");
        symlink("nowhere/new", path("astray")).expect("a link");
        for (link, target) in [("to_old", "there/old"), ("to_to_new", "there/new")] {
            check(&path(link)).expect("a link to a good name");
            write(&path(link), link.as_bytes()).expect("a writable folder");
            assert!(path(link).is_symlink(), "{link}");
            assert!(!path(target).is_symlink(), "{target}");
            let text = std::fs::read_to_string(path(target)).expect("the file");
            assert_eq!(text, link);
        }
        let found = path("there/old").metadata().expect("the file");
        assert_eq!(found.permissions().mode() & 0o777, 0o600);
        assert!(check(&path("round")).is_err());
        let message = check(&path("astray")).expect_err("no folder").to_string();
        assert!(message.contains("there is no folder"), "{message}");
    }

    #[test]
    fn what_cannot_be_written_is_known_before() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("kept"), "kept").expect("a file");
        let mut permissions = path("kept").metadata().expect("the file").permissions();
        permissions.set_readonly(true);
        std::fs::set_permissions(path("kept"), permissions).expect("permissions");
        for (name, why) in [
            ("kept", "read-only"),
            ("", "is a folder"),
            ("kept/a", "there is no folder"),
            ("new/", "the name of a folder"),
            ("new/.", "the name of a folder"),
            ("none/new", "there is no folder"),
            (&"x".repeat(256), "cannot write"),
            ("a\0b", "cannot write"),
        ] {
            for done in [check(&path(name)), write(&path(name), b"new")] {
                let message = done.expect_err(name).to_string();
                assert!(message.contains(why), "{name}: {message}");
            }
        }
        assert_eq!(names(folder.path()), ["kept"]);
        assert!(check(Path::new("")).is_err());
    }

    /// Replacing `/dev/null` with a file would break the machine.
    #[cfg(unix)]
    #[test]
    fn devices_are_written_to_as_they_are() {
        check(Path::new("/dev/null")).expect("a device");
        write(Path::new("/dev/null"), b"text").expect("a device");
        let found = Path::new("/dev/null").metadata().expect("the device");
        assert!(!found.is_file());
    }
}
