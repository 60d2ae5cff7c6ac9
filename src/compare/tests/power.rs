//! Power: which differences are found.

use super::super::*;
use super::simulate::{Random, Render, mild};
use crate::math::UVec2;

const SIDE: u32 = 64;

/// A bias in the upper left quarter of the image.
fn biased(factor: f32) -> impl Fn(UVec2, &mut Random) -> Rgb {
    move |pixel, random| {
        let quarter = pixel.cmplt(UVec2::splat(SIDE / 2)).all();
        mild(pixel, random) * if quarter { factor } else { 1.0 }
    }
}

/// 1 % on a quarter of 64 × 64 pixels, 64 samples per pixel with 30 % noise each (so 3.75 % per pixel): the quarter's
/// mean is known to 3.75 % √2 / 32 = 0.17 %, and 1 % is 6 of these. Found in each of 10 pairs: with 3 channels and p <
/// 10⁻³ among 3,207 tests on four levels, 5 standard errors in one channel are enough, which all three miss once in 400
/// pairs (fixed seeds).
#[test]
fn one_per_cent_on_a_quarter() {
    for seed in 0..10 {
        let a = Render::new(2 * seed, SIDE, 64, 64, biased(1.01));
        let b = Render::new(2 * seed + 1, SIDE, 64, 16, mild);
        let comparison = compare(&a.estimate(), &b.estimate(), &Options::default()).unwrap();
        assert!(!comparison.agrees(), "{seed}: {}", comparison.sentence());
        let quarter = comparison
            .verdict
            .levels
            .iter()
            .find(|l| l.side == Some(32));
        assert_eq!(quarter.unwrap().worst.bounds.min, UVec2::ZERO);
        // The converse of the calibration: the same pair without bias.
        let a = Render::new(2 * seed, SIDE, 64, 64, biased(1.0));
        let comparison = compare(&a.estimate(), &b.estimate(), &Options::default()).unwrap();
        assert!(comparison.agrees(), "{seed}: {}", comparison.sentence());
    }
}

/// The same images without their variances: nothing is lost, as the scatter in a block of 1024 pixels is well known.
#[test]
fn one_per_cent_on_a_quarter_without_variances() {
    for seed in 0..10 {
        let a = Render::new(2 * seed, SIDE, 64, 64, biased(1.01)).without_variance();
        let b = Render::new(2 * seed + 1, SIDE, 64, 64, mild).without_variance();
        let comparison = compare(&a.estimate(), &b.estimate(), &Options::default()).unwrap();
        assert_eq!(comparison.noise, NoiseSource::SpatialWithoutBoth);
        assert!(!comparison.agrees(), "{seed}: {}", comparison.sentence());
    }
}

/// Differences that no single test can prove show in the distribution of all p-values: every pixel is off by 4 %, up or
/// down, about one standard error.
#[test]
fn many_slight_differences_bend_the_distribution() {
    let checked = |pixel: UVec2, random: &mut Random| {
        mild(pixel, random)
            * if (pixel.x / 4).is_multiple_of(2) {
                1.04
            } else {
                0.96
            }
    };
    let a = Render::new(1, SIDE, 64, 64, checked);
    let b = Render::new(2, SIDE, 64, 64, mild);
    let comparison = compare(&a.estimate(), &b.estimate(), &Options::default()).unwrap();
    let pixels = &comparison.uniformity[0];
    assert!(pixels.side == 1 && pixels.too_small(), "{pixels:?}");
    // So do neighbors, three of four of which share a sign.
    assert!(comparison.neighbors.suspicious());
    let fair = Render::new(1, SIDE, 64, 64, mild);
    let comparison = compare(&fair.estimate(), &b.estimate(), &Options::default()).unwrap();
    assert!(comparison.uniformity.iter().all(|u| u.p > 1e-3));
    assert!(!comparison.neighbors.suspicious());
}

