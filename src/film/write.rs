//! Writes an image to a file.

use super::{Encoding, FilmMetadata, Image, exr, pfm, png};
use crate::output::{self, Draft, OutputError};
use image::{ImageError, ImageFormat};
use std::io::{self, BufWriter, IntoInnerError, Seek, Write};
use std::path::{Path, PathBuf};

/// Why an image could not be written; always names the file.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The name does not end in a format's extension.
    #[error("{}: an image's name must end in .exr, .pfm, .png or .tga", .0.display())]
    UnknownFormat(PathBuf),
    /// The file cannot be created.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The file cannot be created, but another one was written instead.
    #[error("{source}; the image is in `{}` instead", .place.display())]
    Elsewhere {
        /// The problem with the requested file.
        source: OutputError,
        /// The file that was written.
        place: PathBuf,
    },
    /// The format cannot hold this image.
    #[error("{}: cannot encode: {reason}", .path.display())]
    Encode {
        /// The file's path.
        path: PathBuf,
        /// The encoder's message.
        reason: String,
    },
}

impl WriteError {
    /// Returns `true` if the image might be written on another machine or later.
    pub fn is_failure(&self) -> bool {
        match self {
            WriteError::UnknownFormat(_) | WriteError::Encode { .. } => false,
            WriteError::Output(error) => error.is_failure(),
            WriteError::Elsewhere { .. } => true,
        }
    }
}

/// The format of an image file, by its extension.
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

/// Returns `true` if a file of this name can store the variances of pixels.
pub fn keeps_variances(path: &Path) -> bool {
    matches!(Format::of(path), Ok(Format::Exr))
}

/// Checks that the name has a supported format's extension.
///
/// # Errors
/// Fails if it does not.
pub fn check_name(path: &Path) -> Result<(), WriteError> {
    Format::of(path).map(drop)
}

/// Checks that [`write()`] to this path will work, as far as can be known before rendering. Leaves no trace.
///
/// # Errors
/// An extension that no format has; what `output::check` finds.
pub fn check_output(path: &Path) -> Result<(), WriteError> {
    Format::of(path)?;
    Ok(output::check(path)?)
}

/// Writes `image` to `path`, in the format given by the extension: `.exr` (linear, with variances and metadata), `.pfm`
/// (linear), `.png`, `.tga` (8-bit sRGB).
///
/// The file appears under its name only when it is complete (`output::write`). A file that was there
/// before is replaced.
///
/// # Errors
/// See [`check_output`]; also a full disk, or an image that the format cannot hold.
pub fn write(path: &Path, image: &Image, metadata: &FilmMetadata) -> Result<(), WriteError> {
    write_as(path, image, metadata, &Encoding::default())
}

/// As [`write()`], stored as `encoding` says.
///
/// # Errors
/// See [`write()`].
pub fn write_as(
    path: &Path,
    image: &Image,
    metadata: &FilmMetadata,
    encoding: &Encoding,
) -> Result<(), WriteError> {
    let format = Format::of(path)?;
    let mut file = BufWriter::new(Draft::begin(path)?);
    let encoded = encode(format, image, metadata, encoding, &mut file);
    let encoded =
        encoded.and_then(|()| Ok(file.into_inner().map_err(IntoInnerError::into_error)?));
    let path = path.to_owned();
    match encoded {
        Ok(file) => Ok(file.finish()?),
        Err(Stopped::ByDisk(source)) => Err(OutputError::Io { path, source }.into()),
        Err(Stopped::ByFormat(reason)) => Err(WriteError::Encode { path, reason }),
    }
}

/// As [`write_as`], for images that took long to render: where the file cannot be made, it goes to the
/// current folder or to that for temporary files (`output::rescue`).
///
/// # Errors
/// See [`write()`]; [`WriteError::Elsewhere`] if the image was saved, but not where requested.
pub fn write_somewhere(
    path: &Path,
    image: &Image,
    metadata: &FilmMetadata,
    encoding: &Encoding,
) -> Result<(), WriteError> {
    let write = |path: &Path| write_as(path, image, metadata, encoding);
    match write(path) {
        Err(WriteError::Output(source)) => {
            Err(match output::rescue(path, |place| write(place).is_ok()) {
                Some(place) => WriteError::Elsewhere { source, place },
                None => WriteError::Output(source),
            })
        }
        done => done,
    }
}

/// Why an image is not in its file.
enum Stopped {
    /// What was to be written is not.
    ByDisk(io::Error),
    /// The format cannot hold it, in the encoder's words.
    ByFormat(String),
}

impl From<io::Error> for Stopped {
    fn from(error: io::Error) -> Stopped {
        Stopped::ByDisk(error)
    }
}

impl From<::exr::error::Error> for Stopped {
    fn from(error: ::exr::error::Error) -> Stopped {
        match error {
            ::exr::error::Error::Io(error) => Stopped::ByDisk(error),
            error => Stopped::ByFormat(error.to_string()),
        }
    }
}

impl From<ImageError> for Stopped {
    fn from(error: ImageError) -> Stopped {
        match error {
            ImageError::IoError(error) => Stopped::ByDisk(error),
            error => Stopped::ByFormat(error.to_string()),
        }
    }
}

fn encode(
    format: Format,
    image: &Image,
    metadata: &FilmMetadata,
    encoding: &Encoding,
    file: &mut (impl Write + Seek),
) -> Result<(), Stopped> {
    match format {
        Format::Exr => exr::encode(image, metadata, encoding, file)?,
        Format::Pfm => pfm::encode(image, file)?,
        Format::Png => png::encode(image, encoding.gain(), ImageFormat::Png, file)?,
        Format::Tga => png::encode(image, encoding.gain(), ImageFormat::Tga, file)?,
    }
    Ok(())
}
