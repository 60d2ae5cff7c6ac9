//! A picture into a file: whole or not at all.

use super::{FilmMetadata, Image, exr, pfm, png};
use image::ImageFormat;
use std::io::Write;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Why a picture could not be written; always names the file.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The name does not end in a format's extension.
    #[error("{}: a picture's name must end in .exr, .pfm, .png or .tga", .0.display())]
    UnknownFormat(PathBuf),
    /// There is a folder of that name.
    #[error("{}: is a folder", .0.display())]
    IsFolder(PathBuf),
    /// The folder it would be in is not there.
    #[error("{}: cannot write: there is no folder `{}`", .path.display(), .folder.display())]
    NoFolder {
        /// The picture's file.
        path: PathBuf,
        /// What is missing.
        folder: PathBuf,
    },
    /// The folder is read-only or full.
    #[error("{}: cannot write: {source}", .path.display())]
    Io {
        /// The picture's file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The format cannot hold this picture.
    #[error("{}: cannot encode: {reason}", .path.display())]
    Encode {
        /// The picture's file.
        path: PathBuf,
        /// What the encoder said.
        reason: String,
    },
}

/// What a picture's file can be, by its name's extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Exr,
    Pfm,
    Png,
    Tga,
}

impl Format {
    fn of(path: &Path) -> Result<Format, WriteError> {
        let extension = path
            .extension()
            .and_then(|e| e.to_str())
            .map(str::to_ascii_lowercase);
        match extension.as_deref() {
            Some("exr") => Ok(Format::Exr),
            Some("pfm") => Ok(Format::Pfm),
            Some("png") => Ok(Format::Png),
            Some("tga") => Ok(Format::Tga),
            _ => Err(WriteError::UnknownFormat(path.to_owned())),
        }
    }
}

/// Can a file of this name hold the variances of pixels?
pub fn keeps_variances(path: &Path) -> bool {
    matches!(Format::of(path), Ok(Format::Exr))
}

/// Does the name end in a format's extension?
///
/// # Errors
/// It does not.
pub fn check_name(path: &Path) -> Result<(), WriteError> {
    Format::of(path).map(drop)
}

/// Will [`write()`] to this path work, as far as can be known before rendering? Leaves no trace.
///
/// # Errors
/// An extension that no format has, a folder of that name, a folder that is missing or cannot be
/// written to.
pub fn check_output(path: &Path) -> Result<(), WriteError> {
    Format::of(path)?;
    if path.is_dir() {
        return Err(WriteError::IsFolder(path.to_owned()));
    }
    temporary(path).map(drop)
}

/// Writes `image` to `path`, in the format that the name's extension says: `.exr` (linear, with
/// variances and metadata), `.pfm` (linear), `.png`, `.tga` (8-bit sRGB).
///
/// The file appears under its name only when it is complete: it is written beside it under a
/// temporary name and renamed. A file that was there before is replaced.
///
/// # Errors
/// See [`check_output`]; a full disk; a picture the format cannot hold.
pub fn write(path: &Path, image: &Image, metadata: &FilmMetadata) -> Result<(), WriteError> {
    let bytes = encode(path, image, metadata)?;
    let io = |source| WriteError::Io {
        path: path.to_owned(),
        source,
    };
    let mut file = temporary(path)?;
    file.write_all(&bytes).map_err(io)?;
    file.as_file().sync_all().map_err(io)?;
    file.persist(path).map_err(|e| io(e.error))?;
    Ok(())
}

fn encode(path: &Path, image: &Image, metadata: &FilmMetadata) -> Result<Vec<u8>, WriteError> {
    let refused = |reason: String| WriteError::Encode {
        path: path.to_owned(),
        reason,
    };
    match Format::of(path)? {
        Format::Exr => exr::encode(image, metadata).map_err(|e| refused(e.to_string())),
        Format::Pfm => Ok(pfm::encode(image)),
        Format::Png => png::encode(image, ImageFormat::Png).map_err(|e| refused(e.to_string())),
        Format::Tga => png::encode(image, ImageFormat::Tga).map_err(|e| refused(e.to_string())),
    }
}

/// A new file in the folder of `path`, removed again unless it is renamed.
fn temporary(path: &Path) -> Result<NamedTempFile, WriteError> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(WriteError::NoFolder {
            path: path.to_owned(),
            folder: folder.to_owned(),
        });
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".fstop-");
    // Temporary files are private by default; a picture is a file like any other, subject to umask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder).map_err(|error| WriteError::Io {
        path: path.to_owned(),
        // Of the hidden file's name, which `tempfile` adds, nobody has heard.
        source: error.kind().into(),
    })
}
