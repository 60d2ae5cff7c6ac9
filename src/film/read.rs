//! Reads images written by [`write()`](super::write()), and other programs' EXR files.

use super::exr::{CHANNELS, INDEPENDENT, VARIANCES};
use super::{Image, LightPathUse, PixelBounds};
use crate::assets::image_data::SizeLimit;
use crate::assets::openexr::{self, check_sizes};
use crate::budget::Budget;
use crate::files;
use crate::math::color::rgb_from_xyz;
use crate::math::{Rgb, UVec2};
use ::exr::meta::attribute::AttributeValue;
use ::exr::prelude::{AnyChannels, FlatSamples, Layer, Text};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// An image read from a file, with the sample counts from its header.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedImage {
    /// The image; with variances if the file has `var.R`, `var.G` and `var.B`.
    pub image: Image,
    /// Attribute `spp`: samples per pixel of one run.
    pub spp: Option<u32>,
    /// Attribute `runs`: number of independent renders averaged in the file. Without `degreesOfFreedom` the variance was then
    /// estimated from their scatter. `None` if a single render estimated it from its samples.
    pub runs: Option<u32>,
    /// Attribute `degreesOfFreedom`: of each variance, as far as the samples of one pixel tell it.
    pub freedom: Option<f64>,
    /// Attribute `variancePool`: see [`FilmMetadata::pool`](super::FilmMetadata::pool).
    pub pool: Option<u32>,
    /// Attributes `lightPaths` and `joinedPaths`: see [`FilmMetadata::light_paths`](super::FilmMetadata::light_paths).
    pub light_paths: Option<LightPathUse>,
    /// Attribute `denoised`: what has taken the noise out.
    pub denoised: Option<String>,
    /// The file has `X`, `Y` and `Z`, from which the colors are converted.
    pub from_xyz: bool,
}

/// Why an image could not be read; always names the file.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Missing, or not a readable EXR file.
    #[error("{}: cannot read: {reason}", .path.display())]
    Exr {
        /// The file's path.
        path: PathBuf,
        /// The decoder's message.
        reason: String,
    },
    /// The file is an EXR, but has no RGB image.
    #[error("{}: has no channels R, G and B", .0.display())]
    NoColor(PathBuf),
    /// The file is an EXR that has one or two of the channels R, G and B.
    #[error("{}: of the channels R, G and B it has only {found}", .path.display())]
    Partial {
        /// The file's path.
        path: PathBuf,
        /// Those that it has.
        found: String,
    },
    /// A data window that extends past the display window's left or upper edge, or is absurdly large.
    #[error("{}: its data window lies outside its display window", .0.display())]
    Window(PathBuf),
}

/// Reads an EXR file: channels `R` `G` `B`, and `var.R` `var.G` `var.B` if present; without these `X` `Y` `Z`, converted to linear
/// sRGB.
///
/// # Errors
/// See [`ReadError`].
pub fn read(path: &Path) -> Result<LoadedImage, ReadError> {
    read_within(path, &Budget::unlimited())
}

/// Like [`read`], with no more memory than is left of `budget`; the image is not charged to it.
///
/// # Errors
/// See [`ReadError`].
pub fn read_within(path: &Path, budget: &Budget) -> Result<LoadedImage, ReadError> {
    let unreadable = |reason: String| ReadError::Exr {
        path: path.to_owned(),
        reason,
    };
    let bytes = files::read_within(path, budget).map_err(|e| unreadable(e.to_string()))?;
    let limit = SizeLimit::for_file(bytes.len()).within(budget);
    check_sizes(&bytes, limit).map_err(unreadable)?;
    let file = openexr::part(&bytes).map_err(unreadable)?;
    let layer = &file.layer_data;
    let display = file.attributes.display_window;
    let (resolution, bounds) =
        window(layer, display).ok_or_else(|| ReadError::Window(path.to_owned()))?;
    let from_xyz = || {
        let pixels = colors(layer, XYZ)?.into_iter().map(rgb_from_xyz);
        Some(pixels.collect())
    };
    let own = colors(layer, CHANNELS);
    // Variances of other axes are not those of these.
    let variance = own.as_ref().and_then(|_| colors(layer, VARIANCES));
    let is_own = own.is_some();
    let pixels = own.or_else(from_xyz);
    let pixels = pixels.ok_or_else(|| no_color(path, layer))?;
    let independent = variance.as_ref().and_then(|_| colors(layer, INDEPENDENT));
    Ok(LoadedImage {
        image: Image {
            resolution,
            bounds,
            pixels,
            variance,
            independent,
            layers: Default::default(),
        },
        spp: number(&layer.attributes.other, "spp"),
        runs: number(&layer.attributes.other, "runs"),
        freedom: real(&layer.attributes.other, "degreesOfFreedom"),
        pool: number(&layer.attributes.other, "variancePool").filter(|&side| side > 0),
        light_paths: light_paths(&layer.attributes.other),
        denoised: text(&layer.attributes.other, "denoised"),
        from_xyz: !is_own,
    })
}

