//! Output files, written atomically: completely or not at all.
//!
//! A file appears under its name only when it is complete. On Linux it has no name until then, so that nothing is left
//! behind however the program ends; elsewhere, and on file systems that do not support that, it is written under a
//! temporary name in the same folder and renamed.

use std::fs::{DirEntry, File, OpenOptions};
use std::io::{self, Cursor, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::NamedTempFile;

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
            OutputError::IsFolder(_) | OutputError::NamesFolder(_) => false,
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
            if unnamed(folder).is_none() {
                named(folder).map_err(|source| io_error(path, source))?;
            }
            Ok(())
        }
    }
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

enum Temporary {
    /// A file without a name.
    Unnamed(File),
    /// A file with a temporary one.
    Named(NamedTempFile),
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
                let file = match unnamed(folder) {
                    Some(file) => Ok(Temporary::Unnamed(file)),
                    None => named(folder).map(Temporary::Named),
                };
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

impl Temporary {
    fn file_mut(&mut self) -> &mut File {
        match self {
            Temporary::Unnamed(file) => file,
            Temporary::Named(file) => file.as_file_mut(),
        }
    }

    /// With those of a file that it will replace.
    fn with_permissions_of(mut self, target: &Path) -> io::Result<Temporary> {
        if let Ok(found) = target.metadata() {
            self.file_mut().set_permissions(found.permissions())?;
        }
        Ok(self)
    }

    /// Makes it the file `target` in `folder`.
    fn persist(mut self, target: &Path, folder: &Path) -> io::Result<()> {
        self.file_mut().sync_all()?;
        match self {
            Temporary::Unnamed(file) => match link(&file, target, folder) {
                Ok(()) => {}
                Err(_) => return copy(file, target, folder),
            },
            Temporary::Named(file) => {
                file.persist(target).map_err(|e| e.error)?;
            }
        }
        sync(folder);
        Ok(())
    }
}

/// Makes a file that cannot get a name the file `target` in `folder`.
fn copy(mut file: File, target: &Path, folder: &Path) -> io::Result<()> {
    let mut copy = Temporary::Named(named(folder)?).with_permissions_of(target)?;
    file.rewind()?;
    io::copy(&mut file, copy.file_mut())?;
    copy.persist(target, folder)
}

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

/// Has the disk keep the names in a folder, so that a file that was reported as written survives a loss of power. Not
/// all systems can.
fn sync(folder: &Path) {
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

/// Prefix of temporary names.
const PREFIX: &str = ".fstop-";

/// A new file under a temporary name, removed on drop unless it is renamed.
fn named(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX);
    // Temporary files are private by default; an image is an ordinary file, subject to umask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    // Strips the temporary name, which `tempfile` adds to the error.
    let file = builder
        .tempfile_in(folder)
        .map_err(|error| io::Error::from(error.kind()))?;
    // Shows others that it is in use; not all file systems can.
    let _ = file.as_file().lock();
    Ok(file)
}

/// A file with a temporary name that is older than this, and that no process has locked, is nobody's.
const ABANDONED: Duration = Duration::from_secs(60);

/// Removes files with temporary names that killed processes have left in a folder.
fn clear(folder: &Path) {
    let is_ours = |entry: &DirEntry| {
        let name = entry.file_name();
        name.as_encoded_bytes().starts_with(PREFIX.as_bytes())
    };
    let is_abandoned = |path: &Path| {
        let age = { path.symlink_metadata() }.and_then(|found| found.modified());
        let is_old = age.is_ok_and(|at| at.elapsed().is_ok_and(|age| age > ABANDONED));
        is_old && File::open(path).is_ok_and(|file| file.try_lock().is_ok())
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let ours = entries.filter(is_ours).map(|entry| entry.path());
    for path in ours.filter(|path| is_abandoned(path)) {
        // A folder that lets nothing go is no reason not to write another file.
        let _ = std::fs::remove_file(path);
    }
}

/// A new file without a name, if the file system supports that.
#[cfg(target_os = "linux")]
fn unnamed(folder: &Path) -> Option<File> {
    use rustix::fs::{Mode, OFlags, open};
    let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
    open(folder, flags, Mode::from_raw_mode(0o666))
        .ok()
        .map(File::from)
}

#[cfg(not(target_os = "linux"))]
fn unnamed(_folder: &Path) -> Option<File> {
    None
}

/// Links a file without a name to the name of `target`.
#[cfg(target_os = "linux")]
fn link(file: &File, target: &Path, folder: &Path) -> io::Result<()> {
    use rustix::fs::{AtFlags, CWD, linkat};
    use std::os::fd::AsRawFd;
    let from = format!("/proc/self/fd/{}", file.as_raw_fd());
    let link = |name: &Path| {
        linkat(CWD, from.as_str(), CWD, name, AtFlags::SYMLINK_FOLLOW).map_err(io::Error::from)
    };
    match link(target) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            // No system call links over an existing file: for an instant it has a temporary name.
            let mut builder = tempfile::Builder::new();
            let beside = builder.prefix(PREFIX).make_in(folder, link)?;
            let renamed = beside.into_temp_path().persist(target);
            renamed.map_err(|e| e.error)
        }
        linked => linked,
    }
}

#[cfg(not(target_os = "linux"))]
fn link(_file: &File, _target: &Path, _folder: &Path) -> io::Result<()> {
    Err(ErrorKind::Unsupported.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
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

    /// On file systems that support files without names: nothing can be left behind.
    #[cfg(target_os = "linux")]
    #[test]
    fn nothing_is_seen_of_a_file_until_it_is_whole() {
        let folder = tempfile::tempdir().expect("a folder");
        for before in [vec![], vec!["a"]] {
            let Some(mut file) = unnamed(folder.path()) else {
                println!("skipped: this file system has no files without names");
                return;
            };
            file.write_all(b"half").expect("a writable folder");
            assert_eq!(names(folder.path()), before);
            link(&file, &folder.path().join("a"), folder.path()).expect("a link");
            assert_eq!(names(folder.path()), ["a"]);
        }
    }

    #[test]
    fn file_systems_without_nameless_files_do_as_well() {
        let folder = tempfile::tempdir().expect("a folder");
        let target = folder.path().join("a");
        for bytes in ["whole", "another"] {
            let file = named(folder.path()).map(Temporary::Named);
            let mut file = file.expect("a writable folder");
            file.file_mut().write_all(bytes.as_bytes()).expect("room");
            file.persist(&target, folder.path()).expect("a name");
            assert_eq!(std::fs::read_to_string(&target).expect("the file"), bytes);
            assert_eq!(names(folder.path()), ["a"]);
        }
        drop(named(folder.path()).expect("a writable folder"));
        assert_eq!(names(folder.path()), ["a"]);
    }

    /// As where `/proc` is not there: no system call names a file by its number alone.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_that_cannot_be_linked_is_copied() {
        let folder = tempfile::tempdir().expect("a folder");
        let Some(mut file) = unnamed(folder.path()) else {
            println!("skipped: this file system has no files without names");
            return;
        };
        file.write_all(b"whole").expect("a writable folder");
        let target = folder.path().join("a");
        copy(file, &target, folder.path()).expect("a copy");
        assert_eq!(std::fs::read(&target).expect("the file"), b"whole");
        assert_eq!(names(folder.path()), ["a"]);
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
