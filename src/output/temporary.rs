//! Files on their way: without a name where the system supports that, or under a temporary one.

use std::fs::{DirEntry, File};
use std::io::{self, ErrorKind, Seek};
use std::path::Path;
use std::time::Duration;
use tempfile::NamedTempFile;

/// A file that is not seen under its name yet. If it never is, it is removed.
pub(super) enum Temporary {
    /// A file without a name.
    Unnamed(File),
    /// A file with a temporary one.
    Named(NamedTempFile),
}

impl Temporary {
    /// An empty one on the disk of `folder`.
    pub(super) fn new(folder: &Path) -> io::Result<Temporary> {
        match unnamed(folder) {
            Some(file) => Ok(Temporary::Unnamed(file)),
            None => named(folder).map(Temporary::Named),
        }
    }

    pub(super) fn file_mut(&mut self) -> &mut File {
        match self {
            Temporary::Unnamed(file) => file,
            Temporary::Named(file) => file.as_file_mut(),
        }
    }

    /// With those of a file that it will replace.
    pub(super) fn with_permissions_of(mut self, target: &Path) -> io::Result<Temporary> {
        if let Ok(found) = target.metadata() {
            self.file_mut().set_permissions(found.permissions())?;
        }
        Ok(self)
    }

    /// Makes it the file `target` in `folder`.
    pub(super) fn persist(mut self, target: &Path, folder: &Path) -> io::Result<()> {
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

/// Has the disk keep the names in a folder, so that a file that was reported as written survives a loss of power. Not
/// all systems can.
pub(super) fn sync(folder: &Path) {
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

/// Prefix of temporary names.
const PREFIX: &str = ".fstop-";

/// A new file under a temporary name, removed on drop unless it is renamed.
pub(super) fn named(folder: &Path) -> io::Result<NamedTempFile> {
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
pub(super) const ABANDONED: Duration = Duration::from_secs(60);

/// Removes files with temporary names that killed processes have left in a folder.
pub(super) fn clear(folder: &Path) {
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
    use crate::output::tests::names;
    use std::io::Write;

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
}
