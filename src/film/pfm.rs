//! Portable float map: `PF`, little-endian, rows from the bottom up, only the crop window
//! (docs/scene-language.md §4.8).

use super::Image;
use std::io::{self, Write};

/// Writes a file.
///
/// # Errors
/// Those of `file`.
pub(super) fn encode(image: &Image, file: &mut impl Write) -> io::Result<()> {
    let size = image.bounds.size();
    // A negative scale means little-endian.
    write!(file, "PF\n{} {}\n-1\n", size.x, size.y)?;
    for y in (0..size.y as usize).rev() {
        for pixel in image.row(y) {
            for v in pixel.to_array() {
                file.write_all(&v.to_le_bytes())?;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rgb, UVec2};

    #[test]
    fn bottom_row_comes_first() {
        let mut image = Image::black(UVec2::new(1, 2));
        image.pixels = vec![Rgb::new(1.0, 2.0, 3.0), Rgb::new(4.0, 5.0, 6.0)];
        let mut bytes = Vec::new();
        encode(&image, &mut bytes).unwrap();
        let header = b"PF\n1 2\n-1\n";
        assert_eq!(&bytes[..header.len()], header);
        let values: Vec<f32> = bytes[header.len()..]
            .chunks(4)
            .map(|b| f32::from_le_bytes(b.try_into().unwrap()))
            .collect();
        assert_eq!(values, [4.0, 5.0, 6.0, 1.0, 2.0, 3.0]);
    }
}
