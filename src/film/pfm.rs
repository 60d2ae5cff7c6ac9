//! Portable float map: `PF`, little-endian, rows from the bottom up, only the crop window
//! (docs/scene-language.md §4.8).

use super::Image;

/// Encodes the whole file in memory.
pub(super) fn encode(image: &Image) -> Vec<u8> {
    let size = image.bounds.size();
    // A negative scale means little-endian.
    let mut bytes = format!("PF\n{} {}\n-1\n", size.x, size.y).into_bytes();
    for y in (0..size.y as usize).rev() {
        for pixel in image.row(y) {
            for v in pixel.to_array() {
                bytes.extend_from_slice(&v.to_le_bytes());
            }
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rgb, UVec2};

    #[test]
    fn bottom_row_comes_first() {
        let mut image = Image::black(UVec2::new(1, 2));
        image.pixels = vec![Rgb::new(1.0, 2.0, 3.0), Rgb::new(4.0, 5.0, 6.0)];
        let bytes = encode(&image);
        let header = b"PF\n1 2\n-1\n";
        assert_eq!(&bytes[..header.len()], header);
        let values: Vec<f32> = bytes[header.len()..]
            .chunks(4)
            .map(|b| f32::from_le_bytes(b.try_into().unwrap()))
            .collect();
        assert_eq!(values, [4.0, 5.0, 6.0, 1.0, 2.0, 3.0]);
    }
}
