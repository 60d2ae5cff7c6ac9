//! Scene files in memory, and locations in them.
//!
//! A file is read once, completely, and never copied; the parser shares it through an `Rc`. Once a file has been parsed
//! its bytes are released, and read again from disk if a message needs an excerpt. Lines and columns are only counted
//! when a message is printed.

use super::files::{SearchFolder, lies_in};
use crate::files::{self, FileProblem};
use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::fs::File;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// A file of a [`SourceMap`]. A file included twice has two ids, one per inclusion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FileId(pub u32);

impl FileId {
    /// A location in this file.
    pub(crate) fn span(self, bytes: Range<u32>) -> Span {
        Span {
            file: self,
            start: bytes.start,
            end: bytes.end,
        }
    }
}

/// A location: the bytes `start..end` of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Span {
    /// The file.
    pub file: FileId,
    /// First byte.
    pub start: u32,
    /// One past the last byte; equal to `start` for a point such as the end of a file.
    pub end: u32,
}

impl Span {
    /// The span from the start of `self` to the end of `other`, or `self` alone if the two are in different files.
    pub fn to(self, other: Span) -> Span {
        if self.file == other.file && other.end >= self.start {
            Span {
                end: other.end,
                ..self
            }
        } else {
            self
        }
    }
}

/// Line and column, both counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Location {
    /// Lines end at LF.
    pub line: usize,
    /// In characters; bytes that are not UTF-8 count as in a lossy conversion.
    pub column: usize,
}

/// Why a file could not be opened.
#[derive(Debug, thiserror::Error)]
#[error("cannot read `{}`: {problem}{}", path.display(), advice(problem))]
pub struct SourceError {
    /// The path that was requested.
    pub path: PathBuf,
    /// The problem.
    pub problem: FileProblem,
}

fn advice(problem: &FileProblem) -> &'static str {
    match problem {
        FileProblem::TooLarge(_) => "; split it and `Include` the parts",
        _ => "",
    }
}

/// Maximum file size in bytes: offsets are `u32`.
const LARGEST: u64 = u32::MAX as u64;

/// Maximum size of a scene from a pipe, in bytes. Whether it ends is only known when it has.
const LARGEST_STREAM: u64 = 1 << 30;

#[derive(Debug)]
struct SourceFile {
    path: PathBuf,
    bytes: Option<Rc<Vec<u8>>>,
    length: usize,
    /// `true` if it can be read again from `path`.
    on_disk: bool,
    included_at: Option<Span>,
}

/// All files opened so far, in order.
#[derive(Debug, Default)]
pub struct SourceMap {
    /// See [`SourceMap::within`].
    within: Option<PathBuf>,
    files: RefCell<Vec<SourceFile>>,
    /// See [`SourceMap::named_files`].
    found: Rc<RefCell<BTreeSet<(String, PathBuf)>>>,
    /// The last file read again for an excerpt: messages about one file tend to be adjacent.
    reread: RefCell<Option<(FileId, Rc<Vec<u8>>)>>,
    /// The last location whose line was counted: file, start of the line, number of line breaks before it.
    counted: Cell<Option<(FileId, usize, usize)>>,
}

impl SourceMap {
    /// An empty map.
    pub fn new() -> Self {
        Self::default()
    }

    /// An empty map for scenes that may refer to files in `folder` only (`--files-within`), including its subfolders.
    /// The main scene itself, which the user names, may be anywhere.
    ///
    /// # Errors
    /// Fails if there is no such folder.
    pub fn within(folder: &Path) -> Result<SourceMap, FileProblem> {
        let folder = folder.canonicalize()?;
        if !folder.is_dir() {
            return Err(FileProblem::Other("this is no folder".to_string()));
        }
        Ok(SourceMap {
            within: Some(folder),
            ..SourceMap::default()
        })
    }

    /// Opens the main scene file. A pipe is read to its end if the program inherited it, as from `<(command)`.
    pub fn open(&self, path: &Path) -> Result<FileId, SourceError> {
        if let Some(within) = &self.within
            && leaves_by_link(path, within)
        {
            return at(path, Err(FileProblem::Outside(within.clone())));
        }
        if is_inherited_pipe(path) {
            let file = File::open(path).map_err(FileProblem::from);
            let bytes = file.and_then(|file| files::read_stream(file, LARGEST_STREAM));
            return Ok(self.add(path.to_owned(), at(path, bytes)?, false, None));
        }
        Ok(self.add(path.to_owned(), read(path)?, true, None))
    }