#[test]
fn one_wrong_pixel() {
    let mut a = Render::new(1, SIDE, 64, 64, mild);
    let b = Render::new(2, SIDE, 160, 16, mild);
    a.image.pixels[1000].z *= 1.5;
    let options = Options::default();
    let verdict = compare(&a.estimate(), &b.estimate(), &options)
        .unwrap()
        .verdict;
    let pixels = &verdict.levels[0];
    assert!(!verdict.agrees());
    assert_eq!(
        (pixels.tests, pixels.worst.channel, pixels.rejected),
        (3 * 4096, 2, 1)
    );
    assert_eq!(pixels.worst.bounds.min, UVec2::new(1000 % 64, 1000 / 64));
    let map = p_values(&a.estimate(), &b.estimate(), &options).unwrap();
    assert!(map.pixels[1000].z < 1e-7 && map.pixels[1000].x > 1e-7);
}

/// An edge that has moved by a pixel, in images that are otherwise equal and not declared noiseless.
#[test]
fn a_moved_edge_without_variances() {
    let drawn = |edge: u32| {
        let mut image = crate::film::Image::black(UVec2::splat(SIDE));
        for (pixel, p) in image.bounds.pixels().zip(&mut image.pixels) {
            // An object with its shadow: bright left of the middle, dark right of it.
            *p = Rgb::splat(if (edge..edge + 20).contains(&pixel.x) {
                0.9
            } else {
                0.5
            });
        }
        image
    };
    let (a, b) = (drawn(20), drawn(21));
    let [a, b] = [&a, &b].map(|image| Estimate {
        image,
        freedom: f64::INFINITY,
        pool: None,
        samples: None,
        light_paths: None,
    });
    let comparison = compare(&a, &b, &Options::default()).unwrap();
    assert!(!comparison.agrees(), "{}", comparison.sentence());
    assert!(comparison.neighbors.correlation.is_finite());
}

/// What is said to be found is found: a difference of all of the image, as large as the comparison says. 95 of a hundred
/// pairs, less three binomial standard deviations (2.2 each) and one for the half step of the quantiles; of half the
/// difference, which is 5.8 / 2 = 2.9 standard errors where 4.2 are needed, few.
#[test]
fn what_is_promised_is_found() {
    let options = Options {
        common_variance: false,
        blocks: vec![8],
        ..Options::default()
    };
    let mut found = [0, 0];
    for seed in 0..100 {
        let a = Render::new(2 * seed, 32, 64, 64, mild);
        let b = Render::new(2 * seed + 1, 32, 64, 64, mild);
        let promise = compare(&a.estimate(), &b.estimate(), &options).unwrap();
        let whole = promise.findable.iter().find(|f| f.side.is_none()).unwrap();
        assert_eq!(
            (promise.answer(), promise.findable.len()),
            (Answer::Agree, 2)
        );
        for (part, found) in [1.0, 0.5].into_iter().zip(&mut found) {
            let mut brighter = a.image.clone();
            // In one channel alone, as the promise is of.
            for pixel in &mut brighter.pixels {
                pixel[whole.channel] *= 1.0 + part * whole.relative as f32;
            }
            let brighter = Estimate {
                image: &brighter,
                ..a.estimate()
            };
            let verdict = compare(&brighter, &b.estimate(), &options).unwrap().verdict;
            *found += u32::from(verdict.levels[1].rejected > 0);
        }
    }
    assert!(found[0] >= 88 && found[1] <= 50, "{found:?}");
}

/// A caustic that samples hardly ever meet: 13 of those of B do, so that it has none once in 500,000 pairs, and 0.8 of A's, which
/// is 95 times too dark without. No comparison says that the images agree.
#[test]
fn what_is_never_met_is_not_agreed_upon() {
    let with_caustic = |pixel: UVec2, random: &mut Random| {
        if pixel.cmplt(UVec2::splat(32)).all() {
            let light = if random.uniform() < 5e-5 { 2e4 } else { 0.0 };
            Rgb::splat(1.0 / 95.0 + light)
        } else {
            mild(pixel, random)
        }
    };
    let mut answers = [0, 0, 0];
    for seed in 0..10 {
        let a = Render::new(2 * seed, SIDE, 16, 16, with_caustic);
        let b = Render::new(2 * seed + 1, SIDE, 256, 256, with_caustic);
        let comparison = compare(&a.estimate(), &b.estimate(), &Options::default()).unwrap();
        answers[comparison.answer() as usize] += 1;
        if comparison.answer() == Answer::CannotTell {
            let doubt = comparison.doubt().unwrap();
            assert_eq!(doubt.bounds.min, UVec2::ZERO);
            // Where k samples of B meet it, its variance counts for the 16 samples of A, too: k 16 / (16 + 256) effective ones. More than
            // 34, where 13 are expected, are met once in a million.
            let effective = doubt.effective_samples;
            assert!(effective > 0.0 && effective <= 2.0, "{doubt:?}");
            assert!(comparison.sentence().starts_with("It cannot be told"));
        }
    }
    // The expectation is the same: "differ" would be a false alarm.
    assert_eq!(answers, [0, 0, 10]);
}

