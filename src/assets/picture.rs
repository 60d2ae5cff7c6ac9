//! Pictures on disk: textures and light maps.

use super::{openexr, pfm};
use crate::math::Rgb;
use image::{DynamicImage, ImageFormat, ImageReader, Limits};
use std::fs::File;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};

/// Memory every picture may take, whatever its file's size: 22 million texels.
const FREE_BYTES: u64 = 256 << 20;

/// Beyond [`FREE_BYTES`], decoded bytes per byte of the file. Deflate reaches at most 1032:1 and
/// packs bytes or half floats, which grow to floats here; a header that promises more lies.
const MAX_EXPANSION: u64 = 4128;

/// Largest side in texels; also keeps all index arithmetic far from overflow.
const MAX_SIDE: usize = 1 << 16;

/// How stored values stand for light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Proportional to light (.exr, .pfm, .hdr).
    Linear,
    /// By convention sRGB-encoded (.png, .tga, .jpg): integers scaled to 0…1.
    Srgb,
}

/// A picture of RGB texels as stored in its file: integer formats scaled to 0…1 but *not* decoded
/// from sRGB, float formats unchanged; grey ones have three equal channels; alpha is dropped.
/// Of an OpenEXR file this is the data window, wherever it lies.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Texels in a row; at least 1.
    pub width: usize,
    /// Rows; at least 1.
    pub height: usize,
    /// What the values mean.
    pub encoding: Encoding,
    texels: Vec<Rgb>,
}

/// Why a picture cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The file cannot be read at all.
    #[error("cannot read '{}': {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Neither the content nor the extension is of a format known here.
    #[error("'{}' is not a picture format fstop reads (.exr, .png, .jpg, .tga, .hdr, .pfm)", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The content breaks its format's rules, or uses a part of it that is not supported.
    #[error("cannot decode '{}': {message}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
}

/// Picture sizes a decoder may trust: checked before anything of that size is allocated.
#[derive(Clone, Copy, Debug)]
pub(super) struct SizeLimit {
    max_bytes: u64,
}

impl SizeLimit {
    /// For a file of `file_bytes` bytes.
    pub(super) fn for_file(file_bytes: usize) -> SizeLimit {
        SizeLimit {
            max_bytes: FREE_BYTES.max((file_bytes as u64).saturating_mul(MAX_EXPANSION)),
        }
    }

    /// An error unless `width` × `height` texels may be allocated.
    pub(super) fn check(self, width: usize, height: usize) -> Result<(), String> {
        let bytes = (width as u64)
            .saturating_mul(height as u64)
            .saturating_mul(size_of::<Rgb>() as u64);
        if width == 0 || height == 0 {
            Err("it has no pixels".into())
        } else if width > MAX_SIDE || height > MAX_SIDE || bytes > self.max_bytes {
            Err(format!(
                "its header claims {width} × {height} pixels, too many for a file of this size"
            ))
        } else {
            Ok(())
        }
    }
}

impl Picture {
    /// Reads `path`; the content's signature decides the format, where there is one, else the
    /// extension. Corrupted files are errors and never allocate more than their size justifies.
    pub fn load(path: &Path) -> Result<Picture, PictureError> {
        let bytes = read_file(path).map_err(|source| PictureError::Unreadable {
            path: path.into(),
            source,
        })?;
        let format = Format::of(path, &bytes)
            .ok_or_else(|| PictureError::UnknownFormat { path: path.into() })?;
        Picture::decode(&bytes, format).map_err(|message| PictureError::Malformed {
            path: path.into(),
            message,
        })
    }

    /// From `height` rows of `width` texels, top row first; `None` where the counts disagree or
    /// there are no texels.
    pub fn from_texels(
        width: usize,
        height: usize,
        encoding: Encoding,
        texels: Vec<Rgb>,
    ) -> Option<Picture> {
        let whole = !texels.is_empty() && width.checked_mul(height) == Some(texels.len());
        whole.then_some(Picture {
            width,
            height,
            encoding,
            texels,
        })
    }

    /// The texel of column `x` (0 at the left) and row `y` (0 at the *top*).
    pub fn pixel(&self, x: usize, y: usize) -> Rgb {
        self.texels[y * self.width + x]
    }

    /// All texels, row by row from the top.
    pub fn texels(&self) -> &[Rgb] {
        &self.texels
    }

    fn decode(bytes: &[u8], format: Format) -> Result<Picture, String> {
        let limit = SizeLimit::for_file(bytes.len());
        match format {
            Format::OpenExr => openexr::read(bytes, limit),
            Format::Pfm => pfm::read(bytes, limit),
            Format::Other(format) => read_with_image_crate(bytes, format, limit),
        }
    }
}

/// Which decoder a file needs.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Format {
    OpenExr,
    Pfm,
    Other(ImageFormat),
}

impl Format {
    fn of(path: &Path, bytes: &[u8]) -> Option<Format> {
        match image::guess_format(bytes) {
            Ok(ImageFormat::OpenExr) => return Some(Format::OpenExr),
            Ok(f @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::Hdr)) => {
                return Some(Format::Other(f));
            }
            _ => {}
        }
        if bytes.starts_with(b"PF") || bytes.starts_with(b"Pf") {
            return Some(Format::Pfm);
        }
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "exr" => Some(Format::OpenExr),
            "pfm" => Some(Format::Pfm),
            "png" => Some(Format::Other(ImageFormat::Png)),
            "jpg" | "jpeg" => Some(Format::Other(ImageFormat::Jpeg)),
            "tga" => Some(Format::Other(ImageFormat::Tga)),
            "hdr" => Some(Format::Other(ImageFormat::Hdr)),
            _ => None,
        }
    }
}

/// The whole file; devices and pipes are refused because they may never end.
fn read_file(path: &Path) -> std::io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    if !metadata.is_file() {
        return Err(std::io::Error::other("it is not a file"));
    }
    let mut bytes = Vec::new();
    file.take(metadata.len()).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn read_with_image_crate(
    bytes: &[u8],
    format: ImageFormat,
    limit: SizeLimit,
) -> Result<Picture, String> {
    let size = ImageReader::with_format(Cursor::new(bytes), format)
        .into_dimensions()
        .map_err(|e| e.to_string())?;
    limit.check(size.0 as usize, size.1 as usize)?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE as u32);
    limits.max_image_height = Some(MAX_SIDE as u32);
    limits.max_alloc = Some(limit.max_bytes);
    reader.limits(limits);
    let decoded = reader.decode().map_err(|e| e.to_string())?;
    let encoding = match decoded {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => Encoding::Linear,
        _ => Encoding::Srgb,
    };
    let rgb = decoded.into_rgb32f();
    let (width, height) = (rgb.width() as usize, rgb.height() as usize);
    let texels = rgb.as_raw().chunks_exact(3).map(Rgb::from_slice).collect();
    Picture::from_texels(width, height, encoding, texels).ok_or_else(|| "it has no pixels".into())
}
