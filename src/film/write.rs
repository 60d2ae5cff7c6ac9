//! An image into a file.

use super::{FilmMetadata, Image, exr, pfm, png};
use crate::output::{self, OutputError};
use image::ImageFormat;
use std::path::{Path, PathBuf};

/// Why an image could not be written; always names the file.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The name does not end in a format's extension.
    #[error("{}: an image's name must end in .exr, .pfm, .png or .tga", .0.display())]
    UnknownFormat(PathBuf),
    /// The file cannot be made.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The file cannot be made, but another in its stead.
    #[error("{source}; the image is in `{}` instead", .place.display())]
    Elsewhere {
        /// What is wrong with the file that was asked for.
        source: OutputError,
        /// The file that was made.
        place: PathBuf,
    },
    /// The format cannot hold this image.
    #[error("{}: cannot encode: {reason}", .path.display())]
    Encode {
        /// The image's file.
        path: PathBuf,
        /// What the encoder said.
        reason: String,
    },
}

/// What an image's file can be, by its name's extension.
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
/// An extension that no format has; what `output::check` finds.
pub fn check_output(path: &Path) -> Result<(), WriteError> {
    Format::of(path)?;
    Ok(output::check(path)?)
}

/// Writes `image` to `path`, in the format that the name's extension says: `.exr` (linear, with
/// variances and metadata), `.pfm` (linear), `.png`, `.tga` (8-bit sRGB).
///
/// The file appears under its name only when it is complete (`output::write`). A file that was there
/// before is replaced.
///
/// # Errors
/// See [`check_output`]; a full disk; an image the format cannot hold.
pub fn write(path: &Path, image: &Image, metadata: &FilmMetadata) -> Result<(), WriteError> {
    let bytes = encode(path, image, metadata)?;
    Ok(output::write(path, &bytes)?)
}

/// As [`write()`], for images that took long to render: where the file cannot be made, it goes to the
/// current folder or to that for temporary files (`output::rescue`).
///
/// # Errors
/// See [`write()`]; [`WriteError::Elsewhere`] where the image is safe, but not where it was wanted.
pub fn write_somewhere(
    path: &Path,
    image: &Image,
    metadata: &FilmMetadata,
) -> Result<(), WriteError> {
    let bytes = encode(path, image, metadata)?;
    output::write(path, &bytes).map_err(|source| match output::rescue(path, &bytes) {
        Some(place) => WriteError::Elsewhere { source, place },
        None => WriteError::Output(source),
    })
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
