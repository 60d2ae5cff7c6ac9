//! Variances of what light paths bring to pixels, which few of them come to.

use super::{PixelBounds, Splats};
use crate::math::UVec2;
use glam::DVec3;

/// The part of the mean variance over its square of 4 × 4 pixels that a pixel's is at least. The sum over the square grows by as much at most, where one pixel has all;
/// a dark pixel beside a bright one may have many times its own variance.
const PART_OF_SMALL: f64 = 1.0 / 4.0;

/// The same over squares of 16 × 16. Larger ones, or a larger part, hide dark regions beside a caustic.
const PART_OF_LARGE: f64 = 1.0 / 64.0;

/// The variances of [`Splats::mean`], but at least parts of the means over squares around each pixel: what a few paths bring, so rarely that none has come to a pixel, is
/// known from its neighbors alone.
pub(super) struct SplatVariances<'a> {
    splats: &'a Splats,
    small: Squares<4>,
    large: Squares<16>,
}

impl SplatVariances<'_> {
    pub(super) fn new(splats: &Splats) -> SplatVariances<'_> {
        let bounds = splats.bounds();
        let (mut small, mut large) = (Squares::<4>::new(bounds), Squares::<16>::new(bounds));
        for pixel in bounds.pixels() {
            small.add(pixel, (splats.variance_of_mean(pixel), 1.0));
        }
        for (square, sum) in small.bounds.pixels().zip(&small.sums) {
            large.add(4 * square, *sum);
        }
        SplatVariances {
            splats,
            small,
            large,
        }
    }

    /// Of one pixel. Infinite if there is a single path.
    pub(super) fn at(&self, pixel: UVec2) -> DVec3 {
        let around =
            (PART_OF_SMALL * self.small.mean(pixel)).max(PART_OF_LARGE * self.large.mean(pixel));
        self.splats.variance_of_mean(pixel).max(around)
    }
}

/// Sums over squares of pixels, counted from the corner of the whole image, and of how many pixels.
struct Squares<const SIDE: u32> {
    /// In units of their side.
    bounds: PixelBounds,
    sums: Vec<(DVec3, f64)>,
}

impl<const SIDE: u32> Squares<SIDE> {
    /// Those that these pixels are in.
    fn new(pixels: PixelBounds) -> Self {
        let bounds = PixelBounds::new(pixels.min / SIDE, pixels.max.map(|n| n.div_ceil(SIDE)));
        Squares {
            bounds,
            sums: vec![(DVec3::ZERO, 0.0); bounds.area()],
        }
    }

    /// Adds the sum over so many pixels, all in the square of this one.
    fn add(&mut self, pixel: UVec2, (sum, count): (DVec3, f64)) {
        let index = self.bounds.index(pixel / SIDE);
        if let Some(all) = index.and_then(|i| self.sums.get_mut(i)) {
            *all = (all.0 + sum, all.1 + count);
        }
    }

    /// Over the square of a pixel.
    fn mean(&self, pixel: UVec2) -> DVec3 {
        let index = self.bounds.index(pixel / SIDE);
        let sum = index.and_then(|i| self.sums.get(i));
        sum.map_or(DVec3::ZERO, |(sum, count)| *sum / count.max(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::SplatBuffer;
    use crate::handles::LightLayer;
    use crate::math::Rgb;

    #[test]
    fn pixels_that_no_path_comes_to_have_a_part_of_their_neighbors_variance() {
        let bounds = PixelBounds::new(UVec2::new(2, 0), UVec2::new(40, 24));
        let mut splats = Splats::new(bounds, 0, 0);
        let mut buffer = SplatBuffer::new(bounds, f32::INFINITY, false);
        buffer.begin(0);
        let bright = UVec2::new(5, 6);
        buffer.push(0, bright, Rgb::ONE, (LightLayer::default(), Rgb::ONE));
        buffer.reach(1000);
        splats.add(&mut buffer);
        let own = splats.variance_of_mean(bright).x;
        let variances = SplatVariances::new(&splats);
        let at = |x, y| variances.at(UVec2::new(x, y)).x;
        // Its square of 4 × 4; that of 16 × 16, of which 14 × 16 are there; and elsewhere.
        for ((x, y), expected) in [
            ((5, 6), own),
            ((4, 7), own / 16.0 / 4.0),
            ((2, 0), own / (14.0 * 16.0) / 64.0),
        ] {
            assert!((at(x, y) / expected - 1.0).abs() < 1e-14, "{x} {y}");
        }
        assert_eq!(at(39, 23), 0.0);
        // What is not known stays so.
        let mut single = Splats::new(bounds, 0, 0);
        buffer.begin(0);
        buffer.reach(1);
        single.add(&mut buffer);
        assert_eq!(SplatVariances::new(&single).at(bright), DVec3::INFINITY);
    }
}
