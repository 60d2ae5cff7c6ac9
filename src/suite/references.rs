//! References, and whether they still are what was accepted.

use crate::files::{self, FileError, FileProblem};
use crate::output::{self, OutputError};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The name of the file of hashes in the folder of references. Its form is that of `sha256sum`, which checks it.
pub const SUMS: &str = "SHA256SUMS";

/// Hashes of a million references are smaller than this.
const LARGEST: u64 = 1 << 30;

/// The hash of a file, as 64 digits.
///
/// # Errors
/// Fails if it cannot be read.
pub fn hash(path: &Path) -> std::io::Result<String> {
    let (mut file, mut hash) = (std::fs::File::open(path)?, Sha256::new());
    let mut buffer = vec![0; 1 << 16];
    loop {
        let count = file.read(&mut buffer)?;
        if count == 0 {
            return Ok(hash
                .finalize()
                .iter()
                .map(|byte| format!("{byte:02x}"))
                .collect());
        }
        hash.update(buffer.get(..count).unwrap_or_default());
    }
}

/// Returns `true` if this is a hash as [`hash()`] writes it, in either case.
pub fn is_hash(text: &str) -> bool {
    text.len() == 64 && text.bytes().all(|byte| byte.is_ascii_hexdigit())
}

/// The hashes of a folder of references.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sums {
    file: PathBuf,
    /// By name, with `/` between folders.
    sums: BTreeMap<String, String>,
}

impl Sums {
    /// Those of a folder; none where the file is missing.
    ///
    /// # Errors
    /// A file that cannot be read, or a line that is none of `sha256sum`.
    pub fn read(folder: &Path) -> Result<Sums, FileError> {
        let file = folder.join(SUMS);
        let unreadable = |why: &str| format!("{}: cannot read: {why}", file.display());
        let bytes = match files::read(&file, LARGEST) {
            Err(FileProblem::Missing) => Vec::new(),
            read => read.map_err(|problem| FileError::from(problem).said(unreadable))?,
        };
        let text = String::from_utf8(bytes).map_err(|_| unreadable("it is not UTF-8 text"))?;
        let mut sums = BTreeMap::new();
        for (number, line) in (1..)
            .zip(text.lines())
            .filter(|(_, line)| !line.trim().is_empty())
        {
            let parts = line.split_once(' ').filter(|(sum, _)| is_hash(sum));
            let name = parts.map(|(_, name)| name.trim_start_matches([' ', '*']));
            let Some((sum, name)) = parts.map(|(sum, _)| sum).zip(name) else {
                let place = file.display();
                return Err(
                    format!("{place}:{number}: expected a SHA-256 and a file's name").into(),
                );
            };
            sums.insert(name.to_owned(), sum.to_ascii_lowercase());
        }
        Ok(Sums { file, sums })
    }

    /// The hash that was accepted.
    pub fn of(&self, name: &str) -> Option<&str> {
        self.sums.get(name).map(String::as_str)
    }

    /// All names.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.sums.keys().map(String::as_str)
    }

    /// Accepts a file, and writes the hashes.
    ///
    /// # Errors
    /// Fails if they cannot be written.
    pub fn accept(&mut self, name: &str, sum: String) -> Result<(), OutputError> {
        self.sums.insert(name.to_owned(), sum);
        self.write()
    }

    /// Forgets a file, and writes the hashes.
    ///
    /// # Errors
    /// Fails if they cannot be written.
    pub fn forget(&mut self, name: &str) -> Result<(), OutputError> {
        self.sums.remove(name);
        self.write()
    }

    fn write(&self) -> Result<(), OutputError> {
        let lines = self
            .sums
            .iter()
            .map(|(name, sum)| format!("{sum}  {name}\n"));
        output::write(&self.file, lines.collect::<String>().as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_sha256sum() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("abc");
        std::fs::write(&path, "abc").expect("a file");
        let sum = hash(&path).expect("a file");
        // FIPS 180-2, appendix B.1.
        let known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sum, known);
        let mut sums = Sums::read(folder.path()).expect("none");
        sums.accept("a b/c.exr", sum).expect("a writable folder");
        let again = Sums::read(folder.path()).expect("sums");
        assert_eq!(again, sums);
        assert_eq!(again.of("a b/c.exr"), Some(known));
        let file = folder.path().join(SUMS);
        std::fs::write(
            &file,
            format!("{} *x.exr\n\nnonsense\n", known.to_uppercase()),
        )
        .expect("a file");
        let error = Sums::read(folder.path()).expect_err("nonsense");
        assert!(
            { error.to_string() }.ends_with("SHA256SUMS:3: expected a SHA-256 and a file's name"),
            "{error}"
        );
    }
}
