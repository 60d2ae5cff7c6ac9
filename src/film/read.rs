//! Reads images written by [`write()`](super::write()), and other programs' EXR files.

use super::exr::{CHANNELS, INDEPENDENT, VARIANCES};
use super::{Image, LightPathUse, PixelBounds};
use crate::assets::image_data::SizeLimit;
use crate::assets::openexr::{self, Chosen, check_sizes, choose_channels};
use crate::budget::Budget;
use crate::files;
use crate::math::color::rgb_from_xyz;
use crate::math::{Rgb, UVec2};
use ::exr::meta::attribute::{AttributeValue, Chromaticities};
use ::exr::prelude::{AnyChannels, FlatSamples, Layer, Text};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// An image read from a file, with the sample counts from its header.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedImage {
    /// The image; with variances if the file has `var.R`, `var.G` and `var.B`.
    pub image: Image,
    /// Attribute `spp`: samples per pixel of one run; a file that says 0 does not know.
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
    /// The corner of the display window, in the coordinates of `bounds`: (0, 0) unless the data window begins left of it or above
    /// it, where that column or row is 0.
    pub display: UVec2,
    /// Attribute `chromaticities`, if these are not Rec. 709's: x and y of red, green, blue and white.
    pub primaries: Option<[f32; 8]>,
}

impl LoadedImage {
    /// An image of which nothing else is known.
    pub fn of(image: Image) -> LoadedImage {
        LoadedImage {
            image,
            spp: None,
            runs: None,
            freedom: None,
            pool: None,
            light_paths: None,
            denoised: None,
            from_xyz: false,
            display: UVec2::ZERO,
            primaries: None,
        }
    }
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
    /// Windows that are absurdly large, or far from each other.
    #[error("{}: its data window and its display window span more pixels than there can be", .0.display())]
    Window(PathBuf),
}

/// Reads an EXR file: channels `R` `G` `B`, and `var.R` `var.G` `var.B` if present; without these `X` `Y` `Z`, converted to linear
/// sRGB, or those of a layer (`ViewLayer.Combined.R`), or gray (`Y`), whose variances may be called as it is (`var.Y`).
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
    let Windows {
        resolution,
        bounds,
        display,
    } = windows(layer, display).ok_or_else(|| ReadError::Window(path.to_owned()))?;
    let own = colors(layer, CHANNELS);
    let xyz = match own {
        Some(_) => None,
        None => colors(layer, XYZ),
    };
    let from_xyz = xyz.is_some();
    let (pixels, prefix, is_gray) = match (own, xyz) {
        (Some(own), _) => (own, String::new(), false),
        (None, Some(xyz)) => (
            xyz.into_iter().map(rgb_from_xyz).collect(),
            String::new(),
            false,
        ),
        (None, None) => other(path, layer)?,
    };
    // Those of this layer, before those of the file.
    let beside = |names: [&str; 3]| {
        let of_layer = || colors(layer, names.map(|name| format!("{prefix}{name}")));
        let gray = || {
            let name = names.first()?.trim_end_matches('R');
            colors(layer, [0; 3].map(|_| format!("{prefix}{name}Y")))
        };
        // Variances of other axes are not those of these.
        if from_xyz {
            return None;
        }
        of_layer()
            .or_else(|| gray().filter(|_| is_gray))
            .or_else(|| colors(layer, names))
    };
    let variance = beside(VARIANCES);
    let independent = variance.as_ref().and_then(|_| beside(INDEPENDENT));
    let chromaticities = file.attributes.chromaticities.filter(|_| !from_xyz);
    Ok(LoadedImage {
        image: Image {
            resolution,
            bounds,
            pixels,
            variance,
            independent,
            layers: Default::default(),
        },
        spp: number(&layer.attributes.other, "spp").filter(|&spp| spp > 0),
        runs: number(&layer.attributes.other, "runs"),
        freedom: real(&layer.attributes.other, "degreesOfFreedom"),
        pool: number(&layer.attributes.other, "variancePool").filter(|&side| side > 0),
        light_paths: light_paths(&layer.attributes.other),
        denoised: text(&layer.attributes.other, "denoised"),
        from_xyz,
        display,
        primaries: chromaticities.and_then(other_primaries),
    })
}

