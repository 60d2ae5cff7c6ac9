//! Reading files: the one way by which a scene, and all that it names, comes in.
//!
//! Only regular files are read, and no more of them than they have when they are opened: a pipe or
//! a device may never end, and opening a pipe that nobody writes to would wait for ever.

use crate::budget::{Budget, OverBudget};
use std::fs::{File, Metadata};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Why a file cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FileProblem {
    /// Nothing is there.
    #[error("there is no such file")]
    Missing,
    /// A folder is there.
    #[error("this is a folder")]
    Folder,
    /// A pipe, a device or a socket is there.
    #[error("this is not a regular file")]
    NotRegular,
    /// A repository was cloned without the large files in it.
    #[error("this is a Git LFS pointer; run `git lfs pull` for the file it stands for")]
    LfsPointer,
    /// Elsewhere, and only one folder may be read.
    #[error("files are read only within `{}` (--files-within)", .0.display())]
    Outside(
        /// The folder.
        PathBuf,
    ),
    /// Beyond what its reader takes.
    #[error("it is larger than {} MiB", .0 >> 20)]
    TooLarge(
        /// The limit in bytes.
        u64,
    ),
    /// There is not enough memory for it.
    #[error("it {0}")]
    OverBudget(#[from] OverBudget),
    /// What the operating system said.
    #[error("{0}")]
    Other(String),
}

impl From<std::io::Error> for FileProblem {
    /// The commonest problem in words of our own, the same on every system.
    fn from(error: std::io::Error) -> FileProblem {
        match error.kind() {
            std::io::ErrorKind::NotFound => FileProblem::Missing,
            _ => FileProblem::Other(error.to_string()),
        }
    }
}

/// All bytes of the regular file at `path`, which may have `most` of them.
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>, FileProblem> {
    let metadata = regular(path)?;
    if metadata.len() > most {
        return Err(FileProblem::TooLarge(most));
    }
    read_regular(path, &metadata)
}

/// All bytes of the regular file at `path`, unless `budget` has not so many left. They are not charged: what is made of
/// them is.
pub fn read_within(path: &Path, budget: &Budget) -> Result<Vec<u8>, FileProblem> {
    let metadata = regular(path)?;
    let _held = budget.hold(metadata.len())?;
    read_regular(path, &metadata)
}

fn regular(path: &Path) -> Result<Metadata, FileProblem> {
    // Asked before it is opened: opening a pipe waits for its other end.
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
    // A file that grows meanwhile is read as far as it was. Reading from the `File` itself keeps its
    // size hint, so that the buffer is allocated once.
    let mut bytes = Vec::new();
    File::open(path)?
        .take(metadata.len())
        .read_to_end(&mut bytes)?;
    if is_lfs_pointer(&bytes) {
        return Err(FileProblem::LfsPointer);
    }
    Ok(bytes)
}

/// All bytes of a stream, which may have `most` of them; for what a person pipes in.
pub fn read_stream(from: impl Read, most: u64) -> Result<Vec<u8>, FileProblem> {
    let mut bytes = Vec::new();
    from.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(FileProblem::TooLarge(most));
    }
    Ok(bytes)
}

/// Is this what Git has in the place of a large file? Pointers begin with their version and are
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
