//! Laws that hold for every kind of points.

use super::*;

fn kinds(spp: u32) -> Vec<SamplerSpec> {
    let grid = Stratified::new(1, 1, true, None);
    let stratified = SamplerSpec {
        points: Points::Stratified(grid),
        ..SamplerSpec::sobol(1)
    };
    vec![
        stratified.with_spp(spp),
        SamplerSpec::random(spp),
        SamplerSpec::sobol(spp),
        // Hammersley sets, as 3/4 of a power of two is not one.
        SamplerSpec::sobol(3 * spp / 4),
    ]
}

/// The draws of a made-up integrator: pairs and single numbers in mixed order.
fn draws(stream: &mut SampleStream) -> (Vec<Vec2>, Vec<f32>) {
    let (mut pairs, mut singles) = (Vec::new(), Vec::new());
    for round in 0..6 {
        pairs.push(stream.next_2d());
        singles.push(stream.next_1d());
        if round % 2 == 0 {
            singles.push(stream.next_1d());
            singles.push(stream.next_1d());
            singles.push(stream.next_1d());
        }
    }
    (pairs, singles)
}

fn pixel(x: i32, y: i32) -> IVec2 {
    IVec2::new(x, y)
}

#[test]
fn streams_depend_on_seed_pixel_index_and_order_only() {
    for spec in kinds(16) {
        let sampler = Sampler::new(&spec, 7);
        let again = Sampler::new(&spec, 7);
        let first = draws(&mut sampler.stream(pixel(-3, 8), 5));
        draws(&mut sampler.stream(pixel(1, 1), 2));
        assert_eq!(first, draws(&mut again.stream(pixel(-3, 8), 5)));
        for other in [
            Sampler::new(&spec, 8).stream(pixel(-3, 8), 5),
            sampler.stream(pixel(8, -3), 5),
            sampler.stream(pixel(-3, 9), 5),
            sampler.stream(pixel(-3, 8), 6),
            sampler.stream(pixel(-3, 8), 5 + (1 << 17)),
        ] {
            assert_ne!(first, draws(&mut other.clone()), "{spec:?}");
        }
    }
}

#[test]
fn streams_of_light_are_their_own() {
    for spec in kinds(16) {
        let sampler = Sampler::new(&spec, 7);
        let first = draws(&mut sampler.light_stream(5));
        assert_eq!(first, draws(&mut sampler.light_stream(5)));
        let others = [
            sampler.light_stream(6),
            sampler.light_stream(5 + (1 << 32)),
            sampler.half(0).light_stream(5),
            sampler.half(1).light_stream(5),
            Sampler::new(&spec, 8).light_stream(5),
            sampler.stream(pixel(0, 0), 5),
        ];
        for mut other in others {
            assert_ne!(first, draws(&mut other), "{spec:?}");
        }
    }
}

#[test]
fn paths_of_light_are_a_net_wherever_a_run_of_them_begins() {
    for first in [0, 1 << 20, 3 << 33] {
        let sampler = Sampler::new(&SamplerSpec::sobol(1), 5);
        let draw = |i: u64| draws(&mut sampler.light_stream(first + i)).0;
        let all: Vec<Vec<Vec2>> = (0..256).map(draw).collect();
        for d in 0..all[0].len() {
            let points: Vec<Vec2> = all.iter().map(|path| path[d]).collect();
            assert!((0..=8).all(|e| one_in_each_cell(&points, 1 << e, 1 << (8 - e))));
        }
    }
}

/// The draws of a fork after `before` pairs, of a fork of that, of another fork of the stream, and of the stream afterwards.
fn ways(sampler: &Sampler, index: u32, before: usize) -> [(Vec<Vec2>, Vec<f32>); 4] {
    let mut stream = sampler.stream(pixel(3, 4), index);
    (0..before).for_each(|_| stream.skip_2d());
    let mut first = stream.fork();
    let mut second = stream.fork();
    let mut below = first.fork();
    // In any order.
    [&mut first, &mut below, &mut second, &mut stream].map(draws)
}

