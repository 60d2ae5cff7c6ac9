//! File reading: everything a scene refers to is read through here.
//!
//! Only regular files are read, up to their size when they were opened: a pipe or a device may never end, and opening a
//! pipe without a writer would block forever.

use crate::budget::{Budget, OverBudget};
use std::fs::{File, Metadata};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Why a file cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FileProblem {
    /// There is no such file.
    #[error("there is no such file")]
    Missing,
    /// It is a folder.
    #[error("this is a folder")]
    Folder,
    /// It is a pipe, a device or a socket.
    #[error("this is not a regular file")]
    NotRegular,
    /// It is a placeholder, as in a repository cloned without its large files.
    #[error("this is a Git LFS pointer; run `git lfs pull` for the file it stands for")]
    LfsPointer,
    /// It is outside the only folder that may be read.
    #[error("files are read only within `{}` (--files-within)", .0.display())]
    Outside(
        /// The folder.
        PathBuf,
    ),
    /// It is larger than its reader accepts.
    #[error("it is larger than {} MiB", .0 >> 20)]
    TooLarge(
        /// The limit in bytes.
        u64,
    ),
    /// It exceeds the memory budget.
    #[error("it {0}")]
    OverBudget(#[from] OverBudget),
    /// It is there, or may be, and reading it failed, in the operating system's words: a disk, a network or a permission
    /// that another machine may not lack.
    #[error("{0}")]
    Failed(String),
    /// Another error, in words.
    #[error("{0}")]
    Other(String),
}

impl FileProblem {
    /// Returns `true` if the same file might be read elsewhere or later: nothing is wrong with the scene.
    pub fn is_failure(&self) -> bool {
        matches!(self, FileProblem::Failed(_))
    }
}

/// Why a file gives nothing, in a sentence.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct FileError {
    message: String,
    /// `true` if the same file might be read elsewhere or later: nothing is wrong with the scene.
    pub is_failure: bool,
}

impl FileError {
    /// Says more, such as which file it is.
    pub fn said(self, say: impl FnOnce(&str) -> String) -> FileError {
        FileError {
            message: say(&self.message),
            ..self
        }
    }
}

impl From<FileProblem> for FileError {
    fn from(problem: FileProblem) -> FileError {
        FileError {
            message: problem.to_string(),
            is_failure: problem.is_failure(),
        }
    }
}

impl From<String> for FileError {
    /// Something is wrong with its contents.
    fn from(message: String) -> FileError {
        FileError {
            message,
            is_failure: false,
        }
    }
}

impl From<std::io::Error> for FileProblem {
    /// The most common error in our own words, the same on every system.
    fn from(error: std::io::Error) -> FileProblem {
        use std::io::ErrorKind::{InvalidFilename, NotADirectory, NotFound};
        match error.kind() {
            NotFound => FileProblem::Missing,
            NotADirectory | InvalidFilename => FileProblem::Other(error.to_string()),
            // Not from the operating system: a name that no file can have.
            _ if error.raw_os_error().is_none() => FileProblem::Other(error.to_string()),
            _ => FileProblem::Failed(error.to_string()),
        }
    }
}

/// All bytes of the regular file at `path`, at most `most`.
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>, FileProblem> {
    let metadata = regular(path)?;
    if metadata.len() > most {
        return Err(FileProblem::TooLarge(most));
    }
    read_regular(path, &metadata)
}

/// The first bytes of the regular file at `path`, at most `most`.
pub fn read_start(path: &Path, most: u64) -> Result<Vec<u8>, FileProblem> {
    regular(path)?;
    let mut bytes = Vec::new();
    File::open(path)?.take(most).read_to_end(&mut bytes)?;
    if is_lfs_pointer(&bytes) {
        return Err(FileProblem::LfsPointer);
    }
    Ok(bytes)
}

/// All bytes of the regular file at `path`, unless they exceed what is left of `budget`. They are not charged; what is
/// made of them is.
pub fn read_within(path: &Path, budget: &Budget) -> Result<Vec<u8>, FileProblem> {
    let metadata = regular(path)?;
    let _held = budget.hold(metadata.len())?;
    read_regular(path, &metadata)
}

fn regular(path: &Path) -> Result<Metadata, FileProblem> {
    // Checked before opening: opening a pipe waits for its other end.
    let metadata = std::fs::metadata(path)?;
    if metadata.is_dir() {
        return Err(FileProblem::Folder);
    }
    if !metadata.is_file() {
        return Err(FileProblem::NotRegular);
    }
    Ok(metadata)
}

fn read_regular(path: &Path, metadata: &Metadata) -> Result<Vec<u8>, FileProblem> {
    // A file that grows meanwhile is read up to its previous size. Reading from the `File` itself keeps its size hint,
    // so that the buffer is allocated once.
    let mut bytes = Vec::new();
    File::open(path)?
        .take(metadata.len())
        .read_to_end(&mut bytes)?;
    if is_lfs_pointer(&bytes) {
        return Err(FileProblem::LfsPointer);
    }
    Ok(bytes)
}

/// All bytes of a stream, at most `most`; for standard input.
pub fn read_stream(from: impl Read, most: u64) -> Result<Vec<u8>, FileProblem> {
    let mut bytes = Vec::new();
    from.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(FileProblem::TooLarge(most));
    }
    Ok(bytes)
}

/// Returns `true` for a Git LFS pointer, the placeholder for a large file. Pointers start with their version and are
/// shorter than 1024 bytes (Git LFS specification; hawser is its first name).
fn is_lfs_pointer(bytes: &[u8]) -> bool {
    let names: [&[u8]; 2] = [
        b"version https://git-lfs.github.com/spec/",
        b"version https://hawser.github.com/spec/",
    ];
    bytes.len() < 1024 && names.iter().any(|name| bytes.starts_with(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regular_files_are_read_whole_and_within_bounds() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a");
        std::fs::write(&path, "twelve bytes").expect("a file");
        assert_eq!(read(&path, 12).as_deref(), Ok(&b"twelve bytes"[..]));
        assert_eq!(read(&path, 11), Err(FileProblem::TooLarge(11)));
        assert!(read_within(&path, &Budget::new(Some(12))).is_ok());
        let short = Budget::new(Some(11));
        let refused = read_within(&path, &short);
        assert!(matches!(refused, Err(FileProblem::OverBudget(_))));
        assert_eq!(short.left(), 11);
        assert_eq!(read(folder.path(), 12), Err(FileProblem::Folder));
        let missing = read(&folder.path().join("b"), 12);
        assert_eq!(missing, Err(FileProblem::Missing));
        #[cfg(unix)]
        assert_eq!(
            read(Path::new("/dev/zero"), 12),
            Err(FileProblem::NotRegular)
        );
    }

    #[test]
    fn streams_are_read_to_their_end_or_limit() {
        assert_eq!(read_stream(&b"abc"[..], 3).as_deref(), Ok(&b"abc"[..]));
        assert_eq!(
            read_stream(std::io::repeat(0), 3),
            Err(FileProblem::TooLarge(3))
        );
    }

    #[test]
    fn pointers_are_told_from_files() {
        let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:ab\nsize 12345\n";
        assert!(is_lfs_pointer(pointer.as_bytes()));
        assert!(!is_lfs_pointer(&pointer.as_bytes()[1..]));
        assert!(!is_lfs_pointer(pointer.repeat(20).as_bytes()));
    }
}
