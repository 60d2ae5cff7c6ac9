//! How far eight-bit images are from a long render, for `benches/peer/run.sh`.
//!
//! `peer_error REFERENCE.exr PICTURE.png…` prints a line for each image: the mean squared error of its linear
//! values, and its mean over the reference's, both over the pixels that no image has to clip.
//!
//! rs_pbrt writes eight-bit PNG only, so fstop's images are measured by theirs too. Rounding to eight bits
//! adds about 1/12 of a step squared, a percent or less of the errors that are compared, and the same to both.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]
#![allow(clippy::print_stdout)]

use fstop::film;
use fstop::math::Vec3;
use fstop::math::color::linear_from_srgb;
use std::path::Path;

/// Pixels with a channel above this in the reference are left out: what noise adds there may be clipped at 1.
const BRIGHTEST: f32 = 0.5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let reference = arguments
        .next()
        .ok_or("usage: peer_error REFERENCE.exr PICTURE.png…")?;
    let reference = film::read(Path::new(&reference))?.image;
    let kept: Vec<bool> = (reference.pixels.iter())
        .map(|p| p.max_element() <= BRIGHTEST)
        .collect();
    let count = kept.iter().filter(|&&k| k).count() as f64;
    for path in arguments {
        let picture = image::open(&path)?.to_rgb8();
        if picture.pixels().len() != kept.len() {
            return Err(format!("{}: not of the reference's size", path.display()).into());
        }
        let (mut squares, mut sum, mut expected) = (0.0, 0.0, 0.0);
        for ((pixel, reference), _) in (picture.pixels().zip(&reference.pixels))
            .zip(&kept)
            .filter(|(_, kept)| **kept)
        {
            let linear = Vec3::from_array(pixel.0.map(|v| linear_from_srgb(f32::from(v) / 255.0)));
            squares += f64::from((linear - *reference).length_squared());
            sum += f64::from(linear.element_sum());
            expected += f64::from(reference.element_sum());
        }
        println!("{:.6e} {:.5}", squares / (3.0 * count), sum / expected);
    }
    Ok(())
}