    /// Opens the file named by an `Include` at `included_at`.
    pub fn include(&self, path: &Path, included_at: Span) -> Result<FileId, SourceError> {
        Ok(self.add(path.to_owned(), read(path)?, true, Some(included_at)))
    }

    /// Reads all of standard input; messages call it `<stdin>`.
    pub fn open_stdin(&self) -> Result<FileId, SourceError> {
        let path = PathBuf::from("<stdin>");
        let bytes = files::read_stream(std::io::stdin().lock(), LARGEST_STREAM);
        let bytes = at(&path, bytes)?;
        Ok(self.add(path, bytes, false, None))
    }

    /// Adds a text that is already in memory; messages call it `name`. A text beyond 4 GiB is truncated.
    pub fn add_text(&self, name: &str, text: impl Into<Vec<u8>>) -> FileId {
        let mut bytes = text.into();
        bytes.truncate(LARGEST as usize);
        self.add(PathBuf::from(name), bytes, false, None)
    }

    fn add(
        &self,
        path: PathBuf,
        bytes: Vec<u8>,
        on_disk: bool,
        included_at: Option<Span>,
    ) -> FileId {
        let mut files = self.files.borrow_mut();
        let id = FileId(files.len() as u32);
        let length = bytes.len();
        files.push(SourceFile {
            path,
            bytes: Some(Rc::new(bytes)),
            length,
            on_disk,
            included_at,
        });
        id
    }

    /// The path by which a file was opened.
    pub fn path(&self, file: FileId) -> PathBuf {
        let files = self.files.borrow();
        let source = files.get(file.0 as usize);
        source.map(|source| source.path.clone()).unwrap_or_default()
    }

    /// The folder of a file: where `Include` and file-valued parameters are looked up.
    pub fn search_folder(&self, file: FileId) -> SearchFolder {
        let path = self.path(file);
        SearchFolder {
            directory: path.parent().map(Path::to_owned).unwrap_or_default(),
            within: self.within.clone(),
            found: Rc::clone(&self.found),
        }
    }

    /// The files that the scene has named, by those names.
    pub fn named_files(&self) -> BTreeSet<(String, PathBuf)> {
        self.found.borrow().clone()
    }

    /// The files that were read from disk, and those that the scene has named: sorted, each once.
    pub fn files_read(&self) -> Vec<PathBuf> {
        let files = self.files.borrow();
        let opened = files.iter().filter(|file| file.on_disk);
        let opened = opened.map(|file| file.path.clone());
        let named = self.named_files().into_iter().map(|(_, path)| path);
        let all: BTreeSet<PathBuf> = opened.chain(named).collect();
        all.into_iter().collect()
    }

    /// Returns `true` if a file was read from disk, and not from a pipe or from memory.
    pub fn is_on_disk(&self, file: FileId) -> bool {
        let files = self.files.borrow();
        let source = files.get(file.0 as usize);
        source.is_some_and(|source| source.on_disk)
    }

    /// The `Include` that brought a file in; `None` for a main file.
    pub fn included_at(&self, file: FileId) -> Option<Span> {
        self.files.borrow().get(file.0 as usize)?.included_at
    }

    /// A file's bytes, read again if they had been released. `None` if the file can no longer be read or has changed
    /// its length since.
    pub fn bytes(&self, file: FileId) -> Option<Rc<Vec<u8>>> {
        let files = self.files.borrow();
        let source = files.get(file.0 as usize)?;
        if let Some(bytes) = &source.bytes {
            return Some(Rc::clone(bytes));
        }
        let mut reread = self.reread.borrow_mut();
        if let Some((last, bytes)) = reread.as_ref()
            && *last == file
        {
            return Some(Rc::clone(bytes));
        }
        let bytes = read(&source.path).ok();
        let bytes = Rc::new(bytes.filter(|bytes| bytes.len() == source.length)?);
        *reread = Some((file, Rc::clone(&bytes)));
        Some(bytes)
    }

    /// Releases the bytes of a file if they can be read again.
    pub(super) fn release(&self, file: FileId) {
        if let Some(source) = self.files.borrow_mut().get_mut(file.0 as usize)
            && source.on_disk
        {
            source.bytes = None;
        }
    }

    /// Line and column of the start of a span; `None` if the file's bytes are no longer available.
    pub fn locate(&self, span: Span) -> Option<Location> {
        let bytes = self.bytes(span.file)?;
        let before = bytes.get(..span.start as usize)?;
        let line_start = before
            .iter()
            .rposition(|&b| b == b'\n')
            .map_or(0, |at| at + 1);
        // Messages mostly come in file order: continue counting from the last one.
        let (from, counted) = match self.counted.get() {
            Some((file, start, lines)) if file == span.file && start <= line_start => {
                (start, lines)
            }
            _ => (0, 0),
        };
        let breaks = before[from..line_start].iter().filter(|&&b| b == b'\n');
        let lines = counted + breaks.count();
        self.counted.set(Some((span.file, line_start, lines)));
        let left = String::from_utf8_lossy(&before[line_start..]);
        Some(Location {
            line: lines + 1,
            column: left.chars().count() + 1,
        })
    }
}

