//! True variances of well-distributed samples, from two independent halves of an image.
//!
//! Stratified and low-discrepancy samples of a pixel depend on each other: the variance of their mean is below that of as
//! many independent ones, by a factor that the samples of one set do not tell. Two independent sets tell it. If p and q are
//! their means, ((p − q)/2)² has the variance of (p + q)/2 for its expectation, but scatters as a chi-squared variable of one degree
//! of freedom. The naive variance v scatters little, and is proportional to the true one among neighbors. So the
//! variance of a pixel is v Σ((p − q)/2)² / Σv with sums over a square of pixels: a ratio estimator (W. G. Cochran,
//! "Sampling Techniques", 3rd edition 1977, chapter 6), whose degrees of freedom are (Σσ²)² / Σσ⁴ (Satterthwaite 1946).

use super::{Developed, PixelBounds};
use crate::math::UVec2;
use glam::DVec3;

/// Side in pixels of the squares whose pixels share a factor, counted from the corner of the whole image, so that a crop
/// window has the image's where it has all of a square. The factors of neighboring pixels may differ tenfold, at edges
/// and where light is direct: with one factor for the whole image 59 % of the 95 % intervals of pixels held (the box of
/// `examples/sampler_curves`, stratified), with one for 8 × 8 90 %, for 4 × 4 92 %. What a block of several squares loses
/// is nothing: the sum of its variances is that of its squared differences, whatever the side.
const POOL: u32 = 4;

impl Developed {
    /// The side of the squares of pixels whose variances share a factor, if they are [pooled](Developed::pool).
    pub fn pooled(&self) -> Option<u32> {
        self.image.independent.as_ref().map(|_| POOL)
    }

    /// Makes the variances those of the mean of two independent halves, if it has their differences. When all samples and all light
    /// are there.
    pub fn pool(&mut self) {
        let Some(mut pooled) = self.differences.take() else {
            return;
        };
        let Some(own) = self.image.variance.take() else {
            return;
        };
        let bounds = self.image.bounds;
        let squares = PixelBounds::new(bounds.min / POOL, bounds.max.map(|n| n.div_ceil(POOL)));
        for square in squares.pixels() {
            let pixels = PixelBounds::new(square * POOL, (square + UVec2::ONE) * POOL);
            let pixels = pixels.intersection(bounds);
            let indices = || pixels.pixels().filter_map(|pixel| bounds.index(pixel));
            let factor = factor(indices().map(|i| (pooled[i].as_dvec3(), own[i].as_dvec3())));
            for i in indices() {
                pooled[i] = (own[i].as_dvec3() * factor).as_vec3();
            }
        }
        self.image.variance = Some(pooled);
        self.image.independent = Some(own);
    }
}

/// Where the naive variance of pixels whose halves differ is that of n (Kish's effective number), the factor is at least this times 1 − n/[`ENOUGH`]: 0.0075 for a single one. A pixel of which two samples of 64
/// meet something else, one of each half, seemed to have no noise at all. With ten times this 98.4 % of the 95 % intervals of 8 × 8 pixels hold in `lamps` of
/// `examples/sampler_curves`, where pixels at the edges of lamps have factors as small as this, and with none 90 % of those of 4 × 4.
const MIN_FACTOR: f64 = 0.01;

/// So many pixels that share the naive variance evenly are not alike in both halves by chance.
const ENOUGH: f64 = 4.0;