/// The image of a file without R, G, B and without X, Y, Z: its pixels, what stands before its channels' names, and whether it is gray.
fn other(path: &Path, layer: &FlatLayer) -> Result<(Vec<Rgb>, String, bool), ReadError> {
    let Ok(Chosen {
        prefix,
        channels: [Some(r), Some(g), Some(b)],
        is_gray,
    }) = choose_channels(&layer.channel_data)
    else {
        return Err(no_color(path, layer));
    };
    let [r, g, b] = [r, g, b].map(|channel| channel.values_as_f32());
    let pixels = r.zip(g).zip(b).map(|((r, g), b)| Rgb::new(r, g, b));
    let pixels: Vec<Rgb> = pixels.collect();
    match Some(pixels.len()) == layer.size.0.checked_mul(layer.size.1) {
        true => Ok((pixels, prefix, is_gray)),
        false => Err(no_color(path, layer)),
    }
}

/// Primaries and white of Rec. 709 (ITU-R BT.709-6 §1), which EXR files without the attribute have.
const REC_709: [f32; 8] = [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290];

/// These, if they are others than Rec. 709's to the three digits that files are written with.
fn other_primaries(found: Chromaticities) -> Option<[f32; 8]> {
    let Chromaticities {
        red,
        green,
        blue,
        white,
    } = found;
    let found = [
        red.0, red.1, green.0, green.1, blue.0, blue.1, white.0, white.1,
    ];
    let is_same = |(x, y): (&f32, &f32)| (x - y).abs() <= 1e-3;
    let are_same = found.iter().zip(&REC_709).all(is_same);
    (!are_same).then_some(found)
}

