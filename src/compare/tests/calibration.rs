//! The false-alarm rate is as claimed, over 400 pairs of renders with the same expectation.
//!
//! Seeds are fixed: each test passes or fails permanently. Its tolerance is the binomial scatter of 400 pairs, ± 4.75
//! standard deviations, which a correct program exceeds once in 10⁶ changes of the seeds.

use super::super::*;
use super::simulate::{Random, Render, fireflies, mild, skewed};
use crate::math::UVec2;

const PAIRS: u64 = 400;

/// The requested rate; large, so that there are enough alarms to count.
const ALPHA: f64 = 0.05;

/// Side of the images: 144 pixels, 9 blocks of 4, 3 channels: 462 tests including the whole image.
const SIDE: u32 = 12;

/// The scatter of [`ALPHA`] over [`PAIRS`].
fn scatter(rate: f64) -> f64 {
    4.75 * (rate * (1.0 - rate) / PAIRS as f64).sqrt()
}

/// How often pairs made by `pair` are reported as different, with several options.
fn false_alarms<const N: usize>(
    ways: [Options; N],
    pair: impl Fn(u64) -> [Render; 2] + Sync,
) -> [f64; N] {
    let differ = |seed: u64| -> [bool; N] {
        let [a, b] = pair(seed);
        ways.each_ref().map(|options| {
            let comparison = compare(&a.estimate(), &b.estimate(), options);
            !comparison.expect("images of one size").agrees()
        })
    };
    let alarms: Vec<[bool; N]> = (0..PAIRS).into_par_iter().map(differ).collect();
    let rates = std::array::from_fn(|way| {
        alarms.iter().filter(|alarm| alarm[way]).count() as f64 / PAIRS as f64
    });
    println!("false alarms where {ALPHA} is asked: {rates:?}");
    rates
}

fn options(common_variance: bool) -> Options {
    Options {
        alpha: ALPHA,
        blocks: vec![1, 4],
        common_variance,
        ..Options::default()
    }
}

/// Renders with given numbers of samples, each variance from its own number of runs.
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

/// Normal noise, twice as many samples on one side, 12 and 24 observations for the variances: Welch's test has the
/// claimed rate, neither more nor much less; the common variance errs toward "agree".
#[test]
fn normal_noise() {
    let sidak = Options {
        correction: Correction::Sidak,
        ..options(false)
    };
    let ways = [options(false), sidak, options(true)];
    let [holm, sidak, common] = false_alarms(ways, pair(mild, [(12, 12), (24, 24)]));
    // Below the claim by design: the levels test the same pixels, which neither correction exploits. By no more than a
    // third.
    let range = ALPHA / 1.5 - scatter(ALPHA)..ALPHA + scatter(ALPHA);
    assert!(range.contains(&holm), "{holm}");
    assert!(range.contains(&sidak), "{sidak}");
    assert!(holm <= sidak && common <= holm, "{holm} {sidak} {common}");
}

/// Samples as from a path tracer, few in the image and many in the reference: a pixel has hit one light or none where
/// the reference has hit half a dozen. With the common variance, the rate is at most as claimed.
#[test]
fn rare_bright_samples() {
    let ways = [options(true), options(false)];
    let [common, naive] = false_alarms(ways, pair(fireflies, [(16, 16), (128, 16)]));
    assert!(common < ALPHA + scatter(ALPHA), "{common}");
    // The reason for the common variance: Welch's test alone raises false alarms here. The seeds are fixed; four times
    // the claim only shows that it is far exceeded.
    assert!(naive > 4.0 * ALPHA, "{naive}");
}

/// Skewed samples without such extremes.
#[test]
fn skewed_noise() {
    let [rate] = false_alarms([options(true)], pair(skewed, [(16, 16), (128, 16)]));
    assert!(rate < ALPHA + scatter(ALPHA), "{rate}");
    let [alike] = false_alarms([options(true)], pair(skewed, [(16, 16), (16, 16)]));
    assert!(alike < ALPHA + scatter(ALPHA), "{alike}");
}

/// Images without variances, made alike: their difference is symmetric whatever the noise.
#[test]
fn without_variances() {
    for draw in [mild, skewed, fireflies] {
        let pair = pair(draw, [(16, 16), (16, 16)]);
        let blind = |seed| pair(seed).map(Render::without_variance);
        let [rate] = false_alarms([options(true)], blind);
        assert!(rate < ALPHA + scatter(ALPHA), "{rate}");
    }
}

/// The same with eight times as many samples on one side: the difference is as skewed as the noise of the poorer image,
/// and symmetry fails. Twice the claimed rate is documented (`docs/compare.md`).
#[test]
fn without_variances_and_not_alike() {
    let pair = pair(skewed, [(16, 16), (128, 16)]);
    let blind = |seed| pair(seed).map(Render::without_variance);
    let [rate] = false_alarms([options(true)], blind);
    assert!(rate < 2.0 * ALPHA + scatter(2.0 * ALPHA), "{rate}");
}