/// What the variances of a square's pixels, as of independent samples, are to be multiplied with: by half the differences of
/// their halves, and them.
fn factor(pixels: impl Iterator<Item = (DVec3, DVec3)>) -> DVec3 {
    let (mut squares, mut naive) = (DVec3::ZERO, DVec3::ZERO);
    let (mut unlike, mut squares_of_unlike) = (DVec3::ZERO, DVec3::ZERO);
    for (difference, own) in pixels.filter(|(difference, _)| !difference.is_nan()) {
        squares += difference * difference;
        naive += own;
        // Nothing has come to the others, most likely: what they have is a part of their neighbors'.
        let own = DVec3::select(difference.cmpne(DVec3::ZERO), own, DVec3::ZERO);
        unlike += own;
        squares_of_unlike += own * own;
    }
    // Without noise there is nothing to correct, and of single samples nothing is known.
    let known = naive.cmpgt(DVec3::ZERO) & naive.cmplt(DVec3::INFINITY);
    // How many pixels tell of it (Kish's effective number).
    let pixels = unlike * unlike / squares_of_unlike.max(DVec3::splat(f64::MIN_POSITIVE));
    let least = MIN_FACTOR * (DVec3::ONE - pixels / ENOUGH);
    DVec3::select(known, (squares / naive).max(least), DVec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::factor;
    use crate::film::{Film, FilmSpec, PixelStatistics};
    use crate::math::{Rgb, UVec2};
    use glam::DVec3;

    /// One value in each of the halves' pixels, and what comes of it by hand.
    #[test]
    fn a_square_shares_the_factor_that_its_halves_tell() {
        let resolution = UVec2::new(16, 8);
        let spec = FilmSpec {
            resolution,
            ..FilmSpec::default()
        };
        let half = |offset: f32| {
            let mut film = Film::new(&spec);
            for (i, pixel) in film.pixels.iter_mut().enumerate() {
                let spread = if i % 2 == 0 { 1.0 } else { 3.0 };
                let values = [2.0 - spread, 2.0 + spread].map(|v| Rgb::splat(v + offset));
                *pixel = PixelStatistics::of(values);
            }
            film
        };
        let [a, b] = [half(0.0), half(0.5)];
        let film = Film::mean_of(&a, &b);
        let before = film.develop();
        assert_eq!(before.independent, None);
        let image = film.developed_halves(|pixel| {
            let known = pixel.x < 8;
            [&a, &b].map(|f| f.statistics(pixel).filter(|_| known).map(|p| p.mean()))
        });
        let image = image.image();
        assert_eq!(image.pixels, before.pixels);
        assert_eq!(image.independent, before.variance);
        let variances = image.variance.iter().flatten();
        let pairs = variances.zip(before.variance.iter().flatten());
        for (i, (variance, naive)) in pairs.enumerate() {
            // Naive: a quarter of twice s²/2 = spread². Differences: (0.5/2)² in every pixel.
            let spread: f32 = if i % 2 == 0 { 1.0 } else { 3.0 };
            assert_eq!(*naive, Rgb::splat(0.5 * spread * spread));
            let factor = if i % 16 < 8 { 0.0625 / 2.5 } else { 1.0 };
            let expected = 0.5 * spread * spread * factor;
            // Single precision, and the rounding of the factor here.
            assert!((*variance - expected).abs().max_element() < 4.0 * f32::EPSILON);
        }
    }

    /// Halves that are alike by chance, where one, two or four pixels of a square have the naive variance.
    #[test]
    fn halves_that_are_alike_do_not_make_a_pixel_noiseless() {
        let known = |pixels: usize| {
            let own = |i: usize| DVec3::splat(if i < pixels { 0.25 } else { 0.0 });
            factor((0..16).map(|i| (DVec3::splat(1e-9), own(i)))).x
        };
        assert!((known(1) - 0.0075).abs() < 1e-15);
        assert!((known(2) - 0.005).abs() < 1e-15);
        // 16 · 10⁻¹⁸ of 1.
        assert!(known(4) < 1e-16);
        assert_eq!(known(0), 1.0);
        // One pixel has light, and what the others have is a part of its variance.
        let lit = |i: usize| match i {
            0 => (DVec3::splat(1e-9), DVec3::splat(0.25)),
            _ => (DVec3::ZERO, DVec3::splat(0.125)),
        };
        assert!((factor((0..16).map(lit)).x - 0.0075).abs() < 1e-15);
        assert_eq!(factor((1..16).map(lit)).x, 0.01);
        // A difference that there is counts.
        let pixels = [
            (DVec3::splat(0.5), DVec3::splat(1.0)),
            (DVec3::ZERO, DVec3::ZERO),
        ];
        assert_eq!(factor(pixels.into_iter()).x, 0.25);
    }
}