#[test]
fn forks_have_numbers_of_their_own() {
    for spec in kinds(16) {
        let sampler = Sampler::new(&spec, 7);
        for before in 0..3 {
            let ways = ways(&sampler, 5, before);
            let mut singles: Vec<f32> = ways.iter().flat_map(|way| way.1.clone()).collect();
            singles.sort_unstable_by(f32::total_cmp);
            let count = singles.len();
            singles.dedup();
            // Two of these sixty numbers of 23 bits would be equal by chance once in 4,700 times.
            assert_eq!(singles.len(), count, "{spec:?}");
            let mut pairs: Vec<f32> = ways
                .iter()
                .flat_map(|way| way.0.clone())
                .map(|p| p.x)
                .collect();
            pairs.sort_unstable_by(f32::total_cmp);
            let count = pairs.len();
            pairs.dedup();
            assert_eq!(pairs.len(), count, "{spec:?}");
        }
    }
}

#[test]
fn forks_are_stratified_over_the_samples_of_a_pixel() {
    let grid = SamplerSpec {
        points: Points::Stratified(Stratified::new(8, 8, true, None)),
        ..SamplerSpec::sobol(64)
    };
    for spec in [SamplerSpec::sobol(64), grid] {
        let sampler = Sampler::new(&spec, 9);
        for before in 0..3 {
            let all: Vec<_> = (0..64).map(|i| ways(&sampler, i, before)).collect();
            for way in 0..4 {
                for d in 0..all[0][way].0.len() {
                    let points: Vec<Vec2> = all.iter().map(|ways| ways[way].0[d]).collect();
                    assert!(one_in_each_cell(&points, 8, 8), "{spec:?}, {way}, {d}");
                }
                for d in 0..all[0][way].1.len() {
                    let points: Vec<Vec2> = { all.iter() }
                        .map(|ways| Vec2::new(ways[way].1[d], 0.0))
                        .collect();
                    assert!(one_in_each_cell(&points, 64, 1), "{spec:?}, {way}, {d}");
                }
            }
        }
    }
}

#[test]
fn streams_stay_what_they_are() {
    // Recorded once: a change here changes every image, and shards and resumed renders with it.
    let expected = [
        (
            0.520_046_06,
            Vec2::new(0.372_550_67, 0.795_803_9),
            0.817_526_7,
        ),
        (
            0.443_835_85,
            Vec2::new(0.066_825_986, 0.370_440_72),
            0.450_106_8,
        ),
        (
            0.599_357_37,
            Vec2::new(0.745_258_45, 0.024_775_624),
            0.290_723_32,
        ),
        (
            0.057_935_22,
            Vec2::new(0.361_365_44, 0.471_708_54),
            0.755_257_1,
        ),
    ];
    for (spec, expected) in kinds(16).into_iter().zip(expected) {
        let mut stream = Sampler::new(&spec, 1).stream(pixel(12, 34), 5);
        let actual = (stream.next_1d(), stream.next_2d(), stream.next_1d());
        assert_eq!(actual, expected, "{spec:?}");
    }
}

/// What a pilot pass finds does not depend on the seed, and has other points than the image.
#[test]
fn pilot_passes_have_the_same_points_whatever_the_seed() {
    for spec in kinds(16) {
        let [a, b] = [1, 2].map(|seed| Sampler::new(&spec, seed));
        let first = |sampler: &Sampler| sampler.stream(pixel(12, 34), 5).next_2d();
        assert_eq!(first(&a.pilot()), first(&b.pilot()));
        assert_ne!(first(&a), first(&b));
        assert_ne!(first(&a), first(&a.pilot()));
    }
}

