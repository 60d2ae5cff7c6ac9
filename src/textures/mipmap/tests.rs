use super::*;
use crate::math::Rgb;
use crate::math::hash::{mix2, unit_float};

const EWA: Filter = Filter::Ewa {
    max_anisotropy: 8.0,
};

fn noise(width: usize, height: usize) -> Vec<f32> {
    (0..width * height)
        .map(|i| unit_float(mix2(i as u64, 7)))
        .collect()
}

fn point(s: f32, t: f32, dstdx: (f32, f32), dstdy: (f32, f32)) -> TextureCoordinates {
    TextureCoordinates {
        st: Vec2::new(s, t),
        dstdx: dstdx.into(),
        dstdy: dstdy.into(),
    }
}

fn finest(s: f32, t: f32) -> TextureCoordinates {
    point(s, t, (0.0, 0.0), (0.0, 0.0))
}

#[test]
fn without_a_footprint_texel_centers_are_exact() {
    let texels = noise(8, 4);
    for filter in [EWA, Filter::Trilinear] {
        let map = Mipmap::new(8, 4, texels.clone(), Wrap::Repeat, filter);
        for t in 0..4 {
            for s in 0..8 {
                let v = map.lookup(&finest((s as f32 + 0.5) / 8.0, (t as f32 + 0.5) / 4.0));
                assert_eq!(v, texels[t * 8 + s]);
            }
        }
        let between = map.lookup(&finest(2.0 / 8.0, 0.5 / 4.0));
        assert!((between - 0.5 * (texels[1] + texels[2])).abs() < 1e-6);
    }
}

#[test]
fn a_constant_image_is_constant_under_every_footprint() {
    for (width, height) in [(1, 1), (16, 16), (13, 7), (1, 5), (64, 3)] {
        for filter in [EWA, Filter::Trilinear] {
            for wrap in [Wrap::Repeat, Wrap::Clamp] {
                let map = Mipmap::new(
                    width,
                    height,
                    vec![Rgb::splat(0.7); width * height],
                    wrap,
                    filter,
                );
                for scale in [0.0, 1e-3, 0.02, 0.3, 1.0, 50.0] {
                    let at = point(0.31, 1.7, (scale, 0.2 * scale), (-0.1 * scale, 0.7 * scale));
                    // Normalized sums of equal values.
                    assert!((map.lookup(&at) - 0.7).abs().max_element() < 2e-6);
                }
            }
        }
    }
}

#[test]
fn filtering_keeps_the_mean() {
    // The mean of look-ups over a whole period is the image's mean, whatever the footprint.
    let texels = noise(32, 32);
    let mean = texels.iter().sum::<f32>() / texels.len() as f32;
    for filter in [EWA, Filter::Trilinear] {
        let map = Mipmap::new(32, 32, texels.clone(), Wrap::Repeat, filter);
        for (dx, dy) in [
            ((0.05, 0.0), (0.0, 0.05)),
            ((0.1, 0.05), (-0.01, 0.02)),
            ((0.4, 0.1), (0.0, 0.06)),
        ] {
            let n = 128;
            let sum: f64 = (0..n * n)
                .map(|i| {
                    let (s, t) = ((i % n) as f32 / n as f32, (i / n) as f32 / n as f32);
                    map.lookup(&point(s, t, dx, dy)) as f64
                })
                .sum();
            // The elliptical filter divides by the weights of whatever texels it meets, so a
            // texel's total weight is not exactly its share: a thousandth here.
            assert!(
                (sum / (n * n) as f64 - mean as f64).abs() < 2e-3,
                "{filter:?} {dx:?} {dy:?}"
            );
        }
    }
}

#[test]
fn a_wide_footprint_sees_the_mean() {
    let texels = noise(16, 64);
    let mean = texels.iter().sum::<f32>() / texels.len() as f32;
    for filter in [EWA, Filter::Trilinear] {
        let map = Mipmap::new(16, 64, texels.clone(), Wrap::Black, filter);
        let v = map.lookup(&point(0.5, 0.5, (4.0, 0.0), (0.0, 4.0)));
        assert!((v - mean).abs() < 1e-5);
    }
}

#[test]
fn elliptical_look_ups_follow_the_ellipse() {
    // Stripes along t: a footprint long in t stays sharp in s, one long in s blurs.
    let stripes: Vec<f32> = (0..64 * 64).map(|i| (i % 64 / 8 % 2) as f32).collect();
    let map = Mipmap::new(64, 64, stripes, Wrap::Repeat, EWA);
    let long_t = map.lookup(&point(12.0 / 64.0, 0.5, (0.02, 0.0), (0.0, 0.15)));
    let long_s = map.lookup(&point(12.0 / 64.0, 0.5, (0.15, 0.0), (0.0, 0.02)));
    assert!(long_t > 0.99, "{long_t}");
    assert!((0.3..0.8).contains(&long_s), "{long_s}");
    let square = Mipmap::new(
        64,
        64,
        vec![0.0f32; 64 * 64],
        Wrap::Repeat,
        Filter::Trilinear,
    );
    assert_eq!(
        square.lookup(&point(0.2, 0.5, (0.02, 0.0), (0.0, 0.15))),
        0.0
    );
}

