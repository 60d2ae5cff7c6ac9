//! The portable float map: `PF` (color) or `Pf` (grayscale), width, height, scale, then 32-bit floats, bottom row
//! first. A negative scale marks little-endian numbers; they are multiplied by its magnitude, as in pbrt-v3 (`ReadImagePFM`).

use super::image_data::{Encoding, ImageData, SizeLimit};
use crate::math::Rgb;

/// Decodes a whole file.
pub(super) fn read(bytes: &[u8], limit: SizeLimit) -> Result<ImageData, String> {
    let mut header = Header { bytes, at: 0 };
    let channels = match header.word() {
        Some("PF") => 3,
        Some("Pf") => 1,
        _ => return Err("it does not start with PF or Pf".into()),
    };
    let width = header.number::<usize>("width")?;
    let height = header.number::<usize>("height")?;
    let scale = header.number::<f32>("scale")?;
    if !scale.is_finite() || scale == 0.0 {
        return Err(format!("its scale is {scale}"));
    }
    limit.check(width, height)?;
    // Exactly one white-space byte separates the header from the numbers.
    let data = bytes.get(header.at + 1..).unwrap_or_default();
    let row_bytes = width * channels * 4;
    if data.len() < row_bytes * height {
        return Err(format!(
            "it ends early: {} bytes of pixels, {} needed",
            data.len(),
            row_bytes * height
        ));
    }
    let number = |b: &[u8]| {
        let word = [b[0], b[1], b[2], b[3]];
        let stored = if scale < 0.0 {
            f32::from_le_bytes(word)
        } else {
            f32::from_be_bytes(word)
        };
        stored * scale.abs()
    };
    let mut texels = Vec::with_capacity(width * height);
    for row in (0..height).rev() {
        let row = &data[row * row_bytes..(row + 1) * row_bytes];
        texels.extend(row.chunks_exact(channels * 4).map(|t| match channels {
            3 => Rgb::new(number(&t[0..4]), number(&t[4..8]), number(&t[8..12])),
            _ => Rgb::splat(number(t)),
        }));
    }
    ImageData::from_texels(width, height, Encoding::Linear, texels)
        .ok_or_else(|| "it has no pixels".into())
}

/// Width and height.
pub(super) fn size(bytes: &[u8]) -> Result<[usize; 2], String> {
    let mut header = Header { bytes, at: 0 };
    header.word();
    Ok([header.number("width")?, header.number("height")?])
}

/// White-space separated words of the header.
struct Header<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Header<'a> {
    /// The next word; `at` is left on the byte after it.
    fn word(&mut self) -> Option<&'a str> {
        let start = self.at
            + self.bytes[self.at..]
                .iter()
                .position(|b| !b.is_ascii_whitespace())?;
        let length = self.bytes[start..]
            .iter()
            .position(|b| b.is_ascii_whitespace())?;
        self.at = start + length;
        std::str::from_utf8(&self.bytes[start..self.at]).ok()
    }

    fn number<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, String> {
        let word = self
            .word()
            .ok_or_else(|| format!("its {what} is missing"))?;
        word.parse().map_err(|_| format!("its {what} is '{word}'"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(header: &str, values: &[f32], bytes: fn(f32) -> [u8; 4]) -> Vec<u8> {
        let mut file = header.as_bytes().to_vec();
        file.extend(values.iter().flat_map(|&v| bytes(v)));
        file
    }

    fn decode(bytes: &[u8]) -> Result<ImageData, String> {
        read(bytes, SizeLimit::for_file(bytes.len()))
    }

    #[test]
    fn rows_run_upwards_and_both_byte_orders_are_read() {
        let values = [0.0, 1.0, 2.0, 3.0];
        let little = decode(&file("Pf\n2 2\n-1\n", &values, f32::to_le_bytes)).unwrap();
        let big = decode(&file("Pf 2 2 1.0\n", &values, f32::to_be_bytes)).unwrap();
        for image in [little, big] {
            assert_eq!(image.pixel(0, 0), Rgb::splat(2.0), "the top row comes last");
            assert_eq!(image.pixel(1, 1), Rgb::splat(1.0));
        }
        let color = decode(&file(
            "PF\n1 1\n-1.000000\n",
            &[5.0, 6.0, 7.0],
            f32::to_le_bytes,
        ))
        .unwrap();
        assert_eq!(color.pixel(0, 0), Rgb::new(5.0, 6.0, 7.0));
    }

    #[test]
    fn numbers_are_scaled() {
        let scaled = decode(&file("Pf\n1 1\n-2.5\n", &[3.0], f32::to_le_bytes)).unwrap();
        assert_eq!(scaled.pixel(0, 0), Rgb::splat(7.5));
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (bytes, said) in [
            ("P6 1 1 -1 ....", "PF or Pf"),
            ("PF\nx 1\n-1\n", "width"),
            ("PF\n1\n", "height"),
            ("PF\n1 -1\n1\n", "height"),
            ("PF\n1 1\n0\n0000", "scale"),
            ("PF\n1 1\n-1\n0000", "12 needed"),
            ("PF\n0 1\n-1\n", "no pixels"),
            ("PF", "PF or Pf"),
        ] {
            let message = decode(bytes.as_bytes()).unwrap_err();
            assert!(message.contains(said), "{bytes:?}: {message}");
        }
    }
}
