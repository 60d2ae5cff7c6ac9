//! Infinite and NaN values, and variances that none can be: counted, located, and excluded from everything else.

use super::Side;
use crate::film::Image;
use crate::math::{Rgb, UVec2};

/// Pixels of a pair of images with an infinite or NaN value.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NonFinite {
    /// Their number in A and in B.
    pub counts: [usize; 2],
    /// The first in each image, row by row.
    pub first: [Option<UVec2>; 2],
    /// Pixels that are finite in one image only: the images certainly differ there.
    pub unmatched: usize,
    /// Pixels of finite values whose variance is NaN or negative, in A and in B.
    pub impossible_variances: [usize; 2],
    /// Pixels excluded from all tests and metrics: those of either image.
    pub left_out: usize,
    /// All pixels of one image.
    pub pixels: usize,
}

impl NonFinite {
    /// Their number in one of the images, and the location of the first.
    pub fn of(&self, side: Side) -> Option<(usize, UVec2)> {
        let i = side as usize;
        self.first[i].map(|first| (self.counts[i], first))
    }

    fn find(a: &Image, b: &Image) -> NonFinite {
        let mut found = NonFinite {
            pixels: a.pixels.len(),
            ..NonFinite::default()
        };
        let pairs = a.pixels.iter().zip(&b.pixels);
        for (index, (p, q)) in pairs.enumerate() {
            let broken = [!p.is_finite(), !q.is_finite()];
            let impossible = [
                has_impossible_variance(a, index),
                has_impossible_variance(b, index),
            ];
            if [broken, impossible] == [[false; 2]; 2] {
                continue;
            }
            found.left_out += 1;
            for i in (0..2).filter(|&i| impossible[i] && !broken[i]) {
                found.impossible_variances[i] += 1;
            }
            found.unmatched += usize::from(broken[0] != broken[1]);
            for i in (0..2).filter(|&i| broken[i]) {
                found.counts[i] += 1;
                found.first[i].get_or_insert_with(|| place(a, index));
            }
        }
        found
    }
}

/// The pixel at an index of the row-by-row list.
fn place(image: &Image, index: usize) -> UVec2 {
    let width = image.bounds.size().x.max(1);
    let index = index as u32;
    image.bounds.min + UVec2::new(index % width, index / width)
}

/// Returns `true` if a variance of the pixel is NaN or negative.
fn has_impossible_variance(image: &Image, index: usize) -> bool {
    let both = [image.variance.as_ref(), image.independent.as_ref()];
    let mut of_pixel = both.into_iter().flatten().filter_map(|v| v.get(index));
    of_pixel.any(|v| v.is_nan() || v.min_element() < 0.0)
}

/// Both images with black, noiseless pixels where either has a non-finite value or an impossible variance. `None` for an image that needs no change.
pub(crate) fn clean(a: &Image, b: &Image) -> (Option<Image>, Option<Image>, NonFinite) {
    let found = NonFinite::find(a, b);
    let is_sound = |i: usize| {
        let finite = [a, b].map(|image| image.pixels.get(i).is_none_or(|p| p.is_finite()));
        finite == [true; 2] && ![a, b].iter().any(|image| has_impossible_variance(image, i))
    };
    let cleaned = |image: &Image| {
        (found.left_out > 0).then(|| {
            let mut image = image.clone();
            for i in (0..image.pixels.len()).filter(|&i| !is_sound(i)) {
                image.pixels[i] = Rgb::ZERO;
                let both = [image.variance.as_mut(), image.independent.as_mut()];
                let of_pixel = both.into_iter().flatten().filter_map(|v| v.get_mut(i));
                of_pixel.for_each(|v| *v = Rgb::ZERO);
            }
            image
        })
    };
    (cleaned(a), cleaned(b), found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counted_located_and_blackened() {
        let mut a = Image::black(UVec2::new(4, 2));
        a.pixels.fill(Rgb::ONE);
        a.variance = Some(vec![Rgb::splat(0.5); 8]);
        let mut b = a.clone();
        a.pixels[5].y = f32::NAN;
        a.pixels[6].z = f32::INFINITY;
        b.pixels[6].x = f32::NAN;
        b.variance.as_mut().unwrap()[0] = Rgb::new(-1.0, f32::NAN, 2.0);
        let (clean_a, clean_b, found) = clean(&a, &b);
        assert_eq!(found.of(Side::A), Some((2, UVec2::new(1, 1))));
        assert_eq!(found.of(Side::B), Some((1, UVec2::new(2, 1))));
        assert_eq!((found.unmatched, found.left_out), (1, 3));
        assert_eq!(found.impossible_variances, [0, 1]);
        for image in [clean_a.unwrap(), clean_b.clone().unwrap()] {
            assert_eq!(image.pixels[5..7], [Rgb::ZERO; 2]);
            assert_eq!(image.variance.unwrap()[5..7], [Rgb::ZERO; 2]);
            assert_eq!(image.pixels[4], Rgb::ONE);
            assert_eq!(image.pixels[0], Rgb::ZERO);
        }
        assert_eq!(clean_b.unwrap().variance.unwrap()[0], Rgb::ZERO);
    }

    #[test]
    fn sound_images_are_not_copied() {
        let a = Image::black(UVec2::new(3, 3));
        let found = NonFinite {
            pixels: 9,
            ..NonFinite::default()
        };
        assert_eq!(clean(&a, &a), (None, None, found));
    }
}
