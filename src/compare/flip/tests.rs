//! FLIP against its authors' own program, and invariants for any images.

use super::*;
use crate::film::PixelBounds;
use crate::math::UVec2;

const SIZE: UVec2 = UVec2::new(40, 32);

/// Texture, a flat patch with sharp edges, a gradient: integers and powers of two only.
fn reference() -> Image {
    let mut image = Image::black(SIZE);
    for (pixel, p) in PixelBounds::new(UVec2::ZERO, SIZE)
        .pixels()
        .zip(&mut image.pixels)
    {
        let (x, y) = (pixel.x, pixel.y);
        let texture = |c: u32| (x * x * (3 + c) + y * y * 7 + x * y * (5 - c) + c * 91) % 97;
        *p = Rgb::from([0, 1, 2].map(|c| texture(c) as f32 / 96.0));
        if (10..20).contains(&x) && (8..20).contains(&y) {
            *p = Rgb::new(0.75, 0.25, 0.125);
        }
        if x >= 28 {
            *p = Rgb::new(x as f32 / 64.0, y as f32 / 64.0, 0.5);
        }
    }
    image
}

/// The same image with a darker stripe, a white pixel and a reddish patch.
fn changed() -> Image {
    let mut image = reference();
    let bounds = image.bounds;
    for (pixel, p) in bounds.pixels().zip(&mut image.pixels) {
        let (x, y) = (pixel.x, pixel.y);
        if (12..16).contains(&y) && (5..25).contains(&x) {
            *p *= 0.75;
        }
        if (x, y) == (30, 20) {
            *p = Rgb::ONE;
        }
        if (2..9).contains(&y) && (30..38).contains(&x) {
            p.x += 0.0625;
        }
    }
    image
}

/// Squared, eight times as bright, with an emitter.
fn high_dynamic_range(mut image: Image, emitter: Rgb) -> Image {
    for p in &mut image.pixels {
        *p = *p * *p * 8.0 + 0.0625;
    }
    image.pixels[25 * 40 + 5] = emitter;
    image
}

fn check(map: &FlipMap, mean: f64, pixels: &[(usize, usize, f32)]) {
    // Both use single precision, with other powers and sums; the square root of small feature differences doubles the
    // relative error.
    assert!((map.mean() - mean).abs() < 2e-5, "{} {mean}", map.mean());
    for &(x, y, value) in pixels {
        let ours = map.values[y * 40 + x];
        assert!((ours - value).abs() < 2e-4, "{x}, {y}: {ours} {value}");
    }
}

/// Values of the authors' program (PyPI `flip-evaluator` 1.7) for the same images.
#[test]
fn ldr_agrees_with_its_authors() {
    let (a, b) = (changed(), reference());
    let map = ldr(&a, &b, PIXELS_PER_DEGREE);
    check(
        &map,
        0.0509926900267601,
        &[
            (0, 0, 0.0),
            (7, 13, 0.31343025),
            (22, 12, 0.30569127),
            (30, 20, 0.32985908),
            (33, 5, 0.16884261),
            (39, 31, 0.0),
            (15, 20, 0.034713257),
        ],
    );
    check(&ldr(&b, &a, PIXELS_PER_DEGREE), 0.0509926900267601, &[]);
    check(&ldr(&a, &b, 20.0), 0.04142330586910248, &[]);
}

#[test]
fn hdr_agrees_with_its_authors() {
    let a = high_dynamic_range(changed(), Rgb::new(32.0, 48.0, 64.0));
    let b = high_dynamic_range(reference(), Rgb::new(64.0, 48.0, 32.0));
    let exposures = ExposureRange::of(&b);
    // The authors' median is the mean of the two middle values, ours the upper one, and the luminance weights differ in
    // the fifth digit.
    assert!((exposures.start - -4.567651).abs() < 1e-3, "{exposures:?}");
    assert!((exposures.stop - 0.571467).abs() < 2e-2, "{exposures:?}");
    assert_eq!(exposures.count, 6);
    let exposures = ExposureRange {
        start: -4.567_651_3,
        stop: 0.571_467_04,
        count: 6,
    };
    check(
        &hdr(&a, &b, &exposures, PIXELS_PER_DEGREE),
        0.06575425714254379,
        &[
            (0, 0, 0.0),
            (7, 13, 0.37634748),
            (22, 12, 0.34875363),
            (30, 20, 0.44731063),
            (33, 5, 0.22786614),
            (5, 25, 0.05460135),
            (15, 20, 0.048866916),
        ],
    );
}

/// The papers' scale: 0 for equal images, 1 for green against blue, the largest possible difference.
#[test]
fn ends_of_the_scale() {
    let b = reference();
    assert_eq!(ldr(&b, &b, PIXELS_PER_DEGREE).max(), 0.0);
    let flat = |rgb| Image {
        pixels: vec![rgb; b.pixels.len()],
        ..b.clone()
    };
    let most = ldr(&flat(Rgb::Y), &flat(Rgb::Z), PIXELS_PER_DEGREE);
    assert!((most.mean() - 1.0).abs() < 1e-5);
    assert!((most.quantile(0.0) - 1.0).abs() < 1e-5);
}

/// Rotating both images by half a turn does not change the error, and images of different sizes have none.
#[test]
fn turned_and_mismatched_images() {
    let turned = |mut image: Image| {
        image.pixels.reverse();
        image
    };
    let map = ldr(&changed(), &reference(), PIXELS_PER_DEGREE);
    let mut other = ldr(&turned(changed()), &turned(reference()), PIXELS_PER_DEGREE);
    other.values.reverse();
    for (p, q) in map.values.iter().zip(&other.values) {
        // Sums in another order.
        assert!((p - q).abs() < 1e-4);
    }
    assert!(
        ldr(&Image::black(UVec2::ONE), &reference(), 67.0)
            .values
            .is_empty()
    );
    let none = Image::black(UVec2::ZERO);
    assert_eq!(ldr(&none, &none, 67.0).mean(), 0.0);
}