/// [`Mipmap::ellipse`], a texel at a time.
fn one_by_one(map: &Mipmap<f32>, level: usize, st: Vec2, major: Vec2, minor: Vec2) -> f32 {
    let level = &map.levels[level];
    let p = st * level.size() - 0.5;
    let Some(Ellipse {
        form: [a, b, c],
        first,
        last,
    }) = Ellipse::new(p, major * level.size(), minor * level.size())
    else {
        panic!("{st} is far from the image");
    };
    let (mut sum, mut weights) = (0.0, 0.0);
    for t in first[1]..=last[1] {
        for s in first[0]..=last[0] {
            let (ds, dt) = (s as f32 - p.x, t as f32 - p.y);
            let r2 = a * ds * ds + b * ds * dt + c * dt * dt;
            if r2 < 1.0 {
                let weight = map.gaussian[((r2 * 128.0) as usize).min(127)];
                sum += level.texel(s.into(), t.into(), map.wrap) * weight;
                weights += weight;
            }
        }
    }
    sum * (1.0 / weights)
}

#[test]
fn four_texels_side_by_side_are_those_of_one_at_a_time() {
    for wrap in [Wrap::Repeat, Wrap::Black, Wrap::Clamp] {
        let map = Mipmap::new(64, 32, noise(64, 32), wrap, EWA);
        for i in 0..3000 {
            let r = |k: u64| unit_float(mix2(i, k));
            let size = 0.3 * r(1) * r(2);
            let (sin, cos) = (6.3 * r(3)).sin_cos();
            let major = Vec2::new(cos, sin) * size;
            let minor = Vec2::new(-sin, cos) * size * (0.03 + r(4));
            let st = Vec2::new(3.0 * r(5) - 1.0, 3.0 * r(6) - 1.0);
            for level in [0, 2] {
                let found = map.ellipse(level, st, major, minor);
                let expected = one_by_one(&map, level, st, major, minor);
                assert_eq!(found.to_bits(), expected.to_bits(), "{st} {major} {minor}");
            }
        }
    }
}

#[test]
fn outside_follows_the_wrap_mode() {
    let texels = noise(4, 4);
    let value = |wrap, s, t| Mipmap::new(4, 4, texels.clone(), wrap, EWA).lookup(&finest(s, t));
    assert_eq!(value(Wrap::Repeat, 1.125, -0.875), texels[0]);
    assert_eq!(value(Wrap::Black, 1.625, 0.5), 0.0);
    assert_eq!(value(Wrap::Clamp, 5.0, -3.0), texels[3]);
    assert_eq!(value(Wrap::Clamp, -5.0, 0.125), texels[0]);
}

#[test]
fn other_sizes_are_enlarged_to_powers_of_two() {
    let ramp: Vec<f32> = (0..12 * 3).map(|i| (i % 12) as f32).collect();
    let map = Mipmap::new(12, 3, ramp, Wrap::Clamp, EWA);
    assert_eq!(
        (map.levels[0].width, map.levels[0].height, map.levels.len()),
        (16, 4, 5)
    );
    // A linear ramp stays one away from its ends (the filter reproduces it to a few per cent
    // of a step), and every row is the same.
    for s in 3..13 {
        let expected = (s as f32 + 0.5) * 12.0 / 16.0 - 0.5;
        for t in 0..4 {
            assert!((map.levels[0].texels[t * 16 + s] - expected).abs() < 0.05);
        }
    }
    let spike = Mipmap::new(3, 1, vec![0.0f32, 1.0, 0.0], Wrap::Black, EWA);
    assert!(
        spike.levels[0].texels.iter().all(|&v| v >= 0.0),
        "the filter's negative lobes are cut"
    );
}

#[test]
fn sides_that_are_powers_of_two_already_are_left_alone() {
    for taps in enlarging_taps(8, 8, Wrap::Repeat)
        .iter()
        .enumerate()
        .map(|(i, t)| t.sum(|j| (i == j) as u8 as f32))
    {
        assert!((taps - 1.0).abs() < 1e-6);
    }
}

#[test]
fn wild_look_ups_return_in_finite_time() {
    let numbers = [0.0, 1e-30, 0.1, 1e7, 1e30, f32::INFINITY, f32::NAN, -1e30];
    for filter in [
        EWA,
        Filter::Ewa {
            max_anisotropy: f32::INFINITY,
        },
        Filter::Trilinear,
    ] {
        for wrap in [Wrap::Repeat, Wrap::Black, Wrap::Clamp] {
            let map = Mipmap::new(8, 4, noise(8, 4), wrap, filter);
            for a in numbers {
                for b in numbers {
                    for c in numbers {
                        map.lookup(&point(a, 0.3, (b, 0.0), (0.0, c)));
                        map.lookup(&point(0.2, a, (b, c), (c, 1e-3)));
                    }
                }
            }
        }
    }
}
