//! Resolution of file names in a scene.

use crate::files::FileProblem;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;

/// The folder in which the file names of a scene are looked up.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SearchFolder {
    /// The folder they are relative to.
    pub directory: PathBuf,
    /// The only folder, absolute and without links, that files may be in (`--files-within`).
    pub within: Option<PathBuf>,
    /// What was found, by the name that the scene gives it.
    pub(super) found: Rc<RefCell<BTreeSet<(String, PathBuf)>>>,
}

impl SearchFolder {
    /// Looks names up relative to `directory`; absolute names and `..` may lead anywhere.
    pub fn new(directory: impl Into<PathBuf>) -> SearchFolder {
        SearchFolder {
            directory: directory.into(),
            ..SearchFolder::default()
        }
    }

    /// The regular file called `name`, by the rules of [`SearchFolder::resolve`].
    pub fn regular(&self, name: &str) -> Result<PathBuf, FileProblem> {
        if let Some(path) = self.resolve(name)? {
            return if path.is_file() {
                Ok(path)
            } else {
                Err(FileProblem::NotRegular)
            };
        }
        let path = self.directory.join(name);
        if let Err(error) = path.metadata() {
            // A server that does not answer, a folder that may not be entered.
            let problem = FileProblem::from(error);
            if problem.is_failure() {
                return Err(problem);
            }
        }
        let is_folder = |name: &str| self.directory.join(name).is_dir();
        Err(if is_folder(name) || is_folder(&slashed(name)) {
            FileProblem::Folder
        } else {
            FileProblem::Missing
        })
    }

    /// The path of the file called `name`, or `None` if there is none. Absolute names are used as they are. Scenes
    /// written on Windows separate folders with backslashes, which may have been taken for escapes (`\t`, `\n`): if the
    /// name as read does not exist, it is tried with slashes.
    ///
    /// # Errors
    /// [`FileProblem::Outside`] if the name, or a link on the way, leaves the only folder that may be read. If the name
    /// itself leaves it, the file system is not accessed.
    pub fn resolve(&self, name: &str) -> Result<Option<PathBuf>, FileProblem> {
        let path = match self.find(name)? {
            None => self.find(&slashed(name))?,
            found => found,
        };
        if let Some(path) = &path {
            let mut found = self.found.borrow_mut();
            found.insert((name.to_owned(), path.clone()));
        }
        Ok(path)
    }

    fn find(&self, name: &str) -> Result<Option<PathBuf>, FileProblem> {
        let path = self.directory.join(name);
        let Some(within) = &self.within else {
            return Ok(Some(path).filter(|path| is_there(path)));
        };
        let outside = || FileProblem::Outside(within.clone());
        let plain = |path: &Path| {
            // The working directory is an empty path here.
            let path = std::path::absolute(Path::new(".").join(path));
            path.map(|path| without_detours(&path))
        };
        let (plain, start) = (plain(&path)?, plain(&self.directory)?);
        // A folder may be reached through a link: paths that start at the scene's folder are resolved from there.
        if !plain.starts_with(within) && !plain.starts_with(start) {
            return Err(outside());
        }
        match path.canonicalize() {
            Ok(path) if path.starts_with(within) => Ok(Some(path).filter(|path| is_there(path))),
            Ok(_) => Err(outside()),
            Err(_) => Ok(None),
        }
    }

    /// Checks that a file may be written at `path`, judging by its folder.
    ///
    /// # Errors
    /// [`FileProblem::Outside`] if it is outside the only folder.
    pub fn admits_output(&self, path: &Path) -> Result<(), FileProblem> {
        let Some(within) = &self.within else {
            return Ok(());
        };
        // A link in place of the file is followed when it is written.
        let target = path.canonicalize().ok();
        match lies_in(path, within) && target.is_none_or(|target| target.starts_with(within)) {
            true => Ok(()),
            false => Err(FileProblem::Outside(within.clone())),
        }
    }
}

/// Returns `true` if the folder of `path` is in `within`, whatever `path` itself leads to.
pub(super) fn lies_in(path: &Path, within: &Path) -> bool {
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new(".")).canonicalize();
    folder.is_ok_and(|folder| folder.starts_with(within))
}

/// An absolute path with `.` and `..` components resolved lexically.
fn without_detours(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => drop(plain.pop()),
            part => plain.push(part),
        }
    }
    plain
}

