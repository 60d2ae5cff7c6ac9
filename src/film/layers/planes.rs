//! The channels of layers, one after the other in memory.

use crate::pages::ask_for_large;

/// Planes of numbers, one for each pixel of an image, row by row. Together in one piece, for which the system has large pages: small ones for
/// each plane take it longer to clear than the numbers take to write.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Planes {
    values: Vec<f32>,
    pixels: usize,
}

impl Planes {
    /// So many, of so many pixels, all 0.
    pub(super) fn new(count: usize, pixels: usize) -> Planes {
        if count == 0 {
            return Planes::default();
        }
        let mut values = vec![0.0; count * pixels];
        ask_for_large(&mut values);
        Planes { values, pixels }
    }

    /// So many planes, from this one on.
    pub(super) fn some(&self, first: usize, count: usize) -> impl Iterator<Item = &[f32]> {
        let range = first * self.pixels..(first + count) * self.pixels;
        let values = self.values.get(range).unwrap_or_default();
        values.chunks_exact(self.pixels.max(1))
    }

    /// The values of so many pixels in a plane, from this one on.
    #[inline(always)]
    pub(super) fn row(&mut self, plane: usize, first: usize, pixels: usize) -> &mut [f32] {
        let first = plane * self.pixels + first;
        self.values
            .get_mut(first..first + pixels)
            .unwrap_or_default()
    }
}
