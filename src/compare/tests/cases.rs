//! Images without noise, with unknown noise, with infinite and NaN values.

use super::super::*;
use super::simulate::{Render, mild};
use crate::math::UVec2;

fn estimate(image: &Image) -> Estimate<'_> {
    Estimate {
        image,
        freedom: 15.0,
        pool: None,
        samples: Some(64.0),
        light_paths: None,
    }
}

/// Without randomness, values must be equal within rounding.
#[test]
fn noiseless_images() {
    let mut a = Image::black(UVec2::splat(8));
    a.pixels.fill(Rgb::new(0.5, 1e-6, 0.0));
    a.variance = Some(vec![Rgb::ZERO; 64]);
    let agrees = |b: &Image| {
        let stored = compare(&estimate(&a), &estimate(b), &Options::default()).unwrap();
        // Whether the files or the caller says so.
        let [a, b] = [&a, b].map(|image| Image {
            variance: None,
            ..image.clone()
        });
        let options = Options {
            noise: Noise::None,
            ..Options::default()
        };
        let told = compare(&estimate(&a), &estimate(&b), &options).unwrap();
        assert_eq!(stored.agrees(), told.agrees());
        assert_eq!(told.noise, NoiseSource::None);
        stored.agrees()
    };
    assert!(agrees(&a));
    let mut rounded = a.clone();
    rounded.pixels[5] *= 1.0 + 5e-6;
    assert!(agrees(&rounded));
    // The residue of the conversion from XYZ in a channel that was black.
    rounded.pixels[5].z = 1e-6;
    assert!(agrees(&rounded));
    for change in [
        Rgb::new(1e-4, 0.0, 0.0),
        Rgb::new(0.0, 0.0, 1e-5),
        Rgb::NAN,
        Rgb::INFINITY,
    ] {
        let mut wrong = a.clone();
        wrong.pixels[5] += change;
        assert!(!agrees(&wrong), "{change}");
    }
}

/// A single sample has no variance; then the scatter of the difference is used.
#[test]
fn unknown_variances_are_none() {
    let mut a = Image::black(UVec2::splat(8));
    a.variance = Some(vec![Rgb::INFINITY; 64]);
    let b = a.clone();
    let single = |image| Estimate {
        image,
        freedom: 0.0,
        pool: None,
        samples: Some(1.0),
        light_paths: None,
    };
    let comparison = compare(&single(&a), &single(&b), &Options::default()).unwrap();
    assert_eq!(comparison.noise, NoiseSource::SpatialWithoutBoth);
    assert!(comparison.agrees());
    let options = Options {
        noise: Noise::Stored,
        ..Options::default()
    };
    let refused = compare(&single(&a), &single(&b), &options);
    assert_eq!(refused, Err(CompareError::NoVariance(Side::A)));
}

/// A pixel of unknown variance among others proves nothing; neither do negative variances.
#[test]
fn broken_variances_prove_nothing() {
    let mut a = Image::black(UVec2::splat(4));
    a.variance = Some(vec![Rgb::splat(1e-6); 16]);
    let mut b = a.clone();
    b.pixels[3] = Rgb::ONE;
    for unknown in [f32::INFINITY, f32::NAN, -1.0] {
        b.variance.as_mut().unwrap()[3] = Rgb::splat(unknown);
        let comparison = compare(&estimate(&a), &estimate(&b), &Options::default()).unwrap();
        let sentence = comparison.sentence();
        assert_eq!(
            comparison.answer(),
            Answer::CannotTell,
            "{unknown}: {sentence}"
        );
        assert_eq!(comparison.noise, NoiseSource::Stored);
    }
}

#[test]
fn one_image_with_variances_and_one_without() {
    let a = Render::new(1, 32, 16, 16, mild);
    let b = Render::new(2, 32, 16, 16, mild).without_variance();
    let options = Options::default();
    let comparison = compare(&a.estimate(), &b.estimate(), &options).unwrap();
    assert_eq!(comparison.noise, NoiseSource::SpatialWithout(Side::B));
    assert!(comparison.agrees());
    assert!(comparison.cautions()[0].starts_with("B has no usable variances"));
    let comparison = compare(&b.estimate(), &a.estimate(), &options).unwrap();
    assert_eq!(comparison.noise, NoiseSource::SpatialWithout(Side::A));
}

