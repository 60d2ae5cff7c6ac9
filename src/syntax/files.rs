//! File names in a scene: where they lead.

use std::path::{Path, PathBuf};

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
