//! File names in a scene: where they lead.

use crate::files::FileProblem;
use std::path::{Path, PathBuf};

/// The regular file that `name` stands for, by the rules of [`resolve`].
pub fn regular(directory: &Path, name: &str) -> Result<PathBuf, FileProblem> {
    if let Some(path) = resolve(directory, name) {
        return if path.is_file() {
            Ok(path)
        } else {
            Err(FileProblem::NotRegular)
        };
    }
    let is_folder = |name: &str| directory.join(name).is_dir();
    Err(if is_folder(name) || is_folder(&slashed(name)) {
        FileProblem::Folder
    } else {
        FileProblem::Missing
    })
}

/// The file that `name` stands for, seen from `directory`, or `None` where there is none.
/// Absolute names stay what they are. Scenes written on Windows spell folders with backslashes,
/// whose first letters may have been taken for escapes (`\t`, `\n`): where the name as read leads
/// nowhere, it is tried with slashes.
pub fn resolve(directory: &Path, name: &str) -> Option<PathBuf> {
    let found = |name: &str| Some(directory.join(name)).filter(|path| is_there(path));
    found(name).or_else(|| found(&slashed(name)))
}

/// Something that can be read: a file, or a device or pipe that acts as one.
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
        let found = |name| regular(folder.path(), name);
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
        assert_eq!(
            resolve(folder.path(), "maps\\wood.png"),
            Some(path("maps/wood.png"))
        );
        assert_eq!(
            resolve(folder.path(), "maps/wood.png"),
            Some(path("maps/wood.png"))
        );
        assert_eq!(resolve(folder.path(), "maps/brick.png"), None);
        let absolute = path("maps/wood.png");
        assert_eq!(
            resolve(Path::new("/elsewhere"), &absolute.to_string_lossy()),
            Some(absolute.clone())
        );
    }
}