/// Returns `true` if `path` is in the folder `within` by its name, and elsewhere by a link.
fn leaves_by_link(path: &Path, within: &Path) -> bool {
    let target = path.canonicalize();
    lies_in(path, within) && target.is_ok_and(|target| !target.starts_with(within))
}

fn read(path: &Path) -> Result<Vec<u8>, SourceError> {
    at(path, files::read(path, LARGEST))
}

fn at<T>(path: &Path, read: Result<T, FileProblem>) -> Result<T, SourceError> {
    read.map_err(|problem| SourceError {
        path: path.to_owned(),
        problem,
    })
}

/// Returns `true` if this is a pipe among the files inherited by the program, which has a writer.
#[cfg(unix)]
fn is_inherited_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    let inherited = ["/dev/fd", "/proc/self/fd", "/dev/stdin"];
    inherited.iter().any(|folder| path.starts_with(folder))
        && std::fs::metadata(path).is_ok_and(|metadata| metadata.file_type().is_fifo())
}

/// Other systems have no such files.
#[cfg(not(unix))]
fn is_inherited_pipe(_: &Path) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(file: FileId, start: u32) -> Span {
        Span {
            file,
            start,
            end: start,
        }
    }

    #[test]
    fn places_count_from_one_in_lines_and_characters() {
        let sources = SourceMap::new();
        let file = sources.add_text("a", b"ab\n\xc3\xa9\xff!\r\n\nx".to_vec());
        // In any order: counting continues from the last location if possible.
        for (at, line, column) in [
            (0, 1, 1),
            (2, 1, 3),
            (5, 2, 2),
            (6, 2, 3),
            (9, 3, 1),
            (10, 4, 1),
            (11, 4, 2),
            (1, 1, 2),
        ] {
            assert_eq!(
                sources.locate(span(file, at)),
                Some(Location { line, column }),
                "{at}"
            );
        }
        assert_eq!(sources.locate(span(file, 12)), None);
        assert_eq!(sources.locate(span(FileId(7), 0)), None);
    }

    #[test]
    fn a_released_file_is_read_again_unless_it_has_changed() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.pbrt");
        std::fs::write(&path, "Identity").expect("a file");
        let sources = SourceMap::new();
        let (file, text) = (
            sources.open(&path).expect("a file"),
            sources.add_text("b", "kept"),
        );
        sources.release(file);
        sources.release(text);
        assert_eq!(sources.bytes(text).as_deref(), Some(&b"kept".to_vec()));
        std::fs::write(&path, "something else").expect("a file");
        assert_eq!(sources.bytes(file), None);
        std::fs::write(&path, "identity").expect("a file");
        assert_eq!(sources.bytes(file).as_deref(), Some(&b"identity".to_vec()));
    }

    #[test]
    fn files_that_are_read_are_listed_once() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let [a, b] = ["a.pbrt", "b.pbrt"].map(|name| folder.path().join(name));
        for path in [&a, &b] {
            std::fs::write(path, "Identity").expect("a file");
        }
        let sources = SourceMap::new();
        let main = sources.open(&b).expect("a file");
        for path in [&a, &b, &a] {
            sources.include(path, span(main, 0)).expect("a file");
        }
        assert_eq!(sources.files_read(), [a, b]);
    }

    /// The file has a length but no contents on disk, so this costs nothing.
    #[test]
    fn more_than_4_gib_is_refused_before_it_is_read() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("huge.pbrt");
        File::create(&path)
            .and_then(|file| file.set_len(LARGEST + 1))
            .expect("a sparse file");
        let sources = SourceMap::new();
        let problem =
            |taken: Result<FileId, SourceError>| taken.expect_err("none of these").problem;
        let too_large = FileProblem::TooLarge(LARGEST);
        assert_eq!(problem(sources.open(&path)), too_large);
        let at = span(FileId(0), 0);
        assert_eq!(problem(sources.include(&path, at)), too_large);
        assert_eq!(problem(sources.open(folder.path())), FileProblem::Folder);
        let missing = problem(sources.open(Path::new("/none")));
        assert_eq!(missing, FileProblem::Missing);
    }
}