#[test]
fn numbers_lie_in_the_half_open_interval() {
    for spec in kinds(4096) {
        let sampler = Sampler::new(&spec, 3);
        for index in 0..4096 {
            let (pairs, singles) = draws(&mut sampler.stream(pixel(0, 0), index));
            let all = pairs.iter().flat_map(|p| [p.x, p.y]).chain(singles);
            for u in all {
                assert!((0.0..1.0).contains(&u), "{spec:?}: {u}");
            }
        }
    }
}

/// Each cell of an `nx` × `ny` grid holds exactly one of the points.
fn one_in_each_cell(points: &[Vec2], nx: u32, ny: u32) -> bool {
    let mut seen = vec![false; (nx * ny) as usize];
    for p in points {
        let cell = (p.x * nx as f32) as u32 + nx * (p.y * ny as f32) as u32;
        if std::mem::replace(&mut seen[cell as usize], true) {
            return false;
        }
    }
    seen.into_iter().all(|s| s)
}

/// All draws of one pixel: `[dimension][sample]`.
fn pixel_draws(
    sampler: &Sampler,
    at: IVec2,
    samples: std::ops::Range<u32>,
) -> (Vec<Vec<Vec2>>, Vec<Vec<f32>>) {
    let all: Vec<_> = samples.map(|i| draws(&mut sampler.stream(at, i))).collect();
    let pairs = (0..all[0].0.len())
        .map(|d| all.iter().map(|s| s.0[d]).collect())
        .collect();
    let singles = (0..all[0].1.len())
        .map(|d| all.iter().map(|s| s.1[d]).collect())
        .collect();
    (pairs, singles)
}

#[test]
fn stratified_hits_every_stratum_once_in_every_dimension() {
    for (nx, ny) in [(4, 4), (2, 2), (5, 3), (1, 7), (16, 16)] {
        let grid = Stratified::new(nx, ny, true, None);
        let spec = SamplerSpec {
            points: Points::Stratified(grid),
            ..SamplerSpec::sobol(nx * ny)
        };
        let sampler = Sampler::new(&spec, 11);
        // Also in the turn after the first.
        for first in [0, nx * ny] {
            let (pairs, singles) = pixel_draws(&sampler, pixel(5, 6), first..first + nx * ny);
            assert!(pairs.iter().all(|d| one_in_each_cell(d, nx, ny)));
            for d in singles {
                let flat: Vec<Vec2> = d.into_iter().map(|u| Vec2::new(u, 0.0)).collect();
                assert!(one_in_each_cell(&flat, nx * ny, 1));
            }
        }
    }
}

#[test]
fn dimensions_beyond_the_limit_are_random() {
    let grid = Stratified::new(8, 8, true, Some(2));
    let spec = SamplerSpec {
        points: Points::Stratified(grid),
        ..SamplerSpec::sobol(64)
    };
    let (pairs, singles) = pixel_draws(&Sampler::new(&spec, 1), pixel(0, 0), 0..64);
    let stratified: Vec<bool> = pairs.iter().map(|d| one_in_each_cell(d, 8, 8)).collect();
    // 64 random points fill 64 cells once each with probability 64!/64⁶⁴ ≈ 3e-27.
    assert_eq!(stratified, [true, true, false, false, false, false]);
    let flat = |d: &[f32]| d.iter().map(|&u| Vec2::new(u, 0.0)).collect::<Vec<_>>();
    assert!(
        one_in_each_cell(&flat(&singles[1]), 64, 1) && !one_in_each_cell(&flat(&singles[2]), 64, 1)
    );
}

#[test]
fn without_jitter_points_are_cell_centers() {
    let grid = Stratified::new(4, 2, false, None);
    let spec = SamplerSpec {
        points: Points::Stratified(grid),
        ..SamplerSpec::sobol(8)
    };
    let (pairs, _) = pixel_draws(&Sampler::new(&spec, 1), pixel(0, 0), 0..8);
    for p in pairs.iter().flatten() {
        assert_eq!(((p.x * 4.0).fract(), (p.y * 2.0).fract()), (0.5, 0.5));
    }
}

