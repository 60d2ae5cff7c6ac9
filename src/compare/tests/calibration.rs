//! The false-alarm rate is what it claims to be, over 1,000 pairs of renders of one expectation.
//!
//! Seeds are fixed: each test passes or fails for ever. Its tolerance is the binomial scatter of 1,000
//! pairs, ± 4.75 standard deviations, which a right program leaves once in 10⁶ changes of the seeds.

use super::super::*;
use super::simulate::{Random, Render, fireflies, mild, skewed};
use crate::math::UVec2;

const PAIRS: u64 = 1000;

/// The rate that is asked for; large, that alarms are many enough to count.
const ALPHA: f64 = 0.05;

/// Side of the pictures: 144 pixels, 9 blocks of 4, 3 channels: 462 tests with the whole.
const SIDE: u32 = 12;

/// What [`ALPHA`] may scatter by among [`PAIRS`].
fn scatter(rate: f64) -> f64 {
    4.75 * (rate * (1.0 - rate) / PAIRS as f64).sqrt()
}

/// How often pairs made by `pair` are said to differ.
fn false_alarms(options: &Options, pair: impl Fn(u64) -> [Render; 2] + Sync) -> f64 {
    let alarms = (0..PAIRS).into_par_iter().filter(|&seed| {
        let [a, b] = pair(seed);
        let comparison = compare(&a.estimate(), &b.estimate(), options);
        !comparison.expect("pictures of one size").agrees()
    });
    alarms.count() as f64 / PAIRS as f64
}

fn options(common_variance: bool) -> Options {
    Options {
        alpha: ALPHA,
        blocks: vec![1, 4],
        common_variance,
        ..Options::default()
    }
}

/// Renders of so many samples, each variance from its own number of runs.
fn pair(
    draw: fn(UVec2, &mut Random) -> Rgb,
    [a, b]: [(u32, u32); 2],
) -> impl Fn(u64) -> [Render; 2] + Sync {
    move |seed| {
        [
            Render::new(2 * seed, SIDE, a.0, a.1, draw),
            Render::new(2 * seed + 1, SIDE, b.0, b.1, draw),
        ]
    }
}

/// Normal noise, twice as many samples on one side, 12 and 24 observations for the variances: Welch's
/// test keeps what it promises, neither more nor much less.
#[test]
fn normal_noise() {
    for correction in [Correction::Holm, Correction::Sidak] {
        let options = Options {
            correction,
            ..options(false)
        };
        let rate = false_alarms(&options, pair(mild, [(12, 12), (24, 24)]));
        // Below the claim by design: the levels look at the same pixels, which neither correction
        // makes use of. Not by more than a third.
        let range = ALPHA / 1.5 - scatter(ALPHA)..ALPHA + scatter(ALPHA);
        assert!(range.contains(&rate), "{correction:?}: {rate}");
    }
}

/// The common variance errs towards "agree" only.
#[test]
fn normal_noise_with_a_common_variance() {
    let rate = false_alarms(&options(true), pair(mild, [(12, 12), (24, 24)]));
    assert!(rate < ALPHA + scatter(ALPHA), "{rate}");
}

/// Samples as path tracers make them, few in the picture and many in the reference: a pixel has met one
/// lamp or none where the reference has met half a dozen. With the common variance at most the claim.
#[test]
fn rare_bright_samples() {
    let few_and_many = [(32, 32), (256, 16)];
    let rate = false_alarms(&options(true), pair(fireflies, few_and_many));
    assert!(rate < ALPHA + scatter(ALPHA), "{rate}");
    // The reason for the common variance: Welch's test alone cries wolf on these. The seeds are fixed;
    // 0.3 only says that it is far from 5 %.
    let naive = false_alarms(&options(false), pair(fireflies, few_and_many));
    assert!(naive > 0.3, "{naive}");
}

/// Skewed samples without such extremes.
#[test]
fn skewed_noise() {
    let rate = false_alarms(&options(true), pair(skewed, [(32, 32), (256, 16)]));
    assert!(rate < ALPHA + scatter(ALPHA), "{rate}");
    let alike = false_alarms(&options(true), pair(skewed, [(32, 32), (32, 32)]));
    assert!(alike < ALPHA + scatter(ALPHA), "{alike}");
}

/// Pictures without variances, made alike: their difference is symmetric whatever the noise.
#[test]
fn without_variances() {
    for draw in [mild, skewed, fireflies] {
        let pair = pair(draw, [(32, 32), (32, 32)]);
        let rate = false_alarms(&options(true), |seed| {
            pair(seed).map(Render::without_variance)
        });
        assert!(rate < ALPHA + scatter(ALPHA), "{rate}");
    }
}

/// The same with eight times as many samples on one side: the difference is as skewed as the noise of
/// the poorer picture, and symmetry fails. Twice the claim is stated (`docs/compare.md`).
#[test]
fn without_variances_and_not_alike() {
    let pair = pair(skewed, [(32, 32), (256, 16)]);
    let rate = false_alarms(&options(true), |seed| {
        pair(seed).map(Render::without_variance)
    });
    assert!(rate < 2.0 * ALPHA + scatter(2.0 * ALPHA), "{rate}");
}