fn no_color(path: &Path, layer: &FlatLayer) -> ReadError {
    let channels = &layer.channel_data.list;
    let is_there = |name: &&str| {
        channels
            .iter()
            .any(|c| c.name.as_slice() == name.as_bytes())
    };
    let found: Vec<&str> = CHANNELS.iter().copied().filter(is_there).collect();
    let path = path.to_owned();
    match found.len() {
        // A file of one other channel is gray, whatever that is called.
        1 | 2 => ReadError::Partial {
            path,
            found: found.join(" and "),
        },
        _ => ReadError::NoColor(path),
    }
}

/// Channels of the CIE's colors, which some renderers write.
const XYZ: [&str; 3] = ["X", "Y", "Z"];

type FlatLayer = Layer<AnyChannels<FlatSamples>>;

/// Resolution and data window, relative to the display window's corner.
fn window(
    layer: &FlatLayer,
    display: ::exr::meta::attribute::IntegerBounds,
) -> Option<(UVec2, PixelBounds)> {
    let offset = |at: i32, origin: i32| u32::try_from(i64::from(at) - i64::from(origin)).ok();
    let position = layer.attributes.layer_position;
    let min = UVec2::new(
        offset(position.0, display.position.0)?,
        offset(position.1, display.position.1)?,
    );
    let size = UVec2::new(
        u32::try_from(layer.size.0).ok()?,
        u32::try_from(layer.size.1).ok()?,
    );
    let resolution = UVec2::new(
        u32::try_from(display.size.0).ok()?,
        u32::try_from(display.size.1).ok()?,
    );
    let max = UVec2::new(min.x.checked_add(size.x)?, min.y.checked_add(size.y)?);
    Some((resolution, PixelBounds::new(min, max)))
}

/// Three channels as colors; `None` if one is missing or subsampled.
fn colors(layer: &FlatLayer, names: [&str; 3]) -> Option<Vec<Rgb>> {
    let mut pixels = vec![Rgb::ZERO; layer.size.0.checked_mul(layer.size.1)?];
    for (i, name) in names.iter().enumerate() {
        let channel = layer
            .channel_data
            .list
            .iter()
            .find(|c| c.name.as_slice() == name.as_bytes())?;
        if channel.sample_data.len() != pixels.len() {
            return None;
        }
        for (pixel, value) in pixels.iter_mut().zip(channel.sample_data.values_as_f32()) {
            pixel[i] = value;
        }
    }
    Some(pixels)
}

/// A string; `None` if it is no text.
fn text(attributes: &HashMap<Text, AttributeValue>, name: &str) -> Option<String> {
    match attributes.get(&Text::from_slice_unchecked(name.as_bytes()))? {
        AttributeValue::Text(text) => Some(text.to_string()),
        _ => None,
    }
}

fn light_paths(attributes: &HashMap<Text, AttributeValue>) -> Option<LightPathUse> {
    let share = |name: &str| match attributes.get(&Text::from_slice_unchecked(name.as_bytes()))? {
        AttributeValue::F32(x) if x.is_finite() => Some(*x),
        _ => None,
    };
    Some(LightPathUse {
        per_sample: share("lightPaths")?,
        joined: share("joinedPaths")?,
    })
}

/// An integer that may be encoded as an integer, a float or a string.
fn number(attributes: &HashMap<Text, AttributeValue>, name: &str) -> Option<u32> {
    let value = attributes.get(&Text::from_slice_unchecked(name.as_bytes()))?;
    match value {
        AttributeValue::I32(n) => u32::try_from(*n).ok(),
        // 2³², the first that does not fit.
        AttributeValue::F32(x) if (0.0..4_294_967_296.0).contains(x) && x.fract() == 0.0 => {
            Some(*x as u32)
        }
        AttributeValue::Text(t) => std::str::from_utf8(t.as_slice()).ok()?.trim().parse().ok(),
        _ => None,
    }
}

/// A finite number of at least 0, encoded in the same ways.
fn real(attributes: &HashMap<Text, AttributeValue>, name: &str) -> Option<f64> {
    let value = attributes.get(&Text::from_slice_unchecked(name.as_bytes()))?;
    let value = match value {
        AttributeValue::I32(n) => f64::from(*n),
        AttributeValue::F32(x) => f64::from(*x),
        AttributeValue::F64(x) => *x,
        AttributeValue::Text(t) => std::str::from_utf8(t.as_slice())
            .ok()?
            .trim()
            .parse()
            .ok()?,
        _ => return None,
    };
    (value >= 0.0 && value.is_finite()).then_some(value)
}