/// Infinite and NaN values: a difference if one image has them, a caution if both do.
#[test]
fn values_that_are_no_numbers() {
    let mut a = Render::new(1, 16, 16, 16, mild);
    let mut b = Render::new(2, 16, 16, 16, mild);
    a.image.pixels[17].x = f32::NAN;
    let comparison = compare(&a.estimate(), &b.estimate(), &Options::default()).unwrap();
    assert!(comparison.verdict.agrees() && !comparison.agrees());
    let sentence = comparison.sentence();
    assert!(
        sentence.contains("A has 1 pixel ") && sentence.contains("1, 1"),
        "{sentence}"
    );
    // The metrics cover all other pixels.
    assert!(comparison.metrics.mse.is_finite() && comparison.metrics.channels[0].ratio > 0.9);
    b.image.pixels[17].y = f32::INFINITY;
    let comparison = compare(&a.estimate(), &b.estimate(), &Options::default()).unwrap();
    assert!(comparison.agrees());
    assert!(comparison.cautions().iter().any(|c| c.contains("left out")));
}

/// Without variances, and with so few observations that no signs of them are significant, nothing can be found, however large it is.
#[test]
fn too_few_observations_prove_nothing() {
    let mut bright = Image::black(UVec2::splat(2));
    let dark = bright.clone();
    bright.pixels.fill(Rgb::splat(5.0));
    let options = Options::default();
    let comparison = compare(&estimate(&dark), &estimate(&bright), &options).unwrap();
    assert_eq!(comparison.answer(), Answer::CannotTell);
    assert!(comparison.findable[0].relative.is_infinite());
    // Equal ones are equal.
    let comparison = compare(&estimate(&bright), &estimate(&bright), &options).unwrap();
    assert_eq!(comparison.answer(), Answer::Agree);

    let [a, b] = [1, 2].map(|seed| Render::new(seed, 32, 64, 64, mild).without_variance());
    let answer = |cell| {
        let options = Options {
            cell,
            ..Options::default()
        };
        let comparison = compare(&a.estimate(), &b.estimate(), &options).unwrap();
        (comparison.answer(), comparison.sentence())
    };
    assert_eq!(answer(1).0, Answer::Agree);
    // Three pixels of many differ: no test finds them, but a black image would have been found.
    let mut c = b.image.clone();
    c.pixels[..3].fill(Rgb::splat(0.6));
    let comparison = compare(&b.estimate(), &estimate(&c), &options).unwrap();
    assert_eq!(
        comparison.answer(),
        Answer::Agree,
        "{}",
        comparison.sentence()
    );
    let (told, sentence) = answer(64);
    assert_eq!(told, Answer::CannotTell, "{sentence}");
    assert!(
        sentence.contains("the whole image could be black"),
        "{sentence}"
    );
}

#[test]
fn images_without_a_finite_pixel_are_not_said_to_agree() {
    let mut a = Image::black(UVec2::splat(4));
    a.pixels.fill(Rgb::NAN);
    let comparison = compare(&estimate(&a), &estimate(&a), &Options::default()).unwrap();
    assert_eq!(comparison.answer(), Answer::CannotTell);
    assert!(comparison.sentence().contains("no pixel has finite values"));
    a.pixels[3] = Rgb::ONE;
    let comparison = compare(&estimate(&a), &estimate(&a), &Options::default()).unwrap();
    assert_eq!(comparison.answer(), Answer::Agree);
}