/// Where there are so many light paths for each sample.
fn using(render: &Render, per_sample: f32) -> Estimate<'_> {
    Estimate {
        light_paths: Some(LightPathUse {
            per_sample,
            joined: 0.0,
        }),
        ..render.estimate()
    }
}

/// An eighth of the light comes to A by one sample in 1024, and to B by light paths in equal parts. A's blocks that lack some of it are no alarm; without
/// knowing of the light paths nearly each pair is one. That A is a quarter too dark is found all the same.
#[test]
fn light_that_one_image_has_from_light_paths() {
    let rare = |scale: f32| {
        move |pixel: UVec2, random: &mut Random| {
            let light = if random.uniform() < 1.0 / 1024.0 {
                128.0
            } else {
                0.0
            };
            scale * (mild(pixel, random) + light)
        }
    };
    let even = |pixel: UVec2, random: &mut Random| mild(pixel, random) + 0.125;
    let differ = |a: &Estimate, b: &Estimate| {
        let comparison = compare(a, b, &Options::default()).unwrap();
        u32::from(comparison.answer() == Answer::Differ)
    };
    let (mut alarms, mut unaware, mut found) = (0, 0, 0);
    for seed in 0..20 {
        let a = Render::new(3 * seed, SIDE, 16, 16, rare(1.0));
        let b = Render::new(3 * seed + 1, SIDE, 256, 16, even);
        let dark = Render::new(3 * seed + 2, SIDE, 16, 16, rare(0.75));
        alarms += differ(&using(&a, 0.0), &using(&b, 0.5));
        unaware += differ(&a.estimate(), &b.estimate());
        found += differ(&using(&dark, 0.0), &using(&b, 0.5));
    }
    assert!(
        alarms == 0 && unaware >= 10 && found == 20,
        "{alarms} {unaware} {found}"
    );
}

/// What would be found grows with the light that may be missed: a difference of just that much is as many standard errors as the test and its power take,
/// whichever image is first.
#[test]
fn light_that_may_be_missed_is_part_of_the_promise() {
    let image = |variance: f32| {
        let mut image = Image::black(UVec2::splat(8));
        image.pixels.fill(Rgb::ONE);
        image.variance = Some(vec![Rgb::splat(variance); 64]);
        image
    };
    // Portions of a quarter, and light that light paths know well.
    let (rare, known) = (image(1.0 / 16.0), image(1e-4));
    let using = |image, per_sample| Estimate {
        image,
        freedom: f64::INFINITY,
        pool: None,
        samples: Some(16.0),
        light_paths: Some(LightPathUse {
            per_sample,
            joined: 0.0,
        }),
    };
    let whole = |a: Estimate, b: Estimate| {
        let found = findable(&a, &b, &Options::default()).unwrap();
        *found.iter().find(|f| f.side.is_none()).unwrap()
    };
    let alike = whole(using(&rare, 0.5), using(&known, 0.5));
    let unlike = whole(using(&rare, 0.0), using(&known, 0.5));
    assert_eq!(unlike, whole(using(&known, 0.5), using(&rare, 0.0)));
    // (q e)² = d² where e is known, and (q e)² + q² d p = d² where portions p are added, by the same q.
    let error = (2.0f64 / 16.0 / 64.0).sqrt();
    let quantiles = alike.relative / error;
    let with_portion = error.hypot((0.25 * unlike.relative / 64.0).sqrt());
    // The tolerance of 1e-5 that both have.
    assert!(
        (unlike.relative / (quantiles * with_portion) - 1.0).abs() < 1e-3,
        "{alike:?} {unlike:?}"
    );
    assert!(
        unlike.relative > 1.2 * alike.relative,
        "{alike:?} {unlike:?}"
    );
    // Of one unit of light.
    let effective = with_portion.powi(-2);
    assert!((unlike.effective_samples / effective - 1.0).abs() < 1e-12);
}
