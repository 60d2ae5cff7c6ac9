//! OpenEXR files: the data window of the part that holds the image, whatever its channels are named.

use super::image_data::{Encoding, ImageData, SizeLimit};
use crate::math::Rgb;
use exr::image::{AnyChannels, FlatSamples, Image, Layer};
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers};
use std::io::Cursor;

/// Decodes a whole file.
pub(super) fn read(bytes: &[u8], limit: SizeLimit) -> Result<ImageData, String> {
    check_sizes(bytes, limit)?;
    let layer = part(bytes)?.layer_data;
    let (width, height) = (layer.size.width(), layer.size.height());
    let [r, g, b] = choose_channels(&layer.channel_data)?.channels;
    let value =
        |channel: Option<&FlatSamples>, i| channel.map_or(0.0, |samples| sample(samples, i));
    let texels = (0..width * height)
        .map(|i| Rgb::new(value(r, i), value(g, i), value(b, i)))
        .collect();
    ImageData::from_texels(width, height, Encoding::Linear, texels)
        .ok_or_else(|| "it has no pixels".into())
}

/// The part of the file that holds the image: the first of those that are most like one.
pub(crate) fn part(bytes: &[u8]) -> Result<Image<Layer<AnyChannels<FlatSamples>>>, String> {
    let meta = meta_data(bytes)?;
    let chosen = chosen(&meta)?;
    check_channels(chosen)?;
    let best = Some(rank(chosen));
    let every = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels();
    OfRank { every, best }
        .first_valid_layer()
        .all_attributes()
        // The number of its threads would be out of our control.
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| said(&error))
}

/// Reads the channels of parts of one rank alone.
struct OfRank<C> {
    every: C,
    best: Option<u8>,
}

impl<'s, C: ReadChannels<'s>> ReadChannels<'s> for OfRank<C> {
    type Reader = C::Reader;

    fn create_channels_reader(&'s self, header: &Header) -> exr::error::Result<C::Reader> {
        match Some(rank(header)) == self.best {
            true => self.every.create_channels_reader(header),
            false => Err(exr::error::Error::Invalid("another part".into())),
        }
    }
}

/// The first of the parts that are most like an image.
fn chosen(meta: &MetaData) -> Result<&Header, String> {
    let best = meta.headers.iter().min_by_key(|header| rank(header));
    best.ok_or_else(|| "it has no layers".to_owned())
}

/// Names of a part's channels, in capitals.
fn capitals(header: &Header) -> Vec<String> {
    let names = header.channels.list.iter().map(|c| c.name.to_string());
    names.map(|name| name.to_ascii_uppercase()).collect()
}

/// Refuses what the decoder would refuse in words of its own, or take for something else.
fn check_channels(header: &Header) -> Result<(), String> {
    let names = capitals(header);
    if ["RY", "BY"]
        .iter()
        .all(|name| names.iter().any(|n| n == name))
    {
        return Err("it holds luminance and chroma (channels Y, RY and BY), which are not supported: convert it to R, G and B".into());
    }
    let channels = header.channels.list.iter();
    let coarse = { channels }.find(|c| c.sampling.width() != 1 || c.sampling.height() != 1);
    match coarse {
        Some(channel) => Err(format!(
            "its channel {} has fewer samples than the image has pixels, which is not supported",
            channel.name
        )),
        None => Ok(()),
    }
}

/// How little a part is like an image: 0 for one of colors, or gray, that is called as [`IMAGES`] are, or not at all. Normals
/// are stored as colors of a prefix, or as X, Y and Z; a lone Z is a depth.
fn rank(header: &Header) -> u8 {
    let names = capitals(header);
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let lasts: Vec<&str> = { names.iter() }
        .filter_map(|name| name.rsplit('.').next())
        .collect();
    let all = |of: &[&str], wanted: [&str; 3]| wanted.iter().all(|name| of.contains(name));
    let has = |name: &str| lasts.contains(&name);
    let is_gray = has("Y") && !(has("X") && has("Z"));
    let part = header.own_attributes.layer_name.as_ref();
    let is_named = part.is_none_or(|part| is_image(&part.to_string()));
    let rgb = ["R", "G", "B"];
    match () {
        () if header.deep => 7,
        () if is_named && (all(&lasts, rgb) || is_gray) => 0,
        () if all(&names, rgb) => 1,
        () if all(&lasts, rgb) => 2,
        () if is_gray => 3,
        () if lasts.len() == 1 && !has("Z") => 4,
        () if all(&lasts, ["X", "Y", "Z"]) => 5,
        () => 6,
    }
}

fn meta_data(bytes: &[u8]) -> Result<MetaData, String> {
    let read = MetaData::read_from_buffered(Cursor::new(bytes), false);
    read.map_err(|error| said(&error))
}

