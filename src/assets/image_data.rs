//! Image files: textures, light maps and their decoders' limits.

use super::{openexr, pfm};
use crate::budget::{Budget, Held};
use crate::files::{self, FileError};
use crate::math::Rgb;
use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::borrow::Cow;
use std::io::Cursor;
use std::path::Path;

/// Memory that any image may take, whatever its file size: 22 million texels.
pub(super) const FREE_BYTES: u64 = 256 << 20;

/// Beyond [`FREE_BYTES`], decoded bytes allowed per byte of the file. Deflate reaches at most 1032:1 and packs bytes or
/// half floats, which become floats here; a header that claims more is corrupt.
pub(super) const MAX_EXPANSION: u64 = 4128;

/// Maximum side in texels; also keeps all index arithmetic far from overflow.
const MAX_SIDE: usize = 1 << 16;

/// How stored values encode light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Proportional to light (.exr, .pfm, .hdr).
    Linear,
    /// By convention sRGB-encoded (.png, .tga, .jpg): integers scaled to 0…1.
    Srgb,
}

/// An image of RGB texels as stored in its file: integer formats are scaled to 0…1 but *not* decoded from sRGB, float
/// formats are unchanged; grayscale images have three equal channels; alpha is dropped. Of an OpenEXR file this is the
/// data window, wherever it is.
#[derive(Clone, Debug)]
pub struct ImageData {
    /// Texels in a row; at least 1.
    pub width: usize,
    /// Rows; at least 1.
    pub height: usize,
    /// The encoding of the values.
    pub encoding: Encoding,
    texels: Vec<Rgb>,
}

/// The bytes of an image file, which count as memory in use while they are held.
pub(super) fn read<'a>(path: &Path, budget: &'a Budget) -> Result<(Vec<u8>, Held<'a>), FileError> {
    let name = path.display();
    let bytes = files::read_within(path, budget)
        .map_err(|e| FileError::from(e).said(|e| format!("cannot read '{name}': {e}")))?;
    let held = budget
        .hold(bytes.len() as u64)
        .map_err(|e| format!("'{name}' {e}"))?;
    Ok((bytes, held))
}

/// What an image's header says, for forecasts of memory.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Texels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Bytes of the file.
    pub file: u64,
    /// Bytes of a texel as the decoder has it; 0 where it is read from the file itself.
    pub stored: u64,
    /// Bytes of a texel that the decoder's are converted to before they are texels; 0 where they are not.
    pub converted: u64,
}

impl Extent {
    /// Number of texels.
    pub fn texels(&self) -> u64 {
        (self.width * self.height) as u64
    }
}

/// Limit on image sizes that a decoder accepts: checked before anything of that size is allocated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SizeLimit {
    /// Bytes justified by the file's size.
    max_bytes: u64,
    /// Bytes left in the memory budget.
    memory: u64,
}

/// Copies of an image that exist during decoding: the decoder's output, its conversion to floats, and the texels.
const COPIES: u64 = 3;

impl SizeLimit {
    /// The limit for a file of `file_bytes` bytes.
    pub(crate) fn for_file(file_bytes: usize) -> SizeLimit {
        SizeLimit {
            max_bytes: FREE_BYTES.max((file_bytes as u64).saturating_mul(MAX_EXPANSION)),
            memory: u64::MAX,
        }
    }

    /// Limits it further to what is left of the budget.
    pub(crate) fn within(self, budget: &Budget) -> SizeLimit {
        SizeLimit {
            memory: budget.left(),
            ..self
        }
    }

    /// Fails unless `width` × `height` texels may be allocated.
    pub(crate) fn check(self, width: usize, height: usize) -> Result<(), String> {
        self.check_channels(width, height, 3)
    }

    /// Like [`SizeLimit::check`], for pixels with any number of channels.
    pub(crate) fn check_channels(
        self,
        width: usize,
        height: usize,
        channels: usize,
    ) -> Result<(), String> {
        let bytes = (width as u64)
            .saturating_mul(height as u64)
            .saturating_mul(channels.div_ceil(3) as u64)
            .saturating_mul(size_of::<Rgb>() as u64);
        if width == 0 || height == 0 {
            Err("it has no pixels".into())
        } else if width > MAX_SIDE || height > MAX_SIDE || bytes > self.max_bytes {
            Err(format!(
                "its header claims {width} × {height} pixels, too many for a file of this size"
            ))
        } else if bytes.saturating_mul(COPIES) > self.memory {
            Err(format!(
                "its {width} × {height} pixels need more memory than is left (see --max-memory)"
            ))
        } else {
            Ok(())
        }
    }
}

