//! Makes the images of `tests/scenes/valid/textures`: one for each format that the reference
//! scenes' textures do not cover. Run from the project's folder.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

use image::{ImageFormat, Rgb, Rgb32FImage, RgbImage};
use std::path::Path;

fn main() -> Result<(), image::ImageError> {
    let folder = Path::new("tests/scenes/valid/textures");
    let ramp = RgbImage::from_fn(8, 6, |x, y| Rgb([x as u8 * 36, y as u8 * 51, 64]));
    ramp.save(folder.join("tiny.jpg"))?;
    // An ending in capitals, as cameras write it.
    ramp.save_with_format(folder.join("TINY2.JPEG"), ImageFormat::Jpeg)?;
    let bright = Rgb32FImage::from_fn(8, 6, |x, y| Rgb([x as f32, y as f32 * 0.1, 4.0]));
    bright.save(folder.join("tiny.hdr"))
}