fn no_color(path: &Path, layer: &FlatLayer) -> ReadError {
    let channels = &layer.channel_data.list;
    let is_there = |name: &&str| {
        channels
            .iter()
            .any(|c| c.name.as_slice() == name.as_bytes())
    };
    let mut prefix = String::new();
    if let Ok(chosen) = choose_channels(&layer.channel_data) {
        prefix = chosen.prefix;
    }
    let names = CHANNELS.map(|name| format!("{prefix}{name}"));
    let names = names.iter().map(String::as_str);
    let found: Vec<&str> = names.filter(is_there).collect();
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

/// Where the pixels are.
struct Windows {
    /// Size of the display window.
    resolution: UVec2,
    /// The data window, relative to the smaller of both windows' corners.
    bounds: PixelBounds,
    /// The display window's corner, relative to the same.
    display: UVec2,
}

/// Both windows; `None` if they are too large.
fn windows(layer: &FlatLayer, display: ::exr::meta::attribute::IntegerBounds) -> Option<Windows> {
    let position = layer.attributes.layer_position;
    let (data, corner) = (position, display.position);
    let from_origin = |at: i32, other: i32| {
        let origin = i64::from(at.min(other));
        u32::try_from(i64::from(at) - origin).ok()
    };
    let min = UVec2::new(
        from_origin(data.0, corner.0)?,
        from_origin(data.1, corner.1)?,
    );
    let display_min = UVec2::new(
        from_origin(corner.0, data.0)?,
        from_origin(corner.1, data.1)?,
    );
    let size = UVec2::new(
        u32::try_from(layer.size.0).ok()?,
        u32::try_from(layer.size.1).ok()?,
    );
    let resolution = UVec2::new(
        u32::try_from(display.size.0).ok()?,
        u32::try_from(display.size.1).ok()?,
    );
    let end = |min: UVec2, size: UVec2| {
        let (x, y) = (min.x.checked_add(size.x)?, min.y.checked_add(size.y)?);
        Some(UVec2::new(x, y))
    };
    let max = end(min, size)?;
    end(display_min, resolution)?;
    Some(Windows {
        resolution,
        bounds: PixelBounds::new(min, max),
        display: display_min,
    })
}

/// Three channels as colors; `None` if one is missing or subsampled.
fn colors(layer: &FlatLayer, names: [impl AsRef<str>; 3]) -> Option<Vec<Rgb>> {
    let mut pixels = vec![Rgb::ZERO; layer.size.0.checked_mul(layer.size.1)?];
    for (i, name) in names.iter().enumerate() {
        let channel = layer
            .channel_data
            .list
            .iter()
            .find(|c| c.name.as_slice() == name.as_ref().as_bytes())?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use ::exr::image::{AnyChannel, Encoding, Image as File};
    use ::exr::meta::attribute::IntegerBounds;
    use ::exr::meta::header::{ImageAttributes, LayerAttributes};
    use ::exr::prelude::{Vec2, WritableImage};

    /// What is read of a file of 2 × 1 pixels, whose values are the first byte of the last part of their channel's name.
    fn of(channels: &[&str], corner: (i32, i32), display: ImageAttributes) -> LoadedImage {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.exr");
        let channel = |name: &&str| {
            let last = name.rsplit('.').next().unwrap();
            let value = f32::from(last.as_bytes()[0]);
            AnyChannel::new(*name, FlatSamples::F32(vec![value; 2]))
        };
        let channels = AnyChannels::sort(channels.iter().map(channel).collect());
        let mut attributes = LayerAttributes {
            layer_position: Vec2(corner.0, corner.1),
            ..LayerAttributes::default()
        };
        let spp = AttributeValue::I32(16);
        attributes.other.insert("spp".into(), spp);
        let layer = Layer::new((2, 1), attributes, Encoding::UNCOMPRESSED, channels);
        let file = File::from_layers(display, vec![layer]);
        file.write().to_file(&path).unwrap();
        read(&path).unwrap()
    }

    fn display(x: i32, y: i32, width: usize, height: usize) -> ImageAttributes {
        ImageAttributes::new(IntegerBounds::new((x, y), (width, height)))
    }

    /// Wherever the colors are, their window, variances and samples are not lost.
    #[test]
    fn layers_and_gray_keep_what_the_file_says() {
        let color = Rgb::new(82.0, 71.0, 66.0);
        let bounds = PixelBounds::new(UVec2::new(3, 1), UVec2::new(5, 2));
        let variances = ["var.R", "var.G", "var.B"];
        let combined = ["R", "G", "B"].map(|name| format!("ViewLayer.Combined.{name}"));
        let combined = combined.each_ref().map(String::as_str);
        let left = ["left.R", "left.G", "left.B"];
        let own = ["left.var.R", "left.var.G", "left.var.B"];
        for (channels, expected) in [
            ([combined, variances].concat(), color),
            ([left, variances].concat(), color),
            ([left, own].concat(), color),
            (vec!["Y", "var.Y"], Rgb::splat(89.0)),
        ] {
            let loaded = of(&channels, (3, 1), display(0, 0, 8, 4));
            assert_eq!((loaded.image.bounds, loaded.spp), (bounds, Some(16)));
            assert_eq!(loaded.image.pixels, [expected; 2], "{channels:?}");
            assert_eq!(loaded.image.variance, Some(vec![expected; 2]));
            assert_eq!(loaded.display, UVec2::ZERO);
        }
    }

    /// The smaller corner is the origin.
    #[test]
    fn data_windows_may_begin_before_the_display_window() {
        let rgb = ["R", "G", "B"];
        let loaded = of(&rgb, (-4, 7), display(-1, 5, 1, 3));
        let bounds = PixelBounds::new(UVec2::new(0, 2), UVec2::new(2, 3));
        assert_eq!(loaded.image.bounds, bounds);
        assert_eq!(loaded.image.resolution, UVec2::new(1, 3));
        assert_eq!(loaded.display, UVec2::new(3, 0));
    }

    #[test]
    fn primaries_are_told_where_they_are_others() {
        let with = |red: (f32, f32)| {
            let chromaticities = Some(Chromaticities {
                red: red.into(),
                green: (0.3, 0.6).into(),
                blue: (0.15, 0.06).into(),
                white: (0.3127, 0.329).into(),
            });
            let attributes = ImageAttributes {
                chromaticities,
                ..display(0, 0, 2, 1)
            };
            of(&["R", "G", "B"], (0, 0), attributes).primaries
        };
        assert_eq!(with((0.64, 0.33)), None);
        assert_eq!(with((0.708, 0.292)).map(|p| p[0]), Some(0.708));
    }
}