/// Returns `true` if `path` can be read: a file, or a device or pipe that acts as one.
fn is_there(path: &Path) -> bool {
    path.metadata().is_ok_and(|metadata| !metadata.is_dir())
}

fn slashed(name: &str) -> String {
    let mut path = String::with_capacity(name.len() + 1);
    for letter in name.chars() {
        match letter {
            '\\' => path.push('/'),
            '\x08' => path.push_str("/b"),
            '\x0c' => path.push_str("/f"),
            '\n' => path.push_str("/n"),
            '\r' => path.push_str("/r"),
            '\t' => path.push_str("/t"),
            other => path.push(other),
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_paths_lead_to_the_same_file() {
        assert_eq!(slashed("a\\b.png"), "a/b.png");
        assert_eq!(slashed("maps\new\tiles.png"), "maps/new/tiles.png");
    }

    #[test]
    fn only_regular_files_are_read() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::create_dir(folder.path().join("maps")).expect("a folder");
        std::fs::write(folder.path().join("maps/a.png"), "").expect("a file");
        let search = SearchFolder::new(folder.path());
        let found = |name| search.regular(name);
        assert!(found("maps/a.png").is_ok());
        assert!(found("maps\\a.png").is_ok());
        assert_eq!(found("maps"), Err(FileProblem::Folder));
        assert_eq!(found(""), Err(FileProblem::Folder));
        assert_eq!(found("maps/b.png"), Err(FileProblem::Missing));
        #[cfg(unix)]
        assert_eq!(found("/dev/null"), Err(FileProblem::NotRegular));
    }

    #[test]
    fn the_name_as_written_comes_first() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        std::fs::create_dir(path("maps")).expect("a folder");
        std::fs::write(path("maps/wood.png"), "").expect("a file");
        let search = SearchFolder::new(folder.path());
        let wood = Ok(Some(path("maps/wood.png")));
        assert_eq!(search.resolve("maps\\wood.png"), wood);
        assert_eq!(search.resolve("maps/wood.png"), wood);
        assert_eq!(search.resolve("maps/brick.png"), Ok(None));
        let absolute = path("maps/wood.png");
        let elsewhere = SearchFolder::new("/elsewhere");
        assert_eq!(elsewhere.resolve(&absolute.to_string_lossy()), wood);
    }

    #[test]
    #[cfg(unix)]
    fn one_folder_is_not_left() {
        let base = tempfile::tempdir().expect("a temporary folder");
        let base = base.path().canonicalize().expect("a folder");
        let path = |name: &str| base.join(name);
        std::fs::create_dir_all(path("scene/maps")).expect("a folder");
        for name in ["secret", "scene/a.png", "scene/maps/b.png"] {
            std::fs::write(path(name), "").expect("a file");
        }
        let link = |to: &str, from: &str| {
            std::os::unix::fs::symlink(path(to), path(from)).expect("a link");
        };
        link("secret", "scene/out");
        link("", "scene/up");
        link("scene/maps", "scene/in");
        link("scene", "door");
        for start in ["scene", "scene/maps/..", "door"] {
            let search = SearchFolder {
                directory: path(start),
                within: Some(path("scene")),
                ..SearchFolder::default()
            };
            let outside = Err(FileProblem::Outside(path("scene")));
            for name in [
                "../secret",
                "maps/../../secret",
                "..\\secret",
                "../no such file",
                "out",
                "up/secret",
                "/etc/passwd",
                "/no such file",
            ] {
                assert_eq!(search.regular(name), outside, "{start} {name}");
            }
            for (name, file) in [
                ("a.png", "scene/a.png"),
                ("maps/../a.png", "scene/a.png"),
                ("maps\\b.png", "scene/maps/b.png"),
                ("in/b.png", "scene/maps/b.png"),
            ] {
                assert_eq!(search.regular(name), Ok(path(file)), "{start} {name}");
            }
            let whole = path("scene/a.png");
            assert_eq!(search.regular(&whole.to_string_lossy()), Ok(whole));
            assert_eq!(search.regular("c.png"), Err(FileProblem::Missing));
            for (name, may) in [
                ("scene/new.exr", true),
                ("scene/in/new.exr", true),
                ("scene/out", false),
                ("scene/up/new.exr", false),
                ("new.exr", false),
                ("scene/no such folder/new.exr", false),
            ] {
                assert_eq!(search.admits_output(&path(name)).is_ok(), may, "{name}");
            }
        }
    }
}