/// The decoder's message, but where it is of little help.
fn said(error: &exr::error::Error) -> String {
    let text = error.to_string();
    match text.contains("reference to missing bytes") {
        true => "the file is cut off or damaged: it refers to more than there is".to_owned(),
        false => text,
    }
}

/// Width and height of the image, and bytes of a texel with all its channels.
pub(super) fn extent(bytes: &[u8]) -> Result<([usize; 2], u64), String> {
    let meta = meta_data(bytes)?;
    let header = chosen(&meta)?;
    let size = [header.layer_size.width(), header.layer_size.height()];
    Ok((size, header.channels.bytes_per_pixel as u64))
}

/// Checks sizes first, because the decoder allocates whatever the header asks for.
pub(crate) fn check_sizes(bytes: &[u8], limit: SizeLimit) -> Result<(), String> {
    for header in &meta_data(bytes)?.headers {
        let size = header.layer_size;
        limit.check_channels(
            size.width(),
            size.height(),
            header.channels.list.len().max(3),
        )?;
    }
    Ok(())
}

/// Layers that hold the image beside those that say something of it, as other programs name them: `ViewLayer.Combined.R`, `beauty.R`.
const IMAGES: [&str; 6] = ["combined", "beauty", "rgba", "rgb", "color", "image"];

/// Returns `true` if the layer of this prefix, which ends with a dot, is called as [`IMAGES`] are.
fn is_image(prefix: &str) -> bool {
    let layer = prefix.trim_end_matches('.').rsplit('.').next();
    layer.is_some_and(|layer| IMAGES.iter().any(|image| image.eq_ignore_ascii_case(layer)))
}

/// What stands before the last part of channels' names, those of the image first, and those of variances (docs/compare.md) last.
fn prefixes(names: &[String]) -> Vec<&str> {
    let named = names
        .iter()
        .filter_map(|name| name.rfind('.').map(|dot| &name[..=dot]));
    let mut prefixes: Vec<&str> = std::iter::once("").chain(named).collect();
    // Stable: plain names stay first, and others in their order.
    prefixes.sort_by_key(|prefix| match prefix {
        _ if prefix.is_empty() || is_image(prefix) => 0,
        _ if prefix.ends_with("var.") || prefix.ends_with("independent.") => 2,
        _ => 1,
    });
    prefixes
}

/// The channels that hold an image.
pub(crate) struct Chosen<'a> {
    /// What stands before their names.
    pub prefix: String,
    /// Red, green and blue.
    pub channels: [Option<&'a FlatSamples>; 3],
    /// It is one channel three times.
    pub is_gray: bool,
}

/// The channels that hold red, green and blue (a missing one is 0): those called R, G and B; else
/// those of a layer that is called as [`IMAGES`] are, or the first layer's (`left.R` …); else Y, or the only channel, for all three.
pub(crate) fn choose_channels(channels: &AnyChannels<FlatSamples>) -> Result<Chosen<'_>, String> {
    let find = |name: &str| {
        channels
            .list
            .iter()
            .find(|c| c.name.eq_case_insensitive(name))
            .map(|c| &c.sample_data)
    };
    let names: Vec<String> = channels.list.iter().map(|c| c.name.to_string()).collect();
    for prefix in prefixes(&names) {
        let rgb = ["R", "G", "B"].map(|c| find(&format!("{prefix}{c}")));
        if rgb.iter().any(Option::is_some) {
            return Ok(Chosen {
                prefix: prefix.to_owned(),
                channels: rgb,
                is_gray: false,
            });
        }
        if let Some(y) = find(&format!("{prefix}Y")) {
            return Ok(Chosen {
                prefix: prefix.to_owned(),
                channels: [Some(y); 3],
                is_gray: true,
            });
        }
    }
    match channels.list.as_slice() {
        [only] if !only.name.eq_case_insensitive("Z") => Ok(Chosen {
            prefix: String::new(),
            channels: [Some(&only.sample_data); 3],
            is_gray: true,
        }),
        [_] => Err("its only channel is Z, a depth: it holds no image".into()),
        _ => Err(format!(
            "none of its channels ({}) is R, G, B or Y",
            names.join(", ")
        )),
    }
}