impl ImageData {
    /// Reads the image at `path`. The format is determined by the signature of the contents if there is one, otherwise
    /// by the extension. Corrupt files are errors and never allocate more than their size justifies, nor more than is
    /// left of `budget`.
    pub fn load(path: &Path, budget: &Budget) -> Result<ImageData, FileError> {
        let name = path.display();
        let (bytes, _held) = read(path, budget)?;
        if bytes.is_empty() {
            return Err(format!("cannot decode '{name}': the file is empty").into());
        }
        let format = Format::of(path, &bytes).ok_or_else(|| {
            format!(
                "'{name}' is not an image format fstop reads (.exr, .png, .jpg, .tga, .hdr, .pfm)"
            )
        })?;
        let limit = SizeLimit::for_file(bytes.len()).within(budget);
        let image = ImageData::decode(&bytes, format, limit)
            .map_err(|e| format!("cannot decode '{name}': {e}"))?;
        // Reserves memory for the image pyramid, in which each level is a quarter of the last.
        let pyramid = size_of_val(image.texels()) as u64 / 3 * 4;
        budget.take(pyramid).map_err(|e| format!("'{name}' {e}"))?;
        Ok(image)
    }

    /// What the header of the file at `path` says.
    ///
    /// # Errors
    /// A file that cannot be read, or whose header is none.
    pub fn extent(path: &Path) -> Result<Extent, FileError> {
        let name = path.display();
        let bytes = files::read_start(path, HEADER)
            .map_err(|e| FileError::from(e).said(|e| format!("cannot read '{name}': {e}")))?;
        let file = path.metadata().map_or(0, |found| found.len());
        let broken = |e: String| format!("cannot decode '{name}': {e}");
        let format = Format::of(path, &bytes)
            .ok_or_else(|| broken("this is no image format that fstop reads".to_string()))?;
        let (width, height, stored, converted) = match format {
            Format::OpenExr => openexr::extent(&bytes).map(|([w, h], stored)| (w, h, stored, 0)),
            Format::Pfm => pfm::size(&bytes).map(|[w, h]| (w, h, 0, 0)),
            Format::Other(format) => decoder_extent(&bytes, format),
        }
        .map_err(broken)?;
        let is_sound = (1..=MAX_SIDE).contains(&width) && (1..=MAX_SIDE).contains(&height);
        if !is_sound {
            return Err(broken(format!("its header claims {width} × {height} pixels")).into());
        }
        Ok(Extent {
            width,
            height,
            file,
            stored,
            converted,
        })
    }

