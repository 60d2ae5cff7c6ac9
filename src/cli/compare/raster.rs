//! Images and maps as embedded in the page: base64 of half floats or of bytes, reduced if the image is large.

use crate::film::Image;
use crate::math::{Rgb, UVec2};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use half::f16;

/// Maximum number of pixels of an image on the page, 16 MB of text for both; larger ones are reduced.
pub(super) const MAX_PIXELS: u64 = 1 << 20;

/// Division of an image into squares of pixels that are merged into one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Reduction {
    full: UVec2,
    /// Side of the squares: 1 for images that fit.
    pub factor: u32,
}

impl Reduction {
    /// The smallest factor that makes an image fit into `most` pixels.
    pub(super) fn new(full: UVec2, most: u64) -> Reduction {
        let fits = |factor: u32| {
            let size = full.map(|n| n.div_ceil(factor));
            u64::from(size.x) * u64::from(size.y) <= most.max(1)
        };
        let factor = (1..=full.max_element().max(1)).find(|&f| fits(f));
        Reduction {
            full,
            factor: factor.unwrap_or(1),
        }
    }

    /// Width and height of the reduced image.
    pub(super) fn size(&self) -> UVec2 {
        self.full.map(|n| n.div_ceil(self.factor))
    }

    /// For each square, row by row, the positions of its pixels.
    fn squares(&self) -> impl Iterator<Item = impl Iterator<Item = usize>> {
        let (full, factor, size) = (self.full, self.factor, self.size());
        (0..size.y).flat_map(move |y| {
            (0..size.x).map(move |x| {
                let columns = x * factor..((x + 1) * factor).min(full.x);
                let rows = y * factor..((y + 1) * factor).min(full.y);
                rows.flat_map(move |row| {
                    let start = row as usize * full.x as usize;
                    columns.clone().map(move |column| start + column as usize)
                })
            })
        })
    }

    /// The means of squares, as little-endian half floats R G B. Halves reach up to 65504; brighter values and
    /// NaN are stored as that.
    pub(super) fn halves(&self, image: &Image) -> String {
        let mut bytes = Vec::new();
        for square in self.squares() {
            let (mut sum, mut count) = (Rgb::ZERO, 0.0f32);
            for pixel in square.filter_map(|i| image.pixels.get(i)) {
                sum += *pixel;
                count += 1.0;
            }
            for value in (sum / count.max(1.0)).to_array() {
                let most = f16::MAX.to_f32();
                let value = if value.is_nan() {
                    most
                } else {
                    value.clamp(-most, most)
                };
                bytes.extend_from_slice(&f16::from_f32(value).to_le_bytes());
            }
        }
        STANDARD.encode(bytes)
    }

    /// The maximum of each square, 0…1 as a byte.
    pub(super) fn bytes(&self, value: impl Fn(usize) -> f32) -> String {
        let largest = |square: &mut dyn Iterator<Item = usize>| {
            let most = square.map(&value).fold(0.0, f32::max);
            (255.0 * most.min(1.0)).round() as u8
        };
        let bytes: Vec<u8> = self
            .squares()
            .map(|mut square| largest(&mut square))
            .collect();
        STANDARD.encode(bytes)
    }
}

/// What the first pixel of each block says, row by row, 0…1 as a byte.
pub(super) fn grid(map: &Image, side: u32, value: impl Fn(Rgb) -> f32) -> String {
    let (size, corner) = (map.bounds.size(), map.bounds.min);
    let mut bytes = Vec::new();
    for y in (0..size.y).step_by(side.max(1) as usize) {
        for x in (0..size.x).step_by(side.max(1) as usize) {
            let value = value(map.pixel(corner + UVec2::new(x, y)));
            bytes.push((255.0 * value.clamp(0.0, 1.0)).round() as u8);
        }
    }
    STANDARD.encode(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_images_shrink_and_small_ones_do_not() {
        let of = |x, y| Reduction::new(UVec2::new(x, y), MAX_PIXELS);
        assert_eq!((of(1024, 1024).factor, of(1025, 1024).factor), (1, 2));
        assert_eq!(of(4000, 3000).size(), UVec2::new(1000, 750));
        assert_eq!(of(0, 0).factor, 1);
        assert_eq!(of(u32::MAX, 1).size().y, 1);
    }

    #[test]
    fn squares_are_means_of_images_and_maxima_of_maps() {
        let mut image = Image::black(UVec2::new(3, 2));
        for (i, p) in image.pixels.iter_mut().enumerate() {
            *p = Rgb::splat(i as f32);
        }
        let reduction = Reduction {
            full: UVec2::new(3, 2),
            factor: 2,
        };
        let bytes = STANDARD.decode(reduction.halves(&image)).unwrap();
        let values: Vec<f32> = bytes
            .chunks_exact(2)
            .map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32())
            .collect();
        // (0 + 1 + 3 + 4) / 4 and, of the column at the edge, (2 + 5) / 2.
        assert_eq!(values, [2.0, 2.0, 2.0, 3.5, 3.5, 3.5]);
        let map = STANDARD
            .decode(reduction.bytes(|i| i as f32 / 10.0))
            .unwrap();
        // Rounded to 255ths.
        assert_eq!(map, [102, 128]);
    }

    #[test]
    fn what_halves_cannot_hold() {
        let mut image = Image::black(UVec2::new(1, 1));
        image.pixels[0] = Rgb::new(f32::NAN, 1e30, f32::NEG_INFINITY);
        let bytes = STANDARD
            .decode(Reduction::new(UVec2::ONE, 1).halves(&image))
            .unwrap();
        let halves = bytes
            .chunks_exact(2)
            .map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32());
        assert_eq!(halves.collect::<Vec<_>>(), [65504.0, 65504.0, -65504.0]);
    }
}