#[test]
fn sobol_pairs_are_nets() {
    // Any power of two of samples, in every pair, from the start and later.
    let sampler = Sampler::new(&SamplerSpec::sobol(256), 5);
    for first in [0u32, 1 << 16] {
        for log in 0..=8 {
            let (pairs, singles) = pixel_draws(&sampler, pixel(1, 2), first..first + (1 << log));
            for d in &pairs {
                assert!((0..=log).all(|e| one_in_each_cell(d, 1 << e, 1 << (log - e))));
            }
            for d in singles {
                let flat: Vec<Vec2> = d.into_iter().map(|u| Vec2::new(u, 0.0)).collect();
                assert!(one_in_each_cell(&flat, 1 << log, 1));
            }
        }
    }
}

#[test]
fn film_and_lens_are_a_net_together() {
    let sampler = Sampler::new(&SamplerSpec::sobol(256), 5);
    let mut seen = vec![false; 256];
    for index in 0..256 {
        let mut stream = sampler.stream(pixel(4, 7), index);
        let (film, _, lens) = (stream.next_2d(), stream.next_1d(), stream.next_2d());
        let quarters = [film.x, film.y, lens.x, lens.y].map(|u| (4.0 * u) as usize);
        let cell = quarters.iter().fold(0, |cell, q| 4 * cell + q);
        assert!(!std::mem::replace(&mut seen[cell], true), "{quarters:?}");
    }
}

/// The crate that the hash comes from has sequences of 65,536 points and 256 dimensions.
#[test]
fn sobol_goes_on_beyond_what_others_end_at() {
    let sampler = Sampler::new(&SamplerSpec::sobol(1 << 20), 5);
    let points: Vec<Vec2> = (0..1 << 17)
        .map(|index| {
            let mut stream = sampler.stream(pixel(1, 2), index);
            for _ in 0..300 {
                stream.next_1d();
            }
            stream.next_2d()
        })
        .collect();
    // None of them comes twice, then.
    assert!(one_in_each_cell(&points, 1 << 8, 1 << 9));
    // Nor does a dimension come again, or a sample at the far end of what can be asked for.
    let mut stream = sampler.stream(pixel(1, 2), u32::MAX);
    let numbers: std::collections::BTreeSet<u32> =
        (0..2000).map(|_| stream.next_1d().to_bits()).collect();
    // Of 2000 numbers of 23 bits 0.24 pairs are expected to be equal.
    assert!(numbers.len() > 1990, "{}", numbers.len());
    let mut last = sampler.stream(pixel(1, 2), u32::MAX - 1);
    assert_ne!(stream.next_2d(), last.next_2d());
}

#[test]
fn numbers_left_out_change_none_of_the_others() {
    for spec in kinds(16) {
        let sampler = Sampler::new(&spec, 3);
        for mask in 0..64u32 {
            let mut all = sampler.stream(pixel(4, 5), 6);
            let mut some = all;
            for round in 0..6 {
                let (one, two) = (all.next_1d(), all.next_2d());
                let needed = mask >> round & 1 == 1;
                let given = some.next_1d_if(needed);
                assert!(!needed || given == one, "{spec:?}");
                if mask >> (5 - round) & 1 == 1 {
                    assert_eq!(some.next_2d(), two, "{spec:?}");
                } else {
                    some.skip_2d();
                }
            }
        }
    }
}

/// Pearson's statistic of `counts` against equal expectations.
fn chi_squared(counts: &[f64]) -> f64 {
    let expected = counts.iter().sum::<f64>() / counts.len() as f64;
    counts
        .iter()
        .map(|c| (c - expected).powi(2) / expected)
        .sum()
}