    /// An image from `height` rows of `width` texels, top row first; `None` if the counts disagree or there are no
    /// texels.
    pub fn from_texels(
        width: usize,
        height: usize,
        encoding: Encoding,
        texels: Vec<Rgb>,
    ) -> Option<ImageData> {
        let whole = !texels.is_empty() && width.checked_mul(height) == Some(texels.len());
        whole.then_some(ImageData {
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

    fn decode(bytes: &[u8], format: Format, limit: SizeLimit) -> Result<ImageData, String> {
        match format {
            Format::OpenExr => openexr::read(bytes, limit),
            Format::Pfm => pfm::read(bytes, limit),
            Format::Other(format) => read_with_image_crate(bytes, format, limit),
        }
    }
}

/// An image file format.
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
        if bytes.starts_with(RADIANCE) {
            return Some(Format::Other(ImageFormat::Hdr));
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

/// Bytes in which the header of any image is expected; those of photographs may hold a preview.
const HEADER: u64 = 1 << 20;

/// What a Radiance file begins with; the word that follows is the program's (`#?RADIANCE`, Mitsuba's `#?RGBE`).
const RADIANCE: &[u8] = b"#?";

/// With the only word there that the decoder knows.
fn decodable(bytes: &[u8], format: ImageFormat) -> Cow<'_, [u8]> {
    let end = bytes.iter().position(|&byte| byte == b'\n');
    match end.and_then(|end| bytes.get(end..)) {
        Some(rest) if format == ImageFormat::Hdr && bytes.starts_with(RADIANCE) => {
            Cow::Owned([b"#?RADIANCE", rest].concat())
        }
        _ => Cow::Borrowed(bytes),
    }
}

/// What the values of a Radiance file are divided by to be light: all its lines `EXPOSURE=` and `COLORCORR=` together
/// (G. Ward, "Real Pixels", Graphics Gems II, 1991, and Radiance's File Formats, "Picture Files").
fn exposure(bytes: &[u8]) -> Result<Rgb, String> {
    let decoder = HdrDecoder::new(Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let found = decoder.metadata();
    let correction = Rgb::from(found.color_correction.unwrap_or((1.0, 1.0, 1.0)));
    let exposure = correction * found.exposure.unwrap_or(1.0);
    match exposure.is_finite() && exposure.min_element() > 0.0 {
        true => Ok(exposure),
        false => Err(
            "its header's EXPOSURE or COLORCORR, which light is to be divided by, is not above 0"
                .into(),
        ),
    }
}

/// Width, height, bytes of a texel as decoded, and as floats.
fn decoder_extent(bytes: &[u8], format: ImageFormat) -> Result<(usize, usize, u64, u64), String> {
    let bytes = decodable(bytes, format);
    let reader = ImageReader::with_format(Cursor::new(bytes), format);
    let decoder = reader.into_decoder().map_err(|e| e.to_string())?;
    let (width, height) = decoder.dimensions();
    let color = decoder.color_type();
    // Floats of three channels are taken as they are.
    let converted = if color == image::ColorType::Rgb32F {
        0
    } else {
        12
    };
    let stored = u64::from(color.bytes_per_pixel());
    Ok((width as usize, height as usize, stored, converted))
}

fn read_with_image_crate(
    bytes: &[u8],
    format: ImageFormat,
    limit: SizeLimit,
) -> Result<ImageData, String> {
    let bytes = &*decodable(bytes, format);
    let exposure = match format {
        ImageFormat::Hdr => exposure(bytes)?,
        _ => Rgb::ONE,
    };
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
    let texels = rgb.as_raw().chunks_exact(3).map(Rgb::from_slice);
    let texels = texels.map(|texel| texel / exposure).collect();
    ImageData::from_texels(width, height, encoding, texels).ok_or_else(|| "it has no pixels".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::*;
    use image::{ImageBuffer, Luma};
    use proptest::prelude::*;
    use std::path::PathBuf;

    fn decode(bytes: &[u8], format: Format) -> std::result::Result<ImageData, String> {
        ImageData::decode(bytes, format, SizeLimit::for_file(bytes.len()))
    }

    fn load(path: &Path) -> std::result::Result<ImageData, String> {
        ImageData::load(path, &Budget::unlimited()).map_err(|error| error.to_string())
    }

    /// Red increases to the right, green downward; every value is a multiple of 1/256.
    fn gradient(x: usize, y: usize) -> Rgb {
        Rgb::new(x as f32 * 16.0 / 256.0, y as f32 * 32.0 / 256.0, 0.25)
    }

    const WIDTH: usize = 9;
    const HEIGHT: usize = 5;

    fn write(directory: &Path, name: &str, save: impl FnOnce(&Path)) -> PathBuf {
        let path = directory.join(name);
        save(&path);
        path
    }

    fn bytes8() -> image::RgbImage {
        ImageBuffer::from_fn(WIDTH as u32, HEIGHT as u32, |x, y| {
            image::Rgb(
                (gradient(x as usize, y as usize) * 256.0)
                    .to_array()
                    .map(|v| v as u8),
            )
        })
    }

    fn exr_with(names: [&str; 3], prefix: &str, half: bool, position: (i32, i32)) -> Vec<u8> {
        let channel = |i: usize| {
            let values = (0..WIDTH * HEIGHT).map(|k| gradient(k % WIDTH, k / WIDTH)[i]);
            let samples = if half {
                FlatSamples::F16(values.map(f16::from_f32).collect())
            } else {
                FlatSamples::F32(values.collect())
            };
            AnyChannel::new(format!("{prefix}{}", names[i]).as_str(), samples)
        };
        let mut alpha = channel(2);
        alpha.name = format!("{prefix}A").as_str().into();
        let channels = AnyChannels::sort(
            [channel(0), channel(1), channel(2), alpha]
                .into_iter()
                .collect(),
        );
        let attributes = LayerAttributes {
            layer_position: Vec2(position.0, position.1),
            ..Default::default()
        };
        let layer = Layer::new(
            (WIDTH, HEIGHT),
            attributes,
            exr::image::Encoding::SMALL_LOSSLESS,
            channels,
        );
        let mut bytes = Vec::new();
        Image::from_layer(layer)
            .write()
            .to_buffered(Cursor::new(&mut bytes))
            .unwrap();
        bytes
    }

    fn is_gradient(path: &Path) -> ImageData {
        let image = load(path).unwrap();
        assert_eq!((image.width, image.height), (WIDTH, HEIGHT));
        image
    }

    #[test]
    fn eight_bit_images_are_scaled_to_one_and_stay_encoded() {
        let directory = tempfile::tempdir().unwrap();
        for name in ["a.png", "a.tga", "a.PNG"] {
            let path = write(directory.path(), name, |p| bytes8().save(p).unwrap());
            let image = is_gradient(&path);
            assert_eq!(image.encoding, super::Encoding::Srgb);
            for (x, y) in [(0, 0), (8, 0), (3, 4)] {
                let expected = gradient(x, y) * (256.0 / 255.0);
                assert!(
                    (image.pixel(x, y) - expected).abs().max_element() < 1e-6,
                    "{name} at {x}, {y}"
                );
            }
        }
    }

    /// One texel of 1, 0.5 and 0.25, by programs of different names, and after exposures of 2 and of 1/2, 1, 4.
    #[test]
    fn radiance_files_say_their_program_and_exposure() {
        let directory = tempfile::tempdir().unwrap();
        for (header, expected) in [
            ("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", [1.0, 0.5, 0.25]),
            ("#?RGBE\nFORMAT=32-bit_rle_rgbe\n", [1.0, 0.5, 0.25]),
            (
                "#?RGBE\nEXPOSURE=2\nEXPOSURE=2\nCOLORCORR=0.25 1 0.5\n",
                [1.0, 0.125, 0.125],
            ),
        ] {
            let bytes = [header.as_bytes(), b"\n-Y 1 +X 1\n", &[128, 64, 32, 129]].concat();
            // The signature alone says what it is.
            let path = directory.path().join("image");
            std::fs::write(&path, &bytes).unwrap();
            assert_eq!(
                load(&path).unwrap().pixel(0, 0).to_array(),
                expected,
                "{header}"
            );
            let extent = ImageData::extent(&path).unwrap();
            assert_eq!((extent.width, extent.height), (1, 1));
        }
        let none = b"#?RGBE\nEXPOSURE=0\n\n-Y 1 +X 1\n\x80\x40\x20\x81";
        let format = Format::Other(ImageFormat::Hdr);
        assert!(decode(none, format).unwrap_err().contains("EXPOSURE"));
    }

    #[test]
    fn jpeg_is_read_whatever_its_name() {
        let directory = tempfile::tempdir().unwrap();
        let flat = image::RgbImage::from_pixel(16, 8, image::Rgb([200, 100, 50]));
        for name in ["a.jpg", "a.jpeg"] {
            let path = write(directory.path(), name, |p| flat.save(p).unwrap());
            let misnamed = path.with_extension("png");
            std::fs::copy(&path, &misnamed).unwrap();
            for path in [path, misnamed] {
                let texel = load(&path).unwrap().pixel(15, 7) * 255.0;
                // Lossy, and its color transform rounds: within two steps of a flat color.
                assert!((texel - Rgb::new(200.0, 100.0, 50.0)).abs().max_element() <= 2.0);
            }
        }
    }

    #[test]
    fn sixteen_bit_png_keeps_its_precision() {
        let directory = tempfile::tempdir().unwrap();
        let gray = ImageBuffer::<Luma<u16>, _>::from_fn(3, 1, |x, _| {
            Luma([[1, 12345, 65535][x as usize]])
        });
        let path = write(directory.path(), "deep.png", |p| gray.save(p).unwrap());
        let image = load(&path).unwrap();
        for (x, stored) in [1.0f32, 12345.0, 65535.0].into_iter().enumerate() {
            assert!((image.pixel(x, 0) * 65535.0 - stored).abs().max_element() < 1e-2);
        }
    }

    #[test]
    fn radiance_images_are_linear() {
        let directory = tempfile::tempdir().unwrap();
        let image = image::Rgb32FImage::from_pixel(8, 4, image::Rgb([100.0, 1.0, 0.5]));
        let path = write(directory.path(), "a.hdr", |p| image.save(p).unwrap());
        let image = load(&path).unwrap();
        assert_eq!(image.encoding, super::Encoding::Linear);
        // A common exponent for three 8-bit mantissas: steps of 128/256.
        assert!(
            (image.pixel(7, 3) - Rgb::new(100.0, 1.0, 0.5))
                .abs()
                .max_element()
                <= 0.5
        );
    }

    #[test]
    fn openexr_is_read_whatever_its_channels_and_window() {
        let directory = tempfile::tempdir().unwrap();
        let rgb = ["R", "G", "B"];
        let cases = [
            exr_with(rgb, "", true, (0, 0)),
            exr_with(rgb, "", false, (-20, 7)),
            exr_with(rgb, "left.", true, (0, 0)),
            exr_with(["r", "g", "b"], "", false, (0, 0)),
        ];
        for bytes in cases {
            let path = write(directory.path(), "a.exr", |p| {
                std::fs::write(p, bytes).unwrap()
            });
            let image = is_gradient(&path);
            assert_eq!(image.encoding, super::Encoding::Linear);
            for (x, y) in [(0, 0), (8, 0), (3, 4)] {
                // Multiples of 1/256 below 1 are exact in half floats.
                assert_eq!(image.pixel(x, y), gradient(x, y));
            }
        }
        let gray = exr_with(["Y", "U", "V"], "", true, (0, 0));
        let path = write(directory.path(), "gray.exr", |p| {
            std::fs::write(p, gray).unwrap()
        });
        assert_eq!(is_gradient(&path).pixel(4, 1), Rgb::splat(gradient(4, 1).x));
        let depth = exr_with(["X", "Z", "U"], "", true, (0, 0));
        let path = write(directory.path(), "depth.exr", |p| {
            std::fs::write(p, depth).unwrap()
        });
        assert!(load(&path).unwrap_err().contains("is R, G, B or Y"));
    }

    #[test]
    fn errors_name_the_file() {
        let directory = tempfile::tempdir().unwrap();
        let missing = directory.path().join("missing.png");
        let nothing = write(directory.path(), "nothing.txt", |p| {
            std::fs::write(p, "text").unwrap()
        });
        let broken = write(directory.path(), "broken.png", |p| {
            std::fs::write(p, "text").unwrap()
        });
        for path in [missing, nothing, broken, directory.path().to_path_buf()] {
            let message = load(&path).unwrap_err();
            assert!(message.contains(path.to_str().unwrap()), "{message}");
        }
    }

    #[test]
    fn headers_that_promise_too_much_are_not_believed() {
        let mut png = Cursor::new(Vec::new());
        bytes8().write_to(&mut png, ImageFormat::Png).unwrap();
        let mut png = png.into_inner();
        png[16..24].copy_from_slice(&[0, 0, 0xff, 0xff, 0, 0, 0xff, 0xff]);
        assert!(decode(&png, Format::Other(ImageFormat::Png)).is_err());
        assert!(decode(b"PF\n60000 60000\n-1\nabcd", Format::Pfm).is_err());
        let limit = SizeLimit::for_file(1000);
        assert!(
            limit.check(60_000, 60_000).is_err()
                && limit.check(0, 3).is_err()
                && limit.check(4096, 4096).is_ok()
        );
        assert!(limit.check(usize::MAX, usize::MAX).is_err());
    }

    /// Whole files of every format.
    fn samples() -> Vec<(Format, Vec<u8>)> {
        let mut samples = vec![
            (Format::OpenExr, exr_with(["R", "G", "B"], "", true, (3, 4))),
            (Format::Pfm, [b"PF 2 1 -1 ".as_slice(), &[0; 24]].concat()),
        ];
        for format in [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Tga] {
            let mut bytes = Cursor::new(Vec::new());
            bytes8().write_to(&mut bytes, format).unwrap();
            samples.push((Format::Other(format), bytes.into_inner()));
        }
        let mut bytes = Cursor::new(Vec::new());
        DynamicImage::from(bytes8())
            .into_rgb32f()
            .write_to(&mut bytes, ImageFormat::Hdr)
            .unwrap();
        samples.push((Format::Other(ImageFormat::Hdr), bytes.into_inner()));
        samples
    }

    #[test]
    fn truncated_files_are_errors_or_images_but_never_panics() {
        for (format, bytes) in samples() {
            assert!(decode(&bytes, format).is_ok(), "{format:?}");
            for end in 0..bytes.len() {
                let _ = decode(&bytes[..end], format);
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn corrupted_files_are_errors_or_images_but_never_panics(
            which in 0usize..6,
            edits in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u8>()), 1..8),
        ) {
            let (format, mut bytes) = samples().swap_remove(which);
            for (at, value) in edits {
                let at = at.index(bytes.len());
                bytes[at] = value;
            }
            if let Ok(image) = decode(&bytes, format) {
                prop_assert_eq!(image.texels().len(), image.width * image.height);
            }
        }
    }
}