/// Noise that is correlated between neighbors, as by a splatting filter, makes tests of blocks overconfident: this is
/// detected, and wider cells restore the rate.
#[test]
fn correlated_noise_is_noticed() {
    let blurred = |seed| {
        let sharp = Render::new(seed, 96, 4, 4, |_, random| {
            Rgb::splat(1.0 + random.normal() as f32)
        });
        let mut image = sharp.image.clone();
        for pixel in image.bounds.pixels() {
            let around = (0..16).map(|k| sharp.image.pixel(pixel + UVec2::new(k % 4, k / 4)));
            let index = image.bounds.index(pixel).unwrap();
            image.pixels[index] = around.sum::<Rgb>() / 16.0;
        }
        image.variance = None;
        image
    };
    let (a, b) = (blurred(1), blurred(2));
    let [a, b] = [&a, &b].map(|image| Estimate {
        image,
        freedom: 3.0,
        pool: None,
        samples: None,
        light_paths: None,
    });
    let comparison = compare(&a, &b, &Options::default()).unwrap();
    assert!(!comparison.agrees());
    assert!(comparison.neighbors.suspicious());
    assert!(comparison.cautions().iter().any(|c| c.contains("--cell")));
    // Squares of eight pixels, twice the filter's width: neighbors share an eighth of their noise instead of a quarter.
    let wide = Options {
        cell: 16,
        blocks: vec![],
        ..Options::default()
    };
    let fair = compare(&a, &b, &wide).unwrap();
    assert!(fair.agrees(), "{}", fair.sentence());
}

#[test]
fn images_that_cannot_be_compared() {
    let small = Image::black(UVec2::splat(4));
    let large = Image::black(UVec2::splat(5));
    let none = Image::black(UVec2::ZERO);
    let mut moved = small.clone();
    moved.bounds = PixelBounds::new(UVec2::splat(1), UVec2::splat(5));
    let options = Options::default();
    let refused = |a, b| compare(&estimate(a), &estimate(b), &options).unwrap_err();
    let size = refused(&small, &large);
    assert!(matches!(size, CompareError::Size(..)));
    assert!(
        size.to_string().contains("A is 4 × 4 pixels, B 5 × 5"),
        "{size}"
    );
    let window = refused(&small, &moved);
    assert!(window.to_string().contains("B x 1..5 y 1..5"), "{window}");
    assert_eq!(refused(&none, &none), CompareError::Empty);
}

/// Degenerate images and options have a verdict.
#[test]
fn odd_options() {
    let a = Image::black(UVec2::new(1, 1));
    for noise in [Noise::Auto, Noise::Spatial, Noise::None] {
        for blocks in [vec![], vec![0], vec![1, 1, u32::MAX]] {
            for cell in [0, 1, u32::MAX] {
                let options = Options {
                    noise,
                    blocks: blocks.clone(),
                    cell,
                    ..Options::default()
                };
                let comparison = compare(&estimate(&a), &estimate(&a), &options).unwrap();
                assert!(comparison.agrees() && comparison.verdict.p() == 1.0);
                assert!(comparison.sentence().contains("agree"));
                assert_eq!(
                    p_values(&estimate(&a), &estimate(&a), &options)
                        .unwrap()
                        .pixels
                        .len(),
                    1
                );
            }
        }
    }
}

/// What is known of all squares is summed up once, not for each pixel of a map, which took minutes for 300 × 300 pixels: here it would be
/// 262,144 times as many squares.
#[test]
fn a_map_of_a_large_image_with_pooled_variances() {
    let mut image = Image::black(UVec2::splat(512));
    image.variance = Some(vec![Rgb::ONE; 512 * 512]);
    let mut other = image.clone();
    other.pixels[7].y = 8.0;
    let [a, b] = [&image, &other].map(|image| Estimate {
        pool: Some(Pool {
            side: 4,
            freedom: 1.0,
        }),
        ..estimate(image)
    });
    let map = p_values(&a, &b, &Options::default()).unwrap();
    let different = map.pixels.iter().filter(|p| **p != Rgb::ONE);
    assert_eq!(different.count(), 1);
    assert!(map.pixels[7].y < 1e-3, "{}", map.pixels[7].y);
}