#[test]
fn numbers_are_uniform_and_pixels_independent() {
    // One sample from each of many pixels: independent numbers whatever the points are. Each
    // dimension, each pair, and each number against its neighbor pixel's, in an 8 × 8 grid.
    for spec in kinds(16) {
        let sampler = Sampler::new(&spec, 99);
        let mut counts = vec![vec![0.0; 64]; 6 + 12 + 6];
        let cell = |x: f32, y: f32| (x * 8.0) as usize + 8 * (y * 8.0) as usize;
        for i in 0..20_000 {
            let (x, y) = (i % 141, i / 141);
            let index = i as u32 % spec.spp;
            let (pairs, singles) = draws(&mut sampler.stream(pixel(x, y), index));
            let (neighbors, _) = draws(&mut sampler.stream(pixel(x + 1000, y), index));
            for d in 0..6 {
                counts[d][cell(pairs[d].x, pairs[d].y)] += 1.0;
                counts[18 + d][cell(pairs[d].x, neighbors[d].x)] += 1.0;
            }
            for d in 0..12 {
                counts[6 + d][cell(singles[d], singles[d + 1])] += 1.0;
            }
        }
        for c in &counts {
            // 63 degrees of freedom; 96 tests in all; the 1e-6 quantile is 128.
            let statistic = chi_squared(c);
            assert!(statistic < 128.0, "{spec:?}: {statistic}");
        }
    }
}

#[test]
fn well_spread_points_estimate_with_less_noise() {
    // ∫∫ x·y² over the unit square is 1/6; the variance of one random sample is 1/15 − 1/36.
    let variance = |spec: &SamplerSpec, dimension: usize| {
        let sampler = Sampler::new(spec, 17);
        let pixels = 400;
        let mut sum = 0.0;
        for i in 0..pixels {
            let (pairs, _) = pixel_draws(&sampler, pixel(i, 0), 0..spec.spp);
            let points = &pairs[dimension];
            let mean = points
                .iter()
                .map(|p| f64::from(p.x * p.y * p.y))
                .sum::<f64>()
                / points.len() as f64;
            sum += (mean - 1.0 / 6.0).powi(2);
        }
        sum / f64::from(pixels)
    };
    let theory = (1.0 / 15.0 - 1.0 / 36.0) / 64.0;
    let [stratified, random, sobol] = [0, 1, 2].map(|k| variance(&kinds(64)[k], 3));
    // 400 squared errors: their mean is good to about 7 %.
    assert!((random / theory - 1.0).abs() < 0.3, "{random} but {theory}");
    // An 8 × 8 grid leaves the variance within cells, about 1/64 of that between them.
    assert!(stratified < theory / 20.0, "{stratified}");
    assert!(sobol < theory / 100.0, "{sobol}");
}

#[test]
fn counts_that_are_no_product_still_spread() {
    let grid = Stratified::new(4, 4, true, None);
    let spec = SamplerSpec {
        points: Points::Stratified(grid),
        ..SamplerSpec::sobol(16)
    };
    for n in [1, 2, 3, 7, 13, 32, 50, 97, 1000] {
        let spec = spec.clone().with_spp(n);
        assert_eq!(spec.spp, n);
        // Unbiased: over many pixels the mean of x is 1/2.
        let sampler = Sampler::new(&spec, 2);
        let pixels = 40_000 / n as i32 + 200;
        let mut sum = 0.0;
        for i in 0..pixels {
            for k in 0..n {
                sum += f64::from(sampler.stream(pixel(i, 7), k).next_2d().x);
            }
        }
        let count = f64::from(pixels) * f64::from(n);
        // Five standard deviations of as many independent numbers; stratified ones vary less.
        assert!(
            (sum / count - 0.5).abs() < 5.0 * (1.0 / 12.0 / count).sqrt(),
            "{n}"
        );
    }
}

#[test]
fn quick_looks_take_one_sample() {
    let [stratified, random, sobol] = [0, 1, 2].map(|k| kinds(16)[k].clone().quick());
    assert_eq!((stratified.spp, random.spp, sobol.spp), (1, 16, 1));
}
