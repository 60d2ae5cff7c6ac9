//! Thumbnails of an image, its reference and where they differ.

use crate::cli::html::escaped;
use crate::film::Image;
use crate::math::Rgb;
use crate::math::color::srgb_from_linear;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::{ExtendedColorType, ImageFormat};
use std::fmt::Write;
use std::io::Cursor;

/// The longer side of a thumbnail, in pixels: three of them fit a card.
const SIDE: u32 = 160;

/// Standard errors at which the map of differences has its full color; noise alone brings few blocks above 4.
const FULL: f32 = 8.0;

/// What the mean of the brighter channels of a reference is shown as, in linear light: images are not always exposed for a screen.
const MIDDLE: f32 = 0.25;

/// Labels, and PNG files in base64.
#[derive(Clone, Debug, Default)]
pub(in crate::cli) struct Thumbnails(Vec<(&'static str, String)>);

impl Thumbnails {
    /// Of one image alone.
    pub(in crate::cli) fn one(label: &'static str, image: &Image) -> Thumbnails {
        let gain = gain(image);
        Thumbnails(
            encoded(label, image, |p| exposed(p, gain))
                .into_iter()
                .collect(),
        )
    }

    /// Of an image, its reference, and the signed t of blocks.
    pub(in crate::cli) fn of(image: &Image, reference: &Image, t: Option<&Image>) -> Thumbnails {
        let gain = gain(reference);
        let pictures = [
            encoded("image", image, |p| exposed(p, gain)),
            encoded("reference", reference, |p| exposed(p, gain)),
            t.and_then(|t| encoded("brighter or darker", t, signed)),
        ];
        Thumbnails(pictures.into_iter().flatten().collect())
    }

    pub(super) fn html(&self) -> String {
        let mut text = String::new();
        for (label, png) in &self.0 {
            let label = escaped(label);
            let _ = writeln!(
                text,
                "<figure><img alt=\"{label}\" src=\"data:image/png;base64,{png}\"><figcaption>{label}</figcaption></figure>"
            );
        }
        match text.is_empty() {
            true => text,
            false => format!("<div class=\"thumbnails\">\n{text}</div>\n"),
        }
    }
}

fn gain(image: &Image) -> f32 {
    let bright = image.pixels.iter().map(|p| f64::from(p.max_element()));
    let finite = bright.filter(|v| v.is_finite());
    let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    match sum > 0.0 {
        true => MIDDLE / (sum / count) as f32,
        false => 1.0,
    }
}

fn exposed(p: Rgb, gain: f32) -> [u8; 3] {
    // Casts saturate, and NaN becomes 0.
    (p * gain)
        .to_array()
        .map(|v| (255.0 * srgb_from_linear(v) + 0.5) as u8)
}

/// The channel that deviates most: warm where the image is brighter, cold where it is darker, black where it is neither.
fn signed(t: Rgb) -> [u8; 3] {
    let most = { t.to_array().into_iter() }.fold(0.0f32, |most, t| match t.abs() > most.abs() {
        true => t,
        false => most,
    });
    let part = (most.abs() / FULL).min(1.0);
    let [full, half] = [255.0 * part, 190.0 * part * part].map(|v| v as u8);
    match most > 0.0 {
        true => [full, half, half / 4],
        false => [half / 4, half, full],
    }
}

/// A PNG whose pixels are means of squares; small images are enlarged by whole numbers. `None` if there is nothing to see.
fn encoded(
    label: &'static str,
    image: &Image,
    color: impl Fn(Rgb) -> [u8; 3],
) -> Option<(&'static str, String)> {
    let size = image.bounds.size();
    let longest = size.max_element();
    let (shrink, grow) = (
        longest.div_ceil(SIDE).max(1),
        (SIDE / longest.max(1)).max(1),
    );
    let [width, height] = [size.x, size.y].map(|n| n.div_ceil(shrink) * grow);
    let mut bytes = Vec::with_capacity(3 * width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            bytes.extend(color(mean(image, [x / grow, y / grow], shrink)));
        }
    }
    let mut file = Cursor::new(Vec::new());
    let (form, png) = (ExtendedColorType::Rgb8, ImageFormat::Png);
    image::write_buffer_with_format(&mut file, &bytes, width, height, form, png).ok()?;
    Some((label, STANDARD.encode(file.into_inner())))
}

/// The mean over a square of pixels, by its place among the squares.
fn mean(image: &Image, [x, y]: [u32; 2], side: u32) -> Rgb {
    let size = image.bounds.size();
    let (mut sum, mut count) = (Rgb::ZERO, 0.0);
    for row in y * side..((y + 1) * side).min(size.y) {
        for column in x * side..((x + 1) * side).min(size.x) {
            let index = row as usize * size.x as usize + column as usize;
            sum += image.pixels.get(index).copied().unwrap_or(Rgb::ZERO);
            count += 1.0;
        }
    }
    sum / f32::max(count, 1.0)
}
