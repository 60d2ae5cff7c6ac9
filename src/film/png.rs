//! Eight-bit images for viewing: PNG and TGA, sRGB-encoded, no tone mapping (docs/scene-language.md §4.8).

use super::Image;
use crate::math::color::srgb_from_linear;
use image::codecs::tga::TgaEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError, ImageFormat};
use std::io::{Seek, Write};

/// Writes a file: only the crop window's pixels, whose values are multiplied by `gain`.
///
/// # Errors
/// Fails if the format cannot hold the image: TGA is limited to 65535 pixels per side; and if `file` does.
pub(super) fn encode(
    image: &Image,
    gain: f32,
    format: ImageFormat,
    file: &mut (impl Write + Seek),
) -> Result<(), ImageError> {
    let size = image.bounds.size();
    let bytes: Vec<u8> = image
        .pixels
        .iter()
        .flat_map(|p| p.to_array().map(|value| quantize(value * gain)))
        .collect();
    let kind = ExtendedColorType::Rgb8;
    match format {
        // The encoder's packets run over the ends of lines, which readers refuse (TGA 2.0, "Run-length encoded images").
        ImageFormat::Tga => TgaEncoder::new(file)
            .disable_rle()
            .write_image(&bytes, size.x, size.y, kind),
        _ => image::write_buffer_with_format(file, &bytes, size.x, size.y, kind, format),
    }
}

/// 255 × the sRGB curve + ½, clamped and truncated, as pbrt-v3 rounds. NaN becomes 0.
pub(super) fn quantize(linear: f32) -> u8 {
    // `as` saturates, so values below 0 and above 255 are clamped.
    (255.0 * srgb_from_linear(linear) + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As readers want them that take each line by itself.
    #[test]
    fn no_packet_of_a_tga_runs_over_the_end_of_a_line() {
        let image = Image::black(crate::math::UVec2::new(5, 3));
        let mut file = std::io::Cursor::new(Vec::new());
        encode(&image, 1.0, ImageFormat::Tga, &mut file).unwrap();
        let bytes = file.into_inner();
        // The image's type is 2, colors without packets.
        assert_eq!((bytes[2], bytes.len()), (2, 18 + 5 * 3 * 3));
    }

    #[test]
    fn known_values() {
        // 18 % gray is 118 in sRGB (1.055·0.18^(1/2.4) − 0.055 = 0.46136, times 255 = 117.6).
        let cases = [
            (0.0, 0),
            (-3.0, 0),
            (1.0, 255),
            (1e9, 255),
            (0.18, 118),
            (f32::INFINITY, 255),
            (f32::NAN, 0),
        ];
        for (linear, byte) in cases {
            assert_eq!(quantize(linear), byte, "{linear}");
        }
        // In the linear segment: 12.92 × 0.002 × 255 + ½ = 7.09.
        assert_eq!(quantize(0.002), 7);
    }
}