/// Sample `i` of a channel; 0 past its end.
fn sample(samples: &FlatSamples, i: usize) -> f32 {
    match samples {
        FlatSamples::F16(v) => v.get(i).map_or(0.0, |h| h.to_f32()),
        FlatSamples::F32(v) => v.get(i).copied().unwrap_or(0.0),
        FlatSamples::U32(v) => v.get(i).map_or(0.0, |&n| n as f32),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::image::{AnyChannel, Encoding, Layers};
    use exr::meta::header::{ImageAttributes, LayerAttributes};
    use exr::prelude::{IntegerBounds, WritableImage};

    /// A file of parts with channels, each with a value that is the first byte of its name.
    fn file(parts: &[(&str, &[&str])]) -> Vec<u8> {
        let channel = |name: &&str| {
            let value = f32::from(name.as_bytes()[0]);
            AnyChannel::new(*name, FlatSamples::F32(vec![value; 2]))
        };
        let layer = |(name, channels): &(&str, &[&str])| {
            let channels = AnyChannels::sort(channels.iter().map(channel).collect());
            let attributes = LayerAttributes::named(*name);
            Layer::new((2, 1), attributes, Encoding::UNCOMPRESSED, channels)
        };
        let layers: Layers<_> = parts.iter().map(layer).collect();
        let bounds = IntegerBounds::from_dimensions((2, 1));
        let mut bytes = Vec::new();
        Image::from_layers(ImageAttributes::new(bounds), layers)
            .write()
            .to_buffered(Cursor::new(&mut bytes))
            .expect("a file");
        bytes
    }

    /// The same with 2 × 2 pixels for each sample of some channels, which the encoder does not write.
    fn subsampled(mut bytes: Vec<u8>, channels: &[&str]) -> Vec<u8> {
        for channel in channels {
            let name = [channel.as_bytes(), &[0]].concat();
            let is_here = |at: &usize| bytes[*at..].starts_with(&name);
            let at = (1..bytes.len()).find(is_here).expect("the channel") + name.len();
            // After the type of its samples and how they are quantized.
            bytes[at + 8..at + 16].copy_from_slice(&[2, 0, 0, 0, 2, 0, 0, 0]);
        }
        bytes
    }

    fn error(bytes: &[u8]) -> String {
        read(bytes, SizeLimit::for_file(bytes.len())).expect_err("no image")
    }

    #[test]
    fn the_part_of_the_image_is_read() {
        let rgb = ["R", "G", "B"].as_slice();
        let (xyz, normals) = (["X", "Y", "Z"].as_slice(), ["N.R", "N.G", "N.B"].as_slice());
        let color = Rgb::new(82.0, 71.0, 66.0);
        let gray = |name: u8| Rgb::new(1.0, 1.0, 1.0) * f32::from(name);
        for (parts, expected) in [
            ([("depth", ["Z"].as_slice()), ("all", rgb)], color),
            ([("all", &["Z", "A"]), ("beauty", rgb)], color),
            ([("gray", &["Y"]), ("left", rgb)], color),
            (
                [
                    ("albedo", &["albedo.R", "albedo.G", "albedo.B"]),
                    ("main", rgb),
                ],
                color,
            ),
            ([("N", xyz), ("left", rgb)], color),
            ([("N", normals), ("beauty", &["Y"])], gray(b'Y')),
            ([("N", xyz), ("gray", &["Y", "A"])], gray(b'Y')),
            ([("N", xyz), ("height", &["L"])], gray(b'L')),
            ([("depth", &["Z"]), ("height", &["L"])], gray(b'L')),
        ] {
            let bytes = file(&parts);
            let image = read(&bytes, SizeLimit::for_file(bytes.len())).expect("an image");
            assert_eq!(image.pixel(1, 0), expected, "{parts:?}");
        }
    }

    #[test]
    fn what_is_no_image_is_said() {
        let of = |channels: &[&str]| file(&[("all", channels)]);
        assert!(error(&of(&["Z"])).contains("a depth"));
        let chroma = of(&["Y", "RY", "BY"]);
        assert!(error(&chroma).contains("luminance and chroma"));
        let whole = of(&["R", "G", "B"]);
        for end in [20, whole.len() - 4] {
            assert!(error(&whole[..end]).contains("cut off or damaged"), "{end}");
        }
    }

    #[test]
    fn subsampled_channels_are_named() {
        let of = |channels: &[&str]| file(&[("all", channels)]);
        let chroma = subsampled(of(&["Y", "RY", "BY"]), &["RY", "BY"]);
        assert!(error(&chroma).contains("luminance and chroma"));
        let other = subsampled(of(&["A", "Y"]), &["Y"]);
        assert!(error(&other).contains("its channel Y has fewer samples"));
    }

    /// As Blender and others name them.
    #[test]
    fn the_image_comes_before_other_layers() {
        let of = |names: &[&str]| {
            let names: Vec<String> = names.iter().map(|name| name.to_string()).collect();
            prefixes(&names).join(" ")
        };
        let blender = ["ViewLayer.Albedo.R", "ViewLayer.Combined.R"];
        assert_eq!(of(&blender), " ViewLayer.Combined. ViewLayer.Albedo.");
        assert_eq!(of(&["R", "albedo.R", "Beauty.R"]), " Beauty. albedo.");
        assert_eq!(of(&["left.R", "right.R"]), " left. right.");
        assert_eq!(of(&["var.R", "view.R"]), " view. var.");
    }
}
