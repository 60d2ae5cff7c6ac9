//! Values of options.

use std::ffi::OsString;
use std::path::PathBuf;

/// Parses a file's name, which is not to be taken for an option.
pub(super) fn file_name(name: OsString) -> Result<PathBuf, String> {
    let path = PathBuf::from(name);
    let name = path.display();
    match path.as_os_str().as_encoded_bytes().starts_with(b"-") {
        true => Err(format!(
            "expected a file's name; one that starts with a hyphen is written `./{name}`"
        )),
        false => Ok(path),
    }
}

/// Parses a whole number that is not negative.
pub(super) fn whole(text: &str) -> Result<u64, String> {
    let expected = |_| format!("expected a whole number from 0 to {}", u64::MAX);
    text.parse().map_err(expected)
}

/// Parses a positive count.
pub(super) fn positive(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(0) | Err(_) => Err(format!("expected a whole number from 1 to {}", u32::MAX)),
        Ok(count) => Ok(count),
    }
}
