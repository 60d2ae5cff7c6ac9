//! Puts PNG images of one size beside each other. The README's image was made by
//!
//! ```sh
//! for lens in dgauss wide telephoto fisheye; do
//!     cargo run --release -- render scenes/course/$lens.pbrt --spp 256 -o /tmp/$lens.png
//! done
//! cargo run --release --features studies --example side_by_side -- \
//!     /tmp/dgauss.png /tmp/wide.png /tmp/telephoto.png /tmp/fisheye.png docs/course.png
//! ```

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

use image::{GenericImage, RgbImage};
use std::error::Error;

/// Pixels between two images.
const GAP: u32 = 8;

fn main() -> Result<(), Box<dyn Error>> {
    let mut names: Vec<String> = std::env::args().skip(1).collect();
    let output = names
        .pop()
        .ok_or("usage: side_by_side PICTURE... OUTPUT.png")?;
    let open = |name: &String| Ok(image::open(name)?.into_rgb8());
    let images = names
        .iter()
        .map(open)
        .collect::<Result<Vec<_>, Box<dyn Error>>>()?;
    let width: u32 = images.iter().map(|p| p.width() + GAP).sum();
    let height = images.iter().map(|p| p.height()).max().ok_or("no images")?;
    let mut sheet = RgbImage::from_pixel(width - GAP, height, image::Rgb([255; 3]));
    let mut x = 0;
    for image in &images {
        sheet.copy_from(image, x, 0)?;
        x += image.width() + GAP;
    }
    sheet.save(output)?;
    Ok(())
}
