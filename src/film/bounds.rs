//! A rectangle of pixels.

use crate::math::UVec2;

/// Pixels side by side that two rectangles have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SharedRow {
    /// The first one's [index](PixelBounds::index) in this rectangle.
    pub own: usize,
    /// In the other rectangle.
    pub other: usize,
    /// How many there are.
    pub pixels: usize,
}

/// The pixels with `min ≤ (x, y) < max`, raster coordinates: x right, y down, (0, 0) at the top left
/// of the full image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PixelBounds {
    /// First column and row.
    pub min: UVec2,
    /// One past the last column and row.
    pub max: UVec2,
}

impl PixelBounds {
    /// The pixels from `min` up to, not including, `max`; empty unless `max` is beyond `min`.
    pub fn new(min: UVec2, max: UVec2) -> PixelBounds {
        PixelBounds {
            min,
            max: max.max(min),
        }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> UVec2 {
        self.max - self.min
    }

    /// Number of pixels.
    pub fn area(&self) -> usize {
        self.size().x as usize * self.size().y as usize
    }

    /// Returns `true` if there are no pixels.
    pub fn is_empty(&self) -> bool {
        self.area() == 0
    }

    /// Returns `true` if `pixel` is one of these.
    pub fn contains(&self, pixel: UVec2) -> bool {
        pixel.cmpge(self.min).all() && pixel.cmplt(self.max).all()
    }

    /// The index of `pixel` in a row-by-row list of these pixels; `None` if it is outside.
    pub fn index(&self, pixel: UVec2) -> Option<usize> {
        if !self.contains(pixel) {
            return None;
        }
        let p = pixel - self.min;
        Some(p.y as usize * self.size().x as usize + p.x as usize)
    }

    /// The pixel of this index; `None` beyond them.
    pub fn pixel(&self, index: usize) -> Option<UVec2> {
        let width = self.size().x as usize;
        let inside = index < self.area();
        inside.then(|| self.min + UVec2::new((index % width) as u32, (index / width) as u32))
    }

    /// The pixels that are in both rectangles.
    pub fn intersection(&self, other: PixelBounds) -> PixelBounds {
        let min = self.min.max(other.min);
        PixelBounds::new(min, self.max.min(other.max))
    }

    /// All pixels, row by row from the top.
    pub fn pixels(self) -> impl Iterator<Item = UVec2> {
        (self.min.y..self.max.y)
            .flat_map(move |y| (self.min.x..self.max.x).map(move |x| UVec2::new(x, y)))
    }

    /// The pixels that are in both rectangles, from top to bottom.
    pub(crate) fn shared_rows(self, other: PixelBounds) -> Vec<SharedRow> {
        let both = self.intersection(other);
        let row = |y| {
            let first = UVec2::new(both.min.x, y);
            Some(SharedRow {
                own: self.index(first)?,
                other: other.index(first)?,
                pixels: both.size().x as usize,
            })
        };
        (both.min.y..both.max.y).filter_map(row).collect()
    }

    /// Square tiles of `side` pixels (at least 1) that cover these pixels exactly once, row by row from the top left;
    /// those at the right and bottom edges may be smaller.
    pub fn tiles(self, side: u32) -> impl Iterator<Item = PixelBounds> {
        let side = side.max(1);
        let count = self.size().map(|n| n.div_ceil(side));
        (0..count.y).flat_map(move |j| {
            (0..count.x).map(move |i| {
                let min = self.min + UVec2::new(i, j) * side;
                PixelBounds::new(min, (self.max - min).min(UVec2::splat(side)) + min)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds(x0: u32, y0: u32, x1: u32, y1: u32) -> PixelBounds {
        PixelBounds::new(UVec2::new(x0, y0), UVec2::new(x1, y1))
    }

    #[test]
    fn shared_rows_are_the_pixels_of_both() {
        let (a, b) = (bounds(1, 2, 6, 5), bounds(3, 0, 9, 4));
        let mut pairs = Vec::new();
        for row in a.shared_rows(b) {
            pairs.extend((0..row.pixels).map(|i| (row.own + i, row.other + i)));
        }
        let both = a
            .pixels()
            .filter_map(|pixel| Some((a.index(pixel)?, b.index(pixel)?)));
        assert!(both.eq(pairs.iter().copied()) && pairs.len() == 6);
        assert!(a.shared_rows(bounds(6, 2, 9, 5)).is_empty());
        assert!(a.shared_rows(bounds(2, 5, 3, 7)).is_empty());
    }

    #[test]
    fn tiles_cover_every_pixel_once() {
        for b in [bounds(0, 0, 1, 1), bounds(3, 5, 20, 11), bounds(7, 7, 7, 9)] {
            for side in [0, 1, 2, 5, 16, 64, u32::MAX] {
                let mut seen = vec![0; b.area()];
                for tile in b.tiles(side) {
                    for pixel in tile.pixels() {
                        seen[b.index(pixel).unwrap()] += 1;
                    }
                }
                assert!(seen.iter().all(|&n| n == 1), "{b:?} in tiles of {side}");
            }
        }
    }

    #[test]
    fn index_counts_row_by_row() {
        let b = bounds(3, 5, 20, 11);
        for (i, pixel) in b.pixels().enumerate() {
            assert_eq!(b.index(pixel), Some(i));
        }
        for outside in [
            UVec2::new(2, 5),
            UVec2::new(3, 4),
            UVec2::new(20, 5),
            UVec2::new(3, 11),
        ] {
            assert_eq!(b.index(outside), None);
        }
    }

    #[test]
    fn disjoint_bounds_intersect_in_nothing() {
        assert!(
            bounds(0, 0, 4, 4)
                .intersection(bounds(6, 6, 9, 9))
                .is_empty()
        );
        assert_eq!(
            bounds(0, 0, 4, 4).intersection(bounds(2, 1, 9, 3)),
            bounds(2, 1, 4, 3)
        );
    }
}
